"""Leapfrog for cables, as a diffrax solver: one evaluation a step, drag at mid-step, second order.

What damping of the material and of the bed do is of first order: it lags by half a step.
"""

from collections.abc import Iterator
from typing import Any, ClassVar, NamedTuple

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.attached import follow, left_out, on_course, travels
from lumpedcable.model.energy import powers
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.forces import evaluate
from lumpedcable.model.hauled import spooled
from lumpedcable.model.line import Workspace
from lumpedcable.model.model import Model
from lumpedcable.model.motion import acceleration, driven_velocities, kick
from lumpedcable.model.state import State
from lumpedcable.physics.precision import rounded_off
from lumpedcable.physics.relaxation import Memory, Relaxed
from lumpedcable.physics.vectors import most

__all__ = ["CableTerm", "HalfStep", "Leapfrog", "rates"]


def rates(
    model: Model, t: Float[Array, ""], y: State, dt: Float[Array, ""] | None = None
) -> tuple[State, dict[str, Evaluation]]:
    """dy/dt of a state: velocities (m/s), accelerations (m/s2) and powers (W).

    `dt` is the step (s) that starts here, if steps are fixed.
    """
    model = model.remembering(y.memory)
    gain, found = acceleration(model, t, y.displacement, y.velocity, y.reaction, dt)
    work = y.work
    if work:
        power = powers(model, t, found, y.displacement, y.velocity, y.velocity, gain, None)
        work = {
            name: {kind: power[name].get(kind, jnp.zeros_like(w)) for kind, w in kinds.items()}
            for name, kinds in work.items()
        }
    still = jax.tree.map(lambda x: 0.0 * x, y.reaction)
    rate = {name: relaxed.rate for name, relaxed in relaxing(found)}
    return State(y.velocity, gain, work, still, y.tension, rate), found


class CableTerm(diffrax.AbstractTerm):
    """The equations of motion of a `Model` for any diffrax solver; the model is `args`.

    Steps are in the precision of the state. The solver's times, which may be in single precision,
    count from `start` (s), which is not. Solvers that know more than a vector field, such as
    `Leapfrog`, ask the model itself.
    """

    start: Float[Array, ""]

    def vf(self, t: Any, y: State, args: Model) -> State:
        """dy/dt."""
        return rates(args, self.start + t, y)[0]

    def contr(self, t0: Any, t1: Any, **kwargs) -> Any:
        """The step (s)."""
        return t1 - t0

    def prod(self, vf: State, control: Any) -> State:
        """The step times dy/dt."""
        return jax.tree.map(lambda rate: jnp.asarray(control).astype(rate.dtype) * rate, vf)


def relaxing(found: dict[str, Evaluation]) -> Iterator[tuple[str, Relaxed]]:
    """How the branches of lines stand whose material relaxes, by line."""
    for name, e in found.items():
        if e.line.relaxed is not None:
            yield name, e.line.relaxed


def workspaces(found: dict[str, Evaluation]) -> dict[str, Workspace]:
    """What an evaluation wrote along each line."""
    return {name: e.line.workspace for name, e in found.items() if e.line.workspace is not None}


def moved(
    model: Model, t: Float[Array, ""], place: dict[str, Array], low: dict[str, Array],
    velocity: dict[str, Array], dt: Float[Array, ""],
) -> tuple[dict[str, Array], dict[str, Array]]:  # fmt: skip
    """Displacements (m) at t (s), a step of dt (s) on, and what rounding leaves out of them.

    In single precision steps that are rounded add up, on a path to a way off, in a taut line to waves
    that nothing made. What a sum x + dt v has no digits for is kept and goes into the next one.
    """
    if not low:
        drifted = jax.tree.map(lambda x, v: x + dt * v, place, velocity)
        return follow(model, t, spooled(model, t, drifted)), {}
    steps = jax.tree.map(lambda rest, v: rest + dt * v, low, velocity)
    sums = jax.tree.map(jnp.add, place, steps)
    low = jax.tree.map(rounded_off, sums, place, steps)
    place = follow(model, t, on_course(model, t, sums))
    return place, jax.lax.stop_gradient(left_out(model, t, place, low))


class HalfStep(NamedTuple):
    """What leapfrog keeps from one step to the next.

    The velocities (m/s) half a step after the state, the work (J) until then, the step `dt` (s), what
    the last evaluation wrote along each line, and the largest tensions (N) so far of the segments of
    lines, both by line and empty where nobody asks for them. `low` is what rounding has left out of the
    displacements (m), in single precision alone and where something carries lines along. `memory` is
    that of the state half a step after it.
    """

    velocity: dict[str, Array]
    work: dict[str, dict[str, Array]]
    dt: Float[Array, ""]
    over: dict[str, Workspace]
    peaks: dict[str, Float[Array, " n"]]
    low: dict[str, Array]
    memory: dict[str, Memory]


