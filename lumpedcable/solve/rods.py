"""The banded system of a path of rods: who pulls whom, and what lengths ask of accelerations.

The unknowns of a place are the accelerations of its coordinates and the tension of the rod before it.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.ends import Attached, Driven
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path
from lumpedcable.model.rods import RodEnds, Spread, along_path, forces_along_path, path_spread
from lumpedcable.physics.motion import mean_velocity_of
from lumpedcable.physics.rod import ROD_SHARES, rod_drag, rod_mass
from lumpedcable.physics.vectors import dot

__all__ = ["Chain", "chain_of", "system_of"]


class Chain(NamedTuple):
    """A path at the start of a kick; P places with s coordinates each, n = P - 1 rods.

    turns (n, d, s) and drifts (d, n) of both ends of the rods: with a the accelerations of the
    coordinates, ends accelerate by J a + drift. before: rates (P, s) half a step earlier.
    pinned: coordinates (P, s) whose rate after the kick is `target` (P, s).
    """

    path: Path
    spread: Spread
    tangent: Float[Array, "d n"]
    first: Float[Array, "n d s"]
    last: Float[Array, "n d s"]
    place: RodEnds
    speed: RodEnds
    flow: RodEnds | None
    force: RodEnds
    before: Float[Array, "P s"]
    pinned: Bool[Array, "P s"]
    target: Float[Array, "P s"]


def chain_of(model: Model, path: Path, t, found, displacement, before, dt, ahead) -> Chain:
    """Everything of a path that stays the same through the iterates of a kick."""
    d = next(iter(model.lines.values())).dimensions
    sizes = [model.bodies[name].reference.shape[0] for name in path.bodies.values()]
    size, rods = max([d, *sizes]), path.places - 1
    dtype = before[path.legs[0].line].dtype
    plain = jnp.broadcast_to(jnp.eye(d, size, dtype=dtype), (rods, d, size))
    first = last = plain
    rates = jnp.zeros((path.places, size), dtype)
    pinned = jnp.zeros((path.places, size), bool).at[:, d:].set(True)
    target = jnp.zeros((path.places, size), dtype)
    for leg in path.legs:
        own = before[leg.line].T
        own = own[::-1] if leg.backward else own
        rates = rates.at[leg.first : leg.first + leg.rods + 1, :d].set(own)
    for (place, side), (line, node) in path.points.items():
        end = model.ends[line][0 if node == 0 else 1]
        if isinstance(end, Driven):
            pinned = pinned.at[place].set(True)
            mean = mean_velocity_of(end.motion, t, ahead).astype(dtype)
            target = target.at[place, :d].set(mean)
        if isinstance(end, Attached):
            name = end.body
            body, key = model.bodies[name], body_key(name)
            m = body.reference.shape[0]
            q, v = body.reference + displacement[key], before[key]
            turn = jnp.zeros((d, size), dtype).at[:, :m].set(body.rate(q, v, end.point)[0])
            if side == 1:
                first = first.at[place].set(turn)
            else:
                last = last.at[place - 1].set(turn)
            rates = rates.at[place].set(jnp.zeros(size, dtype).at[:m].set(v))
            free = jnp.ones(m) if body.free is None else body.free
            pinned = pinned.at[place].set(jnp.ones(size, bool).at[:m].set(free == 0.0))
    nodal = {leg.line: found[leg.line] for leg in path.legs}
    flows = {n: e.nodes.flow for n, e in nodal.items() if e.nodes.flow is not None}
    still = {n: jnp.zeros_like(e.force) for n, e in nodal.items()}
    flow = along_path(path, still | flows) if flows else None
    place = along_path(path, {n: e.line.shape.position for n, e in nodal.items()})
    step = place.last - place.first
    return Chain(
        path=path,
        spread=path_spread(path, model.lines),
        tangent=step / jnp.sqrt(dot(step, step)),
        first=first,
        last=last,
        place=place,
        speed=along_path(path, before),
        flow=flow,
        force=forces_along_path(path, {n: e.force for n, e in nodal.items()}),
        before=rates,
        pinned=pinned,
        target=target,
    )


def system_of(model: Model, chain: Chain, displacement, gain, pushes, dt, ahead):
    """Blocks (lower, diagonal, upper) and right side of an iterate; nothing is pinned yet.

    `gain` (P, s) are the accelerations of the iterate before, `pushes` forces (s,) on bodies by place.
    """
    rods = chain.tangent.shape[1]
    places, size = chain.before.shape
    middle = chain.before + 0.5 * dt * gain
    whole = rod_mass(chain.spread.along, chain.spread.across, chain.tangent)
    first, last, flip = chain.first, chain.last, lambda x: jnp.swapaxes(x, 1, 2)
    own, between = ROD_SHARES
    mass = jnp.zeros((places, size, size), middle.dtype)
    mass = mass.at[:-1].add(flip(first) @ (own * whole) @ first)
    mass = mass.at[1:].add(flip(last) @ (own * whole) @ last)
    cross = flip(first) @ (between * whole) @ last  # (n, s, s)
    force, drift = _forces(model, chain, displacement, middle)
    spun = (own * whole @ drift.first[..., None] + between * whole @ drift.last[..., None])[..., 0]
    spin = (between * whole @ drift.first[..., None] + own * whole @ drift.last[..., None])[..., 0]
    right = jnp.zeros((places, size), middle.dtype)
    right = right.at[:-1].add((flip(first) @ (force.first.T - spun)[..., None])[..., 0])
    right = right.at[1:].add((flip(last) @ (force.last.T - spin)[..., None])[..., 0])
    mass, right = _carried(model, chain, displacement, middle, pushes, mass, right)

    # a rod's pull u T on its first place, against it on its last
    ahead_of = (flip(first) @ chain.tangent.T[..., None])[..., 0]
    behind = (flip(last) @ chain.tangent.T[..., None])[..., 0]
    ends = _ends_after(model, chain, displacement, gain, dt, ahead)
    step = ends.last - ends.first
    far = jnp.sqrt(dot(step, step))
    row = (step / far).T  # u'
    row_first = (row[:, None, :] @ first)[:, 0, :]
    row_last = (row[:, None, :] @ last)[:, 0, :]
    reached = jnp.sum(row_last * gain[1:] - row_first * gain[:-1], axis=1)
    wanted = reached - (far - chain.spread.length) / (dt * ahead)

    one = jnp.ones((1, 1, 1), middle.dtype)
    corner = jnp.concatenate([one, jnp.zeros((rods, 1, 1), middle.dtype)])
    pad = lambda x: jnp.concatenate([jnp.zeros_like(x[:1]), x])  # noqa: E731
    diagonal = jnp.concatenate(
        [
            jnp.concatenate([mass, pad(behind)[:, :, None]], axis=2),
            jnp.concatenate([pad(row_last)[:, None, :], corner], axis=2),
        ],
        axis=1,
    )
    none = jnp.zeros((rods, 1, 1), middle.dtype)
    upper = jnp.concatenate(
        [
            jnp.concatenate([cross, -ahead_of[:, :, None]], axis=2),
            jnp.concatenate([jnp.zeros_like(cross[:, :1]), none], axis=2),
        ],
        axis=1,
    )
    lower = jnp.concatenate(
        [
            jnp.concatenate([flip(cross), jnp.zeros_like(behind)[:, :, None]], axis=2),
            jnp.concatenate([-row_first[:, None, :], none], axis=2),
        ],
        axis=1,
    )
    right = jnp.concatenate([right, pad(wanted)[:, None]], axis=1)
    block = jnp.zeros_like(diagonal[:1])
    return (
        jnp.concatenate([block, lower]),
        diagonal,
        jnp.concatenate([upper, block]),
    ), right


def _ends_after(model: Model, chain: Chain, displacement, gain, dt, ahead) -> RodEnds:
    """Where the rods' ends are after the step of positions that follows (m)."""
    rates = chain.before + dt * gain
    d = chain.tangent.shape[0]
    first = chain.place.first + ahead * rates[:-1, :d].T
    last = chain.place.last + ahead * rates[1:, :d].T
    for (place, side), (line, node) in chain.path.points.items():
        end = model.ends[line][0 if node == 0 else 1]
        if not isinstance(end, Attached):
            continue
        name, body = end.body, model.bodies[end.body]
        m = body.reference.shape[0]
        u = displacement[body_key(name)] + ahead * rates[place, :m]
        where = model.lines[line].reference[:, node] + body.shift(u, end.point)
        if side == 1:
            first = first.at[:, place].set(where)
        else:
            last = last.at[:, place - 1].set(where)
    return RodEnds(first, last)


