"""Winches with a drum, a control law and a top speed, against ODEs of their own equations."""

from functools import cache
from pathlib import Path

import h5py
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lumpedcable.model.winches import Sheave, Winch
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

# A light wire between a fixed end and a post that is shaken. Without weight and with next to no mass
# it is a spring, so that the winch obeys three equations of first order.
EA, SPAN, MASS, SET = 1e6, 10.0, 0.02, 20e3
INERTIA, DAMPING, GAIN, TIME, TOP = 40.0, 800.0, 4.0, 0.2, 50.0
AMPLITUDE, PERIOD = 0.05, 1.5
WINCH = f"""
dimensions = 2
[materials.wire]
law = "linear"
EA = {EA}

[bodies.ship]
position = [{SPAN}, 0, 0]
motion.surge = {{ amplitude = {AMPLITUDE}, period = {PERIOD} }}
points = {{ post = [0, 0, 0] }}

[lines.line]
material = "wire"
length = {SPAN}
segments = 4
mass = {MASS}
start = {{ fixed = [0, 0, 0] }}
[lines.line.end.winch]
at = "ship.post"
tension = {SET}
inertia = {INERTIA}
damping = {DAMPING}
speed = {TOP}
control = {{ gain = {GAIN}, integral_time = {TIME} }}

[output]
duration = "1.2 s"
every = "5 ms"
"""


class Ran:
    """One run of the scene, read back."""

    def __init__(self, folder: Path, text: str, *overrides: str):
        (folder / "winch.toml").write_text(text)
        study = load_study(folder / "winch.toml", list(overrides))
        (self.outcome,) = run_study(study, folder / "winch.h5")
        with open_result(folder / "winch.h5") as found:
            self.time = found.time
            line = found.line("line")
            self.payout, self.speed = (line.field(f)[0] for f in ("payout", "payout_speed"))
            self.end = line.field("end_tension")[0]
            self.tension = line.tension(0)


@cache
def ran(folder: Path, *overrides: str) -> Ran:
    return Ran(folder, WINCH, *overrides)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("winch")


def post(t, amplitude=AMPLITUDE):
    return SPAN + amplitude * np.sin(2 * np.pi * t / PERIOD)


def pull(length, span):
    """What the length costs per metre (N): (1 + e) T - EA e^2 / 2."""
    e = span / length - 1.0
    return (1.0 + e) * EA * e - 0.5 * EA * e**2


def exactly(time, gain=GAIN, integral=TIME, damping=DAMPING, inertia=INERTIA, top=np.inf,
            amplitude=AMPLITUDE):  # fmt: skip
    """L, dL/dt and the integral of the error over time, from the equations that the winch owes."""
    strain = SET / EA
    kept, mass = pull(1.0, 1.0 + strain), inertia + MASS * SPAN / (1 + strain) / 3.0

    def slope(t, y):
        error = (pull(y[0], post(t, amplitude)) - kept) / (1.0 + strain)
        force = error * (1.0 + strain) + gain * error + gain / integral * y[2] - damping * y[1]
        grow = force / mass
        full = abs(y[1]) >= top
        if full and grow * y[1] > 0.0:
            grow = 0.0
        return [y[1], grow, 0.0 if full and error * y[1] > 0.0 else error]

    start = [SPAN / (1.0 + strain), 0.0, 0.0]
    step = np.inf if np.isinf(top) else 2e-4
    return solve_ivp(slope, (0, time[-1]), start, "RK45" if np.isfinite(top) else "DOP853", time,
                     rtol=1e-9, atol=1e-11, max_step=step).y  # fmt: skip


@pytest.mark.slow
def test_a_shaken_winch_obeys_its_control_law(folder):
    run = ran(folder)
    assert run.outcome.status.name == "OK"
    length, speed, _ = exactly(run.time)
    # the line's waves and its 0.2 kg on 40 kg are all that the ODE leaves out
    assert run.payout == pytest.approx(length, abs=2e-3 * np.ptp(length))
    assert run.speed == pytest.approx(speed, abs=5e-3 * np.ptp(speed))
    # the account knows what the drive takes; the abrupt start of the post is what is left
    assert run.outcome.energy_closure < 1e-3


def test_the_integral_takes_away_what_damping_leaves(folder):
    # a long swing of the post is a steady pull at v = 0.2 m/s: without an integral the drive lets
    # c v / (1 + K) of the tension go wrong, with one nothing
    slow = (
        "surge.amplitude=20",
        "surge.period=628.3185307179587 s",
        "output.duration=3",
        "surge.phase=0",
    )
    v = 20 * 0.01
    kept = 1.0 + SET / EA
    often = ran(folder, *slow, "integral_time=1e6")
    error = (often.tension[-1].mean() - SET) * kept
    assert error == pytest.approx(DAMPING * v / kept / (1 + GAIN / kept), rel=2e-2)
    never = ran(folder, *slow)
    assert abs(never.tension[-1].mean() - SET) < 0.02 * (often.tension[-1].mean() - SET)


