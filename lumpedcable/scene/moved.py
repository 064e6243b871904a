"""Bodies that are moved along: ships whose motion is known, with points that lines are tied to."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import Field, Tag

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody
from lumpedcable.scene.motions import FREEDOMS, HarmonicBody, RecordedBody, SeaBody
from lumpedcable.scene.part import Name, Part, choose, did_you_mean_key, tag
from lumpedcable.scene.quantities import Position, PositiveLength, fault, found

_MOTION = f"a table with any of {', '.join(FREEDOMS)}, or with file, or with rao"


def _pick(value: Any) -> str:
    if isinstance(value, Part):
        kinds = {HarmonicBody: "harmonic", RecordedBody: "recorded", SeaBody: "sea"}
        return kinds[type(value)]
    if not isinstance(value, dict):
        raise fault(f"expected {_MOTION}, found {found(value)}")
    if {"rao", "omega"} & value.keys():
        return "sea"
    if {"file", "time"} & value.keys():
        return "recorded"
    keys = (*FREEDOMS, "file", "rao")
    if not set(FREEDOMS) & value.keys():
        raise fault(f"expected {_MOTION}, found {found(value)}{did_you_mean_key(value, keys)}")
    return "harmonic"


BodyMotion = Annotated[
    Annotated[HarmonicBody, Tag(tag("harmonic"))]
    | Annotated[RecordedBody, Tag(tag("recorded"))]
    | Annotated[SeaBody, Tag(tag("sea"))],
    *choose(_pick, _MOTION),
]


class MovedBody(Part):
    """A body that something else moves, such as a ship in waves, with points on it."""

    DRAWN: ClassVar[tuple[str, ...]] = ("size",)

    position: Position
    """Mean place of its origin in m; it turns about axes through it."""
    motion: BodyMotion
    """How it moves."""
    points: dict[Name, Position] = Field(default_factory=dict)
    """Places on the body in m from its origin, in its own axes, by name."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength] | None = None
    """Length, breadth and height in m of the box about its origin that pictures show. Absent: a ball."""


BODIES: dict[str, type[Part]] = {"motion": MovedBody, "on": CarriedBody, "mass": Body}
"""The one place where the key that tells bodies apart becomes a class."""
_BODY = "a table with mass, with mass and on, or with motion"


def _pick_body(value: Any) -> str:
    if isinstance(value, Part):
        return next(kind for kind, cls in BODIES.items() if isinstance(value, cls))
    if not isinstance(value, dict):
        raise fault(f"expected {_BODY}, found {found(value)}")
    return next((kind for kind in BODIES if kind in value), "mass")


AnyBody = Annotated[
    Annotated[MovedBody, Tag(tag("motion"))]
    | Annotated[CarriedBody, Tag(tag("on"))]
    | Annotated[Body, Tag(tag("mass"))],
    *choose(_pick_body, _BODY),
]
"""A body; ``motion`` says that it is moved, ``on`` that it runs along a line."""
