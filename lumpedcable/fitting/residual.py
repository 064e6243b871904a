"""Deviations of the model from the data, in standard deviations, as a function of the parameters."""

from __future__ import annotations

from functools import partial
from itertools import accumulate
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from lumpedcable.fitting.arrays import Arrays, GroupArrays, GroupSpec, Spec, TableArrays, TableSpec
from lumpedcable.fitting.observe import MEASURE, PEAK, STOP, Watched, look, weights_of
from lumpedcable.fitting.transforms import to_values
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.materials import law_of, relaxation_of
from lumpedcable.model.model import Model
from lumpedcable.physics.precision import cast
from lumpedcable.physics.strain_history import relaxing_tension
from lumpedcable.solve.bound import step_bound
from lumpedcable.solve.constrained import rod_gains
from lumpedcable.solve.integrate import begin, interval
from lumpedcable.solve.observe import Sample, sample
from lumpedcable.solve.plan import Numbers, Progress
from lumpedcable.solve.reverse import block_length, scan_in_blocks
from lumpedcable.solve.signs import signs
from lumpedcable.solve.stop import time_of
from lumpedcable.solve.targets import rest_of
from lumpedcable.status import SIGNS, Status
from lumpedcable.study.compiled import RUN_ONCE
from lumpedcable.study.kept import program
from lumpedcable.study.plan import relaxing_times
from lumpedcable.study.strains import MORE

__all__ = [
    "Prediction",
    "deviations",
    "failed_runs",
    "group_start",
    "penalised",
    "predict",
    "residual",
    "run_group",
    "run_models",
    "started",
    "unpacked",
    "value_and_jacobian",
]

PENALTY = 10.0
"""What a run that failed is taken to miss every value by, over the largest value of its column."""


class Prediction(NamedTuple):
    """What the model says: tables (points,), groups (runs, observed, points), all in SI.

    By group: `status` of each run, a `Status`; `steps` between outputs; `rough`, the largest change
    (runs, observed) that a parabola between outputs would make instead of the cubic.
    """

    tables: tuple[Float[Any, " points"], ...]
    groups: tuple[Float[Any, "runs observed points"], ...]
    status: tuple[Int[Any, " runs"], ...]
    steps: tuple[Any, ...]
    rough: tuple[Float[Any, "runs observed"], ...]


def predict(spec: Spec, arrays: Arrays, values: Float[Array, " p"]) -> Prediction:
    """The model's answer to every measured value, for parameters in SI."""
    tables = tuple(_table(s, a, values) for s, a in zip(spec.tables, arrays.tables, strict=True))
    groups = [run_group(s, a, values) for s, a in zip(spec.groups, arrays.groups, strict=True)]
    return Prediction(tables, *(zip(*groups, strict=True) if groups else ((),) * 4))


def _table(spec: TableSpec, arrays: TableArrays, values) -> Float[Array, " points"]:
    numbers = dict(arrays.numbers) | {key: values[index] for key, index in spec.free}
    scene = spec.structure.scene.with_numbers(numbers)
    # without the cut of tension_only: a bench pulls, and the fit would stick at the kink
    material = scene.materials[spec.material].model_copy(update={"tension_only": False})
    strain, relaxation = jnp.asarray(arrays.strain), relaxation_of(material)
    tension = law_of(material).tension(strain)
    if arrays.time is None or relaxation is None:
        return tension
    return tension + relaxing_tension(relaxation, strain, jnp.asarray(arrays.time))


def started(spec: GroupSpec, arrays: GroupArrays, values):
    """Models of a group at rest, the step bound of each run (s), and whether it is in equilibrium."""
    shared, own = dict(arrays.shared), dict(arrays.own)
    for key, index in spec.free:
        shared.pop(key, None)
        own.pop(key, None)
        if len(index) == 1:
            shared[key] = values[index[0]]
        else:
            own[key] = values[jnp.array(index)]
    coordinates = _coordinates(arrays)
    chosen = tuple(key for key, _ in spec.free)

    def start(mine):
        scene = spec.structure.scene.with_numbers(_turned({**shared, **mine}, chosen))
        found = rest_of(scene, spec.structure.layout, coordinates)
        times = [jnp.asarray(time, float) for time in relaxing_times(scene).values()]
        bound = jnp.min(jnp.stack([step_bound(found.model), *times]))
        return cast(found.model, spec.plan.dtype), bound, found.converged

    axis, runs = None if not own else 0, arrays.every.shape[0]
    return jax.vmap(start, in_axes=(axis,), axis_size=runs)(own)


