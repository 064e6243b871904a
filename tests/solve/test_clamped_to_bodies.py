"""Lines that are clamped to bodies turn with them, and turn them."""

import numpy as np
import pytest
from engine_runs import STEEL, line_text, order_of, run_text, scene_of, study_of
from modal_runs import modes_of
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes, sensitivity_of
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve.targets import rest_of

LENGTH, MASS, EI, GRAVITY = 2.0, 0.5, 100.0, 9.81
BENDS = f"bending = {{ EI = {EI} }}"
DOWN = "{ held = { pretension = 3, direction = [0, 0, -1] } }"
LET_GO = '[events.tip]\nbreaks = "rod.end"\ntime = "5 ms"\n'


def tied(point, direction=(1, 0, 0)):
    return f'{{ tied = "{point}", direction = {list(direction)} }}'


def rod(start, end='"free"', segments=20, name="rod", more=""):
    line = line_text(name, "steel", LENGTH, segments, MASS, start, end, BENDS)
    return STEEL.format(more=more) + line


def beam(b):
    """cos - cosh, sin - sinh and sinh of b, of which y(L) of a beam is made, and three derivatives."""
    c, s, C, S = np.cos(b), np.sin(b), np.cosh(b), np.sinh(b)
    return np.array([
        [c - C, s - S, S], [-s - S, c - C, C], [-c - C, -s - S, S], [s - S, -c - C, C]
    ])  # fmt: skip


def test_a_beam_rocked_at_its_clamp_answers_as_a_beam_does(tmp_path):
    """y(0) = 0, slope a sin(w t), neither moment nor shear at L; b^4 = m w^2 L^4 / EI."""
    b, size = 1.4, 1e-3
    period = 2.0 * np.pi * (LENGTH / b) ** 2 * np.sqrt(MASS / EI)
    ship = (
        f"[bodies.ship]\nposition = [-1, 0, 0]\npoints.bow = [1, 0, 0]\n"
        f"motion.ramp = {6 * period}\n"
        f"motion.pitch = {{ amplitude = {size}, period = {period} }}\n"
        f"motion.heave = {{ amplitude = {size}, period = {period} }}\n"
    )
    output = f"output.duration={8 * period}", f"output.every={period / 8}"
    ran = run_text(tmp_path, rod(tied("ship.bow")) + ship, *output)
    assert ran.statuses == ["OK"]
    # pitch turns the bow down as far as heave lifts it: what is left is the turn
    np.testing.assert_allclose(ran["position"][0, :, 0, 2], 0.0, atol=1e-3 * size)
    ends = beam(b)
    outer = np.linalg.solve(ends[2:, :2], -ends[2:, 2])
    expected = -(ends[0, :2] @ outer + ends[0, 2]) * size * LENGTH / b
    last = slice(-8, None)
    turn = 2.0 * np.pi * ran.time[last] / period
    tip = ran["position"][0, last, -1, 2]
    assert np.mean(tip * np.sin(turn)) * 2.0 == pytest.approx(expected, rel=0.01)
    assert abs(np.mean(tip * np.cos(turn))) < 0.01 * abs(expected)
    assert ran.outcomes[0].energy_closure < 1e-3


def test_a_body_that_is_held_clamps_as_a_place_does(tmp_path):
    """Turned by 0.3 rad about y, [1, 0, 0] of its own is [cos 0.3, 0, -sin 0.3]."""
    way = [float(np.cos(0.3)), 0.0, float(-np.sin(0.3))]
    wall = f"{{ fixed = [0, 0, 0], direction = {way} }}"
    more = f"gravity = {GRAVITY}"
    alone = run_text(tmp_path, rod(wall, DOWN, more=more) + LET_GO)
    face = [float(-0.1 * way[0] - 0.2 * way[2]), 0.0, float(0.1 * way[2] - 0.2 * way[0])]
    block = (
        "[bodies.block]\nmass = 1\nposition = [0.1, 0, 0.2]\nattitude = [0, 0.3, 0]\nfree = []\n"
        f"points.face = {face}\n"
    )
    held = run_text(tmp_path, rod(tied("block.face"), DOWN, more=more) + block + LET_GO)
    assert held.statuses == alone.statuses == ["OK"]
    shift = held["position"][0, 0, 0] - alone["position"][0, 0, 0]
    moved = held["position"][0] - shift
    np.testing.assert_allclose(moved, alone["position"][0], atol=1e-9)
    assert np.ptp(alone["position"][0, :, -1, 2]) > 0.01


