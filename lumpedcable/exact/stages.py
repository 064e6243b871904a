"""The stages of a highline as functions of a few numbers, fast enough to follow a slider.

W. Lun, Q. Li & H. Hou (2018) divide a replenishment at sea into six stages and show for each the
shape of the line with its equation, length, sag and tensions. Here each stage is a function of named
numbers in SI; one call takes milliseconds and compiles nothing. Defaults are the paper's where it has
them (its section 5.2), else a sensible value.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np
from numpy.typing import ArrayLike

from .cargo import (
    StraightHighline,
    loaded_from_length,
    loaded_from_tension,
    straight_from_length,
    straight_from_tension,
)
from .checks import NO_LINE
from .dragged import dragged_from_tension
from .highline import (
    Highline,
    highline_from_length,
    highline_from_sag,
    highline_from_tension,
)
from .law import Array

__all__ = ["STAGES", "UNITS", "Slider", "Stage", "StageShape", "stage_shape"]

UNITS = {"S": "m", "S_traction": "m", "f": "m", "F_TA": "N", "F_TB": "N", "F_H": "N"}
"""Units of the numbers of a shape; S_traction is the traction cable's length."""

JOINT = "joint"


@dataclass(frozen=True)
class Slider:
    """A number that a stage depends on.

    Attributes:
        words: what it is.
        unit: its SI unit.
        value: its default.
        low, high: the range worth showing; other values are allowed as far as they have a shape.
    """

    words: str
    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class StageShape:
    """A line at one instant of a stage.

    Attributes:
        x, z: the line, m, shape (points,); 0 at the sending end A, z up.
        equations: the shape equation, one text a part, x and z in m.
        numbers: S, f (m), F_TA, F_TB, F_H (N), units in `UNITS`; f is the depth under the chord at
            `mark`, or at mid-span. Where the line is dragged, S is the highline's own length.
        mark: x and z (m) of the cargo, or of the joint with the traction cable; None without either.
        mark_words: what is there, "" without.
        split: index of the first point after `mark`, None without.
        approximate: the same by straight segments, None where nothing hangs on the line.
    """

    x: Array
    z: Array
    equations: tuple[str, ...]
    numbers: Mapping[str, float]
    mark: tuple[float, float] | None = None
    mark_words: str = ""
    split: int | None = None
    approximate: "StageShape | None" = None


@dataclass(frozen=True)
class Stage:
    """One stage: what it is called, its numbers, and its line for given numbers.

    Attributes:
        words: its title.
        sliders: its numbers by key.
        line: numbers by key to the exact line and its approximation or None.
        mark_words: what is at the line's load or joint.
    """

    words: str
    sliders: Mapping[str, Slider]
    line: Callable[..., tuple[Highline, StraightHighline | None]]
    mark_words: str = ""


def stage_shape(stage: str, points: int = 201, **numbers: float) -> StageShape:
    """Return the shape, its equation, S, f, F_TA, F_TB and F_H of a stage.

    Args:
        stage: a key of `STAGES`.
        points: how many points of the line; one more where it has a load or a joint.
        numbers: SI values of the stage's sliders; a missing one has its default.

    Raises:
        ValueError: no such stage or number, or numbers for which there is no line (a tension too low,
            a line too short, a cargo off the span); the message says which.
    """
    if stage not in STAGES:
        raise ValueError(f"expected a stage, found {_unknown(stage, STAGES)}")
    chosen = STAGES[stage]
    for name in numbers:
        if name not in chosen.sliders:
            raise ValueError(
                f"expected a number of {stage}, found {_unknown(name, chosen.sliders)}"
            )
    values = {key: float(numbers.get(key, s.value)) for key, s in chosen.sliders.items()}
    line, straight = chosen.line(**values)
    shape = _drawn(line, points, chosen.mark_words)
    if straight is None:
        return shape
    return replace(shape, approximate=_drawn(straight, points, chosen.mark_words))


def _unknown(name: str, known: Mapping[str, object]) -> str:
    near = get_close_matches(name, known, 1)
    return f'"{name}"; ' + (f'did you mean "{near[0]}"?' if near else f"known: {', '.join(known)}")


def _drawn(line: Highline | StraightHighline, points: int, words: str) -> StageShape:
    """The points, equations and numbers of a line."""
    x = np.linspace(0.0, float(line.span), points)
    mark = split = None
    if words:
        mark = (float(line.middle[0]), float(line.middle[1]))
        split = int(np.searchsorted(x, mark[0], side="right"))
        x = np.insert(x, split, mark[0])
        split += 1
    numbers = {key: float(value) for key, value in line.numbers().items()}
    if isinstance(line, Highline) and words == JOINT:
        own, traction = (float(part.length) for part in line.parts)
        numbers = {**numbers, "S": own, "S_traction": traction}
    z = np.asarray(line.height(x), float)
    parts = line.parts if isinstance(line, Highline) else ()
    sizes = [float(part.horizontal / part.weight / line.span) for part in parts]
    if not (np.isfinite([*numbers.values(), *x, *z, *sizes]).all() and all(s > 0.0 for s in sizes)):
        raise ValueError(NO_LINE)
    return StageShape(x, z, _equations(line), numbers, mark, words, split)