def _turned(numbers: dict[str, Any], chosen: tuple[str, ...]) -> dict[str, Any]:
    """The numbers of a scene with directions unit vectors again, of which parts are `chosen`."""
    for vector in dict.fromkeys(key[:-2] for key in chosen if key[:-2].endswith(".direction")):
        keys = [f"{vector}.{k}" for k in range(3)]
        parts = jnp.stack([numbers[key] for key in keys])
        numbers |= zip(keys, parts / jnp.linalg.norm(parts), strict=True)
    return numbers


group_start = program(started, ("spec",), RUN_ONCE)


def _coordinates(arrays: GroupArrays) -> Coordinates:
    return Coordinates(arrays.axes, arrays.origin)  # type: ignore[arg-type]


def run_group(spec: GroupSpec, arrays: GroupArrays, values):
    """(runs, observed, points) of a group; status, steps and roughness as in `Prediction`."""
    return run_models(spec, arrays, *started(spec, arrays, values))


def run_models(spec: GroupSpec, arrays: GroupArrays, models: Model, bound, converged):
    """`run_group` from what `started` gives."""
    coordinates = _coordinates(arrays)
    steps = _steps(spec, arrays, bound)

    def run(model, every, last, places, index, mix, less):
        numbers = Numbers(every, steps, arrays.rtol, arrays.atol)  # pyright: ignore[reportArgumentType]
        runs = arrays.every.shape[0]
        kept, status = history(model, spec, numbers, coordinates, places, runs, last)
        if index is None:  # the outputs themselves are asked for
            return kept.T, status, jnp.zeros(kept.shape[1])
        near = kept[index]
        cubic = jnp.einsum("pk,pko->op", mix, near)
        change = jnp.max(jnp.abs(cubic - jnp.einsum("pk,pko->op", less, near)), axis=1)
        return cubic, status, change

    found, status, rough = jax.vmap(run)(
        models, arrays.every, arrays.last, arrays.places, arrays.near, arrays.mix, arrays.less
    )
    if not spec.plan.adaptive:
        wild = _needs(arrays, bound) > steps  # samples alone may miss it: of a slack line, say
        status = jnp.where(wild, int(Status.STEP_BOUND_BROKEN), status)
    status = jnp.where(converged, status, int(Status.STATICS_NOT_CONVERGED))
    return found, status, steps, rough


def _needs(arrays: GroupArrays, bound: Float[Array, " runs"]) -> Float[Array, " runs"]:
    """Steps between outputs that stability asks of each run, not rounded to whole ones."""
    need = arrays.every / (arrays.courant * jax.lax.stop_gradient(bound))
    return need * (1.0 - 1e-9)


def _steps(spec: GroupSpec, arrays: GroupArrays, bound: Float[Array, " runs"]):
    """Steps between outputs: as many as stability asks for, within what the arrays say.

    Rounded up as those of a run are, so that nearby values take the same number.
    """
    if spec.plan.adaptive:
        return 1
    if spec.steps is not None:
        return spec.steps
    count = jnp.maximum(jnp.ceil(jnp.max(_needs(arrays, bound))), 1.0)
    count = jnp.where(jnp.isfinite(count), count, 1.0)
    unit = 2.0 ** jnp.maximum(jnp.floor(jnp.log2(count)) - 4.0, 0.0)
    count = jnp.minimum(jnp.ceil(count / unit) * unit, arrays.most)  # which an int can hold
    return jnp.maximum(count.astype(int), arrays.steps)


