"""A path of rods at the start of a kick: what stays the same through its iterates."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.ends import Attached, Driven
from lumpedcable.model.model import Model
from lumpedcable.model.paths import AFTER, Path
from lumpedcable.model.rods import RodEnds, Spread, along_path, forces_along_path, path_spread
from lumpedcable.physics.motion import mean_velocity_of, velocity_of
from lumpedcable.physics.place import place
from lumpedcable.physics.rod import rod_mass
from lumpedcable.physics.vectors import dot

__all__ = ["Chain", "Guess", "Hub", "chain_of", "first_guess"]


class Hub(NamedTuple):
    """A body at a place of a path: its coordinates q and their rates v half a step ago, each (m,).

    `points` are where rods are tied to it, by side (`BEFORE` or `AFTER` the place), with J = dr/dq
    (d, m) in `turns`; `mass` is M(q); `reduced`: the place stands for the one point, not for q.
    """

    body: AbstractBody
    q: Float[Array, " m"]
    v: Float[Array, " m"]
    mass: Float[Array, "m m"]
    points: dict[int, Float[Array, " d"]]
    turns: dict[int, Float[Array, "d m"]]
    reduced: bool


class Chain(NamedTuple):
    """A path at the start of a kick; P places with s coordinates each, n = P - 1 rods.

    first, last (n, d, s): what turns accelerations of places into those of the rods' ends, None where
    they are the same. before: rates (P, s) half a step earlier. driven: velocities (d,) to come, means
    over a step. t (s): now.
    """

    path: Path
    spread: Spread
    tangent: Float[Array, "d n"]
    whole: Float[Array, "n d d"]
    first: Float[Array, "n d s"] | None
    last: Float[Array, "n d s"] | None
    place: RodEnds
    flow: RodEnds | None
    force: RodEnds
    before: Float[Array, "P s"]
    hubs: dict[int, Hub]
    driven: dict[int, Float[Array, " d"]]
    t: Float[Array, ""]


class Guess(NamedTuple):
    """Accelerations of the places (P, s) and of bodies, by place, in their own coordinates (m,)."""

    places: Float[Array, "P s"]
    bodies: dict[int, Float[Array, " m"]]


def chain_of(model: Model, path: Path, t, found, displacement, before, ahead) -> Chain:
    """Everything of a path that stays the same through the iterates of a kick.

    `ahead` (s) is the step of positions that follows; None at an instant, as of a jerk.
    """
    d = next(iter(model.lines.values())).dimensions
    hubs = _hubs(model, path, t, displacement, before)
    size = max([d, *(hub.q.shape[0] for hub in hubs.values() if not hub.reduced)])
    parts = []
    for leg in path.legs:
        own = before[leg.line].T
        own = own[::-1] if leg.backward else own
        parts.append(own if leg is path.legs[-1] else own[:-1])
    rates = jnp.pad(jnp.concatenate(parts), ((0, 0), (0, size - d)))
    first = last = None
    if any(not hub.reduced for hub in hubs.values()):
        first = last = jnp.broadcast_to(jnp.eye(d, size), (path.places - 1, d, size))
    for at, hub in hubs.items():
        if hub.reduced:
            continue
        assert first is not None
        assert last is not None
        m = hub.q.shape[0]
        rates = place(rates, jnp.pad(hub.v, (0, size - m))[None], at, 0)
        for side, turn in hub.turns.items():
            wide = jnp.pad(turn, ((0, 0), (0, size - m)))[None]
            if side == AFTER:
                first = place(first, wide, at, 0, 0)
            else:
                last = place(last, wide, at - 1, 0, 0)
    driven = {}
    for (at, _), (line, node) in path.points.items():
        end = model.end(line, node)
        if isinstance(end, Driven):
            path_of = end.motion
            v = velocity_of(path_of, t) if ahead is None else mean_velocity_of(path_of, t, ahead)
            driven[at] = v.astype(rates.dtype)
    nodal = {leg.line: found[leg.line] for leg in path.legs}
    flows = {n: e.nodes.flow for n, e in nodal.items() if e.nodes.flow is not None}
    still = {n: jnp.zeros_like(e.force) for n, e in nodal.items()}
    flow = along_path(path, still | flows) if flows else None
    where = along_path(path, {n: e.line.shape.position for n, e in nodal.items()})
    step = where.last - where.first
    tangent = step / jnp.sqrt(dot(step, step))
    spread = path_spread(path, model.lines)
    return Chain(
        path=path,
        spread=spread,
        tangent=tangent,
        whole=rod_mass(spread.along, spread.across, tangent),
        first=first,
        last=last,
        place=where,
        flow=flow,
        force=forces_along_path(path, {n: e.force for n, e in nodal.items()}),
        before=rates,
        hubs=hubs,
        driven=driven,
        t=t,
    )


def _hubs(model: Model, path: Path, t, displacement, before) -> dict[int, Hub]:
    found: dict[int, Hub] = {}
    for at, name in path.bodies.items():
        body, key = model.bodies[name], body_key(name)
        q, v = body.reference + displacement[key], before[key]
        points = {}
        for (where, side), (line, node) in path.points.items():
            end = model.end(line, node)
            if where == at and isinstance(end, Attached):
                points[side] = end.point
        turns = {side: body.rate(q, v, point)[0] for side, point in points.items()}
        found[at] = Hub(body, q, v, body.mass(q, t), points, turns, len(points) == 1)
    return found


def first_guess(chain: Chain) -> Guess:
    """No acceleration anywhere."""
    return Guess(
        jnp.zeros_like(chain.before), {at: jnp.zeros_like(hub.v) for at, hub in chain.hubs.items()}
    )
