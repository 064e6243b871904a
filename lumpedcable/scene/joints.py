"""Rigid joints of lines: where one goes over into the other, and bends as one with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from lumpedcable.scene.ends import JoinedEnd, clamp_of
from lumpedcable.scene.lines import Line
from lumpedcable.scene.part import SIDES, Problem

Side = tuple[str, str]
"""An end of a line: its name, and "start" or "end"."""


def rigid_joints(lines: Mapping[str, Line | None]) -> Iterator[tuple[Side, Side]]:
    """Yield the ends of lines at rigid joints: the one that says so, and what it is joined to."""
    for name, line in lines.items():
        for side in SIDES:
            end = getattr(line, side, None)
            if isinstance(end, JoinedEnd) and end.rigid:
                other, _, other_side = end.joined.rpartition(".")
                yield (name, side), (other, other_side)


def rigid_joint_problems(lines: Mapping[str, Line | None]) -> Iterator[Problem]:
    """Yield rigid joints of lines that do not bend, that are clamped there, or of more than two ends."""
    taken: dict[Side, str] = {}
    for one, other in rigid_joints(lines):
        path = ("lines", *one, "rigid")
        pair = [(side, line) for side in (one, other) if (line := lines.get(side[0])) is not None]
        if len(pair) < 2 or other[1] not in SIDES or one[0] == other[0]:
            continue  # that is told already
        for (name, side), line in pair:
            if line.bending is None:
                yield Problem(path, f'expected bending on both lines, found none on "{name}"')
            elif clamp_of(getattr(line, side)) is not None:
                message = "expected an end that is free to turn, found"
                yield Problem(path, f'{message} "{name}.{side}", which keeps a direction')
        for side in (one, other):
            if side in taken:
                yield Problem(
                    path,
                    f'expected an end of one rigid joint, found "{".".join(side)}", which has one '
                    f'with "{taken[side]}"',
                )
        taken |= {one: ".".join(other), other: ".".join(one)}
