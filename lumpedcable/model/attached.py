"""How bodies move, and with them the ends of lines that are tied to their points.

An end at a point r(q) of a body has no freedom of its own: with J = dr/dq its velocity is J q' and
its acceleration J q'' + J' q', so its mass M and the force F on it enter the body's equation as
J^T M J and J^T (F - M J' q').
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.couple import Found, body_force
from lumpedcable.model.ends import Attached, Driven, solve_small
from lumpedcable.model.grip import MatrixInertia, against_motion
from lumpedcable.model.hauled import placed_on_way, steered, ways
from lumpedcable.model.inertia import end_matrices
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net
from lumpedcable.model.winches import Winch
from lumpedcable.physics.motion import Still, velocity_of, way_of
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.precision import cast
from lumpedcable.physics.vectors import dot

__all__ = [
    "attached_ends",
    "body_gain",
    "follow",
    "follow_rate",
    "left_out",
    "moved_ends",
    "on_course",
    "on_paths",
    "pull_of_lines",
    "start_velocities",
    "tied_to",
    "travels",
]

SLIDES = 2  # times that N, which depends a little on how a body slides, is found


class BodyGain(NamedTuple):
    """A body's acceleration, and by attached end ("line", node) what the body pulls it with (N)."""

    gain: Float[Array, " m"]
    pulls: dict[tuple[str, int], Float[Array, " d"]]


def attached_ends(model: Model, body: str | None = None) -> Iterator[tuple[str, int, Attached]]:
    """Ends that are tied to bodies, or to one of them: (line, 0 or -1, end)."""
    for name, node, end in model.outer_ends():
        if isinstance(end, Attached) and body in (None, end.body):
            yield name, node, end


def follow(model: Model, t: Float[Array, ""], displacement: dict[str, Array]) -> dict[str, Array]:
    """The same displacements (m), with attached ends where their bodies have taken them."""
    moved = dict(displacement)
    for name, node, end in attached_ends(model):
        body = model.bodies[end.body]
        u = body.shift(displacement[body_key(end.body)], end.point)
        moved[name] = _tied(t, moved[name], node, end, u)
    return moved


def follow_rate(
    model: Model,
    t: Float[Array, ""],
    displacement: dict[str, Array],
    velocity: dict[str, Array],
    ahead: Float[Array, ""] | None = None,
) -> dict[str, Array]:
    """The same velocities (m/s), with attached ends moving as their bodies do.

    With `ahead` (s), the velocity that takes an end to where its body will be after so long.
    """
    moved = dict(velocity)
    for name, node, end in attached_ends(model):
        body, key = model.bodies[end.body], body_key(end.body)
        q, v = body.reference + displacement[key], velocity[key]
        if ahead is not None:
            q = q + 0.5 * ahead.astype(q.dtype) * v
        moved[name] = _tied(t, moved[name], node, end, body.rate(q, v, end.point)[1])
    return moved


def _tied(t, values: Array, node: int, end: Attached | Driven, value: Array) -> Array:
    if end.release is not None:
        value = jnp.where(end.release.begun(t), values[:, node], value)
    return place_at_end(values, node, value)


