"""Numbers of the curve in which a line lies: its length, its sag."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["largest", "length", "sag"]

Array = NDArray[Any]


def length(position: Array) -> Array:
    """Sum of distances between nodes (m), from (time, node, 3); surplus nodes (NaN) add nothing."""
    steps = np.linalg.norm(np.diff(position, axis=1), axis=-1)
    return np.where(np.isfinite(steps).any(axis=1), np.nansum(steps, axis=1), np.nan)


def sag(position: Array) -> Array:
    """Largest vertical distance of the nodes below the straight line between the ends (m), (time,).

    Of those nodes over or under it; NaN where the ends stand above each other.
    """
    count = int(np.isfinite(position[0, :, 0]).sum()) or position.shape[1]
    points = position[:, :count]
    start, chord = points[:, :1], points[:, -1:] - points[:, :1]
    flat = np.sum(chord[..., :2] ** 2, axis=-1)
    along = np.sum((points - start)[..., :2] * chord[..., :2], axis=-1)
    share = np.divide(along, flat, out=np.full_like(along, np.nan), where=flat > 1e-12)
    below = start[..., 2] + share * chord[..., 2] - points[..., 2]
    return largest(np.where((share >= 0.0) & (share <= 1.0), below, np.nan))


def largest(table: Array) -> Array:
    """Largest of every row, NaN where there is none."""
    good = np.isfinite(table)
    top = np.max(table, axis=1, initial=-np.inf, where=good)
    return np.where(good.any(axis=1), top, np.nan)
