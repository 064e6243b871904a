"""The banded system of a path of rods: who pulls whom, and what lengths ask of accelerations.

The unknowns of a place are the accelerations of its coordinates and the tension of the rod before it.
A place has the coordinates of space, or those of a body in the middle of the path. Where a path ends at
a body or at something that moves it, its row is M a - F of the rods, weighed with what their force
moves there: a + W (M a - F) = r. W = 0 pins it, and no coordinate of a body has to stand in a block.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.ends import Attached, Driven, solve_small
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path
from lumpedcable.model.rods import RodEnds, Spread, along_path, forces_along_path, path_spread
from lumpedcable.physics.motion import mean_velocity_of
from lumpedcable.physics.place import place
from lumpedcable.physics.rod import ROD_SHARES, rod_drag, rod_mass
from lumpedcable.physics.vectors import dot
from lumpedcable.solve.matrices import at_first, at_last, both, flip, onto, times

__all__ = [
    "Chain",
    "Guess",
    "Hub",
    "Push",
    "System",
    "chain_of",
    "first_guess",
    "hub_gain",
    "pinned_of",
    "system_of",
]


class Hub(NamedTuple):
    """A body at a place of a path: its coordinates q and their rates v half a step ago, each (m,).

    `points` are where rods are tied to it, by side (1: the rod after the place), with J = dr/dq (d, m)
    in `turns`; `mass` is M(q); `reduced`: the place stands for the one point, not for q.
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
    they are the same. before: rates (P, s) half a step earlier. driven: mean velocities (d,) to come.
    t (s): now.
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


class Push(NamedTuple):
    """A force (m,) on a body (N), and which of its coordinates are pinned, to stand still."""

    force: Float[Array, " m"]
    pinned: Float[Array, " m"]


class Guess(NamedTuple):
    """Accelerations of the places (P, s) and of bodies, by place, in their own coordinates (m,)."""

    places: Float[Array, "P s"]
    bodies: dict[int, Float[Array, " m"]]


class System(NamedTuple):
    """Blocks (lower, diagonal, upper) and right side of an iterate, and what follows from a solution.

    `raw` are the rods' own rows at hubs and driven places: matrices and right sides before weighing.
    """

    blocks: tuple[Array, Array, Array]
    right: Float[Array, "P b"]
    raw: dict[int, tuple[Array, Array, Array, Array]]
    known: dict[int, Float[Array, " m"]]

    def pull(self, at: int, x: Float[Array, "P b"]) -> Float[Array, " s"]:
        """The force (N) of the rods on a place: F - M a, with their tensions."""
        lower, diagonal, upper, right = self.raw[at]
        total = right - diagonal @ x[at]
        total = total - lower @ x[at - 1] if at > 0 else total
        return total - upper @ x[at + 1] if at < x.shape[0] - 1 else total


def chain_of(model: Model, path: Path, t, found, displacement, before, ahead) -> Chain:
    """Everything of a path that stays the same through the iterates of a kick."""
    d = next(iter(model.lines.values())).dimensions
    hubs = _hubs(model, path, displacement, before)
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
            if side == 1:
                first = place(first, wide, at, 0, 0)
            else:
                last = place(last, wide, at - 1, 0, 0)
    driven = {}
    for (at, _), (line, node) in path.points.items():
        end = model.end(line, node)
        if isinstance(end, Driven):
            driven[at] = mean_velocity_of(end.motion, t, ahead).astype(rates.dtype)
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


def _hubs(model: Model, path: Path, displacement, before) -> dict[int, Hub]:
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
        found[at] = Hub(body, q, v, body.mass(q), points, turns, len(points) == 1)
    return found


def first_guess(chain: Chain) -> Guess:
    """No acceleration anywhere."""
    return Guess(
        jnp.zeros_like(chain.before), {at: jnp.zeros_like(hub.v) for at, hub in chain.hubs.items()}
    )


