"""Drums that pay lines out as they are told, against an equation of one mass on a spring that grows."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import run_scenes, run_text, study_of
from scipy.integrate import solve_ivp

from lumpedcable import response
from lumpedcable.scene import load_study

G, EA, LENGTH, MASS = 9.81, 2e6, 20.0, 2000.0
TIMES, SPEEDS = [0.0, 0.5, 3.0, 3.2], [0.0, 1.0, 1.0, 0.0]

# a load on a wire that weighs next to nothing
LOAD = f"""
gravity = {G}
[materials.wire]
law = "linear"
EA = {EA}
[bodies.load]
mass = {MASS}
[lines.wire]
material = "wire"
length = {LENGTH}
segments = 2
mass = 0.01
start = {{ drum = {{ at = [0, 0, 50], schedule = {{ time = {TIMES}, speed = {SPEEDS} }} }} }}
end = "load"
[output]
duration = 6
every = 0.02
"""


def out_by(t, times=TIMES, speeds=SPEEDS, length=LENGTH):
    """The length (m) that is out at t (s): the integral of the speed, piece by piece."""
    knots = sorted({0.0, *(x for x in times if 0.0 < x < t), t})
    v = np.interp(knots, times, speeds)
    return length + np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(knots))


def lowered(time, times=TIMES, speeds=SPEEDS):
    """Depth (m) and tension (N) of the load on a spring of the length L(t), M z'' = M g - T."""

    def pull(t, z):
        length = out_by(t, times, speeds)
        return EA * (z - length) / length

    solved = solve_ivp(
        lambda t, y: [y[1], G - pull(t, y[0]) / MASS], (0.0, time[-1]),
        [LENGTH * (1.0 + MASS * G / EA), 0.0], "DOP853", time, rtol=1e-10, atol=1e-11, max_step=0.01,
    )  # fmt: skip
    return solved.y[0], np.array([pull(t, z) for t, z in zip(time, solved.y[0], strict=True)])


@pytest.mark.parametrize(
    ("times", "speeds"),
    [
        (TIMES, SPEEDS),
        pytest.param([0.3, 1.0, 5.0, 5.2], [0.0, -2.5, -2.5, 0.0], marks=pytest.mark.slow),
        pytest.param([0.0], [0.4], marks=pytest.mark.slow),
    ],
    ids=["lowered", "hauled in", "from the start"],
)
def test_a_load_bounces_on_a_spring_that_grows(tmp_path, times, speeds):
    told = f"time = {times}, speed = {speeds}"
    ran = run_text(tmp_path, LOAD.replace(f"time = {TIMES}, speed = {SPEEDS}", told))
    assert ran.statuses == ["OK"]
    depth, tension = lowered(ran.time, times, speeds)
    assert 50.0 - ran["position"][0, :, -1, 2] == pytest.approx(depth, abs=1e-4)
    # the wire's own 0.2 kg make the load swing slower by some 2e-5: after 20 swings as much as this
    assert ran["tension"][0, :, -1] == pytest.approx(tension, abs=2e-4 * np.max(tension))
    # what is out is the integral of the speed
    out = [out_by(t, times, speeds) for t in ran.time]
    assert ran["payout"][0] == pytest.approx(out, rel=1e-12)
    assert ran["payout_speed"][0] == pytest.approx(np.interp(ran.time, times, speeds), abs=1e-12)
    assert ran.outcomes[0].energy_closure < 1e-3


ROPE = f"""
gravity = {G}
[materials.rope]
law = "linear"
EA = 5e6
damping = 2e5
[lines.rope]
material = "rope"
length = 100
segments = 40
mass = 5
{{ends}}
[output]
duration = {{duration}}
every = 0.05
"""


def ends(side, at, schedule, other='"free"'):
    drum = f"{{ drum = {{ at = {at}, schedule = {schedule} }} }}"
    across = {"start": "end", "end": "start"}[side]
    return f"{side} = {drum}\n{across} = {other}"


@pytest.mark.parametrize("side", ["start", "end"])
@pytest.mark.slow
def test_a_rope_alone_is_as_light_as_its_drum_lets_it_fall(tmp_path, side):
    # all of it goes down by L'': m L (g - L'') at the drum
    schedule = "{ time = [0, 2, 4, 4.5, 5.5], speed = [0, 0, 8, 9, 9] }"
    text = ROPE.format(ends=ends(side, [0, 0, 0], schedule), duration=10)
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    segment = 0 if side == "start" else -1
    out, time = ran["payout"][0], ran.time
    fall = np.where((time > 2.0) & (time < 4.0), 4.0, 0.0)
    expected = 5.0 * out * (G - fall)
    steady = ((time > 3.0) & (time < 3.95)) | (time > 8.0)
    error = ran[f"{side}_tension"][0] / expected - 1.0
    assert np.abs(error[steady]).max() < 1e-2
    near = ran["tension"][0, :, segment] / (expected * (1.0 - 0.5 / 40)) - 1.0
    assert np.abs(near[steady]).max() < 1e-2
    assert ran.outcomes[0].energy_closure < 5e-3


@pytest.mark.parametrize(
    "body",
    [
        "motion.heave = { amplitude = 0.4, period = 3 }",
        pytest.param("free", marks=pytest.mark.slow),
    ],
    ids=["moved", "free"],
)
@pytest.mark.slow
def test_a_drum_may_stand_on_a_body_that_moves(tmp_path, body):
    # one that is moved up and down, and one of 5 t on a spring that the load pulls down
    amplitude, period, kilograms, spring = 0.4, 3.0, 5e3, 4e6
    if free := body == "free":
        body = f'mass = {kilograms}\nfree = ["z"]\ncontrol = {{ stiffness = [0, 0, {spring}] }}'
    ship = f"[bodies.ship]\nposition = [0, 0, 50]\npoints = {{ tip = [0, 0, 0] }}\n{body}\n"
    text = LOAD.replace("[bodies.load]", ship + "[bodies.load]")
    ran = run_text(tmp_path, text.replace("at = [0, 0, 50]", 'at = "ship.tip"'))
    assert ran.statuses == ["OK"]

    def slope(t, y):
        post = y[2] if free else -amplitude * np.sin(2 * np.pi * t / period)
        length = out_by(t)
        pull = EA * (y[0] - post - length) / length
        return [y[1], G - pull / MASS, y[3], G + (pull - spring * y[2]) / kilograms]

    start = [LENGTH * (1.0 + MASS * G / EA), 0.0, 0.0, 0.0]
    solved = solve_ivp(slope, (0.0, 6.0), start, "DOP853", ran.time, rtol=1e-9, atol=1e-10,
                       max_step=0.02).y  # fmt: skip
    assert 50.0 - ran["position"][0, :, -1, 2] == pytest.approx(solved[0], abs=2e-4)
    assert 50.0 - ran["position"][0, :, 0, 2] == pytest.approx(
        solved[2] if free else -amplitude * np.sin(2 * np.pi * ran.time / period), abs=2e-4
    )
    assert ran.outcomes[0].energy_closure < 1e-3


TOW = """
[water]
density = 1000
[materials.rope]
law = "linear"
EA = 1e7
damping = 1e5
[lines.rope]
material = "rope"
length = 100
segments = 25
mass = 1
diameter = 0.04
drag = { normal = 1.2, tangential = 0.1 }
start = { held = { pretension = 100, direction = [-1, 0, 0] } }
end = { drum = { at = [0, 0, 0], schedule = { time = [1, 3, 17], speed = [0, -3, -3] } } }
[output]
duration = 17
every = 0.1
"""


@pytest.mark.slow
def test_water_drags_on_what_is_hauled_through_it(tmp_path):
    # every metre of the rope goes at 3 m/s, whichever node is there: pi d Ct rho v^2 / 2 of drag on it
    ran = run_text(tmp_path, TOW)
    assert ran.statuses == ["OK"]
    out, late = ran["payout"][0], ran.time > 6.0
    drag = 0.5 * 1000 * np.pi * 0.04 * 0.1 * 3.0**2
    assert ran["end_tension"][0, late] == pytest.approx(100 + drag * out[late], rel=2e-3)
    assert out[-1] == pytest.approx(55.0, rel=1e-12)
    assert ran.outcomes[0].energy_closure < 5e-3


TOWED = """
gravity = 9.81
[water]
density = 1025
current = { profile = "uniform", velocity = [1, 0, 0] }
[materials.wire]
law = "linear"
EA = 5e6
[bodies.load]
mass = 500
volume = 0.2
[lines.wire]
material = "wire"
length = 60
segments = 30
mass = 2
diameter = 0.03
drag = { normal = 1.2, tangential = 0.02 }
added_mass = { normal = 1.0 }
bending = { EI = 500 }
start = { drum = { at = [0, 0, 0], schedule = { time = [0, 1, 6, 7], speed = [0, -4, -4, 0] } } }
end = "load"
[output]
duration = 9
every = 0.1
"""


@pytest.mark.parametrize(
    "solver",
    [
        "",
        pytest.param('dtype = "float32"', marks=pytest.mark.slow),
        pytest.param('method = "rk4"', marks=pytest.mark.slow),
        pytest.param('method = "dopri8"', marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_the_account_closes_where_a_line_is_hauled_in_aslant(tmp_path, solver):
    ran = run_text(tmp_path, TOWED + f"[solver]\n{solver}\n")
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
    assert ran["payout"][0, -1] == pytest.approx(36.0, rel=1e-12)


@pytest.mark.slow
def test_hauling_in_takes_the_step_of_the_shortest(tmp_path):
    # 20 m to 5 m: segments a quarter as long have a quarter of the step, and no more than that
    hauled = "time = [0, 1], speed = [0, -2.7]"
    text = LOAD.replace(f"time = {TIMES}, speed = {SPEEDS}", hauled)
    steps = {}
    for told in (text, text.replace("-2.7", "2.7")):
        ran = run_text(tmp_path, told, "segments=8", "wire.mass=1")
        assert ran.statuses == ["OK"]
        steps[told == text] = ran.outcomes[0].solver_step
    assert steps[True] / steps[False] == pytest.approx((20 - 2.7 * 5.5) / 20, rel=0.1)


SHORT = LOAD.replace("duration = 6", "duration = 4").replace("mass = 0.01", "mass = 1")
SPEED = "lines.wire.start.drum.schedule.speed.1"


@pytest.mark.slow
def test_speeds_may_be_swept_in_one_program(tmp_path):
    speeds = [0.5, 1.0, 1.5]
    study = study_of(tmp_path, SHORT, f"{SPEED}={speeds}")
    assert len({scene.skeleton() for scene in study.runs}) == 1
    swept = run_scenes(tmp_path, study)
    assert swept.statuses == ["OK"] * 3
    for k, speed in enumerate(speeds):
        out = out_by(4.0, speeds=[0.0, speed, 1.0, 0.0])
        assert swept["payout"][k, -1] == pytest.approx(out, rel=1e-12)
    alone = run_text(tmp_path, SHORT, f"{SPEED}=1.5")
    assert swept["tension"][2] == pytest.approx(alone["tension"][0], rel=1e-9)


@pytest.mark.parametrize("key", [SPEED, "lines.wire.start.drum.schedule.time.1"])
@pytest.mark.slow
def test_derivatives_of_the_peak_go_through_the_drum(tmp_path, key):
    path = tmp_path / "scene.toml"
    path.write_text(SHORT, encoding="utf-8")
    answer = response(path, [key], "max tension at wire.end")
    at = load_study(path).scene.numbers()[key]
    slope = float(jax.grad(lambda x: answer(x[None]))(jnp.array(at)))
    up, down = (float(answer(jnp.array([at + way]))) for way in (1e-4, -1e-4))
    assert slope == pytest.approx((up - down) / 2e-4, rel=2e-3)
    assert abs(slope) > 100.0


def test_a_scene_at_rest_is_as_long_as_it_says(tmp_path):
    # statics knows nothing of speeds, and gives the same with a wire that is simply held
    rest = SHORT[: SHORT.index("duration")]
    drum = f"{{ drum = {{ at = [0, 0, 50], schedule = {{ time = {TIMES}, speed = {SPEEDS} }} }} }}"
    assert drum in rest
    ran = run_text(tmp_path, rest)
    held = run_text(tmp_path, rest.replace(drum, "{ fixed = [0, 0, 50] }"))
    assert ran["position"] == pytest.approx(held["position"], abs=1e-12)
    assert ran["payout"][0] == pytest.approx(LENGTH)


@pytest.mark.slow
def test_a_target_finds_how_much_is_out(tmp_path):
    text = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = 5e6
[lines.wire]
material = "wire"
length = 60
segments = 16
mass = 2
start = { drum = { at = [0, 0, 0], schedule = { time = [0], speed = [1] } } }
end = { fixed = [50, 0, -20] }
[targets.taut]
change = "lines.wire.length"
of = "wire.end"
tension = 5e3
[output]
"""
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    assert ran["end_tension"][0, 0] == pytest.approx(5e3, rel=1e-6)
    assert ran["payout"][0, 0] == pytest.approx(ran.places["wire"][-1], rel=1e-12)
    assert 53.0 < ran["payout"][0, 0] < 56.0


