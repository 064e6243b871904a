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

from lumpedcable.model.ends import solve_small
from lumpedcable.model.model import Model
from lumpedcable.model.paths import AFTER
from lumpedcable.model.rods import RodEnds
from lumpedcable.physics.place import place
from lumpedcable.physics.rod import ROD_SHARES, rod_drag
from lumpedcable.physics.vectors import dot
from lumpedcable.solve.chains import Chain, Guess, Hub
from lumpedcable.solve.matrices import at_first, at_last, both, flip, lengthening, onto, times

__all__ = [
    "Lengths",
    "Motion",
    "Push",
    "System",
    "assembled",
    "hub_gain",
    "hub_weight",
    "inertia_of",
    "on_course",
    "pinned_of",
    "system_of",
]


class Push(NamedTuple):
    """A force (m,) on a body (N), and which of its coordinates are pinned, to stand still."""

    force: Float[Array, " m"]
    pinned: Float[Array, " m"]


class Row(NamedTuple):
    """The row of a place: what the unknowns of the place before, of its own and of the next one count.

    b = s + 1: accelerations and the tension before the place.
    """

    lower: Float[Array, "s b"]
    level: Float[Array, "s b"]
    upper: Float[Array, "s b"]
    right: Float[Array, " s"]


class System(NamedTuple):
    """Blocks (lower, diagonal, upper) and right side of an iterate, and what follows from a solution.

    `raw` are the rods' own rows at hubs and driven places, before weighing.
    """

    blocks: tuple[Array, Array, Array]
    right: Float[Array, "P b"]
    raw: dict[int, Row]
    known: dict[int, Float[Array, " m"]]

    def pull(self, at: int, x: Float[Array, "P b"]) -> Float[Array, " s"]:
        """The force (N) of the rods on a place: F - M a, with their tensions."""
        row = self.raw[at]
        total = row.right - row.level @ x[at]
        total = total - row.lower @ x[at - 1] if at > 0 else total
        return total - row.upper @ x[at + 1] if at < x.shape[0] - 1 else total


class Motion(NamedTuple):
    """M a = F of the places without tensions: blocks on the diagonal and beside it, right sides."""

    mass: Float[Array, "P s s"]
    cross: Float[Array, "n s s"]
    right: Float[Array, "P s"]


class Lengths(NamedTuple):
    """What the lengths ask of accelerations: last . a_j+1 - first . a_j = right (m/s2), of each rod."""

    first: Float[Array, "n s"]
    last: Float[Array, "n s"]
    right: Float[Array, " n"]


class Weighed(NamedTuple):
    """What the row of a place at a hub or a driven end becomes: A a + W (M a - F) = r.

    W is `weight`, A `matrix`, r `right`; `known` is the force (m,) on a body beside the rods'.
    """

    weight: Float[Array, "s s"]
    matrix: Float[Array, "s s"]
    right: Float[Array, " s"]
    known: Float[Array, " m"]


def system_of(
    model: Model, chain: Chain, guess: Guess, pushes: dict[int, Push], dt, ahead,
    held: tuple[Array, Array] | None = None,
) -> System:  # fmt: skip
    """The system of an iterate that starts from the accelerations of the one before.

    `pushes` are the forces on bodies beside their own, and their pinned coordinates, by place; `held`
    what friction adds to the inertia (P, d, d) and to the force (P, d) of places.
    """
    own = _motion(model, chain, guess, dt, held)
    give = chain.spread.give / (dt * ahead)
    return assembled(
        chain, own, _lengths(chain, guess, dt, ahead), _weights(chain, guess, pushes, dt), give
    )


