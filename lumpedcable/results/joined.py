"""Datasets that show what lies in several files as one (HDF5's virtual datasets)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py

__all__ = ["joined"]


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
