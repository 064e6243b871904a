"""Numbers that a scene asks for: of bodies on lines, of places along lines, and of its waves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Tag, model_validator

from lumpedcable.scene.events import place_problems, split_place, target_of, target_text
from lumpedcable.scene.part import Part, Problem, Text, choose, either, tag
from lumpedcable.scene.quantities import (
    Length,
    NonNegativeForce,
    NonNegativeTime,
    PositiveLength,
    PositiveSpeed,
    PositiveTorque,
    Speed,
    fault,
    found,
)
from lumpedcable.scene.units import format_quantity

__all__ = [
    "SEA",
    "BendingMeasure",
    "BodyMeasure",
    "DisplacementMeasure",
    "ElevationMeasure",
    "HeightMeasure",
    "LineMeasure",
    "LineSpeedMeasure",
    "Measure",
    "MotionMeasure",
    "PlaceKind",
    "PositionMeasure",
    "SpeedMeasure",
    "TensionMeasure",
    "VelocityMeasure",
]

SEA = "sea"
"""What a height is over that is over the waves."""

PlaceKind = Literal["tension", "bending_moment", "speed", "position", "velocity", "displacement"]
"""What is measured at a place of a line."""


class HeightMeasure(Part):
    """The least height of a body over the water, over waves or over a ship's deck."""

    UNIT: ClassVar[str] = "m"
    LEAST: ClassVar[bool] = True
    height: Text
    """Name of a body on a line, whose trolley it is of."""
    over: Text | None = None
    """Name of the moved body that carries the deck, or "sea": its waves. Absent: over z = level."""
    level: Length = 0.0
    """Height in m of the deck in that body's axes, over the waves, or of the level in space."""
    near: Text | None = None
    """A point of a body, "ship.post": counts only near it. Absent: always."""
    within: PositiveLength | None = None
    """Horizontal distance in m from that point within which it counts."""
    beyond: PositiveLength | None = None
    """Horizontal distance in m from that point beyond which alone it counts. Absent: none."""
    while_hauled: bool = False
    """Counts only until the body has been hauled to its stop."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: Length | None = None
    """Least height in m that is safe. Absent: none."""

    @property
    def body(self) -> str:
        """Name of the body."""
        return self.height

    @property
    def words(self) -> str:
        """What it is."""
        over = {None: "", SEA: " over the waves"}.get(self.over, f" over the deck of {self.over}")
        level = "" if self.level == 0.0 else f" less {format_quantity(self.level, 'm')}"
        return f"height of {self.height}{over}{level if self.over == SEA else ''}"

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where a distance has nothing that it counts from, or the reverse."""
        yield from _together(self)


class SpeedMeasure(Part):
    """The largest vertical speed of a body, up or down."""

    UNIT: ClassVar[str] = "m/s"
    LEAST: ClassVar[bool] = False
    climb: Text
    """Name of a body on a line, whose trolley it is of."""
    near: Text | None = None
    """A point of a body, "ship.post": counts only near it. Absent: always."""
    within: PositiveLength | None = None
    """Horizontal distance in m from that point within which it counts."""
    beyond: PositiveLength | None = None
    """Horizontal distance in m from that point beyond which alone it counts. Absent: none."""
    while_hauled: bool = False
    """Counts only until the body has been hauled to its stop."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: PositiveSpeed | None = None
    """Largest speed in m/s that is safe. Absent: none."""

    @property
    def body(self) -> str:
        """Name of the body."""
        return self.climb

    @property
    def words(self) -> str:
        """What it is."""
        return f"vertical speed of {self.climb}"

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where a distance has nothing that it counts from, or the reverse."""
        yield from _together(self)


def _together(measure: HeightMeasure | SpeedMeasure) -> Iterator[Problem]:
    bounds = (measure.within, measure.beyond)
    if measure.near is None and bounds != (None, None):
        yield Problem(("near",), "expected near with within or beyond, found no near")
    if measure.near is not None and bounds == (None, None):
        yield Problem(("within",), "expected within or beyond with near, found neither")


