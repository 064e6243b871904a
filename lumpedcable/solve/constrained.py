"""A step for lines that keep their length: tensions and accelerations from one banded system.

Leapfrog as for other lines, x_n+1 = x_n + dt v_n+1/2 and v_n+3/2 = v_n+1/2 + dt a_n+1, but the
accelerations hold the tensions of rods as unknowns, which are such that the rods have their lengths
after the next step of positions (SHAKE: Ryckaert, Ciccotti & Berendsen, J. Comput. Phys. 23, 1977):

    M a - sum of u T = F,      |x_j+1 - x_j + dt (v_j+1 - v_j) + dt^2 (a_j+1 - a_j)| = l_j,

u the rods' directions now. Linearised about what the last iterate would lead to, (a_j, T_j-1) of one
place and the next make a block tridiagonal system, O(N) (Newton's method; the second iterate is left
with an error of the fourth order in dt). Forces that depend on velocity are taken at the middle of the
kick, (v_n+1/2 + v_n+3/2) / 2, from the iterate before, so that the step is of second order. Where the
step is too long for what pulls at a light joint, the iterates no longer find the lengths: a step that
leads to rods that have lost theirs has failed. Coulomb's
friction of a body picks one of two systems: stuck, where its coordinate is pinned, or sliding. That of
lines is in `solve.grips`.
"""

from typing import Any, ClassVar, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.attached import body_gain, follow, follow_rate
from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import Found
from lumpedcable.model.energy import powers
from lumpedcable.model.forces import evaluate
from lumpedcable.model.model import Model
from lumpedcable.model.paths import paths_of
from lumpedcable.model.rods import to_lines, to_segments
from lumpedcable.model.state import State
from lumpedcable.physics.vectors import size as norm
from lumpedcable.solve.blocks import solve_blocks
from lumpedcable.solve.chains import Chain, Guess, chain_of, first_guess
from lumpedcable.solve.grips import (
    Bed,
    LineGrip,
    bed_of,
    first_grip,
    next_grip,
    on_lines,
    remembered,
    terms,
)
from lumpedcable.solve.leapfrog import CableTerm
from lumpedcable.solve.matrices import eliminated
from lumpedcable.solve.rods import Push, hub_gain, pinned_of, system_of
from lumpedcable.solve.stretch import giving_way

__all__ = ["Constrained", "RodHalfStep", "rod_gains"]

# from the accelerations of the step before; more where there is no step before, and where places of
# lines stick and slide
ITERATES = 2
GRIPPED_ITERATES = 3
FIRST_ITERATES = 6
# share of its length that a rod may be off: what is resolved keeps a millionth and better, what blows up
# passes this some ten steps before its energies run away
LOST = 1e-4


class Grip(NamedTuple):
    """What friction does to a body in one iterate: whether it slides, and the force (m,) if it does."""

    sliding: Bool[Array, ""]
    force: Float[Array, " m"]


class Memory(NamedTuple):
    """What an iterate starts from: accelerations, the friction of bodies by place, that of lines.

    And what a kick wants of those before: the stretches (m) of rods that give way, None where none does.
    """

    guess: Guess
    grips: dict[int, Grip]
    lines: LineGrip | None
    stretch: Float[Array, "2 n"] | None = None


