"""The decay of a force while something breaks, and the growth of what moves or pushes."""

import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["grown_time", "growth", "release_ramp"]


def release_ramp(
    t: Float[Array, ""], start: Float[Array, ""], time: Float[Array, ""]
) -> Float[Array, ""]:
    """The share of a force that is still held while its line breaks (-), from 1 to 0.

    cos^2(pi (t - start) / (2 time)) between `start` and `start + time` (s), 1 before, 0 after
    (Zhu, Yin & Shen 2018, eq. 7). With time = 0 it drops to 0 at `start` itself.
    """
    after = t >= start + time
    inside = (t >= start) & ~after
    # chosen before the division, which has no derivative far before (t = -inf) and for time = 0
    share = jnp.where(inside, t - start, 0.0) / jnp.where(inside, time, 1.0)
    return jnp.where(after, 0.0, jnp.cos(0.5 * jnp.pi * share) ** 2)


def growth(t: Float[Array, ""], time: Float[Array, ""]) -> Float[Array, ""]:
    """The share r(t) (-) of what grows from nothing over `time` (s): sin^2(pi t / (2 time)), then 1."""
    return jnp.sin(0.5 * jnp.pi * _share(t, time)) ** 2


def grown_time(t: Float[Array, ""], time: Float[Array, ""]) -> Float[Array, ""]:
    """The integral of r from 0 to t (s), which beyond `time` (s) is t - time / 2."""
    share = _share(t, time)
    return t - 0.5 * time * (share + jnp.sin(jnp.pi * share) / jnp.pi)


def _share(t, time):
    # not `clip`, whose derivative at its bounds is half of that inside: what grows starts at rest
    return jnp.where(t < time, t / time, 1.0)
