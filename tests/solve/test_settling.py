"""Rigid bodies that start at rest: where statics puts them, and that they stay there."""

import jax
import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text, scene_of, study_of
from scipy.optimize import root

from lumpedcable import response
from lumpedcable.scene import SceneError
from lumpedcable.study.rest_report import rest_table
from lumpedcable.study.run import run_study

G, RHO = 10.0, 1000.0
WIRE = """
[materials.wire]
law = "linear"
EA = "1 MN"
tension_only = true
"""


def output(duration="1 s", every="0.1 s"):
    return f'[output]\nduration = "{duration}"\nevery = "{every}"\n'


def start_of_body(ran, name="box"):
    return ran.bodies[name]["position"][0, 0], ran.bodies[name]["attitude"][0, 0]


def stays(ran, name="box", rtol=1e-8):
    """Whether a body is where it was at the start, in its first run."""
    place = ran.bodies[name]["position"][0]
    assert np.abs(place - place[0]).max() < rtol * 10.0
    turn = ran.bodies[name]["attitude"][0]
    assert np.abs(turn - turn[0]).max() < rtol
    return True


# on a line: EA/L (x - L) on the left, EA/L (D - x - L) on the right, and a thrust F
SPRINGS = (
    WIRE
    + """
[bodies.box]
mass = 500
position = [9.7, 0, 0]
free = ["x"]
control = { force = ["3 kN", 0, 0] }
settle = true
"""
    + line_text("left", "wire", 10, 3, 0.1, fixed(0, 0, 0), '"box"')
    + line_text("right", "wire", 10, 3, 0.1, fixed(21, 0, 0), '"box"')
)


