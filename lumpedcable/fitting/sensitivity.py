"""What a result depends on: derivatives of one scalar of a run by every number of its scene."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.arrays import GroupArrays, GroupSpec, seen_plan
from lumpedcable.fitting.axes import axes_reached, axes_seen
from lumpedcable.fitting.checks import unknown_start
from lumpedcable.fitting.difference import Check, checked
from lumpedcable.fitting.observe import MEASURE, STOP, Watched, watched
from lumpedcable.fitting.parameters import numbers_of
from lumpedcable.fitting.residual import group_start, run_group, run_models, started
from lumpedcable.fitting.scalar import AskedError, Scalar
from lumpedcable.model.layout import make_layout
from lumpedcable.model.numbers import number
from lumpedcable.physics.vectors import root
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.measures import BodyMeasure
from lumpedcable.status import ADVICE, MEANING, Status
from lumpedcable.study.compiled import RUN_OFTEN, RUN_ONCE, Structure, understood
from lumpedcable.study.compiling import heard
from lumpedcable.study.endless import MOST_STEPS, EndlessError, endless_words, total_steps
from lumpedcable.study.kept import program
from lumpedcable.study.plan import (
    asked_step,
    plan_of,
    rounded_steps,
    tolerances,
)
from lumpedcable.timings import Timings

__all__ = ["Sensitivity", "picked", "scalar_slopes", "sensitivity_of", "setting_of"]

Array = NDArray[np.float64]
AT_ONCE = 32  # most directions that go through time together
# A way back adds up along the line at every step, once for each number of it. The compiler would make a
# tree of each sum and write it out addition by addition: more code than the nearest cache holds. Of one
# line in double precision a loop is as good.
PLAIN_SUMS = {"xla_disable_hlo_passes": "tree_reduction_rewriter"}
RUN_BACK = understood((RUN_OFTEN or {}) | PLAIN_SUMS) or RUN_OFTEN
WILD = 1e4  # per cent per per cent from which a derivative tells of rounding alone
SURROUNDINGS = ("water", "air", "sea", "seabed")  # whose numbers' labels do not say whose they are
NO_END = np.iinfo(np.int32).max  # steps: those of a run are known, and no trial asks for more
SLOW = 20.0  # s that a batch of directions may take before differences have a program of their own
REVERSE_FROM = 200  # numbers from which one way back is cheaper than so many ways forward


@dataclass(frozen=True)
class Sensitivity:
    """A scalar of a run (SI), and its derivatives by numbers of the scene, the largest share first.

    `slopes` are d(scalar)/d(number) in SI; `shares` are relative: per cent of the scalar per per cent
    of the number, 0 where the number is 0. `check` compares the largest share with differences.
    """

    scalar: Scalar
    value: float
    status: Status
    keys: tuple[str, ...]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    slopes: Array
    shares: Array
    check: Check | None = None

    @property
    def remarks(self) -> list[str]:
        """What is to be known of the derivatives, in words."""
        said = []
        if self.status is not Status.OK:
            said.append(f"The run failed: {MEANING[self.status]}; {ADVICE[self.status]}.")
        if np.any(np.abs(self.shares[np.isfinite(self.shares)]) > WILD):
            said.append(
                "Derivatives as large as these tell of rounding alone, as where a slack line crumples "
                "or links rattle: they say nothing. Take a result of an earlier time (output.duration)."
            )
        if self.check is not None and not self.check.good:
            said.append(str(self.check))
        if none := int(np.sum(~np.isfinite(self.slopes))):
            said.append(f"By {none} of the numbers it has no derivative here.")
        return said


def sensitivity_of(
    study: Study, scalar: Scalar, run: int = 0, reverse: bool | None = None
) -> Sensitivity:
    """Derivatives of a scalar of one run by every number of its physics.

    Exact derivatives of the discrete model, at the number of steps that the run takes. Forward mode,
    or reverse mode with one state kept an output where there are very many numbers (or as `reverse`
    says).

    Raises:
        SceneError: the run would take more steps than anybody waits for.
        AskedError: the scalar's place is not in the scene, or its measure never counts.
    """
    scene = study.runs[run]
    named = _numbers(study, scene)
    keys = tuple(key for key, _, _ in named)
    values = np.array([scene.numbers()[key] for key in keys])
    back = len(keys) >= REVERSE_FROM if reverse is None else reverse
    try:
        spec, arrays = setting_of(scene, scalar, keys, back)
    except EndlessError as error:
        raise SceneError([study.fault("output.duration", str(error))]) from None
    timings = Timings()
    with heard(timings):
        found, status, slopes = _slopes(spec, arrays, values, scalar.reduction, back)
        value = float(found)
        timings.mark("slopes")
    rounds = 1 if back else _rounds(values.size)
    slow = timings.stages["slopes"] > SLOW * rounds
    if not np.isfinite(value) and int(status) == Status.OK:
        raise AskedError(scalar.never)
    shares = np.asarray(slopes) * values / value if value else np.zeros(values.size)

    def result(values: Array) -> float:
        if slow:
            found, status = _alone(spec, arrays, values, scalar.reduction)
        else:
            found, status, _ = _slopes(spec, arrays, values, scalar.reduction, back, rounds=1)
        return float(found) if int(status) == Status.OK else np.nan

    known = np.where(np.isfinite(shares), shares, 0.0)
    check = None
    if int(status) == Status.OK and np.any(known):
        check = checked(keys, values, known, value, result)
    order = np.lexsort((-np.abs(slopes), -np.abs(shares)))
    return Sensitivity(
        scalar, value, Status(int(status)), tuple(keys[k] for k in order),
        tuple(named[k][1] for k in order), tuple(named[k][2] for k in order), values[order],
        np.asarray(slopes)[order], shares[order], check,
    )  # fmt: skip


def scalar_slopes(
    study: Study, scalar: Scalar, keys: tuple[str, ...], values: Array, run: int = 0
) -> tuple[float, Status, Array]:
    """A scalar of a run with other `values` (SI) of numbers, its status, its derivatives by them."""
    scene = study.runs[run]
    scene = scene.with_numbers(dict(zip(keys, map(float, values), strict=True)))
    spec, arrays = setting_of(scene, scalar, keys, back=False)
    found, status, slopes = _slopes(spec, arrays, np.asarray(values), scalar.reduction, False)
    if not np.isfinite(found) and int(status) == Status.OK:
        raise AskedError(scalar.never)
    return float(found), Status(int(status)), np.asarray(slopes)


def _numbers(study: Study, scene: Scene) -> list[tuple[str, str, str]]:
    """Key, label and unit of every number of the physics, without directions (made unit vectors)."""
    found = []
    for key in scene.numbers():
        if key.split(".")[0] in ("output", "solver", "statics") or ".direction." in key:
            continue
        if key.endswith(".max_strain"):
            continue  # it bounds the step and touches nothing else
        numbers, _ = numbers_of(study, key)
        where = key.split(".")[0]
        of = f"{where} " if where in SURROUNDINGS else ""
        found += [(n.key, of + n.label, n.kind.unit) for n in numbers]
    labels = [label for _, label, _ in found]
    return [(k, k if labels.count(label) > 1 else label, u) for k, label, u in found]


def setting_of(
    scene: Scene, scalar: Scalar, keys, back: bool, spare: float = 0.0, anywhere: bool = False
) -> tuple[GroupSpec, GroupArrays]:
    """One run of a scene as a group of one, looked at at its own output times.

    With `back` it has as many steps as the scene asks for, and a share `spare` more. A step that the
    scene gives is obeyed as by a run, which may be above the bound: what is sampled judges it alone.
    It is right at the scene's own numbers, with their derivatives; `anywhere`, for other values too.

    Raises:
        EndlessError: it would take more steps than anybody waits for.
        AskedError: there is no such place, no coordinates for the scene, or a break in it begins at a
            tension.
    """
    if (wrong := unknown_start(scene)) is not None:
        raise AskedError(wrong)
    layout = make_layout(scene)
    what, place = Watched(scalar.quantity, scalar.at, None, None), 0.0
    measure = scene.measures.get(scalar.at) if scalar.quantity == MEASURE else None
    upright = isinstance(measure, BodyMeasure)  # a height, or a speed up or down
    try:
        if scalar.quantity not in (MEASURE, STOP):
            what, place = watched(scene, layout, scalar.quantity, scalar.at, scalar.component)
        if anywhere:
            coordinates = axes_reached(scene, keys)
        else:
            coordinates = axes_seen(scene, keys, 2 if upright else what.component)
    except ValueError as error:
        raise AskedError(str(error)) from error
    plan = plan_of(scene, layout)
    plan = seen_plan(plan)
    count, solver = scene.output.count, scene.solver
    shared = {key: number(x) for key, x in scene.numbers().items()}
    arrays = GroupArrays(
        shared, {}, jnp.asarray(coordinates.axes), jnp.asarray(coordinates.origin),
        jnp.array([[place]]), jnp.array([scene.output.every]), None, None, None, None,
        jnp.zeros((1, 1, count + 1)), jnp.ones((1, 1, count + 1)), jnp.asarray(1, int),
        jnp.asarray(NO_END, int), number(1.0), *map(number, tolerances(solver)),
    )  # fmt: skip
    free = tuple((key, (k,)) for k, key in enumerate(keys))
    structure = Structure(scene.skeleton(), layout, scene)
    spec = GroupSpec(structure, plan, (what,), count, free, strained=True)
    if plan.adaptive:
        return spec, arrays
    at = np.array([scene.numbers()[key] for key in keys])
    _, bound, _ = group_start(spec, arrays, at)
    bound = np.asarray(bound)
    steps = math.ceil(int(rounded_steps(scene, bound)[0]) * (1.0 + spare))
    if total_steps(scene, steps) > MOST_STEPS:
        step = float(asked_step(scene, bound)[0]) / (1.0 + spare)
        raise EndlessError(endless_words(scene, scene.output.duration, step))
    # typed as they were: else what starts a run would be compiled again
    unjudged = arrays._replace(courant=number(jnp.inf))
    if back:
        judged = arrays if solver.step is None else unjudged
        return replace(spec, steps=steps), judged
    # more than that are taken by nobody: the run itself takes so many
    return spec, unjudged._replace(steps=jnp.asarray(steps, int))


def _slopes(
    spec: GroupSpec,
    arrays: GroupArrays,
    values,
    reduction: str,
    back: bool,
    rounds: int | None = None,
):
    """The scalar, its status and its derivatives; of so many rounds of directions alone.

    One round is the quickest way to the scalar itself, since nothing is compiled for it.
    """
    values = jnp.asarray(values)
    if back:
        return _backwards(spec, arrays, values, reduction)
    # batches of one size, so that one program is compiled: those too many lead nowhere
    whole = _rounds(values.size)
    width = -(-values.size // whole)
    starts = _starts(spec, arrays, values, jnp.eye(whole * width, values.size))
    found = [
        _forwards(spec, arrays, starts, reduction, width, k * width) for k in range(rounds or whole)
    ]
    slopes = jnp.concatenate([slope for _, _, slope in found])
    return found[0][0], found[0][1], slopes[: values.size]


def _rounds(count: int) -> int:
    """How many batches of directions so many numbers take."""
    return -(-count // AT_ONCE)


def _alone(spec: GroupSpec, arrays: GroupArrays, values, reduction: str):
    """The scalar and its status, without derivatives."""
    return _onwards(spec, arrays, *group_start(spec, arrays, jnp.asarray(values)), reduction)


@partial(program, static=("spec", "reduction"), options=RUN_OFTEN)
def _onwards(spec: GroupSpec, arrays: GroupArrays, models, bound, converged, reduction: str):
    """The scalar and its status from what a run starts from."""
    found, status, _, _ = run_models(spec, arrays, models, bound, converged)
    return picked(found[0, 0], reduction), status[0]


@partial(program, static=("spec",), options=RUN_ONCE)
def _starts(spec: GroupSpec, arrays: GroupArrays, values, directions):
    """What runs start from, numbers apart from the rest, and the numbers' change in each direction.

    A program of its own: it runs once, and takes long to compile where the compiler tries hard.
    """

    def start(values):
        models, bound, converged = started(spec, arrays, values)
        floats, rest = eqx.partition(models, eqx.is_inexact_array)
        return floats, (rest, bound, converged)

    def along(direction):
        return jax.jvp(start, (values,), (direction,), has_aux=True)

    everything = jax.vmap(along)(directions)
    changes = everything[1]
    floats, _, (rest, bound, converged) = jax.tree.map(lambda x: x[0], everything)
    return floats, changes, rest, bound, converged


@partial(program, static=("spec", "reduction", "width"), options=RUN_OFTEN)
def _forwards(spec: GroupSpec, arrays: GroupArrays, starts, reduction: str, width: int, first):
    """The scalar, its status and so many derivatives from the `first`, together through time."""
    floats, changes, rest, bound, converged = starts

    def scalar(floats):
        models = eqx.combine(floats, rest)
        found, status, _, _ = run_models(spec, arrays, models, bound, converged)
        value = picked(found[0, 0], reduction)
        return value, (value, status[0])

    def along(change):
        _, slope, (value, status) = jax.jvp(scalar, (floats,), (change,), has_aux=True)
        return slope, value, status

    some = jax.tree.map(lambda x: jax.lax.dynamic_slice_in_dim(x, first, width), changes)
    slopes, value, status = jax.vmap(along)(some)
    return value[0], status[0], slopes


@partial(program, static=("spec", "reduction"), options=RUN_BACK)
def _backwards(spec: GroupSpec, arrays: GroupArrays, values, reduction: str):
    """The scalar, its status and its derivatives, by one way back."""

    def scalar(values):
        found, status, _, _ = run_group(spec, arrays, values)
        value = picked(found[0, 0], reduction)
        return value, (value, status[0])

    slopes, (value, status) = jax.grad(scalar, has_aux=True)(values)
    return value, status, slopes


def picked(history, reduction: str):
    """One number of a history; a measure is NaN while it does not count."""
    counts = jnp.isfinite(history)

    def mean(values):
        return jnp.sum(jnp.where(counts, values, 0.0)) / jnp.sum(counts)

    return {
        "max": lambda: jnp.max(jnp.where(counts, history, -jnp.inf)),
        "min": lambda: jnp.min(jnp.where(counts, history, jnp.inf)),
        "mean": lambda: mean(history),
        "std": lambda: root(mean((jnp.where(counts, history, 0.0) - mean(history)) ** 2)),
        "first": lambda: history[jnp.argmax(counts)],
        "last": lambda: history[history.size - 1 - jnp.argmax(counts[::-1])],
    }[reduction]()
