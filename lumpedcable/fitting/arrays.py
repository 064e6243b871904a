"""A problem as structure and arrays: what is compiled, and the numbers that it is given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lumpedcable.fitting.axes import changed_scenes
from lumpedcable.fitting.data import FitProblem, Record, Smooth
from lumpedcable.fitting.observe import Grid, Watched, grid_of, spacing_of
from lumpedcable.fitting.transforms import Transform, transform_of
from lumpedcable.model.layout import make_layout
from lumpedcable.model.numbers import number
from lumpedcable.scene import Fault, Scene, SceneError
from lumpedcable.solve.plan import Plan
from lumpedcable.study.compiled import Structure, prepare_batch
from lumpedcable.study.endless import MOST_STEPS, endless_words
from lumpedcable.study.plan import (
    common_coordinates,
    courant_of,
    plan_of,
    rounded_steps,
    stable_bound,
    tolerances,
)

__all__ = [
    "Arrays",
    "GroupArrays",
    "GroupSpec",
    "Spec",
    "TableArrays",
    "TableSpec",
    "arrays_of",
    "grouped",
    "seen_plan",
]

SEEN = ("position", "velocity", "tension")
MANY = 1000  # times as many steps as at the start values: a wave a thousand times as fast


@dataclass(frozen=True)
class TableSpec:
    """A table's structure; `free` are its free keys, each with the index of its parameter."""

    structure: Structure
    material: str
    free: tuple[tuple[str, int], ...]


@dataclass(frozen=True)
class GroupSpec:
    """The structure of records that go through time together.

    `free`: free keys, each with one parameter's index for all runs, or one index a run. `steps` are
    fixed where reverse mode must know them; None where they are a number among the arrays. A run that
    is `strained` beyond max_strain of a material has failed where that is asked for.
    """

    structure: Structure
    plan: Plan
    watched: tuple[Watched, ...]
    count: int
    free: tuple[tuple[str, tuple[int, ...]], ...]
    steps: int | None = None
    strained: bool = False


@dataclass(frozen=True)
class Spec:
    """All structure of a problem: what another program has to be compiled for."""

    tables: tuple[TableSpec, ...]
    groups: tuple[GroupSpec, ...]
    smooth: tuple[tuple[int, ...], ...]
    loss: str


class TableArrays(NamedTuple):
    """Numbers of the scene by key; strains (-), tensions (N) and weights (1/N), each (points,).

    `time` (s), (points,), where what relaxes counts; else None.
    """

    numbers: dict[str, Float[Any, ""]]
    strain: Float[Any, " points"]
    data: Float[Any, " points"]
    weight: Float[Any, " points"]
    time: Any = None


class GroupArrays(NamedTuple):
    """Numbers of the runs, their grids, and what was measured.

    `shared` are the same in all runs, `own` differ (runs,). places (runs, observed) in m from a line's
    start; every (runs,) in s; `last` (runs,), how many outputs a run's own data need, None where all
    have as many as the group; near, mix (runs, points, 4), and `less` those of a parabola, None where
    the outputs themselves are compared; data and weight (runs, observed, points), the weight 0 where
    there is nothing.
    `steps` is the least number of steps between outputs, `most` the largest that values may ask for: a
    run that needs more fails, so that one wild trial does not take hours.
    """

    shared: dict[str, Float[Any, ""]]
    own: dict[str, Float[Any, " runs"]]
    axes: Float[Any, "3 d"]
    origin: Float[Any, " 3"]
    places: Float[Any, "runs observed"]
    every: Float[Any, " runs"]
    last: Any
    near: Any
    mix: Any
    less: Any
    data: Float[Any, "runs observed points"]
    weight: Float[Any, "runs observed points"]
    steps: Any
    most: Any
    courant: Float[Any, ""]
    rtol: Float[Any, ""]
    atol: Float[Any, ""]


class SmoothArrays(NamedTuple):
    """Strains of a table's points, and the size (N) of a usual change of slope times one over it."""

    strain: Float[Any, " points"]
    weight: Float[Any, ""]


class Arrays(NamedTuple):
    """All numbers of a problem; parameters that are `held` stay `at` a value (unbounded)."""

    transform: Transform
    tables: tuple[TableArrays, ...]
    groups: tuple[GroupArrays, ...]
    smooth: tuple[SmoothArrays, ...]
    threshold: Float[Any, ""]
    held: Any
    at: Float[Any, " p"]


class Member(NamedTuple):
    """A record on its way into a group."""

    record: Record
    scene: Scene
    structure: Structure
    plan: Plan


