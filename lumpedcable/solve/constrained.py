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
from lumpedcable.model.couple import Found
from lumpedcable.model.ends import Driven
from lumpedcable.model.energy import powers
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path, paths_of
from lumpedcable.model.rods import to_lines, to_segments
from lumpedcable.model.state import State
from lumpedcable.solve.banded import solve_chain
from lumpedcable.solve.leapfrog import CableTerm
from lumpedcable.solve.rods import Chain, chain_of, system_of

__all__ = ["Constrained"]

ITERATES = 3


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
    """Velocities at the middle and at the end of a kick, and tensions (N).

    `friction` has the forces on bodies (N) by body, and by line the power (W) of what moves its ends.
    """

    middle: dict[str, Array]
    after: dict[str, Array]
    tension: dict[str, Array]
    friction: dict[str, Array]
    found: Found


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
    chain = chain_of(model, path, t, found, displacement, before, dt, ahead)
    grips = {
        place: _first_grip(model, chain, place)
        for place, name in path.bodies.items()
        if model.bodies[name].friction is not None
    }
    gain = jnp.zeros_like(chain.before)
    needed: dict[int, Array] = {}
    driven = _driven(model, path)
    used, now, pull = grips, _pins(model, chain, grips, dt), jnp.zeros(path.places - 1)
    for _ in range(ITERATES):
        used = grips
        pushes = {place: jnp.where(g.sliding, g.force, 0.0) for place, g in grips.items()}
        matrix, right = system_of(model, chain, displacement, gain, pushes, dt, ahead)
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
        needed = {place: _needed(chain, place, matrix, right, x) for place in [*grips, *driven]}
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
    friction: dict[str, Array] = {}
    for place, lines in driven.items():
        # what moves an end of a line works on it
        friction[lines] = jnp.dot(needed[place], half[place]) + friction.get(lines, 0.0)
    for place, name in path.bodies.items():
        key, m = body_key(name), model.bodies[name].reference.shape[0]
        after[key], middle[key] = ends[place, :m], half[place, :m]
        if place in grips:
            level, grip = _level(model, chain, place), used[place]
            sticking = jnp.where(level, needed[place], 0.0)
            friction[name] = jnp.where(grip.sliding, grip.force, sticking)[:m]
    return Kicked(middle, after, to_segments(path, pull), friction, found)


def _driven(model: Model, path: Path) -> dict[int, str]:
    """Places whose motion is given, and the line that ends there."""
    found = {}
    for (place, _), (line, node) in path.points.items():
        if isinstance(model.ends[line][0 if node == 0 else 1], Driven):
            found[place] = line
    return found


def _pins(model: Model, chain: Chain, grips: dict[int, Grip], dt):
    """Pinned coordinates (P, s) and their accelerations (m/s2)."""
    pinned, target = chain.pinned, chain.target
    for place, grip in grips.items():
        level = _level(model, chain, place)
        pinned = pinned.at[place].set(pinned[place] | (level & ~grip.sliding))
    return pinned, (target - chain.before) / dt


def _level(model: Model, chain: Chain, place: int) -> Bool[Array, " s"]:
    """The coordinates in which a body slides on the bed."""
    friction = model.bodies[chain.path.bodies[place]].friction
    assert friction is not None
    up = friction.up
    size = chain.before.shape[1]
    return jnp.zeros(size, bool).at[: up.shape[0]].set(jnp.abs(up) < 0.5)


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
    # against the motion; where it only starts to slide, as what held it before
    holds = jnp.where(grip.sliding, grip.force, pull)
    speed, size = (_length(x) for x in (rate, holds))
    moving = speed > 0.0
    against = jnp.where(
        moving,
        -rate / jnp.where(moving, speed, 1.0),
        holds / jnp.where(size > 0.0, size, 1.0),
    )
    turned = moving & (jnp.dot(rate + dt * jnp.where(level, gain, 0.0), rate) < 0.0)
    return Grip(jnp.where(grip.sliding, ~turned, size > limit), limit * against)


def _length(vector: Float[Array, " s"]) -> Float[Array, ""]:
    """Euclidean norm whose derivative at zero is zero."""
    square = jnp.sum(vector**2)
    zero = square == 0.0
    return jnp.where(zero, 0.0, jnp.sqrt(jnp.where(zero, 1.0, square)))
