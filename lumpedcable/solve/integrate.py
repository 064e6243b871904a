"""Through time: from output to output with a fixed or an adaptive step, in pieces of fixed size.

One compiled program advances a scene by up to `Plan.outputs` outputs, whatever their number and whatever
the number of steps between them; a loop outside it shows progress, writes what is finished and can be
interrupted.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int, PyTree

from lumpedcable.model.attached import moved_ends, on_paths, start_velocities
from lumpedcable.model.balance import reactions_at_rest
from lumpedcable.model.bodies import body_key
from lumpedcable.model.ends import end_name
from lumpedcable.model.energy import empty_body_work, empty_work
from lumpedcable.model.hauled import steered
from lumpedcable.model.model import Model
from lumpedcable.model.motion import carries
from lumpedcable.model.state import State
from lumpedcable.physics.linear import pick
from lumpedcable.physics.motion import velocity_of
from lumpedcable.physics.precision import cast
from lumpedcable.physics.tension import strain_at
from lumpedcable.solve.constrained import Constrained, rod_gains
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.jerk import jerked
from lumpedcable.solve.keeping import field_slots, put, put_seldom, room_for
from lumpedcable.solve.largest import so_far
from lumpedcable.solve.leapfrog import CableTerm, HalfStep, Leapfrog
from lumpedcable.solve.listed import listed
from lumpedcable.solve.observe import Recoil, Sample, sample, tips, watch, watched, watches
from lumpedcable.solve.plan import Numbers, Plan, Progress, peaks_of
from lumpedcable.solve.reverse import block_length, scan_in_blocks
from lumpedcable.solve.rk4 import RK4
from lumpedcable.solve.stop import halted, held, rests, time_of
from lumpedcable.solve.trips import tripped, trips
from lumpedcable.solve.upright import upright, uprightest
from lumpedcable.solve.watching import Watching
from lumpedcable.status import Status

__all__ = ["METHODS", "advance", "begin", "initial_state", "interval"]

# of an output interval: stages that have no solution with a step as short as this will not have any
LEAST_SOLVED = 1e-10
METHODS = {
    "leapfrog": Leapfrog,
    "constrained": Constrained,
    "rk4": RK4,
    "euler": diffrax.Euler,
    "heun": diffrax.Heun,
    "midpoint": diffrax.Midpoint,
    "ralston": diffrax.Ralston,
    "bosh3": diffrax.Bosh3,
    "tsit5": diffrax.Tsit5,
    "dopri5": diffrax.Dopri5,
    "dopri8": diffrax.Dopri8,
    "kvaerno3": diffrax.Kvaerno3,
    "kvaerno4": diffrax.Kvaerno4,
    "kvaerno5": diffrax.Kvaerno5,
}


def initial_state(model: Model, energy: bool, stepping: bool) -> State:
    """A model at rest at its reference, its driven ends already moving as they will."""
    t = jnp.zeros(())
    displacement = {name: jnp.zeros_like(line.reference) for name, line in model.lines.items()}
    velocity = dict(displacement)
    for name, node, end in moved_ends(model):
        v = velocity_of(end.motion, t).astype(velocity[name].dtype)
        velocity[name] = velocity[name].at[:, node].set(v)
    displacement |= {body_key(n): jnp.zeros_like(b.reference) for n, b in model.bodies.items()}
    velocity = steered(model, t, None, start_velocities(model, velocity))
    velocity = jerked(model, t, displacement, velocity)
    work = {name: empty_work(line, stepping) for name, line in model.lines.items()}
    work |= {body_key(n): empty_body_work(model, n) for n in model.bodies}
    tension = {
        name: line.law.tension(line.reference_strain)
        for name, line in model.lines.items()
        if line.inextensible
    }
    memory = {
        name: line.relaxation.at_rest(line.law, line.reference_strain)
        for name, line in model.lines.items()
        if line.relaxation is not None
    }
    reaction = reactions_at_rest(model, displacement)
    return State(displacement, velocity, work if energy else {}, reaction, tension, memory)


def begin(model: Model, plan: Plan, numbers: Numbers) -> tuple[Progress, Sample]:
    """The start of a run and its first sample."""
    y = initial_state(model, plan.energy, plan.method == "leapfrog")
    dt = numbers.every / numbers.steps
    zero = jnp.zeros(())
    solver_state = dt
    if not plan.adaptive:
        solver = fixed_solver(plan, numbers)
        solver_state = solver.init(CableTerm(zero), zero, dt, y, model)
    seen = watches(model, y, plan.recoils)
    never, going = jnp.zeros((), bool), jnp.zeros((), jnp.int32)
    own = None if plan.adaptive else dt
    first = sample(model, zero, y, plan.quantities, own, going, rod_gains(solver_state, y))
    moving = jnp.asarray(jnp.nan, jnp.float64)  # a type as later, lest the program compile twice
    standing = upright(model, y)
    ends = tips(model, zero, y, plan.tips)
    largest = so_far(model, first.largest, {}, plan.borne) | watched(seen)
    resting = _rests(model, plan.recoils)
    first = first._replace(largest=largest, upright=standing, tips=ends, rests=resting)
    trip = trips(model, y)
    return Progress(y, solver_state, seen, going, moving, y.tension, never, standing, trip), first


def _rests(model: Model, recoils: tuple[Recoil, ...]) -> dict[str, Float[Array, " 2"]]:
    """Strains (-) and tensions (N) at rest of recoiling ends of lines with loads, by end.

    Between the middle of the last segment and the end lies half a segment's weight. What the law cannot
    tell of the end, as of a slack one, is that of the middle. Without loads both are the same.
    """
    found = {}
    for name, node in recoils:
        line = model.lines[name]
        if not line.loads or line.inextensible:
            continue
        tension = tension_at(line, node, model, name)
        strain = strain_at(line.law, tension, line.max_strain)
        middle = pick(line.reference_strain, line.segment(node))
        inside = line.law.tension(middle)
        close = float(jnp.finfo(tension.dtype).eps) ** 0.5 * jnp.abs(tension)
        known = jnp.abs(line.law.tension(strain) - tension) <= close
        known &= jnp.abs(inside - tension) > close
        both = jnp.stack([strain, tension]), jnp.stack([middle, inside])
        found[end_name(name, node)] = jnp.where(known, *both)
    return found


def fixed_solver(plan: Plan, numbers: Numbers) -> diffrax.AbstractSolver:
    """The solver for given steps; an implicit one finds its stages to the plan's tolerances."""
    method = METHODS[plan.method]
    stages = plan.sloped and issubclass(method, diffrax.AbstractRungeKutta)
    options: dict[str, Any] = {"scan_kind": "bounded"} if stages else {}
    if issubclass(method, diffrax.AbstractImplicitSolver):
        own = cast(numbers, plan.dtype)
        options["root_finder"] = diffrax.VeryChord(rtol=own.rtol, atol=own.atol, norm=_size)
    if method is Leapfrog:
        options |= {"writes_over": not isinstance(numbers.steps, int)}
        options |= {"watch_peaks": plan.watch_peaks}
    return method(**options)


