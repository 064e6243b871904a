"""What can be told before anything is computed: lines too short, anchors that float, hulls that sink."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import dist, prod
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import JoinedEnd, held_place
from lumpedcable.scene.environment import Fluid
from lumpedcable.scene.joints import Side
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import SIDES, Problem
from lumpedcable.scene.units import format_quantity

__all__ = ["hull_problems", "rod_problems"]

SLACK = 1e-3  # share of its length that an inextensible line may seem short of, by rounded numbers
Lines = Mapping[str, Line | None]
OTHER = {"start": "end", "end": "start"}


def rod_problems(
    lines: Lines, bodies: Mapping[str, Any], materials: Mapping[str, Any], fluid: Fluid | None
) -> Iterator[Problem]:
    """Yield paths of inextensible lines that do not reach, and bodies on the bed that would float."""
    for name, body in bodies.items():
        lying = isinstance(body, Body) and body.friction is not None and body.bearing is None
        if isinstance(body, Body) and lying and body.volume and fluid:
            carried = fluid.density * body.volume
            if carried >= body.mass:
                yield Problem(
                    ("bodies", name, "mass"),
                    "expected a body with friction to lie on the bed, heavier than the water that it "
                    f"displaces ({carried:g} kg), found {body.mass:g} kg",
                )
    told: set[Side] = set()
    for name, line in lines.items():
        if line is None or getattr(materials.get(line.material), "law", None) != "inextensible":
            continue
        for side in SIDES:
            if (name, side) not in told:
                yield from _too_short(lines, bodies, materials, (name, side), told)


def hull_problems(
    bodies: Mapping[str, Any], water: Fluid | None, depth: float | None
) -> Iterator[Problem]:
    """Yield hulls that are heavier than the water that their boxes displace, or aground.

    The waves of the scene are on water of that `depth` (m), None: deep, or none.
    """
    for name, body in bodies.items():
        if water is None or not isinstance(body, Body) or body.hull is None or body.size is None:
            continue
        most = water.density * prod(body.size)
        if body.mass >= most:
            yield Problem(
                ("bodies", name, "mass"),
                "expected a hull to float, lighter than the water that its whole box displaces "
                f"({format_quantity(most, 'kg')}), found {format_quantity(body.mass, 'kg')}",
            )
        draught = body.draught(water.density)
        if depth is not None and body.mass < most and draught >= depth:
            yield Problem(
                ("sea", "depth"),
                f"expected more than the draught of {name}, {format_quantity(draught, 'm')}, found "
                f"{format_quantity(depth, 'm')}",
            )


def _too_short(
    lines: Lines,
    bodies: Mapping[str, Any],
    materials: Mapping[str, Any],
    first: Side,
    told: set[Side],
) -> Iterator[Problem]:
    """The lines from an end with a place to the next, if they are shorter than the way between.

    Those with EA stretch, by at most the half that other laws are used for.
    """
    start, here, length, reach = _placed(lines, bodies, first), first, 0.0, 0.0
    passed: list[str] = []
    while start is not None and here[0] not in passed:
        line = lines[here[0]]
        if line is None or isinstance(line.length, str):
            return
        passed.append(here[0])
        length += line.length
        rigid = getattr(materials.get(line.material), "EA", None) is None
        reach += line.length * (1.0 + (SLACK if rigid else materials[line.material].max_strain))
        last = here[0], OTHER[here[1]]
        end = _placed(lines, bodies, last)
        if end is not None:
            told |= {first, last}
            if dist(start, end) > reach:
                yield Problem(
                    ("lines", passed[-1], "length"),
                    f"expected inextensible lines that reach over the {dist(start, end):.6g} m "
                    f"between their ends, found {length:.6g} m of {', '.join(passed)}",
                )
            return
        beside = _joined(lines, last)
        if beside is None:
            return
        here = beside


def _placed(lines: Lines, bodies: Mapping[str, Any], side: Side) -> tuple[float, ...] | None:
    """Where an end is at the start (m), None if that follows from the statics."""
    line = lines[side[0]]
    end = None if line is None else getattr(line, side[1])
    if (place := held_place(end)) is not None:
        return place
    if isinstance(end, str) and "." in end:
        name, point = end.split(".", 1)
        body = bodies.get(name)
        if isinstance(body, Body) and point in body.points and body.position is not None:
            if any(body.attitude or ()):
                return None
            return tuple(a + b for a, b in zip(body.position, body.points[point], strict=True))
    return None


def _joined(lines: Lines, side: Side) -> Side | None:
    """The one end that is joined to an end, None if there is none or more than one."""
    found: set[Side] = set()
    for name, line in lines.items():
        for which in SIDES if line is not None else ():
            told = _partner(getattr(line, which))
            if told == side:
                found.add((name, which))
            if (name, which) == side and told is not None and told[0] in lines:
                found.add(told)
    return found.pop() if len(found) == 1 else None


def _partner(end: Any) -> Side | None:
    """The end that an end says it is joined to."""
    text = end.joined if isinstance(end, JoinedEnd) else end
    if not isinstance(text, str) or "." not in text:
        return None
    name, side = text.rsplit(".", 1)
    return (name, side) if side in OTHER else None