def arrays_of(problem: FitProblem, steps: Sequence[int] | None = None) -> tuple[Spec, Arrays]:
    """Structure and numbers of a problem.

    `steps`: fixed numbers of steps between outputs, by group, for reverse mode.
    """
    tables = [_table(problem, k) for k in range(len(problem.tables))]
    groups = [_group(problem, members) for members in grouped(problem)]
    if steps is not None:
        groups = [
            (GroupSpec(**{**vars(spec), "steps": int(n)}), arrays)
            for (spec, arrays), n in zip(groups, steps, strict=True)
        ]
    smooth = [_smooth(problem, one) for one in problem.smooth]
    spec = Spec(
        tuple(spec for spec, _ in tables),
        tuple(spec for spec, _ in groups),
        tuple(index for index, _ in smooth),
        problem.method.loss,
    )
    arrays = Arrays(
        transform_of(problem.parameters),
        tuple(arrays for _, arrays in tables),
        tuple(arrays for _, arrays in groups),
        tuple(arrays for _, arrays in smooth),
        number(problem.method.threshold),
        np.zeros(len(problem.parameters), bool),
        np.zeros(len(problem.parameters)),
    )
    return spec, arrays


def _table(problem: FitProblem, k: int) -> tuple[TableSpec, TableArrays]:
    table = problem.tables[k]
    scene = table.study.scene
    values = {
        key: number(value)
        for key, value in scene.numbers().items()
        if key.startswith(f"materials.{table.material}.")
    }
    free = tuple(
        (key, index) for key in values if (index := problem.owner(key, table.name)) is not None
    )
    structure = Structure(scene.skeleton(), make_layout(scene), scene)
    points = table.series.values.size
    arrays = TableArrays(
        values, table.series.x, table.series.values, np.full(points, table.series.weight),
        table.series.time,
    )  # fmt: skip
    return TableSpec(structure, table.material, free), arrays


def grouped(problem: FitProblem) -> list[list[Member]]:
    """Records that share their structure, their steps, what is observed and their parameters."""
    groups: dict[object, list[Member]] = {}
    for record in problem.records:
        scene = _lasting(record)
        structure = Structure(scene.skeleton(), make_layout(scene), scene)
        plan = plan_of(scene, structure.layout)
        plan = seen_plan(plan)
        owned = tuple(key for key in scene.numbers() if problem.owner(key, record.name) is not None)
        key = (structure, plan, scene.solver, record.watched, owned, _pace(record, scene, plan))
        groups.setdefault(key, []).append(Member(record, scene, structure, plan))
    return list(groups.values())


def _pace(record: Record, scene: Scene, plan: Plan) -> int | None:
    """What records that go through time together have alike: about how many steps between outputs.

    A group's runs all take as many as the one that needs the most. None where every step is one.
    """
    every = spacing_of(record.series[0].x)
    if plan.adaptive or every is None:
        return None
    step = scene.solver.step
    return round(math.log2(every)) if step is None else rounded_steps_of(scene, every, step)


def _lasting(record: Record) -> Scene:
    """A record's scene; one without a duration, which would stay at rest, lasts as long as the data."""
    scene = record.study.runs[0]
    if not scene.output.static:
        return scene
    last = float(record.series[0].x[-1])
    return scene.with_numbers({"output.duration": last, "output.every": last})


def seen_plan(plan: Plan) -> Plan:
    """A scene's plan with what is looked at here alone, and with derivatives."""
    return replace(plan, quantities=SEEN, recoils=(), outputs=1, sloped=True, watch_peaks=False)


def _group(problem: FitProblem, members: list[Member]) -> tuple[GroupSpec, GroupArrays]:
    scenes = [member.scene for member in members]
    starts = [_starts(problem, member) for member in members]
    begun = [s.with_numbers(values) for s, values in zip(scenes, starts, strict=True)]
    # values that the search comes to lie in the same line, plane or space
    led = [one for s, free in zip(begun, starts, strict=True) for one in changed_scenes(s, free)]
    coordinates = common_coordinates(members[0].record.study, [*scenes, *begun], led)
    structure, plan = members[0].structure, members[0].plan
    values = [scene.numbers() for scene in scenes]
    free = []
    for key in values[0]:
        owners = [problem.owner(key, member.record.name) for member in members]
        mine = tuple(index for index in owners if index is not None)
        if mine:
            free.append((key, mine if len(set(mine)) > 1 else mine[:1]))
    differ = {key for key in values[0] if len({v[key] for v in values}) > 1}
    # the grid of a run is its own: what the scene says of outputs is not used
    differ = {key for key in differ if not key.startswith("output.")}
    shared = {key: number(x) for key, x in values[0].items() if key not in differ}
    own = {key: np.array([v[key] for v in values]) for key in sorted(differ)}
    bound = _bounds(members, begun, coordinates)
    grids = _grids(members, bound)
    outputs = [grid.outputs for grid in grids]
    points = max(member.record.series[0].x.size for member in members)
    solver = scenes[0].solver
    courant = courant_of(scenes[0]) if solver.step is None else 1.0
    arrays = GroupArrays(
        shared, own, np.asarray(coordinates.axes), np.asarray(coordinates.origin),
        np.array([member.record.distances for member in members]),
        np.array([grid.every for grid in grids]),
        None if len(set(outputs)) == 1 else np.array(outputs),
        np.stack([_padded(grid.near, points, 0) for grid in grids]),
        np.stack([_padded(grid.weight, points, 0) for grid in grids]),
        np.stack([_padded(grid.less, points, 0) for grid in grids]),
        np.stack([_rows(member.record, points, "values") for member in members]),
        np.stack([_rows(member.record, points, "weight") for member in members]),
        jnp.asarray(1, int), _most(grids, bound, courant), number(courant),
        *map(number, tolerances(solver)),
    )  # fmt: skip
    if solver.step is not None:
        steps = max(rounded_steps_of(scenes[0], grid.every, solver.step) for grid in grids)
        arrays = arrays._replace(steps=jnp.asarray(steps, int))
    watched = members[0].record.watched
    return GroupSpec(structure, plan, watched, max(outputs), tuple(free)), arrays


