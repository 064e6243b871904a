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
    ships: Mapping[str, tuple[NDArray[Any], NDArray[Any]]],
    runs: NDArray[Any],
    times: NDArray[Any],
    scene: Mapping[str, Any],
    pack: Pack,
) -> list[dict[str, Any]]:
    """The bodies that a file follows, and the ships that are moved.

    Args:
        result: the open file.
        ships: place (m) and attitude (rad) of others at all its times, (run, time, 3).
        runs: the runs shown.
        times: indices of the saved times shown.
        scene: tables of the scene in SI numbers.
        pack: takes the arrays: x, y, z of (run, frame) in m, and w, x, y, z of the attitude.

    Returns:
        One table per solid: name, size (length, breadth, height in m) or None, the points of a ship
        (m, in its axes), and its arrays. Cargo that swings is a solid of its own under its trolley.
    """
    told = scene.get("bodies") or {}
    found = []
    for name in result.bodies:
        places, angles = (
            np.array([result.body(name, quantity, int(run))[times] for run in runs])
            for quantity in ("position", "attitude")
        )
        own = told.get(name, {})
        if isinstance(own.get("depth"), int | float):
            found.append(_solid(f"trolley of {name}", {}, places, angles, pack))
            places = places + _turned(angles, [0.0, 0.0, -float(own["depth"])])
        found.append(_solid(name, own, places, angles, pack))
    for name, (places, angles) in ships.items():
        found.append(_solid(name, told.get(name, {}), places[:, times], angles[:, times], pack))
    return found


def _solid(
    name: str, told: Mapping[str, Any], places: NDArray[Any], angles: NDArray[Any], pack: Pack
) -> dict[str, Any]:
    """A solid of (run, frame, 3) places and angles, with what the scene tells of it."""
    size, points = told.get("size"), told.get("points")
    turns = _continuous(quaternion(angles))
    return {
        "name": name,
        "size": size if isinstance(size, list) else None,
        "points": list(points.values()) if isinstance(points, dict) and "motion" in told else [],
        "position": [pack.field(part) for part in np.moveaxis(places, -1, 0)],
        "attitude": [pack.field(part) for part in np.moveaxis(turns, -1, 0)],
    }


def _turned(angles: NDArray[Any], way: ArrayLike) -> NDArray[np.float64]:
    """A vector in the axes of a body turned by roll, pitch, yaw (..., 3), in those of space."""
    known = np.isfinite(angles).all(axis=-1, keepdims=True)
    flat = np.where(known, angles, 0.0).reshape(-1, 3)
    return Rotation.from_euler("xyz", flat).apply(way).reshape(angles.shape)


def _continuous(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same turns, (run, frame, 4), with signs such that neighbours in time can be mixed."""
    steps = np.sum(turns[:, 1:] * turns[:, :-1], axis=-1)
    signs = np.cumprod(np.where(steps < 0.0, -1.0, 1.0), axis=1)
    return np.concatenate([turns[:, :1], turns[:, 1:] * signs[..., None]], axis=1)
