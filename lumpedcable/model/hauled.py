"""Coordinates whose motion is given: trolleys that are hauled, and what drums have paid out."""

from __future__ import annotations

from collections.abc import Iterator

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.model import Model
from lumpedcable.model.reels import Drum
from lumpedcable.model.riders import Rider
from lumpedcable.physics.motion import AbstractMotion, mean_velocity_of, velocity_of, way_of

__all__ = ["placed_on_way", "spooled", "steered", "steered_gain", "ways"]

Values = dict[str, Array]


def _hauled(model: Model) -> Iterator[tuple[str, AbstractMotion, Array]]:
    for name, body in model.bodies.items():
        if isinstance(body, Rider | Drum) and body.path is not None and body.free is not None:
            yield body_key(name), body.path, body.free


def placed_on_way(model: Model, t: Float[Array, ""], displacement: Values) -> Values:
    """The same displacements (m), but hauled coordinates where their paths are at t (s)."""
    moved = dict(displacement)
    for key, way, free in ways(model, t):
        own = displacement[key]
        moved[key] = jnp.where(free > 0.0, own, way.astype(own.dtype))
    return moved


def spooled(model: Model, t: Float[Array, ""], displacement: Values) -> Values:
    """The same displacements (m), but of drums what they have paid out by t (s).

    A sum over the steps is off by what rounding leaves out of each.
    """
    moved = dict(displacement)
    for name, body in model.bodies.items():
        if isinstance(body, Drum):
            key = body_key(name)
            moved[key] = way_of(body.path, jnp.zeros_like(t), t).astype(moved[key].dtype)
    return moved


def ways(model: Model, t: Float[Array, ""]) -> Iterator[tuple[str, Array, Array]]:
    """How far hauled bodies are on their paths at t (s), in double precision (m), and what is free."""
    for key, path, free in _hauled(model):
        yield key, way_of(path, jnp.zeros_like(t), t), free


def steered(model: Model, t, dt: Float[Array, ""] | None, velocity: Values) -> Values:
    """The same velocities, but hauled bodies as they are hauled: at t (s), or over the dt (s) after."""
    moved = dict(velocity)
    for key, path, free in _hauled(model):
        own = velocity[key]
        given = velocity_of(path, t) if dt is None else mean_velocity_of(path, t, dt)
        moved[key] = jnp.where(free > 0.0, own, given.astype(own.dtype))
    return moved


def steered_gain(model: Model, t, gains: Values) -> Values:
    """The same accelerations, but of hauled coordinates those of their paths."""
    moved = dict(gains)
    for key, path, free in _hauled(model):

        def speed(s, path=path):
            return velocity_of(path, s)

        given = jax.jvp(speed, (t,), (jnp.ones_like(t),))[1].astype(gains[key].dtype)
        moved[key] = jnp.where(free > 0.0, gains[key], given)
    return moved
