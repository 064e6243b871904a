"""Bodies that a bed bears: dropped, tipped, sliding, between lines, each against its own equations."""

import numpy as np
import pytest
from command_line import say
from engine_runs import fixed, line_text, run_text
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G, MASS, BEARING, BED = 9.81, 500.0, 500e3, -3.0
SIZE = (1.6, 2.0, 0.8)
BLEND = 0.2 * MASS * 9.80665 / BEARING  # m, over which contact takes hold: as of lines
AWAY = line_text("rope", "wire", 1, 2, 10, fixed(9, 0, 9), '"free"')  # a scene has a line
BOX = (
    f"gravity = {G}\n"
    f'[seabed]\nheight = {BED}\nstiffness = "100 kPa"\nMORE\n'
    '[materials.wire]\nlaw = "linear"\nEA = "100 kN"\n'
    f"[bodies.box]\nmass = {MASS}\nsize = {list(SIZE)}\nbearing = {BEARING}\nBODY\n"
    + AWAY
    + '[output]\nduration = "TIME"\nevery = "10 ms"\nquantities = ["position", "velocity", "energy"]\n'
)


def box(body, time="1 s", more=""):
    return BOX.replace("BODY", body).replace("TIME", time).replace("MORE", more)


def sink(p):
    """s(p) of the docstring of the bed (m)."""
    q = np.clip(p, 0.0, BLEND)
    return q**2 / (2.0 * BLEND) + np.maximum(p - q, 0.0)


def stored(p):
    """Its integral (m2)."""
    q = np.clip(p, 0.0, BLEND)
    return q**3 / (6.0 * BLEND) + 0.5 * np.maximum(p - q, 0.0) * p


def tumbling(start, times, damping=0.0):
    """x, z, pitch of the box in its plane by its own equations: edges with half the bed's spring."""
    long, high = 0.5 * SIZE[0], 0.5 * SIZE[2]
    inertia = MASS / 12.0 * (SIZE[0] ** 2 + SIZE[2] ** 2)
    corners = np.array([[-long, -high], [long, -high], [-long, high], [long, high]])

    def slope(_, y):
        _, z, angle, u, w, spin = y
        c, s = np.cos(angle), np.sin(angle)
        # pitch turns z towards x
        arm_x, arm_z = c * corners[:, 0] + s * corners[:, 1], c * corners[:, 1] - s * corners[:, 0]
        depth = BED - (z + arm_z)
        push = 0.5 * BEARING * sink(depth)
        rising = w - spin * arm_x
        contact = np.clip(depth / BLEND, 0.0, 1.0)
        push += np.maximum(-0.5 * damping * contact * rising, -push)
        return [u, w, spin, 0.0, push.sum() / MASS - G, -(push * arm_x).sum() / inertia]

    found = solve_ivp(
        slope, (0, times[-1]), [*start, 0, 0, 0], "DOP853", times, rtol=1e-10, atol=1e-12,
        max_step=1e-3,
    )  # fmt: skip
    return found.y[:3].T


def motion(ran):
    """x, z and pitch over time."""
    mine = ran.bodies["box"]
    return np.stack(
        [mine["position"][0, :, 0], mine["position"][0, :, 2], mine["attitude"][0, :, 1]], axis=1
    )


@pytest.mark.parametrize("damping", [pytest.param(0.0, marks=pytest.mark.slow), 2e3])
@pytest.mark.slow
def test_a_box_that_falls_on_an_edge_tumbles_as_its_equations_say(tmp_path, damping):
    more = f"damping = {damping}" if damping else ""
    text = box("position = [0, 0, -1]\nattitude = [0, 0.3, 0]", "1 s", more)
    ran = run_text(tmp_path, text + "[solver]\nwaves = 'plain'\nstep = 2e-4\n")
    assert ran.statuses == ["OK"]
    # the damping of the bed goes with its stiffness: c / k of the one is c / k of the other
    exact = tumbling([0.0, -1.0, 0.3], ran.time, damping * BEARING / 100e3)
    assert np.ptp(exact[:, 2]) > 0.2  # it turns
    assert motion(ran) == pytest.approx(exact, abs=2e-3)
    assert np.abs(ran.energy["residual"]).max() < 2e-3 * ran.energy["kinetic"].max()


