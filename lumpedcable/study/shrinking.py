"""A batch whose runs end one by one: the lanes of those that have stopped are given up."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from lumpedcable.solve.keeping import fields_done
from lumpedcable.solve.observe import Sample
from lumpedcable.solve.plan import Progress
from lumpedcable.study.ahead import advance_runs
from lumpedcable.study.batches import COMPILING, step_time, steps_at_once
from lumpedcable.study.compiled import Ready
from lumpedcable.study.devices import at_hand
from lumpedcable.study.packed import Packed, unpacked
from lumpedcable.study.plan import plan_of
from lumpedcable.study.starts import filled, rows_of
from lumpedcable.study.triggers import Triggers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.part import Part

__all__ = ["Batch", "looks_at", "until_look"]

FEWEST = 4  # lanes below which there is nothing to save
LOOKS = 16  # times in a run at which lanes may be given up, at outputs that no clock decides on


class Batch:
    """The runs of a part on their way through time, in as many lanes as still move.

    A run that has stopped repeats its last state. It keeps its lane while a batch of half the lanes
    would not hold the others, or would have too little left to do to pay for its program.
    """

    def __init__(self, part: Part, ready: Ready, run: Packed, triggers: Triggers):
        self.part, self.run, self.triggers = part, run, triggers
        self.ready = _at_hand(ready)
        self.plan, self.size = part.plan, part.size
        self.rows = np.arange(len(part.runs))  # of the part's runs, those that have a lane
        self._last: Any = None
        self._ends: Any = None
        self._noted_last: list[Any] = []  # arrays of the same, in whose place it comes

    def advance(self, done: int, count: int, between: Callable[[], None]) -> Sample:
        """Samples (runs, count, ...) of all runs, of the outputs after number `done`; their fields alone
        (runs, `fields_done`, ...).

        Nobody can interrupt a call, so that an interval of many steps is gone through in several;
        `between` is called after each.
        """
        found = self._called(done, count, between)
        lived, after = len(self.rows), self.plan.fields_after
        found = jax.tree.map(lambda x: np.asarray(x)[:lived], found)
        reached = 1 + fields_done(done, count - 1, after)  # with those of the last output
        found = _first(unpacked(found), count, reached)
        if self._noted_last:
            self._last = jax.tree.unflatten(jax.tree.structure(found), self._noted_last)
            self._noted_last = []
        if lived < len(self.part.runs):
            found = jax.tree.map(self._among_all, self._last, found)
        self._last = jax.tree.map(lambda x: x[:, -1:], found)
        return _first(found, count, fields_done(done, count, after))

    def _called(self, done: int, count: int, between: Callable[[], None]) -> Any:
        """What `advance_runs` tells, made again for breaks that were found to begin meanwhile."""
        # a call writes over the state that it is given
        before = Packed(np.array(self.run.numbers), self.run.form) if self.triggers else None
        found = self._advanced(done, count, between)
        while before is not None:
            begun = self.triggers.begun(self.ready.packed, self.run, self.rows)
            if not begun:
                break
            models = self.triggers.in_models(self.ready.packed, begun)
            self.ready = _at_hand(self.ready._replace(packed=models))
            before = self.triggers.in_runs(before, begun)
            self.run = before
            found = self._advanced(done, count, between)
        return found

    def _advanced(self, done: int, count: int, between: Callable[[], None]) -> Any:
        """`count` outputs after number `done`, once; the state goes on."""
        steps, most = self.part.steps, self.steps_at_once
        cuts = [*range(0, steps, most), steps]
        found: Any = None
        for pair in itertools.pairwise(cuts):
            ends = None if pair == (0, steps) else tuple(map(np.asarray, pair))
            self.run, found = advance_runs(
                self.ready.packed, self.plan, self.part.numbers, self.run,
                np.asarray(done), np.asarray(count), ends,
            )  # fmt: skip
            between()
        return found

    def noted(self) -> dict[str, NDArray[Any]]:
        """What another process needs to go on from here, besides what it begins with."""
        found = {"run": np.asarray(self.run.numbers), "rows": self.rows}
        if self._ends is not None:
            found |= _numbered("last", self._last) | _numbered("ends", self._ends)
        return found

    def resume(self, found: Mapping[str, NDArray[Any]]) -> None:
        """Go on from where another process was, which has `noted` it."""
        ready = self.ready._replace(packed=self.triggers.known(self.ready.packed))
        self.rows, self.size = found["rows"], len(found["run"])
        if self.size < self.part.size:
            ends = jax.tree.structure(self.run.tree())
            self._ends = jax.tree.unflatten(ends, _in_order("ends", found))
            self._noted_last = _in_order("last", found)
            ready = rows_of(ready, filled(self.rows, self.size))
            self.plan = plan_of(self.part.structure.scene, self.part.structure.layout, self.size)
        self.ready = _at_hand(ready)
        self.run = Packed(found["run"], self.run.form)

    @property
    def steps_at_once(self) -> int:
        """The most steps in a call."""
        return steps_at_once(self.part.structure.layout, self.size)

    @property
    def outputs_at_once(self) -> int:
        """The most outputs in a call."""
        return max(1, min(self.plan.outputs, self.steps_at_once // self.part.steps))

    def _among_all(self, last: np.ndarray, found: np.ndarray) -> np.ndarray:
        whole = np.repeat(last, found.shape[1], axis=1)
        whole[self.rows] = found
        return whole

    @property
    def stopped(self) -> np.ndarray:
        """Which of all runs have stopped."""
        return self._last.stopped[:, 0]

    def repeated(self, done: int, count: int) -> Sample:
        """The last samples of all runs, for the `count` outputs after number `done`."""
        fields = fields_done(done, count, self.plan.fields_after)

        def again(tree: Any, times: int) -> Any:
            return jax.tree.map(lambda x: np.repeat(x, times, axis=1), tree)

        return again(self._last, count)._replace(fields=again(self._last.fields, fields))

    def shrink(self, left: int) -> None:
        """Go on without the runs that have stopped, if that pays; `left` outputs are to come.

        By what these take roughly, not by what the last ones have taken: fewer lanes round otherwise,
        and results may not depend on how busy a machine was.
        """
        layout = self.part.structure.layout
        seconds = step_time(layout) * self.size * self.part.steps * left
        moving = np.flatnonzero(~self.stopped[self.rows])
        size = self.size
        while size >= 2 * FEWEST and len(moving) <= size // 2:
            size //= 2
        if size == self.size or seconds * (1.0 - size / self.size) < COMPILING:
            return
        self._ends = self.ends()
        kept = filled(moving, size)
        self.ready = _at_hand(rows_of(self.ready, kept))
        self.run = jax.tree.map(np.array, rows_of(self.run, kept))  # calls write over it
        self.plan = plan_of(self.part.structure.scene, self.part.structure.layout, size)
        self.rows, self.size = self.rows[moving], size

    def ends(self) -> Progress:
        """Where all runs are (runs, ...): those that have stopped, where they did."""
        now = rows_of(self.run, np.arange(len(self.rows))).tree()
        if self._ends is None:
            return now
        whole = jax.tree.map(np.array, self._ends)
        for all_, mine in zip(jax.tree.leaves(whole), jax.tree.leaves(now), strict=True):
            all_[self.rows] = mine
        return whole


def until_look(done: int, count: int) -> int:
    """Outputs from number `done` of `count` to the next after which lanes may be given up."""
    every = -(-count // LOOKS)
    return every - done % every


def looks_at(done: int, count: int) -> bool:
    """Whether lanes may be given up after output number `done` of `count`."""
    return done % -(-count // LOOKS) == 0


def _numbered(name: str, tree: Any) -> dict[str, NDArray[Any]]:
    """The arrays of a tree, in their order."""
    return {f"{name}/{k}": np.asarray(leaf) for k, leaf in enumerate(jax.tree.leaves(tree))}


def _in_order(name: str, found: Mapping[str, NDArray[Any]]) -> list[NDArray[Any]]:
    """Those arrays again."""
    return [found[f"{name}/{k}"] for k in range(sum(key.startswith(f"{name}/") for key in found))]


def _at_hand(ready: Ready) -> Ready:
    """The models where their steps are taken, call after call."""
    return ready._replace(packed=at_hand(ready.packed))


def _first(samples: Sample, count: int, fields: int) -> Sample:
    """The first `count` samples (runs, ...) of each run, and the first `fields` of its fields."""
    cut = jax.tree.map(lambda x: x[:, :count], samples._replace(fields={}))
    return cut._replace(fields=jax.tree.map(lambda x: x[:, :fields], samples.fields))
