"""The exact simple wave of a ramped release."""

import numpy as np
import pytest
from nylon_line import LENGTH, MASS, RUNS, cut, cut_slope, slope, tension
from scipy.integrate import quad, solve_ivp
from wave_checks import gauss

from lumpedcable.exact import LinearRelease, ramped_release

RUN1, RUN2, RUN3, RUN4 = RUNS


@pytest.mark.parametrize("law", [(tension, slope), (tension, None), (cut, cut_slope), (cut, None)])
def test_birth_of_the_shock(law):
    # Computed independently (Zhu 2018, runs 3 and 4), to the digits known.
    known = {(RUN4, 5e-3): (5.19, 3.93), (RUN4, 50e-3): (51.9, 39.3), (RUN3, 5e-3): (46.2, 50.1)}
    for (run, ramp), (ms, place) in known.items():
        wave = ramped_release(law[0], MASS, ramp, tension0=run.T0, derivative=law[1])
        digits = 2 if ms < 10 else 1
        assert round(1e3 * wave.shock_time, digits) == ms
        assert round(wave.shock_place, digits if place < 10 else 1) == place
    assert ramped_release(law[0], MASS, 50e-3, tension0=RUN3.T0).shock_place > LENGTH
    for run in (RUN1, RUN2):
        wave = ramped_release(law[0], MASS, 5e-3, tension0=run.T0, derivative=law[1])
        assert wave.shock_time == wave.shock_place == np.inf


@pytest.mark.parametrize("run", [RUN3, RUN4])
def test_birth_of_the_shock_by_crossing_neighbours(run):
    ramp = 5e-3
    wave = ramped_release(tension, MASS, ramp, tension0=run.T0)
    left = np.linspace(0.0, ramp, 200001)[1:-1]
    e = np.interp(run.T0 * np.cos(0.5 * np.pi * left / ramp) ** 2, tension(E), E)
    c = np.sqrt(slope(e) / MASS)
    faster = np.diff(c) > 0.0
    time = (np.diff(c * left) / np.diff(c))[faster]
    place = (c[1:] * c[:-1] * np.diff(left) / np.diff(c))[faster]
    i = np.argmin(time)
    assert wave.shock_time == pytest.approx(time[i], rel=1e-6)
    assert wave.shock_place == pytest.approx(place[i], rel=1e-3)


E = np.linspace(0.0, 0.3, 400001)


def test_end_velocity():
    for run in RUNS:
        wave = ramped_release(tension, MASS, 5e-3, tension0=run.T0, derivative=slope)
        assert wave.end_velocity(5e-3) == pytest.approx(run.isentropic, rel=1e-9)
        assert wave.end_speed == pytest.approx(run.isentropic, rel=1e-9)
        half = wave.end_strain_history(2.5e-3)
        assert tension(half) == pytest.approx(0.5 * run.T0, rel=1e-12)  # cos^2(pi/4) = 1/2
        by_quad = quad(lambda e: np.sqrt(slope(e) / MASS), half, wave.strain0, epsabs=0)[0]
        assert wave.end_velocity(2.5e-3) == pytest.approx(by_quad, rel=1e-10)
        assert wave.end_velocity(0.0) == 0.0


def test_lumped_chain_agrees():
    # N = 4000 lumped masses, no drag, 5 ms, law cut at zero: largest end speeds, computed
    # independently; they overshoot the exact plateau by the dispersion of the chain.
    largest = (43.17713438, 111.2525629, 166.2949228)
    for run, v in zip(RUNS[:3], largest, strict=True):
        wave = ramped_release(cut, MASS, 5e-3, tension0=run.T0)
        assert wave.end_speed == pytest.approx(v, rel=3e-4)


def residuals(wave, law, s, t, h=1e-6):
    """Relative defects of e_t = w_s and m w_t = T_s at (s, t) by central differences."""
    c = np.sqrt(slope(wave.strain(s, t)) / MASS)
    d = h * c
    e_t = (wave.strain(s, t + h) - wave.strain(s, t - h)) / (2 * h)
    w_s = (wave.velocity(s + d, t) - wave.velocity(s - d, t)) / (2 * d)
    w_t = (wave.velocity(s, t + h) - wave.velocity(s, t - h)) / (2 * h)
    T_s = (law(wave.strain(s + d, t)) - law(wave.strain(s - d, t))) / (2 * d)
    scale = np.max(np.abs(e_t))
    return max(
        np.max(np.abs(e_t - w_s)) / scale,
        np.max(np.abs(MASS * w_t - T_s)) / (MASS * scale * np.max(c)),
    )


@pytest.mark.parametrize(("run", "t"), [(RUN1, 0.03), (RUN2, 0.02), (RUN3, 0.03), (RUN4, 5e-3)])
def test_field_obeys_the_equations(run, t):
    wave = ramped_release(tension, MASS, 5e-3, tension0=run.T0, derivative=slope)
    # Inside the wave, away from its two ends where the second derivatives jump.
    rear = max(0.0, float(wave.sound_speed(wave.end_strain)) * (t - 5e-3))
    front = float(wave.sound_speed(run.e0)) * t
    s = rear + (front - rear) * np.linspace(0.1, 0.9, 41)
    assert residuals(wave, tension, s, t) < 2e-5
    # Shown a wrong wave, the check fails: the field of a line 2 % heavier.
    heavy = ramped_release(tension, 1.02 * MASS, 5e-3, tension0=run.T0, derivative=slope)
    assert residuals(heavy, tension, s, t) > 5e-3