class TestExactPlaces:
    @pytest.mark.slow
    def test_between_two_springs(self, tmp_path):
        # on a line: EA/L (x - L) on the left, EA/L (D - x - L) on the right, and a thrust F
        length, apart, thrust = 10.0, 21.0, 3e3
        text = (
            WIRE + f"[bodies.box]\nmass = 500\nposition = [9.7, 0, 0]\nsettle = true\n"
            f'free = ["x"]\n'
            f"control = {{ force = [{thrust}, 0, 0] }}\n"
            + line_text("left", "wire", length, 3, 0.1, fixed(0, 0, 0), '"box"')
            + line_text("right", "wire", length, 3, 0.1, fixed(apart, 0, 0), '"box"')
        )
        ran = run_text(tmp_path, text + output())
        spring = 1e6 / length
        exact = 0.5 * apart + 0.5 * thrust / spring
        assert start_of_body(ran)[0][0] == pytest.approx(exact, rel=1e-10)
        assert ran["left.end_tension"][0, 0] == pytest.approx(spring * (exact - 10.0), rel=1e-9)
        assert stays(ran)

    @pytest.mark.slow
    def test_its_derivative(self, tmp_path):
        # a push of 1 N more moves it by half the give of one spring
        (tmp_path / "scene.toml").write_text(SPRINGS + output("0.1 s", "10 ms"))
        by = ["bodies.box.control.force.0"]
        place = response(tmp_path / "scene.toml", by=by, of="first position at left.end in x")
        value, slope = jax.value_and_grad(place)(place.values)
        assert value == pytest.approx(10.5 + 3e3 / 2e5, rel=1e-10)
        assert slope[0] == pytest.approx(1.0 / 2e5, rel=1e-9)

    @pytest.mark.slow
    def test_hangs_with_its_weight_under_the_line(self, tmp_path):
        # from a point off its centre of gravity, which comes to be straight below it
        off, up, length, mass, metre = 0.3, 0.4, 5.0, 200.0, 2.0
        text = (
            f"gravity = {G}\n"
            + WIRE
            + f"[bodies.box]\nmass = {mass}\nsize = [1, 1, 1]\nposition = [0.5, 0, -5]\n"
            f"points = {{ eye = [{off}, 0, {up}] }}\nsettle = true\n"
            + line_text("hoist", "wire", length, 5, metre, fixed(0, 0, 0), '"box.eye"')
        )
        ran = run_text(tmp_path, text + output())
        place, turn = start_of_body(ran)
        # each segment carries the body and the line below its middle
        below = metre * length * (np.arange(5) + 0.5) / 5
        stretch = np.sum(1.0 * (mass + below) * G / 1e6)
        deep = length + stretch + np.hypot(off, up)
        np.testing.assert_allclose(place, [0.0, 0.0, -deep], atol=1e-7)
        # positive pitch puts +x down: the eye (off, up) is turned to (0, |eye|)
        assert turn[1] == pytest.approx(-np.arctan2(off, up), abs=1e-8)
        assert stays(ran, rtol=1e-6)

    @pytest.mark.slow
    def test_floats_deeper_by_what_pulls_it_down(self, tmp_path):
        # a tether from the bed: rho g A s = EA (h - s - L) / L, s the sinkage, h without tether
        length, breadth, height, mass = 6.0, 4.0, 3.0, 24e3
        draught = mass / (RHO * length * breadth)
        above = 19.0 + 0.5 * height - draught + 0.2  # of its centre over the bed where it floats
        tether = above - 0.5 * height - 0.1
        text = (
            f"gravity = {G}\n[water]\ndensity = {RHO}\n"
            + WIRE
            + f"[bodies.box]\nmass = {mass}\nsize = [{length}, {breadth}, {height}]\n"
            'position = [0, 0, 0]\npoints = { keel = [0, 0, -1.5] }\nhull = {}\nfree = ["z"]\n'
            "settle = true\n"
            + line_text("tether", "wire", tether, 1, 1e-3, fixed(0, 0, -19.2), '"box.keel"',
                        'diameter = "1 mm"')
        )  # fmt: skip
        ran = run_text(tmp_path, text + output("0.1 s", "10 ms"))
        floats = 0.5 * height - draught  # height of its centre
        stiff, spring = RHO * G * length * breadth, 1e6 / tether
        far = floats - 1.5 + 19.2 - tether  # by which the tether would be stretched there
        sinkage = spring * far / (stiff + spring)
        assert start_of_body(ran)[0][2] == pytest.approx(floats - sinkage, abs=1e-6)
        assert ran["tether.start_tension"][0, 0] == pytest.approx(stiff * sinkage, rel=1e-4)

    @pytest.mark.slow
    def test_does_not_move_along_what_is_held(self, tmp_path):
        text = (
            WIRE
            + '[bodies.box]\nmass = 500\nsize = [1, 1, 1]\nposition = [9, 1, 0]\nfree = ["x"]\n'
            "settle = true\n"
            + line_text("left", "wire", 10, 2, 0.1, fixed(0, 0, 0), '"box"')
            + line_text("right", "wire", 10, 2, 0.1, fixed(22, 0, 0), '"box"')
        )
        ran = run_text(tmp_path, text + output("0.1 s", "10 ms"))
        np.testing.assert_allclose(start_of_body(ran)[0], [11.0, 1.0, 0.0], atol=1e-9)


# a barge on two heavy chains that lie on the bed, pushed to one side, its first guess metres off
MOORED = f"""
gravity = {G}
[water]
density = {RHO}
[seabed]
height = -20
stiffness = "20 kPa"
damping = "2 kPa s"
[materials.chain]
law = "linear"
EA = "100 MN"
tension_only = true
[bodies.box]
mass = "300 t"
size = [20, 8, 4]
position = [1, 0, 0.2]
points = {{ bow = [10, 0, -1], stern = [-10, 0, -1] }}
hull = {{}}
control = {{ force = ["40 kN", 0, 0] }}
settle = true
""" + "".join(
    line_text(name, "chain", 90, 18, 60, fixed(x, 0, -20), f'"box.{point}"', 'diameter = "0.1 m"')
    for name, x, point in (("ahead", 95, "bow"), ("astern", -95, "stern"))
)