INERTIA, WEIGHT, ARM = 0.3, 2.0, 0.25
TIP = (
    f"[bodies.tip]\nsettle = true\nmass = {WEIGHT}\ninertia = [{INERTIA}, {INERTIA}, {INERTIA}]\n"
    f"position = [{LENGTH + ARM}, 0, 0]\npoints.face = [{-ARM}, 0, 0]\n"
)
WALL = "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"


@pytest.mark.slow
def test_a_beam_with_a_body_at_its_tip_swings_as_one(tmp_path):
    """Its end pulls the body with EI d3y/dx3 and turns it back with EI d2y/dx2; b as above."""

    def balance(b):
        square, step = EI / MASS * (b / LENGTH) ** 4, LENGTH / b
        y, h, m, v = (row[:2] / step**k for k, row in enumerate(beam(b)))
        shear = EI * v + square * WEIGHT * (y + ARM * h)
        turn = square * INERTIA * h - EI * (m + ARM * v)
        return np.linalg.det(np.stack([shear, turn]))

    grid = np.linspace(0.2, 6.0, 300)
    signs = np.sign([balance(b) for b in grid])
    roots = [brentq(balance, *grid[k : k + 2]) for k in np.flatnonzero(signs[1:] != signs[:-1])][:3]
    exact = (np.array(roots) / LENGTH) ** 2 * np.sqrt(EI / MASS) / (2.0 * np.pi)
    errors = []
    for segments in (20, 40):
        text = rod(WALL, tied("tip.face"), segments, more="dimensions = 2") + TIP
        found = modes_of(tmp_path, text, count=3)
        errors.append(np.abs(found.frequency / exact - 1.0))
    assert errors[1].max() < 5e-3
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.1)


HUB_MASS, HUB_INERTIA = 3.0, [0.04, 0.05, 0.06]
HUB = (
    f"[bodies.hub]\nmass = {HUB_MASS}\ninertia = {HUB_INERTIA}\nposition = [0, 0, 0]\n"
    "points.right = [0.1, 0, 0]\npoints.left = [-0.1, 0.05, 0]\n"
)


@pytest.mark.parametrize("way", [[0, 1, 0], pytest.param([0, 0.6, 0.8], marks=pytest.mark.slow)])
def test_two_arms_and_a_hub_keep_their_momenta(tmp_path, way):
    """Bent arms are let go at once: nothing acts from outside, so that no momentum ever is."""
    held = f"{{ held = {{ pretension = 20, direction = {way} }} }}"
    text = rod(tied("hub.right"), held) + HUB
    text += line_text("arm", "steel", 1.5, 12, MASS, '"free"', tied("hub.left"), BENDS)
    text += '[events.tip]\nbreaks = "rod.end"\ntime = 0\n'
    ran = run_text(tmp_path, text, "output.duration=0.6", "output.every=0.02")
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-4
    assert ran.energy["bending"][0, 0] > 10.0 * ran.energy["bending"][0, 10:].min()
    momentum, spin, parts = np.zeros((31, 3)), np.zeros((31, 3)), 0.0
    for name, length, segments in (("rod", LENGTH, 20), ("arm", 1.5, 12)):
        share = np.full(segments + 1, MASS * length / segments)
        share[[0, -1]] *= 0.5
        x, v = ran[f"{name}.position"][0], ran[f"{name}.velocity"][0]
        momentum += np.einsum("n,tnc->tc", share, v)
        own = np.einsum("n,tnc->tc", share, np.cross(x, v))
        spin += own
        parts = max(parts, np.abs(own).max())
    assert parts > 1.0
    place, speed, angles, rates = (
        ran.bodies["hub"][key][0] for key in ("position", "velocity", "attitude", "turning")
    )
    momentum += HUB_MASS * speed
    (roll, pitch, _), (p, q, r) = angles.T, rates.T
    about = [
        p - r * np.sin(pitch),
        q * np.cos(roll) + r * np.sin(roll) * np.cos(pitch),
        r * np.cos(roll) * np.cos(pitch) - q * np.sin(roll),
    ]
    own = HUB_INERTIA * np.stack(about, axis=1)  # in its own axes
    spin += HUB_MASS * np.cross(place, speed) + Rotation.from_euler("xyz", angles).apply(own)
    assert np.abs(momentum).max() < 1e-6
    assert np.abs(spin).max() < 1e-5 * parts


