"""Products of vectors that stand in the columns of an array."""

from jaxtyping import Array, Float

__all__ = ["dot"]


def dot(a: Float[Array, "d *n"], b: Float[Array, "d *n"]) -> Float[Array, "*n"]:
    """a . b of each column, d being 1 to 3.

    Written out: a reduction would be a loop of its own, between loops that could be one.
    """
    return sum((a[k] * b[k] for k in range(1, a.shape[0])), a[0] * b[0])
