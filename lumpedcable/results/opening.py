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
    first = _ways(path)[0]
    try:
        return h5py.File(path, "r", locking=first)
    except (FileNotFoundError, PermissionError, IsADirectoryError):
        raise
    except OSError:
        for other in _ways(path)[1:]:
            with contextlib.suppress(OSError):
                return h5py.File(path, "r", locking=other)
        raise


def how_locked(path: Path) -> Lock:
    """What to ask of locks for the file to open, as `read_only` does.

    Raises:
        OSError: it cannot be opened.
    """
    for way in _ways(path):
        with contextlib.suppress(OSError):
            h5py.File(path, "r", locking=way).close()
            return way
    read_only(path).close()  # says why not
    return None


def _ways(path: Path) -> tuple[Lock, ...]:
    return (False, None, True) if path.name.endswith(PARTIAL_SUFFIX) else (None, False, True)
