"""What runs along a line, and what pays the line out: cargo under a trolley, winches and drums."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Tag

from lumpedcable.scene.angles import turn_problems
from lumpedcable.scene.part import Part, Problem, Text, choose, tag
from lumpedcable.scene.quantities import (
    Angle,
    Damper,
    Length,
    MomentOfInertia,
    NonNegativeNumber,
    NonNegativeTime,
    Position,
    PositiveForce,
    PositiveLength,
    PositiveMass,
    PositiveNumber,
    PositiveSpeed,
    PositiveTime,
    Speed,
    fault,
    found,
)
from lumpedcable.scene.records import table_problems

_PLACE = 'a place [x, y, z] or a point of a body, "BODY.POINT"'


def _pick_place(value: Any) -> str:
    if isinstance(value, str):
        return "name"
    if isinstance(value, list | tuple) and len(value) == 3:
        return "position"
    raise fault(f"expected {_PLACE}, found {found(value)}")


Place = Annotated[
    Annotated[Text, Tag(tag("name"))] | Annotated[Position, Tag(tag("position"))],
    *choose(_pick_place, _PLACE),
]


class Friction(Part):
    """Friction of the trolley on the line: coefficient tanh(v / speed) times the push across it."""

    coefficient: NonNegativeNumber
    """Friction coefficient at speeds well above ``speed``."""
    speed: PositiveSpeed = 0.01
    """Speed in m/s of the trolley along the line below which friction fades."""


class Contact(Part):
    """How the trolley's wheel sinks into the line: k x^m + c step(x / d) dx/dt at the depth x.

    Gao et al. (2022), eq. 10; step(y) = y^2 (3 - 2 y) from 0 to 1.
    """

    stiffness: PositiveNumber
    """k in N/m^exponent."""
    exponent: PositiveNumber = 1.5
    """m, 1 or more; 1.5 by Hertz for round bodies."""
    damping: Damper | None = None
    """Largest damping c in N s/m; needed with depth. Absent: none."""
    depth: PositiveLength | None = None
    """Depth d in m from which the damping is full."""

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where damping and depth do not come together, and an exponent below 1."""
        if (self.damping is None) != (self.depth is None):
            absent = "damping" if self.damping is None else "depth"
            yield Problem((absent,), "expected damping and depth together, found one of them")
        if self.exponent < 1.0:
            yield Problem(("exponent",), f"expected 1 or more, found {self.exponent:g}")


class On(Part):
    """Where a trolley is on its line, and how it is moved along it."""

    line: Text
    """Name of the line."""
    place: PositiveLength
    """Horizontal distance in m from the start of the line at t = 0."""
    speed: PositiveSpeed | None = None
    """Horizontal speed in m/s at which it is hauled away from the line's start. Absent: it rolls."""
    stop: PositiveLength = 1.0
    """Horizontal distance in m from the line's end at which hauling has brought it to rest."""
    ease: PositiveTime = 1.0
    """Time in s that it takes to come to rest there."""
    friction: Friction | None = None
    """Friction between trolley and line. Absent: none."""
    contact: Contact | None = None
    """How its wheel sinks into a lumped line. Absent: not at all."""


class CarriedBody(Part):
    """Cargo that a trolley carries along a line: a point, or a body that swings under it."""

    DRAWN: ClassVar[tuple[str, ...]] = ("size",)

    mass: PositiveMass
    """Mass in kg, trolley included."""
    on: On
    """The line and the place on it."""
    height: Length | None = None
    """Height z in m of the trolley at t = 0. Absent: at rest on the line, but for the way along it."""
    depth: PositiveLength | None = None
    """Distance in m from the trolley down to the centre of gravity. Absent: a point at the trolley."""
    inertia: MomentOfInertia | None = None
    """Moment of inertia in kg m2 about the centre of gravity; needed with depth."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength] | None = None
    """Length, breadth and height in m of the box about its centre that pictures show. Absent: a ball."""

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where depth and inertia do not come together."""
        if (self.depth is None) != (self.inertia is None):
            absent = "inertia" if self.inertia is None else "depth"
            yield Problem((absent,), "expected depth and inertia together, found one of them")


class Control(Part):
    """A drive that watches the tension: it adds gain (e + integral of e / integral_time) to it.

    e is the tension of the line less that of the winch, in N.
    """

    gain: NonNegativeNumber
    """Newtons of the drive for each newton that the tension is off."""
    integral_time: PositiveTime | None = None
    """Time in s after which a lasting error has been answered as strongly again. Absent: no integral."""