class LineMeasure(Part):
    """The largest of something at a place of a line; the key that names the line is its `KIND`."""

    KIND: ClassVar[PlaceKind]
    WORDS: ClassVar[str]
    UNIT: ClassVar[str]
    if TYPE_CHECKING:  # each has its own, where it stands best
        place: float | None
        after: float | None
        limit: float | None

    @property
    def LEAST(self) -> bool:
        """Whether its least value tells of a run, not its largest."""
        return False

    @model_validator(mode="before")
    @classmethod
    def _split_place(cls, data: Any) -> Any:
        return split_place(data, cls.KIND)

    @property
    def at(self) -> str:
        """The line, or the end of it."""
        return getattr(self, self.KIND)

    def target(self) -> tuple[str, Literal["start", "end"] | None, float | None]:
        """Return (line, "start" or "end", None) or (line, None, place in m)."""
        return target_of(self.at, self.place)

    @property
    def words(self) -> str:
        """What it is."""
        return f"{self.WORDS} {self.at}" + ("" if self.place is None else f"@{self.place:g} m")

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where the place is missing or given twice."""
        yield from place_problems(self.KIND, self.at, self.place)


class TensionMeasure(LineMeasure):
    """The largest tension at a place of a line, linear between the middles of segments.

    As of all measures, of the output times alone: a snap between two of them is not seen.
    ``tension = "rope@30 m"`` is short for ``tension = "rope"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "tension"
    WORDS: ClassVar[str] = "tension at"
    UNIT: ClassVar[str] = "N"
    tension: Annotated[Text, AfterValidator(target_text)]
    """The end ("rope.end"), or the line ("rope") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: NonNegativeForce | None = None
    """Largest tension in N that is safe. Absent: none."""


class BendingMeasure(LineMeasure):
    """The largest bending moment at a place of a line that bends, linear between nodes.

    ``bending_moment = "pipe@30 m"`` is short for ``bending_moment = "pipe"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "bending_moment"
    WORDS: ClassVar[str] = "bending moment at"
    UNIT: ClassVar[str] = "N m"
    bending_moment: Annotated[Text, AfterValidator(target_text)]
    """The end ("pipe.end"), or the line ("pipe") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: PositiveTorque | None = None
    """Largest bending moment in N m that is safe. Absent: none."""


class LineSpeedMeasure(LineMeasure):
    """The largest speed of a place of a line, linear between nodes.

    ``speed = "rope@30 m"`` is short for ``speed = "rope"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "speed"
    WORDS: ClassVar[str] = "speed of"
    UNIT: ClassVar[str] = "m/s"
    speed: Annotated[Text, AfterValidator(target_text)]
    """The end ("rope.end"), or the line ("rope") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: PositiveSpeed | None = None
    """Largest speed in m/s that is safe. Absent: none."""


class MotionMeasure(LineMeasure):
    """The largest or the least of the motion of a place of a line, or of a component of it."""

    if TYPE_CHECKING:  # likewise
        component: Literal["x", "y", "z"] | None
        extreme: Literal["largest", "least"]

    @property
    def LEAST(self) -> bool:
        """Whether its least value tells of a run, not its largest."""
        return self.extreme == "least"

    @property
    def words(self) -> str:
        """What it is."""
        return super().words + ("" if self.component is None else f" in {self.component}")

    def problems(self) -> Iterator[Problem]:
        """Yield a fault in the place, and a limit that no size can be within."""
        yield from super().problems()
        if self.component is None and self.limit is not None and self.limit <= 0.0:
            yield Problem(
                ("limit",),
                f"expected a positive limit of a {self.KIND} without component, which is a size, "
                f"found {format_quantity(self.limit, self.UNIT)}",
            )


class PositionMeasure(MotionMeasure):
    """A coordinate of a place of a line, linear between nodes.

    ``position = "rope@30 m"`` is short for ``position = "rope"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "position"
    WORDS: ClassVar[str] = "position of"
    UNIT: ClassVar[str] = "m"
    position: Annotated[Text, AfterValidator(target_text)]
    """The end ("rope.end"), or the line ("rope") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    component: Literal["x", "y", "z"]  # type: ignore[assignment] (needed, which the others' is not)
    """Which coordinate."""
    extreme: Literal["largest", "least"] = "largest"
    """Which value the summary has."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: Length | None = None
    """Largest coordinate in m that is safe, or the least. Absent: none."""