def system_of(
    model: Model, chain: Chain, guess: Guess, pushes: dict[int, Push], dt, ahead,
    held: tuple[Array, Array] | None = None,
) -> System:  # fmt: skip
    """The system of an iterate that starts from the accelerations of the one before.

    `pushes` are the forces on bodies beside their own, and their pinned coordinates, by place; `held`
    what friction adds to the inertia (P, d, d) and to the force (P, d) of places.
    """
    (places, size), d = chain.before.shape, chain.tangent.shape[0]
    own, between = ROD_SHARES
    mass_first, mass_last = (both(j, own * chain.whole, j) for j in (chain.first, chain.last))
    cross = both(chain.first, between * chain.whole, chain.last)
    middle = chain.before + 0.5 * dt * guess.places
    force, drift = _forces(model, chain, guess, middle, dt)
    spun, spin = force.first.T, force.last.T
    if drift is not None:
        spun = (
            spun - times(own * chain.whole, drift.first) - times(between * chain.whole, drift.last)
        )
        spin = (
            spin - times(between * chain.whole, drift.first) - times(own * chain.whole, drift.last)
        )
    mass = at_first(mass_first) + at_last(mass_last)
    right = at_first(onto(chain.first, spun)) + at_last(onto(chain.last, spin))
    for at, index in chain.path.junctions.items():
        junction = model.junctions[index]
        here = (jnp.arange(places) == at).astype(mass.dtype)
        if junction.mass is not None:
            mass = mass + here[:, None, None] * junction.mass * jnp.eye(size, dtype=mass.dtype)
        if junction.load is not None:
            right = right + here[:, None] * jnp.pad(junction.load, (0, size - d))
    if held is not None:
        wide = (0, size - d)
        mass = mass + jnp.pad(held[0], ((0, 0), wide, wide))
        right = right + jnp.pad(held[1], ((0, 0), wide))
    if size > d:
        mass = mass + _padded_places(chain, size, d)

    # a rod's pull u T on its first place, against it on its last
    ahead_of, behind = onto(chain.first, chain.tangent.T), onto(chain.last, chain.tangent.T)
    ends = _ends_after(chain, guess, dt, ahead)
    step = ends.last - ends.first
    far = jnp.sqrt(dot(step, step))
    row = (step / far).T  # u'
    row_first, row_last = onto(chain.first, row), onto(chain.last, row)
    reached = jnp.sum(row_last * guess.places[1:] - row_first * guess.places[:-1], axis=1)
    wanted = reached - (far - chain.spread.length) / (dt * ahead)

    low = jnp.concatenate([flip(cross), jnp.zeros((places - 1, size, 1), mass.dtype)], axis=2)
    high = jnp.concatenate([cross, -ahead_of[:, :, None]], axis=2)
    level = jnp.concatenate([mass, at_last(behind)[:, :, None]], axis=2)
    lower, upper = at_last(low), at_first(high)
    weights = {at: _hub_weight(chain, guess, at, pushes.get(at), dt) for at in chain.hubs}
    for at, target in chain.driven.items():
        none = jnp.zeros((size, size), mass.dtype)
        aim = jnp.pad(target, (0, size - d))
        weights[at] = none, jnp.eye(size), (aim - chain.before[at]) / dt, none[0]
    raw = {at: (lower[at], level[at], upper[at], right[at]) for at in weights}
    known = {at: force_of for at, (_, _, _, force_of) in weights.items()}
    for at, (weight, matrix, vector, _) in weights.items():
        wide = jnp.pad(matrix, ((0, 0), (0, 1)))
        before, own_row, after, own_right = raw[at]
        lower = place(lower, (weight @ before)[None], at, 0, 0)
        upper = place(upper, (weight @ after)[None], at, 0, 0)
        level = place(level, (wide + weight @ own_row)[None], at, 0, 0)
        right = place(right, (vector + weight @ own_right)[None], at, 0)

    # a tension before the first place, which is none, and what rods give way by
    one = (jnp.arange(places) == 0).astype(mass.dtype) - at_last(chain.spread.give / (dt * ahead))
    one = one[:, None, None]
    last_row = jnp.concatenate([at_last(row_last)[:, None, :], one], axis=2)
    first_row = jnp.pad(at_last(-row_first)[:, None, :], ((0, 0), (0, 0), (0, 1)))
    return System(
        (
            jnp.concatenate([lower, first_row], axis=1),
            jnp.concatenate([level, last_row], axis=1),
            jnp.pad(upper, ((0, 0), (0, 1), (0, 0))),
        ),
        jnp.concatenate([right, at_last(wanted)[:, None]], axis=1),
        raw,
        known,
    )


def _hub_weight(chain: Chain, guess: Guess, at: int, push: Push | None, dt):
    """W, the matrix beside it, r of a body's place, and the known force on the body (m,).

    Free coordinates: M q'' = Q + J^T f with f the rods' pull; pinned ones come to rest in this kick.
    """
    hub, size = chain.hubs[at], chain.before.shape[1]
    m = hub.q.shape[0]
    known = hub.body.force(hub.q, hub.v + 0.5 * dt * guess.bodies[at], chain.t)
    pinned = pinned_of(hub, push)
    known = known if push is None else known + push.force
    free, stop = 1.0 - pinned, -pinned * hub.v / dt
    only = hub.mass * jnp.outer(free, free) + jnp.diag(pinned)
    force = free * (known - hub.mass @ stop)
    if not hub.reduced:
        wide, long = ((0, size - m), (0, size - m)), (0, size - m)
        return (
            jnp.pad(jnp.diag(free), wide),
            jnp.pad(only, wide),
            jnp.pad(force + stop, long),
            known,
        )
    ((side, turn),) = hub.turns.items()
    gains = jax.vmap(lambda column: solve_small(only, free * column))(turn)  # (d, m)
    drift = _rate(hub, guess.bodies[at], side, dt)[1]
    vector = gains @ known - gains @ (hub.mass @ stop) + turn @ stop + drift
    more = (0, size - turn.shape[0])
    return (
        jnp.pad(gains @ turn.T, (more, more)),
        jnp.eye(size),
        jnp.pad(vector, more),
        known,
    )