def on_paths(
    model: Model, t: Float[Array, ""], displacement: dict[str, Array], velocity: dict[str, Array]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """The same displacements (m) and velocities (m/s), what is moved, hauled or tied as it is at t (s).

    What is integrated from accelerations alone drifts off: a step in them that falls into a step of
    time leaves a velocity behind.
    """
    displacement, velocity = on_course(model, t, displacement), steered(model, t, None, velocity)
    for name, node, end in moved_ends(model):
        v = velocity[name]
        velocity[name] = _tied(t, v, node, end, velocity_of(end.motion, t).astype(v.dtype))
    displacement = follow(model, t, displacement)
    return displacement, follow_rate(model, t, displacement, velocity)


def on_course(
    model: Model, t: Float[Array, ""], displacement: dict[str, Array]
) -> dict[str, Array]:
    """The same displacements (m), with what is moved or hauled where its path is at t (s)."""
    displacement = placed_on_way(model, t, displacement)
    for name, node, end in moved_ends(model):
        u = displacement[name]
        place = way_of(end.motion, jnp.zeros_like(t), t).astype(u.dtype)
        displacement[name] = _tied(t, u, node, end, place)
    return displacement


def travels(model: Model) -> bool:
    """Whether something carries lines along: ends that are moved, or bodies.

    Their displacements grow, and with them what rounding leaves out, while the lines stay taut. Others
    but tremble, or recoil slack.
    """
    return bool(model.bodies) or any(True for _ in moved_ends(model))


def left_out(
    model: Model, t: Float[Array, ""], displacement: dict[str, Array], low: dict[str, Array]
) -> dict[str, Array]:
    """What rounding has left out of displacements (m) at t (s), also where that is given.

    `displacement` are those of `on_course`, with what is tied following; `low` is what a step has left
    out of all others.
    """
    low = dict(low)
    for key, way, free in ways(model, t):
        own = displacement[key]
        low[key] = jnp.where(free > 0.0, low[key], (way - own).astype(own.dtype))
    for name, node, end in moved_ends(model):
        own, left = displacement[name][:, node], low[name]
        rest = (way_of(end.motion, jnp.zeros_like(t), t) - own).astype(own.dtype)
        low[name] = _tied(t, left, node, end, rest)
    for name, node, end in attached_ends(model):
        body, key = model.bodies[end.body], body_key(end.body)
        own, left = displacement[name][:, node], low[name]
        body, point = cast((body, end.point), str(t.dtype))
        rest = body.shift(displacement[key].astype(t.dtype) + low[key], point) - own
        low[name] = _tied(t, left, node, end, rest.astype(own.dtype))
    return low


def moved_ends(model: Model) -> Iterator[tuple[str, int, Driven]]:
    """Ends that are moved along paths: (line, its end, what is there)."""
    for name, node, end in model.driven():
        if not isinstance(end.motion, Still):
            yield name, node, end


def start_velocities(model: Model, velocity: dict[str, Array]) -> dict[str, Array]:
    """Velocities (m/s) at the start: bodies as they are let go, lines at rest but for their ends."""
    moved = dict(velocity)
    zero = {}
    for name, body in model.bodies.items():
        zero[body_key(name)] = jnp.zeros_like(body.reference)
        start = body.start_velocity
        moved[body_key(name)] = jnp.zeros_like(body.reference) if start is None else start
    return follow_rate(model, jnp.zeros(()), zero, moved)


def body_gain(
    model: Model, name: str, t: Float[Array, ""], found: Found, displacement: dict[str, Array],
    before: dict[str, Array], dt: Float[Array, ""] | None,
) -> BodyGain:  # fmt: skip
    """Acceleration of a body under its own forces and those of the lines that are tied to it.

    Over a kick of length dt (s), what depends on velocities is taken at the middle of the kick: from
    a first gain for the body, and for the drag of the ends' nodes by its linear part, as at a junction.
    """
    body, v = model.bodies[name], before[body_key(name)]
    first = _gain_at(model, name, body, t, found, displacement, before, v, dt)
    if dt is None:
        return first
    middle = v + 0.5 * dt * first.gain
    return _gain_at(model, name, body, t, found, displacement, before, middle, dt)


def _gain_at(
    model: Model, name: str, body: AbstractBody, t, found: Found, displacement, before, middle, dt
) -> BodyGain:
    """The gain from `before` on, with forces that depend on velocities taken at `middle`."""
    key = body_key(name)
    q, v = body.reference + displacement[key], before[key]
    half = 0.0 if dt is None else 0.5 * dt
    matrix, vector = body.mass(q, t), body.force(q, middle, t)
    pull = body_force(model, name, found, displacement)
    vector = vector if pull is None else vector + pull
    parts = {}
    for line, node, end in attached_ends(model, name):
        e = found[line]
        turn, w, bias = body.rate(q, middle, end.point)
        mass, drag, flow = end_matrices(e.nodes, node, w)
        force = e.force[:, node] - drag @ (turn @ v - flow) - mass @ bias
        mass = mass + half * drag
        active = 1.0
        if end.release is not None:
            active = jnp.where(end.release.begun(t), 0.0, 1.0).astype(v.dtype)
            # what still holds the end while it breaks pulls the body the other way
            still = e.ends[0 if node == 0 else 1]
            assert still is not None  # known of every end that can break
            vector = vector - (1.0 - active) * (turn.T @ still)
        matrix = matrix + active * (turn.T @ mass @ turn)
        vector = vector + active * (turn.T @ force)
        parts[line, node] = (turn, mass, force)
    gain = _solved(matrix, vector, body.free)
    if body.friction is not None:
        gain, found.held[name] = _held_back(body, matrix, vector, q, v, dt)
    if isinstance(body, Winch):
        gain = body.limited(v, gain, dt)
    pulls = {end: mass @ (turn @ gain) - force for end, (turn, mass, force) in parts.items()}
    return BodyGain(gain, pulls)


def _held_back(
    body: AbstractBody, matrix: Array, vector: Array, q: Array, v: Array, dt
) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """The gain of a body on a bed, and the friction on it (N), each (m,).

    Friction takes what would stop the body in this kick, or mu N where that is less, against it: a body
    that it stops does not creep. N is what holds up the body in its motion. At an instant (dt None) a
    body at rest is held, and one that moves is pushed against its motion.
    """
    friction = body.friction
    assert friction is not None
    level = friction.level(v)
    free = jnp.ones_like(v) if body.free is None else body.free
    stop = jnp.zeros_like(v) if dt is None else -level * free * v / dt
    still = stop + _solved(matrix, vector - matrix @ stop, free * (1.0 - level))
    needed = level * free * (matrix @ still - vector)
    against, moving = needed, False
    if dt is None:
        rate = level * free * v
        moving = jnp.any(rate != 0.0)
        against = jnp.where(moving, -rate, needed)
    square = dot(against, against)
    size = jnp.sqrt(jnp.where(square > 0.0, square, 1.0))
    way = against / size
    if dt is not None and friction.up.shape[0] > 2:
        # in two directions against the motion after the kick, not against what would stop it
        limit = friction.limit(matrix @ still - vector, q, v)
        slides = square > limit**2
        inertia = MatrixInertia(_level_inertia(matrix, level * free, free))
        start = jnp.where(slides, way, 1.0)[:2, None]
        turned = against_motion(start, inertia, jnp.where(slides, limit / size, 1.0)[None])
        way = jnp.where(slides, jnp.pad(turned[:, 0], (0, v.shape[0] - 2)), way)
    gain, force = still, needed
    for _ in range(SLIDES):
        limit = friction.limit(matrix @ gain - vector, q, v)
        slides = moving | (dot(needed, needed) > limit**2)
        force = jnp.where(slides, limit * way, needed)
        gain = jnp.where(slides, _solved(matrix, vector + limit * way, free), still)
    return gain, force


def _level_inertia(matrix: Array, level: Array, free: Array) -> Float[Array, "2 2"]:
    """What resists forces along the bed, along x and y, the other coordinates left to follow (kg).

    1 where the body cannot slide.
    """
    units = jnp.diag(level)[:2]
    yields = jnp.stack([_solved(matrix, unit, free)[:2] * level[:2] for unit in units])
    (a, b), (_, c) = yields + jnp.diag(1.0 - level[:2])
    return jnp.stack([c, -b, -b, a]).reshape(2, 2) / (a * c - b * b)


def _solved(matrix: Array, vector: Array, free: Array | None) -> Array:
    """Accelerations of the free coordinates, 0 for those that are held."""
    if free is None:
        return solve_small(matrix, vector)
    only = matrix * jnp.outer(free, free) + jnp.diag(1.0 - free)
    return solve_small(only, vector * free)


def pull_of_lines(
    model: Model, net: Net, name: str, forces: Float[Array, "places d"], q: Float[Array, " m"]
) -> Float[Array, " m"]:
    """J^T F (N, N m) on a body at q, of the `forces` (N) on the ends that are tied to it."""
    ends, pulls = tied_to(model, net, name, forces, q)
    return jnp.einsum("edm,ed->m", ends, pulls)


def tied_to(
    model: Model, net: Net, name: str, forces: Float[Array, "places d"], q: Float[Array, " m"]
) -> tuple[Float[Array, "e d m"], Float[Array, "e d"]]:
    """J of the ends that are tied to a body at q, and the forces (N) on them."""
    d = forces.shape[1]
    points = [end.point for _, _, end in attached_ends(model, name)]
    points = jnp.stack(points) if points else jnp.zeros((0, d))
    pulls = forces[net.tied[name]] if name in net.tied else jnp.zeros((0, d))
    return jax.vmap(jax.jacfwd(model.bodies[name].place), (None, 0))(q, points), pulls