@pytest.mark.slow
def test_it_falls_as_deep_as_its_energy_goes_and_leaves_at_its_speed(tmp_path):
    ran = run_text(tmp_path, box("position = [0, 0, 0]", "1.2 s"))
    deepest = brentq(
        lambda p: MASS * G * (-BED - 0.5 * SIZE[2] + p) - BEARING * stored(p), BLEND, 1.0
    )
    z = motion(ran)[:, 1]
    assert z.min() == pytest.approx(BED + 0.5 * SIZE[2] - deepest, abs=0.01)  # seen each 10 ms
    fall = np.sqrt(2.0 * G * (-BED - 0.5 * SIZE[2]))
    assert ran.bodies["box"]["velocity"][0, :, 2].max() == pytest.approx(fall, rel=0.02)


@pytest.mark.parametrize(("tilt", "ends"), [(0.9, 0.0), (1.3, 0.5 * np.pi)])
def test_one_that_is_tipped_beyond_its_edge_falls_over(tmp_path, tilt, ends):
    """Its centre is over the edge at a pitch of atan(1.6 / 0.8) = 1.107."""
    half = 0.5 * (SIZE[0] * np.sin(tilt) + SIZE[2] * np.cos(tilt))
    text = box(
        f"position = [0, 0, {BED + half}]\nattitude = [0, {tilt}, 0]", "6 s", "damping = '10 kPa s'"
    )
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    assert motion(ran)[-1, 2] == pytest.approx(ends, abs=0.01)


@pytest.mark.parametrize("dimensions", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_friction_stops_it_where_it_does_what_its_motion_had(tmp_path, dimensions):
    """v^2 / (2 mu g), as of one whose height is held; its start a little over its place of rest."""
    speed, mu = 3.0, 0.4
    way = np.array([0.6, 0.8] if dimensions == 3 else [1.0, 0.0])
    rest = BED + 0.5 * SIZE[2] - MASS * G / BEARING - 0.5 * BLEND
    text = box(
        f"position = [0, 0, {rest}]\nvelocity = [{speed * way[0]}, {speed * way[1]}, 0]\n"
        f'friction = {mu}\nfree = ["x", "y", "z"]',
        "1.5 s",
    )
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    place, velocity = (ran.bodies["box"][key][0] for key in ("position", "velocity"))
    assert place[-1, :2] == pytest.approx(way * speed**2 / (2.0 * mu * G), rel=1e-3, abs=1e-12)
    assert np.all(velocity[-10:, :2] == 0.0)
    work = ran.energy["lost_friction"][0]
    assert work[-1] == pytest.approx(0.5 * MASS * speed**2, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("segments", [10, 80])
def test_a_clump_between_two_lines_lies_as_deep_on_any_mesh(tmp_path, segments):
    """A body without a size stands on the bed with its centre, 10 mm in it.

    Its lines alone would bear it 96 mm deep with 10 segments, and 766 mm with 80.
    """
    text = (
        f'gravity = {G}\n[seabed]\nheight = -10\nstiffness = "100 kPa"\n'
        '[materials.chain]\nlaw = "linear"\nEA = "100 MN"\n'
        '[bodies.clump]\nmass = 2000\nposition = [0, 0, -10]\nfree = ["x", "y", "z"]\nsettle = true\n'
        'bearing = "2 MN/m"\n'
        + line_text("ground", "chain", 20, segments, 10, fixed(-20, 0, -10), '"clump"')
        + line_text("riser", "chain", 21, segments, 10, '"clump"', fixed(17, 0, 0))
        + '[output]\nduration = "0.2 s"\nevery = "50 ms"\n'
    )
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    z = ran.bodies["clump"]["position"][0, :, 2]
    assert np.ptp(z) < 1e-6  # it is at rest
    # half a segment of each line lies on the bed beside it: its weight, and what the bed bears it with
    beside = 0.5 * (20 + 21) / segments
    blend = 0.2 * 2000 * 9.80665 / 2e6
    weight = (2000 + 10 * beside) * G
    depth = (weight + 2e6 * 0.5 * blend) / (2e6 + 100e3 * beside)
    assert -10.0 - z[0] == pytest.approx(depth, rel=5e-3)


@pytest.mark.slow
def test_one_that_sinks_through_a_bed_that_does_not_bear_it_is_told(tmp_path):
    (tmp_path / "scene.toml").write_text(
        box("position = [0, 0, -1]").replace(f"bearing = {BEARING}", "")
    )
    said = say(tmp_path, "run", "scene.toml", "-o", "r.h5")
    deep = 0.5 * G * 1.0**2 - 2.0
    assert said.code == 0
    words = " ".join(said.out.split())
    assert f"box ends {deep:.2g} m under the bed" in words
    assert "give bodies.box.bearing" in words


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '[seabed]\nheight = -3.0\nstiffness = "100 kPa"\nMORE\n',
            "",
            "bearing: expected [seabed]",
        ),
        ("position = ", "free = ['x']\nposition = ", "expected a body that can rise"),
        ("0, 0, 0]", "0, 0, -2.7]", "position.2: expected its deepest corner on the bed, at -3 m"),
        ("bearing = 500000.0", "friction = 0.3", "expected a body with bearing, or one on the bed"),
    ],
)
def test_what_cannot_be_is_told(tmp_path, old, new, words):
    text = BOX.replace("BODY", "position = [0, 0, 0]").replace("TIME", "1 s")
    assert old in text
    (tmp_path / "scene.toml").write_text(text.replace(old, new).replace("MORE\n", ""))
    said = say(tmp_path, "check", "scene.toml")
    assert said.code == 2
    assert words in said.err


