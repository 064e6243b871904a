"""The water in Airy's waves: wave numbers, the surface, continuity, what is steady at the bed."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.sea import GRAVITY, SeaFlow, SeaState, SeaSurface, wave_numbers

HEADING = 0.6  # rad
WAY = jnp.asarray([np.cos(HEADING), np.sin(HEADING), 0.0])
UP = jnp.asarray([0.0, 0.0, 1.0])
SURFACE = 2.0  # m
PLACES = jnp.asarray([[3.0, -8.0, 40.0], [1.0, 5.0, -7.0], [1.5, -4.0, -20.0]])


def number(value):
    return jnp.asarray(value, float)


def flow(depth, components=7, ramp=None, height=1.2, ahead=4.0):
    deep = None if depth is None else number(depth)
    sea = SeaState.of(number(height), number(6.0), number(3.3), 3, components, deep)
    more = None if ramp is None else number(ramp)
    return SeaFlow(sea, WAY, number(ahead), UP, number(-SURFACE), more)


def one(what, t, place):
    """Velocity or acceleration (m/s, m/s2) at one place (m)."""
    return what.motion(number(t), place[:, None])[0][:, 0]


DEPTHS = [None, 30.0, 60.0]


@pytest.mark.parametrize("depth", [0.5, 5.0, 50.0, 5e3])
def test_wave_numbers_are_those_of_the_dispersion_relation(depth):
    omega = np.array([0.05, 0.4, 1.0, 3.0])
    found = wave_numbers(jnp.asarray(omega), number(depth))
    for w, k in zip(omega, found, strict=True):
        exact = brentq(
            lambda x, w=w: GRAVITY * x * np.tanh(x * depth) - w**2, 1e-9, 1e3, xtol=1e-15
        )
        assert float(k) == pytest.approx(exact, rel=1e-12)


def test_they_have_their_derivative_by_the_depth():
    omega, depth, step = jnp.asarray([0.4, 1.0]), number(12.0), 1e-4
    slope = jax.jvp(lambda h: wave_numbers(omega, h), (depth,), (number(1.0),))[1]
    about = (wave_numbers(omega, depth + step) - wave_numbers(omega, depth - step)) / (2 * step)
    np.testing.assert_allclose(slope, about, rtol=1e-6)


@pytest.mark.parametrize("depth", DEPTHS)
def test_no_water_appears_and_it_does_not_turn(depth):
    water = flow(depth)
    for place in PLACES.T:
        under = place.at[2].set(jnp.minimum(place[2], SURFACE - 0.1))
        gradient = jax.jacfwd(lambda x: one(water, 1.7, x))(under)
        scale = np.abs(np.asarray(gradient)).max()
        assert scale > 1e-3
        assert abs(float(jnp.trace(gradient))) < 1e-12 * max(scale, 1.0)
        np.testing.assert_allclose(gradient, gradient.T, atol=1e-12)


@pytest.mark.parametrize("depth", DEPTHS)
def test_accelerations_are_the_rates_of_velocities(depth):
    water = flow(depth)
    t = number(2.3)
    velocity, rate = jax.jvp(lambda s: water.motion(s, PLACES)[0], (t,), (number(1.0),))
    np.testing.assert_allclose(rate, water.motion(t, PLACES)[1], atol=1e-12)
    assert np.abs(velocity).max() > 0.2


@pytest.mark.parametrize("depth", DEPTHS)
def test_the_mean_surface_rises_as_the_waves_do(depth):
    water = flow(depth)
    sea, x = water.sea, np.array([11.0, -6.0, SURFACE])
    along = np.dot(WAY, x) + 4.0

    def eta(t):
        angle = np.asarray(sea.omega) * t - np.asarray(sea.number) * along + np.asarray(sea.phase)
        return np.sum(np.asarray(sea.amplitude) * np.cos(angle))

    step = 1e-5
    for t in (0.0, 4.1):
        rate = (eta(t + step) - eta(t - step)) / (2 * step)
        assert float(one(water, t, jnp.asarray(x))[2]) == pytest.approx(rate, abs=1e-8)


@pytest.mark.parametrize("depth", DEPTHS)
def test_the_surface_is_where_the_water_in_it_rises_to(depth):
    water = flow(depth, ahead=0.0)
    surface = SeaSurface(water.sea, number(HEADING), number(SURFACE))
    at = jnp.asarray([[11.0, -6.0, SURFACE], [-3.0, 20.0, SURFACE]])
    for t in (0.0, 4.1, 86400.0):
        rate = jax.jvp(lambda s: surface.height(s, at), (number(t),), (number(1.0),))[1]
        np.testing.assert_allclose(rate, water.motion(number(t), at.T)[0][2], atol=1e-9)
    # and on average where it was at rest, as high as it is said to be
    times = jnp.linspace(0.0, 20000.0, 40001)
    heights = jax.vmap(lambda t: surface.height(t, at[0]))(times)
    assert float(jnp.mean(heights)) == pytest.approx(SURFACE, abs=2e-3)
    assert 4.0 * float(jnp.std(heights)) == pytest.approx(1.2, rel=0.01)


def test_the_surface_grows_as_the_flow_does():
    water = flow(None, ramp=12.0, ahead=0.0)
    at = jnp.asarray([4.0, 9.0, -1.0])
    full = SeaSurface(water.sea, number(HEADING), number(SURFACE))
    slow = SeaSurface(water.sea, number(HEADING), number(SURFACE), number(12.0))
    for t, share in ((0.0, 0.0), (6.0, 0.5), (8.0, 0.75), (12.0, 1.0), (40.0, 1.0)):
        risen = float(full.height(number(t), at)) - SURFACE
        assert float(slow.height(number(t), at)) - SURFACE == pytest.approx(
            share * risen, abs=1e-14
        )


def test_at_the_bed_water_goes_to_and_fro_and_on_deep_water_it_rests_far_below():
    bed = jnp.asarray([5.0, 2.0, SURFACE - 30.0])
    low = one(flow(30.0), 0.7, bed)
    assert float(low[2]) == pytest.approx(0.0, abs=1e-15)
    assert float(jnp.abs(low[0])) > 1e-3
    np.testing.assert_allclose(one(flow(30.0), 0.7, bed - 5.0 * UP), low, atol=1e-15)
    assert np.abs(one(flow(None), 0.7, bed - 400.0 * UP)).max() < 1e-8


def test_above_the_mean_surface_water_moves_as_in_it():
    at = jnp.asarray([5.0, 2.0, SURFACE])
    for depth in DEPTHS:
        water = flow(depth)
        np.testing.assert_array_equal(one(water, 1.0, at), one(water, 1.0, at + 3.0 * UP))


def test_very_deep_water_is_deep_and_a_ramp_grows_as_squares_of_sines():
    deep, depth = flow(None), flow(2e3)
    for a, b in zip(
        deep.motion(number(3.0), PLACES), depth.motion(number(3.0), PLACES), strict=True
    ):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12)
    slow = flow(None, ramp=12.0)
    for t, share in ((0.0, 0.0), (6.0, 0.5), (8.0, 0.75), (12.0, 1.0), (40.0, 1.0)):
        for a, b in zip(
            deep.motion(number(t), PLACES), slow.motion(number(t), PLACES), strict=True
        ):
            np.testing.assert_allclose(share * a, b, atol=1e-14)


def test_single_precision_keeps_the_phase_of_a_sea_that_has_run_for_a_day():
    water, t = flow(30.0), number(86400.0)
    single = water.motion(t, PLACES.astype(jnp.float32))
    for a, b in zip(water.motion(t, PLACES), single, strict=True):
        assert b.dtype == jnp.float32
        np.testing.assert_allclose(a, b, atol=2e-6)
