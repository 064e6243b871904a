"""Forces of Froude and Krylov on a box, against the pressure summed over its faces."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.sea import SeaState
from lumpedcable.physics.wave_pressure import PressedBox

L, B, T, ABOVE, WEIGHT = 50.0, 10.0, 3.0, 1.2, 1025 * 9.81
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(48)
HEADINGS = (0.0, 0.7, np.pi / 2, 2.5, -1.0)


def number(value):
    return jnp.asarray(value, float)


def sea_of(depth, period=6.0):
    return SeaState.of(
        number(1), number(period), number(3.3), 1, 4, None if depth is None else number(depth)
    )


def box_of(heading):
    return PressedBox(*map(number, (L, B, T, ABOVE, WEIGHT, heading)))


def summed(k, depth, heading, box=(L, B, T, ABOVE), weight=WEIGHT):
    """Force (N) and moment (N m) per metre of the wave, complex, of -p n over the wetted faces."""
    total = np.zeros(6, complex)
    half, above = np.array(box[:3]) / 2, box[3]
    for axis, side in ((0, 1), (0, -1), (1, 1), (1, -1), (2, -1)):
        a, b = (j for j in range(3) if j != axis)
        place = np.zeros((POINTS.size**2, 3))
        across = np.meshgrid(POINTS * half[a], POINTS * half[b], indexing="ij")
        place[:, a], place[:, b] = (values.ravel() for values in across)
        place[:, axis] = side * half[axis]
        place[:, 2] -= half[2]  # from the keel to the water
        area = np.outer(WEIGHTS * half[a], WEIGHTS * half[b]).ravel()
        x, y, z = place.T
        deep = np.exp(k * z) if depth is None else np.cosh(k * (depth + z)) / np.cosh(k * depth)
        p = weight * deep * np.exp(-1j * k * (x * np.cos(heading) + y * np.sin(heading)))
        outward = np.zeros(3)
        outward[axis] = side
        force = -(p * area)[:, None] * outward
        total[:3] += force.sum(axis=0)
        total[3:] += np.cross(place - [0.0, 0.0, above], force).sum(axis=0)
    return total


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("depth", [None, 60.0, 7.0])
def test_they_are_those_of_the_pressure_on_its_faces(depth, heading):
    sea = sea_of(depth)
    real, turned = map(np.asarray, box_of(heading).response(sea))
    assert np.abs(real[2]).max() > 1e5
    for k, found in zip(np.asarray(sea.number), (real + 1j * turned).T, strict=True):
        exact = summed(k, depth, heading)
        np.testing.assert_allclose(found[:3], exact[:3], atol=1e-9 * np.abs(exact[:3]).max())
        np.testing.assert_allclose(found[3:], exact[3:], atol=1e-9 * np.abs(exact[3:]).max())


def test_in_long_waves_it_is_lifted_and_carried_as_the_water_itself():
    # a metre of water on the area of its waterplane, and rho V a along the waves and up
    sea = sea_of(None, period=100.0)
    real, turned = map(np.asarray, box_of(0.7).response(sea))
    np.testing.assert_allclose(real[2], WEIGHT * L * B, rtol=0.02)
    slope = WEIGHT * L * B * T * np.asarray(sea.number)
    np.testing.assert_allclose(turned[0], slope * np.cos(0.7), rtol=0.02)
    np.testing.assert_allclose(turned[1], slope * np.sin(0.7), rtol=0.02)


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("depth", [pytest.param(None, marks=pytest.mark.slow), 12.0])
def test_they_have_their_derivatives(depth, heading):
    def response(x):
        sea = SeaState.of(
            number(1), x[0], number(3.3), 1, 3, None if depth is None else depth * x[6]
        )
        box = PressedBox(x[1] * L, x[2] * B, x[3] * T, x[4] * ABOVE, number(WEIGHT), heading + x[5])
        return jnp.concatenate(box.response(sea))

    x, h = jnp.array([6.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0]), 1e-5
    slopes = np.asarray(jax.jacfwd(response)(x))
    for j in range(x.size):
        step = h * jnp.eye(x.size)[j]
        about = np.asarray(response(x + step) - response(x - step)) / (2 * h)
        np.testing.assert_allclose(
            slopes[..., j], about, rtol=1e-6, atol=1e-7 * (1.0 + np.abs(slopes[..., j]).max())
        )
