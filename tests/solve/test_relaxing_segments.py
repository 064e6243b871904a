"""Segments whose material relaxes, on ends that move as they are told, beside their own equations."""

from itertools import pairwise

import numpy as np
import pytest
from engine_runs import line_text, run_text, scene_of
from relaxing_ropes import BRANCHES, NYLON, nylon, relaxing
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from lumpedcable.model.assemble import make_line
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.solve.bound import line_step_bound

LONG, SWING, PERIOD = 10.0, 0.5, 0.2  # m, m, s
OMEGA = 2.0 * np.pi / PERIOD
HOOKE = 'law = "linear"\nEA = 1e6'


def segment(law, branches, end, steps, duration, every):
    """One segment of a law with branches between a fixed place and another `end`."""
    line = line_text("rope", "rope", LONG, 1, 1.0, "{ fixed = [0, 0, 0] }", end)
    return f"""
[materials.rope]
{law}
{relaxing("rope", branches)}
{line}
[solver]
{steps}
[output]
duration = {duration}
every = {every}
"""


def shaken(law, mean, swing=SWING, branches=BRANCHES):
    """One segment, pulled to `mean` (m), whose far end is moved to and fro by `swing` (m)."""
    motion = (
        f"{{ motion = {{ position = [{mean}, 0, 0], amplitude = [{swing}, 0, 0], "
        f"period = {PERIOD} }} }}"
    )
    return segment(law, branches, motion, "step = 1e-3", 0.6, 0.02)


def pulled(t, stiff, time):
    """What a branch carries (N) that is shaken from rest from t = 0 on: storage, loss, and the start."""
    x = OMEGA * time
    swung = np.cos(OMEGA * t) + x * np.sin(OMEGA * t) - np.exp(-t / time)
    return stiff * SWING / LONG * x / (1.0 + x**2) * swung


@pytest.mark.slow
def test_a_segment_that_is_shaken(tmp_path):
    text = shaken(HOOKE, 12.0)
    errors = []
    for step in (1e-3, 5e-4, 2.5e-4):
        ran = run_text(tmp_path, text, f"solver.step={step}")
        t = ran.time
        exact = 1e6 * (0.2 + SWING / LONG * np.sin(OMEGA * t))
        exact += sum(pulled(t, *branch) for branch in BRANCHES.values())
        errors.append(np.max(np.abs(ran["tension"][0, :, 0] - exact)))
        assert ran.statuses == ["OK"]
    assert errors[0] < 1e-3 * 5e5 * SWING / LONG
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("method", ["rk4", pytest.param("tsit5", marks=pytest.mark.slow)])
def test_by_other_methods(tmp_path, method):
    text = shaken(HOOKE, 12.0)
    chosen = () if method == "rk4" else ("solver.rtol=1e-6", "solver.atol=1e-9")
    text = text if method == "rk4" else text.replace("step = 1e-3", "")
    ran = run_text(tmp_path, text, f"solver.method={method}", *chosen)
    t = ran.time
    exact = 1e6 * (0.2 + SWING / LONG * np.sin(OMEGA * t))
    exact += sum(pulled(t, *branch) for branch in BRANCHES.values())
    assert np.max(np.abs(ran["tension"][0, :, 0] - exact)) < 1e-3 * 5e5 * SWING / LONG


