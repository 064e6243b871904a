"""What holds the ends of lines: tables and texts of the scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, Tag

from lumpedcable.scene.angles import turn_problems
from lumpedcable.scene.carried import DrumEnd, WinchEnd, post_of
from lumpedcable.scene.part import SIDES, Part, Path, Problem, Text, choose, did_you_mean_key, tag
from lumpedcable.scene.quantities import (
    Angle,
    NonNegativeForce,
    Number,
    Position,
    PositiveTime,
    Time,
    Velocity,
    fault,
    found,
)
from lumpedcable.scene.records import times_fault


def _unit_vector(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    norm = math.hypot(*vector)
    if norm == 0:
        raise fault("expected a direction, found the zero vector")
    if abs(norm - 1) < 1e-15:
        return vector  # already a unit vector: the same when read again
    x, y, z = vector
    return (x / norm, y / norm, z / norm)


Direction = Annotated[tuple[Number, Number, Number], AfterValidator(_unit_vector)]
"""A direction, made a unit vector when it is read."""


class FixedEnd(Part):
    """An end that stays where it is; with a direction, of a line with bending, it is clamped."""

    fixed: Position
    """Where, in m."""
    direction: Direction | None = None
    """Direction that the line keeps there, from its start towards its end. Absent: free to turn."""


class HeldForce(Part):
    """An end pulled by a constant force of size ``pretension``, until an event takes it away."""

    pretension: NonNegativeForce
    """Size of the force in N; the tension at this end in the start state."""
    direction: Direction
    """Direction of the force, away from the line."""


class HeldPosition(Part):
    """An end held at a place, as by :class:`FixedEnd`."""

    position: Position
    """Where, in m."""


_HELD = "a table with pretension and direction, or with position alone"


def _pick_held(value: Any) -> str:
    if isinstance(value, Part):
        return "position" if isinstance(value, HeldPosition) else "force"
    if not isinstance(value, dict) or ("position" in value and len(value) > 1):
        raise fault(f"expected {_HELD}, found {found(value)}")
    return "position" if "position" in value else "force"


Held = Annotated[
    Annotated[HeldForce, Tag(tag("force"))] | Annotated[HeldPosition, Tag(tag("position"))],
    *choose(_pick_held, _HELD),
]


class HeldEnd(Part):
    """An end held by a force or at a place."""

    held: Held
    """What holds it."""


class HarmonicMotion(Part):
    """x(t) = position + velocity t + amplitude sin(2 pi t / period + phase)."""

    position: Position
    """Mean place in m at t = 0."""
    velocity: Velocity | None = None
    """Steady velocity in m/s, reached at the end of the ramp. Absent: none."""
    amplitude: Position | None = None
    """Amplitude of the oscillation in m. Absent: none."""
    period: PositiveTime | None = None
    """Period in s; needed with amplitude."""
    phase: Angle = 0.0
    """Phase in rad at t = 0."""
    ramp: PositiveTime | None = None
    """Time in s over which the motion grows from rest. Absent: at once."""

    def problems(self) -> Iterator[Problem]:
        """Yield a phase in degrees without its unit, and amplitude without period or the reverse."""
        yield from turn_problems(("phase",), self.phase)
        if self.amplitude is not None and self.period is None:
            yield Problem(("period",), "expected a positive time (s) with amplitude, found nothing")
        if self.amplitude is None and self.period is not None:
            yield Problem(
                ("period",), "expected amplitude = [x, y, z] with period, found no amplitude"
            )


class RecordedMotion(Part):
    """Places at times, from a CSV file or written out; a cubic spline between them."""

    FILE: ClassVar[tuple[str, ...]] = ("file", "time", "position")

    file: Text | None = None
    """CSV file with columns t, x, y, z in s and m, relative to the scene file."""
    time: tuple[Time, ...] = ()
    """Times of the record in s, increasing."""
    position: tuple[Position, ...] = ()
    """Places at those times in m."""

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the record."""
        where: Path = ("file",) if self.file is not None else ("time",)
        message = times_fault(self.time)
        if len(self.time) >= 2 and len(self.position) != len(self.time):
            where = where if self.file is not None else ("position",)
            yield Problem(
                where,
                f"expected {len(self.time)} places, one per time, found {len(self.position)}",
            )
        elif message:
            yield Problem(where, message)


_MOTION = "a table with position, or with file"


def _pick_motion(value: Any) -> str:
    if isinstance(value, Part):
        return "recorded" if isinstance(value, RecordedMotion) else "harmonic"
    if not isinstance(value, dict):
        raise fault(f"expected {_MOTION}, found {found(value)}")
    return "recorded" if {"file", "time"} & value.keys() else "harmonic"


