"""Running a study: batches of runs through time, every finished piece written as it comes."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping
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
from lumpedcable.scene import Scene, Study
from lumpedcable.solve.plan import Numbers
from lumpedcable.study.account import Account
from lumpedcable.study.ahead import foresee
from lumpedcable.study.batches import kind, lanes
from lumpedcable.study.bookmark import Bookmark
from lumpedcable.study.compiled import Ready, Structure
from lumpedcable.study.contents import Contents
from lumpedcable.study.endless import mark_endless
from lumpedcable.study.laying import Laid, equal_rows, lay_out
from lumpedcable.study.outcome import Outcome, Table, outcomes_of
from lumpedcable.study.packed import Form, Packed
from lumpedcable.study.part import Part
from lumpedcable.study.places import found_lengths
from lumpedcable.study.plan import plan_of, stable_bound, stepping, tolerances
from lumpedcable.study.rest import write_rest
from lumpedcable.study.shrinking import Batch, looks_at, until_look
from lumpedcable.study.starts import batched, filled, rows_of, starts
from lumpedcable.study.summary import empty_table, summarise
from lumpedcable.study.triggers import Triggers, begin_with
from lumpedcable.timings import Timings

__all__ = ["run_runs", "run_study"]

# outputs asked for at once are doubled, up to the plan's, while a call takes less than that (s): few
# calls for a short run, and a bar that moves and a file that fills up for a long one
PACE = 0.25
FEW = 16  # runs that most likely go together: their programs are compiled before that is known


def run_study(
    study: Study,
    target: Path,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    timings: Timings | None = None,
    on_resume: Callable[[], None] = lambda: None,
) -> list[Outcome]:
    """Run every scene of a study and write one results file.

    Args:
        study: validated scene file with its sweep.
        target: where the HDF5 file goes; it has its name only when it is complete.
        on_progress: called with the number of finished and of all output times of all runs.
        timings: filled with the wall time of each stage.
        on_resume: called first of all where this goes on with what an interrupted call has left in
            NAME.partial: of the same scene, by the same program on the same machine.

    Returns:
        The outcome of each run, in order: status, summaries, energy closure.

    Raises:
        SceneError: the scene cannot be laid out (too few segments for its breaks, too few
            dimensions).
        OutputError: the file cannot be written.
        KeyboardInterrupt: interrupted; what was finished is in the file named .partial, and where it
            took more than some seconds, how far it has come is noted beside it.
    """
    laid, runs = lay_out(study), np.arange(len(study.runs))
    tables = run_runs(laid, runs, target, on_progress, timings, on_resume=on_resume)
    return [outcome for mine, table in tables for outcome in outcomes_of(table, mine)]


def run_runs(
    laid: Laid,
    runs: ArrayLike,
    target: Path,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    timings: Timings | None = None,
    exact: bool = True,
    overwrite: bool = True,
    on_resume: Callable[[], None] | None = None,
    folders: bool = True,
) -> list[tuple[NDArray[np.int64], Table]]:
    """Run some runs of a study and write one results file of them.

    Args:
        laid: the study laid out.
        runs: numbers of the runs, shape (runs,), rising.
        target, on_progress, timings: as of `run_study`.
        exact: whether the exact wave of each run is worked out too (some 10 ms a run).
        overwrite: whether a file that is there is replaced, or an OutputError.
        on_resume: as of `run_study`; None: nothing is noted, and gone on with.
        folders: whether missing folders above the file are made, or an OutputError.

    Returns:
        The numbers of all runs, block by block: which runs, and their summaries by dataset.

    Raises:
        BusyError: another process writes the file.
        OutputError, KeyboardInterrupt: as of `run_study`.
    """
    timings, runs = timings or Timings(), np.asarray(runs)
    contents = Contents(laid, runs, exact)
    mark = Bookmark(contents, target, on_resume is not None)
    tables = []
    opened = contents.open(target, overwrite=overwrite, goes_on=mark.goes_on, folders=folders)
    with opened as writer:
        if mark.goes_on and on_resume:
            on_resume()
        else:
            mark.remove()  # what it says is of a file that is gone
        timings.mark("lay out")
        tell = _Teller(len(runs) * laid.count, on_progress)
        outlet = _Outlet(contents, writer, tell, timings, mark)
        tell(0)
        try:
            for first in range(0, len(runs), kind().block):
                some = runs[first : first + kind().block]
                table = mark.table(empty_table(contents, len(some)))
                tables.append((some, table))
                if mark.passed:
                    tell.found(len(some) * laid.count)
                    continue
                try:
                    _run_block(outlet, _Block(some, first, table))
                finally:
                    contents.write_table(writer, first, table)
                    writer.flush()
                timings.mark("write")
        except KeyboardInterrupt:
            with suppress(Exception):
                writer.keep()
            raise
        writer.finish()
        mark.remove()
        timings.mark("write")
    return tables


class _Teller:
    """Adds up finished outputs for whoever shows progress; `pace` is how many to ask for at once."""

    def __init__(self, total: int, on_progress: Callable[[int, int], None]):
        self.total, self.done, self.on_progress = total, 0, on_progress
        self.pace: int = kind().first

    def took(self, seconds: float, most: int) -> None:
        """Learn from a call how much to ask for next, also of the next part, at most `most`."""
        if seconds < PACE:
            self.pace = max(self.pace, min(2 * self.pace, most))

    def found(self, outputs: int) -> None:
        """Outputs that an earlier process has finished: told with the next of this one, since compiling
        comes before those, and nobody could tell from it how long the rest will take."""
        self.done += outputs

    def __call__(self, outputs: int) -> None:
        self.done += outputs
        self.on_progress(min(self.done, self.total), self.total)


@dataclass(frozen=True)
class _Outlet:
    """Where the outputs of runs go: what a file holds of them, the file, who is told, the times, and
    where it is noted how far they have come."""

    contents: Contents
    writer: ResultWriter
    tell: _Teller
    timings: Timings
    mark: Bookmark


@dataclass(frozen=True)
class _Block:
    """Runs whose start states are held at once: their numbers in the study (runs,), their first row
    in the file, and their summaries."""

    runs: NDArray[np.int64]
    first: int
    table: Table


def _run_block(outlet: _Outlet, block: _Block) -> None:
    """All runs of a block, to the file and to the table."""
    contents, tell = outlet.contents, outlet.tell
    laid = contents.laid
    if contents.places:  # for runs of which none is found
        rows = block.first + np.arange(len(block.runs))
        contents.places.write(outlet.writer, block.runs, rows)
    right = contents.mark_impossible(block.runs, block.table)
    tell(int(np.sum(~right)) * laid.count)
    which = laid.which(block.runs)
    for index in np.unique(which):
        rows = np.flatnonzero((which == index) & right)
        left = len(rows)
        for part, ready in _prepared(outlet, block, laid.structures[index], rows):
            left -= len(part.runs)
            if outlet.mark.passes():
                tell.found(len(part.runs) * laid.count)
                continue
            account = Account(part, laid.count, laid.coordinates)
            try:
                _run_part(outlet, part, ready, block.first + part.rows, account)
            finally:
                summarise(contents, part, ready, account, block.table)
            outlet.mark.ended()
            outlet.timings.mark("sum up")
        tell(left * laid.count)


def _prepared(
    outlet: _Outlet, block: _Block, structure: Structure, rows: NDArray[np.int64]
) -> Iterator[tuple[Part, Ready]]:
    """Start states of the runs in some rows, of one structure, then the runs by the steps they need.

    Those that need more than anybody waits for are marked in the table instead.
    """
    if len(rows) == 0:
        return
    laid, scene = outlet.contents.laid, structure.scene

    def expect(form: Form) -> None:
        if len(rows) <= FEW and not scene.output.static:
            _foresee(laid, structure, len(rows), form)

    ready = starts(laid, structure, block.runs[rows], expect)
    outlet.timings.mark("statics")
    swept = laid.study.runs.columns(block.runs[rows])
    ready = ready._replace(bound=stable_bound(scene, np.asarray(ready.bound), swept))
    stepped = stepping(scene, structure.layout, np.asarray(ready.bound), swept)
    endless = mark_endless(scene, ready, swept, stepped[:, 0], rows, block.table)
    kept = np.flatnonzero(~endless)
    cuts = cuts_in(ready.model)
    ways = np.column_stack([stepped, *cuts.values()])
    groups = [kept[some] for some in equal_rows(ways[kept])] if len(kept) else []
    sizes = laid.sizes_for(structure, [int(stepped[g[0], 0]) for g in groups], [*map(len, groups)])
    for alike in groups:
        steps, *errors = stepped[alike[0]]
        here = {name: before[alike[0]] for name, before in cuts.items()}
        numbers = _numbers(scene, int(steps), errors, here)
        for mine, size in batched(alike, sizes):
            plan = plan_of(scene, structure.layout, size)
            part = Part(structure, block.runs[rows[mine]], rows[mine], size, plan, numbers)
            yield part, rows_of(ready, filled(mine, size))


def _numbers(scene: Scene, steps: int, errors: Iterable[float], cuts: Mapping[str, Any]) -> Numbers:
    """Those of a plan of so many steps in an output interval, `errors` tolerated, by line its `cuts`."""
    every, rtol, atol = map(number, (scene.output.every, *errors))
    return Numbers(
        every, jnp.asarray(steps), rtol, atol, {k: jnp.asarray(n) for k, n in cuts.items()}
    )


def _foresee(laid: Laid, structure: Structure, runs: int, form: Form) -> None:
    """Have the programs of so many runs compiled, of models of a form, which most likely go together."""
    scene, layout = structure.scene, structure.layout
    size = lanes(runs, laid.sizes_for(structure, [1], [runs]))[0]
    models = Packed(jax.ShapeDtypeStruct((size, form.size), np.dtype(float)), form)
    cuts = {piece.name: np.int64(0) for piece in layout.pieces if piece.seam is not None}
    numbers = _numbers(scene, 1, tolerances(scene.solver), cuts)
    foresee(models, plan_of(scene, layout, size), numbers)


def _run_part(
    outlet: _Outlet, part: Part, ready: Ready, rows: NDArray[np.int64], account: Account
) -> None:
    """All outputs of the runs of a part: to their rows of the file as they come, and to the account."""
    contents, tell, timings = outlet.contents, outlet.tell, outlet.timings
    lived, stops = len(part.runs), part.plan.stop is not None
    triggers = Triggers(part, ready)
    account.starts = triggers.starts
    ready, run, start = _write_start(outlet, part, ready, rows, account, triggers)
    batch = Batch(part, ready, run, triggers)

    def keep(samples: Any, done: int, count: int) -> None:
        """`count` outputs after number `done`."""
        account.add(samples, done + 1, count)
        if contents.histories:
            contents.write(outlet.writer, rows, samples, start, done + 1)
            outlet.writer.flush()
        tell(count * lived)

    done = outlet.mark.resume(account, batch, triggers)
    tell.found(done * lived)
    while done < account.count:
        now = min(tell.pace, batch.outputs_at_once, account.count - done)
        if stops:
            now = min(now, until_look(done, account.count))
        asked = clock.perf_counter()
        samples = batch.advance(done, now, partial(tell, 0))
        timings.mark("advance")
        took = clock.perf_counter() - asked
        keep(samples, done, now)
        timings.mark("write")
        done += now
        left = account.count - done
        if stops and left:
            if batch.stopped.all():
                # nothing moves any more: what is left repeats the last state
                keep(batch.repeated(done, left), done, left)
                break
            if looks_at(done, account.count):
                batch.shrink(left)
        outlet.mark.note(done, account, batch)  # what goes on from here has looked at the lanes
        tell.took(took, batch.outputs_at_once)
    account.finish(batch.ends(), ready)


def _write_start(
    outlet: _Outlet, part: Part, ready: Ready, rows: NDArray[np.int64], account: Account,
    triggers: Triggers,
) -> tuple[Ready, Packed, dict[str, NDArray[np.float64]]]:  # fmt: skip
    """The start of a part's runs, to the file and to the account.

    Returns:
        The model and the state of each lane, and where the lines are (m), where outputs to come are
        asked for that.
    """
    contents, writer, laid = outlet.contents, outlet.writer, outlet.contents.laid
    scene, lived = laid.scene, len(part.runs)
    ready, run, sample = begin_with(triggers, part, ready)
    sample = jax.tree.map(lambda x: np.asarray(x)[:lived, None], sample).tree()
    keeps = contents.fields or contents.tips or scene.output.static
    start = account.start_positions(ready) if keeps else {}
    account.add(sample, 0, 1)
    contents.write(writer, rows, sample, start, 0)
    if scene.output.static:
        mine = [contents.study.runs[int(k)] for k in part.runs]
        rest = rows_of(ready, np.arange(lived))
        write_rest(writer, mine, rows, laid.coordinates, rest, start, sample.ends)
    if contents.places and contents.places.found:
        lengths = found_lengths(contents.places, rows_of(ready, np.arange(lived)), sample, scene)
        contents.places.write(writer, part.runs, rows, lengths)
    outlet.timings.mark("begin")
    return ready, run, start
