"""Coulomb friction of lines on the bed: where it acts, and what it does in a kick of leapfrog.

An end that something holds, moves or carries has none until it breaks away, nor has the place at which
a line is going to break: half a segment each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.ends import Joined, Loaded
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.vectors import dot

if TYPE_CHECKING:
    from lumpedcable.model.model import Model

__all__ = ["grip_limit", "held_back", "joint_held_back"]


def grip_limit(model: Model, name: str, t, e, velocity) -> Float[Array, " nodes"]:
    """The most friction (N) that each node of a line can have at its velocity (m/s)."""
    line = model.lines[name]
    assert line.grip is not None  # who asks has looked
    limit = line.grip.limit(e.line.shape, velocity)
    for node in line.ends:
        share = _share(model, t, model.end(name, node))
        if share is not None:
            limit = place_at_end(limit, node, limit[node] * jnp.asarray(share, limit.dtype))
    return limit


def _share(model: Model, t, end):
    """0 for an end that is held, 1 once it has broken away; None for one that lies there for good."""
    if isinstance(end, Loaded) or _lasting(model, end):
        return None
    release = model.parting(end.junction) if isinstance(end, Joined) else end.release
    return 0.0 if release is None else release.begun(t)


def _lasting(model: Model, end) -> bool:
    """Whether an end stays joined to others for good."""
    if not isinstance(end, Joined):
        return False
    members = model.junctions[end.junction].members
    return all(model.end(name, node).release is None for name, node in members)


def held_back(model: Model, name: str, t, e, before, change, dt):
    """The velocity (m/s) after a kick of length dt (s) with friction, and the evaluation.

    Friction takes of a node's momentum along the bed what would stop it in this kick, or mu N dt
    where that is less: a node that it stops does not creep. With added mass, which is not the same
    along and across the line, it acts against that momentum.
    """
    after = before + change
    level = _level(e, model.lines[name], after)
    force, stopped = _friction(
        level, _momentum(e.nodes, level), grip_limit(model, name, t, e, before), dt
    )
    return after - stopped, e._replace(grip=force)


def joint_held_back(model: Model, members, t, found, before, matrix, gain, dt):
    """The same for the acceleration (m/s2) of a joint with the inertia `matrix` (kg, (d, d)).

    The force (N) is booked on the first member.
    """
    names = [name for name, _ in members]
    if not all(model.lines[n].grip is not None and found[n].grip is not None for n in names):
        return gain
    if not _lasting(model, model.end(*members[0])):
        return gain
    name, node = members[0]
    e = found[name]
    limit = sum(grip_limit(model, n, t, found[n], before[n])[k] for n, k in members)
    grip = model.lines[name].grip
    assert grip is not None  # as looked at above
    normal = grip.bed.normal(e.line.shape)
    n = normal[:, 0 if normal.shape[1] == 1 else node]
    after = before[name][:, node] + dt * gain
    level = (after - n * jnp.dot(n, after))[:, None]
    force, stopped = _friction(level, matrix @ level, limit, dt)
    for k, (member, place) in enumerate(members):
        own = found[member].grip
        mine = force[:, 0] if k == 0 else jnp.zeros_like(force[:, 0])
        found[member] = found[member]._replace(grip=place_at_end(own, place, mine))
    return gain - stopped[:, 0] / dt


def _level(e, line, velocity) -> Float[Array, "d nodes"]:
    """The part of a velocity (m/s) that lies in the plane of the bed."""
    normal = line.grip.bed.normal(e.line.shape)
    return velocity - normal * dot(normal, velocity)


def _momentum(nodes: inertia.Frame, velocity) -> Float[Array, "d nodes"]:
    """M v (kg m/s)."""
    if nodes.tangent is None:
        return nodes.mass_t * velocity
    along, across = nodes.split(velocity)
    return nodes.mass_t * along * nodes.tangent + nodes.mass_n * across


def _friction(level, momentum, limit, dt) -> tuple[Array, Array]:
    """Friction (N) and the velocity (m/s) that it takes in dt (s), both (d, nodes)."""
    square = dot(momentum, momentum)
    most = limit * dt
    slides = square > most**2
    size = jnp.sqrt(jnp.where(slides, square, 1.0))
    share = jnp.where(slides, most / size, 1.0)
    return -share * momentum / dt, share * level