def history(
    model: Model, spec: GroupSpec, numbers: Numbers, coordinates: Coordinates, places, runs: int,
    last=None,
) -> tuple[Float[Array, "outputs observed"], Int[Array, ""]]:  # fmt: skip
    """Observed values at every output of one of `runs` runs, the start first, and its `Status`.

    After its `last` output (None: that of the group) a run begins anew, so that it never comes to what
    lies behind its own data: neither its status nor a derivative hears of that. Values from there on
    mean nothing.
    """
    plan = spec.plan
    dt = None if plan.adaptive else numbers.every / numbers.steps
    shown = (*SIGNS, Status.STRAIN_EXCEEDED) if spec.strained else SIGNS

    watched = [
        (what, weights_of(model, coordinates, what, places[k]))
        for k, what in enumerate(spec.watched)
    ]

    def pick(run: Progress, s: Sample, what: Watched, weights):
        if what.quantity == STOP:
            return run.stopped
        if what.quantity == PEAK:
            return run.rod_peaks[what.piece][what.node]
        return look(model, coordinates, s, what, weights)

    def seen(run: Progress, s: Sample):
        values = jnp.stack([pick(run, s, what, weights) for what, weights in watched])
        counts = jnp.array([what.quantity not in (MEASURE, STOP) for what in spec.watched])
        finite = s.finite & jnp.all(jnp.isfinite(values) | ~counts)
        found = signs(s._replace(finite=finite, lost=run.lost, upright=run.upright))
        if spec.strained:
            found[Status.STRAIN_EXCEEDED] = s.largest.get("stretch", jnp.zeros(())) > 1.0 + MORE
        return values, jnp.stack([found[sign] for sign in shown])

    def look_at(run: Progress, k):
        t = time_of(model, plan, run, (own(k) + 1) * numbers.every)
        gains = rod_gains(run.solver_state, run.y)
        return seen(run, sample(model, t, run.y, plan.quantities, dt, run.stuck, gains))

    begun, first = begin(model, plan, numbers)

    def own(k):
        return k if last is None else k % last

    def gone_on(run: Progress, k, block=None):
        if last is not None:
            run = jax.tree.map(lambda old, now: jnp.where(own(k) == 0, old, now), begun, run)
        # with derivatives steps of bodies are so long that one function would take minutes to compile
        whole, start = not model.rigid, own(k) * numbers.every
        return interval(model, plan, numbers, run, start, block, whole=whole)

    if spec.steps is None:

        def body(run, k):
            run = gone_on(run, k)
            return run, look_at(run, k)

        _, (values, wrong) = jax.lax.scan(body, begun, jnp.arange(spec.count))
    else:  # for reverse mode
        block = block_length(spec.count * spec.steps, begun, runs)

        def turn(run, k):
            run = gone_on(run, k, block)
            return run, run._replace(solver_state=None)  # which nobody looks at

        # blocks of whole outputs, or where one takes more steps than that, of a part of its steps
        turns = block // spec.steps or max(1, spec.count)
        _, (values, wrong) = scan_in_blocks(turn, begun, spec.count, turns, look_at)
    now, amiss = seen(begun, first)
    wrong = jnp.concatenate([amiss[None], wrong])
    begins = jnp.where(jnp.any(wrong, axis=0), jnp.argmax(wrong, axis=0), wrong.shape[0])
    status = jnp.array(shown)[jnp.argmin(begins)]
    status = jnp.where(jnp.any(wrong), status, int(Status.OK))
    return jnp.concatenate([now[None], values]), status


def deviations(
    spec: Spec, arrays: Arrays, values: Float[Array, " p"]
) -> tuple[Float[Array, " n"], Float[Array, " m"], Prediction]:
    """(model - data) weight for every value, rows that ask for smoothness, what was predicted.

    A run that failed deviates by nothing: see `penalised`.
    """
    found = predict(spec, arrays, values)
    parts = [(f - a.data) * a.weight for f, a in zip(found.tables, arrays.tables, strict=True)]
    for f, status, a in zip(found.groups, found.status, arrays.groups, strict=True):
        good = (status == Status.OK)[:, None, None]
        parts.append(jnp.where(good, (f - a.data) * a.weight, 0.0).ravel())
    rows = [jnp.zeros(0)]
    for index, a in zip(spec.smooth, arrays.smooth, strict=True):
        slope = jnp.diff(values[jnp.array(index)]) / jnp.diff(a.strain)
        rows.append(jnp.diff(slope) * a.weight)
    return jnp.concatenate(parts), jnp.concatenate(rows), found