@pytest.mark.parametrize(("run", "t"), [(RUN1, 0.03), (RUN2, 3e-3), (RUN3, 0.04), (RUN4, 4.8e-3)])
def test_momentum_and_length(run, t):
    wave = ramped_release(tension, MASS, 5e-3, tension0=run.T0, derivative=slope)
    front = float(wave.sound_speed(run.e0)) * t
    # m integral w ds = integral of (T0 - F) dt, with integral of cos^2 by hand.
    x = min(t / 5e-3, 1.0)
    lost = run.T0 * (t - 5e-3 * (0.5 * x + np.sin(np.pi * x) / (2 * np.pi)))
    momentum = MASS * gauss(lambda s: wave.velocity(s, t), 0.0, front, 200)
    assert momentum == pytest.approx(lost, rel=1e-6)
    # integral (e0 - e) ds = displacement of the end.
    shortened = gauss(lambda s: run.e0 - wave.strain(s, t), 0.0, front, 200)
    moved = gauss(wave.end_velocity, 0.0, min(t, 5e-3), 200) + wave.end_speed * max(t - 5e-3, 0)
    assert shortened == pytest.approx(moved, rel=1e-6)
    # Neither holds for the linear line of the same front speed.
    c0 = float(wave.sound_speed(run.e0))
    linear = LinearRelease(1e3, MASS * c0**2, MASS, run.T0, 5e-3)
    wrong = gauss(lambda s: linear.velocity(s, t), 0.0, front, 200)
    assert abs(wrong / (moved * c0) - 1.0) > 0.01


def test_linear_law_is_dalembert():
    EA, mass, e0 = 1e6, 1.0, 0.05
    wave = ramped_release(
        lambda e: EA * e, mass, 5e-3, strain0=e0, derivative=lambda e: EA + 0.0 * e
    )
    line = LinearRelease(100.0, EA, mass, EA * e0, 5e-3)
    s, t = np.linspace(0.0, 60.0, 121), 0.05
    assert wave.velocity(s, t) == pytest.approx(line.velocity(s, t), abs=1e-9)
    assert wave.tension(s, t) == pytest.approx(line.tension(s, t), abs=1e-6)
    assert wave.end_valid_until(100.0) == pytest.approx(0.2, rel=1e-9)
    assert wave.shock_time == np.inf


def test_stiffer_table_segment_below_is_a_shock_at_once():
    e, T = [0.0, 0.1, 0.2], [0.0, 30.0, 40.0]
    wave = ramped_release(lambda x: np.interp(x, e, T), 1.0, 2.0, strain0=0.2, knots=e)
    # T = 30 of 40 N is reached where cos^2 = 3/4: a third of the ramp.
    assert (wave.shock_time, wave.shock_place) == pytest.approx((2.0 / 3.0, 0.0))
    # The stiffer segment above is a fan instead: no shock.
    wave = ramped_release(lambda x: np.interp(x, e, [0, 10, 40]), 1.0, 2.0, strain0=0.2, knots=e)
    assert wave.shock_time == np.inf


@pytest.mark.parametrize("run", [RUN2, RUN4])
def test_end_valid_until_by_integrating_the_characteristic(run):
    wave = ramped_release(tension, MASS, 5e-3, tension0=run.T0, derivative=slope)
    if run is RUN2:
        start, place = LENGTH / run.c0, LENGTH
        strain = wave.strain
    else:
        start, place = wave.shock_time, wave.shock_place

        def strain(s, t):  # between the end and the shock the simple wave goes on
            label = np.linspace(0.0, 5e-3, 4001)
            e = wave.end_strain_history(label)
            behind = label >= wave.shock_label
            s_of = np.sqrt(slope(e) / MASS) * (t - label)
            at = np.interp(-s, -s_of[behind], e[behind])
            return np.where(s <= s_of[-1], wave.end_strain, at)

    def backwards(t, s):
        return -np.sqrt(slope(strain(np.maximum(s, 0.0), t)) / MASS)

    def home(t, s):
        return s[0]

    home.terminal = True
    path = solve_ivp(backwards, (start, 1.0), [place], events=home, rtol=1e-8, atol=1e-8)
    assert wave.end_valid_until(LENGTH) == pytest.approx(path.t_events[0][0], rel=1e-5)


def test_errors():
    wave = ramped_release(tension, MASS, 5e-3, tension0=RUN4.T0)
    with pytest.raises(ValueError, match=r"shock forms at t = 0\.0051875"):
        wave.strain(1.0, 6e-3)
    with pytest.raises(ValueError, match="negative"):
        wave.strain(-1.0, 1e-3)
    with pytest.raises(ValueError, match="positive length"):
        wave.end_valid_until(-2.0)
    with pytest.raises(ValueError, match="positive ramp"):
        ramped_release(tension, MASS, 0.0, tension0=1e5)
    with pytest.raises(ValueError, match="positive mass"):
        ramped_release(tension, -1.0, 1.0, tension0=1e5)
    with pytest.raises(ValueError, match="falls at"):
        ramped_release(lambda e: e + 0.05 * np.sin(40 * e), 1.0, 1.0, strain0=0.5)