class RodHalfStep(NamedTuple):
    """What a constrained step leaves to the next one.

    The velocities (m/s) half a step after the state, the work (J) until then, the step `dt` (s), what
    the iterates of each path start from, and the lengths (m) that the rods come to after the next step.
    """

    velocity: dict[str, Array]
    work: dict[str, dict[str, Array]]
    dt: Float[Array, ""]
    memory: tuple[Memory, ...]
    length: dict[str, Array]


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
        kicked = kick(args, t0, y0.displacement, y0.velocity, None, 0.5 * dt, dt)
        work = _worked(args, t0, y0, y0.displacement, y0.velocity, kicked, 0.5 * dt)
        return RodHalfStep(kicked.after, work, dt, kicked.memory, kicked.length)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """One step from t0 to t1 (s); it diverges where rods have lost their lengths."""
        kept: RodHalfStep = solver_state
        before, work, dt = kept.velocity, kept.work, kept.dt
        t1 = jnp.asarray(t1)
        place = jax.tree.map(lambda x, v: x + dt * v, y0.displacement, before)
        place = follow(args, t1, place)
        kicked = kick(args, t1, place, before, kept.memory, dt, dt)
        now = after = work
        if work:
            whole = _worked(args, t1, y0, place, before, kicked, dt)
            now = jax.tree.map(lambda w, p: w + 0.5 * p, work, whole)
            after = jax.tree.map(lambda w, p: w + p, work, whole)
        y1 = State(place, kicked.middle, now, y0.reaction, kicked.tension)
        dense = {"y0": y0, "y1": y1}
        ahead = RodHalfStep(kicked.after, after, dt, kicked.memory, kicked.length)
        kinds: Any = diffrax.RESULTS
        lost = lengths_lost(args, place, kept.length)
        result = kinds.where(lost, kinds.nonlinear_divergence, kinds.successful)  # pyright: ignore[reportArgumentType]
        return y1, None, dense, ahead, result

    def func(self, terms, t0, y0, args):
        """Rates at an instant: what a solver of diffrax may be asked for; no step uses it."""
        raise NotImplementedError("rods have no rates without a step")


def rod_gains(state: Any, y: State) -> dict[str, Float[Array, "d nodes"]]:
    """Accelerations (m/s2) of the nodes of rods at a state, by line; {} of what is not made of rods."""
    if not isinstance(state, RodHalfStep):
        return {}
    moves = state.dt > 0.0  # a scene at rest has no steps
    half = jnp.where(moves, 0.5 * state.dt, 1.0)
    return {
        name: jnp.where(moves, state.velocity[name] - y.velocity[name], 0.0) / half
        for name in y.tension
    }


def lengths_lost(model: Model, displacement, length: dict[str, Array]) -> Bool[Array, ""]:
    """Whether a rod does not have the length (m) that the kick before has found for this place (m)."""
    lost = jnp.zeros((), bool)
    for name, line in model.lines.items():
        off = jnp.abs(line.shape(displacement[name]).length - length[name])
        lost |= ~jnp.all(off <= LOST * length[name])  # also where nothing is known
    return lost


class Kicked(NamedTuple):
    """Velocities at the middle and at the end of a kick, tensions (N) and lengths to come to (m).

    `friction` has the forces on bodies (N) by body, and by line the power (W) of what moves its ends.
    """

    middle: dict[str, Array]
    after: dict[str, Array]
    tension: dict[str, Array]
    length: dict[str, Array]
    friction: dict[str, Array]
    found: Found
    memory: tuple[Memory, ...]


def _worked(model: Model, t, y: State, place, before, kicked: Kicked, dt) -> dict:
    """Work (J) of a kick of length dt (s), by line or body and kind; empty where none is asked for."""
    if not y.work:
        return y.work
    power = powers(
        model, t, kicked.found, place, before, kicked.middle, kicked.after, dt, kicked.friction,
        kicked.tension,
    )  # fmt: skip
    return {n: {k: dt * power[n][k] for k in kinds} for n, kinds in y.work.items()}


