"""What must hold of the breaks of a scene: where, when, of what, and how time is stepped then."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from math import inf
from typing import Any

from lumpedcable.scene.ends import clamp_of, held_force, tie_of
from lumpedcable.scene.events import Event
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import Path, Problem, unknown
from lumpedcable.scene.run import Output, Solver
from lumpedcable.scene.units import format_quantity

__all__ = ["event_problems"]

Lines = Mapping[str, Line | None]


def event_problems(
    events: Mapping[str, Event | None], lines: Lines, others: Mapping[str, Any]
) -> Iterator[Problem]:
    """Yield what is wrong with breaks; None stands for the unreadable."""
    if not lines:
        return  # told already
    # pairs and no table: a place may be a number of many runs, which has no hash
    broken: list[tuple[tuple[str, str | float | None], str]] = []
    for name, event in events.items():
        if event is None or next(event.problems(), None) is not None:
            continue
        yield from _beginning(("events", name), event, others)
        path: Path = ("events", name, "breaks")
        target, side, place = event.target()
        if target not in lines:
            message = f"expected the name of a line, found {unknown(target, lines)}"
            yield Problem(path, message)
            continue
        where = (target, side if side is not None else place)
        first = next((other for known, other in broken if known == where), None)
        if first is not None:
            yield Problem(path, f'expected one event per place, found the place of "{first}" again')
            continue
        broken.append((where, name))
        line = lines[target]
        if line is None or line.model == "ideal":
            continue  # told already
        if place is not None and not 0 < place < line.unstretched:
            yield Problem(
                ("events", name, "place"),
                f"expected a place inside the line, between 0 m and "
                f"{format_quantity(line.unstretched, 'm')}, found {format_quantity(place, 'm')}",
            )
        if side is not None:
            yield from _end(("events", name), event, getattr(line, side), lines)
    cuts = Counter(line for (line, place), _ in broken if not isinstance(place, str))
    for whole, count in cuts.items():
        for name in (f"{whole}-{k + 1}" for k in range(count + 1)):
            if name in lines:
                message = (
                    f'expected another name, found "{name}", a part of "{whole}" when that breaks'
                )
                yield Problem(("lines", name), message)


def _beginning(at: Path, event: Event, others: Mapping[str, Any]) -> Iterator[Problem]:
    """What is wrong with when a break begins."""
    output, solver = others.get("output"), others.get("solver", Solver())
    last = output.duration if isinstance(output, Output) and not output.static else inf
    if event.start >= last:
        yield Problem(
            (*at, "start"),
            f"expected a time before the run ends at {format_quantity(last, 's')}, "
            f"found {format_quantity(event.start, 's')}",
        )
    if event.tension is not None and isinstance(solver, Solver) and solver.adaptive:
        # what such methods carry at an end is known at outputs alone
        yield Problem(
            (*at, "tension"),
            "expected fixed steps where a break begins at a tension (leapfrog, rk4 or solver.step), "
            f'found solver.method = "{solver.method}"',
        )


def _end(at: Path, event: Event, end: Any, lines: Lines) -> Iterator[Problem]:
    """What is wrong with the end of a line that is to break."""
    if clamp_of(end) is not None:
        message = "expected an end that is free to turn, found"
        yield Problem((*at, "breaks"), f'{message} "{event.breaks}", which keeps a direction')
    if _tied(lines, event.breaks):
        return
    if end == "free":
        message = f'expected an end that is held, found "{event.breaks}", which is free'
        yield Problem((*at, "breaks"), message)
    held = held_force(end)
    if held is not None and event.tension is not None:
        yield Problem(
            (*at, "tension"),
            "expected an end that a place, a motion, a body or another line holds, found "
            f'"{event.breaks}", which a force of {format_quantity(held.pretension, "N")} holds '
            "whatever happens: give start",
        )


def _tied(lines: Lines, end: str) -> bool:
    """Return whether the end of some line is joined to ``end``, or may be."""
    ties = [[tie_of(x) for x in (line.start, line.end)] for line in lines.values() if line]
    return None in lines.values() or any(end in pair for pair in ties)
