"""Small blocks, many of them: elimination within one, products of all."""

import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["at_first", "at_last", "both", "eliminated", "flip", "lengthening", "onto", "times"]


def eliminated(matrix: Float[Array, "b b"], right: Float[Array, "b n"]) -> Float[Array, "b n"]:
    """Solution of a small system by elimination without pivoting, in the order of its unknowns.

    Of a place those are accelerations first, whose part of the matrix is positive, then the tension,
    whose part is negative once they are gone. No library call, which would cost more than it does.
    """
    b = matrix.shape[0]
    rows, table = jnp.arange(b)[:, None], jnp.concatenate([matrix, right], axis=1)
    for k in range(b):
        line = table[k] / table[k, k]
        table = jnp.where(rows == k, line, table - table[:, k : k + 1] * line)
    return table[:, b:]


def both(left, matrix, right):
    """J^T A K, of all rods; None stands for the unit matrix."""
    matrix = matrix if left is None else flip(left) @ matrix
    return matrix if right is None else matrix @ right


def onto(turn, vectors: Float[Array, "n d"]) -> Float[Array, "n s"]:
    """J^T v of all rods; None stands for the unit matrix."""
    return vectors if turn is None else (vectors[:, None, :] @ turn)[:, 0, :]


def lengthening(
    first: Float[Array, "n s"], last: Float[Array, "n s"], rates: Float[Array, "P s"]
) -> Float[Array, " n"]:
    """How fast rods lengthen, last . v_j+1 - first . v_j, by rates of places; likewise by gains."""
    return jnp.sum(last * rates[1:] - first * rates[:-1], axis=1)


def times(matrices: Float[Array, "n d d"], vectors: Float[Array, "n d"]) -> Float[Array, "n d"]:
    """A v of all rods."""
    return (matrices @ vectors[..., None])[..., 0]


def flip(x: Array) -> Array:
    """Transposed matrices."""
    return jnp.swapaxes(x, 1, 2)


def at_first(x: Array) -> Array:
    """Values of rods at their first places, nothing at the last place."""
    return jnp.pad(x, ((0, 1), *((0, 0),) * (x.ndim - 1)))


def at_last(x: Array) -> Array:
    """Values of rods at their last places, nothing at the first place."""
    return jnp.pad(x, ((1, 0), *((0, 0),) * (x.ndim - 1)))
