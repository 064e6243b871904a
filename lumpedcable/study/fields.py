"""The fields of lines and bodies as a results file holds them."""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import part_names

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["BODY_FIELDS", "FIELDS", "TIPS", "body_fields", "sized", "tip_of", "tip_start"]


class Field(NamedTuple):
    """A quantity along a line: of its nodes or segments, a vector or a number, its unit and words."""

    of: str
    vector: bool
    unit: str
    text: str


FIELDS = {
    "position": Field("node", True, "m", "position"),
    "velocity": Field("node", True, "m/s", "velocity"),
    "tension": Field("segment", False, "N", "tension, damping included"),
    "strain": Field("segment", False, "1", "strain"),
    "bending_moment": Field("node", False, "N m", "bending moment"),
}
TIPS = {
    "position": ("m", "place of the {} of the line"),
    "velocity": ("m/s", "velocity of the {} of the line"),
}
BODY_FIELDS = {
    "position": ("xyz", "m", "place of the {}"),
    "velocity": ("xyz", "m/s", "velocity of the {}"),
    "attitude": ("angle", "rad", "roll, pitch, yaw"),
    "turning": ("angle", "rad/s", "rates of roll, pitch, yaw"),
}


def body_fields(coordinates: Coordinates, q, v) -> dict[str, NDArray[np.float64]]:
    """Places (m), velocities (m/s), angles (rad) and their rates from q and v (runs, times, m)."""
    d = coordinates.dimensions
    found = {}
    for places, angles, values in (("position", "attitude", q), ("velocity", "turning", v)):
        found[places] = coordinates.expand(values[..., :d], 2, place=places == "position")
        turned = values[..., d:]
        if d == 2:
            turned = turned * coordinates.normal
        found[angles] = turned if d > 1 else np.zeros((*values.shape[:-1], 3))
    return found


def tip_of(end: str, lines: Container[str]) -> tuple[str, str]:
    """Line and side of an end in the file, which has `lines`: of a line that is cut one of its parts."""
    name, _, side = end.rpartition(".")
    return name if name in lines else part_names(name)[side == "end"], side


def tip_start(places: NDArray[np.float64], side: str) -> NDArray[np.float64]:
    """Where an end starts (m), (runs, 3); `places` (runs, 3, nodes), filled up with NaN at the end."""
    last = np.isfinite(places[:, 0]).sum(axis=1) - 1 if side == "end" else 0
    return places[np.arange(len(places)), :, last]


def sized(table: NDArray[Any], axis: int, size: int) -> NDArray[Any]:
    """An axis filled up with NaN to `size`, where another run of the study has more nodes, or cut to it.

    What is cut off of a part of a line is NaN in all runs.
    """
    missing = size - table.shape[axis]
    if missing == 0:
        return table
    if missing < 0:
        return table[(slice(None),) * axis + (slice(size),)]
    widths = [(0, 0)] * table.ndim
    widths[axis] = (0, missing)
    return np.pad(table, widths, constant_values=np.nan)