@pytest.mark.slow
def test_a_beam_bears_a_body_at_its_tip(tmp_path):
    """P = M g at an arm a turns the tip by P L (L / 2 + a) / EI and lowers it; so does the beam's w."""
    stiff = "lines.rod.bending.EI=2e4"
    force, weight = WEIGHT * GRAVITY, MASS * GRAVITY
    turn = LENGTH * (force * (0.5 * LENGTH + ARM) + weight * LENGTH**2 / 6.0) / 2e4
    low = LENGTH**2 * (force * (LENGTH / 3.0 + ARM / 2.0) + weight * LENGTH**2 / 8.0) / 2e4
    errors = []
    for segments in (10, 20, 40):
        text = rod(WALL, tied("tip.face"), segments, more=f"gravity = {GRAVITY}") + TIP
        scene = scene_of(tmp_path, text, stiff)
        found = rest_of(scene, make_layout(scene), coordinates_of([scene])).model
        tip = np.asarray(found.lines["rod"].reference)[:, -1]
        angle = np.asarray(found.bodies["tip"].reference)[2]
        errors.append([abs(-tip[1] / low - 1.0), abs(angle / turn - 1.0)])
    assert np.max(errors[-1]) < 1e-3
    assert np.all(order_of(errors, (2.0, 2.0))[0] > 1.9)


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.slow
def test_what_a_clamp_on_a_body_tells_has_derivatives(tmp_path, back):
    """Of where the tip swings once its weight is let go, by differences; the body settles first."""
    keys = ("lines.rod.bending.EI", "bodies.tip.mass", "bodies.tip.points.face.0")
    text = rod(WALL, tied("tip.face", (1, 0, 0.1)), 6, more=f"gravity = {GRAVITY}") + TIP
    text += line_text("hook", "steel", 1.0, 2, 2.0, '"tip"', '"free"')
    text += '[events.drop]\nbreaks = "hook.start"\ntime = "5 ms"\n'
    study = study_of(tmp_path, text)
    scalar = read_scalar("last position at rod.end in z", study.runs[0])
    values = np.array([study.runs[0].numbers()[key] for key in keys])
    found = sensitivity_of(study, scalar, reverse=back)
    slopes = dict(zip(found.keys, map(float, found.slopes), strict=True))
    for k, step in enumerate((0.05, 1e-3, 1e-4)):
        more, less = (
            scalar_slopes(study, scalar, keys, values + s * step * np.eye(3)[k])[0] for s in (1, -1)
        )
        assert slopes[keys[k]] == pytest.approx((more - less) / (2.0 * step), rel=1e-4)


PULL = "schedule = { time = [0, 0.2, 1, 1.2], speed = [0, -1.2, -1.2, 0] }"
DRUM = f"{{ drum = {{ at = [2, 0, 0], {PULL} }} }}"
WINCH = "{ winch = { at = [2, 0, 0], tension = 5, inertia = 0.2 } }"


@pytest.mark.parametrize(("end", "status"), [(DRUM, "OK"), (WINCH, "STEP_BOUND_BROKEN")])
@pytest.mark.slow
def test_the_step_knows_of_what_is_hauled_in(tmp_path, end, status):
    """The shorter its segments, the stiffer is a clamp: known of a drum, seen of a winch."""
    hub = "[bodies.hub]\nmass = 1\ninertia = [1e-6, 1e-6, 1e-6]\n"
    hub += 'position = [0, 0, 0]\nfree = ["x", "pitch"]\n'
    text = rod(tied("hub", (1, 0, 0.02)), end, 10, more="dimensions = 2") + hub
    output = "output.duration=1.2", "output.every=0.05", "solver.courant=0.9"
    ran = run_text(tmp_path, text, *output, "materials.steel.EA=1e4")
    assert ran.statuses == [status]
    if status == "OK":
        assert np.abs(ran.bodies["hub"]["attitude"]).max() < 0.1
