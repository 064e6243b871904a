"""What is known at an end of a line at one instant: its force, or its motion."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.ends import Attached, Driven, Joined, Loaded, end_name
from lumpedcable.model.model import Model
from lumpedcable.physics.waves import Boundary

__all__ = ["boundary"]


def boundary(
    model: Model, name: str, node: int, t: Float[Array, ""], reaction: dict[str, Float[Array, " d"]]
) -> Boundary:
    """What a wave meets at an end of a line, at t (s)."""
    end = model.end(name, node)
    force, rate = _force_and_rate(model, name, node, t, reaction)
    if isinstance(end, Loaded):
        return Boundary(True, force, None, rate)
    if isinstance(end, Driven):
        begun = False if end.release is None else end.release.begun(t)
        return Boundary(begun, force, None, rate)
    if isinstance(end, Attached):
        release = end.release
    else:
        release = model.parting(end.junction) if end.release is None else end.release
    if release is None:
        return Boundary(False, force, True, rate)
    begun = release.begun(t)
    return Boundary(begun, force, ~begun, rate)


def _force_and_rate(model: Model, name: str, node: int, t, reaction):
    """The known force on an end (N) and how fast it changes (N/s), None where there is none."""
    end = model.end(name, node)
    if isinstance(end, Loaded) and end.release is None:
        return end.force, None
    t = jnp.asarray(t)
    return jax.jvp(lambda t: _force(model, name, node, t, reaction), (t,), (jnp.ones_like(t),))


def _force(model: Model, name: str, node: int, t, reaction) -> Float[Array, " d"] | None:
    """The known force on an end node (N), None where there is none."""
    end = model.end(name, node)
    if isinstance(end, Loaded):
        return end.external(t)
    if isinstance(end, Joined):
        force = None
        for member, other in model.leavers(end.junction):
            sign = 1.0 if member == (name, node) else -1.0
            if (name, node) in (member, model.carrier(end.junction)):
                share = other.held(t) * other.begun(t)
                part = reaction[end_name(*member)]
                part = sign * part * share.astype(part.dtype)
                force = part if force is None else force + part
        return force
    if end.release is None:
        return None
    held = reaction[end_name(name, node)]
    share = end.release.held(t) * end.release.begun(t)
    return held * share.astype(held.dtype)
