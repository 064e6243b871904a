"""Running a study: batches of runs through time, every finished piece written as it comes."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.results import ResultWriter
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.scene.errors import Fault
from lumpedcable.solve.integrate import Numbers, Plan
from lumpedcable.study.compiled import (
    Ready,
    advance_batch,
    begin_batch,
    number,
    prepare_batch,
)
from lumpedcable.study.contents import Contents
from lumpedcable.study.plan import (
    DEFAULT_ATOL,
    DEFAULT_RTOL,
    Batch,
    batches,
    common_coordinates,
    output_count,
    plan_of,
    rounded_steps,
)
from lumpedcable.study.rest import write_rest
from lumpedcable.study.summary import Account, Outcome, summarise

__all__ = ["Timings", "run_study"]

# outputs asked for at first; doubled, up to the plan's, while a call takes less than PACE (s): few calls
# for a short run, and a bar that moves and a file that fills up for a long one
FIRST_OUTPUTS = 16
PACE = 0.25


@dataclass
class Timings:
    """Wall time of each stage (s)."""

    stages: dict[str, float] = field(default_factory=dict)
    _mark: float = field(default_factory=clock.perf_counter)

    def mark(self, stage: str) -> None:
        """Book the time since the last mark under `stage`."""
        now = clock.perf_counter()
        self.stages[stage] = self.stages.get(stage, 0.0) + now - self._mark
        self._mark = now


def run_study(
    study: Study,
    target: Path,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    timings: Timings | None = None,
) -> list[Outcome]:
    """Run every scene of a study and write one results file.

    Args:
        study: validated scene file with its sweep.
        target: where the HDF5 file goes; it has its name only when it is complete.
        on_progress: called with the number of finished and of all output times of all runs.
        timings: filled with the wall time of each stage.

    Returns:
        The outcome of each run, in order: status, summaries, energy closure.

    Raises:
        SceneError: the scene cannot be laid out (too few segments for its breaks, too few
            dimensions).
        OutputError: the file cannot be written.
        KeyboardInterrupt: interrupted; what was finished is in the file named .partial.
    """
    timings = timings or Timings()
    scenes = list(study.runs)
    try:
        groups = batches(scenes)
    except ValueError as error:
        raise SceneError([Fault(str(study.path), 1, "lines", str(error))]) from None
    coordinates = common_coordinates(study, scenes)
    count = output_count(scenes[0])
    contents = Contents(study, scenes, groups, coordinates, count)
    outcomes: list[Outcome | None] = [None] * len(scenes)
    with contents.open(target) as writer:
        timings.mark("lay out")
        total, done = len(scenes) * count, 0

        def tick(outputs: int) -> None:
            nonlocal done
            done += outputs
            on_progress(min(done, total), total)

        on_progress(0, total)
        try:
            for batch in groups:
                for part, ready, steps in _prepared(study, batch, scenes, coordinates, timings):
                    account = Account(part, count, coordinates)
                    try:
                        _run_batch(scenes, part, ready, steps, contents, writer, account, tick,
                                   timings)  # fmt: skip
                    finally:
                        for run, outcome in summarise(study, scenes, part, ready, account).items():
                            outcomes[run] = outcome
                            contents.write_outcome(writer, run, outcome)
                        writer.flush()
                    timings.mark("write")
        except KeyboardInterrupt:
            with suppress(Exception):
                writer.keep()
            raise
        writer.finish(solver_steps=[int(o.steps) for o in outcomes if o is not None])
        timings.mark("write")
    return [o for o in outcomes if o is not None]


@dataclass(frozen=True)
class Part:
    """Runs of a batch that take the same number of steps, and so can go through time together."""

    batch: Batch
    runs: tuple[int, ...]
    plan: Plan
    steps: int


def _prepared(
    study: Study,
    batch: Batch,
    scenes: list[Scene],
    coordinates: Coordinates,
    timings: Timings,
):
    """Statics of a batch, then its runs sorted by the number of steps that they need."""
    scene = scenes[batch.runs[0]]
    swept_keys = {axis.key for axis in study.axes} | {"output.duration"}
    shared, swept = {}, {}
    for key, value in scene.numbers().items():
        if key in swept_keys:
            swept[key] = np.array([scenes[run].numbers()[key] for run in batch.runs])
        else:
            shared[key] = number(value)
    ready = prepare_batch(
        batch.structure, scene.solver.dtype, coordinates.axes, coordinates.origin, shared, swept
    )
    jax.block_until_ready(ready.bound)
    timings.mark("statics")
    plan = plan_of(scene, batch.structure.layout, len(batch.runs))
    steps = rounded_steps(scene, np.asarray(ready.bound))
    if plan.adaptive:
        steps = np.ones_like(steps)
    for each in sorted(set(steps.tolist())):
        chosen = np.flatnonzero(steps == each)
        runs = tuple(batch.runs[i] for i in chosen)
        mine = ready if len(chosen) == len(batch.runs) else _pick(ready, chosen)
        yield Part(batch, runs, plan, int(each)), mine, int(each)


def _pick(ready: Ready, chosen: np.ndarray) -> Ready:
    return jax.tree.map(lambda x: x[chosen], ready)


def _run_batch(
    scenes: list[Scene],
    part: Part,
    ready: Ready,
    steps: int,
    contents: Contents,
    writer: ResultWriter,
    account: Account,
    tick: Callable[[int], None],
    timings: Timings,
) -> None:
    """All outputs of the runs of a part: to the file as they come, and to the account."""
    scene = scenes[part.runs[0]]
    numbers = Numbers(
        number(scene.output.every),
        jnp.asarray(steps),
        number(scene.solver.rtol or DEFAULT_RTOL),
        number(scene.solver.atol or DEFAULT_ATOL),
    )
    run, first = begin_batch(ready.model, part.plan, numbers)
    first = jax.tree.map(lambda x: np.asarray(x)[:, None], first)
    account.add(first, 0, 1)
    contents.write(writer, part.runs, first, account.start_positions(ready), 0)
    if scene.output.static:
        ends = {name: np.asarray(values)[:, 0] for name, values in first.ends.items()}
        write_rest(writer, scenes, part.runs, ready, account.start_positions(ready), ends)
    timings.mark("begin")
    done, pace = 0, min(FIRST_OUTPUTS, part.plan.outputs)
    while done < account.count:
        now, asked = min(pace, account.count - done), clock.perf_counter()
        run, samples = advance_batch(
            ready.model, part.plan, numbers, run, np.asarray(done), np.asarray(now)
        )
        samples: Any = jax.tree.map(lambda x, n=now: np.asarray(x)[:, :n], samples)
        timings.mark("advance")
        account.add(samples, done + 1, now)
        contents.write(writer, part.runs, samples, account.start_positions(ready), done + 1)
        writer.flush()
        timings.mark("write")
        done += now
        tick(now * len(part.runs))
        if clock.perf_counter() - asked < PACE:
            pace = min(2 * pace, part.plan.outputs)
    account.finish(run)
