"""What is measured: series of numbers in SI with their noise, table by table and record by record."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.language import FitMethod
from lumpedcable.fitting.observe import Watched
from lumpedcable.fitting.parameters import Parameter
from lumpedcable.scene import Study

__all__ = ["FitProblem", "Record", "Series", "Smooth", "Table"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Series:
    """Measured values over strain or time, all in SI.

    `noise` is their standard deviation, None where it is not known; `weight` is one over it, or over
    the largest value where it is not. `time` (s) is that of a bench's rows over strain, None where they
    have none.
    """

    name: str
    label: str
    unit: str
    x: Array
    x_unit: str
    values: Array
    noise: float | None
    time: Array | None = None

    @property
    def weight(self) -> float:
        """What a deviation is multiplied with."""
        top = float(np.max(np.abs(self.values)))
        return 1.0 / (self.noise if self.noise is not None else top if top > 0.0 else 1.0)


@dataclass(frozen=True)
class Table:
    """Tensions of a material of a scene at given strains, in order of time where the series has one."""

    name: str
    study: Study
    material: str
    series: Series


@dataclass(frozen=True)
class Record:
    """One run of a scene, and what was recorded of it."""

    name: str
    study: Study
    watched: tuple[Watched, ...]
    distances: tuple[float, ...]
    series: tuple[Series, ...]


@dataclass(frozen=True)
class Smooth:
    """A table of tensions whose slope shall change little: change by `size` of the mean slope."""

    key: str
    experiment: str | None
    size: float


@dataclass(frozen=True)
class FitProblem:
    """Everything that a fit needs to know: parameters, data and how to search; its file, for faults."""

    title: str
    study: Study
    parameters: tuple[Parameter, ...]
    tables: tuple[Table, ...]
    records: tuple[Record, ...]
    smooth: tuple[Smooth, ...]
    method: FitMethod
    file: str = ""

    @property
    def series(self) -> list[Series]:
        """All series: those of the tables, then those of the records."""
        return [t.series for t in self.tables] + [s for r in self.records for s in r.series]

    @property
    def points(self) -> int:
        """Number of measured values."""
        return sum(series.values.size for series in self.series)

    @property
    def ranges(self) -> tuple[Array, Array, Array]:
        """The bounds of all parameters, low and high, and their start values, each (p,) in SI."""
        low, high, start = (
            np.array([getattr(p, k) for p in self.parameters]) for k in ("low", "high", "start")
        )
        return low, high, start

    @property
    def freedom(self) -> int:
        """Degrees of freedom that the data leave: values beyond the parameters, 1 at least."""
        return max(self.points - len(self.parameters), 1)

    @property
    def known_noise(self) -> bool:
        """Whether the noise was given, rather than to be found from what the fit leaves."""
        return all(series.noise is not None for series in self.series)

    def owner(self, key: str, experiment: str) -> int | None:
        """The index of the parameter that is this key in this experiment, None where none is."""
        for index, parameter in enumerate(self.parameters):
            if parameter.key == key and parameter.experiment in (None, experiment):
                return index
        return None