SLOPE = "profile = { x = [-50, 50], depth = [-15, 15] }"  # 0.3, down to larger x


def test_a_box_that_lies_flush_on_a_slope_is_as_good_as_one_on_a_flat_bed(tmp_path):
    height, angle = BED + 0.5 * SIZE[2] / np.cos(np.arctan(0.3)), np.arctan(0.3)
    lying = f"position = [0, 0, {height - 1e-3}]\nattitude = [0, {angle}, 0]"
    (tmp_path / "scene.toml").write_text(box(lying, more=SLOPE))
    assert say(tmp_path, "check", "scene.toml").code == 0
    # level, its uphill edge is 0.3 m deep
    level = f"position = [0, 0, {BED + 0.5 * SIZE[2]}]"
    (tmp_path / "scene.toml").write_text(box(level, more=SLOPE))
    said = say(tmp_path, "check", "scene.toml")
    assert said.code == 2
    deep = 0.3 * 0.5 * SIZE[0]
    assert f"change position to {BED + 0.5 * SIZE[2] + deep:g} m" in " ".join(said.err.split())


@pytest.mark.slow
def test_the_step_is_short_enough_for_a_steep_bed(tmp_path):
    # let fall by 0.1 m on 45 degrees it comes back to where it was, along the slope's mirror
    steep = "profile = { x = [-500, 500], depth = [-500, 500] }"
    text = box(f'position = [0, 0, {BED + 0.1}]\nfree = ["x", "z"]', "2 s", more=steep)
    text = text.replace(f"size = {list(SIZE)}\n", "")
    text = text.replace(AWAY, line_text("rope", "wire", 1, 1, 1000, fixed(9, 0, 1019), '"free"'))
    ran = run_text(tmp_path, text, 'output.every="0.1 s"')
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 0.02
    # over the bed, where it is: hardly higher than it fell from, as far as so coarse a step may have it
    place = ran.bodies["box"]["position"][0]
    assert np.max(place[:, 2] + place[:, 0] - BED) < 0.15
