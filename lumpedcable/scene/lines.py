"""Lines, and what holds their two ends."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Tag

from lumpedcable.scene.angles import turn_problems
from lumpedcable.scene.carried import DrumEnd, WinchEnd, post_of
from lumpedcable.scene.part import SIDES, Part, Path, Problem, Text, choose, did_you_mean_key, tag
from lumpedcable.scene.quantities import (
    Angle,
    BendingStiffness,
    MassPerLength,
    NonNegativeForce,
    NonNegativeNumber,
    NonNegativeTime,
    Number,
    Position,
    PositiveLength,
    PositiveNumber,
    PositiveTime,
    SegmentCount,
    Speed,
    Time,
    Velocity,
    fault,
    found,
)
from lumpedcable.scene.records import times_fault
from lumpedcable.scene.units import format_quantity


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


def tie_of(end: Any) -> str | None:
    """Return the text that says what an end is tied to, None where it is not or is held by itself."""
    if isinstance(end, JoinedEnd):
        return end.joined
    if (post := post_of(end)) is not None:
        return post if isinstance(post, str) else None
    return end if isinstance(end, str) and end != "free" else None


def joined_to(lines: Mapping[str, Line | None], end: Any) -> Any:
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
    """Return the direction out of which a line with bending leaves an end, None where it may turn."""
    return end.direction if isinstance(end, FixedEnd | MovingEnd) else None


ENDS: dict[str, type[Part]] = {
    "fixed": FixedEnd,
    "held": HeldEnd,
    "motion": MovingEnd,
    "winch": WinchEnd,
    "drum": DrumEnd,
    "joined": JoinedEnd,
}
"""The one place where the key of an end's table becomes a class."""
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
        if len(kinds) == 1 and (len(value) == 1 or kinds[0] in ("fixed", "motion", "joined")):
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
    | Annotated[JoinedEnd, Tag(tag("joined"))],
    *choose(_pick_end, _END),
]
"""What holds an end: text ("free", a body, "BODY.POINT", another line's end) or a table."""


class Drag(Part):
    """Drag of the fluid on the line, with the velocity of the fluid relative to the line.

    Force per length: normal 0.5 rho d normal |vn| vn; tangential f 0.5 rho d tangential |vt| vt,
    with f = pi ("textbook"), pi/2 ("half") or 1 ("projected").
    """

    normal: NonNegativeNumber
    """Coefficient across the line."""
    tangential: NonNegativeNumber
    """Coefficient along the line."""
    convention: Literal["textbook", "half", "projected"] = "textbook"
    """The area that the tangential coefficient refers to."""


class AddedMass(Part):
    """Fluid that moves with the line: coefficient times rho pi d^2 / 4, in kg per m."""

    normal: NonNegativeNumber
    """Coefficient for motion across the line, 1 for a smooth cylinder."""
    tangential: NonNegativeNumber | None = None
    """Coefficient for motion along the line. Absent: none."""


class Bending(Part):
    """Resistance to bending: moment = EI times curvature."""

    EI: BendingStiffness
    """Bending stiffness in N m2."""


class Payout(Part):
    """Line paid out, or hauled in, since a beginning: its length is length + speed time."""

    speed: Speed
    """Speed in m/s at which line is paid out; negative: hauled in."""
    time: NonNegativeTime
    """Time in s since the beginning."""

    @property
    def way(self) -> float:
        """Length in m paid out until now."""
        return self.speed * self.time


class Line(Part):
    """A cable between two ends, cut into segments with masses between them."""

    model: Literal["lumped", "ideal"] = "lumped"
    """How it is computed: as lumps, or as an ideal cable without mass whose winch sets its tension."""
    material: Text
    """Name of its tension law, from [materials]."""
    length: PositiveLength
    """Unstretched length in m."""
    payout: Payout | None = None
    """Line paid out since it had this length. Absent: none."""
    segments: SegmentCount | None = None
    """Number of segments."""
    grading: PositiveNumber | None = None
    """Last over first segment length, geometric between. Absent: all equal."""
    segment_lengths: tuple[PositiveLength, ...] | None = None
    """Unstretched lengths of all segments in m, from the start, instead of segments."""
    mass: MassPerLength
    """Dry mass in kg per m of unstretched length."""
    diameter: PositiveLength | None = None
    """Outer diameter in m; needed where there is a fluid."""
    drag: Drag | None = None
    """Drag of the fluid. Absent: none."""
    added_mass: AddedMass | None = None
    """Fluid that moves with the line. Absent: none."""
    bending: Bending | None = None
    """Bending stiffness. Absent: none."""
    start: End
    """What holds the end at unstretched distance 0."""
    end: End
    """What holds the end at unstretched distance ``length``."""

    @property
    def unstretched(self) -> float:
        """Unstretched length in m, with what was paid out."""
        return self.length if self.payout is None else self.length + self.payout.way

    @property
    def section(self) -> float:
        """Area of the cross-section in m2, 0 where the scene does not give it."""
        return 0.0 if self.diameter is None else 0.25 * math.pi * self.diameter * self.diameter

    @property
    def count(self) -> int:
        """Number of segments, 0 of an ideal line."""
        if self.segment_lengths is not None:
            return len(self.segment_lengths)
        return 0 if self.segments is None else self.segments

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the segments and what was paid out."""
        if self.payout is not None and self.segment_lengths is not None:
            yield Problem(("payout",), "expected segments with payout, found segment_lengths")
        elif self.payout is not None and self.unstretched <= 0.0:
            yield Problem(
                ("payout", "time"),
                f"expected less time, found {format_quantity(self.payout.time, 's')}, in which the "
                "whole line is hauled in",
            )
        lengths = self.segment_lengths
        if lengths is None:
            if self.segments is None and self.model == "lumped":
                yield Problem(("segments",), "expected a number of segments, found nothing")
            elif self.grading is not None and self.segments == 1 and self.grading != 1:
                yield Problem(("grading",), "expected at least 2 segments to grade, found 1")
            return
        for other in ("segments", "grading"):
            if getattr(self, other) is not None:
                yield Problem((other,), f"expected segment_lengths without {other}, found both")
        if not lengths:
            yield Problem(("segment_lengths",), "expected at least 1 length, found none")
        elif abs(math.fsum(lengths) - self.length) > 1e-6 * self.length:
            yield Problem(
                ("segment_lengths",),
                f"expected lengths that add up to {format_quantity(self.length, 'm')}, "
                f"found {format_quantity(math.fsum(lengths), 'm')}",
            )