def robust(r: Float[Array, " n"], loss: str, c: Float[Array, ""]) -> Float[Array, " n"]:
    """Deviations whose squares are the loss rho(r): sqrt(rho(r)) with the sign of r.

    squares: r^2. huber: r^2 up to c, 2 c |r| - c^2 beyond. cauchy: c^2 ln(1 + r^2/c^2).
    """
    if loss == "squares":
        return r
    if loss == "huber":
        far = jnp.abs(r) > c
        long = jnp.sqrt(jnp.where(far, 2.0 * c * jnp.abs(r) - c**2, 1.0))
        return jnp.where(far, jnp.sign(r) * long, r)
    u = (r / c) ** 2
    small = u < 1e-8
    ratio = jnp.where(small, 1.0 - 0.5 * u, jnp.log1p(u) / jnp.where(small, 1.0, u))
    return r * jnp.sqrt(ratio)


def penalised(
    spec: Spec, arrays: Arrays, z: Float[Array, " p"]
) -> tuple[Float[Array, " n"], Float[Array, " m"]]:
    """What is squared and summed, for unbounded parameters; and the `Prediction` as one array.

    Measured values, then smoothness, then one row for each run: 0, or where the run failed a number
    larger than what its values could deviate by. So the others can still tell where to go.
    """
    z = jnp.where(arrays.held, arrays.at, z)
    r, smooth, found = deviations(spec, arrays, to_values(arrays.transform, z))
    fines = [jnp.zeros(0)]
    for status, a in zip(found.status, arrays.groups, strict=True):
        worst = jnp.max(jnp.abs(a.data * a.weight), axis=2, keepdims=True)
        fine = PENALTY * jnp.sqrt(jnp.sum(jnp.where(a.weight > 0.0, worst, 0.0) ** 2, axis=(1, 2)))
        fines.append(jnp.where(status == Status.OK, 0.0, fine))
    r = robust(r, spec.loss, arrays.threshold)
    flat = [jnp.ravel(jnp.asarray(x, float)) for x in jax.tree.leaves(found)]
    return jnp.concatenate([r, smooth, *fines]), jnp.concatenate(flat)


def unpacked(arrays: Arrays, flat: Float[Array, " m"]) -> Prediction:
    """The `Prediction` that `penalised` packed."""
    tables = tuple(a.data for a in arrays.tables)
    groups = tuple(a.data for a in arrays.groups)
    shape = Prediction(
        tables,
        groups,
        tuple(a.every for a in arrays.groups),
        tuple(jnp.zeros(()) for _ in groups),
        tuple(a.places for a in arrays.groups),
    )
    leaves, tree = jax.tree.flatten(shape)
    sizes = [leaf.size for leaf in leaves]
    parts = jnp.split(flat, list(accumulate(sizes))[:-1])
    filled = [part.reshape(leaf.shape) for part, leaf in zip(parts, leaves, strict=True)]
    return jax.tree.unflatten(tree, filled)


def failed_runs(runs: int, r: Float[Array, " n"]) -> Int[Array, ""]:
    """How many of all `runs` failed, from what `penalised` gave."""
    return jnp.sum(r[r.shape[0] - runs :] > 0.0)


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def residual(spec: Spec, arrays: Arrays, z: Float[Array, " p"]):
    """`penalised`, with its Jacobian worked out as a whole, in forward mode, where it is needed.

    A minimiser then multiplies with a matrix instead of going through time again. What was predicted
    has no derivative.
    """
    return penalised(spec, arrays, z)


@residual.defjvp
def _residual_jvp(spec, primals, tangents):
    arrays, z = primals
    value, flat, slope = value_and_jacobian(spec, arrays, z)
    return (value, flat), (slope @ tangents[1], jnp.zeros_like(flat))


def value_and_jacobian(spec: Spec, arrays: Arrays, z: Float[Array, " p"]):
    """`penalised` and its Jacobian (n, p), zero in the rows of a run that failed."""

    def both(z):
        value, flat = penalised(spec, arrays, z)
        return value, (value, flat)

    slope, (value, flat) = jax.jacfwd(both, has_aux=True)(z)
    return value, flat, jnp.where(jnp.isfinite(slope), slope, 0.0)
