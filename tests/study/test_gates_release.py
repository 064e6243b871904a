"""The parted line against exact waves: end speed, front arrival, energy, displacement."""

import numpy as np
import pytest
from engine_runs import HOOKE, ROPE, run_text
from nylon_line import LENGTH, MASS, RUNS, cut

from lumpedcable.exact import ramped_release, release_wave

SWEEP = """
[sweep]
"lines.rope.end.held.pretension" = ["45 kN", "180 kN", "315 kN", "450 kN"]
"""
CUT = ROPE.replace("tension_only = false", "tension_only = true") + SWEEP
SIGNED = ROPE + SWEEP


def plateau(run, ramp):
    """When the end moves at its final speed (s): after the ramp, until something comes back."""
    wave = release_wave(cut, MASS, tension0=run.T0)
    until = wave.reflection_return(LENGTH)
    if ramp > 0.0:
        smooth = ramped_release(cut, MASS, ramp, tension0=run.T0)
        if np.isinf(smooth.shock_time) or smooth.shock_place > LENGTH:
            until = min(until, smooth.end_valid_until(LENGTH))
    return ramp + 1e-3, until


def end_speed(ran, k):
    return -ran["velocity"][k, :, -1, 0]


@pytest.fixture(scope="module")
def signed(tmp_path_factory):
    """Runs 1 to 4 with the law as printed, which carries compression like tension."""
    return run_text(
        tmp_path_factory.mktemp("signed"), SIGNED, "rope.segments=400", "output.duration=100 ms"
    )


@pytest.fixture(scope="module")
def slack(tmp_path_factory):
    """Runs 1 to 4 with the law cut at zero, until the reflection is back."""
    return run_text(
        tmp_path_factory.mktemp("slack"), CUT, "rope.segments=400", "output.duration=230 ms"
    )


def mean_error(ran, k):
    """Mean end speed on the plateau over the exact one, less 1; and the error in m/s."""
    run = RUNS[k]
    first, last = plateau(run, 5e-3)
    speed = end_speed(ran, k)[(ran.time >= first) & (ran.time <= last)]
    error = speed.mean() - run.end_speed
    return error / run.end_speed, error


def test_a_straight_dry_line_is_computed_along_itself(signed):
    # no weight, no water: one coordinate is enough, and all three come back
    assert signed.attributes["coordinates"] == 1
    assert signed["position"].shape[-1] == 3
    assert np.all(signed["position"][..., 1:] == 0.0)


@pytest.mark.parametrize("k", [0, 1, 2])
def test_end_speed_of_a_rarefaction(signed, k):
    # 43.17086886, 111.227207, 166.250409 m/s
    assert abs(mean_error(signed, k)[1]) < 0.01


def test_end_speed_behind_a_shock(signed):
    # 228.8391582 m/s for an instantaneous break; a smooth one starts at 228.3583965 m/s
    assert abs(mean_error(signed, 3)[0]) < 3e-3


@pytest.mark.parametrize("k", [0, 1, 2, 3])
def test_end_speed_of_a_line_that_cannot_push(slack, k):
    # the same speeds: the cut does not reach into the wave. Where the end has run ahead and gone
    # slack no tension pulls it back; the viscosity of slack segments must
    relative, error = mean_error(slack, k)
    assert abs(relative) < 3e-3 if k == 3 else abs(error) < 0.01


@pytest.mark.parametrize("n", [400, pytest.param(800, marks=pytest.mark.slow)])
def test_a_broken_end_does_not_run_into_its_neighbours(tmp_path, n):
    # without the viscosity of slack segments the end of run 4 kept its overshoot of 20 m/s and
    # passed its neighbour, of 800 segments after 27 ms, long before anything real could happen there
    ran = run_text(
        tmp_path, CUT, f"rope.segments={n}", "break.time=0 s", "output.duration=50 ms",
        "output.every=2 ms",
    )  # fmt: skip
    assert ran.statuses == ["OK"] * 4
    assert np.min(ran["strain"]) > -0.05


def test_front_of_an_instantaneous_break_arrives_as_a_shock(tmp_path):
    # run 4: 58.43 ms by the exact wave, not L/c(e0) = 74.96 ms; judged where half the tension
    # is gone, since the front is a jump from 450 kN to 152 kN
    ran = run_text(
        tmp_path, CUT, "rope.segments=400", "break.time=0 s", "output.duration=62 ms",
        "output.every=0.1 ms",
    )  # fmt: skip
    wall = ran["start_tension"][3]
    when = np.interp(-0.5 * wall[0], -wall, ran.time)
    assert abs(when - 58.42866851e-3) < 0.3e-3
    # the others: their fronts are no jumps at the head, which feels 1 % of the drop first
    assert np.isnan(ran.outcomes[0].recoils["rope.end"]["front_arrival"])  # 91.2 ms
    for k in (1, 2):
        wave = release_wave(cut, MASS, tension0=RUNS[k].T0)
        arrival = ran.outcomes[k].recoils["rope.end"]["front_arrival"]
        assert abs(arrival - wave.front_arrival(LENGTH)) < 0.02 * wave.front_arrival(LENGTH)


def hooke(folder, n, *more):
    return run_text(folder, HOOKE, f"rope.segments={n}", "output.duration=190 ms", *more)


@pytest.mark.parametrize("n", [50, *(pytest.param(n, marks=pytest.mark.slow) for n in (200, 800))])
def test_plateau_of_a_linear_line(tmp_path, n):
    # T0 / (m c) = 50 kN / (1 kg/m 1000 m/s) from 0 to 200 ms
    ran = hooke(tmp_path, n)
    speed = end_speed(ran, 0)[ran.time > 5e-3]
    assert speed.mean() == pytest.approx(50.0, rel=2e-3)