MOST_TURNS = 5
"""Of a line around a drum that it slides over."""


class Sheave(Part):
    """A fixed sheave at the post, over which the line slides to the drum."""

    friction: NonNegativeNumber
    """Friction coefficient between line and sheave, or what its bearing comes to."""
    wrap: Angle
    """Angle in rad that the line is bent by around it."""
    speed: PositiveSpeed = 0.01
    """Speed in m/s of payout below which friction fades."""

    def problems(self) -> Iterator[Problem]:
        """Yield an angle in degrees without its unit, and a line that bends the other way."""
        yield from turn_problems(("wrap",), self.wrap, MOST_TURNS)
        if self.wrap < 0.0:
            yield Problem(("wrap",), f"expected an angle of 0 or more, found {self.wrap:g} rad")


class Schedule(Part):
    """Tensions over time: linear from the winch's own at t = 0 through these, then the last of them."""

    time: tuple[PositiveTime, ...]
    """Times in s, increasing."""
    tension: tuple[PositiveForce, ...]
    """Tensions in N at those times."""

    def problems(self) -> Iterator[Problem]:
        """Yield lists of unequal length and times that do not increase."""
        yield from table_problems("time", self.time, "time", "s", self.tension, "tension", 1)


class Winch(Part):
    """A drum that pays a line out and hauls it in to keep its tension."""

    at: Place
    """Where, in m, or a point of a body, "ship.post"."""
    tension: PositiveForce
    """Tension in N that it keeps."""
    schedule: Schedule | None = None
    """Other tensions that it keeps later. Absent: none."""
    inertia: PositiveMass | None = None
    """Moment of inertia of drum and drive over the drum's radius squared, in kg. Absent: none."""
    damping: Damper | None = None
    """Force in N per m/s of payout, against it. Absent: none."""
    speed: PositiveSpeed | None = None
    """Largest speed in m/s of payout and hauling in; not with rk4 and the like. Absent: any."""
    control: Control | None = None
    """What its drive does about a wrong tension. Absent: it pulls with its tension, come what may."""
    sheave: Sheave | None = None
    """The sheave that the line runs over at the post. Absent: one without friction."""


class WinchEnd(Part):
    """An end that a winch keeps at a tension, by paying the line out and hauling it in."""

    winch: Winch
    """The winch."""


class DrumSchedule(Part):
    """Speeds over time: linear between these, the first before them and the last after them."""

    time: tuple[NonNegativeTime, ...]
    """Times in s, increasing."""
    speed: tuple[Speed, ...]
    """Speeds in m/s of payout at those times; negative: hauled in."""

    def problems(self) -> Iterator[Problem]:
        """Yield lists of unequal length and times that do not increase."""
        yield from table_problems("time", self.time, "time", "s", self.speed, "speed", 1)

    def least_way(self, duration: float) -> tuple[float, float]:
        """Return the least that has been paid out (m, negative: hauled in) in a time (s), and when."""
        times = sorted({0.0, duration, *(t for t in self.time if 0.0 < t < duration)})
        speeds = [float(v) for v in np.interp(times, self.time, self.speed)]
        way, found = 0.0, [(0.0, 0.0)]
        for (begin, v), (end, w) in pairwise(zip(times, speeds, strict=True)):
            step = end - begin
            if v < 0.0 < w:  # it turns there from hauling in to paying out
                turn = step * v / (v - w)
                found.append((way + 0.5 * v * turn, begin + turn))
            way += 0.5 * (v + w) * step
            found.append((way, end))
        return min(found)


class Drum(Part):
    """A drum that pays a line out and hauls it in as it is told."""

    at: Place
    """Where, in m, or a point of a body, "ship.post"."""
    schedule: DrumSchedule
    """How fast it pays out at what time."""


class DrumEnd(Part):
    """An end on a drum, which pays the line out and hauls it in at given speeds."""

    drum: Drum
    """The drum."""


def post_of(end: Any) -> tuple[float, float, float] | str | None:
    """Return where the winch or drum of an end stands, a place (m) or "BODY.POINT"; None of others."""
    if isinstance(end, WinchEnd):
        return end.winch.at
    return end.drum.at if isinstance(end, DrumEnd) else None


def stands_at(end: Any) -> Any:
    """Return where the winch or drum of an end stands, and any other end itself."""
    post = post_of(end)
    return end if post is None else post


def reel_key(end: Any) -> str | None:
    """Return the key that an end on a winch or drum is written with, None of others."""
    if isinstance(end, WinchEnd):
        return "winch"
    return "drum" if isinstance(end, DrumEnd) else None
