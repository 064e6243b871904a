"""What must hold between drums and the rest of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lumpedcable.scene.carried import CarriedBody, Drum, DrumEnd, WinchEnd
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import SIDES, Path, Problem
from lumpedcable.scene.units import format_quantity

__all__ = ["drum_problems"]

LEAST = 0.01  # share of its length that stays out at least: all segments of a line get as short

Lines = Mapping[str, Line | None]


def drum_problems(
    lines: Lines, bodies: Mapping[str, Any], duration: float | None
) -> Iterator[Problem]:
    """Yield what is wrong with drums, but for where they stand.

    None stands for the unreadable, and for a `duration` (s) that is not known.
    """
    for name, line in lines.items():
        if line is None:
            continue
        path: Path = ("lines", name)
        drums = [side for side in SIDES if isinstance(getattr(line, side), DrumEnd)]
        if not drums:
            continue
        yield from _alone(path, line, drums)
        if line.model == "ideal":
            yield Problem(
                (*path, drums[0], "drum"),
                'expected model = "lumped" for a line on a drum, found "ideal", whose length nothing '
                "asks for",
            )
        for rider, body in bodies.items():
            if isinstance(body, CarriedBody) and body.on.line == name:
                yield Problem(
                    ("bodies", rider, "on", "line"),
                    f'expected a line without a drum where a body runs on it, found "{name}"',
                )
        for side in drums:
            yield from _joined(lines, path, side)
            drum = getattr(line, side).drum
            if duration and next(drum.schedule.problems(), None) is None:
                yield from _hauled((*path, side), line, drum, duration)


def _alone(path: Path, line: Line, drums: list[str]) -> Iterator[Problem]:
    """Yield a second drum, and a winch across from the drum."""
    if len(drums) == 2:
        yield Problem((*path, "end"), "expected one drum on a line, found one at either end")
    elif any(isinstance(getattr(line, side), WinchEnd) for side in SIDES):
        yield Problem(
            (*path, drums[0]),
            "expected a drum or a winch on a line, found a drum at one end and a winch at the other",
        )


def _joined(lines: Lines, path: Path, side: str) -> Iterator[Problem]:
    """Yield the ends of other lines that are joined to a drum's: it pays out one line."""
    for name, line in lines.items():
        for own in SIDES if line is not None else ():
            end = getattr(line, own)
            tie = getattr(end, "joined", end)
            if tie == f"{path[1]}.{side}":
                yield Problem(
                    ("lines", name, own),
                    f'expected a place, a body or the end of a line without a drum there, found "{tie}"',
                )


def _hauled(path: Path, line: Line, drum: Drum, duration: float) -> Iterator[Problem]:
    """Yield a schedule that hauls the line in, but for a hundredth, within the duration (s)."""
    way, when = drum.schedule.least_way(duration)
    if line.unstretched > 0.0 and line.unstretched + way <= LEAST * line.unstretched:
        yield Problem(
            (*path, "drum", "schedule", "speed"),
            f"expected speeds that leave more than {format_quantity(LEAST * line.unstretched, 'm')} of "
            f"the line out, found {format_quantity(-way, 'm')} of its "
            f"{format_quantity(line.unstretched, 'm')} hauled in by {format_quantity(when, 's')}",
        )