BESIDE = """
[lines.other]
material = "wire"
length = 42
segments = 4
mass = 1
start = { fixed = [0, 5, 10] }
end = { winch = { at = [40, 5, 10], tension = "20 kN" } }
[output]
"""


@pytest.mark.slow
def test_a_drum_and_a_winch_of_two_lines_do_not_meddle(tmp_path):
    ran = run_text(tmp_path, SHORT.replace("[output]", BESIDE))
    assert ran.statuses == ["OK"]
    alone = run_text(tmp_path, SHORT)
    assert ran["wire.tension"] == pytest.approx(alone["wire.tension"], rel=2e-3)
    assert np.ptp(ran["other.payout"]) < 1e-6


@pytest.mark.slow
def test_a_line_may_part_across_from_its_drum(tmp_path):
    cut = '[events.cut]\nbreaks = "rope.start"\nstart = 10\ntime = 0.05\n'
    ran = run_text(tmp_path, TOW + cut)
    assert ran.statuses == ["OK"]
    # what is left of it comes in as before, with nothing at its end
    drag = 0.5 * 1000 * np.pi * 0.04 * 0.1 * 3.0**2
    late = ran.time > 13.0
    assert ran["end_tension"][0, late] == pytest.approx(drag * ran["payout"][0, late], rel=5e-3)


@pytest.mark.slow
def test_the_scene_of_a_crane_comes_to_its_closed_form(tmp_path):
    scene = Path(__file__).parents[2] / "configs" / "lowering.toml"
    ran = run_scenes(tmp_path, load_study(scene))
    assert ran.statuses == ["OK"]
    # L = 38.25 m while it brakes, as the file says
    length, heavy = 38.25, 20e3 + 7.0 * 38.25 / 3.0
    rate = np.sqrt(60e6 / length / heavy)
    share = 0.5 * 0.3e6 / length / np.sqrt(60e6 / length * heavy)
    turn = np.pi - 2.0 * np.arcsin(share)
    root = np.sqrt(1.0 - share**2)
    swing = np.cos(turn) - share / root * np.sin(turn)
    peak = 20e3 * (G + 2.0 * (1.0 - np.exp(-share * turn / root) * swing))
    assert rate * root * 0.5 > turn  # it brakes for so long
    (told,) = load_study(scene).scene.references["spring"].values["peak"]
    assert told == pytest.approx(peak, rel=1e-4)
    assert ran.outcomes[0].measures["peak"] == pytest.approx(peak, rel=2e-3)