def assembled(
    chain: Chain, own: Motion, lengths: Lengths, weights: dict[int, Weighed],
    give: Float[Array, " n"],
) -> System:  # fmt: skip
    """The system of motion and lengths, where rods lengthen by `give` for every newton."""
    places, size = chain.before.shape
    # a rod's pull u T on its first place, against it on its last
    ahead_of, behind = onto(chain.first, chain.tangent.T), onto(chain.last, chain.tangent.T)

    dtype = own.mass.dtype
    low = jnp.concatenate([flip(own.cross), jnp.zeros((places - 1, size, 1), dtype)], axis=2)
    high = jnp.concatenate([own.cross, -ahead_of[:, :, None]], axis=2)
    level = jnp.concatenate([own.mass, at_last(behind)[:, :, None]], axis=2)
    lower, upper, right = at_last(low), at_first(high), own.right
    raw = {at: Row(lower[at], level[at], upper[at], right[at]) for at in weights}
    known = {at: weighed.known for at, weighed in weights.items()}
    for at, weighed in weights.items():
        row, weight = raw[at], weighed.weight
        wide = jnp.pad(weighed.matrix, ((0, 0), (0, 1)))
        lower = place(lower, (weight @ row.lower)[None], at, 0, 0)
        upper = place(upper, (weight @ row.upper)[None], at, 0, 0)
        level = place(level, (wide + weight @ row.level)[None], at, 0, 0)
        right = place(right, (weighed.right + weight @ row.right)[None], at, 0)

    # a tension before the first place, which is none, and what rods give way by
    one = (jnp.arange(places) == 0).astype(dtype) - at_last(give)
    one = one[:, None, None]
    last_row = jnp.concatenate([at_last(lengths.last)[:, None, :], one], axis=2)
    first_row = jnp.pad(at_last(-lengths.first)[:, None, :], ((0, 0), (0, 0), (0, 1)))
    return System(
        (
            jnp.concatenate([lower, first_row], axis=1),
            jnp.concatenate([level, last_row], axis=1),
            jnp.pad(upper, ((0, 0), (0, 1), (0, 0))),
        ),
        jnp.concatenate([right, at_last(lengths.right)[:, None]], axis=1),
        raw,
        known,
    )


def _motion(model: Model, chain: Chain, guess: Guess, dt, held) -> Motion:
    """Inertia and forces of rods, junctions and, by `held`, friction; see `system_of`."""
    (places, size), d = chain.before.shape, chain.tangent.shape[0]
    own, between = ROD_SHARES
    mass, cross = inertia_of(model, chain)
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
    right = at_first(onto(chain.first, spun)) + at_last(onto(chain.last, spin))
    for at, index in chain.path.junctions.items():
        junction = model.junctions[index]
        if junction.load is not None:
            here = (jnp.arange(places) == at).astype(mass.dtype)
            right = right + here[:, None] * jnp.pad(junction.load, (0, size - d))
    if held is not None:
        wide = (0, size - d)
        mass = mass + jnp.pad(held[0], ((0, 0), wide, wide))
        right = right + jnp.pad(held[1], ((0, 0), wide))
    return Motion(mass, cross, right)


def inertia_of(model: Model, chain: Chain) -> tuple[Float[Array, "P s s"], Float[Array, "n s s"]]:
    """Masses (kg) of places, rods and junctions together, and those between neighbours."""
    (places, size), d = chain.before.shape, chain.tangent.shape[0]
    own, between = ROD_SHARES
    mass_first, mass_last = (both(j, own * chain.whole, j) for j in (chain.first, chain.last))
    cross = both(chain.first, between * chain.whole, chain.last)
    mass = at_first(mass_first) + at_last(mass_last)
    for at, index in chain.path.junctions.items():
        junction = model.junctions[index]
        if junction.mass is not None:
            here = (jnp.arange(places) == at).astype(mass.dtype)
            mass = mass + here[:, None, None] * junction.mass * jnp.eye(size, dtype=mass.dtype)
    if size > d:
        mass = mass + _padded_places(chain, size, d)
    return mass, cross


def _lengths(chain: Chain, guess: Guess, dt, ahead) -> Lengths:
    """The rods' lengths at the end of the next step of positions, linear about the guess."""
    ends = _ends_after(chain, guess, dt, ahead)
    step = ends.last - ends.first
    far = jnp.sqrt(dot(step, step))
    row = (step / far).T  # u'
    first, last = onto(chain.first, row), onto(chain.last, row)
    reached = lengthening(first, last, guess.places)
    return Lengths(first, last, reached - (far - chain.spread.length) / (dt * ahead))


def _weights(chain: Chain, guess: Guess, pushes: dict[int, Push], dt) -> dict[int, Weighed]:
    """How rows are weighed, by place; those of driven ends land on the velocities to come."""
    size, d = chain.before.shape[1], chain.tangent.shape[0]
    found = {at: _hub_weight(chain, guess, at, pushes.get(at), dt) for at in chain.hubs}
    for at, target in chain.driven.items():
        aim = jnp.pad(target, (0, size - d))
        found[at] = on_course((aim - chain.before[at]) / dt)
    return found


