"""Coulomb friction of lines on the bed: where it acts, and what it does in a kick of leapfrog.

An end that something holds, moves or carries has none until it breaks away, nor has the place at which
a line is going to break: half a segment each.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.ends import End, Joined, Loaded
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.seabed import BedGrip
from lumpedcable.physics.vectors import dot

if TYPE_CHECKING:
    from lumpedcable.model.couple import Found
    from lumpedcable.model.model import Model

__all__ = ["grip_limit", "held_back", "joint_held_back"]


def grip_limit(model: Model, name: str, t, e: Evaluation, velocity) -> Float[Array, " nodes"]:
    """The most friction (N) that each node of a line can have at its velocity (m/s)."""
    limit = _grip(model, name).limit(e.line.shape, velocity)
    for node in model.lines[name].ends:
        share = _share(model, t, model.end(name, node))
        if share is not None:
            limit = place_at_end(limit, node, limit[node] * jnp.asarray(share, limit.dtype))
    return limit


def _grip(model: Model, name: str) -> BedGrip:
    """What a line has of friction."""
    grip = model.lines[name].grip
    assert grip is not None  # who asks has looked
    return grip


def _share(model: Model, t, end: End) -> Any:
    """0 for an end that is held, 1 once it has broken away; None for one that lies there for good."""
    if isinstance(end, Loaded) or _lasting(model, end):
        return None
    release = model.parting(end.junction) if isinstance(end, Joined) else end.release
    return 0.0 if release is None else release.begun(t)


def _lasting(model: Model, end: End) -> bool:
    """Whether an end stays joined to others for good."""
    if not isinstance(end, Joined):
        return False
    members = model.junctions[end.junction].members
    return all(model.end(name, node).release is None for name, node in members)


def held_back(
    model: Model, name: str, t, e: Evaluation, before, change, dt
) -> tuple[Float[Array, "d nodes"], Evaluation]:
    """The velocity (m/s) after a kick of length dt (s) with friction, and the evaluation.

    Friction takes of a node's momentum along the bed what would stop it in this kick, or mu N dt
    where that is less: a node that it stops does not creep. With added mass, which is not the same
    along and across the line, it acts against that momentum.
    """
    after = before + change
    level = _level(_grip(model, name).bed.normal(e.line.shape), after)
    force, stopped = _friction(
        level, _momentum(e.nodes, level), grip_limit(model, name, t, e, before), dt
    )
    return after - stopped, e._replace(grip=force)


def joint_held_back(
    model: Model, members, t, found: Found, before, matrix, gain, dt
) -> Float[Array, " d"]:
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
    normal = _grip(model, name).bed.normal(e.line.shape)
    n = normal[:, 0 if normal.shape[1] == 1 else node]
    after = before[name][:, node] + dt * gain
    level = (after - n * jnp.dot(n, after))[:, None]
    force, stopped = _friction(level, matrix @ level, limit, dt)
    for k, (member, place) in enumerate(members):
        own = found[member].grip
        assert own is not None  # as was looked at above
        mine = force[:, 0] if k == 0 else jnp.zeros_like(force[:, 0])
        found[member] = found[member]._replace(grip=place_at_end(own, place, mine))
    return gain - stopped[:, 0] / dt


def _level(normal: Float[Array, "d nodes"], velocity) -> Float[Array, "d nodes"]:
    """The part of a velocity (m/s) that lies in the plane of the bed."""
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
