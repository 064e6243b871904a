"""Linear systems that only couple neighbours, small blocks, many times over: no library call."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["at_first", "at_last", "both", "flip", "onto", "solve_chain", "times"]


def solve_chain(
    lower: Float[Array, "places b b"],
    diagonal: Float[Array, "places b b"],
    upper: Float[Array, "places b b"],
    right: Float[Array, "places b"],
) -> Float[Array, "places b"]:
    """Solution of a block tridiagonal system by block elimination (Thomas), O(places).

    Within a block by elimination without pivoting, in the order of its unknowns: accelerations first,
    whose part of the matrix is positive, then the tension, whose part is negative once they are gone.
    The first lower and the last upper block meet zeros.
    """
    b = right.shape[1]
    rows = jnp.arange(b)[:, None]

    def forward(carry, row):
        gain, value = carry
        low, middle, up, r = row
        # [middle - low gain | up | r - low value], reduced to [I | up' | r']
        table = jnp.concatenate([middle - low @ gain, up, (r - low @ value)[:, None]], axis=1)
        for k in range(b):
            line = table[k] / table[k, k]
            table = jnp.where(rows == k, line, table - table[:, k : k + 1] * line)
        gain, value = table[:, b : 2 * b], table[:, 2 * b]
        return (gain, value), (gain, value)

    zero = (jnp.zeros_like(diagonal[0]), jnp.zeros_like(right[0]))
    _, (gains, values) = jax.lax.scan(forward, zero, (lower, diagonal, upper, right))

    def backward(after, row):
        gain, value = row
        here = value - gain @ after
        return here, here

    _, x = jax.lax.scan(backward, zero[1], (gains, values), reverse=True)
    return x


def both(left, matrix, right):
    """J^T A K, of all rods; None stands for the unit matrix."""
    matrix = matrix if left is None else flip(left) @ matrix
    return matrix if right is None else matrix @ right


def onto(turn, vectors: Float[Array, "n d"]) -> Float[Array, "n s"]:
    """J^T v of all rods; None stands for the unit matrix."""
    return vectors if turn is None else (vectors[:, None, :] @ turn)[:, 0, :]


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
