"""Rigid bodies on the page: boxes of their size in their attitude, balls where the size is unknown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from lumpedcable.page.pack import Pack
from lumpedcable.results.reader import ResultFile

__all__ = ["moved_bodies", "posts_of", "quaternion", "size_of", "solids_of", "turned"]


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
    scenes: Sequence[Mapping[str, Any]],
    pack: Pack,
) -> list[dict[str, Any]]:
    """The bodies that a file follows, and the ships that are moved.

    Args:
        result: the open file.
        ships: place (m) and attitude (rad) of others at all its times, (run, time, 3).
        runs: the runs shown.
        times: indices of the saved times shown.
        scenes: tables of the scene of each run in SI numbers.
        pack: takes the arrays: x, y, z of (run, frame) in m, and w, x, y, z of the attitude.

    Returns:
        One table per solid: name, size (length, breadth, height in m) or None and the points of a ship
        (m, in its axes), each by run, and its arrays. Cargo that swings is a solid of its own under its
        trolley.
    """
    ways = {
        name: tuple(
            np.array([result.body(name, quantity, int(run))[times] for run in runs])
            for quantity in ("position", "attitude")
        )
        for name in result.bodies
    }
    ways |= {name: (place[:, times], angles[:, times]) for name, (place, angles) in ships.items()}
    drawn = [
        list(solids_of({name: tuple(way[k] for way in both) for name, both in ways.items()}, scene))
        for k, scene in enumerate(scenes)
    ]
    return [_solid(list(each), pack) for each in zip(*drawn, strict=True)]


def solids_of(
    ways: Mapping[str, tuple[NDArray[Any], ...]], scene: Mapping[str, Any]
) -> Iterator[tuple[str, Mapping[str, Any], NDArray[Any], NDArray[Any]]]:
    """Name, what the scene tells of it, places and angles of everything that is drawn as a solid.

    Args:
        ways: by body, its places (m) and angles (rad), each (..., 3).
        scene: tables of the scene in SI numbers.
    """
    bodies = scene.get("bodies") or {}
    for name, (places, angles) in ways.items():
        told = bodies.get(name, {})
        if isinstance(told.get("depth"), int | float):
            yield f"trolley of {name}", {}, places, angles
            places = places + turned(angles, [0.0, 0.0, -float(told["depth"])])
        yield name, told, places, angles


def posts_of(told: Mapping[str, Any]) -> list[Any]:
    """The points (m, in its axes) that a moved ship has posts at."""
    points = told.get("points")
    return list(points.values()) if isinstance(points, dict) and "motion" in told else []


def size_of(told: Mapping[str, Any]) -> list[Any] | None:
    """Length, breadth and height (m) of a body, None where the scene does not tell."""
    size = told.get("size")
    return size if isinstance(size, list) else None


def _solid(
    runs: list[tuple[str, Mapping[str, Any], NDArray[Any], NDArray[Any]]], pack: Pack
) -> dict[str, Any]:
    """A solid of (frame, 3) places and angles in each run, with what its scene tells of it."""
    names, told, places, angles = zip(*runs, strict=True)
    turns = _continuous(quaternion(np.array(angles)))
    return {
        "name": names[0],
        "size": [size_of(one) for one in told],
        "points": [posts_of(one) for one in told],
        "position": [pack.field(part) for part in np.moveaxis(np.array(places), -1, 0)],
        "attitude": [pack.field(part) for part in np.moveaxis(turns, -1, 0)],
    }


def turned(angles: NDArray[Any], way: ArrayLike) -> NDArray[np.float64]:
    """A vector in the axes of a body turned by roll, pitch, yaw (..., 3), in those of space."""
    known = np.isfinite(angles).all(axis=-1, keepdims=True)
    flat = np.where(known, angles, 0.0).reshape(-1, 3)
    return Rotation.from_euler("xyz", flat).apply(way).reshape(angles.shape)


def _continuous(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same turns, (run, frame, 4), with signs such that neighbours in time can be mixed."""
    steps = np.sum(turns[:, 1:] * turns[:, :-1], axis=-1)
    signs = np.cumprod(np.where(steps < 0.0, -1.0, 1.0), axis=1)
    return np.concatenate([turns[:, :1], turns[:, 1:] * signs[..., None]], axis=1)
