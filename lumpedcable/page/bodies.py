"""Rigid bodies on the page: boxes of their size in their attitude, balls where the size is unknown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from lumpedcable.page.pack import Pack
from lumpedcable.results.reader import ResultFile

__all__ = ["moved_bodies", "quaternion"]


def quaternion(attitude: ArrayLike) -> NDArray[np.float64]:
    """Unit quaternions w, x, y, z, shape (..., 4), of roll, pitch, yaw (rad), shape (..., 3).

    Turned by roll about x first, then pitch about y, then yaw about z, axes of the scene; NaN where
    the attitude is.
    """
    angles = np.asarray(attitude, float)
    known = np.isfinite(angles).all(axis=-1, keepdims=True)
    flat = np.where(known, angles, 0.0).reshape(-1, 3)
    found = Rotation.from_euler("xyz", flat).as_quat(scalar_first=True)
    found = found.reshape(*angles.shape[:-1], 4)
    return np.where(known, found, np.nan)


def moved_bodies(
    result: ResultFile,
    runs: NDArray[Any],
    times: NDArray[Any],
    scene: Mapping[str, Any],
    pack: Pack,
) -> list[dict[str, Any]]:
    """The bodies that a file follows.

    Args:
        result: the open file.
        runs: the runs shown.
        times: indices of the saved times shown.
        scene: tables of the scene in SI numbers.
        pack: takes the arrays: x, y, z of (run, frame) in m, and w, x, y, z of the attitude.

    Returns:
        One table per body: name, size (length, breadth, height in m) or None, and its arrays.
    """
    found = []
    for name in result.bodies:
        size = (scene.get("bodies") or {}).get(name, {}).get("size")
        body: dict[str, Any] = {"name": name, "size": size if isinstance(size, list) else None}
        for quantity in ("position", "attitude"):
            values = np.array([result.body(name, quantity, int(run))[times] for run in runs])
            if quantity == "attitude":
                values = _continuous(quaternion(values))
            body[quantity] = [pack.field(part) for part in np.moveaxis(values, -1, 0)]
        found.append(body)
    return found


def _continuous(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same turns, (run, frame, 4), with signs such that neighbours in time can be mixed."""
    steps = np.sum(turns[:, 1:] * turns[:, :-1], axis=-1)
    signs = np.cumprod(np.where(steps < 0.0, -1.0, 1.0), axis=1)
    return np.concatenate([turns[:, :1], turns[:, 1:] * signs[..., None]], axis=1)
