"""The file system below results files: what it refuses is told in a line, and HDF5 survives it.

Where HDF5 fails to write while it closes a file or a dataset, it frees what belongs to it, but not its
number, and comes back to it when the process ends: a segmentation fault. So such writes must not fail.

A file in the making is locked by whoever writes it, which HDF5 does where it can. A lock ends with its
process, so that a temporary name without one is a leftover.
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
from lumpedcable.results.errors import BusyError, DiskError, OutputError, first_line

try:
    import fcntl
except ImportError:  # Windows, which deletes no file that somebody has opened
    fcntl = None

__all__ = [
    "check_room",
    "close",
    "create",
    "is_named",
    "let_go",
    "make_folder",
    "prepare",
    "reopen",
    "reported",
    "sink",
    "sync_folder",
]

_SPENT = {errno.ENOSPC, errno.EFBIG, errno.EIO, errno.EROFS, getattr(errno, "EDQUOT", None)}
"""What ails a disk and not a file: another one would not be written either."""


def create(path: Path) -> h5py.File:
    """A new HDF5 file, which must not be there.

    Raises:
        BlockingIOError: another process has made it first.
    """
    try:
        file = h5py.File(h5py.h5f.create(os.fsencode(path), h5py.h5f.ACC_EXCL, fapl=_access()))
    except OSError as error:
        if "file exists" in str(error).lower():
            raise BlockingIOError(errno.EAGAIN, "made by another process", str(path)) from None
        raise
    if not is_named(file, path):  # taken for a leftover before it was locked
        close(file)
        raise BlockingIOError(errno.EAGAIN, "deleted by another process", str(path))
    return file


def reopen(path: Path) -> h5py.File:
    """A file that another process has left unfinished, to go on with.

    Raises:
        BlockingIOError: a process writes it.
    """
    return h5py.File(h5py.h5f.open(os.fsencode(path), h5py.h5f.ACC_RDWR, fapl=_access()))


def _access() -> h5py.h5p.PropFAID:
    """How files in the making are opened.

    Values go to the disk when they are written, and not when their dataset is let go: there nobody
    could tell that it is full.
    """
    access = h5py.h5p.create(h5py.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5py.h5f.LIBVER_EARLIEST, h5py.h5f.LIBVER_LATEST)
    access.set_sieve_buf_size(0)
    return access


def is_named(file: h5py.File, path: Path) -> bool:
    """Whether a name still is that of an open file: no other process has deleted or replaced it."""
    return _same(file.id.get_vfd_handle(), path)


def _same(number: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(number), os.stat(path))
    except FileNotFoundError:
        return False


def close(file: h5py.File) -> None:
    """Close a file, whatever becomes of what is not yet written."""
    try:
        file.flush()
    except (OSError, ValueError, RuntimeError):  # one of the three, by the call
        sink(file)
    with contextlib.suppress(OSError, RuntimeError):  # memory has no room either
        file.close()


@contextlib.contextmanager
def let_go(file: h5py.File) -> Iterator[None]:
    """Close a file, and keep its lock while its temporary name is renamed or deleted.

    Without it another process may take the name for a leftover, and put its own file there.
    """
    lock = os.dup(file.id.get_vfd_handle()) if fcntl else None
    try:
        close(file)
        yield
    finally:
        if lock is not None:
            os.close(lock)


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


def make_folder(target: Path) -> None:
    """Make the folder of a file, or say why that cannot be."""
    with reported(target):
        target.parent.mkdir(parents=True, exist_ok=True)


def prepare(target: Path, partial: Path, overwrite: bool) -> None:
    """Clear the temporary name, or say why a file cannot be written there."""
    with reported(target):
        if target.is_dir():
            raise OutputError(f"cannot write {target}: it is a folder")
        if target.exists() and not overwrite:
            raise OutputError(f"cannot write {target}: it exists already")
        with contextlib.suppress(FileNotFoundError):
            _clear(partial)


def _clear(partial: Path) -> None:
    """Delete what a process has left unfinished; BlockingIOError where one writes it."""
    if fcntl is None:
        try:
            partial.unlink()
        except PermissionError:
            raise BlockingIOError(errno.EAGAIN, "opened by another process", str(partial)) from None
        return
    number = os.open(partial, os.O_RDWR if os.access(partial, os.W_OK) else os.O_RDONLY)
    try:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:
            pass  # this disk has no locks
        if not _same(number, partial):
            raise BlockingIOError(errno.EAGAIN, "replaced by another process", str(partial))
        partial.unlink()
    finally:
        os.close(number)


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
    except BlockingIOError as error:
        raise BusyError(f"cannot write {path}: another run is writing it") from error
    except (OSError, ValueError, RuntimeError) as error:
        # HDF5 raises one of the three, by the call, and buries the system's reason in its own trace
        number = getattr(error, "errno", None)
        found = re.search(r"errno = (\d+)", str(error))
        number = number or (int(found[1]) if found else None)
        if number is None and not isinstance(error, OSError):
            raise
        reason = os.strerror(number) if number else first_line(error)
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