Motion = Annotated[
    Annotated[HarmonicMotion, Tag(tag("harmonic"))]
    | Annotated[RecordedMotion, Tag(tag("recorded"))],
    *choose(_pick_motion, _MOTION),
]


class MovingEnd(Part):
    """An end that is moved along a given path; with a direction, of a line with bending, clamped."""

    motion: Motion
    """The path in time."""
    direction: Direction | None = None
    """Direction that the line keeps there, from its start towards its end. Absent: free to turn."""


class JoinedEnd(Part):
    """An end joined to another line's, as by a hinge or rigidly."""

    joined: Text
    """The end of another line, "LINE.start" or "LINE.end"."""
    rigid: bool = False
    """Whether the two lines go on straight into each other, so that what bends bends over the joint."""
    at: Position | None = None
    """Where both are at the start in m; from then on nothing holds them there. Absent: it is found."""


class TiedEnd(Part):
    """An end of a line with bending that is clamped to a body: it moves and turns as that does."""

    tied: Text
    """The rigid body, or the point of one or of a moved one, "BODY.POINT"."""
    direction: Direction
    """Direction in the body's own axes that the line keeps there, from its start towards its end."""


def tie_of(end: Any) -> str | None:
    """Return the text that says what an end is tied to, None where it is not or is held by itself."""
    if isinstance(end, JoinedEnd):
        return end.joined
    if isinstance(end, TiedEnd):
        return end.tied
    if (post := post_of(end)) is not None:
        return post if isinstance(post, str) else None
    return end if isinstance(end, str) and end != "free" else None


def joined_to(lines: Mapping[str, Any], end: Any) -> Any:
    """Return the end of another line that an end is joined to, in turn, or the end itself."""
    seen = set()
    while (tie := tie_of(end)) is not None and tie not in seen:
        seen.add(tie)
        name, _, side = tie.rpartition(".")
        line = lines.get(name)
        if line is None or side not in SIDES:
            break
        end = getattr(line, side)
    return end


def held_place(end: Any) -> tuple[float, float, float] | None:
    """Return the place that holds an end (m), as ``fixed`` or as ``held``; None where none does."""
    if isinstance(end, FixedEnd):
        return end.fixed
    if isinstance(end, HeldEnd) and isinstance(end.held, HeldPosition):
        return end.held.position
    return None


def held_force(end: Any) -> HeldForce | None:
    """Return the force that holds an end, None where none does."""
    return end.held if isinstance(end, HeldEnd) and isinstance(end.held, HeldForce) else None


def clamp_of(end: Any) -> tuple[float, float, float] | None:
    """Return the direction out of which a line with bending leaves an end, None where it may turn.

    At a body it is in the axes of that.
    """
    return end.direction if isinstance(end, FixedEnd | MovingEnd | TiedEnd) else None


ENDS: dict[str, type[Part]] = {
    "fixed": FixedEnd,
    "held": HeldEnd,
    "motion": MovingEnd,
    "winch": WinchEnd,
    "drum": DrumEnd,
    "joined": JoinedEnd,
    "tied": TiedEnd,
}
"""The one place where the key of an end's table becomes a class."""
WITH_MORE = ("fixed", "motion", "joined", "tied")
"""Those that may have other keys beside their own."""
_END = (
    f'"free", a body or a point of one, the end of another line, or a table with one of '
    f"{', '.join(ENDS)}"
)


def _pick_end(value: Any) -> str:
    if isinstance(value, str):
        return "name"
    if isinstance(value, Part):
        return next((kind for kind, cls in ENDS.items() if isinstance(value, cls)), "name")
    if isinstance(value, dict):
        kinds = [kind for kind in ENDS if kind in value]
        if len(kinds) == 1 and (len(value) == 1 or kinds[0] in WITH_MORE):
            return kinds[0]
    hint = did_you_mean_key(value, ENDS) if isinstance(value, dict) else ""
    raise fault(f"expected {_END}, found {found(value)}{hint}")


End = Annotated[
    Annotated[Text, Tag(tag("name"))]
    | Annotated[FixedEnd, Tag(tag("fixed"))]
    | Annotated[HeldEnd, Tag(tag("held"))]
    | Annotated[MovingEnd, Tag(tag("motion"))]
    | Annotated[WinchEnd, Tag(tag("winch"))]
    | Annotated[DrumEnd, Tag(tag("drum"))]
    | Annotated[JoinedEnd, Tag(tag("joined"))]
    | Annotated[TiedEnd, Tag(tag("tied"))],
    *choose(_pick_end, _END),
]
"""What holds an end: text ("free", a body, "BODY.POINT", another line's end) or a table."""
