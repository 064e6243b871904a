"""The bed and the surface of the water in the scene of a results file, as pictures draw them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeGuard

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

__all__ = ["Bed", "Ground", "bed_of", "ground_of", "number_in", "tables"]

PARTS = 12  # straight parts in which each interval of a profile is drawn


class Bed(NamedTuple):
    """A bed with a profile: heights z (m) at places x (m), and its slopes (-) before and beyond them."""

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    slopes: tuple[float, float]


class Ground(NamedTuple):
    """Whether there is water, and the heights (m) of its surface and of the bed, None where unknown."""

    water: bool
    surface: float | None
    bed: float | Bed | None


def tables(text: str) -> dict[str, Any]:
    """The tables of a scene's text; none where there is no text or it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}


def ground_of(scene: Mapping[str, Any]) -> Ground:
    """What the tables of a scene in SI numbers tell of water and bed.

    The surface is drawn where the scene says how high it is, or at z = 0 where there is a bed below it,
    something floats, waves go over it or a current dies out under it; water is everywhere without them.
    """
    water, bed, sea = scene.get("water"), scene.get("seabed"), scene.get("sea")
    surface = None
    if isinstance(water, dict) or isinstance(sea, dict):
        hulls = [body.get("hull") for body in (scene.get("bodies") or {}).values()]
        flow = sea.get("flow") if isinstance(sea, dict) else None
        current = water.get("current") if isinstance(water, dict) else None
        tellers = [water, current, flow, *hulls]
        told = [number_in(t, "surface") for t in tellers if isinstance(t, dict)]
        surface = next((height for height in told if height is not None), None)
        dies_out = isinstance(current, dict) and current.get("profile") == "power"
        known = (bed, sea, *hulls, current if dies_out else None)
        if surface is None and any(isinstance(t, dict) for t in known):
            surface = 0.0
    return Ground(isinstance(water, dict), surface, _bed(bed) if isinstance(bed, dict) else None)


def bed_of(height: float, x: Sequence[float], depth: Sequence[float]) -> Bed:
    """The bed that is `depth` (m) under `height` (m) at the places x (m), as lines meet it.

    A monotone cubic (Fritsch & Butland 1984) that goes on straight at its ends.
    """
    given, deep = np.asarray(x, float), np.asarray(depth, float)
    slopes = np.diff(deep)[[0, -1]] / np.diff(given)[[0, -1]]
    beyond = np.array([-1.0, 1.0])
    wide = np.concatenate([given[:1] - 1.0, given, given[-1:] + 1.0])
    ends = deep[[0, -1]] + beyond * slopes
    curve = PchipInterpolator(wide, np.concatenate([ends[:1], deep, ends[1:]]))
    shares = np.linspace(0.0, 1.0, PARTS, endpoint=False)
    places = np.append((given[:-1, None] + np.diff(given)[:, None] * shares).ravel(), given[-1])
    return Bed(places, height - curve(places), (-float(slopes[0]), -float(slopes[1])))


def number_in(table: Mapping[str, Any], key: str) -> float | None:
    """A number of a table, None where it has none of that name."""
    value = table.get(key)
    return float(value) if _is_number(value) else None


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _bed(bed: Mapping[str, Any]) -> float | Bed | None:
    """How high the bed is (m), or its curve."""
    height, profile = number_in(bed, "height"), bed.get("profile")
    if height is None or not isinstance(profile, dict):
        return height
    x, depth = (list(profile.get(key) or ()) for key in ("x", "depth"))
    if (
        not all(map(_is_number, [*x, *depth]))
        or not len(x) == len(depth) > 1
        or np.any(np.diff(x) <= 0.0)
    ):
        return None
    return bed_of(height, x, depth)
