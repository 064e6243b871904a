"""Running a study: batches of runs through time, every finished piece written as it comes."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.model.numbers import number
from lumpedcable.model.seams import cuts_in
from lumpedcable.results import ResultWriter
from lumpedcable.scene import Study
from lumpedcable.solve.integrate import Numbers, Plan
from lumpedcable.study.account import Account
from lumpedcable.study.compiled import Ready, Structure, begin_batch
from lumpedcable.study.contents import Contents
from lumpedcable.study.endless import mark_endless
from lumpedcable.study.laying import Laid, equal_rows, lay_out
from lumpedcable.study.places import found_lengths
from lumpedcable.study.plan import plan_of, stepping
from lumpedcable.study.rest import write_rest
from lumpedcable.study.shrinking import Batch
from lumpedcable.study.starts import batched, filled, rows_of, starts
from lumpedcable.study.summary import Outcome, Table, empty_table, outcomes_of, summarise
from lumpedcable.timings import Timings

__all__ = ["BLOCK", "Part", "run_runs", "run_study"]

# outputs asked for at first; doubled, up to the plan's, while a call takes less than PACE (s): few calls
# for a short run, and a bar that moves and a file that fills up for a long one
FIRST_OUTPUTS = 16
PACE = 0.25
BLOCK = 1024  # runs whose start states are held at once


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
    laid, runs = lay_out(study), np.arange(len(study.runs))
    tables = run_runs(laid, runs, target, on_progress, timings)
    return [outcome for mine, table in tables for outcome in outcomes_of(table, mine)]


def run_runs(
    laid: Laid,
    runs: ArrayLike,
    target: Path,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    timings: Timings | None = None,
    exact: bool = True,
    overwrite: bool = True,
) -> list[tuple[NDArray[np.int64], Table]]:
    """Run some runs of a study and write one results file of them.

    Args:
        laid: the study laid out.
        runs: numbers of the runs, shape (runs,), rising.
        target, on_progress, timings: as of `run_study`.
        exact: whether the exact wave of each run is worked out too (some 10 ms a run).
        overwrite: whether a file that is there is replaced, or an OutputError.

    Returns:
        The numbers of all runs, block by block: which runs, and their summaries by dataset.

    Raises:
        BusyError: another process writes the file.
        OutputError, KeyboardInterrupt: as of `run_study`.
    """
    timings, runs = timings or Timings(), np.asarray(runs)
    contents = Contents(laid, runs, exact)
    tables = []
    with contents.open(target, overwrite=overwrite) as writer:
        timings.mark("lay out")
        tell = _Teller(len(runs) * laid.count, on_progress)
        tell(0)
        try:
            for first in range(0, len(runs), BLOCK):
                block = runs[first : first + BLOCK]
                table = empty_table(contents, len(block))
                tables.append((block, table))
                try:
                    _run_block(contents, writer, block, first, table, tell, timings)
                finally:
                    contents.write_table(writer, first, table)
                    writer.flush()
                timings.mark("write")
        except KeyboardInterrupt:
            with suppress(Exception):
                writer.keep()
            raise
        writer.finish()
        timings.mark("write")
    return tables


class _Teller:
    """Adds up finished outputs for whoever shows progress; `pace` is how many to ask for at once."""

    def __init__(self, total: int, on_progress: Callable[[int, int], None]):
        self.total, self.done, self.on_progress = total, 0, on_progress
        self.pace: int = FIRST_OUTPUTS

    def took(self, seconds: float, most: int) -> None:
        """Learn from a call how much to ask for next, also of the next part, at most `most`."""
        if seconds < PACE:
            self.pace = max(self.pace, min(2 * self.pace, most))

    def __call__(self, outputs: int) -> None:
        self.done += outputs
        self.on_progress(min(self.done, self.total), self.total)


@dataclass(frozen=True)
class Part:
    """Runs of one structure that go through time together, stepped alike.

    Attributes:
        structure: what they share.
        runs: their numbers in the study, shape (runs,).
        rows: their rows in the block, shape (runs,).
        size: lanes of the batch; those beyond the runs repeat the last one.
        plan: how they are stepped.
        numbers: steps in each output interval, and what else steps are taken with.
    """

    structure: Structure
    runs: NDArray[np.int64]
    rows: NDArray[np.int64]
    size: int
    plan: Plan
    numbers: Numbers

    @property
    def steps(self) -> int:
        """Steps in each output interval."""
        return int(self.numbers.steps)


def _run_block(
    contents: Contents,
    writer: ResultWriter,
    block: NDArray[np.int64],
    first: int,
    table: Table,
    tell: _Teller,
    timings: Timings,
) -> None:
    """All runs of a block, to the file from row `first` on and to the table."""
    laid = contents.laid
    if contents.places:  # for runs of which none is found
        contents.places.write(writer, block, first + np.arange(len(block)))
    right = contents.mark_impossible(block, table)
    tell(int(np.sum(~right)) * laid.count)
    which = laid.which(block)
    for index in np.unique(which):
        rows = np.flatnonzero((which == index) & right)
        left = len(rows)
        for part, ready in _prepared(laid, laid.structures[index], block, rows, table, timings):
            left -= len(part.runs)
            account = Account(part, laid.count, laid.coordinates)
            try:
                _run_part(contents, writer, part, ready, first, account, tell, timings)
            finally:
                summarise(contents, part, ready, account, table)
            timings.mark("sum up")
        tell(left * laid.count)


def _prepared(
    laid: Laid,
    structure: Structure,
    block: NDArray[np.int64],
    rows: NDArray[np.int64],
    table: Table,
    timings: Timings,
) -> Iterator[tuple[Part, Ready]]:
    """Start states of runs of one structure, then the runs by the steps they need.

    Those that need more than anybody waits for are marked in the table instead.
    """
    if len(rows) == 0:
        return
    scene = structure.scene
    ready = starts(laid, structure, block[rows])
    timings.mark("statics")
    swept = laid.study.runs.columns(block[rows])
    stepped = stepping(scene, structure.layout, np.asarray(ready.bound), swept)
    kept = np.flatnonzero(~mark_endless(scene, ready, swept, stepped[:, 0], rows, table))
    cuts = cuts_in(ready.model)
    ways = np.column_stack([stepped, *cuts.values()])
    groups = [kept[some] for some in equal_rows(ways[kept])] if len(kept) else []
    sizes = laid.sizes_for(structure, [int(stepped[g[0], 0]) for g in groups], [*map(len, groups)])
    for alike in groups:
        steps, *tolerances = stepped[alike[0]]
        here = {name: jnp.asarray(before[alike[0]]) for name, before in cuts.items()}
        every, rtol, atol = map(number, (scene.output.every, *tolerances))
        numbers = Numbers(every, jnp.asarray(int(steps)), rtol, atol, here)
        for mine, size in batched(alike, sizes):
            plan = plan_of(scene, structure.layout, size)
            part = Part(structure, block[rows[mine]], rows[mine], size, plan, numbers)
            yield part, rows_of(ready, filled(mine, size))


def _run_part(
    contents: Contents,
    writer: ResultWriter,
    part: Part,
    ready: Ready,
    first_row: int,
    account: Account,
    tell: _Teller,
    timings: Timings,
) -> None:
    """All outputs of the runs of a part: to the file as they come, and to the account."""
    scene, rows, lived = contents.laid.scene, first_row + part.rows, len(part.runs)
    run, sample = begin_batch(ready.packed, part.plan, part.numbers)
    sample = jax.tree.map(lambda x: np.asarray(x)[:lived, None], sample).tree()
    keeps = contents.fields or contents.tips or scene.output.static
    start = account.start_positions(ready) if keeps else {}
    account.add(sample, 0, 1)
    contents.write(writer, rows, sample, start, 0)
    if scene.output.static:
        mine = [contents.study.runs[int(k)] for k in part.runs]
        rest = rows_of(ready, np.arange(lived))
        write_rest(writer, mine, rows, rest, start, sample.ends)
    if contents.places and contents.places.found:
        lengths = found_lengths(contents.places, rows_of(ready, np.arange(lived)), sample, scene)
        contents.places.write(writer, part.runs, rows, lengths)
    timings.mark("begin")
    batch = Batch(part, ready, run)
    done = 0
    while done < account.count:
        now = min(tell.pace, batch.outputs_at_once, account.count - done)
        asked = clock.perf_counter()
        samples: Any = batch.advance(done, now, partial(tell, 0))
        timings.mark("advance")
        took = clock.perf_counter() - asked
        account.add(samples, done + 1, now)
        if contents.histories:
            contents.write(writer, rows, samples, start, done + 1)
            writer.flush()
        timings.mark("write")
        done += now
        tell(now * lived)
        if part.plan.stop is not None and done < account.count:
            left = account.count - done
            if batch.stopped.all():
                # nothing moves any more: what is left repeats the last state
                samples = batch.repeated(done, left)
                account.add(samples, done + 1, left)
                if contents.histories:
                    contents.write(writer, rows, samples, start, done + 1)
                tell(left * lived)
                break
            batch.shrink(took * left / now)
        tell.took(took, batch.outputs_at_once)
    account.finish(batch.ends(), ready)
