"""Datasets that show what lies in several files as one (HDF5's virtual datasets)."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from lumpedcable.results.errors import ResultError
from lumpedcable.results.folder import is_study_folder
from lumpedcable.results.opening import read_only

__all__ = ["copy_whole", "damaged", "is_whole", "joined"]

MOST_NAMED = 5
"""Damaged files that are named; of more the number is told."""
_AT_ONCE = 2**22  # numbers that are copied at once
_OF_SCALES = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}  # attributes HDF5 keeps itself


def joined(
    file: h5py.File,
    path: str,
    shape: tuple[int, ...],
    dtype: Any,
    fill: float | int | None,
    parts: Sequence[tuple[str, int]],
) -> h5py.Dataset:
    """A dataset whose rows stand in other files, at the same path; nothing is copied.

    Args:
        file: the open file that shows them.
        path: where the dataset stands, here and there.
        shape: the whole shape, runs first.
        dtype: type of its values.
        fill: what rows of a file that is not there read as.
        parts: names of the files, relative to this file's folder, and their numbers of rows.
    """
    layout, first = h5py.VirtualLayout(shape, dtype), 0
    for name, rows in parts:
        source = h5py.VirtualSource(name, "/" + path, shape=(rows, *shape[1:]), dtype=dtype)
        layout[first : first + rows] = source
        first += rows
    return file.create_virtual_dataset(path, layout, fillvalue=fill)


def copy_whole(source: Path, target: Path) -> None:
    """Copy a results file; what it shows of other files is in the copy itself.

    Raises:
        OSError: a file cannot be read or written.
    """
    shutil.copyfile(source, target)
    with read_only(source) as file, h5py.File(target, "r+") as copy:
        shown: list[str] = []
        file.visititems(
            lambda path, item: (
                shown.append(path) if isinstance(item, h5py.Dataset) and item.is_virtual else None
            )
        )
        for path in shown:
            _fill(copy, path, file[path])


def is_whole(file: h5py.File) -> bool:
    """Whether a results file is complete, by its own word, and all files that it shows are there.

    Raises:
        ResultError: none is, and nothing else of their study: its file has been copied alone.
    """
    status = file.get("status")
    complete = bool(file.attrs.get("complete", False))
    if not complete or not isinstance(status, h5py.Dataset) or not status.is_virtual:
        return complete
    folder = Path(file.filename).parent
    names = sorted({source.file_name for source in status.virtual_sources()})
    there = [name for name in names if (folder / name).exists() or Path(name).exists()]
    if not there and not is_study_folder(folder):
        raise ResultError(
            f"{file.filename} shows what lies in {folder / names[0]} and other files, of which "
            "none is there: move the whole folder of a study"
        )
    return len(there) == len(names)


def damaged(dataset: h5py.Dataset) -> str:
    """What is damaged, in words, where a dataset cannot be read: files that it shows, or itself."""
    folder = Path(dataset.file.filename).parent
    shown = {source.file_name for source in dataset.virtual_sources()} if dataset.is_virtual else ()
    files = [folder / name for name in sorted(shown)]
    found = [str(file) for file in files if file.exists() and not _opens(file)]
    if not found:
        return f"{dataset.file.filename}: {dataset.name} is damaged"
    if len(found) == 1:
        return f"{found[0]} is damaged; once it is deleted, lumpedcable study computes it again"
    more = f" and {len(found) - MOST_NAMED} more" if len(found) > MOST_NAMED else ""
    names = ", ".join(found[:MOST_NAMED])
    return (
        f"{names}{more} are damaged; once they are deleted, lumpedcable study computes them again"
    )


def _opens(path: Path) -> bool:
    try:
        read_only(path).close()
    except OSError:
        return False
    return True


def _fill(copy: h5py.File, path: str, whole: Any) -> None:
    """Put a dataset with the values of `whole` in the place of one that shows other files."""
    old = copy[path]
    assert isinstance(old, h5py.Dataset)
    scales = [[scale.name for scale in dim.values()] for dim in old.dims]
    known = {name: old.attrs[name] for name in old.attrs if name not in _OF_SCALES}
    # a scale knows whose it is
    for dim, names in zip(old.dims, scales, strict=True):
        for name in names:
            dim.detach_scale(copy[name])
    del copy[path]
    new = copy.create_dataset(path, whole.shape, whole.dtype, fillvalue=whole.fillvalue)
    step = max(1, _AT_ONCE // max(1, int(np.prod(whole.shape[1:]))))
    for first in range(0, whole.shape[0], step):
        new[first : first + step] = whole[first : first + step]
    new.attrs.update(known)
    for dim, names in zip(new.dims, scales, strict=True):
        for name in names:
            dim.attach_scale(copy[name])
