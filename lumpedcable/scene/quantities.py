"""The numbers of a scene: annotated types that know their SI unit and refuse any other dimension.

A field typed ``Length`` accepts a plain number in metres or a text such as "50 mm", and holds a
float in metres afterwards. The unit travels with the type (see :class:`Quantity`), so that errors,
the JSON schema and the axes of a sweep can state it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from lumpedcable.scene.units import (
    UnitError,
    describe,
    format_quantity,
    parse_quantity,
    split_quantity,
    unit_of,
)

NAME_PATTERN = r"[A-Za-z][A-Za-z0-9_-]*"
MAX_COUNT = 1_000_000
"""Largest count a scene may ask for (segments, iterations are bounded by it)."""
_SHOWN = 60  # characters of a wrong value that are told


def fault(text: str, key: str | None = None) -> PydanticCustomError:
    """Return the error that a validator raises to say ``text`` to the user as it stands.

    ``key`` is the one to blame in a table that is validated as a whole.
    """
    return PydanticCustomError("scene", "{text}", {"text": text, "key": key})


def found(value: Any) -> str:
    """Return how a wrong value is named in an error: 3, "text", a list of 3, a table."""
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"' if len(value) <= _SHOWN else f'"{value[: _SHOWN - 3]}..."'
        # Python writes no number out of thousands of digits
        case int() if abs(value) >= 10**_SHOWN:
            return f"a whole number of more than {_SHOWN} digits"
        case int() | float():
            return str(value)
        case list() | tuple():
            return f"a list of {len(value)}"
        case dict():
            return f"a table with {', '.join(map(str, value))}" if value else "an empty table"
        case None:
            return "nothing"
        case _:
            return f"a {type(value).__name__}"


@dataclass(frozen=True)
class Quantity:
    """What a numeric field holds: its SI unit, its sign, and the largest value it may take."""

    unit: str
    sign: Literal["any", "positive", "nonnegative"] = "any"
    maximum: float | None = None
    words: str | None = None
    """What it is, "a moment (N m)", where its dimension does not tell."""

    @property
    def expected(self) -> str:
        """The text after "expected", for example "a positive length (m)"."""
        name = describe(unit_of(self.unit)[1]) if self.unit else "a number"
        name = self.words or name
        if self.sign != "any":
            article, rest = name.split(" ", 1)
            word = {"positive": "positive", "nonnegative": "non-negative"}[self.sign]
            name = f"a {word} {rest}" if article in ("a", "an") else name
        if self.maximum is not None:
            name += f" of at most {format_quantity(self.maximum, self.unit)}"
        return name

    def read(self, value: Any) -> float:
        """Return ``value`` in SI.

        Raises:
            PydanticCustomError: another dimension, not finite, or out of range.
        """
        if isinstance(value, str):
            try:
                number = parse_quantity(value, self.unit)
            except UnitError as error:
                raise fault(f"expected {self.expected}, found {error}") from None
        elif isinstance(value, bool) or not isinstance(value, int | float):
            raise fault(f"expected {self.expected}, found {found(value)}")
        else:
            number = self._finite(value)
        if (
            (self.sign == "positive" and number <= 0)
            or (self.sign == "nonnegative" and number < 0)
            or (self.maximum is not None and number > self.maximum)
        ):
            raise fault(f"expected {self.expected}, found {found(value)}")
        return number

    def _finite(self, value: float) -> float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise fault(f"expected {self.expected}, found {found(value)}, which is not finite")
        return number

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        number: dict[str, Any] = {"type": "number"}
        if self.sign == "positive":
            number["exclusiveMinimum"] = 0
        elif self.sign == "nonnegative":
            number["minimum"] = 0
        if self.maximum is not None:
            number["maximum"] = self.maximum
        unit = f"in {self.unit} where it is a plain number" if self.unit else "or a percentage"
        # The sign belongs to the number: a text is only asked to look like a number with a unit.
        text = {
            "type": "string",
            "pattern": _TEXT if self.unit else _BARE_TEXT,
            "description": f"a number and a unit such as {self.unit or '%'}",
        }
        return {"anyOf": [number, text], "description": f"{self.expected}, {unit}"}


_DIGITS = r"^\s*[+\u2212-]?(\d[\d_]*(\.\d*)?|\.\d+)([eE][+\u2212-]?\d+)?\s*"
_TEXT = _DIGITS + r"[A-Za-zµμ°%(].*$"
_BARE_TEXT = _DIGITS + r"%?\s*$"


@dataclass(frozen=True)
class ReferenceNumber(Quantity):
    """A number from elsewhere, of any dimension; nan says that the source gives none."""

    unit: str = ""

    @property
    def expected(self) -> str:
        """The text after "expected"."""
        return "a number, with or without a unit (nan where the source gives none)"

    def read(self, value: Any) -> float:
        """Return ``value`` in SI, whatever its dimension."""
        if isinstance(value, str):
            try:
                number, unit = split_quantity(value)
                return parse_quantity(value, unit) if unit else number
            except UnitError as error:
                raise fault(f"expected {self.expected}, found {error}") from None
        if isinstance(value, float) and math.isnan(value):
            return value
        return super().read(value)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"type": ["number", "string"], "description": self.expected}


@dataclass(frozen=True)
class Count:
    """A whole number from ``minimum`` to :data:`MAX_COUNT`."""

    minimum: int = 1
    maximum: int = MAX_COUNT
    unit: str = ""

    @property
    def expected(self) -> str:
        """The text after "expected"."""
        return f"a whole number from {self.minimum} to {self.maximum}"

    def read(self, value: Any) -> int:
        """Return ``value``, which must be an int in range.

        Raises:
            PydanticCustomError: anything else.
        """
        if isinstance(value, bool) or not isinstance(value, int):
            raise fault(f"expected {self.expected}, found {found(value)}")
        if not self.minimum <= value <= self.maximum:
            raise fault(f"expected {self.expected}, found {found(value)}")
        return value

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {
            "type": "integer",
            "minimum": self.minimum,
            "maximum": self.maximum,
            "description": self.expected,
        }


Length = Annotated[float, Quantity("m")]
NonNegativeLength = Annotated[float, Quantity("m", "nonnegative")]
PositiveLength = Annotated[float, Quantity("m", "positive")]
Force = Annotated[float, Quantity("N")]
PositiveForce = Annotated[float, Quantity("N", "positive")]
NonNegativeForce = Annotated[float, Quantity("N", "nonnegative")]
Time = Annotated[float, Quantity("s")]
PositiveTime = Annotated[float, Quantity("s", "positive")]
NonNegativeTime = Annotated[float, Quantity("s", "nonnegative")]
PositiveMass = Annotated[float, Quantity("kg", "positive")]
MassPerLength = Annotated[float, Quantity("kg/m", "positive")]
Density = Annotated[float, Quantity("kg/m3", "positive")]
Speed = Annotated[float, Quantity("m/s")]
PositiveSpeed = Annotated[float, Quantity("m/s", "positive")]
Acceleration = Annotated[float, Quantity("m/s2", "positive")]
KinematicViscosity = Annotated[float, Quantity("m2/s", "positive")]
MomentOfInertia = Annotated[float, Quantity("kg m2", "positive")]
BendingStiffness = Annotated[float, Quantity("N m2", "positive")]
Damping = Annotated[float, Quantity("N s", "nonnegative")]
Damper = Annotated[float, Quantity("N s/m", "nonnegative")]
FoundationStiffness = Annotated[float, Quantity("Pa", "positive")]
FoundationDamping = Annotated[float, Quantity("Pa s", "nonnegative")]
Torque = Annotated[float, Quantity("N m", words="a moment (N m)")]
PositiveTorque = Annotated[float, Quantity("N m", "positive", words="a moment (N m)")]
Spring = Annotated[float, Quantity("N/m", "nonnegative", words="a stiffness (N/m)")]
PositiveSpring = Annotated[float, Quantity("N/m", "positive", words="a stiffness (N/m)")]
TurnSpring = Annotated[float, Quantity("N m/rad", "nonnegative", words="a stiffness (N m/rad)")]
TurnDamper = Annotated[
    float, Quantity("N m s/rad", "nonnegative", words="a damping constant (N m s/rad)")
]
Volume = Annotated[float, Quantity("m3", "positive")]
Angle = Annotated[float, Quantity("rad")]
Number = Annotated[float, Quantity("")]
PositiveNumber = Annotated[float, Quantity("", "positive")]
NonNegativeNumber = Annotated[float, Quantity("", "nonnegative")]
Fraction = Annotated[float, Quantity("", "positive", 1.0)]
SegmentCount = Annotated[int, Count(1)]

Position = tuple[Length, Length, Length]
"""Three coordinates in m; z is up."""
Velocity = tuple[Speed, Speed, Speed]
"""Three components in m/s."""
