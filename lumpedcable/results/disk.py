"""The file system below results files: what it refuses is told in a line, and HDF5 survives it.

Where HDF5 fails to write while it closes a file or a dataset, it frees what belongs to it, but not its
number, and comes back to it when the process ends: a segmentation fault. So such writes must not fail.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import h5py

from lumpedcable.results import human
from lumpedcable.results.errors import DiskError, OutputError

__all__ = ["check_room", "close", "create", "prepare", "reported", "sink", "sync_folder"]

_SPENT = {errno.ENOSPC, errno.EFBIG, errno.EIO, errno.EROFS, getattr(errno, "EDQUOT", None)}
"""What ails a disk and not a file: another one would not be written either."""


def create(path: Path) -> h5py.File:
    """A new HDF5 file, which must not be there.

    Values go to the disk when they are written, and not when their dataset is let go: there nobody
    could tell that it is full.
    """
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_EARLIEST, h5py.h5f.LIBVER_LATEST)
    access.set_sieve_buf_size(0)
    return h5py.File(h5py.h5f.create(os.fsencode(path), h5py.h5f.ACC_EXCL, fapl=access))


def close(file: h5py.File) -> None:
    """Close a file, whatever becomes of what is not yet written."""
    try:
        file.flush()
    except (OSError, ValueError, RuntimeError):  # one of the three, by the call
        sink(file)
    with contextlib.suppress(OSError, RuntimeError):  # memory has no room either
        file.close()


def sink(file: h5py.File) -> None:
    """Let HDF5 write from now on into memory, which takes it: what is on the disk stays as it is."""
    with _nowhere() as other:
        os.dup2(other, file.id.get_vfd_handle(), inheritable=False)


@contextlib.contextmanager
def _nowhere() -> Iterator[int]:
    """A file in memory without a name, or in the system's own folder where there are none."""
    if hasattr(os, "memfd_create"):
        number = os.memfd_create("lost")
        try:
            yield number
        finally:
            os.close(number)
    else:
        with tempfile.TemporaryFile() as file:
            yield file.fileno()


def prepare(target: Path, partial: Path, overwrite: bool) -> None:
    """Make the folder and clear the temporary name, or say why that cannot be."""
    with reported(target):
        if target.is_dir():
            raise OutputError(f"cannot write {target}: it is a folder")
        if target.exists() and not overwrite:
            raise OutputError(f"cannot write {target}: it exists already")
        target.parent.mkdir(parents=True, exist_ok=True)
        if partial.exists():
            try:
                h5py.File(partial, "r").close()
            except BlockingIOError:
                raise OutputError(f"cannot write {target}: another run is writing it") from None
            except OSError:
                pass  # an unreadable leftover
            partial.unlink()


def check_room(target: Path, needed: int) -> None:
    """Refuse what the disk cannot hold, before the disk is filled to find out."""
    free = shutil.disk_usage(target.parent).free
    if needed > free:
        sizes = f"{human.size(needed)}, {human.size(free)} are free"
        raise DiskError(f"cannot write {target}: the results take {sizes}")


@contextlib.contextmanager
def reported(path: Path) -> Iterator[None]:
    """Turn a failure of the file system into one line for the user."""
    try:
        yield
    except (OSError, ValueError, RuntimeError) as error:
        # HDF5 raises one of the three, by the call, and buries the system's reason in its own trace
        number = getattr(error, "errno", None)
        found = re.search(r"errno = (\d+)", str(error))
        number = number or (int(found[1]) if found else None)
        if number is None and not isinstance(error, OSError):
            raise
        reason = os.strerror(number) if number else str(error).splitlines()[0]
        kind = DiskError if number in _SPENT else OutputError
        raise kind(f"cannot write {path}: {reason}") from error


def sync_folder(folder: Path) -> None:
    """Make the renaming itself durable, where the system can open folders."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
