"""Operations on arrays that are written so that they fit into loops with others."""

import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["dot", "least", "most", "root", "size", "unit"]


def dot(a: Float[Array, "d *n"], b: Float[Array, "d *n"]) -> Float[Array, "*n"]:
    """a . b of each column, d being 1 to 3.

    Written out: a reduction would be a loop of its own, between loops that could be one.
    """
    return sum((a[k] * b[k] for k in range(1, a.shape[0])), a[0] * b[0])


def size(vector: Float[Array, "d *n"]) -> Float[Array, "*n"]:
    """Euclidean norm along the first axis; its derivative at zero is zero, not NaN."""
    return root(dot(vector, vector))


def unit(vector: Float[Array, "d *n"]) -> Float[Array, "d *n"]:
    """The vectors along the first axis at the length 1, and 0 where they are 0."""
    long = size(vector)
    return jnp.where(long > 0.0, vector / jnp.where(long > 0.0, long, 1.0), 0.0)


def root(square: Float[Array, "..."]) -> Float[Array, "..."]:
    """The square root, and 0 with derivative 0 where there is none or its slope is infinite."""
    zero = square <= 0.0
    return jnp.where(zero, 0.0, jnp.sqrt(jnp.where(zero, 1.0, square)))


def least(a: Float[Array, "..."] | float, b: Float[Array, "..."] | float) -> Float[Array, "..."]:
    """min(a, b), and b where a is NaN: `jnp.minimum` looks for NaN in both, which costs a third more.

    For values of which a NaN shows elsewhere.
    """
    return jnp.where(a < b, a, b)


def most(a: Float[Array, "..."] | float, b: Float[Array, "..."] | float) -> Float[Array, "..."]:
    """max(a, b), and b where a is NaN; see `least`."""
    return jnp.where(a > b, a, b)
