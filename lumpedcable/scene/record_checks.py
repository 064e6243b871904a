"""Whether the records that move ships and ends of lines last as long as the run does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from lumpedcable.scene.ends import MovingEnd, RecordedMotion
from lumpedcable.scene.motions import RecordedBody
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.part import SIDES, Path, Problem
from lumpedcable.scene.records import gap_fault
from lumpedcable.scene.units import format_quantity

__all__ = ["record_problems"]


def record_problems(
    lines: Mapping[str, Any],
    bodies: Mapping[str, Any],
    duration: float | None,
    until: str = "the run ends",
) -> Iterator[Problem]:
    """Yield records of ends with gaps, and all that begin after 0 s or end early in mid-motion.

    What a record does not cover rests: a record may begin and end early where it rests there itself.
    `duration` (s) is None where it is not known; `until` says what ends after it.
    """
    for name, body in bodies.items():
        if isinstance(body, MovedBody) and isinstance(body.motion, RecordedBody):
            motion = body.motion
            rows = [getattr(motion, freedom) for freedom in motion.names()]
            yield from _covers(("bodies", name, "motion"), motion, rows, duration, until)
    for name, line in lines.items():
        for side in SIDES if line is not None else ():
            end = getattr(line, side)
            if isinstance(end, MovingEnd) and isinstance(end.motion, RecordedMotion):
                path: Path = ("lines", name, side, "motion")
                rows = [[place[k] for place in end.motion.position] for k in range(3)]
                yield from _covers(path, end.motion, rows, duration, until)
                if next(end.motion.problems(), None) is None:
                    # what somebody wrote down may rest for long; what was measured has lost something
                    message = gap_fault(end.motion.time, () if end.motion.file else rows)
                    if message:
                        yield Problem((*path, "file" if end.motion.file else "time"), message)


def _covers(
    path: Path,
    motion: RecordedBody | RecordedMotion,
    rows: Sequence[Sequence[float]],
    duration: float | None,
    until: str,
) -> Iterator[Problem]:
    if next(motion.problems(), None) is not None:
        return  # told already
    where = (*path, "file" if motion.file else "time")
    first, last = motion.time[0], motion.time[-1]
    if first > 0.0 and any(row[0] != row[1] for row in rows):
        yield Problem(
            where,
            "expected a record from 0 s on, or one that begins at rest, found its first time at "
            f"{format_quantity(first, 's')}",
        )
    if duration is None or last >= duration * (1.0 - 1e-9):
        return
    if any(row[-1] != row[-2] for row in rows):
        yield Problem(
            where,
            f"expected a record until {until} at {format_quantity(duration, 's')}, or one "
            f"that ends at rest, found its last time at {format_quantity(last, 's')}",
        )