def pinned_of(hub: Hub, push: Push | None) -> Float[Array, " m"]:
    """1 for coordinates of a body that stand still, 0 for others."""
    held = jnp.zeros_like(hub.q) if hub.body.free is None else 1.0 - hub.body.free
    return held if push is None else jnp.maximum(held, push.pinned)


def hub_gain(
    system: System, chain: Chain, at: int, push: Push | None, x: Float[Array, "P b"], dt
) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """q'' (m,) of a body, and the force (N) on it that its motion needs beyond the known ones."""
    hub, pull = chain.hubs[at], system.pull(at, x)
    m = hub.q.shape[0]
    if not hub.reduced:
        gain, on = x[at, :m], pull[:m]
    else:
        ((_, turn),) = hub.turns.items()
        on = turn.T @ pull[: turn.shape[0]]
        pinned = pinned_of(hub, push)
        free, stop = 1.0 - pinned, -pinned * hub.v / dt
        only = hub.mass * jnp.outer(free, free) + jnp.diag(pinned)
        gain = solve_small(only, free * (system.known[at] + on - hub.mass @ stop)) + stop
    return gain, hub.mass @ gain - system.known[at] - on


def _padded_places(chain: Chain, size: int, d: int) -> Float[Array, "P s s"]:
    """Ones for coordinates that a place does not have."""
    rows = []
    for at in range(chain.path.places):
        hub = chain.hubs.get(at)
        count = d if hub is None or hub.reduced else hub.q.shape[0]
        rows.append(jnp.diag((jnp.arange(size) >= count).astype(chain.before.dtype)))
    return jnp.stack(rows)


def _rate(hub: Hub, gain, side: int, dt) -> tuple[Float[Array, " d"], Float[Array, " d"]]:
    """Velocity (m/s) of a body's point in the middle of a kick, and (dJ/dt) v (m/s2)."""
    _, v, drift = hub.body.rate(hub.q, hub.v + 0.5 * dt * gain, hub.points[side])
    return v, drift


def _ends_after(chain: Chain, guess: Guess, dt, ahead) -> RodEnds:
    """Where the rods' ends are after the step of positions that follows (m)."""
    rates = chain.before + dt * guess.places
    d = chain.tangent.shape[0]
    first = chain.place.first + ahead * rates[:-1, :d].T
    last = chain.place.last + ahead * rates[1:, :d].T
    for at, hub in chain.hubs.items():
        u = hub.q - hub.body.reference
        after = u + ahead * (hub.v + dt * guess.bodies[at])
        for side, point in hub.points.items():
            start = chain.place.first[:, at] if side == 1 else chain.place.last[:, at - 1]
            where = start + hub.body.shift(after, point) - hub.body.shift(u, point)
            if side == 1:
                first = place(first, where[:, None], 0, at)
            else:
                last = place(last, where[:, None], 0, at - 1)
    return RodEnds(first, last)


def _forces(model: Model, chain: Chain, guess: Guess, middle, dt) -> tuple[RodEnds, RodEnds | None]:
    """Forces on the rods' ends (N), and the drifts (n, d) of those at bodies in the middle (m/s2)."""
    d, rods = chain.tangent.shape
    first, last = middle[:-1, :d].T, middle[1:, :d].T
    drifts = None
    if chain.first is not None:
        drifts = [jnp.zeros((rods, d), middle.dtype)] * 2
    for at, hub in chain.hubs.items():
        for side in hub.points:
            v, drift = _rate(hub, guess.bodies[at], side, dt)
            if side == 1:
                first = place(first, v[:, None], 0, at)
            else:
                last = place(last, v[:, None], 0, at - 1)
            if drifts is not None and not hub.reduced:
                k, where = (0, at) if side == 1 else (1, at - 1)
                drifts[k] = place(drifts[k], drift[None], where, 0)
    force = chain.force
    if any(model.lines[leg.line].drag is not None for leg in chain.path.legs):
        if chain.flow is not None:
            first, last = first - chain.flow.first, last - chain.flow.last
        spread = chain.spread
        drag = rod_drag(spread.normal, spread.tangential, chain.tangent, first, last)
        force = RodEnds(force.first + drag[0], force.last + drag[1])
    return force, None if drifts is None else RodEnds(*drifts)
