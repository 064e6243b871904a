"""A results file as far as its runs went, and went well."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.lines import Index, LineData, dataset_of, times_of
from lumpedcable.results.reader import OK, ResultFile, opened
from lumpedcable.results.series import Series

__all__ = ["NOT_YET", "WELL", "SoundFile"]

Array = NDArray[Any]
NOT_YET = "interrupted"  # at its end, or not begun
WELL = (OK, "still_moving", NOT_YET)  # ends up to which a run is right


class SoundFile(ResultFile):
    """A results file of whose runs all that came after they had gone wrong or had stopped reads NaN.

    What follows a run that goes wrong may be of any size, and would hide beside it what came before;
    what follows a stop is the state at it, which is no part of the motion. Where a picture keeps on
    showing what has stopped, as it lies there, that can be left as it is.
    """

    def __init__(self, path: Path, file: h5py.File, stops: bool = True) -> None:
        super().__init__(path, file)
        self.series: Series = _SoundSeries(file, self)
        self._stops = stops

    @classmethod
    def open(cls, path: str | Path, *, stops: bool = True) -> Self:
        """Open a results file, as `open_result` does.

        Args:
            path: as of `open_result`.
            stops: whether what followed a stop reads NaN too, or the state at the stop.

        Raises:
            ResultError: as of `open_result`.
        """
        return opened(path, lambda where, file: cls(where, file, stops))

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """At which saved times each run was right and on its way, (run, time); it is at its start.

        So it is at the first saved time after its stop, which is of the stop itself, and where stops
        do not count at all that follow.
        """
        return self._until(self._stops, self.time)

    @cached_property
    def shown(self) -> NDArray[np.bool_]:
        """The same at the times with fields, (run, field_time)."""
        return self._until(self._stops, self.field_time)

    @cached_property
    def moving(self) -> NDArray[np.bool_]:
        """The same where stops count in any case: what has stopped keeps the speed at its stop."""
        return self._until(True, self.time)

    def _until(self, stops: bool, times: Array) -> NDArray[np.bool_]:
        failed = np.array([status not in WELL for status in self.status])
        good = ~(failed[:, None] & (times >= self.status_time[:, None]))
        stop = self.summary().get("run", {}).get("stop_time") if stops else None
        if stop is not None:
            good[:, 1:] &= ~(times[None, :-1] >= stop[:, None])
        good[:, 0] = True
        return good

    def good_at(self, times: str | None) -> NDArray[np.bool_] | None:
        """The same at the times of `times_of`; None where there are none."""
        if times is None:
            return None
        return self.good if times == "time" else self.shown

    def last_frame(self, run: int) -> int:
        """Number of the last time with fields at which a run was right and on its way."""
        return int(self.shown[run].nonzero()[0][-1])

    def line(self, name: str) -> LineData:
        """The fields of one line."""
        return _SoundLine(super().line(name)._group, name, self)

    def body(self, name: str, quantity: str, run: Index = None) -> Array:
        """As of the whole file."""
        return _masked(super().body(name, quantity, run), self.good, run)

    def measures(self) -> dict[str, tuple[Array, dict[str, Any]]]:
        """As of the whole file."""
        return {n: (_masked(v, self.good), told) for n, (v, told) in super().measures().items()}

    def energy(self, term: str, run: Index = None) -> Array:
        """As of the whole file."""
        return _masked(super().energy(term, run), self.good, run)


class _SoundLine(LineData):
    """The fields of one line, as far as its runs went well."""

    def __init__(self, group: h5py.Group, name: str, whole: SoundFile) -> None:
        super().__init__(group, name)
        self._whole = whole

    def field(self, name: str, run: Index = None, time: Index = None) -> Array:
        """As of the whole file."""
        values = super().field(name, run, time)
        good = self._whole.good_at(times_of(dataset_of(self._group, name)))
        return values if good is None else _masked(values, good, run, time)


class _SoundSeries(Series):
    """What the file follows through time by its path, as far as its runs went well."""

    def __init__(self, file: h5py.File, whole: SoundFile) -> None:
        super().__init__(file)
        self._whole = whole

    def read(self, path: str, run: int | slice) -> Array:
        """As of the whole file."""
        values = super().read(path, run)
        good = self._whole.good_at(times_of(self._found(path)[0]))
        return values if good is None else _masked(values, good, run)


def _masked(values: Array, good: NDArray[np.bool_], run: Index = None, time: Index = None) -> Array:
    """Values (run, time, ...), or of some, with NaN for what is not good."""
    good = good[tuple(slice(None) if index is None else index for index in (run, time))]
    if good.all():
        return values
    return np.where(good.reshape(good.shape + (1,) * (values.ndim - good.ndim)), values, np.nan)
