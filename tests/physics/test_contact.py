"""The contact of a wheel with a line: in series with the kink, with the damping that it owes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.contact import Hertz, contact


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.2, 3.0])
def test_the_depth_is_that_of_two_springs_in_series(exponent):
    hertz = Hertz(jnp.asarray(3e7), jnp.asarray(exponent))
    for gap in (1e-9, 1e-5, 1e-3, 0.1, 2.0):
        for spring in (1e2, 1e5, 1e9):
            x = float(hertz.depth_of(jnp.asarray(gap), jnp.asarray(spring)))
            assert 0.0 < x <= gap
            pressed, bent = 3e7 * x**exponent, spring * (gap - x)
            assert pressed == pytest.approx(bent, rel=1e-6, abs=1e-9 * spring * gap)


def test_its_force_is_the_slope_of_its_energy():
    hertz = Hertz(jnp.asarray(4e6), jnp.asarray(1.5))
    nodes = jnp.stack([jnp.linspace(0.0, 2.0, 21), 0.01 * jnp.cos(jnp.linspace(0.0, 3.0, 21))])

    @jax.jit
    def energy(place):
        touch = contact(nodes, place, jnp.asarray(5e3), jnp.asarray(0.1), hertz)
        return touch.kink_energy + hertz.energy(touch.depth)

    for place in ([0.53, -0.02], [0.55, 0.1], [1.234, 0.03]):
        at = jnp.asarray(place)
        touch = jax.jit(contact)(nodes, at, jnp.asarray(5e3), jnp.asarray(0.1), hertz)
        # at the foot the energy does not change along the line: differences see the push alone
        h = 1e-6
        slope = [float(energy(at + h * e) - energy(at - h * e)) / (2 * h) for e in jnp.eye(2)]
        assert np.asarray(touch.push) == pytest.approx(slope, rel=1e-4, abs=1e-3)
        assert float(touch.depth) > 0.0


def test_damping_grows_as_the_step_function_says():
    hertz = Hertz(jnp.asarray(1e12), jnp.asarray(1.0), jnp.asarray(500.0), jnp.asarray(2e-3))
    # next to a stiff kink all of the gap is depth, next to a soft one nothing
    for x, step in ((0.0, 0.0), (1e-3, 0.5), (2e-3, 1.0), (9e-3, 1.0)):
        drag = float(hertz.drag(jnp.asarray(x), jnp.asarray(1e18)))
        assert drag == pytest.approx(500 * step, rel=1e-5)
    assert float(hertz.drag(jnp.asarray(1e-3), jnp.asarray(1e6))) < 1e-9
    assert jax.grad(hertz.energy)(jnp.asarray(1e-3)) == pytest.approx(1e9)
