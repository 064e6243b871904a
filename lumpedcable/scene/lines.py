"""Lines: what they are of, how they are cut, and what the fluid does to them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

from lumpedcable.scene.ends import End
from lumpedcable.scene.part import Part, Problem, Text
from lumpedcable.scene.quantities import (
    BendingStiffness,
    MassPerLength,
    NonNegativeNumber,
    NonNegativeTime,
    PositiveLength,
    PositiveNumber,
    SegmentCount,
    Speed,
)
from lumpedcable.scene.units import format_quantity


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
