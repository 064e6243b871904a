"""Where the nodes of lines lie unstretched: as the scene tells, or as it is found when a run starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.assemble import segment_lengths
from lumpedcable.model.layout import make_layout
from lumpedcable.results import Coordinate, ResultWriter, Variable
from lumpedcable.scene import Scene
from lumpedcable.solve.observe import Sample
from lumpedcable.study.carried import carried_histories, winch_lines
from lumpedcable.study.laying import Laid

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.compiled import Ready

__all__ = ["Places", "found_lengths", "neighbours"]

PLACES = {
    "unstretched_position": ("node", "unstretched distance from the start of the line"),
    "unstretched_segment": ("segment", "the same, segment middles"),
}
PAID_OUT = ", as paid out when the run starts"
LATER = "at later times these grow with payout, all in its ratio to that of the start"


class Places:
    """Unstretched distances (m) along the lines of a study, as datasets.

    Of most lines they are known before anything runs. Of a line whose length a target or a winch finds,
    the scene's is a first guess: theirs are written when a run starts, (run, node) and (run, segment).

    Attributes:
        targeted: names of the lines whose lengths targets find.
        paid: names of the lines that a winch pays out.
    """

    def __init__(self, laid: Laid) -> None:
        self._laid = laid
        pieces = [piece for structure in laid.structures for piece in structure.layout.pieces]
        self._lines = {name: piece.line for piece in pieces for name in piece.names}
        chosen = {target.line for target in laid.scene.targets.values()}
        paid = set(winch_lines(laid.scene)) - chosen
        self.targeted: list[str] = [n for n, line in self._lines.items() if line in chosen]
        self.paid: list[str] = [n for n, line in self._lines.items() if line in paid]

    @property
    def found(self) -> list[str]:
        """Names of the lines whose lengths are found when a run starts."""
        return [*self.targeted, *self.paid]

    def variables(self) -> list[Variable]:
        """Datasets of lines whose lengths are found."""
        return [
            Variable(
                f"lines/{name}/{quantity}", ("run", place), "f8", "m",
                text + PAID_OUT if name in self.paid else text,
                {"comment": LATER} if name in self.paid else {}, counted=False, places=True,
            )
            for name in self.found
            for quantity, (place, text) in PLACES.items()
        ]  # fmt: skip

    def coordinates(self, runs: NDArray[np.int64]) -> dict[str, Coordinate]:
        """Datasets of the other lines, for some runs: one row for all of the study, or one for each."""
        found = {}
        for name in self._laid.segments:
            if name in self.found:
                continue
            nodes, rows = self._told(name, runs)
            nodes = nodes[rows] if rows.size else nodes[0]
            dims = ("run",) * (nodes.ndim - 1)
            both = zip(PLACES.items(), _both(nodes), strict=True)
            for (quantity, (place, text)), values in both:
                path = f"lines/{name}/{quantity}"
                found[path] = Coordinate(values, "m", text, (*dims, place))
        return found

    def write(
        self,
        writer: ResultWriter,
        runs: NDArray[np.int64],
        rows: NDArray[np.int64],
        lengths: Mapping[str, NDArray[np.float64]] | None = None,
    ) -> None:
        """Write the places along lines whose lengths are found.

        Args:
            writer: the file; `variables` are declared in it.
            runs: numbers of the runs in the study.
            rows: their rows in the file.
            lengths: unstretched lengths (m) of these lines, each (runs,); where one is NaN, and without
                any, the places are those of the scene's first guess.
        """
        for name in self.found:
            nodes, which = self._told(name, runs)
            nodes = (
                nodes[which] if which.size else np.broadcast_to(nodes, (len(runs), nodes.shape[1]))
            )
            if lengths is not None:
                begin = nodes[:, :1]  # of a part that a break cuts off: its place
                whole = np.nanmax(nodes - begin, axis=1)
                ratio = np.where(np.isfinite(lengths[name]), lengths[name], whole) / whole
                nodes = begin + (nodes - begin) * ratio[:, None]  # all segments grow alike
            for quantity, values in zip(PLACES, _both(nodes), strict=True):
                for group in neighbours(rows):
                    here = slice(int(rows[group[0]]), int(rows[group[-1]]) + 1)
                    writer.write(f"lines/{name}/{quantity}", values[group], run=here)

    def _told(
        self, name: str, runs: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """What scenes tell of the nodes' places (m): different rows, and which one each run has.

        None are named where all runs of the study have the same.
        """
        study, laid = self._laid.study, self._laid
        line = self._lines[name]
        lengths = ("length", "payout.", "grading", "segment_lengths.")
        own = tuple(f"lines.{line}.{key}" for key in lengths)
        own += tuple(
            f"events.{k}.place" for k, e in laid.scene.events.items() if e.target()[0] == line
        )
        keys = sorted(key for key in study.runs.moved if key.startswith(own))
        if not keys and len(laid.structures) == 1:
            rows, firsts = np.zeros(0, int), np.zeros(1, int)
        else:
            moved = study.runs.numbers(runs)
            table = np.column_stack([laid.which(runs), *(moved[key] for key in keys)])
            _, firsts, rows = np.unique(table, axis=0, return_index=True, return_inverse=True)
            firsts = runs[firsts]
        nodes = np.full((len(firsts), laid.segments[name] + 1), np.nan)
        for k, run in enumerate(firsts):
            places = node_places(study.runs[int(run)], name)
            if places is not None:
                nodes[k, : places.size] = places
        return nodes, rows.ravel()


def found_lengths(
    places: Places, ready: Ready, sample: Sample, scene: Scene
) -> dict[str, NDArray[np.float64]]:
    """Unstretched lengths (m) of the lines of `places.found`, (runs,); NaN where no rest was found.

    Args:
        places: of the study.
        ready: runs of one structure at rest.
        sample: their state at the start, (runs, 1, ...).
        scene: any with this structure.
    """
    payouts = carried_histories(scene, sample) if places.paid else {}
    found = {name: payouts[f"lines/{name}/payout"][:, 0] for name in places.paid}
    for name in places.targeted:
        line = ready.model.lines[name]
        sizes = np.asarray(line.segment_length)
        count = np.asarray(line.reference_strain).shape[-1]
        found[name] = np.broadcast_to(sizes, (len(sizes), count)).sum(axis=1)
    good = np.asarray(ready.converged)
    return {name: np.where(good, length, np.nan) for name, length in found.items()}


def neighbours(rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Indices of rows of a file in groups that stand side by side: each write costs as much as
    thousands of numbers."""
    return np.split(np.arange(len(rows)), np.flatnonzero(np.diff(rows) != 1) + 1)


def node_places(scene: Scene, name: str) -> NDArray[np.float64] | None:
    """Unstretched distances (m) of the nodes of a line or a part of one from the start of the line.

    None if the scene has no such part.
    """
    layout = make_layout(scene)
    if all(piece.name != name for piece in layout.pieces):
        return None
    piece = next(p for p in layout.pieces if p.name == name)
    lengths = np.broadcast_to(segment_lengths(scene, piece, np), (piece.segments,))
    begin = 0.0
    for other in layout.of_line(piece.line):
        if other.name == name:
            break
        own = np.broadcast_to(segment_lengths(scene, other, np), (other.segments,))
        begin += float(own.sum())
    return begin + np.concatenate([[0.0], np.cumsum(lengths)])


def _both(nodes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places (m) of nodes (..., n + 1) and of the middles between them."""
    return nodes, 0.5 * (nodes[..., 1:] + nodes[..., :-1])