def folding(times, mean, swing, branches):
    """Tension (N) of a segment of nylon that is shaken and folds, by its own equations."""
    stiff, time = np.array(list(branches.values())).T
    slack = brentq(nylon, -0.5, 0.5)

    def cut(e):
        return max(nylon(e), 0.0) if e > slack else 0.0

    def total(e, s):
        return cut(e) + np.sum(stiff * (e - s))

    def strain(t):
        return mean / LONG - 1.0 + swing / LONG * np.sin(OMEGA * t)

    def rate(t, s):
        e = strain(t)
        if total(e, s) < 0.0:
            e = brentq(total, max(e, slack), np.max(s) + 1e-9, args=(s,))
        return (e - s) / time

    start = np.full(len(stiff), max(strain(0.0), slack))
    found = solve_ivp(
        rate, (0.0, times[-1]), start, t_eval=times, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    return np.array([max(total(strain(t), s), 0.0) for t, s in zip(times, found.y.T, strict=True)])


KEYS = "\n".join(f"{key} = {value}" for key, value in NYLON.items())
# pulled by a few per cent and pushed back, slack half of the time; to where the law bends over, with
# less beside it and with more; slack at rest
FOLDS = [
    pytest.param(10.3, 0.5, BRANCHES, marks=pytest.mark.slow),
    (11.6, 1.8, {"only": (2e5, 2.0)}),
    pytest.param(11.4, 2.0, {"only": (5e5, 2.0)}, marks=pytest.mark.slow),
    (9.7, 0.8, {"only": (3e5, 1000.0)}),
]


@pytest.mark.parametrize(("mean", "swing", "branches"), FOLDS)
@pytest.mark.slow
def test_a_rope_that_folds(tmp_path, mean, swing, branches):
    law = f'law = "tanh"\n{KEYS}\ntension_only = true'
    text = shaken(law, mean, swing=swing, branches=branches)
    errors = []
    for step in (5e-4, 2.5e-4):
        ran = run_text(tmp_path, text, f"solver.step={step}")
        exact = folding(ran.time, mean, swing, branches)
        assert np.mean(exact == 0.0) > 0.2
        errors.append(np.max(np.abs(ran["tension"][0, :, 0] - exact)))
        assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 2e-3
    assert errors[1] < 1e-3 * np.max(exact)
    # but where the error is that of the other integration
    assert errors[0] / errors[1] > 2.5 or errors[0] < 1e-8 * np.max(exact)


def test_a_rope_that_is_slack_pulls_once_it_is_taut(tmp_path):
    # its end goes off at 1 m/s; a branch that hardly relaxes is a spring beside that of the law
    motion = "{ motion = { position = [9.8, 0, 0], velocity = [1, 0, 0] } }"
    law = 'law = "linear"\nEA = 1e6\ntension_only = true'
    text = segment(law, {"only": (3e5, 1e6)}, motion, "step = 1e-3", 0.4, 0.05)
    ran = run_text(tmp_path, text)
    exact = 1.3e6 * np.maximum(ran.time - 0.2, 0.0) / LONG
    assert ran["tension"][0, :, 0] == pytest.approx(exact, abs=1e-4 * np.max(exact))


@pytest.mark.parametrize(
    ("stiff", "time"),
    [(1e4, 1e-4), (1e6, 1e-2), (1e6, 1e-4), (1e8, 1e-4), (1e8, 1e-7), (1e9, 1e-6)],
)
def test_the_largest_stable_step(tmp_path, stiff, time):
    # leapfrog of one segment between two lumps as a matrix: e_n, l e'_n+1/2 and s_n+1/2 to those after
    text = segment(HOOKE, {"only": (stiff, time)}, '"free"', "", 1, 1)
    scene = scene_of(tmp_path, text)
    line = make_line(scene, "rope", np.array([LONG]), 1, Coordinates(*coordinates_of([scene])))
    bound = float(line_step_bound(line))

    def growth(dt):
        decay = np.exp(-dt / time)
        mean = stiff * (1.0 - decay) * time / dt
        per = 4.0 * dt / (1.0 * LONG**2)
        kick = [[1, 0, 0], [-per * (1e6 + mean), 1, per * mean], [1 - decay, 0, decay]]
        drift = [[1, dt, 0], [0, 1, 0], [0, 0, 1]]
        return np.max(np.abs(np.linalg.eigvals(np.array(drift) @ np.array(kick))))

    assert growth(0.999 * bound) <= 1.0
    assert growth(1.01 * bound) > 1.0


@pytest.mark.slow
def test_single_precision_holds_as_long(tmp_path):
    # a step is a ten-thousandth of a hundredth of the time: what it relaxes has no digit of its own
    motion = (
        "{ motion = { time = [0, 0.1, 0.2, 1], position = "
        "[[10, 0, 0], [10.5, 0, 0], [10.5, 0, 0], [10.5, 0, 0]] } }"
    )
    single = 'step = 1e-4\ndtype = "float32"'
    text = segment(HOOKE, {"only": (2e5, 100.0)}, motion, single, 1, 0.1)
    ran = run_text(tmp_path, text)
    carried = ran["tension"][0, :, 0] - 1e6 * ran["strain"][0, :, 0]
    assert carried[-1] / carried[2] == pytest.approx(np.exp(-0.8 / 100.0), abs=2e-4)


SPEED, TURNED = 1.0, [0.0, 0.2, 0.6, 0.8]  # m/s, s


def hauled(times):
    """Tension (N) of 10.3 m that a drum makes of 10 m and less, by the equations of the material."""
    stiff, time = np.array(list(BRANCHES.values())).T

    def strain(t):
        knots = np.unique([0.0, *(x for x in TURNED if x < t), t])
        speed = -SPEED * np.interp(knots, TURNED, [0.0, 1.0, 1.0, 0.0])
        return 10.3 / (LONG + np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(knots))) - 1.0

    found = solve_ivp(
        lambda t, s: (strain(t) - s) / time, (0.0, times[-1]), np.full(2, strain(0.0)),
        t_eval=times, rtol=1e-9, atol=1e-12, max_step=1e-3,
    )  # fmt: skip
    pulls = zip(times, found.y.T, strict=True)
    return np.array([1e6 * strain(t) + stiff @ (strain(t) - s) for t, s in pulls])


@pytest.mark.slow
def test_a_line_on_a_drum(tmp_path):
    speeds = [0.0, -SPEED, -SPEED, 0.0]
    drum = (
        f"{{ drum = {{ at = [10.3, 0, 0], schedule = {{ time = {TURNED}, speed = {speeds} }} }} }}"
    )
    text = shaken(HOOKE, 10.3).replace("duration = 0.6", "duration = 1.2")
    start, _, rest = text.partition("end = ")
    ran = run_text(tmp_path, f"{start}end = {drum}\n{rest.partition(chr(10))[2]}")
    exact = hauled(ran.time)
    assert np.max(np.abs(ran["tension"][0, :, 0] - exact)) < 1e-4 * np.max(exact)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow
def test_a_line_on_a_winch_keeps_its_account(tmp_path):
    # the end across is shaken, and the winch pays out and hauls in what keeps its tension
    text = shaken(HOOKE, 12.0).replace("segments = 1", "segments = 10")
    winch = "{ winch = { at = [0, 0, 0], tension = 5e4, inertia = 50, damping = 2e4 } }"
    text = text.replace("start = { fixed = [0, 0, 0] }", f"start = {winch}")
    text = text.replace("duration = 0.6", "duration = 2").replace("step = 1e-3", "step = 2e-4")
    ran = run_text(tmp_path, text)
    pulled = ran["tension"][0]
    assert ran.statuses == ["OK"]
    assert np.std(pulled) > 0.05 * 5e4
    assert np.mean(pulled[ran.time > 1.0]) == pytest.approx(5e4, rel=0.02)
    lost = ran.energy["lost_relaxation"][0]
    residual = np.max(np.abs(ran.energy["residual"][0]))
    assert residual < 2e-3 * lost[-1]
