"""Loops that the CPU's compiler is not to make one function of."""

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Int

__all__ = ["listed"]


def listed(k: Int[Array, ""]) -> Int[Array, ""]:
    """The number of a turn as it is, in a way that its loop stays a list of functions to call.

    XLA makes one function of a loop and all loops in it (`WHOLE_LOOPS` in `study/compiled.py`), unless
    there is in it what cannot be part of one: a sorting. LLVM takes four times as long for a function
    that is twice as long.
    """
    if jax.default_backend() != "cpu":
        return k
    return lax.sort(jnp.stack([k, k]))[0]
