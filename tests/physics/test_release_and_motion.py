"""What ends do: the force that decays while a line breaks, and paths that ends are moved along."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.motion import Harmonic, Recorded, Still, velocity_of
from lumpedcable.physics.ramp import release_ramp


def ramp(t, start, time):
    return float(release_ramp(jnp.asarray(t), jnp.asarray(start), jnp.asarray(time)))


@pytest.mark.parametrize(
    ("share", "held"),
    [(-1.0, 1.0), (0.0, 1.0), (1 / 3, 0.75), (0.5, 0.5), (2 / 3, 0.25), (1.0, 0.0)],
)
def test_the_ramp_is_a_squared_cosine(share, held):
    # Zhu, Yin & Shen 2018, eq. 7: cos^2(pi t / 2 t_br); cos^2 30 deg = 3/4, cos^2 60 deg = 1/4
    assert ramp(0.02 + share * 5e-3, 0.02, 5e-3) == pytest.approx(held, abs=1e-12)


def test_a_break_without_duration_is_a_step():
    assert ramp(0.02, 0.02, 0.0) == 0.0
    assert ramp(0.02 - 1e-15, 0.02, 0.0) == 1.0
    assert ramp(1.0, 0.02, 0.0) == 0.0
    # and what a ramp tends to as it gets shorter
    assert ramp(0.02 + 1e-12, 0.02, 1e-12) == 0.0
    assert ramp(0.0199, 0.02, 1e-12) == 1.0


def test_the_ramp_has_finite_derivatives_everywhere():
    for time in (0.0, 5e-3):
        for t in (-np.inf, 0.0, 0.02, 0.021, 0.025, 0.03):  # statics look long before the start
            for way in (jax.jacrev, jax.jacfwd):
                slopes = way(release_ramp, argnums=(0, 1, 2))(
                    jnp.asarray(t), jnp.asarray(0.02), jnp.asarray(time)
                )
                assert np.all(np.isfinite(slopes))
    # in the middle the slope is -pi / (2 t_br)
    middle = jax.grad(release_ramp)(jnp.asarray(0.0225), jnp.asarray(0.02), jnp.asarray(5e-3))
    assert float(middle) == pytest.approx(-np.pi / (2 * 5e-3), rel=1e-12)


MEAN = jnp.asarray([1.0, -2.0, 3.0])
DRIFT = jnp.asarray([0.5, 0.0, -0.1])
SWAY = jnp.asarray([0.2, 0.3, 0.4])


def paths():
    period, phase = jnp.asarray(7.0), jnp.asarray(0.6)
    t = np.array([0.0, 0.5, 1.1, 2.0, 3.5])
    record = np.stack([np.sin(t), t**2, 0.0 * t], axis=1)
    return {
        "still": Still(MEAN),
        "drift": Harmonic(MEAN, velocity=DRIFT),
        "sway": Harmonic(MEAN, amplitude=SWAY, period=period, phase=phase),
        "both": Harmonic(MEAN, DRIFT, SWAY, period, phase),
        "slow start": Harmonic(MEAN, DRIFT, SWAY, period, phase, jnp.asarray(2.0)),
        "recorded": Recorded(jnp.asarray(t), jnp.asarray(record)),
    }


@pytest.mark.parametrize("path", paths().values(), ids=paths().keys())
def test_velocity_is_the_derivative_of_the_place(path):
    h = 1e-6
    for t in (0.3, 0.77, 1.5, 2.9, 3.2):
        slope = (path.position(jnp.asarray(t + h)) - path.position(jnp.asarray(t - h))) / (2 * h)
        np.testing.assert_allclose(velocity_of(path, jnp.asarray(t)), slope, atol=2e-8)


def test_harmonic_motion_is_what_the_scene_language_says():
    # x = position + velocity t + amplitude sin(2 pi t / period + phase)
    t = 1.234
    found = paths()["both"].position(jnp.asarray(t))
    swing = np.sin(2 * np.pi * t / 7.0 + 0.6)
    expected = np.asarray(MEAN) + np.asarray(DRIFT) * t + np.asarray(SWAY) * swing
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_motion_that_grows_starts_at_rest_in_the_middle():
    path = paths()["slow start"]
    np.testing.assert_array_equal(path.position(jnp.asarray(0.0)), MEAN)
    np.testing.assert_allclose(velocity_of(path, jnp.asarray(0.0)), 0.0, atol=1e-15)
    full = paths()["both"]
    for t in (2.0, 3.3):
        behind = full.position(jnp.asarray(t)) - path.position(jnp.asarray(t))
        np.testing.assert_allclose(behind, DRIFT * 1.0)  # half of the ramp of 2 s


def test_an_end_that_gathers_way_is_never_faster_than_its_speed():
    path = Harmonic(MEAN, velocity=DRIFT, ramp=jnp.asarray(2.0))
    t = jnp.linspace(0.0, 3.0, 61)
    found = jax.vmap(lambda t: velocity_of(path, t))(t)
    share = np.sin(0.25 * np.pi * np.minimum(t, 2.0)) ** 2
    np.testing.assert_allclose(found, share[:, None] * DRIFT, atol=1e-14)


class TestRecorded:
    path = paths()["recorded"]

    def test_goes_through_the_record(self):
        for t, place in zip(self.path.time, self.path.record, strict=True):
            np.testing.assert_allclose(self.path.position(t), place, atol=1e-14)

    def test_rests_before_it(self):
        before = jnp.asarray(-3.0)
        np.testing.assert_array_equal(self.path.position(before), self.path.record[0])
        np.testing.assert_array_equal(velocity_of(self.path, before), 0.0)

    def test_goes_on_behind_it_as_between_its_last_rows(self):
        (*_, a, b), (*_, x, y) = self.path.time, self.path.record
        slope = (y - x) / (b - a)
        for late in (1e-3, 6.5):
            place = self.path.position(b + late)
            np.testing.assert_allclose(place, y + late * slope, rtol=1e-14)
            np.testing.assert_allclose(velocity_of(self.path, b + late), slope, rtol=1e-12)

    def test_moves_at_the_record_s_own_slope_at_its_points(self):
        slopes = np.gradient(np.asarray(self.path.record), np.asarray(self.path.time), axis=0)
        for t, slope in zip(self.path.time, slopes, strict=True):
            np.testing.assert_allclose(velocity_of(self.path, t), slope, atol=1e-12)

    def test_has_no_jumps_in_velocity_inside(self):
        for t in self.path.time[1:-1]:
            before, after = (velocity_of(self.path, t + h) for h in (-1e-9, 1e-9))
            np.testing.assert_allclose(before, after, atol=1e-6)

    def test_follows_a_parabola_exactly(self):
        # slopes by the second-order difference formula are exact for t^2, also at uneven times
        for t in (0.6, 1.5, 1.99):
            assert float(self.path.position(jnp.asarray(t))[1]) == pytest.approx(t**2, rel=1e-12)
