"""Bounded numbers as unbounded ones: what the minimisers move, of order one at the start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from lumpedcable.fitting.parameters import Parameter

__all__ = [
    "Transform",
    "before_bounds",
    "share_of",
    "slope_at",
    "to_unbounded",
    "to_values",
    "transform_of",
]

FAR = 40.0
"""|z| towards a bound beyond which x is the bound to rounding: exp(-40) = 4e-18 of the scale away."""


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


def before_bounds(t: Transform, z: np.ndarray) -> np.ndarray:
    """z, but no further out than `FAR` towards a bound: the same x to rounding."""
    z = np.asarray(z, float)
    out = np.where(t.has_low & t.has_high, FAR, np.inf)
    return np.where(t.has_low | t.has_high, np.clip(z, -FAR, out), z)


def share_of(t: Transform, z: np.ndarray) -> np.ndarray:
    """How far x is from its nearest bound, over the scale; inf without bounds."""
    z = np.clip(np.asarray(z, float), -700.0, 700.0)
    both = 1.0 / (1.0 + np.exp(np.abs(z)))
    bounded = np.where(t.has_low & t.has_high, both, np.exp(z))
    return np.where(t.has_low | t.has_high, bounded, np.inf)


def slope_at(t: Transform, z: np.ndarray) -> np.ndarray:
    """dx/dz at `before_bounds`."""
    z = before_bounds(t, z)
    share = share_of(t, z)
    with np.errstate(invalid="ignore"):  # of what is not used
        one = np.where(t.has_low, t.scale, -t.scale) * share
        bounded = np.where(t.has_low & t.has_high, t.scale * share * (1.0 - share), one)
    return np.where(t.has_low | t.has_high, bounded, t.scale)