def _fixed(
    model: Model, plan: Plan, numbers: Numbers, run: Progress, start, block: int | None,
    turns: tuple[Any, Any] | None, whole: bool,
) -> Progress:  # fmt: skip
    """The steps of one output interval from `start` (s) on, which are equal: `turns`, or all."""
    solver, term = fixed_solver(plan, numbers), CableTerm(jnp.zeros(()))
    dt = numbers.every / numbers.steps
    implicit = isinstance(solver, diffrax.AbstractImplicitSolver)
    staggered = isinstance(solver, Leapfrog | Constrained)  # sees to its ends itself

    def step(i, run: Progress) -> Progress:
        i = i if whole else listed(i)
        t0 = start + i * dt
        t1 = start + (i + 1) * dt
        y, _, _, state, result = solver.step(term, t0, t1, run.y, model, run.solver_state, False)
        if not staggered:
            y = _settled(model, t1, y, dt.astype(plan.dtype))
        seen = watch(model, y, run.seen, plan.recoils, t1, dt)
        stuck = run.stuck
        if implicit:  # no other method can fail to find its stages
            stuck = _first(stuck, result != diffrax.RESULTS.successful, Status.STEP_NOT_FOUND)
        peaks = {name: jnp.maximum(p, y.tension[name]) for name, p in run.rod_peaks.items()}
        standing = uprightest(model, y, run.upright)
        trip = tripped(model, y, run.trips, t1, dt)
        after = Progress(y, state, seen, stuck, run.stopped, peaks, run.lost, standing, trip)
        if isinstance(solver, Constrained):
            after = held(run, after, result != diffrax.RESULTS.successful)
        return after if plan.stop is None else halted(model, plan, run, after, t0, dt)

    if isinstance(numbers.steps, int):
        # for reverse mode: the way back takes each step again, which is cheaper than to fetch from
        # memory all that a step has worked out
        again = jax.checkpoint(lambda run, i: (step(i, run), None), prevent_cse=False)
        block = block_length(numbers.steps, run) if block is None else block
        return scan_in_blocks(again, run, numbers.steps, block)[0]
    return jax.lax.fori_loop(*turns or (0, numbers.steps), step, run)


