"""What must hold between the measures of a scene and the rest of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody
from lumpedcable.scene.carried_checks import is_point, named, points_of
from lumpedcable.scene.ends import tie_of
from lumpedcable.scene.lines import Line
from lumpedcable.scene.measures import (
    SEA,
    BendingMeasure,
    BodyMeasure,
    HeightMeasure,
    LineMeasure,
)
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.outcomes import TAKEN
from lumpedcable.scene.part import SIDES, Path, Problem
from lumpedcable.scene.units import format_quantity

__all__ = ["measure_problems"]

Lines = Mapping[str, Line | None]
Bodies = Mapping[str, Any]


def measure_problems(
    lines: Lines, bodies: Bodies, measures: Mapping[str, Any], parts: Set[str],
    duration: float | None,
) -> Iterator[Problem]:  # fmt: skip
    """Yield what is wrong with measures.

    Args:
        lines, bodies, measures: by name, None where one could not be read.
        parts: the keys of all single parts that the scene has, readable or not.
        duration: of a run, s; None where it is not known.
    """
    for name, measure in measures.items():
        path: Path = ("measures", name)
        if name in TAKEN:
            yield Problem(
                path, f'expected another name, found "{name}", which is a number of every run'
            )
        if measure is None:
            continue
        if measure.after is not None and duration is not None and measure.after > duration:
            yield Problem(
                (*path, "after"),
                f"expected a time before the end of the run, {format_quantity(duration, 's')}, "
                f"found {format_quantity(measure.after, 's')}",
            )
        if isinstance(measure, LineMeasure):
            yield from _place(lines, path, measure)
        elif isinstance(measure, BodyMeasure):
            yield from _measure(bodies, path, measure)
        elif SEA not in parts:
            yield Problem((*path, "elevation"), "expected [sea], whose waves it is of, found none")
        if isinstance(measure, HeightMeasure) and measure.over is not None:
            yield from _over(lines, bodies, path, measure, parts)


def _measure(bodies: Bodies, path: Path, measure: BodyMeasure) -> Iterator[Problem]:
    key = "height" if isinstance(measure, HeightMeasure) else "climb"
    name = measure.body
    riders = [n for n, body in bodies.items() if body is None or isinstance(body, CarriedBody)]
    if name not in riders:
        yield named((*path, key), name, riders, "the name of a body on a line")
    body = bodies.get(name)
    if measure.while_hauled and isinstance(body, CarriedBody) and body.on.speed is None:
        yield Problem(
            (*path, "while_hauled"),
            f'expected a body that is hauled, found "{name}", which has no speed',
        )
    if measure.near is not None and not is_point(bodies, measure.near):
        yield named((*path, "near"), measure.near, points_of(bodies), "a point of a moved body")


def _over(
    lines: Lines, bodies: Bodies, path: Path, measure: HeightMeasure, parts: Set[str]
) -> Iterator[Problem]:
    """Yield a deck that is not one, or above the posts on it."""
    assert measure.over is not None
    if measure.over == SEA:
        if SEA not in parts:
            yield Problem((*path, "over"), "expected [sea], whose waves it is over, found none")
        elif SEA in bodies:
            yield Problem(
                ("bodies", SEA), f'expected another name where a height is over = "{SEA}", the waves, '
                f'found "{SEA}"'
            )  # fmt: skip
        return
    ships = [
        n
        for n, body in bodies.items()
        if body is None or isinstance(body, MovedBody) or (isinstance(body, Body) and body.rigid)
    ]
    if measure.over not in ships:
        sea, what = ([SEA], ', or "sea"') if SEA in parts else ([], "")
        known = [*ships, *sea]
        yield named((*path, "over"), measure.over, known, f"the name of a moved body{what}")
        return
    ship = bodies[measure.over]
    if ship is None:
        return
    ends = [tie_of(getattr(line, side)) for line in lines.values() if line for side in SIDES]
    for post in dict.fromkeys([measure.near, *ends]):
        holder, _, point = (post or "").partition(".")
        if (
            holder == measure.over
            and point in ship.points
            and measure.level >= ship.points[point][2]
        ):
            yield Problem(
                (*path, "level"),
                f"expected a deck below {post}, which is at "
                f"{format_quantity(ship.points[point][2], 'm')}, "
                f"found {format_quantity(measure.level, 'm')}",
            )
            return


def _place(lines: Lines, path: Path, measure: LineMeasure) -> Iterator[Problem]:
    if next(measure.problems(), None) is not None:
        return  # told already
    name, _, place = measure.target()
    known = [n for n, line in lines.items() if line is None or line.model != "ideal"]
    if name not in known:
        yield named((*path, measure.KIND), name, known, "the name of a line with nodes")
    line = lines.get(name)
    if line is not None and isinstance(measure, BendingMeasure) and line.bending is None:
        yield Problem(
            (*path, measure.KIND), f'expected a line with bending, found "{name}", which has none'
        )
    if line is not None and place is not None and not 0 <= place <= line.unstretched:
        yield Problem(
            (*path, "place"),
            f"expected a place on the line, from 0 m to {format_quantity(line.unstretched, 'm')}, "
            f"found {format_quantity(place, 'm')}",
        )