def kick(
    model: Model, t, displacement, before, memory: tuple[Memory, ...] | None, dt, ahead
) -> Kicked:
    """A kick of length dt (s) centred on t or, at the start, from t on.

    `ahead` (s) is the step of positions that follows, at whose end the rods have their lengths;
    `memory` what the kick before found for each path, None where there was none.
    """
    found = evaluate(model, t, displacement, before, {}, None)
    middle, after, carried, lengths, held, kept = {}, {}, {}, {}, {}, []
    walked: set[str] = set()
    for k, path in enumerate(paths_of(model)):
        chain = chain_of(model, path, t, found, displacement, before, ahead)
        bed = bed_of(model, path, t, found, before, chain.spread.across)
        mine = _kick_path(model, chain, bed, None if memory is None else memory[k], dt, ahead)
        for line, force in mine.gripped.items():
            found[line] = found[line]._replace(grip=force)
        middle, after = middle | mine.middle, after | mine.after
        carried, lengths = carried | mine.tension, lengths | mine.length
        held = held | mine.friction
        kept.append(mine.memory)
        walked |= set(path.bodies.values())
    # in their order, not that of a set: another in each process would be another program each time
    for name in (name for name in model.bodies if name not in walked):
        key = body_key(name)
        gain = body_gain(model, name, t, found, displacement, before, dt).gain
        middle[key], after[key] = before[key] + 0.5 * dt * gain, before[key] + dt * gain
    if model.bodies:
        middle = follow_rate(model, t, displacement, middle)
        after = follow_rate(model, t, displacement, after, ahead)
    return Kicked(middle, after, carried, lengths, held, found, tuple(kept))


class Walked(NamedTuple):
    """What the iterates of a path lead to: see `Kicked`."""

    middle: dict[str, Array]
    after: dict[str, Array]
    tension: dict[str, Array]
    length: dict[str, Array]
    friction: dict[str, Array]
    gripped: dict[str, Array]
    memory: Memory


class _Iterate(NamedTuple):
    """An iterate: what the next starts from, what this one used, and the forces (N) that it found.

    `pull` are the tensions of the rods, `needed` the forces on bodies beyond the known ones, `driving`
    those on places whose motion is given, `gripped` the friction of lines on places (P, d).
    """

    memory: Memory
    used: dict[int, Grip]
    pull: Float[Array, " n"]
    needed: dict[int, Array]
    driving: dict[int, Array]
    gripped: Float[Array, "P d"] | None


def _kick_path(
    model: Model, chain: Chain, bed: Bed | None, memory: Memory | None, dt, ahead
) -> Walked:
    start, stretch = _first(chain, bed, memory), None
    if any(model.lines[leg.line].give is not None for leg in chain.path.legs):
        chain, stretch = giving_way(chain, None if memory is None else memory.stretch, ahead)
    d = chain.tangent.shape[0]
    rates = chain.before[:, :d]

    def iterate(_, last: _Iterate) -> _Iterate:
        guess, grips, lines, _ = last.memory
        pushes = {at: _push(chain, at, grip) for at, grip in grips.items()}
        held = None if bed is None or lines is None else terms(bed, lines, rates, dt)
        system = system_of(model, chain, guess, pushes, dt, ahead, held)
        x = solve_blocks(system.blocks, system.right, eliminated)
        found = {at: hub_gain(system, chain, at, pushes.get(at), x, dt) for at in chain.hubs}
        gains = {at: gain for at, (gain, _) in found.items()}
        needed = {at: force for at, (_, force) in found.items()}
        after = {at: _next_grip(chain, at, needed[at], gains[at], g, dt) for at, g in grips.items()}
        driving = {at: -system.pull(at, x) for at in chain.driven}
        used = None
        if bed is not None and lines is not None and start.memory.lines is not None:
            lines, used = next_grip(bed, start.memory.lines, lines, rates, x[:, :d], dt)
        now = Memory(Guess(x[:, :-1], gains), after, lines)
        return _Iterate(now, grips, x[1:, -1], needed, driving, used)

    count = ITERATES if bed is None else GRIPPED_ITERATES
    last = jax.lax.fori_loop(0, FIRST_ITERATES if memory is None else count, iterate, start)
    walked = _walked(chain, bed, last, dt)
    return walked._replace(memory=walked.memory._replace(stretch=stretch))


