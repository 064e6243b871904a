"""Functions that may be differentiated once, in every way that jax has, and no second time."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.fitting.once import differentiable_once

X = jnp.array([1.0, 2.0])
SLOPES = 3.0 * X**2


@jax.jit
def cubes(x):
    return jnp.sum(differentiable_once(x) ** 3)


FIRST = {
    "forward": jax.jacfwd(cubes),
    "backward": jax.jacrev(cubes),
    "compiled": jax.jit(jax.grad(cubes)),
    "many": lambda x: jax.vmap(jax.grad(cubes))(jnp.stack([0.0 * x, x]))[1],
    "linearised": lambda x: jax.vmap(jax.linearize(cubes, x)[1])(jnp.eye(2)),
    "gone through again": jax.grad(jax.checkpoint(cubes)),
    "by the change": lambda x: jax.grad(lambda t: jax.jvp(cubes, (x,), (t,))[1])(x),
    "in a loop": lambda x: jax.lax.scan(lambda c, _: (c, jax.grad(cubes)(c)), x, None, 2)[1][1],
}


@pytest.mark.parametrize("way", FIRST)
def test_first_derivatives_are_what_they_were(way):
    assert cubes(X) == 9.0
    np.testing.assert_allclose(FIRST[way](X), SLOPES, rtol=1e-15)


@pytest.mark.parametrize("outer", [jax.jacfwd, jax.jacrev])
@pytest.mark.parametrize("way", FIRST)
def test_second_derivatives_are_refused(way, outer):
    with pytest.raises(NotImplementedError, match="expected first derivatives"):
        outer(FIRST[way])(X)
