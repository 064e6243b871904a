"""How high the water's surface is: what tells of it must agree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isclose
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.environment import Fluid, PowerCurrent, Sea
from lumpedcable.scene.part import Path, Problem
from lumpedcable.scene.units import format_quantity

__all__ = ["surface_problems", "surfaces"]

SAME = 1e-9  # relative, and in m: what conversions of units leave


def surfaces(
    bodies: Mapping[str, Any], water: Fluid | None, sea: Sea | None
) -> Iterator[tuple[Path, float]]:
    """Yield each key that tells of the surface at rest, and its height z in m."""
    current = None if water is None else water.current
    if isinstance(current, PowerCurrent):
        yield ("water", "current", "surface"), current.surface
    if sea is not None and sea.flow is not None:
        yield ("sea", "flow", "surface"), sea.flow.surface
    for name, body in bodies.items():
        if isinstance(body, Body) and body.hull is not None:
            yield ("bodies", name, "hull", "surface"), body.hull.surface


def surface_problems(
    bodies: Mapping[str, Any], water: Fluid | None, sea: Sea | None
) -> Iterator[Problem]:
    """Yield heights of the surface that are not those of the first."""
    told = list(surfaces(bodies, water, sea))
    for path, height in told[1:]:
        first = told[0]
        if not isclose(height, first[1], rel_tol=SAME, abs_tol=SAME):
            yield Problem(
                path,
                f"expected {format_quantity(first[1], 'm')}, the height of the water's surface in "
                f"{'.'.join(map(str, first[0]))}, found {format_quantity(height, 'm')}",
            )
