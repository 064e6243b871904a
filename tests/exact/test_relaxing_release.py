"""The line that relaxes against its limits, a finite-difference march and what is known of its front."""

import numpy as np
import pytest

from lumpedcable.exact import LinearRelease, RelaxingRelease

LINE = {"length": 100.0, "mass": 1.0, "tension0": 5e4}
RAMP = 0.03
S, T = np.linspace(0.0, 100.0, 11), np.linspace(0.001, 0.4, 37)[:, None]
QUANTITIES = ("displacement", "velocity", "tension")


def close(found, exact, bound):
    for one in QUANTITIES:
        a, b = getattr(found, one)(S, T), getattr(exact, one)(S, T)
        assert np.max(np.abs(a - b)) <= bound * np.max(np.abs(b)), one


@pytest.mark.parametrize(
    ("branch", "EA"),
    [((1e-3, 0.02), 1e6), ((1e6, 1e-7), 1e6), ((1e6, 1e6), 2e6)],
    ids=["none to speak of", "gone at once", "never gone"],
)
def test_limits_are_elastic_lines(branch, EA):
    line = RelaxingRelease(EA=1e6, branches=(branch,), ramp_time=RAMP, modes=4000, **LINE)
    close(line, LinearRelease(EA=EA, ramp_time=RAMP, **LINE), 5e-4)


@pytest.mark.parametrize("ramp", [0.2, 0.2 / 3.0, 0.0667, 0.05])
@pytest.mark.parametrize("branches", [(), ((1e-9, 1.0),)])
def test_a_ramp_as_fast_as_a_mode(ramp, branches):
    # pi / ramp is the lowest frequency, c pi / 2 L, or the next, and nothing damps it
    line = RelaxingRelease(EA=1e6, branches=branches, ramp_time=ramp, modes=4000, **LINE)
    close(line, LinearRelease(EA=1e6, ramp_time=ramp, **LINE), 1e-6)


def march(line, n, duration, every):
    """Second-order differences in space, RK4 in time: velocities of the nodes from the fixed end on."""
    h = line.length / n
    stiff = np.array([s for s, _ in line.branches])[:, None]
    time = np.array([t for _, t in line.branches])[:, None]
    mass = np.full(n, line.mass * h)
    mass[-1] /= 2.0

    def rate(t, y):
        w, v, z = y
        strain = np.diff(w, prepend=0.0) / h
        pull = line.EA * strain + np.sum(stiff * (strain - z), axis=0)
        push = line.tension0 * np.sin(0.5 * np.pi * min(t / line.ramp_time, 1.0)) ** 2
        return v, np.diff(np.append(pull, -push)) / mass, (strain - z) / time

    y = (np.zeros(n), np.zeros(n), np.zeros((len(line.branches), n)))
    dt = every / np.ceil(every / (0.5 * h / line.front_speed))
    found = []
    for k in range(round(duration / dt)):

        def moved(share, slope, y=y):
            return [a + share * dt * b for a, b in zip(y, slope, strict=True)]

        k1 = rate(k * dt, y)
        k2 = rate((k + 0.5) * dt, moved(0.5, k1))
        k3 = rate((k + 0.5) * dt, moved(0.5, k2))
        k4 = rate((k + 1) * dt, moved(1.0, k3))
        slopes = zip(k1, k2, k3, k4, strict=True)
        y = moved(1.0, [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in slopes])
        if round((k + 1) * dt / every, 6) % 1 == 0:
            found.append(-y[1])
    return np.array(found)


def test_against_finite_differences():
    branches = ((8e5, 0.02), (5e5, 0.004))
    line = RelaxingRelease(EA=1e6, branches=branches, ramp_time=RAMP, modes=4000, **LINE)
    t = np.arange(1, 31)[:, None] * 0.01
    errors = []
    for n in (50, 100):
        exact = line.velocity(np.linspace(100.0, 0.0, n + 1)[1:], t)
        errors.append(np.max(np.abs(march(line, n, 0.3, 0.01) - exact)))
    assert errors[1] < 0.01 * np.max(np.abs(exact))
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_front_of_a_release_at_once():
    line = RelaxingRelease(EA=1e6, branches=((1e6, 0.02),), modes=20_000, **LINE)
    c = line.front_speed
    assert c == pytest.approx(np.sqrt(2e6))
    for x in (25.0, 50.0, 75.0):
        # carried on from two instants behind it, where 20,000 modes still ripple by 1/(k c dt) = 3e-3
        early, late = (float(line.velocity(x, x / c + dt)) for dt in (4e-4, 8e-4))
        exact = 5e4 / (line.mass * c) * float(line.front_height(x))
        assert 2.0 * early - late == pytest.approx(exact, rel=3e-3)
        assert abs(float(line.velocity(x, x / c - 4e-4))) < 1e-3 * exact


def test_what_is_no_line():
    with pytest.raises(ValueError, match="expected a positive time of a branch, found 0 s"):
        RelaxingRelease(EA=1e6, branches=((1e6, 0.0),), **LINE)
    with pytest.raises(ValueError, match="expected a ramp of 0 s or more"):
        RelaxingRelease(EA=1e6, branches=(), ramp_time=-1.0, **LINE)
    with pytest.raises(ValueError, match="from 0 at the released end to 100 m"):
        RelaxingRelease(EA=1e6, branches=(), **LINE).tension(101.0, 0.0)
