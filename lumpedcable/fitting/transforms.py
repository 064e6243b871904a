"""Bounded numbers as unbounded ones: what the minimisers move, of order one at the start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lumpedcable.fitting.parameters import Parameter

__all__ = ["Transform", "slope_at", "to_unbounded", "to_values", "transform_of"]


class Transform(NamedTuple):
    """x(z) of each parameter: from -inf to inf in z, from its lower to its upper bound in x.

    x = scale z without bounds, low + scale exp(z) above a bound, high - scale exp(z) below one, and
    low + scale / (1 + exp(-z)) between two. All (parameters,); low and high are 0 where not used.
    """

    low: Float[Any, " p"]
    high: Float[Any, " p"]
    scale: Float[Any, " p"]
    has_low: Any
    has_high: Any


def transform_of(parameters: Sequence[Parameter]) -> Transform:
    """The transform whose scales are the bounds' gap, or the start values.

    Where that is zero: the largest start of the same unit, or 1.
    """
    start, low, high = (
        np.array([getattr(p, key) for p in parameters], float) for key in ("start", "low", "high")
    )
    has_low, has_high = np.isfinite(low), np.isfinite(high)
    most = [max(abs(q.start) for q in parameters if q.unit == p.unit) or 1.0 for p in parameters]
    free = np.where(start != 0.0, np.abs(start), most)
    with np.errstate(invalid="ignore"):
        scale = np.select(
            [has_low & has_high, has_low, has_high], [high - low, start - low, high - start], free
        )
    return Transform(
        np.where(has_low, low, 0.0), np.where(has_high, high, 0.0), scale, has_low, has_high
    )


def to_values(t: Transform, z: Float[Any, " p"]) -> Float[Any, " p"]:
    """x of z."""
    # exp of what is not used must not overflow: its derivative would be undefined
    power = jnp.exp(jnp.clip(z, -700.0, 700.0))
    # from the nearer bound, so that the derivative does not end where the value rounds to the bound
    share = t.scale * jax.nn.sigmoid(-jnp.abs(z))
    both = jnp.where(z > 0.0, t.high - share, t.low + share)
    one = jnp.where(t.has_low, t.low + t.scale * power, t.high - t.scale * power)
    bounded = jnp.where(t.has_low & t.has_high, both, one)
    return jnp.where(t.has_low | t.has_high, bounded, t.scale * z)


def to_unbounded(t: Transform, x: np.ndarray) -> np.ndarray:
    """z of x, which lies between the bounds."""
    x = np.asarray(x, float)
    with np.errstate(all="ignore"):
        share = (x - t.low) / t.scale
        both = np.log(share / (1.0 - share))
        one = np.log(np.where(t.has_low, x - t.low, t.high - x) / t.scale)
        bounded = np.where(t.has_low & t.has_high, both, one)
    return np.where(t.has_low | t.has_high, bounded, x / t.scale)


def slope_at(t: Transform, z: np.ndarray) -> np.ndarray:
    """dx/dz."""
    z = np.clip(np.asarray(z, float), -700.0, 700.0)
    share = 1.0 / (1.0 + np.exp(np.abs(z)))
    with np.errstate(over="ignore"):  # of what is not used
        one = np.where(t.has_low, t.scale, -t.scale) * np.exp(z)
    bounded = np.where(t.has_low & t.has_high, t.scale * share * (1.0 - share), one)
    return np.where(t.has_low | t.has_high, bounded, t.scale)
