"""A step for lines that keep their length: tensions and accelerations from one banded system.

Leapfrog as for other lines, x_n+1 = x_n + dt v_n+1/2 and v_n+3/2 = v_n+1/2 + dt a_n+1, but the
accelerations hold the tensions of rods as unknowns, which are such that the rods have their lengths
after the next step of positions (SHAKE: Ryckaert, Ciccotti & Berendsen, J. Comput. Phys. 23, 1977):

    M a - sum of u T = F,      |x_j+1 - x_j + dt (v_j+1 - v_j) + dt^2 (a_j+1 - a_j)| = l_j,

u the rods' directions now. Linearised about what the last iterate would lead to, (a_j, T_j-1) of one
place and the next make a block tridiagonal system, O(N) (Newton's method; the second iterate is left
with an error of the fourth order in dt). Forces that depend on velocity are taken at the middle of the
kick, (v_n+1/2 + v_n+3/2) / 2, from the iterate before, so that the step is of second order. Coulomb's
friction of a body picks one of two systems: stuck, where its coordinate is pinned, or sliding.
"""

from typing import ClassVar, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.attached import body_gain, follow_rate
from lumpedcable.model.bodies import body_key
from lumpedcable.model.ends import Driven
from lumpedcable.model.energy import powers
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path, paths_of
from lumpedcable.model.rods import (
    RodEnds,
    Spread,
    along_path,
    forces_along_path,
    path_spread,
    to_lines,
    to_segments,
)
from lumpedcable.model.state import State
from lumpedcable.physics.motion import mean_velocity_of
from lumpedcable.physics.rod import ROD_SHARES, rod_drag, rod_mass
from lumpedcable.physics.vectors import dot
from lumpedcable.solve.banded import solve_chain
from lumpedcable.solve.leapfrog import CableTerm

__all__ = ["Constrained"]

ITERATES = 3


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


class Grip(NamedTuple):
    """What friction does to a body in one iterate: whether it slides, and the force (s,) if it does."""

    sliding: Bool[Array, ""]
    force: Float[Array, " s"]


class Constrained(diffrax.AbstractSolver):
    """Leapfrog with rods; the step must be constant."""

    term_structure: ClassVar = CableTerm
    interpolation_cls: ClassVar = diffrax.LocalLinearInterpolation

    def order(self, terms):
        """2."""
        return 2

    def init(self, terms, t0, t1, y0, args):
        """Velocities and work half a step after the start, from a kick of half a step."""
        t0, dt = jnp.asarray(t0), jnp.asarray(t1 - t0)
        kicked = kick(args, t0, y0.displacement, y0.velocity, y0.tension, 0.5 * dt, dt)
        work = _worked(args, t0, y0, y0.displacement, y0.velocity, kicked, 0.5 * dt)
        return kicked.after, work, dt

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """One step from t0 to t1 (s)."""
        before, work, dt = solver_state
        t1 = jnp.asarray(t1)
        place = jax.tree.map(lambda x, v: x + dt * v, y0.displacement, before)
        place = args.followed(t1, place)
        kicked = kick(args, t1, place, before, y0.tension, dt, dt)
        now = after = work
        if work:
            whole = _worked(args, t1, y0, place, before, kicked, dt)
            now = jax.tree.map(lambda w, p: w + 0.5 * p, work, whole)
            after = jax.tree.map(lambda w, p: w + p, work, whole)
        y1 = State(place, kicked.middle, now, y0.reaction, kicked.tension)
        dense = {"y0": y0, "y1": y1}
        return y1, None, dense, (kicked.after, after, dt), diffrax.RESULTS.successful

    def func(self, terms, t0, y0, args):
        """Rates at an instant: what a solver of diffrax may be asked for; no step uses it."""
        raise NotImplementedError("rods have no rates without a step")


class Kicked(NamedTuple):
    """Velocities at the middle and at the end of a kick, tensions (N), friction's forces on bodies."""

    middle: dict[str, Array]
    after: dict[str, Array]
    tension: dict[str, Array]
    friction: dict[str, Array]
    found: dict


def _worked(model: Model, t, y: State, place, before, kicked: Kicked, dt) -> dict:
    """Work (J) of a kick of length dt (s), by line or body and kind; empty where none is asked for."""
    if not y.work:
        return y.work
    power = powers(
        model, t, kicked.found, place, before, kicked.middle, kicked.after, dt, kicked.friction
    )
    return {n: {k: dt * power[n][k] for k in kinds} for n, kinds in y.work.items()}


