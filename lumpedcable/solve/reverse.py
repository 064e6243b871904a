"""Loops that can be gone through backwards without keeping every step."""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

__all__ = ["block_length", "scan_in_blocks"]


def block_length(count: int, steps: int) -> int:
    """Turns of `steps` steps in a block: the B that makes count/B + B steps, the states kept, least."""
    return max(1, round(math.sqrt(count / steps)))


def scan_in_blocks(
    body: Callable[[Any, Any], tuple[Any, Any]], carry: Any, count: int, steps: int
) -> tuple[Any, Any]:
    """`jax.lax.scan(body, carry, jnp.arange(count))` for reverse mode.

    Of the way there only the carry at the start of every block is kept; on the way back each block
    is gone through again, and what its steps need is kept for one block at a time. So the memory
    grows with the square root of count * steps, and the time by one more way there.

    Args:
        body: of a carry and the number of the turn, to the next carry and what is stacked.
        carry: at the start.
        count: turns.
        steps: steps in each turn, for the length of a block alone.
    """
    length = block_length(count, steps)
    blocks, rest = divmod(count, length)

    @jax.checkpoint
    def block(carry: Any, first: Any) -> tuple[Any, Any]:
        return jax.lax.scan(body, carry, first + jnp.arange(length))

    @jax.checkpoint
    def last(carry: Any) -> tuple[Any, Any]:
        return jax.lax.scan(body, carry, blocks * length + jnp.arange(rest))

    carry, found = jax.lax.scan(block, carry, length * jnp.arange(blocks))
    found = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), found)
    if rest:
        carry, more = last(carry)
        found = jax.tree.map(lambda a, b: jnp.concatenate([a, b]), found, more)
    return carry, found