def _equations(line: Highline | StraightHighline) -> tuple[str, ...]:
    """The shape equation of each part, eqs. (1), (32), as z over x."""
    if isinstance(line, StraightHighline):
        x, z = line.middle
        after = (z + line.drop) / (x - line.span)
        return (
            f"z = {z / x:.6g} x",
            f"z = {_number(z)} {_signed(after)} (x - {_number(x)})",
        )
    found = []
    for part in line.parts:
        size = float(part.horizontal / part.weight)
        # both numbers are of 1 and stand before the size: that leaves 6 digits of the span
        digits = 7 + max(0, math.ceil(math.log10(size / float(line.span))))
        along = "x" if part.x == 0.0 else f"(x - {_number(part.x)})"
        along = f"{along}/{size:.{digits}g}"
        start = "" if part.z == 0.0 else f"{_number(part.z)} + "
        found.append(
            f"z = {start}{size:.{digits}g} [cosh({_number(part.angle, digits)} - {along}) "
            f"- {_number(np.cosh(part.angle), digits)}]"
        )
    return tuple(found)


def _number(value: ArrayLike, digits: int = 6) -> str:
    return f"{float(np.asarray(value)):.{digits}g}"


def _signed(value: ArrayLike) -> str:
    number = float(np.asarray(value))
    return f"{'-' if number < 0.0 else '+'} {abs(number):.6g}"


# --- the stages ---------------------------------------------------------------------------------

_SPAN = {
    "span": Slider("horizontal distance of the posts", "m", 60.0, 20.0, 100.0),
    "drop": Slider("height of the sending end over the receiving end", "m", 16.0, -20.0, 30.0),
    "weight": Slider("weight of the highline per length", "N/m", 40.0, 5.0, 100.0),
}
_TENSION = {"tension": Slider("tension at the sending end", "N", 80e3, 3e3, 200e3)}
_LENGTH = {"length": Slider("length of the highline", "m", 63.34896, 62.2, 80.0)}
_CARGO = {
    "load": Slider("weight of the cargo", "N", 20e3, 1e3, 50e3),
    "place": Slider("distance of the cargo from the sending end", "m", 30.0, 1.0, 59.0),
}
_TRACTION = {
    "speed": Slider("speed at which the highline is paid out or in", "m/s", 1.0, 0.1, 3.0),
    "time": Slider("time since the start of the stage", "s", 30.0, 0.0, 60.0),
    "traction_weight": Slider("weight of the traction cable per length", "N/m", 5.0, 1.0, 40.0),
    "traction": Slider("tension of the traction cable at the receiving end", "N", 4e3, 2e3, 20e3),
}


def _erection(span, drop, weight, speed, time, traction_weight, traction):
    S = speed * time
    return dragged_from_tension(span, drop, weight, S, traction_weight, traction), None


def _withdrawal(span, drop, weight, speed, time, traction_weight, traction, start):
    S = start - speed * time
    return dragged_from_tension(span, drop, weight, S, traction_weight, traction), None


def _from_sag(span, drop, weight, sag):
    return highline_from_sag(span, drop, weight, sag), None


def _from_length(span, drop, weight, length):
    return highline_from_length(span, drop, weight, length), None


def _from_tension(span, drop, weight, tension):
    return highline_from_tension(span, drop, weight, tension), None


def _unloading(span, drop, weight, tension, lowered):
    return highline_from_tension(span, drop + lowered, weight, tension), None


def _delivery(span, drop, weight, load, place, tension):
    return (
        loaded_from_tension(span, drop, weight, load, place, tension),
        straight_from_tension(span, drop, load, place, tension),
    )


def _delivery_length(span, drop, weight, load, place, length):
    return (
        loaded_from_length(span, drop, weight, load, place, length),
        straight_from_length(span, drop, load, place, length),
    )


_SAG = {"sag": Slider("deflection at mid-span", "m", 5.620999, 0.1, 20.0)}
_START = {"start": Slider("length of the highline at the start", "m", 60.0, 5.0, 62.0)}
_LOWERED = {"lowered": Slider("way of the receiving end down its post", "m", 2.0, 0.0, 10.0)}

STAGES: Mapping[str, Stage] = {
    "erection": Stage("Erection", _SPAN | _TRACTION, _erection, JOINT),
    "stabilisation": Stage("Stabilisation, from the sag", _SPAN | _SAG, _from_sag),
    "stabilisation-length": Stage("Stabilisation, from the length", _SPAN | _LENGTH, _from_length),
    "adjustment": Stage("Adjustment", _SPAN | _TENSION, _from_tension),
    "delivery": Stage(
        "Delivery at constant length",
        _SPAN | _CARGO | {"length": replace(_LENGTH["length"], value=62.5)},
        _delivery_length,
        "cargo",
    ),
    "delivery-tension": Stage(
        "Delivery at constant tension", _SPAN | _CARGO | _TENSION, _delivery, "cargo"
    ),
    "unloading": Stage("Unloading", _SPAN | _TENSION | _LOWERED, _unloading),
    "withdrawal": Stage("Withdrawal", _SPAN | _TRACTION | _START, _withdrawal, JOINT),
}
"""The six stages of the paper by name, two of them in two ways."""
