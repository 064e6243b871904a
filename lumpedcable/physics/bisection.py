"""Halving an interval until it is as small as wanted."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

__all__ = ["bisected"]


def bisected(
    below: Callable[[Float[Array, "..."]], Bool[Array, "..."]],
    low: Float[Array, "..."],
    high: Float[Array, "..."],
    halvings: int,
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Bounds of where `below` ceases to be True between `low` and `high`, halved so many times.

    Element by element, where `below` answers so. Nothing is differentiated.
    """

    def halve(_, bounds):
        low, high = bounds
        middle = 0.5 * (low + high)
        before = below(middle)
        return jnp.where(before, middle, low), jnp.where(before, high, middle)

    bounds = jax.lax.stop_gradient((low, high))
    return jax.lax.stop_gradient(jax.lax.fori_loop(0, halvings, halve, bounds))
