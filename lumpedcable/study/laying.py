"""A study laid out: which runs share a compiled program, and what they all have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.cuts import cut_keys, cuts_of, layouts_of
from lumpedcable.scene import Scene, SceneError, Study
from lumpedcable.study.batches import batch_sizes, lane_time, nodes_of, sizes_for
from lumpedcable.study.compiled import Structure
from lumpedcable.study.plan import common_coordinates, structure_of

__all__ = ["Laid", "equal_rows", "lay_out"]

MOST_SCENES = 1000  # looked at for the coordinates that all runs lie in
# numbers that place nothing: however many values they take, the coordinates are the same
PLACELESS = ("materials.", "events.", "solver.", "statics.", "targets.")
PLACELESS_ENDS = (".mass", ".diameter", ".pretension", ".segments", ".density", ".EI")
PLACELESS_PARTS = (".drag.", ".added_mass.")


@dataclass(frozen=True)
class Laid:
    """A study and what its runs share.

    Attributes:
        study: the scene file with its sweep.
        structures: the different structures, in order of the first run that has each.
        coordinates: those of all runs.
        count: number of outputs after the start.
        segments: the most that each line, or part of a line, has in any run.
    """

    study: Study
    structures: tuple[Structure, ...]
    coordinates: Coordinates
    count: int
    segments: Mapping[str, int]

    @property
    def scene(self) -> Scene:
        """The first run's scene; what all runs share stands in it."""
        return self.structures[0].scene

    @cached_property
    def _order(self) -> dict[Structure, int]:
        return {structure: index for index, structure in enumerate(self.structures)}

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Sizes of the batches that runs go through time in."""
        nodes = max(nodes_of(structure.layout) for structure in self.structures)
        return batch_sizes(len(self.study.runs), nodes)

    def sizes_for(
        self, structure: Structure, steps: Sequence[int], counts: Sequence[int]
    ) -> tuple[int, ...]:
        """Sizes of the batches of runs of a structure, `counts` of them with so many `steps` each."""
        scene, layout = structure.scene, structure.layout
        groups = [(n, lane_time(scene, layout, k)) for k, n in zip(steps, counts, strict=True)]
        return sizes_for(groups, self.sizes, len(self.study.runs) / len(self.structures))

    def which(self, runs: ArrayLike) -> NDArray[np.int64]:
        """The structure of each of some runs, as its index, shape (runs,)."""
        runs = np.asarray(runs)
        if len(self.structures) == 1:
            return np.zeros(len(runs), int)
        found = np.empty(len(runs), int)
        for first, rows in _alike(self.study, runs):
            found[rows] = self._order[structure_of(self.study.runs[first])]
        return found


def lay_out(study: Study) -> Laid:
    """Lay out a study, whatever the number of its runs.

    Raises:
        SceneError: the scene cannot be laid out (too few segments for its breaks, too few
            dimensions).
    """
    structures: dict[Structure, None] = {}
    segments: dict[str, int] = {}
    deciding = _deciding_runs(study)
    try:
        for first, rows in _alike(study, deciding):
            structure = structure_of(study.runs[first])
            structures.setdefault(structure)
            for name, most in _segments(study, structure, deciding[rows]):
                segments[name] = max(most, segments.get(name, 0))
    except ValueError as error:
        raise SceneError([study.fault("lines", str(error))]) from None
    coordinates = common_coordinates(study, _placing_scenes(study))
    found = tuple(structures)
    return Laid(study, found, coordinates, found[0].scene.output.count, segments)


def _segments(study: Study, structure: Structure, runs: NDArray[np.int64]):
    """Yield the most segments that lines, and parts of lines, have in runs of a structure."""
    for piece in structure.layout.pieces:
        if piece.seam is None:
            yield piece.name, piece.segments
            continue
        scene = structure.scene
        moved = study.runs.numbers(runs) if cut_keys(scene) & study.runs.moved else {}
        along = [name for name, event in scene.events.items() if event.target()[1] is None]
        cuts = cuts_of(scene, moved, len(runs))[:, along.index(piece.seam)]
        first, last = piece.names
        yield first, int(cuts.max())
        yield last, piece.segments - int(cuts.min())


def _alike(study: Study, runs: NDArray[np.int64]):
    """Yield, for each structure among some runs, the first run that has it and all their rows."""
    counts = sorted(study.runs.counts)
    columns = study.runs.columns(runs)
    whole = np.array([columns[key] for key in counts], float).reshape(len(counts), len(runs)).T
    found = []
    for group in equal_rows(whole):
        scene = study.runs[int(runs[group[0]])]
        moved = study.runs.numbers(runs[group]) if cut_keys(scene) & study.runs.moved else {}
        layouts = layouts_of(scene, moved, len(group))
        found += [group[rows] for rows in equal_rows(layouts)]
    for rows in sorted(found, key=lambda rows: rows[0]):
        yield int(runs[rows[0]]), rows


def equal_rows(table: NDArray) -> list[NDArray[np.int64]]:
    """Rows grouped by equal content, as their indices in rising order."""
    if table.shape[1] == 0:
        return [np.arange(len(table))]
    _, inverse = np.unique(table, axis=0, return_inverse=True)
    order = np.argsort(inverse.ravel(), kind="stable")
    ends = np.flatnonzero(np.diff(inverse.ravel()[order])) + 1
    return np.split(order, ends)


def _deciding_runs(study: Study) -> NDArray[np.int64]:
    """Runs that show every structure: all rows of what decides it, the first of all else."""
    runs = study.runs
    deciding = runs.counts | cut_keys(study.scene)
    return _product(study, [any(a.key in deciding for a in f.axes) for f in runs.factors])


def _product(study: Study, chosen: list[bool]) -> NDArray[np.int64]:
    """Runs with every row of the chosen factors and the first of the others."""
    if not study.factors:
        return np.zeros(1, int)
    rows = [
        np.arange(len(f)) if mine else np.zeros(1, int)
        for f, mine in zip(study.factors, chosen, strict=True)
    ]
    grid = np.meshgrid(*rows, indexing="ij")
    return np.ravel_multi_index([g.ravel() for g in grid], study.shape)


def _placing_scenes(study: Study) -> list[Scene]:
    """Scenes that together need the coordinates of all runs.

    All, where few differ in what places them; of many, those with the extremes of each number, and
    a share between.
    """
    runs = study.runs

    def places(key: str) -> bool:
        return not (
            key.startswith(PLACELESS)
            or key.endswith(PLACELESS_ENDS)
            or any(part in key for part in PLACELESS_PARTS)
        )

    chosen = [any(places(axis.key) for axis in f.axes) for f in runs.factors]
    found = _product(study, chosen)
    if len(found) > MOST_SCENES:
        table = runs.columns(found)
        ends = [f(values) for values in table.values() for f in (np.argmin, np.argmax)]
        between = np.linspace(0, len(found) - 1, MOST_SCENES).astype(int)
        found = found[sorted({*map(int, ends), *between.tolist()})]
    return [runs[int(run)] for run in found]
