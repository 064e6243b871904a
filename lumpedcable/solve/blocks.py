"""Newton's linear systems on a net of lines: Jacobians by colour, solves by blocks, all O(N)."""

from collections.abc import Callable
from functools import partial

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["BlockTridiagonal", "block_jacobian", "solve_blocks"]

BlockTridiagonal = tuple[
    Float[Array, "blocks b b"], Float[Array, "blocks b b"], Float[Array, "blocks b b"]
]


def block_jacobian(
    residual: Callable[[Float[Array, "blocks b"]], Float[Array, "blocks b"]],
    x: Float[Array, "blocks b"],
) -> tuple[Float[Array, "blocks b"], BlockTridiagonal]:
    """A residual, and its Jacobian's sub-, main and superdiagonal blocks, where only neighbours couple.

    Blocks three apart share no row, so 3 b directional derivatives give every entry (Curtis, Powell
    & Reid, J. Inst. Maths Applics 13, 1974), however many blocks there are. The first sub- and the
    last superdiagonal block are meaningless and not used.
    """
    count, b = x.shape
    colour = jnp.arange(count) % 3
    seeds = (colour[None, :] == jnp.arange(3)[:, None]).astype(x.dtype)  # (3, blocks)
    seeds = seeds[:, None, :, None] * jnp.eye(b, dtype=x.dtype)[None, :, None, :]
    along = partial(jax.jvp, residual, (x,))
    every = jax.vmap(jax.vmap(lambda s: along((s,)), out_axes=(None, 0)), out_axes=(None, 0))
    value, columns = every(seeds)
    rows = jnp.arange(count)
    parts = [jnp.swapaxes(columns[(rows + shift) % 3, :, rows, :], 1, 2) for shift in (-1, 0, 1)]
    return value, (parts[0], parts[1], parts[2])


def solve_blocks(
    matrix: BlockTridiagonal,
    right: Float[Array, "blocks b"],
    solve: Callable[[Array, Array], Array] = jnp.linalg.solve,
) -> Float[Array, "blocks b"]:
    """Solution of a block tridiagonal system by block elimination (Thomas), without pivoting
    between blocks; `solve` of a block (b, b) and right sides (b, n) is what is done within one.

    The first lower and the last upper block meet zeros.
    """
    lower, diagonal, upper = matrix

    def forward(carry, row):
        gain, value = carry
        low, middle, up, r = row
        pivot = middle - low @ gain
        both = solve(pivot, jnp.concatenate([up, (r - low @ value)[:, None]], axis=1))
        return (both[:, :-1], both[:, -1]), (both[:, :-1], both[:, -1])

    zero = (jnp.zeros_like(diagonal[0]), jnp.zeros_like(right[0]))
    _, (gains, values) = jax.lax.scan(forward, zero, (lower, diagonal, upper, right))

    def backward(after, row):
        gain, value = row
        here = value - gain @ after
        return here, here

    _, x = jax.lax.scan(backward, zero[1], (gains, values), reverse=True)
    return x
