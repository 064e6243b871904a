"""Loops that can be gone through backwards without keeping every step."""

import math
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

__all__ = ["KEPT", "block_length", "scan_in_blocks"]

KEPT = 2**26  # bytes of states that are kept in any case: less than the programs themselves take


def block_length(turns: int, state: Any, runs: int = 1) -> int:
    """Turns of a loop in a block, for `runs` runs at once with such a `state` each.

    All of them where `KEPT` bytes hold their states; else as many as those hold, or the root of their
    number if that is more: the B that makes turns/B + B, the states kept, least.
    """
    size = sum(x.size * x.dtype.itemsize for x in jax.tree.leaves(state))
    return min(turns, max(1, round(math.sqrt(turns)), KEPT // (runs * size)))


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