class Leapfrog(diffrax.AbstractSolver):
    """Kick-drift leapfrog with velocities kept at half steps.

    x_n+1 = x_n + dt v_n+1/2, then the forces at x_n+1 with the velocities of half a step before,
    then a kick of length dt centred on t_n+1 (`Model.kick`) that gives v_n+1, the velocity of the
    state, and v_n+3/2, kept between steps. Work is accumulated at the same instants, so that the
    kinetic energy is accounted for to rounding. The step must be constant.

    With `watch_peaks` it also keeps the largest tensions of every line's segments so far (N). They are
    known here, which makes them a twentieth of a step; worked out anew from the state they would be a
    fifth.

    With `writes_over` each step writes what it works out along the lines over what the one before
    left there, which saves memory traffic; on the way back of reverse mode it costs some.
    """

    writes_over: bool = eqx.field(static=True, default=True)
    watch_peaks: bool = eqx.field(static=True, default=False)
    term_structure: ClassVar = CableTerm
    interpolation_cls: ClassVar = diffrax.LocalLinearInterpolation

    def order(self, terms):
        """2."""
        return 2

    def init(self, terms, t0, t1, y0, args):
        """Velocities and work half a step after the start, from the accelerations at the start."""
        t0, dt = jnp.asarray(t0), jnp.asarray(t1 - t0)
        half = 0.5 * dt
        kind = next(iter(y0.velocity.values())).dtype
        slope, start = rates(args, t0, y0, dt.astype(kind))
        velocity, work = jax.tree.map(
            lambda v, a: v + half.astype(v.dtype) * a,
            (y0.velocity, y0.work),
            (slope.velocity, slope.work),
        )
        memory = {
            name: args.lines[name].relaxation.half_a_step_on(
                relaxed, dt.astype(kind), kind != dt.dtype
            )
            for name, relaxed in relaxing(start)
        }
        whole = args.remembering(y0.memory)
        found = evaluate(whole, t0, y0.displacement, velocity, y0.reaction, dt)
        over = workspaces(found) if self.writes_over else {}
        watched = args.lines if self.watch_peaks else {}
        peaks = {n: line.law.tension(line.reference_strain) for n, line in watched.items()}
        velocity = driven_velocities(args, t0, dt, y0.displacement, velocity)
        rounds = kind != dt.dtype and travels(args)
        low = jax.tree.map(jnp.zeros_like, y0.displacement) if rounds else {}
        return HalfStep(velocity, work, dt, over, peaks, low, memory)

    def step(self, terms, t0, t1, y0, args, solver_state, made_jump):
        """One step from t0 to t1 (s)."""
        model = args
        kept: HalfStep = solver_state
        before, work, over = kept.velocity, kept.work, kept.over
        t1 = jnp.asarray(t1)
        # the step is kept rather than taken as t1 - t0, so that what follows from it alone is
        # worked out once and not at every step
        dt = kept.dt.astype(next(iter(before.values())).dtype)
        place, low = moved(model, t1, y0.displacement, kept.low, before, dt)
        model = model.with_low(low).remembering(kept.memory)
        kicked = kick(model, t1, place, before, y0.reaction, dt, over or None)
        middle, after, found = kicked.middle, kicked.after, kicked.found
        now = work
        if work:
            power = powers(model, t1, found, place, before, middle, after, dt)
            now = jax.tree.map(lambda w, p: w + 0.5 * dt * p, work, power)
            work = jax.tree.map(lambda w, p: w + dt * p, work, power)
        memory = {name: relaxed.now for name, relaxed in relaxing(found)}
        y1 = State(place, middle, now, kicked.reaction, y0.tension, memory)
        dense = {"y0": y0, "y1": y1}
        over = workspaces(found) if over else {}
        peaks = {name: most(found[name].line.pull, peak) for name, peak in kept.peaks.items()}
        later = {n: r.after for n, r in relaxing(found) if r.after is not None}
        ahead = HalfStep(after, work, kept.dt, over, peaks, low, later)
        return y1, None, dense, ahead, diffrax.RESULTS.successful

    def func(self, terms, t0, y0, args):
        """dy/dt at the start of a step."""
        return rates(args, jnp.asarray(t0), y0)[0]
