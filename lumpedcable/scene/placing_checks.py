"""Whether the places that a scene gives can be: none under the bed, one for ends that are joined."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import dist, hypot
from typing import Any

import numpy as np

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import post_of, reel_key
from lumpedcable.scene.ends import (
    FixedEnd,
    HarmonicMotion,
    HeldEnd,
    HeldPosition,
    JoinedEnd,
    MovingEnd,
    tie_of,
)
from lumpedcable.scene.environment import Seabed
from lumpedcable.scene.lines import Line
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.part import SIDES, Path, Problem
from lumpedcable.scene.units import format_quantity

__all__ = [
    "bearing_problems",
    "below_problems",
    "joined_problems",
    "lying_problems",
    "settling_problems",
]

SAME = 1e-9  # share of a place by which it may differ from itself, by rounding
LIES = 0.1  # share of its height that a body on the bed may be above or in it
SINKS = 2.0  # times as deep as its weight pushes it a corner may start in the bed that bears it
Lines = Mapping[str, Line | None]


def below_problems(lines: Lines, bodies: Mapping[str, Any], seabed: Seabed) -> Iterator[Problem]:
    """Yield the places where an end or a body starts below the bed."""
    places: list[tuple[Path, tuple[float, ...]]] = []
    for name, line in lines.items():
        for side in SIDES if line is not None else ():
            path, place = _place(getattr(line, side))
            if place is not None:
                places.append((("lines", name, side, *path), place))
    for name, body in bodies.items():
        if isinstance(body, Body | MovedBody) and body.position is not None:
            places.append((("bodies", name, "position"), body.position))
    for path, place in places:
        bed = seabed.height_at(place[0])
        if place[2] < bed:
            yield Problem(
                (*path, 2),
                f"expected {format_quantity(bed, 'm')} or more, the height of the "
                f"seabed, found {format_quantity(place[2], 'm')}",
            )


def lying_problems(bodies: Mapping[str, Any], seabed: Seabed) -> Iterator[Problem]:
    """Yield boxes with friction that are neither on the bed nor a little above or in it."""
    for name, body in bodies.items():
        if not isinstance(body, Body) or body.friction is None or body.bearing is not None:
            continue
        if body.size is None or body.position is None or any(body.attitude or ()):
            continue  # its bottom is not known, or of one that is turned no plane
        bed, half = seabed.height_at(body.position[0]), 0.5 * body.size[2]
        bottom = body.position[2] - half
        if abs(bottom - bed) > LIES * body.size[2]:
            yield Problem(
                ("bodies", name, "position", 2),
                "expected a body with friction to lie on the bed, its bottom (position less half its "
                f"height) at {format_quantity(bed, 'm')}, found that at {format_quantity(bottom, 'm')}; "
                f"change position to {format_quantity(bed + half, 'm')} or seabed.height",
            )


def bearing_problems(
    bodies: Mapping[str, Any], seabed: Seabed, gravity: float | None
) -> Iterator[Problem]:
    """Yield boxes that start so deep in the bed that bears them that it would throw them out."""
    for name, body in bodies.items():
        if not isinstance(body, Body) or body.bearing is None or body.hull is not None:
            continue
        if body.size is None or body.position is None or body.settle:
            continue
        corners = body.corners
        beds = [seabed.height_at(float(x)) for x in corners[:, 0]]
        deepest = int(np.argmax(np.asarray(beds) - corners[:, 2]))
        bed, found = beds[deepest], float(corners[deepest, 2])
        sinks = SINKS * body.mass * (gravity or 0.0) / body.bearing
        if found < bed - sinks - SAME * hypot(*body.position):
            yield Problem(
                ("bodies", name, "position", 2),
                f"expected its deepest corner on the bed, at {format_quantity(bed, 'm')}, or above it, "
                f"found that at {format_quantity(found, 'm')}; change position to "
                f"{format_quantity(body.position[2] + bed - found, 'm')} or seabed.height",
            )


def joined_problems(lines: Lines) -> Iterator[Problem]:
    """Yield the places of joined ends that are not where another end at their joint is held."""
    ends = {
        f"{name}.{side}": getattr(line, side)
        for name, line in lines.items()
        if line is not None
        for side in SIDES
    }
    met: dict[str, set[str]] = {}
    for name, end in ends.items():
        tie = tie_of(end)
        together = {name} | met.get(name, set())
        if tie is not None:
            together |= {tie} | met.get(tie, set())
        met |= dict.fromkeys(together, together)
    told: set[str] = set()
    for name, end in ends.items():
        if not isinstance(end, JoinedEnd) or end.at is None:
            continue
        told.add(name)
        for other in sorted(met[name] & ends.keys() - {name}):
            place = _held(ends[other])
            first = isinstance(ends[other], JoinedEnd) and other not in told
            if place is None or first or dist(place, end.at) <= SAME * (1.0 + hypot(*place)):
                continue  # of two ends that are joined the second one is told
            line, side = name.rsplit(".", 1)
            yield Problem(
                ("lines", line, side, "at"),
                f'expected the place of "{other}", which meets it: {_words(place)}, '
                f"found {_words(end.at)}",
            )
            break


def _words(place: tuple[float, ...]) -> str:
    return f"[{', '.join(format_quantity(x, 'm') for x in place)}]"


def _held(end: Any) -> tuple[float, ...] | None:
    """Return where an end is while the start state is found (m), where the scene itself says it."""
    return None if isinstance(end, MovingEnd) else _place(end)[1]


def _place(end: Any) -> tuple[Path, tuple[float, ...] | None]:
    """Return where an end starts, as far as the scene says it, and the keys that say it."""
    if isinstance(end, FixedEnd):
        return ("fixed",), end.fixed
    if isinstance(end, HeldEnd) and isinstance(end.held, HeldPosition):
        return ("held", "position"), end.held.position
    if isinstance(end, MovingEnd) and isinstance(end.motion, HarmonicMotion):
        return ("motion", "position"), end.motion.position
    if (reel := reel_key(end)) is not None and not isinstance(post := post_of(end), str):
        return (reel, "at"), post
    if isinstance(end, JoinedEnd):
        return ("at",), end.at
    return (), None


def settling_problems(
    bodies: Mapping[str, Any],
    lines: Mapping[str, Line | None],
    materials: Mapping[str, Any],
) -> Iterator[Problem]:
    """Yield what stands in the way of statics that finds where bodies are at rest."""
    told = None
    rods = [n for n, x in lines.items() if x and _law(materials.get(x.material)) == "inextensible"]
    if rods:
        told = f'expected lines with a law of tension, found the inextensible "{rods[0]}"'
    for name, body in bodies.items():
        if not isinstance(body, Body) or not body.settle:
            continue
        if told is not None:
            yield Problem(("bodies", name, "settle"), f"{told}, where a body settles")
        elif body.friction is not None and body.bearing is None:
            yield Problem(
                ("bodies", name, "settle"),
                "expected a body without friction, found one that friction can hold anywhere",
            )


def _law(material: Any) -> str | None:
    return getattr(material, "law", None)