def test_the_ideal_winch_is_the_limit_of_large_gains(folder):
    # the tension goes wrong by M L'' / (1 + K), twice that where it rings
    smooth = ("surge.phase=90 deg", "damping=0", "integral_time=1e6")
    worst = []
    for gain in (10, 40, 160):
        run = ran(folder, *smooth, f"control.gain={gain}")
        late = run.time > 0.4
        acceleration = AMPLITUDE * (2 * np.pi / PERIOD) ** 2
        worst.append(np.max(np.abs(run.tension[late] - SET)))
        assert worst[-1] < 2.2 * INERTIA * acceleration / (1 + gain)
    assert worst[1] < 0.35 * worst[0]
    assert worst[2] < 0.35 * worst[1]


def test_a_top_speed_holds_and_does_not_wind_up(folder):
    run = ran(folder, "winch.speed=0.15")
    assert run.outcome.status.name == "OK"
    assert np.max(np.abs(run.speed)) == pytest.approx(0.15, rel=1e-9)
    length = exactly(run.time, top=0.15)[0]
    assert run.payout == pytest.approx(length, abs=5e-3 * np.ptp(length))
    # with the integral running on at the top speed it would come back late
    assert run.outcome.energy_closure < 1e-3


@pytest.mark.slow
def test_a_sheave_grips_both_ways(tmp_path):
    text = WINCH.replace(f"control = {{ gain = {GAIN}, integral_time = {TIME} }}",
                         'sheave = { friction = 0.1, wrap = "90 deg", speed = 0.002 }')  # fmt: skip
    text = text.replace(f"damping = {DAMPING}\nspeed = {TOP}\n", "")
    run = Ran(tmp_path, text, "surge.period=6 s", "output.duration=5")
    assert run.outcome.status.name == "OK"
    grip = np.exp(0.1 * np.pi / 2)
    out, back = (run.time > 0.8) & (run.time < 1.2), (run.time > 3.4) & (run.time < 4.2)
    # the line stretches and slackens by 5 cm before it slides
    # Euler: the line beyond the sheave carries exp(mu theta) of the drum's tension as it is pulled out,
    # and as much less on the way back; the drum's 40 kg and the strain of 2 % are the rest
    assert run.tension[out].mean() == pytest.approx(SET * grip, rel=5e-3)
    assert run.tension[back].mean() == pytest.approx(SET / grip, rel=5e-3)
    assert run.outcome.energy_closure < 1e-3


def test_the_length_of_the_file_is_a_first_guess_alone(folder):
    # a line that weighs as much as its drum turns: what is out at rest counts, not what was guessed
    short, long = (
        ran(folder, "lines.line.mass=20", f"lines.line.length={guess}") for guess in (8.0, 25.0)
    )
    assert np.ptp(short.payout) > 0.02
    np.testing.assert_allclose(long.payout, short.payout, rtol=0, atol=1e-9)
    np.testing.assert_allclose(long.tension, short.tension, rtol=1e-8)


@pytest.mark.parametrize("speed", [1.0, -1.0, -3.0])
def test_a_sheave_rubs_by_all_that_the_drum_pulls_with(speed):
    set_, damping, grip = (jnp.asarray(x) for x in (20e3, 10e3, 0.1 * np.pi))
    one = jnp.ones(())
    winch = Winch(
        jnp.ones(1), one, set_, set_, one, damping=damping, sheave=Sheave(grip, 0.01 * one)
    )
    q, v = jnp.ones(1), jnp.full(1, speed)
    forces = winch.resisting(q, v)
    line = float(set_ - sum(force[0] for force in forces.values()))  # what keeps the speed steady
    # Euler: hauling at 1 m/s the drum pulls with 20 - 10 kN, paying out with 20 + 10; at 3 m/s it would
    # push, and a line that is not pressed on the sheave is not rubbed
    drum = 20e3 + 10e3 * speed
    expected = drum * np.exp(np.sign(speed) * 0.1 * np.pi) if drum > 0.0 else drum
    assert line == pytest.approx(expected, rel=1e-6)
    assert float(forces["friction"][0]) * speed <= 0.0


@pytest.mark.slow
def test_places_along_a_line_are_those_of_what_is_paid_out_at_the_start(tmp_path):
    text = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