def _adaptive(model: Model, plan: Plan, numbers: Numbers, run: Progress, start) -> Progress:
    """One output interval from `start` (s), the step chosen by the estimated error."""
    # diffrax steps in one precision, the state's: its times count from the start of the interval
    dtype = next(iter(run.y.velocity.values())).dtype
    guess = jnp.clip(run.solver_state, 1e-6 * numbers.every, numbers.every)
    own, guess = cast((numbers, guess), str(dtype))
    steps = diffrax.PIDController(rtol=own.rtol, atol=own.atol, norm=_size)

    eps = 4.0 * jnp.finfo(dtype).eps
    least = eps * own.every, jnp.maximum(LEAST_SOLVED, eps) * own.every

    def part(carry, until):
        t0, y, seen, taken, stuck = carry
        until = jnp.where(stuck > 0, t0, until)
        controller = Watching(steps, seen, start, least, plan.recoils)
        solution = diffrax.diffeqsolve(
            CableTerm(start), METHODS[plan.method](), t0, until, guess, y, args=model,
            stepsize_controller=controller, max_steps=plan.max_steps, throw=False,
            saveat=diffrax.SaveAt(t1=True, controller_state=bool(seen)),
            adjoint=diffrax.ForwardMode(),
        )  # fmt: skip
        assert solution.ys is not None
        y = jax.tree.map(lambda x: x[0], solution.ys)
        y = _settled(model, start + until, y, None)
        if seen:
            assert solution.controller_state is not None
            _, seen = solution.controller_state
        stuck = _first(
            stuck, solution.result == diffrax.RESULTS.max_steps_reached, Status.TOO_MANY_STEPS
        )
        stuck = _first(stuck, solution.result != diffrax.RESULTS.successful, Status.STEP_NOT_FOUND)
        return (until, y, seen, taken + solution.stats["num_accepted_steps"], stuck), None

    found = jnp.zeros((), dtype), run.y, run.seen, jnp.zeros((), jnp.int64), run.stuck
    if run.y.reaction:
        found, _ = jax.lax.scan(part, found, _until_breaks(model, own.every, start))
    else:
        found, _ = part(found, own.every)
    _, y, seen, taken, stuck = found
    dt, standing = numbers.every / jnp.maximum(taken, 1), uprightest(model, y, run.upright)
    return Progress(y, dt, seen, stuck, run.stopped, run.rod_peaks, run.lost, standing, run.trips)


def _first(stuck, failed, status: Status) -> Int[Array, ""]:
    """`stuck` as it is, or why steps end now."""
    return jnp.where((stuck == 0) & failed, jnp.asarray(int(status), stuck.dtype), stuck)


def _settled(model: Model, t, y: State, dt) -> State:
    """The same state, with moved ends as they are at t (s), and what those that can break carry."""
    displacement, velocity = on_paths(model, t, y.displacement, y.velocity)
    reaction = y.reaction
    if reaction:
        whole = model.remembering(y.memory)
        reaction = carries(whole, t, displacement, velocity, reaction, dt)
    return State(displacement, velocity, y.work, reaction, y.tension, y.memory)