def kick(model: Model, t, displacement, before, tension, dt, ahead) -> Kicked:
    """A kick of length dt (s) centred on t or, at the start, from t on.

    `ahead` (s) is the step of positions that follows, at whose end the rods have their lengths.
    """
    found = model.evaluate(t, displacement, before, {}, None)
    middle, after, carried, held = {}, {}, {}, {}
    walked: set[str] = set()
    for path in paths_of(model):
        mine = _kick_path(model, path, t, found, displacement, before, tension, dt, ahead)
        middle, after = middle | mine.middle, after | mine.after
        carried, held = carried | mine.tension, held | mine.friction
        walked |= set(path.bodies.values())
    for name in set(model.bodies) - walked:
        key = body_key(name)
        gain = body_gain(model, name, t, found, displacement, before, dt).gain
        middle[key], after[key] = before[key] + 0.5 * dt * gain, before[key] + dt * gain
    if model.bodies:
        middle = follow_rate(model, t, displacement, middle)
        after = follow_rate(model, t, displacement, after, ahead)
    return Kicked(middle, after, carried, held, found)


def _kick_path(
    model: Model, path: Path, t, found, displacement, before, tension, dt, ahead
) -> Kicked:
    chain = _chain(model, path, t, found, displacement, before, dt, ahead)
    grips = {
        place: _first_grip(model, chain, place)
        for place, name in path.bodies.items()
        if model.bodies[name].friction is not None
    }
    gain = jnp.zeros_like(chain.before)
    needed: dict[int, Array] = {}
    used = grips
    for _ in range(ITERATES):
        used = grips
        matrix, right = _system(model, chain, displacement, gain, grips, dt, ahead)
        lower, diagonal, upper = matrix
        now = _pins(model, chain, grips, dt)
        held = jnp.concatenate([now[0], jnp.zeros_like(now[0][:, :1])], axis=1)
        aim = jnp.concatenate([now[1], jnp.zeros_like(now[1][:, :1])], axis=1)
        eye = jnp.eye(right.shape[1], dtype=right.dtype)
        x = solve_chain(
            jnp.where(held[:, :, None], 0.0, lower),
            jnp.where(held[:, :, None], eye, diagonal),
            jnp.where(held[:, :, None], 0.0, upper),
            jnp.where(held, aim, right),
        )
        gain, pull = x[:, :-1], x[1:, -1]
        needed = {place: _needed(chain, place, matrix, right, x) for place in grips}
        grips = {
            place: _next_grip(model, chain, place, needed[place], x[place, :-1], grip, dt)
            for place, grip in grips.items()
        }
    d = chain.tangent.shape[0]
    # a pinned coordinate ends at its target exactly: what sticks does not creep
    ends = jnp.where(now[0], chain.before + dt * now[1], chain.before + dt * gain)
    ends = jnp.where(now[0] & (jnp.abs(ends) < 1e-15), 0.0, ends)
    half = 0.5 * (chain.before + ends)
    after, middle = to_lines(path, ends[:, :d].T), to_lines(path, half[:, :d].T)
    friction = {}
    for place, name in path.bodies.items():
        key, m = body_key(name), model.bodies[name].reference.shape[0]
        after[key], middle[key] = ends[place, :m], half[place, :m]
        if place in grips:
            level, grip = _level(model, chain, place), used[place]
            sticking = jnp.where(level, needed[place], 0.0)
            friction[name] = jnp.where(grip.sliding, grip.force, sticking)[:m]
    return Kicked(middle, after, to_segments(path, pull), friction, found)


def _chain(model: Model, path: Path, t, found, displacement, before, dt, ahead) -> Chain:
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
        if place in path.bodies:
            name = path.bodies[place]
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
    flow = {n: e.nodes.flow for n, e in nodal.items() if e.nodes.flow is not None}
    if flow:
        still = {n: jnp.zeros_like(e.force) for n, e in nodal.items()}
        flow = along_path(path, still | flow)
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
        flow=flow or None,
        force=forces_along_path(path, {n: e.force for n, e in nodal.items()}),
        before=rates,
        pinned=pinned,
        target=target,
    )


def _pins(model: Model, chain: Chain, grips: dict[int, Grip], dt):
    """Pinned coordinates (P, s) and their accelerations (m/s2)."""
    pinned, target = chain.pinned, chain.target
    for place, grip in grips.items():
        level = _level(model, chain, place)
        pinned = pinned.at[place].set(pinned[place] | (level & ~grip.sliding))
    return pinned, (target - chain.before) / dt


def _level(model: Model, chain: Chain, place: int) -> Bool[Array, " s"]:
    """The coordinates in which a body slides on the bed."""
    up = model.bodies[chain.path.bodies[place]].friction.up
    size = chain.before.shape[1]
    return jnp.zeros(size, bool).at[: up.shape[0]].set(jnp.abs(up) < 0.5)