class VelocityMeasure(MotionMeasure):
    """The velocity of a place of a line, linear between nodes.

    ``velocity = "rope@30 m"`` is short for ``velocity = "rope"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "velocity"
    WORDS: ClassVar[str] = "velocity of"
    UNIT: ClassVar[str] = "m/s"
    velocity: Annotated[Text, AfterValidator(target_text)]
    """The end ("rope.end"), or the line ("rope") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    component: Literal["x", "y", "z"] | None = None
    """Component of the velocity. Absent: its size."""
    extreme: Literal["largest", "least"] = "largest"
    """Which value the summary has."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: Speed | None = None
    """Largest velocity in m/s that is safe, or the least. Absent: none."""


class DisplacementMeasure(MotionMeasure):
    """How far a place of a line is from where it was when the run started, linear between nodes.

    ``displacement = "rope@30 m"`` is short for ``displacement = "rope"`` with ``place = "30 m"``.
    """

    KIND: ClassVar[PlaceKind] = "displacement"
    WORDS: ClassVar[str] = "displacement of"
    UNIT: ClassVar[str] = "m"
    displacement: Annotated[Text, AfterValidator(target_text)]
    """The end ("rope.end"), or the line ("rope") at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    component: Literal["x", "y", "z"] | None = None
    """Component of the displacement. Absent: its size."""
    extreme: Literal["largest", "least"] = "largest"
    """Which value the summary has."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: Length | None = None
    """Largest displacement in m that is safe, or the least. Absent: none."""


class ElevationMeasure(Part):
    """The highest that the waves come at a place: what a wave gauge shows."""

    UNIT: ClassVar[str] = "m"
    LEAST: ClassVar[bool] = False
    elevation: tuple[Length, Length]
    """Place x and y of the gauge in m."""
    after: NonNegativeTime | None = None
    """Time in s from which on it counts, such as when waves have grown. Absent: from the start."""
    limit: Length | None = None
    """Largest height in m over the water at rest that is safe. Absent: none."""

    @property
    def words(self) -> str:
        """What it is."""
        x, y = (format_quantity(value, "m") for value in self.elevation)
        return f"height of the waves at x = {x}, y = {y}"


BodyMeasure = HeightMeasure | SpeedMeasure
_KINDS = {
    "height": HeightMeasure,
    "climb": SpeedMeasure,
    "tension": TensionMeasure,
    "bending_moment": BendingMeasure,
    "speed": LineSpeedMeasure,
    "position": PositionMeasure,
    "velocity": VelocityMeasure,
    "displacement": DisplacementMeasure,
    "elevation": ElevationMeasure,
}
_MEASURE = f"a table with {either(_KINDS)}"


def _pick_measure(value: Any) -> str:
    for key, kind in _KINDS.items():
        if isinstance(value, kind) or (isinstance(value, dict) and key in value):
            return key
    raise fault(f"expected {_MEASURE}, found {found(value)}")


Measure = Annotated[
    Annotated[HeightMeasure, Tag(tag("height"))]
    | Annotated[SpeedMeasure, Tag(tag("climb"))]
    | Annotated[TensionMeasure, Tag(tag("tension"))]
    | Annotated[BendingMeasure, Tag(tag("bending_moment"))]
    | Annotated[LineSpeedMeasure, Tag(tag("speed"))]
    | Annotated[PositionMeasure, Tag(tag("position"))]
    | Annotated[VelocityMeasure, Tag(tag("velocity"))]
    | Annotated[DisplacementMeasure, Tag(tag("displacement"))]
    | Annotated[ElevationMeasure, Tag(tag("elevation"))],
    *choose(_pick_measure, _MEASURE),
]
"""A number of a run that its scene asks for."""