def _forces(model: Model, chain: Chain, displacement, middle) -> tuple[RodEnds, RodEnds]:
    """Forces on the rods' ends (N), and the drifts (n, d) that bodies' turning gives them (m/s2)."""
    d, rods = chain.tangent.shape
    first, last = middle[:-1, :d].T, middle[1:, :d].T
    drifts = [jnp.zeros((rods, d), middle.dtype)] * 2
    for (place, side), (line, node) in chain.path.points.items():
        end = model.ends[line][0 if node == 0 else 1]
        if not isinstance(end, Attached):
            continue
        name, body = end.body, model.bodies[end.body]
        q = body.reference + displacement[body_key(name)]
        m = q.shape[0]
        _, v, drift = body.rate(q, middle[place, :m], end.point)
        if side == 1:
            first, drifts[0] = first.at[:, place].set(v), drifts[0].at[place].set(drift)
        else:
            last, drifts[1] = last.at[:, place - 1].set(v), drifts[1].at[place - 1].set(drift)
    force = chain.force
    if any(model.lines[leg.line].drag is not None for leg in chain.path.legs):
        if chain.flow is not None:
            first, last = first - chain.flow.first, last - chain.flow.last
        spread = chain.spread
        drag = rod_drag(spread.normal, spread.tangential, chain.tangent, first, last)
        force = RodEnds(force.first + drag[0], force.last + drag[1])
    return force, RodEnds(*drifts)


def _carried(model: Model, chain: Chain, displacement, middle, pushes, mass, right):
    """Masses and forces of bodies and junctions added to those of the rods."""
    d = chain.tangent.shape[0]
    for place, name in chain.path.bodies.items():
        body = model.bodies[name]
        q = body.reference + displacement[body_key(name)]
        m = q.shape[0]
        mass = mass.at[place, :m, :m].add(body.mass(q))
        right = right.at[place, :m].add(body.force(q, middle[place, :m]))
        if place in pushes:
            right = right.at[place].add(pushes[place])
    for place, index in chain.path.junctions.items():
        junction = model.junctions[index]
        if junction.mass is not None:
            mass = mass.at[place, :d, :d].add(junction.mass * jnp.eye(d, dtype=mass.dtype))
        if junction.load is not None:
            right = right.at[place, :d].add(junction.load)
    return mass, right