def _ends_after(model: Model, chain: Chain, displacement, gain, dt, ahead) -> RodEnds:
    """Where the rods' ends are after the step of positions that follows (m)."""
    rates = chain.before + dt * gain
    d = chain.tangent.shape[0]
    first = chain.place.first + ahead * rates[:-1, :d].T
    last = chain.place.last + ahead * rates[1:, :d].T
    for (place, side), (line, node) in chain.path.points.items():
        if place not in chain.path.bodies:
            continue
        name = chain.path.bodies[place]
        body, end = model.bodies[name], model.ends[line][0 if node == 0 else 1]
        m = body.reference.shape[0]
        u = displacement[body_key(name)] + ahead * rates[place, :m]
        where = model.lines[line].reference[:, node] + body.shift(u, end.point)
        if side == 1:
            first = first.at[:, place].set(where)
        else:
            last = last.at[:, place - 1].set(where)
    return RodEnds(first, last)


def _system(model: Model, chain: Chain, displacement, gain, grips, dt, ahead):
    """Blocks (lower, diagonal, upper) and right side of an iterate; nothing is pinned yet."""
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
    mass, right = _carried(model, chain, displacement, middle, grips, mass, right)

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


def _forces(model: Model, chain: Chain, displacement, middle) -> tuple[RodEnds, RodEnds]:
    """Forces on the rods' ends (N), and the drifts (n, d) that bodies' turning gives them (m/s2)."""
    d, rods = chain.tangent.shape
    first, last = middle[:-1, :d].T, middle[1:, :d].T
    drifts = [jnp.zeros((rods, d), middle.dtype)] * 2
    for (place, side), (line, node) in chain.path.points.items():
        if place not in chain.path.bodies:
            continue
        name = chain.path.bodies[place]
        body, end = model.bodies[name], model.ends[line][0 if node == 0 else 1]
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


def _carried(model: Model, chain: Chain, displacement, middle, grips, mass, right):
    """Masses and forces of bodies and junctions added to those of the rods."""
    d = chain.tangent.shape[0]
    for place, name in chain.path.bodies.items():
        body = model.bodies[name]
        q = body.reference + displacement[body_key(name)]
        m = q.shape[0]
        mass = mass.at[place, :m, :m].add(body.mass(q))
        right = right.at[place, :m].add(body.force(q, middle[place, :m]))
        if place in grips:
            grip = grips[place]
            right = right.at[place].add(jnp.where(grip.sliding, grip.force, 0.0))
    for place, index in chain.path.junctions.items():
        junction = model.junctions[index]
        if junction.mass is not None:
            mass = mass.at[place, :d, :d].add(junction.mass * jnp.eye(d, dtype=mass.dtype))
        if junction.load is not None:
            right = right.at[place, :d].add(junction.load)
    return mass, right


def _first_grip(model: Model, chain: Chain, place: int) -> Grip:
    """Sliding where it moves; the force against it is not known before a first iterate."""
    level = _level(model, chain, place)
    moving = jnp.any(jnp.where(level, chain.before[place], 0.0) != 0.0)
    return Grip(moving, jnp.zeros_like(chain.before[place]))


def _needed(chain: Chain, place: int, matrix, right, x) -> Float[Array, " s"]:
    """The force (N) on a place that its motion needs beyond the known ones: what pins it."""
    lower, diagonal, upper = matrix
    out = diagonal[place] @ x[place] - right[place]
    if place > 0:
        out = out + lower[place] @ x[place - 1]
    if place < x.shape[0] - 1:
        out = out + upper[place] @ x[place + 1]
    return out[:-1]


def _next_grip(model: Model, chain: Chain, place: int, needed, gain, grip: Grip, dt) -> Grip:
    """What friction does in the next iterate, from the forces and accelerations of this one."""
    friction = model.bodies[chain.path.bodies[place]].friction
    assert friction is not None
    level = _level(model, chain, place)
    up = jnp.zeros_like(needed).at[: friction.up.shape[0]].set(friction.up)
    limit = friction.coefficient * jnp.maximum(jnp.dot(up, needed), 0.0)
    rate = jnp.where(level, chain.before[place], 0.0)
    pull = jnp.where(level, needed, 0.0)
    speed, size = jnp.sqrt(jnp.sum(rate**2)), jnp.sqrt(jnp.sum(pull**2))
    # sliding: against the motion; about to slide: against the pull
    moving = speed > 0.0
    against = jnp.where(
        moving,
        -rate / jnp.where(moving, speed, 1.0),
        pull / jnp.where(size > 0.0, size, 1.0),
    )
    turned = moving & (jnp.dot(rate + dt * jnp.where(level, gain, 0.0), rate) < 0.0)
    return Grip(jnp.where(grip.sliding, ~turned, size > limit), limit * against)
