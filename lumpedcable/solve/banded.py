"""Linear systems that only couple neighbours, small blocks, many times over: no library call."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["solve_chain"]


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
