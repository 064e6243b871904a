"""How ships move, and what waves push them with: six freedoms over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Tag

from lumpedcable.scene.angles import IN_RADIANS, TURN, turn_problems
from lumpedcable.scene.part import (
    Name,
    Part,
    Path,
    Problem,
    Text,
    choose,
    did_you_mean,
    did_you_mean_key,
    tag,
)
from lumpedcable.scene.quantities import (
    Angle,
    Force,
    Length,
    Number,
    PositiveTime,
    Time,
    Torque,
    fault,
    found,
)
from lumpedcable.scene.records import gap_fault, times_fault
from lumpedcable.scene.units import format_quantity

SHIFTS = ("surge", "sway", "heave")
TURNS = ("roll", "pitch", "yaw")
BEGUN_ANEW = 0.5  # rad to the last row that an angle may leave which goes on after a turn
FREEDOMS = (*SHIFTS, *TURNS)
"""The six motions of a ship: along and about its x, y and z axes."""


class ByFreedom(Part):
    """Something for any of the six freedoms, each under its name."""

    def names(self) -> tuple[str, ...]:
        """Return the freedoms that it names."""
        return tuple(name for name in FREEDOMS if getattr(self, name) is not None)


def _degrees(sines: ByFreedom) -> Iterator[Problem]:
    """Yield phases and angles of swinging that stand in degrees without their unit."""
    for name in sines.names():
        sine = getattr(sines, name)
        yield from turn_problems((name, "phase"), sine.phase)
        if isinstance(sine, Turn):
            yield from turn_problems((name, "amplitude"), sine.amplitude)


class Shift(Part):
    """amplitude sin(2 pi t / period + phase), along an axis."""

    amplitude: Length
    """Amplitude in m."""
    period: PositiveTime
    """Period in s."""
    phase: Angle = 0.0
    """Phase in rad at t = 0."""


class Turn(Part):
    """amplitude sin(2 pi t / period + phase), about an axis."""

    amplitude: Angle
    """Amplitude in rad."""
    period: PositiveTime
    """Period in s."""
    phase: Angle = 0.0
    """Phase in rad at t = 0."""


class HarmonicBody(ByFreedom):
    """Harmonic motions of a body about its mean place, one for each freedom that it names."""

    surge: Shift | None = None
    """Along x. Absent: none."""
    sway: Shift | None = None
    """Along y. Absent: none."""
    heave: Shift | None = None
    """Along z, up. Absent: none."""
    roll: Turn | None = None
    """About the x axis through the body's position. Absent: none."""
    pitch: Turn | None = None
    """About its y axis. Absent: none."""
    yaw: Turn | None = None
    """About its z axis. Absent: none."""
    ramp: PositiveTime | None = None
    """Time in s over which the motion grows from rest. Absent: at once."""

    def problems(self) -> Iterator[Problem]:
        """Yield angles in degrees that stand without their unit."""
        yield from _degrees(self)