tension_only = true
[lines.line]
material = "wire"
length = "60 m"
segments = 4
mass = "20 g/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = [40, 0, 0], tension = "8 kN" } }
[output]
duration = "20 ms"
every = "10 ms"
[sweep]
"lines.line.end.winch.tension" = ["8 kN", "1 N"]
"lines.line.length" = ["42 m", "60 m"]
"""
    (tmp_path / "scene.toml").write_text(text)
    outcomes = run_study(load_study(tmp_path / "scene.toml"), tmp_path / "out.h5")
    # 1 N cannot hold up the 7.8 N that the line weighs
    assert [outcome.status.name for outcome in outcomes[2:]] == ["STATICS_NOT_CONVERGED"] * 2
    shares = np.linspace(0.0, 1.0, 5)
    with open_result(tmp_path / "out.h5") as result:
        line = result.line("line")
        # L (1 + T / EA) = 40 m, less the (w L / T)^2 / 24 of the sag, 4e-8; else the first guess
        lengths = [40.0 / 1.008, 40.0 / 1.008, 42.0, 60.0]
        for run, length in enumerate(lengths):
            np.testing.assert_allclose(line.unstretched_position(run), length * shares, rtol=1e-6)
            middles = length * (shares[1:] - 0.125)
            np.testing.assert_allclose(line.unstretched_segment(run), middles, rtol=1e-6)
    with h5py.File(tmp_path / "out.h5") as file:
        assert "when the run starts" in file["lines/line/unstretched_position"].attrs["long_name"]
        assert "with payout" in file["lines/line/unstretched_position"].attrs["comment"]


def test_a_real_winch_needs_a_real_cable(tmp_path):
    text = WINCH.replace('material = "wire"', 'model = "ideal"\nmaterial = "wire"', 1)
    (tmp_path / "ideal.toml").write_text(text)
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "ideal.toml")
    found = {fault.key: fault.message for fault in caught.value.faults}
    assert 'expected model = "lumped"' in found["lines.line.end.winch.control"]
    assert 'expected model = "lumped"' in found["lines.line.end.winch.speed"]


# waves of 1000 m/s pass a tenth of the line in the step until less than 10 c dt of it is left
HAULED = """
[materials.wire]
law = "linear"
EA = "1 MN"
damping = 0
[lines.line]
material = "wire"
length = "20 m"
segments = 10
mass = "1 kg/m"
start = { winch = { at = [0, 0, 0], tension = "5 kN", damping = "0.5 kN s/m" } }
end = { motion = { position = [20.1, 0, 0], velocity = [-4, 0, 0], ramp = "0.2 s" } }
[output]
duration = "2.79 s"
every = "9 ms"
"""


@pytest.mark.parametrize("damping", [pytest.param(0.0, marks=pytest.mark.slow), 20.0, 200.0])
@pytest.mark.slow
def test_a_line_that_is_hauled_in_outruns_its_step_and_says_so(tmp_path, damping):
    text = HAULED.replace("damping = 0\n", f"damping = {damping}\n" if damping else "")
    outcome = Ran(tmp_path, text).outcome
    # leapfrog's step of segments l is 4 / (g + sqrt(g^2 + 4 w^2)), w = 2 c / l, g = 4 damping / (m l^2),
    # so that l^2 = (c dt)^2 + 2 damping dt / m where the step is that one; strained by 0.3 % meanwhile
    step = outcome.solver_step
    shortest = np.sqrt((1000.0 * step) ** 2 + 2.0 * damping * step)
    # the winch hauls at 4 m/s with 5 - 0.5 * 4 kN, 0.1 s later for the ramp
    until = (20.1 - 1.003 * 10 * shortest) / 4.0 + 0.1
    assert outcome.status.name == "STEP_BOUND_BROKEN"
    assert outcome.status_time == pytest.approx(until, abs=0.03)


@pytest.mark.parametrize(("solver", "refused"), [
    ('method = "rk4"', True),
    ('method = "tsit5"\nstep = "1 ms"', True),
    ('method = "tsit5"', False),
    ('method = "leapfrog"', False),
])  # fmt: skip
def test_a_top_speed_needs_steps_that_keep_it(tmp_path, solver, refused):
    text = (
        HAULED.replace('tension = "5 kN"', 'tension = "5 kN", speed = 3') + f"[solver]\n{solver}\n"
    )
    (tmp_path / "scene.toml").write_text(text.replace("damping = 0\n", ""))
    if not refused:
        load_study(tmp_path / "scene.toml")
        return
    with pytest.raises(SceneError, match=r"winch\.speed: expected solver\.method"):
        load_study(tmp_path / "scene.toml")


@pytest.mark.slow
def test_a_place_of_a_rope_that_is_paid_out_has_the_speed_of_the_rope(tmp_path):
    # nodes move along the rope as it grows longer; the rope 2 m from where it is held only stretches
    text = WINCH.replace("amplitude = 0.05", "amplitude = 2").replace("period = 1.5", "period = 6")
    text = text.replace(
        'duration = "1.2 s"\nevery = "5 ms"', 'duration = "0.5 s"\nevery = "0.1 ms"'
    )
    for kind in ("position", "velocity"):
        text += f'[measures.{kind}]\n{kind} = "line@2 m"\ncomponent = "x"\n'
    text += '[measures.speed]\nspeed = "line@2 m"\n'
    (tmp_path / "scene.toml").write_text(text)
    run_study(load_study(tmp_path / "scene.toml"), tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        time, out = file["time"][()], file["lines/line/payout"][0]
        place, velocity, speed = (
            file[f"measures/{k}"][0] for k in ("position", "velocity", "speed")
        )
    assert np.ptp(out) > 0.5  # of 10 m: the mesh passes the place with up to a fifth of that speed
    passing = 2.0 * np.gradient(out, time) / out
    assert np.abs(passing).max() > 0.2
    np.testing.assert_allclose(velocity[1:-1], np.gradient(place, time)[1:-1], atol=0.01)
    np.testing.assert_allclose(speed, np.abs(velocity), atol=1e-12)
