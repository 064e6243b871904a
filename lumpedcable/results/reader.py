"""Reads a results file, finished or not; fields stay on the disk until they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import deepcopy
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.attributes import attributes_of as _attributes
from lumpedcable.results.attributes import text_of as _text
from lumpedcable.results.axes import Axis
from lumpedcable.results.errors import ResultError, check_known, did_you_mean, first_line
from lumpedcable.results.folder import HOW_TO_SHOW, StudyFolder, is_study_folder
from lumpedcable.results.ground import tables
from lumpedcable.results.joined import is_whole
from lumpedcable.results.lines import Index, LineData, dataset_of, frames_of, read
from lumpedcable.results.opening import read_only
from lumpedcable.results.schema import axes_words, check_version, partial_of
from lumpedcable.results.series import Series

Array = NDArray[Any]
Kind = TypeVar("Kind")

OK = "ok"
"""The status of a run that reached its end."""


class ResultFile:
    """An open results file; close it or use it as a context manager.

    What is known before a study runs (times, swept numbers, names of cases) is read once; what runs
    write, each time that it is asked for.

    Attributes:
        path: where it lies.
        attributes: attributes of the whole file; `complete` is a bool, `versions`, `overrides` and
            `dimensions` are unpacked from their JSON text.
        complete: whether the study ran to its end, and all its files are there.
        runs: number of runs.
        time: saved times in s, shape (time,).
        frames: which of them have fields of lines, shape (frame,).
        series: everything along run and time by its path.
    """

    def __init__(self, path: Path, file: h5py.File) -> None:
        self.path = path
        self._file = file
        self.series: Series = Series(file)
        self.attributes: dict[str, Any] = _attributes(file)
        self.complete: bool = is_whole(file)
        self.attributes["complete"] = self.complete
        shape = dataset_of(file, "run").shape
        if len(shape) != 1:
            raise ResultError(f"{path} is damaged: expected run of shape (run,), found {shape}")
        self.runs: int = int(shape[0])
        self.time: NDArray[np.float64] = read(dataset_of(file, "time"), ())
        self.frames: NDArray[np.int64] = frames_of(file)

    @property
    def field_time(self) -> NDArray[np.float64]:
        """Saved times in s that have fields of lines, shape (frame,)."""
        return self.time[self.frames]

    @property
    def scene_text(self) -> str:
        """The whole scene file the study was run from."""
        return str(self.attributes.get("scene", ""))

    @cached_property
    def scene(self) -> dict[str, Any]:
        """The tables of the scene in SI numbers, with what was changed on the command line."""
        return tables(str(self.attributes.get("effective_scene", "")) or self.scene_text)

    def scene_of(self, run: int) -> dict[str, Any]:
        """The same with the swept numbers of a run."""
        scene = deepcopy(self.scene)
        for axis in self.axes:
            *way, last = axis.key.split(".")
            table: Any = scene
            for key in way:
                table = _inside(table, key)
            value = axis.values[run].item()
            if isinstance(table, dict):
                table[last] = value
            elif _inside(table, last) is not None:
                table[int(last)] = value
        return scene

    @cached_property
    def axes(self) -> list[Axis]:
        """The swept numbers, slowest first; empty without a sweep."""
        found: list[tuple[int, str, h5py.Dataset]] = []
        for name, item in self._file.items():
            if isinstance(item, h5py.Dataset) and "key" in item.attrs:
                found.append((int(item.attrs.get("axis", len(found))), name, item))
        found.sort(key=lambda entry: entry[0])
        keys = [_text(item.attrs["key"]) for _, _, item in found]
        units = [_text(item.attrs.get("units", "")) for _, _, item in found]
        return [
            Axis(name, key, unit if unit != "1" else "", item[()], words)
            for (_, name, item), key, unit, words in zip(
                found, keys, units, axes_words(keys), strict=True
            )
        ]

    @cached_property
    def cases(self) -> list[str]:
        """The name of the case of every run; empty where a sweep names none."""
        item = self._file.get("case")
        return [_text(name) for name in item[()]] if isinstance(item, h5py.Dataset) else []

    @cached_property
    def axes_apart(self) -> list[Axis]:
        """The swept numbers less those that the name of a case stands for."""
        cases = self.cases
        if not cases:
            return self.axes
        return [
            axis
            for axis in self.axes
            if len(set(zip(cases, axis.values.tolist(), strict=True))) > len(set(cases))
        ]

    def hold(self, run: int) -> None:
        """Raise ResultError where there is no such run."""
        if not (isinstance(run, int | np.integer) and 0 <= run < self.runs):
            expected = f"a run from 0 to {self.runs - 1}" if self.runs > 1 else "0, its only run"
            raise ResultError(f"{self.path}: expected {expected}, found {run!r}")

    def label(self, run: int, digits: int = 6) -> str:
        """What sets a run apart, e.g. "pretension 45 kN, break time 5 ms"; "" without a sweep.

        The name of its case stands for the numbers that belong to it.
        """
        case = self.cases[run : run + 1]
        return ", ".join([*case, *(axis.text(run, digits) for axis in self.axes_apart)])

    @property
    def status(self) -> list[str]:
        """How each run ended: "ok", or a word for what went wrong."""
        if "status" not in self._file:
            return [OK] * self.runs
        dataset = dataset_of(self._file, "status")
        meanings = _text(dataset.attrs.get("flag_meanings", "")).split()
        values = np.atleast_1d(dataset.attrs.get("flag_values", np.arange(len(meanings))))
        words = {int(v): word for v, word in zip(values, meanings, strict=False)}
        return [words.get(int(v), f"status {int(v)}") for v in read(dataset, ())]

    @property
    def status_time(self) -> Array:
        """When each failed run failed, in s, NaN for the others; shape (run,)."""
        if "status_time" not in self._file:
            return np.full(self.runs, np.nan)
        return read(dataset_of(self._file, "status_time"), ())

    @property
    def status_message(self) -> list[str]:
        """What each failed run said, "" for the others."""
        if "status_message" not in self._file:
            return [""] * self.runs
        return [_text(value) for value in read(dataset_of(self._file, "status_message"), ())]

    def reason(self, run: int) -> str:
        """Why a run is not all there: what it said, or else how it ended."""
        return self.status_message[run] or self.status[run].replace("_", " ")

    @property
    def written(self) -> NDArray[np.int64]:
        """Number of saved times on the disk, shape (run,); less than `time` where unfinished."""
        if "written" not in self._file:
            return np.full(self.runs, len(self.time))
        return read(dataset_of(self._file, "written"), ()).astype(np.int64)

    @property
    def lines(self) -> list[str]:
        """Names of the lines in the order of the scene; parts of one that breaks are together."""
        order = {name: k for k, name in enumerate(self.scene.get("lines") or {})}

        def place(name: str) -> tuple[int, int, str]:
            own = name if name in order else name.rpartition("-")[0]
            return order.get(own, len(order)), len(name), name

        return sorted(self._names("lines", h5py.Group), key=place)

    def line(self, name: str) -> LineData:
        """The fields of one line.

        Raises:
            ResultError: there is no such line.
        """
        self._check("line", name, self.lines)
        group = self._file[f"lines/{name}"]
        assert isinstance(group, h5py.Group)
        return LineData(group, name)

    @property
    def bodies(self) -> list[str]:
        """Names of the rigid bodies."""
        return self._names("bodies", h5py.Group)

    def body(self, name: str, quantity: str, run: Index = None) -> Array:
        """position (m), velocity (m/s), attitude (rad) or turning (rad/s) of a body, (run, time, 3).
        Raises ResultError where there is no such body or quantity.
        """
        self._check("body", name, self.bodies)
        self._check("quantity", quantity, self._names(f"bodies/{name}"))
        pick = () if run is None else (run,)
        return read(dataset_of(self._file, f"bodies/{name}/{quantity}"), pick)

    def measures(self) -> dict[str, tuple[Array, dict[str, Any]]]:
        """Measures (run, time), NaN where they do not count, with units, long_name and limit."""
        found = {n: dataset_of(self._file, f"measures/{n}") for n in self._names("measures")}
        return {n: (read(d, ()), _attributes(d)) for n, d in found.items()}

    @property
    def measured(self) -> dict[str, str]:
        """Measures by name, with or without histories: whether the "largest" or the "least" tells."""
        told = {name: self.summary_attributes("run", name) for name in self._names("summary")}
        kept = self._names("measures")
        mine = {n: of for n, of in told.items() if n in kept or "extreme" in of}
        return {name: str(of.get("extreme", "largest")) for name, of in mine.items()}

    @property
    def energy_terms(self) -> list[str]:
        """Names of the energy terms."""
        return self._names("energy", h5py.Dataset)

    def energy(self, term: str, run: Index = None) -> Array:
        """An energy term in J, shape (run, time).

        Raises:
            ResultError: there is no such term.
        """
        self._check("energy term", term, self.energy_terms)
        pick = () if run is None else (run,)
        return read(dataset_of(self._file, f"energy/{term}"), pick)

    def energy_name(self, term: str) -> str:
        """What an energy term is, in words."""
        self._check("energy term", term, self.energy_terms)
        return _text(dataset_of(self._file, f"energy/{term}").attrs.get("long_name", term))

    @property
    def ends(self) -> list[str]:
        """The recoiling ends that the summary tells of, e.g. "rope.end"."""
        return self._names("summary", h5py.Group)

    def summary(self) -> dict[str, dict[str, Array]]:
        """All summary numbers by end and quantity, each of shape (run,).

        Numbers of the whole run, such as energy_closure, stand under "run".
        """
        found = {
            end: {name: self._summary(end, name) for name in self._names(f"summary/{end}")}
            for end in self.ends
        }
        whole = {name: self._summary("run", name) for name in self._names("summary")}
        return {**({"run": whole} if whole else {}), **found}

    def summary_attributes(self, end: str, name: str) -> dict[str, Any]:
        """Attributes of a summary number: units, long_name, and `holds` or `source` if any."""
        return _attributes(dataset_of(self._file, _summary_path(end, name)))

    @property
    def cables(self) -> list[str]:
        """Names of the cables of a scene at rest, e.g. "before+after"; none where it moves."""
        return self._names("rest", h5py.Group)

    def rest(self, cable: str) -> dict[str, Array]:
        """Numbers of a cable at rest by name, each of shape (run,).

        Raises:
            ResultError: there is no such cable.
        """
        self._check("cable", cable, self.cables)
        path = f"rest/{cable}"
        return {
            name: read(dataset_of(self._file, f"{path}/{name}"), ()) for name in self._names(path)
        }

    def group_attributes(self, path: str) -> dict[str, Any]:
        """Attributes of any group, e.g. "summary/rope.end"; empty if there is none."""
        return _attributes(self._file[path]) if path in self._file else {}

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
        if isinstance(error, _DAMAGE) and _raised_by_h5py(trace):
            raise ResultError(_told(self.path, error)) from error

    def _summary(self, end: str, name: str) -> Array:
        return read(dataset_of(self._file, _summary_path(end, name)), ())

    def _names(self, path: str, kind: type = h5py.Dataset) -> list[str]:
        group = self._file.get(path)
        if not isinstance(group, h5py.Group):
            return []
        return [key for key, item in group.items() if isinstance(item, kind)]

    def _check(self, what: str, name: str, known: Iterable[str]) -> None:
        check_known(self.path, what, name, known)


# what reading an array, an attribute or JSON of another form raises
_DAMAGE = (AssertionError, IndexError, KeyError, OSError, RuntimeError, TypeError, ValueError)


def open_result(path: str | Path) -> ResultFile:
    """Open a results file, finished or not.

    Args:
        path: the file; one still being written (NAME.partial) is read as far as it was flushed; or a
            study folder, whose shards are read as one file.

    Returns:
        The open file, to be closed or used as a context manager.

    Raises:
        ResultError: there is no such file, or it is not a results file of a layout known here.
    """
    return opened(path, ResultFile)


def opened(path: str | Path, kind: Callable[[Path, h5py.File], Kind]) -> Kind:
    """What `kind` makes of a results file, open; where it fails the file is closed again.

    Raises:
        ResultError: as of `open_result`.
    """
    path = Path(path)
    try:
        folder = StudyFolder.open(path) if is_study_folder(path) else None
        path = path if folder is None else folder.view
        if path.is_dir():
            raise ResultError(f"{path} is a folder, expected a results file (*.h5)")
        if not path.exists():
            partial = partial_of(path)
            siblings = path.parent.glob("*.h5") if path.parent.is_dir() else ()
            hint = did_you_mean(path.name, (other.name for other in siblings))
            if partial.exists():
                hint = f"; there is an unfinished {partial.name} beside it"
            if folder is not None:
                hint = f"; {HOW_TO_SHOW}"
            raise ResultError(f"no such file: {path}{hint}")
        file = read_only(path)
    except PermissionError as error:
        raise ResultError(f"{path} may not be read (permission denied)") from error
    except OSError as error:
        reason = "a damaged HDF5 file" if h5py.is_hdf5(path) else "not an HDF5 file"
        hint = "; lumpedcable run writes one from a scene" if path.suffix == ".toml" else ""
        raise ResultError(f"{path} is {reason}, expected a results file{hint}") from error
    try:
        check_version(path, _text(file.attrs.get("schema_version", "")))
        return kind(path, file)
    except BaseException as error:
        file.close()
        if isinstance(error, _DAMAGE):
            raise ResultError(_told(path, error)) from error
        raise


def _told(path: Path, error: BaseException) -> str:
    return f"{path} is damaged or lacks a part: {first_line(error)}"


def _raised_by_h5py(trace: TracebackType | None) -> bool:
    """Whether an error arose in h5py itself: any look into a damaged file may meet the damage."""
    file = ""
    while trace is not None:
        file, trace = trace.tb_frame.f_code.co_filename, trace.tb_next
    return "h5py" in Path(file).parts


def _summary_path(end: str, name: str) -> str:
    return f"summary/{name}" if end == "run" else f"summary/{end}/{name}"


def _inside(table: Any, key: str) -> Any:
    """What a table of a scene has under a key, or a list in a place such as "2"; None for nothing."""
    if isinstance(table, list) and key.isdecimal() and int(key) < len(table):
        return table[int(key)]
    return table.get(key) if isinstance(table, dict) else None