def rounded_steps_of(scene: Scene, every: float, step: float) -> int:
    """Steps of at most `step` (s) in an output interval (s), as a run would take them."""
    output = scene.output.model_copy(update={"every": every})
    solver = scene.solver.model_copy(update={"step": step})
    one = scene.model_copy(update={"output": output, "solver": solver})
    return int(rounded_steps(one, np.array([step]))[0])


def _starts(problem: FitProblem, member: Member) -> dict[str, float]:
    """The start values of the free numbers of a record's scene, by key."""
    name, found = member.record.name, {}
    for key in member.scene.numbers():
        if (index := problem.owner(key, name)) is not None:
            found[key] = problem.parameters[index].start
    return found


def _bounds(members: list[Member], begun: list[Scene], coordinates) -> list[float]:
    """The longest step (s) of each run at the start values, which the scenes `begun` have."""
    scene, runs = members[0].scene, [one.numbers() for one in begun]
    swept = {key: np.array([values[key] for values in runs]) for key in runs[0]}
    ready = prepare_batch(
        members[0].structure, scene.solver.dtype, coordinates.axes, coordinates.origin, {}, swept
    )
    bound = stable_bound(scene, np.asarray(ready.bound), swept)
    return [float(b) for b in np.where(np.isfinite(bound), bound, np.nan)]


def _most(grids: list[Grid], bounds: list[float], courant: float) -> Int[Array, ""]:
    """The most steps between outputs: `MANY` for each that the start values need."""
    with np.errstate(divide="ignore"):
        needs = np.array([grid.every for grid in grids]) / (courant * np.array(bounds))
    need = np.max(needs, where=np.isfinite(needs), initial=1.0)
    return jnp.asarray(MANY * math.ceil(need), int)


def _grids(members: list[Member], bounds: list[float]) -> list[Grid]:
    grids = []
    for member, bound in zip(members, bounds, strict=True):
        solver = member.scene.solver
        step = solver.step if solver.step is not None else courant_of(member.scene) * bound
        times = member.record.series[0].x
        _refuse_endless(member, float(times[-1]), step)
        grids.append(grid_of(times, step if np.isfinite(step) else times[-1] / 1000.0))
    return grids


def _refuse_endless(member: Member, duration: float, step: float) -> None:
    """SceneError where a run would take more steps than anybody waits for, at the start values."""
    total = duration / step if step else math.inf
    if not member.plan.adaptive and total > MOST_STEPS:
        where = f'experiment "{member.record.name}", at the start values'
        words = f"{where}: {endless_words(member.scene, duration, step)}"
        raise SceneError([Fault(str(member.record.study.path), None, "", words)])


def _padded(rows: np.ndarray, size: int, value: float) -> np.ndarray:
    """Rows added at the end up to a size."""
    room = [(0, size - rows.shape[0]), *[(0, 0)] * (rows.ndim - 1)]
    return np.pad(rows, room, constant_values=value)


def _rows(record: Record, points: int, what: str) -> np.ndarray:
    """(observed, points): values, or weights with zeros where the record has ended."""
    rows = []
    for series in record.series:
        row = series.values if what == "values" else np.full(series.values.size, series.weight)
        rows.append(_padded(row, points, 0))
    return np.array(rows)


def _smooth(problem: FitProblem, one: Smooth) -> tuple[tuple[int, ...], SmoothArrays]:
    """Parameters of a table's tensions in order, its strains, and the weight of a change of slope."""
    mine = [
        (int(p.key.rpartition(".")[2]), k)
        for k, p in enumerate(problem.parameters)
        if p.key.startswith(f"{one.key}.") and p.experiment == one.experiment
    ]
    index = tuple(k for _, k in sorted(mine))
    name = one.key.split(".")[1]
    strain = np.array(problem.study.scene.materials[name].strain, float)  # type: ignore[union-attr]
    start = np.array([problem.parameters[k].start for k in index])
    mean = abs(start[-1] - start[0]) / (strain[-1] - strain[0])
    return index, SmoothArrays(strain, number(1.0 / (one.size * mean)))
