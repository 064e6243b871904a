"""How rigid bodies move: what is written down beside what jax finds by following place and mass."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.rigid import place_of, point_rate, rigid_mass, turning_force

RANDOM = np.random.default_rng(5)
KINDS = [(1, 0), (2, 1), (3, 3)]  # dimensions, angles


def motion(d, angles):
    """Coordinates, their rates, a point of the body, its masses along its axes and its inertias."""
    q, v = RANDOM.normal(size=(2, d + angles))
    point, inertia = RANDOM.normal(size=d), RANDOM.uniform(1.0, 5.0, size=angles)
    return q, v, point, RANDOM.uniform(1.0, 9.0, size=d), inertia


@pytest.mark.parametrize(("d", "angles"), KINDS)
def test_a_point_moves_as_its_place_does(d, angles):
    for _ in range(5):
        q, v, point, _, _ = map(jnp.asarray, motion(d, angles))

        def jacobian(at, point=point):
            return jax.jacfwd(place_of)(at, point)

        matrix, change = jax.jvp(jacobian, (q,), (v,))
        found = point_rate(q, v, point)
        for x, exact in zip(found, (matrix, matrix @ v, change @ v), strict=True):
            assert x == pytest.approx(np.asarray(exact), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(("d", "angles"), KINDS)
def test_velocity_terms_are_those_of_lagranges_equation(d, angles):
    for _ in range(5):
        q, v, _, *masses = map(jnp.asarray, motion(d, angles))

        def kinetic(at, v=v, masses=masses):
            return 0.5 * v @ rigid_mass(at, *masses) @ v

        change = jax.jvp(lambda at, m=masses: rigid_mass(at, *m), (q,), (v,))[1] @ v
        exact = np.asarray(change - jax.grad(kinetic)(q))
        assert turning_force(q, v, *masses) == pytest.approx(exact, rel=1e-11, abs=1e-12)


def test_a_thrown_body_keeps_momentum_and_energy():
    # no force: a body that tumbles, its masses alike along its axes, by the equations with these terms
    def slope(y):
        q, v = y
        mass = rigid_mass(q, translation, inertia)
        return v, -jnp.linalg.solve(mass, turning_force(q, v, translation, inertia))

    translation, inertia = jnp.full(3, 2.0), jnp.array([1.0, 2.0, 3.0])
    q, v = jnp.zeros(6), jnp.array([1.0, 2.0, 3.0, 0.7, 0.1, -0.4])
    dt, y = 1e-3, (q, v)

    @jax.jit
    def step(y):
        move = lambda y, k, h: jax.tree.map(lambda a, b: a + h * b, y, k)  # noqa: E731
        a = slope(y)
        b = slope(move(y, a, dt / 2))
        c = slope(move(y, b, dt / 2))
        d = slope(move(y, c, dt))
        total = jax.tree.map(lambda a, b, c, d: (a + 2 * b + 2 * c + d) / 6, a, b, c, d)
        return move(y, total, dt)

    for _ in range(1000):
        y = step(y)
    first, last = (0.5 * v @ rigid_mass(q, translation, inertia) @ v for q, v in ((q, v), y))
    assert float(last) == pytest.approx(float(first), rel=1e-10)
    assert np.asarray(y[1][:3]) == pytest.approx([1.0, 2.0, 3.0], rel=1e-12)
