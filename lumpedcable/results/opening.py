"""Results files opened for reading, beside whoever else reads or writes them."""

from __future__ import annotations

import contextlib
from pathlib import Path

import h5py

from lumpedcable.results.schema import PARTIAL_SUFFIX

__all__ = ["how_locked", "read_only"]

Lock = bool | None
"""Whether HDF5 asks for a lock, as `h5py.File` takes it; None is its own default."""


def read_only(path: Path) -> h5py.File:
    """The file, open.

    A process may open a file several times if it asks for locks alike each time. A whole file is opened
    as h5py and xarray do it, so that whoever has read results may go on with either; one that is still
    written must be readable beside its writer, who has it locked.

    Raises:
        OSError: it cannot be opened in any way: that of the first.
    """
    return _opened(path)[0]


def how_locked(path: Path) -> Lock:
    """What to ask of locks for the file to open, as `read_only` does.

    Raises:
        OSError: it cannot be opened.
    """
    file, way = _opened(path)
    file.close()
    return way


def _opened(path: Path) -> tuple[h5py.File, Lock]:
    written = path.name.endswith(PARTIAL_SUFFIX)
    first, *others = (False, None, True) if written else (None, False, True)
    try:
        return h5py.File(path, "r", locking=first), first
    except (FileNotFoundError, PermissionError, IsADirectoryError):
        raise
    except OSError:
        for other in others:
            with contextlib.suppress(OSError):
                return h5py.File(path, "r", locking=other), other
        raise
