"""Whatever a results file follows through time, by its path."""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.attributes import text_of
from lumpedcable.results.errors import ResultError
from lumpedcable.results.lines import times_of

__all__ = ["Series"]

Array = NDArray[Any]

_ALONG, _ABOUT = ("x", "y", "z"), ("roll", "pitch", "yaw")
_BODY = {"position": _ALONG, "velocity": _ALONG, "attitude": _ABOUT, "turning": _ABOUT}
_ENDS = {f"{side}_{k}": _ALONG for side in ("start", "end") for k in ("position", "velocity")}
_COMPONENTS = _BODY | _ENDS
"""Of what is followed of bodies and of ends of lines, (run, time, 3)."""


class Series:
    """The datasets of an open file along run and time, found by their dimensions."""

    def __init__(self, file: h5py.File) -> None:
        self._file = file

    @property
    def histories(self) -> dict[str, tuple[str, str]]:
        """Every dataset of shape (run, time): what it is in words and its SI unit ("" if none)."""
        found: dict[str, tuple[str, str]] = {}

        def look(path: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and item.ndim == 2 and times_of(item) == "time":
                words = text_of(item.attrs.get("long_name", ""))
                words = words or path.split("/")[-1].replace("_", " ")
                unit = text_of(item.attrs.get("units", ""))
                found[path] = (words, "" if unit == "1" else unit)

        self._file.visititems(look)
        return found

    @property
    def motions(self) -> dict[str, tuple[str, str]]:
        """Every component of the motion of bodies and of ends of lines: whose it is, its SI unit.

        Their paths are "bodies/ship/position/x", "lines/rope/end_velocity/x".
        """
        found: dict[str, tuple[str, str]] = {}
        for kind, quantities in (("bodies", _BODY), ("lines", _ENDS)):
            group = self._file.get(kind)
            for name, one in group.items() if isinstance(group, h5py.Group) else ():
                for quantity, components in quantities.items():
                    item = one.get(quantity)
                    if isinstance(item, h5py.Dataset) and item.ndim == 3:
                        unit = text_of(item.attrs.get("units", ""))
                        for component in components:
                            found[f"{kind}/{name}/{quantity}/{component}"] = (name, unit)
        return found

    @property
    def numbers(self) -> dict[str, str]:
        """The SI unit ("" if none) of every number that sums up a run, a dataset of shape (run,)."""
        found: dict[str, str] = {}

        def look(path: str, item: Any) -> None:
            # in groups; what stands at the root tells of the runs themselves
            if not isinstance(item, h5py.Dataset) or item.ndim != 1 or "/" not in path:
                return
            if "run" in item.dims[0] and item.dtype.kind in "fiu":
                unit = text_of(item.attrs.get("units", ""))
                found[path] = "" if unit == "1" else unit

        self._file.visititems(look)
        return found

    def read(self, path: str, run: int | slice) -> Array:
        """One run, or some, of a dataset whose first dimension is run, or of one of `motions`.

        Raises:
            ResultError: the file does not hold it, or it cannot be read.
        """
        dataset, which = self._found(path)
        try:
            return np.asarray(dataset[run])[(..., *which)]
        except (OSError, IndexError, ValueError) as error:
            raise ResultError(f"{self._file.filename}: {path} cannot be read: {error}") from error

    def _found(self, path: str) -> tuple[h5py.Dataset, tuple[int, ...]]:
        """A dataset, and which of its last components is asked for, if one is."""
        for parent, which in ((path, ()), self._component(path)):
            found = self._file.get(parent)
            if isinstance(found, h5py.Dataset):
                return found, which
        raise ResultError(f"{self._file.filename}: no {path}")

    @staticmethod
    def _component(path: str) -> tuple[str, tuple[int, ...]]:
        parent, _, last = path.rpartition("/")
        known = _COMPONENTS.get(parent.rpartition("/")[2], ())
        return (parent, (known.index(last),)) if last in known else (path, ())
