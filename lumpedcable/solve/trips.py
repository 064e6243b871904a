"""Ends that break at a tension: the time at which what holds them first pulls with it."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.ends import end_name
from lumpedcable.model.model import Model
from lumpedcable.model.state import State
from lumpedcable.physics.linear import pick
from lumpedcable.physics.vectors import dot, size

__all__ = ["Trip", "tripped", "trips"]


class Trip(NamedTuple):
    """The tension (N) that an end had to carry at the last step, and when it first was enough.

    `time` (s) is linear between steps, 0 where the end at rest carries as much, NaN before.
    """

    tension: Float[Array, ""]
    time: Float[Array, ""]


def trips(model: Model, y: State) -> dict[str, Trip]:
    """Ends that break at a tension, by name, at the start."""
    found = {}
    for name, node, level in _tripping(model):
        now = _tension(model, y, name, node)
        enough = now >= level
        found[end_name(name, node)] = Trip(now, jnp.where(enough, 0.0, jnp.nan))
    return found


def tripped(
    model: Model, y: State, before: dict[str, Trip], t: Float[Array, ""], dt: Float[Array, ""]
) -> dict[str, Trip]:
    """The same after a step of dt that ended at t (s)."""
    after = {}
    for name, node, level in _tripping(model):
        end = end_name(name, node)
        old, now = before[end], _tension(model, y, name, node)
        enough = jnp.isnan(old.time) & (now >= level)
        ahead = (now - level) / jnp.where(enough, now - old.tension, 1.0)
        # less than enough a step ago, or the end would have broken then
        when = t - dt * jnp.clip(ahead, 0.0, 1.0)
        after[end] = Trip(now, jnp.where(enough, when, old.time))
    return after


def _tripping(model: Model) -> list[tuple[str, int, Float[Array, ""]]]:
    """Ends that break at a tension: (line, its end, that tension in N)."""
    return [
        (name, node, end.release.tension)
        for name, node, end in model.breakable()
        if end.release is not None and end.release.tension is not None
    ]


def _tension(model: Model, y: State, name: str, node: int) -> Float[Array, ""]:
    """What holds an end (N), 0 where it pushes."""
    line, force = model.lines[name], y.reaction[end_name(name, node)]
    step = _place(line, y.displacement[name], node) - _place(line, y.displacement[name], node, 1)
    return jnp.where(dot(force, step) > 0.0, size(force), 0.0)


def _place(line, displacement, node: int, inner: int = 0) -> Float[Array, " d"]:
    """Where a node is (m): of an end, or so many further in."""
    at = line.node(node, inner)
    return pick(line.reference, at) + pick(displacement, at)
