"""How high the water's surface is: what tells of it must agree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from math import isclose, prod
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.environment import Fluid, PowerCurrent, Sea, Seabed
from lumpedcable.scene.part import Path, Problem
from lumpedcable.scene.units import format_quantity

__all__ = ["depth_problems", "leaving_problems", "surface_problems", "surfaces"]

Parts = Mapping[str, Any]

SAME = 1e-9  # relative, and in m: what conversions of units leave
ROUNDED = 0.01  # share by which a volume of few digits may exceed that of a box
OFF = 0.1  # share of a depth by which that of waves may miss that over the bed


def surfaces(
    bodies: Mapping[str, Any], water: Fluid | None, sea: Sea | None
) -> Iterator[tuple[Path, float]]:
    """Yield each key that tells of the surface at rest, and its height z in m.

    What the scene does not say of one of them is as the first says that there is.
    """
    current, flow = water and water.current, sea and sea.flow
    tellers: dict[Path, Any] = {("water",): water}
    if isinstance(current, PowerCurrent):
        tellers["water", "current"] = current
    tellers["sea", "flow"] = flow
    for name, body in bodies.items():
        if isinstance(body, Body):
            tellers["bodies", name, "hull"] = body.hull
    for path, part in tellers.items():
        if part is not None and part.surface is not None:
            yield (*path, "surface"), part.surface


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


def depth_problems(
    bodies: Mapping[str, Any], water: Fluid | None, sea: Sea | None, seabed: Seabed
) -> Iterator[Problem]:
    """Yield a depth of the waves' water that is nowhere that over the bed."""
    if sea is None or sea.depth is None:
        return
    level = next((height for _, height in surfaces(bodies, water, sea)), None)
    if level is None and sea.flow is None:
        return  # nobody says where the surface is
    level = 0.0 if level is None else level
    deep = [level - seabed.height_at(x) for x in (seabed.profile.x if seabed.profile else (0.0,))]
    least, most = min(deep), max(deep)
    if not (1.0 - OFF) * least <= sea.depth <= (1.0 + OFF) * most:
        bed = format_quantity(least, "m")
        bed += f" to {format_quantity(most, 'm')}" if most > least else ""
        yield Problem(
            ("sea", "depth"),
            f"expected the depth of the water over the seabed, {bed} (its surface is at "
            f"{format_quantity(level, 'm')}), found {format_quantity(sea.depth, 'm')}",
        )


def leaving_problems(
    lines: Parts, bodies: Parts, materials: Parts, others: Parts, named: Set[str]
) -> Iterator[Problem]:
    """Yield what does not go with water that ends at a surface.

    Args:
        lines, bodies, materials: by name, None where one could not be read.
        others: the single parts that could be read, by key.
        named: the keys of all single parts, readable or not.
    """
    air, water = others.get("air"), others.get("water")
    if air is not None and air.surface is not None:
        yield Problem(("air", "surface"), "expected no surface of the air, found one")
    if water is None or water.surface is None:
        return
    if "gravity" not in named:
        yield Problem(
            ("water", "surface"), "expected gravity where water has a surface, found none"
        )
    for name, line in lines.items():
        if line is None or line.diameter is None:
            continue
        material = materials.get(line.material)
        if material is not None and material.law == "inextensible":
            yield Problem(
                ("lines", name, "material"),
                "expected an elastic material of a line that the water's surface crosses, found an "
                "inextensible one (without water.surface it is under water as a whole)",
            )
    sea = others.get("sea")
    for name, body in bodies.items():
        if not isinstance(body, Body) or body.hull is not None:
            continue  # a hull has its own water
        if body.volume is None and body.drag is not None:
            yield Problem(
                ("bodies", name, "volume"),
                "expected the volume (m3) of a body with drag where water has a surface, found nothing",
            )
        most = None if body.size is None else prod(body.size)
        if body.volume is not None and most is not None and body.volume > (1.0 + ROUNDED) * most:
            yield Problem(
                ("bodies", name, "volume"),
                f"expected at most that of its box, {most:g} m3, of a body that floats, found "
                f"{body.volume:g} m3",
            )
        flows = sea is not None and sea.flow is not None
        if body.volume is not None and not body.rigid and flows:
            yield Problem(
                ("bodies", name, "volume"),
                "expected a rigid body where waves lift the surface of the water, found a point (with "
                'free = ["x", "y", "z"] it is one that does not turn)',
            )
