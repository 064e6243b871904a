"""Breaks that begin at a tension: found as runs go, and gone back for.

Until a break begins nothing depends on when it does. So the compiled program knows of a start alone,
inf at first, and tells when an end has to carry what it breaks at (`solve.trips`). That is the start
then, and the call in which it was is made again from where it began: the run is that of a scene which
gives the start.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lumpedcable.model.ends import end_name
from lumpedcable.solve.plan import Progress
from lumpedcable.study.ahead import begin_runs
from lumpedcable.study.compiled import Ready
from lumpedcable.study.packed import Packed
from lumpedcable.study.plan import recoil_event
from lumpedcable.study.starts import rows_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.part import Part

__all__ = ["Triggers", "begin_with"]


class Triggers:
    """The breaks of a part's runs that begin at a tension, and when those that have begun did.

    Attributes:
        starts: by event, when it began in each run (s), inf where it has not, shape (runs,).
    """

    def __init__(self, part: Part, ready: Ready):
        scene, layout = part.structure.scene, part.structure.layout
        self.part = part
        self.ends: dict[str, str] = {}  # by event, the end that breaks
        self._starts: dict[str, int] = {}  # and the column of the models' numbers with its start
        for name, node, event in layout.breaks:
            if scene.events[event].tension is not None:
                release = _columns(ready.packed).end(name, node).release
                self.ends[event], self._starts[event] = end_name(name, node), int(release.start)
        self.starts = {event: np.full(len(part.runs), np.inf) for event in self.ends}

    def __bool__(self) -> bool:
        return bool(self.ends)

    def begun(
        self, models: Packed, run: Packed, rows: NDArray[np.int64]
    ) -> dict[str, NDArray[np.float64]]:
        """By event, when it began in each lane (s), NaN where nothing new did; {} where none did at all.

        Of several in one lane the first alone, since it may change what the others carry. `rows` are the
        part's runs in the first lanes; the others repeat them.
        """
        trips = _tree(run).trips
        found = np.array([np.asarray(trips[end].time, float) for end in self.ends.values()])
        known = np.asarray(models.numbers)[:, [*self._starts.values()]].T
        found = np.where(np.isfinite(known), np.nan, found)
        first = np.min(np.where(np.isnan(found), np.inf, found), axis=0)
        found = np.where(found == first, found, np.nan)
        if np.isnan(found).all():
            return {}
        for event, when in zip(self.ends, found, strict=True):
            own = when[: len(rows)]
            self.starts[event][rows] = np.where(np.isnan(own), self.starts[event][rows], own)
        return dict(zip(self.ends, found, strict=True))

    def in_models(self, models: Packed, begun: dict[str, NDArray[np.float64]]) -> Packed:
        """Models whose breaks begin then."""
        return _placed(models, {self._starts[event]: when for event, when in begun.items()})

    def known(self, models: Packed) -> Packed:
        """Models whose breaks begin when they are known to."""
        begun = {}
        for event, starts in self.starts.items():
            lanes = np.pad(starts, (0, len(models.numbers) - len(starts)), mode="edge")
            begun[event] = np.where(np.isfinite(lanes), lanes, np.nan)
        return self.in_models(models, begun) if begun else models

    def in_runs(self, run: Packed, begun: dict[str, NDArray[np.float64]]) -> Packed:
        """Runs whose watches of ends that recoil know it."""
        plan, layout = self.part.plan, self.part.structure.layout
        where: Progress = _columns(run)
        columns = {}
        for recoil, watch in zip(plan.recoils, where.seen, strict=True):
            when = begun.get(recoil_event(layout, recoil))
            if when is not None:
                columns[int(watch.begins)] = when
        return _placed(run, columns)


def begin_with(triggers: Triggers, part: Part, ready: Ready) -> tuple[Ready, Packed, Packed]:
    """The models of a part's runs, their states and samples at the start.

    What carries as much at rest as it breaks at begins to break at once.
    """
    run, sample = begin_runs(ready.packed, part.plan, part.numbers)
    while triggers and (begun := triggers.begun(ready.packed, run, np.arange(len(part.runs)))):
        ready = ready._replace(packed=triggers.in_models(ready.packed, begun))
        run, sample = begin_runs(ready.packed, part.plan, part.numbers)
    return ready, run, sample


def _tree(packed: Packed) -> Any:
    return Packed(np.asarray(packed.numbers), packed.form).tree()


def _columns(packed: Packed) -> Any:
    """The tree with the numbers of the columns that its numbers have in each row."""
    columns = Packed(np.arange(float(packed.numbers.shape[-1]))[None], packed.form)
    return rows_of(columns.tree(), np.array(0))


def _placed(packed: Packed, columns: dict[int, NDArray[np.float64]]) -> Packed:
    """The same with new numbers in some columns, where they are no NaN."""
    numbers = np.array(packed.numbers)
    for column, values in columns.items():
        numbers[:, column] = np.where(np.isnan(values), numbers[:, column], values)
    return Packed(numbers, packed.form)
