"""Cargo on an ideal cable against an independent calculation, an ODE solution and limits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lumpedcable.exact import IdealHighline

# Gao et al. 2022, section 2.1: 5 m, 1000 kg, 40 kN; numbers of an independent calculation
SHORT = IdealHighline(5.0, 40e3, 1000.0, 9.81)


def test_the_five_metre_case():
    # sin of the slope at rest is m g / (2 T), so sag = a tan; small digits from that calculation
    slope = 9810.0 / 80e3
    assert -SHORT.height() == pytest.approx(2.5 * slope / np.sqrt(1 - slope**2), rel=1e-12)
    assert -SHORT.height() == pytest.approx(0.3088936971, abs=1e-10)
    assert SHORT.stiffness() == pytest.approx((477.5490677, 31280.94939), rel=1e-9)
    assert SHORT.periods() == pytest.approx((9.092239512, 1.123414191), rel=1e-9)


def test_the_five_metre_case_let_go_from_straight():
    assert -SHORT.lowest(0.0) == pytest.approx(0.6224852425, rel=1e-9)
    assert SHORT.top_speed(0.0) == pytest.approx(1.7374606, rel=1e-7)
    assert SHORT.period_from(0.0) == pytest.approx(1.12661394, rel=1e-8)
    # small oscillations are the limit
    near = SHORT.height() + 1e-3
    assert SHORT.period_from(near) == pytest.approx(SHORT.periods()[1], rel=1e-5)


@pytest.mark.parametrize("up", [0.0, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3])
def test_a_small_swing_has_the_period_of_small_oscillations(up):
    # 3.891621 s from the stiffness 2 T cos^3/(l/2) with sin = m g/(2 T), as far as the swing is small:
    # the next term goes with the square of swing over sag
    case = IdealHighline(60.0, 80e3, 2000.0, 9.81)
    cosine = np.sqrt(1.0 - (2000.0 * 9.81 / 160e3) ** 2)
    period = 2.0 * np.pi * np.sqrt(2000.0 / (2.0 * 80e3 * cosine**3 / 30.0))
    assert period == pytest.approx(3.891621, abs=1e-6)
    start = case.height() + up
    assert case.period_from(start) == pytest.approx(period, rel=1e-8)
    # as far below as above, to first order, and as quick as the harmonic swing
    assert case.height() - case.lowest(start) == pytest.approx(up, rel=1e-3, abs=1e-14)
    assert case.top_speed(start) == pytest.approx(2.0 * np.pi / period * up, rel=1e-3, abs=1e-14)


def test_what_is_lost_is_a_difference_of_potentials():
    case = IdealHighline(60.0, 80e3, 2000.0, 9.81, place=20.0, rise=4.0)
    start = case.height() + 30.0
    drop = case.potential(start) - case.potential(case.height())
    assert case.top_speed(start) == pytest.approx(np.sqrt(2.0 * drop / 2000.0), rel=1e-10)
    assert case.potential(case.lowest(start)) == pytest.approx(case.potential(start), rel=1e-12)


@pytest.mark.parametrize(
    ("depth", "inertia", "periods"),
    [
        (0.5, 200.0, (9.204338652, 1.253295275, 1.123414283)),
        (1.0, 667.0, (9.317809508, 1.598694342, 1.123414283)),
        (1.35, 1000.0, (9.396358674, 1.670667138, 1.123414283)),
    ],
)
def test_a_body_that_swings_under_its_trolley(depth, inertia, periods):
    # the independent calculation linearised by differences: 1e-7
    assert SHORT.hung_periods(depth, inertia) == pytest.approx(periods, rel=2e-6)


def test_the_period_is_that_of_the_motion():
    case = IdealHighline(60.0, 80e3, 2000.0, 9.81, place=45.0, rise=0.4)
    start = case.height() + 1.5

    def rate(_, y):
        return [y[1], case.lift(y[0]) / case.mass - case.gravity]

    def back(t, y):
        return y[1] if t > 1e-6 else -1.0

    back.direction = -1
    found = solve_ivp(
        rate, (0, 30), [start, 0], "DOP853", events=back, rtol=1e-12, atol=1e-12, max_step=0.1
    )
    assert found.t_events[0][0] == pytest.approx(case.period_from(start), rel=1e-9)
    assert np.min(found.y[0]) == pytest.approx(case.lowest(start), abs=1e-3)


def test_calm_water_heights_of_the_transfer():
    # Gao et al. 2022, section 2.2: posts of 4.8 m and 5.2 m, 2000 kg; an independent calculation of
    # the height over the receiver's deck at 15 m from its post, posts standing on level decks
    for span, tension, height in (
        (50.0, 80e3, 2.472536074), (60.0, 80e3, 2.300450643), (70.0, 60e3, 1.148511605),
        (70.0, 100e3, 2.777282129), (80.0, 80e3, 2.082580318),
    ):  # fmt: skip
        case = IdealHighline(span, tension, 2000.0, 9.81, place=span - 15.0, rise=0.4)
        assert 4.8 + case.height() == pytest.approx(height, abs=1e-9)


def test_cargo_off_the_span_or_too_heavy_is_refused():
    with pytest.raises(ValueError, match="between the posts"):
        IdealHighline(5.0, 40e3, 1000.0, 9.81, place=6.0)
    with pytest.raises(ValueError, match="half the weight"):
        IdealHighline(5.0, 4e3, 1000.0, 9.81)
    with pytest.raises(ValueError, match="above rest"):
        SHORT.lowest(-1.0)