def on_course(given: Float[Array, " s"]) -> Weighed:
    """How the row of a place is weighed whose acceleration (m/s2) is given."""
    size = given.shape[0]
    none = jnp.zeros((size, size), given.dtype)
    return Weighed(none, jnp.eye(size), given, none[0])


def _hub_weight(chain: Chain, guess: Guess, at: int, push: Push | None, dt) -> Weighed:
    """How the row of a body's place is weighed in a kick."""
    hub, drift = chain.hubs[at], None
    known = hub.body.force(hub.q, hub.v + 0.5 * dt * guess.bodies[at], chain.t)
    known = known if push is None else known + push.force
    if hub.reduced:
        ((side, _),) = hub.turns.items()
        drift = _rate(hub, guess.bodies[at], side, dt)[1]
    return hub_weight(hub, chain.before.shape[1], pinned_of(hub, push), dt, known, drift)


def hub_weight(
    hub: Hub, size: int, pinned: Float[Array, " m"], dt, known: Float[Array, " m"],
    drift: Float[Array, " d"] | None,
) -> Weighed:  # fmt: skip
    """How the row of a body's place of `size` coordinates is weighed.

    Free coordinates: M q'' = Q + J^T f with f the rods' pull and Q `known` (N); pinned ones come to rest
    in this kick. `drift` is (dJ/dt) v (m/s2), None where there is none.
    """
    m = hub.q.shape[0]
    free, stop, mass = _loose(hub, pinned, dt)
    force = free * (known - hub.mass @ stop)
    if not hub.reduced:
        wide, long = ((0, size - m), (0, size - m)), (0, size - m)
        weight, matrix = jnp.pad(jnp.diag(free), wide), jnp.pad(mass, wide)
        return Weighed(weight, matrix, jnp.pad(force + stop, long), known)
    ((_, turn),) = hub.turns.items()
    gains = jax.vmap(lambda column: solve_small(mass, free * column))(turn)  # (d, m)
    vector = gains @ known - gains @ (hub.mass @ stop) + turn @ stop
    vector = vector if drift is None else vector + drift
    more = (0, size - turn.shape[0])
    weight = jnp.pad(gains @ turn.T, (more, more))
    return Weighed(weight, jnp.eye(size), jnp.pad(vector, more), known)


class _Loose(NamedTuple):
    """What a body does freely while some of its coordinates are pinned.

    1 for free coordinates and 0 for others; the accelerations that stop pinned ones in this kick; the
    mass of the free ones, with ones for the others.
    """

    free: Float[Array, " m"]
    stop: Float[Array, " m"]
    mass: Float[Array, "m m"]


def _loose(hub: Hub, pinned: Float[Array, " m"], dt) -> _Loose:
    free, stop = 1.0 - pinned, -pinned * hub.v / dt
    return _Loose(free, stop, hub.mass * jnp.outer(free, free) + jnp.diag(pinned))


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
        free, stop, mass = _loose(hub, pinned_of(hub, push), dt)
        gain = solve_small(mass, free * (system.known[at] + on - hub.mass @ stop)) + stop
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
            start = chain.place.first[:, at] if side == AFTER else chain.place.last[:, at - 1]
            where = start + hub.body.shift(after, point) - hub.body.shift(u, point)
            if side == AFTER:
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
            if side == AFTER:
                first = place(first, v[:, None], 0, at)
            else:
                last = place(last, v[:, None], 0, at - 1)
            if drifts is not None and not hub.reduced:
                k, where = (0, at) if side == AFTER else (1, at - 1)
                drifts[k] = place(drifts[k], drift[None], where, 0)
    force = chain.force
    if any(model.lines[leg.line].drag is not None for leg in chain.path.legs):
        if chain.flow is not None:
            first, last = first - chain.flow.first, last - chain.flow.last
        spread = chain.spread
        drag = rod_drag(spread.normal, spread.tangential, chain.tangent, first, last)
        force = RodEnds(force.first + drag[0], force.last + drag[1])
    return force, None if drifts is None else RodEnds(*drifts)
