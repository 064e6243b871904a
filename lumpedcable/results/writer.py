"""Writes a results file piece by piece, so that what has been flushed outlives a crash.

The file grows under a temporary name beside the target and takes the target's name only when it is
finished. All numeric datasets are laid out in full when the writer is made: a full disk or a
forbidden folder shows before anything is computed, and later writes change bytes of data but no
structure of the file, so that a process killed between two flushes cannot leave it unreadable.
That is also why nothing is compressed.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.results import disk
from lumpedcable.results.errors import OutputError, nearest
from lumpedcable.results.joined import joined
from lumpedcable.results.schema import (
    SCHEMA_VERSION,
    Coordinate,
    Variable,
    as_dataset,
    attribute,
    group_of,
    partial_of,
    resolve,
)
from lumpedcable.results.target import followed

_TEXT = h5py.string_dtype("utf-8")


class ResultWriter:
    """A results file in the making.

    As a context manager it finishes on a normal exit; on an exception it keeps the temporary file
    where something had been flushed, and deletes it otherwise.

    Args:
        target: the file to make, usually *.h5. Where it is a symbolic link, the file that it leads to
            is made, but for one with `parts`.
        dims: size of every dimension by path, e.g. {"run": 8, "lines/rope/node": 201, "xyz": 3}.
        variables: datasets to be written later with `write`.
        coordinates: datasets known now, by path. A dimension without one counts 0, 1, 2, ..., but
            "xyz" of size 3 reads "x", "y", "z".
        attributes: attributes of the whole file (title, scene, solver, ...).
        overwrite: whether an existing target may be replaced (when finished, not before).
        parts: other results files that hold the runs in this order, as (name relative to the
            target's folder, number of runs). The variables along runs are then views of theirs;
            where a file is not there yet, they read as not written.
        folders: whether missing folders above the target are made, or an OutputError.
        goes_on: whether to go on with the temporary file that an earlier writer, which was given the
            same, has left.

    Raises:
        BusyError: another process writes the file.
        OutputError: the file cannot be written there.
        ValueError: the declaration is inconsistent (a mistake in the calling program).
    """

    def __init__(
        self,
        target: str | Path,
        *,
        dims: Mapping[str, int],
        variables: Iterable[Variable],
        coordinates: Mapping[str, Coordinate] | None = None,
        attributes: Mapping[str, Any] | None = None,
        overwrite: bool = True,
        parts: Sequence[tuple[str, int]] = (),
        goes_on: bool = False,
        folders: bool = True,
    ) -> None:
        # references are looked for beside the file that has them
        self.target: Path = Path(target) if parts else followed(Path(target))
        self.partial: Path = partial_of(self.target)
        self._dims = dict(dims)
        self._variables = {variable.path: variable for variable in variables}
        self._flushed, self._parts = False, tuple(parts)
        self._lost: OutputError | None = None
        coordinates = _with_defaults(self._dims, coordinates or {})
        self._counted = {
            path: np.zeros(self._dims["run"], np.int32)
            for path, variable in self._variables.items()
            if variable.counted and "run" in self._dims and {"run", "time"} <= set(variable.dims)
        }
        if goes_on:
            self._go_on()
            return
        if folders:
            disk.make_folder(self.target)
        disk.prepare(self.target, self.partial, overwrite)
        with disk.reported(self.partial):
            self._file = disk.create(self.partial)
        try:
            if not overwrite and self.target.exists():  # finished by another process meanwhile
                raise OutputError(f"cannot write {self.target}: it exists already")
            if not self._parts:
                disk.check_room(self.target, sum(map(self._bytes, self._variables.values())))
            with self._written():
                self._lay_out(coordinates, attributes or {})
                self._sync()
        except BaseException:
            self.abandon()
            raise

    def write(self, path: str, values: ArrayLike, **selection: slice | int) -> None:
        """Write part of a variable.

        Args:
            path: the variable's path.
            values: array of exactly the selected shape; text for variables of dtype "str".
            selection: for each dimension to restrict, a slice or an index, e.g.
                `run=slice(0, 8), time=slice(0, 25)`; the other dimensions are written whole.

        Raises:
            OutputError: the disk is full or gone.
            ValueError: no such variable or dimension, or another shape (a mistake in the caller).
        """
        variable = self._variables.get(path)
        if variable is None:
            close = nearest(path, self._variables)
            raise ValueError(f"no variable {path!r}" + (f"; nearest: {close}" if close else ""))
        unknown = set(selection) - set(variable.dims)
        if unknown:
            raise ValueError(f"{path} has dimensions {variable.dims}, not {sorted(unknown)}")
        dataset = self._dataset(path)
        ranges = [
            range(size)[selection.get(dim, slice(None))]
            for dim, size in zip(variable.dims, dataset.shape, strict=True)
        ]
        expected = tuple(len(kept) for kept in ranges if isinstance(kept, range))
        array = as_dataset(values)
        if array.shape != expected:
            raise ValueError(f"{path}: expected shape {expected}, found {array.shape}")
        with self._written():
            dataset[tuple(selection.get(dim, slice(None)) for dim in variable.dims)] = array
            if variable.dtype == "str":
                self._file.flush()  # text lives in a heap: leave no half-written one behind
        if path in self._counted:
            self._count(path, selection.get("run"), selection.get("time"))

    def flush(self) -> None:
        """Bring everything written so far safely onto the disk.

        Raises:
            OutputError: the disk is full or gone.
        """
        with self._written():
            if self._counted and not self._parts:
                self._dataset("written")[...] = np.min(list(self._counted.values()), axis=0)
            self._sync()
        self._flushed = True

    def finish(self, complete: bool = True, **attributes: Any) -> Path:
        """Mark the file complete, close it and give it the target's name.

        Args:
            complete: False for a view of parts that are not all there.
            attributes: last attributes of the whole file.

        Returns:
            The target's path.

        Raises:
            BusyError: another process has put its own file there, which a disk without locks allows.
            OutputError: the disk is full or gone; the temporary file stays.
        """
        with self._written():
            for name, value in attributes.items():
                self._set(name, value)
            self._set("complete", complete)
        self.flush()
        own = disk.is_named(self._file, self.partial)
        with disk.reported(self.target), disk.let_go(self._file):
            if not own:
                raise BlockingIOError
            os.replace(self.partial, self.target)
            disk.sync_folder(self.target.parent)
        return self.target

    def keep(self) -> Path:
        """Flush and close, leaving the temporary file as it is: incomplete but readable."""
        try:
            self.flush()
        finally:
            disk.close(self._file)
        return self.partial

    def abandon(self) -> None:
        """Close and delete the temporary file."""
        with disk.let_go(self._file):
            self.partial.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if not self._file:  # closed already: finished, kept or abandoned
            return
        if kind is None:
            self.finish()
        elif self._flushed:
            with contextlib.suppress(OutputError):  # the first error is the one to report
                self.keep()
        else:
            self.abandon()

    @contextlib.contextmanager
    def _written(self) -> Iterator[None]:
        """Whatever changes the file; once that has failed, nothing more is written to it."""
        if self._lost is not None:
            raise self._lost
        try:
            with disk.reported(self.partial):
                yield
        except OutputError as error:
            self._lost = error
            disk.sink(self._file)
            raise

    def _go_on(self) -> None:
        """Open the temporary file that is there, and know what of every run is written."""
        with disk.reported(self.partial):
            self._file = disk.reopen(self.partial)
            for ends in self._counted.values():
                ends[...] = self._dataset("written")[...]
        self._flushed = True

    def _bytes(self, variable: Variable) -> int:
        """Size of a variable on the disk; text has none of a size known before."""
        if variable.dtype == "str":
            return 0
        shape = (self._dims[path] for path in self._paths(variable.path, variable.dims))
        return math.prod(shape) * np.dtype(variable.dtype).itemsize

    def _lay_out(
        self, coordinates: Mapping[str, Coordinate], attributes: Mapping[str, Any]
    ) -> None:
        for name, value in {
            "schema_version": SCHEMA_VERSION,
            **attributes,
            "dimensions": self._dims,
            "complete": False,
        }.items():
            self._set(name, value)
        for path in self._dims:
            self._place(path, coordinates[path])
            self._dataset(path).make_scale(path.rpartition("/")[2])
        auxiliary = {path: c for path, c in coordinates.items() if path not in self._dims}
        for path, coordinate in auxiliary.items():
            self._place(path, coordinate)
        places = {path: v.dims for path, v in self._variables.items() if v.places}
        places |= {path: coordinate.dims or () for path, coordinate in auxiliary.items()}
        for variable in self._variables.values():
            self._declare(variable, {} if variable.places else places)
        if self._counted:
            self._declare(Variable("written", ("run",), "i4", "1", "saved times written"), {})

    def _place(self, path: str, coordinate: Coordinate) -> None:
        array = as_dataset(coordinate.values)
        dims = coordinate.dims or (path.rpartition("/")[2],)
        shape = tuple(self._dims[p] for p in self._paths(path, dims))
        if array.shape != shape:
            raise ValueError(f"{path}: expected shape {shape} for {dims}, found {array.shape}")
        dtype = _TEXT if array.dtype == object else array.dtype
        dataset = self._file.create_dataset(path, data=array, dtype=dtype)
        if path not in self._dims:
            self._attach(dataset, path, dims)
        _describe(dataset, coordinate.units, coordinate.long_name, coordinate.attributes)

    def _declare(self, variable: Variable, places: Mapping[str, tuple[str, ...]]) -> None:
        text = variable.dtype == "str"
        dtype = _TEXT if text else np.dtype(variable.dtype)
        fill = variable.fill
        if fill is None and np.dtype(dtype).kind == "f":
            fill = np.nan
        shape = tuple(self._dims[p] for p in self._paths(variable.path, variable.dims))
        if self._parts and variable.dims[:1] == ("run",):
            dataset = joined(self._file, variable.path, shape, dtype, fill, self._parts)
        else:
            kept = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            if not text:
                kept.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
                kept.set_fill_time(h5py.h5d.FILL_TIME_ALLOC)
            dataset = self._create(variable.path, shape, dtype, fill, kept)
        self._attach(dataset, variable.path, variable.dims)
        _describe(dataset, variable.units, variable.long_name, variable.attributes)
        group = group_of(variable.path)
        beside = [
            path.rpartition("/")[2]
            for path, dims in places.items()
            if group_of(path) == group and set(dims) <= set(variable.dims)
        ]
        if beside:  # the CF way of naming coordinates that are not dimensions
            dataset.attrs["coordinates"] = " ".join(beside)

    def _create(
        self, path: str, shape: tuple[int, ...], dtype: Any, fill: Any, kept: Any
    ) -> h5py.Dataset:
        if fill is not None:
            kept.set_fill_value(np.asarray(fill, dtype))
        group = self._file.require_group("/" + group_of(path))
        space = h5py.h5s.create_simple(shape)
        kind = h5py.h5t.py_create(np.dtype(dtype), logical=True)
        name = path.rpartition("/")[2].encode()
        return h5py.Dataset(h5py.h5d.create(group.id, name, kind, space, dcpl=kept))

    def _attach(self, dataset: h5py.Dataset, path: str, dims: tuple[str, ...]) -> None:
        for place, scale in enumerate(self._paths(path, dims)):
            dataset.dims[place].attach_scale(self._dataset(scale))

    def _paths(self, path: str, dims: tuple[str, ...]) -> list[str]:
        return [resolve(dim, group_of(path), self._dims) for dim in dims]

    def _dataset(self, path: str) -> h5py.Dataset:
        found = self._file[path]
        assert isinstance(found, h5py.Dataset)
        return found

    def _set(self, name: str, value: Any) -> None:
        if value is not None:
            self._file.attrs[name] = attribute(value)

    def _count(self, path: str, runs: slice | int | None, times: slice | int | None) -> None:
        """Move the end of the unbroken stretch of times written from the first, run by run."""
        kept = range(self._dims["time"])[times if times is not None else slice(None)]
        first, last = (kept, kept) if isinstance(kept, int) else (kept[0], kept[-1])
        ends = self._counted[path]
        part = ends[runs if runs is not None else slice(None)]
        ends[runs if runs is not None else slice(None)] = np.where(
            (part >= first), np.maximum(part, last + 1), part
        )

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.id.get_vfd_handle())


def _with_defaults(
    dims: Mapping[str, int], coordinates: Mapping[str, Coordinate]
) -> dict[str, Coordinate]:
    """Every dimension's coordinate, given or counted, then the others in their order."""
    complete: dict[str, Coordinate] = {}
    for path, size in dims.items():
        if size < 1:
            raise ValueError(f"dimension {path}: expected a size of at least 1, found {size}")
        name = path.rpartition("/")[2]
        values: NDArray[Any] = np.arange(size, dtype=np.int32)
        if name == "xyz" and size == 3:
            values = np.array(["x", "y", "z"], object)
        words = "component" if name == "xyz" else f"{name} number"
        complete[path] = coordinates.get(path, Coordinate(values, "1", words))
    return {**complete, **coordinates}


def _describe(
    dataset: h5py.Dataset, units: str, long_name: str, attributes: Mapping[str, Any]
) -> None:
    dataset.attrs["units"] = units
    dataset.attrs["long_name"] = long_name or str(dataset.name).rpartition("/")[2].replace("_", " ")
    for name, value in attributes.items():
        if value is not None:
            dataset.attrs[name] = attribute(value)