class RecordedBody(ByFreedom):
    """Motions at times, from a CSV file or written out; a cubic spline between them."""

    FILE: ClassVar[tuple[str, ...]] = ("file", "time", *FREEDOMS)

    file: Text | None = None
    """CSV file with a column t (s) and any of surge, sway, heave (m), roll, pitch, yaw (rad)."""
    time: tuple[Time, ...] = ()
    """Times of the record in s, increasing."""
    surge: tuple[Length, ...] | None = None
    """Along x at those times in m."""
    sway: tuple[Length, ...] | None = None
    """Along y at those times in m."""
    heave: tuple[Length, ...] | None = None
    """Along z at those times in m."""
    roll: tuple[Angle, ...] | None = None
    """About x at those times in rad."""
    pitch: tuple[Angle, ...] | None = None
    """About y at those times in rad."""
    yaw: tuple[Angle, ...] | None = None
    """About z at those times in rad."""

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the record."""
        where: Path = ("file",) if self.file is not None else ("time",)
        if not self.names():
            yield Problem(where, f"expected one of {', '.join(FREEDOMS)}, found none")
        for name in self.names():
            values = getattr(self, name)
            if len(values) != len(self.time):
                yield Problem(
                    ("file",) if self.file is not None else (name,),
                    f"expected {len(self.time)} values of {name}, one per time, "
                    f"found {len(values)}",
                )
        message = times_fault(self.time) or gap_fault(self.time)
        if message:
            yield Problem(where, message)
        for name in self.names():
            if name in TURNS and (message := self._turned_back(name)):
                yield Problem(("file",) if self.file is not None else (name,), message)

    def _turned_back(self, name: str) -> str:
        """What is wrong with an angle that begins anew after half a turn or a whole one, else ""."""
        values = getattr(self, name)
        for time, (before, after) in zip(self.time[1:], pairwise(values), strict=False):
            if abs(after - before) > math.pi:
                on = after + math.copysign(math.tau, before - after)
                if abs(on - before) > BEGUN_ANEW:
                    return (
                        f"expected {name} that changes by less than half a turn from row to row, found "
                        f"{after:.4g} rad after {before:.4g} rad at {format_quantity(time, 's')}; "
                        f"{IN_RADIANS}"
                    )
                return (
                    f"expected {name} that goes on beyond half a turn, {math.degrees(on):.4g} deg at "
                    f"{format_quantity(time, 's')}, found {math.degrees(after):.4g} deg after "
                    f"{math.degrees(before):.4g} deg"
                )
        return ""


class SeaBody(Part):
    """Motions in the waves of [sea], by the body's response amplitude operators (RAO)."""

    FILE: ClassVar[tuple[str, ...]] = ("rao", "omega", "response")

    rao: Text | None = None
    """CSV file with columns omega (rad/s), NAME (m or rad per m of wave) and NAME_phase (rad)."""
    omega: tuple[Number, ...] = ()
    """Angular frequencies of the table in rad/s, increasing."""
    response: dict[Name, tuple[tuple[Number, Number], ...]] = Field(default_factory=dict)
    """By freedom: amplitude (m or rad per m of wave) and phase (rad) at those frequencies."""
    ramp: PositiveTime | None = None
    """Time in s over which the motion grows from rest. Absent: at once."""

    def names(self) -> tuple[str, ...]:
        """Return the freedoms that it names."""
        return tuple(name for name in FREEDOMS if name in self.response)

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the table."""
        where: Path = ("rao",) if self.rao is not None else ("omega",)
        if not self.names():
            yield Problem(where, f"expected one of {', '.join(FREEDOMS)}, found none")
        if len(self.omega) < 2:
            yield Problem(where, f"expected at least 2 frequencies, found {len(self.omega)}")
        for before, after in pairwise(self.omega):
            if after <= before:
                yield Problem(
                    where,
                    f"expected frequencies that increase, found {after:g} rad/s after "
                    f"{before:g} rad/s",
                )
                return
        for name in self.response:
            if name not in FREEDOMS:
                yield Problem(
                    ("response", name) if self.rao is None else where,
                    f"expected one of {', '.join(FREEDOMS)}, found {found(name)}"
                    f"{did_you_mean(name, FREEDOMS)}",
                )
            elif len(self.response[name]) != len(self.omega):
                yield Problem(
                    where,
                    f"expected {len(self.omega)} values of {name}, one per frequency, "
                    f"found {len(self.response[name])}",
                )
            else:
                yield from self._leaps(where, name)

    def _leaps(self, where: Path, name: str) -> Iterator[Problem]:
        """Yield a phase beyond a turn that leaps from row to row: degrees without their unit."""
        phases = [phase for _, phase in self.response[name]]
        for before, after in pairwise(phases):
            if max(abs(before), abs(after)) > TURN and abs(after - before) > math.pi:
                yield Problem(
                    where,
                    f"expected phases of {name} that change by less than half a turn from row to row, "
                    f"found {after:.4g} rad after {before:.4g} rad; {IN_RADIANS}: write "
                    f'"{name}_phase (deg)"',
                )
                return


class Push(Part):
    """amplitude sin(2 pi t / period + phase), a force along an axis."""

    amplitude: Force
    """Amplitude in N."""
    period: PositiveTime
    """Period in s."""
    phase: Angle = 0.0
    """Phase in rad at t = 0."""


class Heel(Part):
    """amplitude sin(2 pi t / period + phase), a moment about an axis."""

    amplitude: Torque
    """Amplitude in N m."""
    period: PositiveTime
    """Period in s."""
    phase: Angle = 0.0
    """Phase in rad at t = 0."""


class HarmonicWaves(ByFreedom):
    """Harmonic forces and moments of waves on a free body, one for each freedom that it names."""

    surge: Push | None = None
    """Force along its length. Absent: none."""
    sway: Push | None = None
    """Force along its breadth. Absent: none."""
    heave: Push | None = None
    """Force along z, up. Absent: none."""
    roll: Heel | None = None
    """Moment about its length. Absent: none."""
    pitch: Heel | None = None
    """Moment about its breadth. Absent: none."""
    yaw: Heel | None = None
    """Moment about its height. Absent: none."""
    ramp: PositiveTime | None = None
    """Time in s over which the forces grow from nothing. Absent: at once."""

    def problems(self) -> Iterator[Problem]:
        """Yield phases in degrees that stand without their unit."""
        yield from _degrees(self)


class SeaWaves(SeaBody):
    """Forces and moments of the waves of [sea] on a free body, by its load RAOs."""

    rao: Text | None = None
    """CSV file with columns omega (rad/s), NAME (N or N m per m of wave) and NAME_phase (rad)."""
    response: dict[Name, tuple[tuple[Number, Number], ...]] = Field(default_factory=dict)
    """By freedom: amplitude (N or N m per m of wave) and phase (rad) at those frequencies."""
    ramp: PositiveTime | None = None
    """Time in s over which the forces grow from nothing. Absent: at once."""


class PressureWaves(Part):
    """The pressure of the waves of [sea] on the wetted box of a hull that does not disturb them."""

    law: Literal["froude-krylov"]
    """How the forces come about."""
    ramp: PositiveTime | None = None
    """Time in s over which the forces grow from nothing. Absent: at once."""


_WAVES = f"a table with any of {', '.join(FREEDOMS)}, or with rao or law"


def _pick_waves(value: Any) -> str:
    if isinstance(value, Part):
        kinds = {SeaWaves: "sea", PressureWaves: "law"}
        return kinds.get(type(value), "harmonic")
    if not isinstance(value, dict):
        raise fault(f"expected {_WAVES}, found {found(value)}")
    if {"rao", "omega"} & value.keys():
        return "sea"
    if "law" in value:
        return "law"
    if not set(FREEDOMS) & value.keys():
        hint = did_you_mean_key(value, (*FREEDOMS, "rao", "law"))
        raise fault(f"expected {_WAVES}, found {found(value)}{hint}")
    return "harmonic"


Waves = Annotated[
    Annotated[HarmonicWaves, Tag(tag("harmonic"))]
    | Annotated[SeaWaves, Tag(tag("sea"))]
    | Annotated[PressureWaves, Tag(tag("law"))],
    *choose(_pick_waves, _WAVES),
]