def _until_breaks(model: Model, every, start) -> Float[Array, " parts"]:
    """Times (s) from `start` on that cut an interval just before each break that begins in it.

    There what an end carries is known, which is what decays from then on.
    """
    starts = jnp.stack([end.release.start for *_, end in model.breakable() if end.release])
    # so much before that neither precision takes the one for the other
    small = jnp.finfo(every.dtype).eps * every + jnp.finfo(starts.dtype).eps * (start + every)
    ahead = jnp.clip(starts - start - 8.0 * small, 0.0, every).astype(every.dtype)
    return jnp.append(jnp.sort(ahead), every)


def _size(error: State) -> Float[Array, ""]:
    """Size of an error: of the motion and of what relaxes; energies are a by-product."""
    return _rms((error.displacement, error.velocity, error.memory))


def _rms(tree: PyTree) -> Float[Array, ""]:
    leaves = [jnp.ravel(x) for x in jax.tree.leaves(tree)]
    return jnp.sqrt(jnp.mean(jnp.concatenate(leaves) ** 2))


def interval(
    model: Model, plan: Plan, numbers: Numbers, run: Progress, start, block: int | None = None,
    turns: tuple[Any, Any] | None = None, whole: bool = True,
) -> Progress:  # fmt: skip
    """One output interval of a run, from `start` (s) on.

    `block` is the number of steps from one state that reverse mode keeps to the next; None: what
    `block_length` says of this interval alone. `turns` are the equal steps that are taken, from which
    number on and before which; None: all. They are one function of the CPU's if it is to be `whole`.
    """
    if plan.adaptive:
        return _adaptive(model, plan, numbers, run, start)
    return _fixed(model, plan, numbers, run, start, block, turns, whole)


def advance(
    model: Model, plan: Plan, numbers: Numbers, run: Progress, first: Int[Array, ""],
    count: Int[Array, ""], keep: Callable[[Sample], Any] | None = None,
    ends: tuple[Int[Array, ""], Int[Array, ""]] | None = None,
) -> tuple[Progress, Any]:  # fmt: skip
    """`count` outputs on from output number `first`; samples (outputs of the plan, ...).

    `keep` makes of a sample what is kept of it; None: all, but fields only as `put_seldom` keeps them,
    of every `plan.fields_after`th output. `ends` are the equal steps of the first interval that are
    taken already, and those of the last one that are taken now or were before; None: none, and all.
    The last sample of an interval that is not gone through to its end means nothing.
    """
    dt = None if plan.adaptive else numbers.every / numbers.steps

    def sample_at(run: Progress, t) -> Any:
        whole = model
        if isinstance(run.solver_state, HalfStep):
            whole = model.with_low(run.solver_state.low)
        now = time_of(model, plan, run, t)
        gains = rod_gains(run.solver_state, run.y)
        found = sample(whole, now, run.y, plan.quantities, dt, run.stuck, gains)
        largest = so_far(model, found.largest, peaks_of(plan, run), plan.borne)
        largest |= watched(run.seen)
        more = {"largest": largest, "upright": run.upright}
        more["tips"] = tips(model, now, run.y, plan.tips)
        found = found._replace(stopped=rests(model, plan, run), lost=run.lost, **more)
        return found if keep is None else keep(found)

    shapes = jax.eval_shape(lambda r: sample_at(r, numbers.every), run)
    empty = room_for(shapes, plan.outputs)
    seldom = keep is None and plan.fields_after > 1
    if seldom:
        slots = field_slots(plan.outputs, plan.fields_after)
        empty = empty._replace(fields=room_for(shapes.fields, slots))

    def body(k, carry):
        run, kept = carry
        k = listed(k) if model.rigid else k
        turns = None
        if ends is not None:
            turns = (
                jnp.where(k == 0, ends[0], 0),
                jnp.where(k == count - 1, ends[1], numbers.steps),
            )
        run = interval(model, plan, numbers, run, (first + k) * numbers.every, turns=turns)
        found = sample_at(run, (first + k + 1) * numbers.every)
        if seldom:
            return run, put_seldom(kept, found, first, k, plan.fields_after)
        return run, put(kept, found, k)

    return jax.lax.fori_loop(0, count, body, (run, empty))