class TestAMooredBarge:
    @pytest.mark.slow
    def test_carries_its_thrust_and_its_chains_and_stays(self, tmp_path):
        sweep = '[sweep]\n"bodies.box.control.force.0" = ["40 kN", "0 N"]\n'
        ran = run_text(tmp_path, MOORED + output("5 s") + sweep)
        assert [own.status.name for own in ran.outcomes] == ["OK", "OK"]
        assert stays(ran, rtol=1e-7)
        # of the end segments' pulls the parts along x balance the thrust
        for run, thrust in enumerate((40e3, 0.0)):
            pull = 0.0
            for line in ("ahead", "astern"):
                ends = ran[f"{line}.position"][run, 0, -2:]
                step = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
                pull += ran[f"{line}.tension"][run, 0, -1] * step[0]
            assert pull == pytest.approx(thrust, abs=1.0)
        # without thrust it is in the middle, and lower than it floats alone, by what hangs on it
        place, turn = ran.bodies["box"]["position"][1, 0], ran.bodies["box"]["attitude"][1, 0]
        assert abs(place[0]) < 1e-6
        assert abs(turn[1]) < 1e-9
        assert -0.1 < place[2] - (2.0 - 300e3 / (RHO * 160.0)) < -0.01

    @pytest.mark.slow
    def test_at_rest_alone_the_table_tells_where_it_is(self, tmp_path, capsys):
        study = study_of(tmp_path, SPRINGS + "[output]\n")
        run_study(study, tmp_path / "rest.h5")
        rest_table(study, tmp_path / "rest.h5")
        told = capsys.readouterr().out.split("box\n")[1].split("\n")
        assert told[1].split()[:3] == ["x", "y", "z"]
        assert any(line.split()[:2] == ["0", "10.5150"] for line in told)


class TestRefused:
    def test_with_the_reason(self, tmp_path):
        text = (
            f"gravity = {G}\n[seabed]\nheight = -1\nstiffness = 1e5\n"
            + WIRE
            + "[bodies.box]\nmass = 500\nposition = [11, 0, 0]\nsettle = true\n"
            + 'free = ["x"]\nfriction = 0.3\n'
            + line_text("left", "wire", 10, 2, 0.1, fixed(0, 0, 0), '"box"')
        )
        with pytest.raises(SceneError, match="expected a body without friction"):
            scene_of(tmp_path, text + output())

    def test_rods(self, tmp_path):
        text = (
            '[materials.stiff]\nlaw = "inextensible"\n'
            "[bodies.box]\nmass = 500\nposition = [11, 0, 0]\nsettle = true\n"
            + line_text("left", "stiff", 11, 2, 0.1, fixed(0, 0, 0), '"box"')
            + '[solver]\nstep = "1 ms"\n'
        )
        with pytest.raises(SceneError, match='found the inextensible "left", where a body settles'):
            scene_of(tmp_path, text + output())


