"""Coulomb friction of lines on the bed: where it acts, and what it does in a kick of leapfrog.

An end that something holds, moves or carries has none until it breaks away, nor has the place at which
a line is going to break: half a segment each.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.couple import Found
from lumpedcable.model.ends import End, Joined, Loaded, solve_small
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.model import Model
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.seabed import BedGrip
from lumpedcable.physics.vectors import dot

__all__ = ["MatrixInertia", "against_motion", "grip_limit", "held_back", "joint_held_back"]

ROUNDS = 5  # of Newton's method: with masses thirty times as large across, to 1e-10
LEAST = 1e-6  # share of a momentum below which friction's direction is that of the velocity to this


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
    where that is less: a node that it stops does not creep, and one that goes on has it against the
    velocity after the kick, also where added mass is not the same along and across the line: then what
    is pushed along the bed goes a little up or down as well, where the line lifts off. Of a line
    with a winch the velocity is that of its substance: where friction holds it, nodes move past it.
    """
    after = before + change
    slides = after if e.past is None else after + e.past
    normal = _grip(model, name).bed.normal(e.line.shape)
    level = _level(normal, slides)
    limit = grip_limit(model, name, t, e, before)
    if model.lines[name].added_mass is None:
        force, stopped = _friction(level, _Masses(e.nodes, True), limit, dt)
        return after - stopped, e._replace(grip=force)
    mass = _Masses(e.nodes, False)
    force, stopped = _friction(level, mass.along(normal), limit, dt)
    raised = normal * dot(normal, mass.divided(force)) * dt
    return after - stopped + raised, e._replace(grip=force)


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
    mass = MatrixInertia(matrix)
    force, stopped = _friction(level, mass.along(n), limit, dt)
    stopped = stopped - n[:, None] * dot(n[:, None], mass.divided(force)) * dt
    for k, (member, place) in enumerate(members):
        own = found[member].grip
        assert own is not None  # as was looked at above
        mine = force[:, 0] if k == 0 else jnp.zeros_like(force[:, 0])
        found[member] = found[member]._replace(grip=place_at_end(own, place, mine))
    return gain - stopped[:, 0] / dt


def _level(normal: Float[Array, "d nodes"], velocity) -> Float[Array, "d nodes"]:
    """The part of a velocity (m/s) that lies in the plane of the bed."""
    return velocity - normal * dot(normal, velocity)


class _Masses:
    """The inertia M (kg) of a line's nodes; `alike` where friction and momentum have one direction."""

    def __init__(self, nodes: inertia.Frame, alike: bool):
        self.nodes, self.alike = nodes, alike or nodes.tangent is None or nodes.tangent.shape[0] < 3

    def along(self, normal: Float[Array, "d nodes"]) -> _Masses:
        """What resists forces along a bed, whose way up is `normal`.

        With P what leaves the normal out, the velocity along the bed yields to them by P M^-1 P =
        P / m_n + (1/m_t - 1/m_n) q q^T, q = P t: that of nodes whose line lies along q.
        """
        nodes = self.nodes
        if nodes.tangent is None:
            return self
        flat = _level(normal, nodes.tangent)
        square = dot(flat, flat)
        yields = 1.0 / nodes.mass_n + (1.0 / nodes.mass_t - 1.0 / nodes.mass_n) * square
        flat = flat / jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
        return _Masses(nodes._replace(tangent=flat, mass_t=1.0 / yields), self.alike)

    def times(self, vector: Array) -> Array:
        """M v."""
        return self._each(vector, self.nodes.mass_t, self.nodes.mass_n)

    def divided(self, vector: Array) -> Array:
        """M^-1 p."""
        return self._each(vector, 1.0 / self.nodes.mass_t, 1.0 / self.nodes.mass_n)

    def damped(self, vector: Array, share: Array) -> Array:
        """(1 + k M)^-1 p with k (1/kg), shape (nodes,)."""
        along, across = 1.0 + share * self.nodes.mass_t, 1.0 + share * self.nodes.mass_n
        return self._each(vector, 1.0 / along, 1.0 / across)

    def _each(self, vector: Array, along: Array, across: Array) -> Array:
        if self.nodes.tangent is None:
            return along * vector
        part, rest = self.nodes.split(vector)
        return along * part * self.nodes.tangent + across * rest


class MatrixInertia:
    """The inertia M (kg, (d, d)) of a joint, or of a body along the bed; vectors are (d, 1)."""

    def __init__(self, matrix: Array):
        self.matrix, self.alike = matrix, matrix.shape[0] < 3

    def along(self, n: Float[Array, " d"]) -> MatrixInertia:
        """What resists forces along a bed, whose way up is n: P M^-1 P inverted, any mass along n."""
        d = n.shape[0]
        plane = jnp.eye(d, dtype=n.dtype) - jnp.outer(n, n)
        yields = jnp.stack([solve_small(self.matrix, way) for way in plane]) @ plane
        yields = yields + jnp.outer(n, n) * (d / jnp.trace(self.matrix))
        return MatrixInertia(
            jnp.stack([solve_small(yields, way) for way in jnp.eye(d, dtype=n.dtype)])
        )

    def times(self, vector: Array) -> Array:
        """M v."""
        return self.matrix @ vector

    def divided(self, vector: Array) -> Array:
        """M^-1 p."""
        return solve_small(self.matrix, vector[:, 0])[:, None]

    def damped(self, vector: Array, share: Array) -> Array:
        """(1 + k M)^-1 p with k (1/kg), shape (1,)."""
        eye = jnp.eye(self.matrix.shape[0], dtype=self.matrix.dtype)
        return solve_small(eye + share * self.matrix, vector[:, 0])[:, None]


def _friction(level, mass: _Masses | MatrixInertia, limit, dt) -> tuple[Array, Array]:
    """Friction (N) and the velocity (m/s) that it takes in dt (s), both (d, nodes)."""
    momentum = mass.times(level)
    square = dot(momentum, momentum)
    most = limit * dt
    slides = square > most**2
    size = jnp.sqrt(jnp.where(slides, square, 1.0))
    share = jnp.where(slides, most / size, 1.0)
    if mass.alike:
        return -share * momentum / dt, share * level
    way = jnp.where(slides, momentum / size, 1.0)
    against = jnp.where(slides, most * against_motion(way, mass, share), momentum)
    return -against / dt, jnp.where(slides, mass.divided(against), level)


def against_motion(way: Array, mass: _Masses | MatrixInertia, share: Array) -> Array:
    """The unit vectors v'/|v'| of what slides, with M (v' - v) = -mu N dt v'/|v'|.

    `way` is M v / |M v|, (d, nodes), and `share` r = mu N dt / |M v|. With k = |v'| / (mu N dt) the
    impulse is p(k) = (1 + k M)^-1 M v, and |p| = r |M v| gives k: 1/|p| is concave in k and nearly
    straight, so that Newton's method comes to it from 0 without passing it.
    """
    least = jnp.maximum(share, LEAST)
    k = jnp.zeros_like(share)
    for _ in range(ROUNDS):
        p = mass.damped(way, k)
        square = dot(p, p)
        fall = dot(p, mass.damped(mass.times(p), k))
        k = k + square * (jnp.sqrt(square) / least - 1.0) / fall
    p = mass.damped(way, k)
    return p / jnp.sqrt(dot(p, p))