def _first(chain: Chain, bed: Bed | None, memory: Memory | None) -> _Iterate:
    """What the first iterate starts from; a body slides where it moves, against the force of before."""
    guess = first_guess(chain) if memory is None else memory.guess
    grips = {}
    for at, hub in chain.hubs.items():
        if hub.body.friction is not None:
            moving = jnp.any(_level(chain, at) * hub.v != 0.0)
            force = jnp.zeros_like(hub.v) if memory is None else memory.grips[at].force
            grips[at] = Grip(moving, force)
    none = {at: jnp.zeros_like(hub.v) for at, hub in chain.hubs.items()}
    still = {at: jnp.zeros_like(chain.before[0]) for at in chain.driven}
    lines = None
    if bed is not None:
        lines = first_grip(bed) if memory is None else memory.lines
    start, pull = Memory(guess, grips, lines), jnp.zeros_like(chain.spread.length)
    return _Iterate(start, grips, pull, none, still, None if lines is None else lines.force)


def _walked(chain: Chain, bed: Bed | None, last: _Iterate, dt) -> Walked:
    path, d = chain.path, chain.tangent.shape[0]
    guess = last.memory.guess
    ends = chain.before + dt * guess.places
    half = 0.5 * (chain.before + ends)
    after, middle = to_lines(path, ends[:, :d].T), to_lines(path, half[:, :d].T)
    friction: dict[str, Array] = {}
    for at, force in last.driving.items():
        # what moves an end of a line works on it
        line = next(line for (where, _), (line, _) in path.points.items() if where == at)
        friction[line] = jnp.dot(force, half[at]) + friction.get(line, 0.0)
    for at, name in path.bodies.items():
        hub, key, grip = chain.hubs[at], body_key(name), last.used.get(at)
        push = None if grip is None else _push(chain, at, grip)
        # what is pinned ends at rest exactly: what sticks does not creep
        free = hub.v + dt * guess.bodies[at]
        after[key] = jnp.where(pinned_of(hub, push) > 0.0, 0.0, free)
        middle[key] = 0.5 * (hub.v + after[key])
        if grip is not None:
            sticking = _level(chain, at) * last.needed[at]
            friction[name] = jnp.where(grip.sliding, grip.force, sticking)
    memory, gripped = last.memory, {}
    if bed is not None and memory.lines is not None and last.gripped is not None:
        memory = memory._replace(lines=remembered(bed, memory.lines, last.gripped))
        gripped = on_lines(path, last.gripped)
    tension = to_segments(path, last.pull)
    length = to_segments(path, chain.spread.length + chain.spread.give * last.pull)
    return Walked(middle, after, tension, length, friction, gripped, memory)


def _push(chain: Chain, at: int, grip: Grip) -> Push:
    """A body's friction where it slides, and its coordinates on the bed where it sticks."""
    stuck = jnp.where(grip.sliding, 0.0, _level(chain, at))
    return Push(jnp.where(grip.sliding, grip.force, 0.0), stuck)


def _level(chain: Chain, at: int) -> Float[Array, " m"]:
    """1 for the coordinates in which a body slides on the bed."""
    hub = chain.hubs[at]
    friction = hub.body.friction
    assert friction is not None
    return friction.level(hub.q)


def _next_grip(chain: Chain, at: int, needed, gain, grip: Grip, dt) -> Grip:
    """What friction does in the next iterate, from the forces and accelerations of this one."""
    hub = chain.hubs[at]
    friction = hub.body.friction
    assert friction is not None
    level, limit = friction.level(hub.q), friction.limit(needed, hub.q, hub.v)
    rate, pull = level * hub.v, level * needed
    # against the motion; where it only starts to slide, as what held it before
    holds = jnp.where(grip.sliding, grip.force, pull)
    speed, size = (norm(x) for x in (rate, holds))
    moving = speed > 0.0
    against = jnp.where(
        moving,
        -rate / jnp.where(moving, speed, 1.0),
        holds / jnp.where(size > 0.0, size, 1.0),
    )
    turned = moving & (jnp.dot(rate + dt * level * gain, rate) < 0.0)
    return Grip(jnp.where(grip.sliding, ~turned, size > limit), limit * against)
