"""The fields of a line in a results file, which stay on the disk until they are asked for."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.errors import ResultError
from lumpedcable.results.joined import damaged
from lumpedcable.results.schema import BREAKING_STRENGTH, FIELD_TIME

__all__ = ["Index", "LineData", "dataset_of", "frames_of", "read", "times_of"]

Array = NDArray[Any]
Index = int | slice | None

_AT_ONCE = 2**20  # numbers that are read at once


class LineData:
    """The fields of one line, read when asked for.

    `run` and `time` are indices or slices; leaving one out reads all along it. An index drops the
    dimension. Times are counted among those at which fields are kept, `time`. Where runs differ in their
    number of nodes, the surplus is NaN.
    """

    def __init__(self, group: h5py.Group, name: str) -> None:
        self.name: str = name
        self._group = group

    @property
    def nodes(self) -> int:
        """Number of nodes, the largest where runs differ."""
        return dataset_of(self._group, "node").shape[0]

    def node_count(self, run: int) -> int:
        """Number of nodes that a run has; the rest of the arrays is padding."""
        return int(np.isfinite(self.unstretched_position(run)).sum())

    @property
    def time(self) -> NDArray[np.float64]:
        """Times in s of its fields, shape (time,): all that are saved, or some of them."""
        return read(dataset_of(self._group, "/time"), ())[frames_of(self._group.file)]

    @property
    def fields(self) -> list[str]:
        """Names of the fields stored in every run and time."""
        return [
            key
            for key, item in self._group.items()
            if isinstance(item, h5py.Dataset) and times_of(item)
        ]

    def position(self, run: Index = None, time: Index = None) -> Array:
        """Node positions in m, shape (run, time, node, 3)."""
        return self.field("position", run, time)

    def velocity(self, run: Index = None, time: Index = None) -> Array:
        """Node velocities in m/s, shape (run, time, node, 3)."""
        return self.field("velocity", run, time)

    def tension(self, run: Index = None, time: Index = None) -> Array:
        """Segment tensions in N, shape (run, time, segment)."""
        return self.field("tension", run, time)

    def strain(self, run: Index = None, time: Index = None) -> Array:
        """Segment strains (-), shape (run, time, segment)."""
        return self.field("strain", run, time)

    def bending_moment(self, run: Index = None, time: Index = None) -> Array:
        """Bending moments at the nodes of a line that bends in N m, shape (run, time, node)."""
        return self.field("bending_moment", run, time)

    def field(self, name: str, run: Index = None, time: Index = None) -> Array:
        """Any field of shape (run, time, ...) by name, at the times that it is kept at.

        Raises:
            ResultError: the file does not hold it, or it cannot be read.
        """
        pick = tuple(slice(None) if index is None else index for index in (run, time))
        return read(dataset_of(self._group, name), pick)

    def breaking_strength(self, run: int = 0) -> float:
        """Breaking strength of its material in N in a run, NaN where the file tells of none."""
        if not self.has(BREAKING_STRENGTH):
            return float("nan")
        return float(read(dataset_of(self._group, BREAKING_STRENGTH), (run,)))

    def unstretched_position(self, run: int = 0) -> Array:
        """Unstretched distance of the nodes from the line's start in m, shape (node,)."""
        return self._along("unstretched_position", run)

    def unstretched_segment(self, run: int = 0) -> Array:
        """Unstretched distance of the segments' midpoints from the start in m, (segment,)."""
        return self._along("unstretched_segment", run)

    def unstretched_lengths(self) -> tuple[float, float]:
        """The least and the largest unstretched length (m) of all runs, NaN where none is known yet.

        From the first node to the last: a part of a line begins where the line is cut.
        """
        dataset = dataset_of(self._group, "unstretched_position")
        least, largest = np.inf, -np.inf
        step = max(1, _AT_ONCE // self.nodes)
        for first in range(0, len(dataset) if dataset.ndim == 2 else 1, step):
            pick = (slice(first, first + step),) if dataset.ndim == 2 else ()
            places = np.atleast_2d(read(dataset, pick))
            known = places[np.isfinite(places).any(axis=1)]  # of runs that have begun
            if len(known):
                lengths = np.nanmax(known, axis=1) - np.nanmin(known, axis=1)
                least, largest = min(least, lengths.min()), max(largest, lengths.max())
        return (float(least), float(largest)) if least <= largest else (np.nan, np.nan)

    def _along(self, name: str, run: int) -> Array:
        dataset = dataset_of(self._group, name)
        return read(dataset, (run,) if dataset.ndim == 2 else ())

    def has(self, name: str) -> bool:
        """Whether the file holds a field of this name."""
        return name in self._group


def frames_of(file: h5py.File) -> NDArray[np.int64]:
    """Which of the saved times of a file have fields, shape (time,)."""
    time = read(dataset_of(file, "time"), ())
    if FIELD_TIME not in file:
        return np.arange(len(time))
    seldom = read(dataset_of(file, FIELD_TIME), ())
    return np.searchsorted((time[1:] + time[:-1]) / 2, seldom)  # the nearest ones


def times_of(dataset: h5py.Dataset) -> str | None:
    """Which times its second dimension is of: all ("time"), those of fields, or none at all (None)."""
    names = ("time", FIELD_TIME) if dataset.ndim > 1 else ()
    return next((name for name in names if name in dataset.dims[1]), None)


def dataset_of(group: h5py.Group, name: str) -> h5py.Dataset:
    """A dataset of a group; ResultError where it is not there."""
    found = group.get(name)
    if not isinstance(found, h5py.Dataset):
        raise ResultError(f"{group.file.filename}: no {name} in {group.name}")
    return found


def read(dataset: h5py.Dataset, pick: tuple[int | slice, ...]) -> Array:
    """A part of a dataset; ResultError where there is no such part, or it is damaged."""
    try:
        return np.asarray(dataset[pick])
    except (IndexError, ValueError) as error:
        shape = dataset.shape
        raise ResultError(f"{dataset.name} of shape {shape} has no part {pick}") from error
    except OSError as error:
        raise ResultError(damaged(dataset)) from error