HUNG = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "100 kN"
[bodies.box]
mass = 500
size = [2.0, 1.0, 0.5]
points = { eye = [0, 0, 0.25] }
position = [0, 0, 0.6]
attitude = [0, ANGLE, 0]
settle = true
""" + line_text("rope", "wire", 3, 4, 0.01, fixed(0, 0, 4), '"box.eye"')  # fmt: skip


@pytest.mark.parametrize("angle", [2.0, np.pi])
@pytest.mark.slow
def test_a_body_that_hangs_does_not_stand_on_its_head(tmp_path, angle):
    ran = run_text(tmp_path, HUNG.replace("ANGLE", str(angle)) + "[output]")
    assert ran.statuses == ["OK"]
    place, turn = start_of_body(ran)
    np.testing.assert_allclose(np.cos(turn), 1.0, atol=1e-12)
    weight = (500 + 0.01 * 3.0) * 9.81
    low = 4.0 - 3.0 * (1.0 + weight / 1e5) - 0.25
    assert place[2] == pytest.approx(low, abs=1e-5)


LAID = """
gravity = 9.81
[seabed]
height = 0
stiffness = "100 kPa"
damping = "5 kPa s"
[materials.wire]
law = "linear"
EA = "100 kN"
[bodies.box]
mass = 500
size = [2.0, 1.0, 0.5]
bearing = 500e3
position = [0, 0, HEIGHT]
attitude = ATTITUDE
settle = true
"""
SLACK = line_text("rope", "wire", 8, 16, 5, fixed(6, 0, 3), '"box"')
LOOSE = line_text("rope", "wire", 8, 16, 5, fixed(6, 0, 3), '"free"')


def laid(height, attitude, line, out="[output]"):
    return LAID.replace("HEIGHT", str(height)).replace("ATTITUDE", str(attitude)) + line + out


@pytest.mark.parametrize(
    ("height", "attitude", "line"),
    [
        (0.6, [0, 0.1, 0], SLACK),  # by a step that is downhill no more, onto its edge: 1.326 rad
        (0.6, [0, -0.3, 0], SLACK),
        # nothing holds its yaw, nor where it is
        (0.4, [0.1, 0.05, 0], LOOSE),
        (0.26, [0.01, 0.005, 0], LOOSE),
    ],
)
@pytest.mark.slow
def test_a_box_on_a_bed_lies_flat(tmp_path, height, attitude, line):
    ran = run_text(tmp_path, laid(height, attitude, line, output("0.5 s")))
    assert ran.statuses == ["OK"]
    place, turn = start_of_body(ran)
    np.testing.assert_allclose(turn[:2], 0.0, atol=1e-6)
    assert stays(ran, rtol=1e-7)
    if line == LOOSE:  # k (p - b / 2) = m g, b the depth over which contact takes hold
        depth = 500 * 9.81 / 500e3 + 0.1 * 500 * 9.80665 / 500e3
        assert place[2] == pytest.approx(0.25 - depth, abs=1e-9)


@pytest.mark.slow
def test_what_nothing_holds_has_derivatives_where_it_lies(tmp_path):
    path = tmp_path / "scene.toml"
    # the chain at its centre holds no yaw
    where = '[measures.height]\nposition = "rope.end"\ncomponent = "z"\n'
    path.write_text(laid(0.3, [0.01, 0.02, 0], SLACK + where), encoding="utf-8")
    sunk = response(path, ["bodies.box.mass"], "max height")
    slope = float(jax.jacfwd(sunk)(np.array([500.0]))[0])
    assert slope == pytest.approx(-(9.81 + 0.1 * 9.80665) / 500e3, rel=1e-4)


# thrust along its own axis, on one line from its stern: its forces have no energy
STEERED = """
[materials.wire]
law = "linear"
EA = "500 kN"
[bodies.ship]
mass = 20e3
size = [10, 4, 2]
position = [27.1, 0, 0]
attitude = [0, 0, 0.3]
points = { stern = [-5, 0, 0] }
free = ["x", "y", "yaw"]
settle = true
control = { force = ["2 kN", 0, 0], turn_stiffness = [0, 0, SPRING] }
[output]
""" + line_text("rope", "wire", 22, 1, 1e-6, fixed(0, 0, 0), '"ship.stern"')  # fmt: skip


@pytest.mark.parametrize("spring", [2e3, pytest.param(50e3, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_a_ship_under_thrust_rests_where_its_forces_balance(tmp_path, spring):
    def left(q):
        x, y, yaw = q
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        stern = np.array([x, y]) - 5.0 * ahead
        away = np.linalg.norm(stern)
        pull = -5e5 * (away / 22.0 - 1.0) * stern / away
        arm = -5.0 * ahead
        moment = arm[0] * pull[1] - arm[1] * pull[0] - spring * (yaw - 0.3)
        return [*(2e3 * ahead + pull), moment]

    exact = root(left, [26.0, 8.0, 0.3], tol=1e-13)
    assert exact.success
    ran = run_text(tmp_path, STEERED.replace("SPRING", str(spring)))
    assert ran.statuses == ["OK"]
    place, turn = start_of_body(ran, "ship")
    np.testing.assert_allclose([*place[:2], turn[2]], exact.x, atol=1e-5)


DRAGGED = """
[water]
density = 1000
current = { velocity = [1.5, 0.4, 0] }
[materials.wire]
law = "linear"
EA = "50 kN"
[bodies.buoy]
mass = 500
size = [2, 1, 1]
drag = [1, 1, 1]
position = [9, 0, 0]
attitude = [0, 0, 0.2]
free = FREE
settle = true
[output]
""" + line_text("rope", "wire", 10, 4, 0.1, fixed(0, 0, 0), '"buoy"')  # fmt: skip


@pytest.mark.slow
def test_a_current_does_not_turn_what_it_only_pulls_at(tmp_path):
    turning = run_text(tmp_path, DRAGGED.replace("FREE", '["x", "y", "yaw"]'))
    held = run_text(tmp_path, DRAGGED.replace("FREE", '["x", "y"]'))
    assert turning.statuses == held.statuses == ["OK"]
    place, turn = start_of_body(turning, "buoy")
    assert turn[2] == pytest.approx(0.2, abs=2e-3)
    np.testing.assert_allclose(place, start_of_body(held, "buoy")[0], atol=5e-3)
