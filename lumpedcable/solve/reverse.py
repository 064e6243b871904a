"""Loops that can be gone through backwards without keeping every step."""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

__all__ = ["block_length", "scan_in_blocks"]

# bytes of states: of a whole loop, up to what an allocator hands out again without a page fault for
# each part of it; of a block, what stays near the processor while the block is gone through twice
KEPT, BLOCK = 24 * 2**20, 3 * 2**18


def block_length(turns: int, state: Any, runs: int = 1) -> int:
    """Turns of a loop in a block, for `runs` runs at once with such a `state` each.

    All of them where `KEPT` bytes hold their states. Else each block but the last is gone through once
    more, and has as many turns as `BLOCK` bytes hold states, or the root of the number of turns if
    that is more: the B that makes turns/B + B, the states kept, least.
    """
    size = runs * sum(x.size * x.dtype.itemsize for x in jax.tree.leaves(state))
    if turns * size <= KEPT:
        return max(1, turns)  # of a loop without any too
    return min(turns, max(1, round(math.sqrt(turns)), BLOCK // size))


def scan_in_blocks(
    body: Callable[[Any, Any], tuple[Any, Any]],
    carry: Any,
    count: int,
    length: int,
    look: Callable[[Any, Any], Any] | None = None,
) -> tuple[Any, Any]:
    """`jax.lax.scan(body, carry, jnp.arange(count))` for reverse mode.

    Of the way there only the carry at the start of every block of `length` turns is kept, and what
    the turns of the last block need. On the way back each other block is gone through again, so that
    what its turns need is there for one block at a time. The memory grows with count / length +
    length, and the time by one more way there, but for the last block.

    Args:
        body: of a carry and the number of the turn, to the next carry and what is stacked.
        carry: at the start.
        count: turns.
        length: turns in each block, see `block_length`.
        look: of what a turn gave and its number, to what is stacked in its place. It looks at all
            turns of a block at once, which takes less time than one after the other.
    """
    blocks = max(0, count - 1) // length

    def some(carry: Any, turns: Any) -> tuple[Any, Any]:
        carry, found = jax.lax.scan(body, carry, turns)
        return carry, found if look is None else jax.vmap(look)(found, turns)

    if not blocks:
        return some(carry, jnp.arange(count))
    again = jax.checkpoint(lambda carry, first: some(carry, first + jnp.arange(length)))
    carry, found = jax.lax.scan(again, carry, length * jnp.arange(blocks))
    carry, more = some(carry, jnp.arange(blocks * length, count))
    found = jax.tree.map(lambda x: x.reshape(-1, *x.shape[2:]), found)
    return carry, jax.tree.map(lambda a, b: jnp.concatenate([a, b]), found, more)
