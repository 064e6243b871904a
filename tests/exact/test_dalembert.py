"""The linear line with all its reflections against a march of characteristics."""

import numpy as np
import pytest

from lumpedcable.exact import LinearRelease

LINE = {"length": 100.0, "EA": 1e6, "mass": 1.0, "tension0": 5e4}


def march(line, n, steps):
    """Riemann invariants w -+ T/Z shifted one cell a step: exact at the nodes for linear waves."""
    Z = np.sqrt(line.EA * line.mass)
    dt = line.length / n / line.wave_speed
    into = np.full(n + 1, -line.tension0 / Z)  # w - T/Z, runs towards the fixed end
    back = np.full(n + 1, line.tension0 / Z)  # w + T/Z, runs towards the released end
    out = []
    for k in range(1, steps + 1):
        into = np.concatenate([[0.0], into[:-1]])
        back = np.concatenate([back[1:], [0.0]])
        F = line.tension0 * np.cos(0.5 * np.pi * min(k * dt / line.ramp_time, 1.0)) ** 2
        into[0] = back[0] - 2.0 * F / Z  # T = F there
        back[-1] = -into[-1]  # w = 0 there
        out.append((k * dt, 0.5 * (back - into) * Z, 0.5 * (back + into)))
    return out


def test_against_characteristics():
    line = LinearRelease(**LINE, ramp_time=0.013)
    s = np.linspace(0.0, 100.0, 201)
    moved = np.zeros(201)
    last = np.zeros(201)
    dt = 0.0
    for t, T, w in march(line, 200, 1700):  # over eight reflections
        assert np.max(np.abs(line.tension(s, t) - T)) < 1e-6
        assert np.max(np.abs(line.velocity(s, t) - w)) < 1e-9
        dt = dt or t
        moved, last = moved + 0.5 * dt * (w + last), w
    # The trapezoidal sum has an error of dt^2/12 times the jump of acceleration, at most.
    assert np.max(np.abs(line.displacement(s, t) - moved)) < 1e-3 * np.max(np.abs(moved))


def test_a_wrong_speed_is_noticed():
    wrong = LinearRelease(**LINE | {"EA": 1.01e6}, ramp_time=0.013)
    right = LinearRelease(**LINE, ramp_time=0.013)
    s = np.linspace(0.0, 100.0, 201)
    worst = max(np.max(np.abs(wrong.tension(s, t) - T)) for t, T, _ in march(right, 200, 600))
    assert worst > 1e3


def test_instantaneous_release_by_hand():
    # c = 1000 m/s, v = c e0 = 50 m/s; the front passes mid-span at 50 ms, the wall at 100 ms.
    line = LinearRelease(**LINE)
    t = np.array([0.001, 0.099, 0.199, 0.201, 0.399, 0.401])
    assert line.end_velocity(t) == pytest.approx([50, 50, 50, -50, -50, 50])
    assert line.tension(50.0, [0.0499, 0.0501]) == pytest.approx([5e4, 0.0])
    assert line.wall_tension([0.0999, 0.1001, 0.2999, 0.3001]) == pytest.approx(
        [5e4, -5e4, -5e4, 5e4]
    )
    assert line.end_displacement([0.1, 0.2, 0.3, 0.4]) == pytest.approx([5, 10, 5, 0])


def test_fixed_end_periodicity_and_mean():
    # Free vibration of a fixed-free rod about the unstretched state: period 4 L/c, mean e0 L.
    for ramp in (0.0, 0.013):
        line = LinearRelease(**LINE, ramp_time=ramp)
        t = 0.02 + 0.4 * (np.arange(400) + 0.5) / 400
        assert line.displacement(100.0, t) == pytest.approx(np.zeros(400), abs=1e-12)
        assert line.end_displacement(t + 0.4) == pytest.approx(line.end_displacement(t), abs=1e-9)
        assert np.mean(line.end_displacement(t)) == pytest.approx(5.0, rel=1e-9)
        # The displacement is the integral of the velocity, the strain its slope.
        x, h = np.linspace(1.37, 98.61, 50), 1e-5
        e = (line.displacement(x + h, 0.777) - line.displacement(x - h, 0.777)) / (2 * h)
        assert 5e4 + 1e6 * e == pytest.approx(line.tension(x, 0.777), abs=1e-2)


def test_short_ramp_tends_to_the_jump():
    sudden, quick = LinearRelease(**LINE), LinearRelease(**LINE, ramp_time=1e-7)
    t = np.linspace(0.0013, 0.8971, 77)
    assert quick.end_velocity(t) == pytest.approx(sudden.end_velocity(t), abs=1e-9)
    assert quick.wall_tension(t) == pytest.approx(sudden.wall_tension(t), abs=1e-6)


def test_errors():
    with pytest.raises(ValueError, match="positive EA"):
        LinearRelease(**LINE | {"EA": 0.0})
    with pytest.raises(ValueError, match="ramp of 0 s or more"):
        LinearRelease(**LINE, ramp_time=-1.0)
    with pytest.raises(ValueError, match="0 at the released end to 100 m"):
        LinearRelease(**LINE).velocity(101.0, 0.0)
