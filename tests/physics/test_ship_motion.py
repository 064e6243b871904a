"""Motions of ships and of points on them: rotations, records, and seas of known spectra."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.motion import Recorded, velocity_of
from lumpedcable.physics.ramp import growth
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.sea import GRAVITY, SeaState, jonswap
from lumpedcable.physics.ships import (
    HarmonicBody,
    PointOfBody,
    RecordedBody,
    SeaBody,
    Swing,
)

HEAVE, ROLL = 2, 3
EYE, ORIGIN = jnp.eye(3), jnp.zeros(3)


def number(value):
    return jnp.asarray(value, float)


def swing(freedom, amplitude, period, phase=0.0):
    return Swing(freedom, number(amplitude), number(period), number(phase))


def test_turns_are_roll_then_pitch_then_yaw_about_fixed_axes():
    turn = np.array([0.3, -0.2, 1.1])
    expected = Rotation.from_euler("xyz", turn).as_matrix()
    np.testing.assert_allclose(rotation(jnp.asarray(turn)), expected, atol=1e-15)


def test_a_post_goes_on_an_arc_as_its_ship_rolls_and_heaves():
    # Gao et al. 2022, eq. 19-20, class 5 of table 1; a post of 12 m, 5 m to the side of the axis
    heave, roll = swing(HEAVE, 1.6, 9.4), swing(ROLL, np.deg2rad(2.899), 8.0, 0.4)
    post = jnp.asarray([3.0, 5.0, 12.0])
    path = PointOfBody(HarmonicBody((heave, roll)), jnp.asarray([1.0, 2.0, 0.5]), post, EYE, ORIGIN)
    t = 3.1
    angle = np.deg2rad(2.899) * np.sin(2 * np.pi * t / 8.0 + 0.4)
    c, s = np.cos(angle), np.sin(angle)
    z = 0.5 + 1.6 * np.sin(2 * np.pi * t / 9.4) + 5.0 * s + 12.0 * c
    np.testing.assert_allclose(
        path.position(number(t)), [4.0, 2.0 + 5.0 * c - 12.0 * s, z], atol=1e-14
    )


def test_a_ramp_starts_at_rest_and_ends_in_the_full_motion():
    full = HarmonicBody((swing(HEAVE, 1.0, 8.0, 0.7),))
    eased = HarmonicBody(full.swings, number(4.0))
    path = PointOfBody(eased, ORIGIN, ORIGIN, EYE, ORIGIN)
    assert np.all(np.asarray(path.position(number(0.0))) == 0.0)
    assert np.all(np.asarray(velocity_of(path, number(0.0))) == 0.0)
    np.testing.assert_allclose(eased.freedoms(number(6.0)), full.freedoms(number(6.0)))


def eased_sea(ramp=12.0):
    """Heave and roll in the same sea, at once and growing over `ramp` (s)."""
    table = jnp.asarray([0.01, 10.0])
    response = {HEAVE: jnp.asarray([[2.0, 0.3]] * 2), ROLL: jnp.asarray([[0.05, -0.4]] * 2)}
    state = SeaState.of(*map(number, (3.0, 9.0, 3.3)), 5, 40)
    numbers = (state, number(20.0), table, response)
    return SeaBody.of(*numbers), SeaBody.of(*numbers, ramp=number(ramp))


def test_a_motion_in_a_sea_starts_at_rest_where_it_has_a_ramp():
    full, eased = eased_sea()
    where = (jnp.asarray([1.0, 2.0, 3.0]), jnp.asarray([4.0, 5.0, 6.0]), EYE, ORIGIN)
    at_once, path = PointOfBody(full, *where), PointOfBody(eased, *where)
    zero = number(0.0)
    assert float(jnp.linalg.norm(velocity_of(at_once, zero))) > 0.1
    np.testing.assert_array_equal(velocity_of(path, zero), 0.0)
    np.testing.assert_array_equal(path.position(zero), [5.0, 7.0, 9.0])


def test_a_motion_in_a_sea_grows_as_a_swing_does():
    full, eased = eased_sea()
    swings = HarmonicBody((swing(HEAVE, 1.0, 7.0, 1.0),))
    grown = HarmonicBody(swings.swings, number(12.0))
    for t in map(number, (0.5, 3.0, 6.0, 11.0)):
        share = float(grown.freedoms(t)[HEAVE] / swings.freedoms(t)[HEAVE])
        assert share == pytest.approx(np.sin(0.5 * np.pi * float(t) / 12.0) ** 2, rel=1e-12)
        assert share == pytest.approx(float(growth(t, number(12.0))), rel=1e-12)
        np.testing.assert_allclose(eased.freedoms(t), share * full.freedoms(t), rtol=1e-12)
    for t in map(number, (12.0, 12.5, 90.0)):
        np.testing.assert_array_equal(eased.freedoms(t), full.freedoms(t))


@pytest.mark.parametrize("t", [0.0, 0.7, 6.0, 11.9, 12.0, 30.0])
def test_the_speed_of_a_growing_motion_is_that_of_its_places(t):
    path = PointOfBody(eased_sea()[1], ORIGIN, jnp.asarray([4.0, 5.0, 6.0]), EYE, ORIGIN)
    h = 1e-4
    before, after = (path.position(number(t + s)) for s in (-h, h))
    # differences are off by h^2 / 6 of the third derivative, below 100 m/s3 with w up to 4 wp = 2.8 /s,
    # and by rounding over h; the acceleration has no jump at either end of the ramp but r'' a / 2
    rate = np.asarray(velocity_of(path, number(t)))
    np.testing.assert_allclose((after - before) / (2 * h), rate, rtol=0, atol=2e-5)


def test_a_record_goes_through_its_values():
    time = np.linspace(0.0, 10.0, 41)
    table = np.zeros((41, 6))
    table[:, HEAVE], table[:, ROLL] = np.sin(time), 0.1 * np.cos(time)
    body = RecordedBody(Recorded(jnp.asarray(time), jnp.asarray(table)))
    for k in (0, 7, 40):
        np.testing.assert_allclose(body.freedoms(number(time[k])), table[k], atol=1e-14)
    # between them a cubic of slopes by differences: error h^2 / 6 of the slope's, h = 0.25 s
    assert float(body.freedoms(number(3.1))[HEAVE]) == pytest.approx(np.sin(3.1), abs=2e-3)


def sea(period=9.0, gamma=1.0, components=4000, way=0.0, seed=1, phase=0.0, height=3.0):
    table = jnp.asarray([0.01, 10.0])
    response = {HEAVE: jnp.asarray([[2.0, phase], [2.0, phase]])}
    numbers = [number(v) for v in (height, period, gamma)]
    return sea_of(*numbers, seed, components, number(way), table, response)


@partial(jax.jit, static_argnums=(3, 4))  # one program instead of one an operation
def sea_of(height, period, gamma, seed, components, way, table, response):
    return SeaBody.of(SeaState.of(height, period, gamma, seed, components), way, table, response)


def test_a_sea_carries_the_energy_of_its_height():
    # variance of the surface (Hs/4)^2; a response of 2 m/m makes heave's four times that
    for components in (1, 20, 400):
        body = sea(components=components)
        variance = np.sum(np.asarray(body.amplitude) ** 2) / 2
        assert variance == pytest.approx((3.0 / 4) ** 2, rel=1e-12)
        moved = np.asarray(body.cosine[HEAVE]) ** 2 + np.asarray(body.sine[HEAVE]) ** 2
        np.testing.assert_allclose(moved, 4.0, rtol=1e-12)


def test_a_fully_developed_sea_has_its_energy_where_the_integral_puts_it():
    # w^-5 exp(-5/4 (wp/w)^4) has the integral exp(-5/4 (wp/w)^4) below w: 28.65 % below the peak,
    # 92.5 % below twice it; the components reach to 4 wp, beyond which 0.5 % is left out
    body, peak = sea(), 2 * np.pi / 9.0
    energy, omega = np.asarray(body.amplitude) ** 2, np.asarray(body.omega)
    whole = np.exp(-1.25 / 4.0**4)
    for ratio in (1.0, 2.0):
        below = np.sum(energy[omega < ratio * peak]) / np.sum(energy)
        assert below == pytest.approx(np.exp(-1.25 / ratio**4) / whole, abs=2e-3)


@pytest.mark.parametrize("gamma", [1.0, 3.3, 7.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_sea_of_one_component_is_a_sine_of_its_period(gamma, seed):
    body = sea(period=10.0, gamma=gamma, components=1, seed=seed)
    assert np.asarray(body.omega) == pytest.approx([2 * np.pi / 10.0], rel=1e-12)
    # a sine of amplitude a has the standard deviation a / sqrt(2)
    assert np.asarray(body.amplitude) == pytest.approx([np.sqrt(2.0) * 3.0 / 4.0], rel=1e-12)


@pytest.mark.parametrize("components", [2, 5, 20, 35])
def test_few_components_stand_where_the_energy_is(components):
    # as above, the share of energy below r wp is exp(-5/4 r^-4) over that below 4 wp
    body, peak = sea(components=components), 2 * np.pi / 9.0
    ratio = np.asarray(body.omega) / peak
    at_peak = np.isclose(ratio, 1.0, rtol=1e-12)
    assert np.sum(at_peak) == 1
    share = np.exp(-1.25 / ratio**4) / np.exp(-1.25 / 4.0**4)
    band = np.arange(components) / components
    assert np.all((share > band - 1e-5) & (share < band + 1.0 / components + 1e-5))
    np.testing.assert_allclose(body.amplitude, 0.75 * np.sqrt(2.0 / components), rtol=1e-12)


def test_the_seas_of_more_components_have_one_in_each_of_equal_bands():
    ratio = np.asarray(sea(components=100).omega) * 9.0 / (2 * np.pi)
    band = 0.4 + 0.036 * np.arange(101)
    assert np.all((ratio >= band[:-1]) & (ratio <= band[1:]))


def test_the_peak_of_jonswap_is_enhanced_by_gamma():
    omega = jnp.asarray([0.7, 1.4, 2.1]) * 2 * np.pi / 9.0 / 1.4
    ratio = jonswap(omega, number(9.0), number(3.3)) / jonswap(omega, number(9.0), number(1.0))
    # at w = wp/2 and 3/2 wp the bump is exp(-0.25 / (2 s^2)): 8e-12 and 2e-7
    np.testing.assert_allclose(ratio, [1.0, 3.3, 1.0], rtol=1e-6)


def test_one_sea_reaches_a_ship_downwind_later():
    # one component of frequency w: a way x later by w x / g
    near, far = sea(components=1), sea(components=1, way=50.0)
    omega = float(near.omega[0])
    for t in (0.0, 3.3):
        late = t + omega * 50.0 / GRAVITY
        assert float(far.freedoms(number(late))[HEAVE]) == pytest.approx(
            float(near.freedoms(number(t))[HEAVE]), abs=1e-9
        )


def test_a_phase_of_the_response_leads():
    plain, turned = sea(components=1), sea(components=1, phase=np.pi / 2)
    quarter = np.pi / 2 / float(plain.omega[0])
    assert float(turned.freedoms(number(1.0))[HEAVE]) == pytest.approx(
        float(plain.freedoms(number(1.0 + quarter))[HEAVE]), abs=1e-9
    )


def test_a_seed_gives_one_sea():
    a, b, c = sea(components=10), sea(components=10), sea(components=10, seed=2)
    np.testing.assert_array_equal(a.phase, b.phase)
    assert not np.allclose(a.phase, c.phase)


def test_on_shallow_water_a_sea_takes_longer_to_a_ship_downwind():
    depth, way = number(8.0), 50.0
    state = SeaState.of(number(3.0), number(9.0), number(1.0), 1, 1, depth)
    table, response = jnp.asarray([0.01, 10.0]), {HEAVE: jnp.asarray([[2.0, 0.0]] * 2)}
    near, far = (SeaBody.of(state, number(x), table, response) for x in (0.0, way))
    # T = 9 s on 8 m: L = g T^2 / (2 pi) tanh(2 pi 8 / L), 73.5 m
    length = 73.5
    for _ in range(100):
        length = GRAVITY * 9.0**2 / (2 * np.pi) * np.tanh(2 * np.pi * 8.0 / length)
    late = number(1.3 + 9.0 * way / length)
    assert 60.0 < length < 90.0
    assert float(far.freedoms(late)[HEAVE]) == pytest.approx(
        float(near.freedoms(number(1.3))[HEAVE]), abs=1e-9
    )
