"""Which number of a run is meant: "max velocity at rope.end", "stop time", "min h_w"."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from lumpedcable.fitting.observe import MEASURE, PEAK, STOP, UNITS
from lumpedcable.model.layout import layout_of, make_layout
from lumpedcable.scene import Fault, Scene, SceneError, Study
from lumpedcable.scene.part import did_you_mean
from lumpedcable.study.plan import common_coordinates, recoil_name, recoils_of

__all__ = ["AskedError", "Scalar", "asked_scalar", "read_scalar", "usual_scalar"]

REDUCTIONS = ("max", "min", "mean", "std", "first", "last")
STOP_TIME, PEAKS = "stop time", "peak"
# a place along a line may have a blank before its unit
_SCALAR = re.compile(r"(\w+) (\w+) at (\S+@.+?|\S+)(?: in (\w+))?")
_MEASURE = re.compile(r"(\w+) ([A-Za-z][\w-]*)")


class AskedError(SceneError, ValueError):
    """A number of a run that is asked for is none, or is not there; the message says why."""

    def __init__(self, message: str):
        super().__init__([Fault("", None, "", message)])

    def __reduce__(self) -> tuple[type[SceneError], tuple[Any, ...]]:
        return AskedError, (str(self),)


@dataclass(frozen=True)
class Scalar:
    """One number of a run: the max, min, first or last of a quantity at a place, over the outputs.

    Or its mean or standard deviation over them.
    Or of a measure of the scene, whose name is then `at`, over the outputs at which it counts; or
    when the body `at` came to rest; or the largest tension of a rod at any step.
    """

    reduction: str
    quantity: str
    at: str
    component: str | None
    unit: str

    def __str__(self) -> str:
        if self.quantity == STOP:
            return STOP_TIME
        if self.quantity == MEASURE:
            return f"{self.reduction} {self.at}"
        if self.quantity == PEAK:
            return f"peak tension at {self.at}"
        part = "" if self.component is None else f" in {self.component}"
        return f"{self.reduction} {self.quantity} at {self.at}{part}"

    @property
    def never(self) -> str:
        """What is said where a run has no such number."""
        if self.quantity == STOP:
            return f'expected "{self.at}" to come to rest within output.duration, which it does not'
        return (
            f'expected a measure that counts, found "{self.at}", which never does within '
            "output.duration: take a longer one, or another result"
        )


def asked_scalar(study: Study, of: str | None, run: int) -> Scalar:
    """The scalar of a run that a text means, or the usual one.

    Raises:
        SceneError: the scene cannot be laid out, whatever is asked of it.
        AskedError: the text means none.
    """
    scene = study.runs[run]
    layout_of(study, scene)
    common_coordinates(study, [scene])
    return usual_scalar(scene) if of is None else read_scalar(of, scene)


def read_scalar(text: str, scene: Scene) -> Scalar:
    """The scalar that a text means: "max velocity at rope.end", "last position at rope@30 m in x".

    Of a measure of the scene it is "min h_w"; "stop time" is when the body of output.stop comes to
    rest, "peak tension at rod.start" the largest of every step, of a line of rods.

    Raises:
        AskedError: it means none; the message says what was expected.
    """
    if not isinstance(text, str):
        raise AskedError(f'expected a text as "max velocity at rope.end", found {text!r}')
    text = " ".join(text.split())
    if text == STOP_TIME:
        return _stop_time(scene)
    match = _SCALAR.fullmatch(text)
    expected = (
        'expected "max velocity at LINE.end", "max tension at LINE@30 m", "max displacement at BODY" or '
        "the like"
    )
    measure = _MEASURE.fullmatch(text)
    if measure is not None and measure.group(1) in REDUCTIONS and scene.measures:
        return _measure(scene, *measure.groups())
    if match is None:
        raise AskedError(f'{expected}, found "{text}"')
    reduction, quantity, at, component = match.groups()
    for word, known in ((reduction, (*REDUCTIONS, PEAKS)), (quantity, tuple(UNITS))):
        if word not in known:
            raise AskedError(
                f'expected one of {", ".join(known)}, found "{word}"{did_you_mean(word, known)}'
            )
    if component is not None and (component not in "xyz" or quantity == "tension"):
        wanted = "none for a tension" if quantity == "tension" else "x, y or z"
        raise AskedError(f'expected as component {wanted}, found "{component}"')
    if component is None and quantity == "position":
        raise AskedError(f'expected a component of the position, "{text} in x" or the like')
    if reduction == PEAKS:
        if quantity != "tension":
            raise AskedError(f'expected "peak tension at PLACE", found "{text}": take max')
        return Scalar("max", PEAK, at, None, UNITS["tension"])
    return Scalar(reduction, quantity, at, component, UNITS[quantity])


def _stop_time(scene: Scene) -> Scalar:
    """When the body that ends the run comes to rest."""
    if scene.output.stop is None:
        raise AskedError('expected output.stop = "BODY" in the scene for a stop time, found none')
    return Scalar("last", STOP, scene.output.stop, None, "s")


def _measure(scene: Scene, reduction: str, name: str) -> Scalar:
    """A scalar of a measure."""
    if name not in scene.measures:
        hint = did_you_mean(name, scene.measures)
        raise AskedError(f'expected a measure of the scene, found "{name}"{hint}')
    return Scalar(reduction, MEASURE, name, None, scene.measures[name].UNIT)


def usual_scalar(scene: Scene) -> Scalar:
    """The peak speed of the first end that breaks; else the scene's first measure at its worst; else
    the largest tension at the first line's start.
    """
    recoils = recoils_of(make_layout(scene))
    for recoil in recoils:
        if recoil.line in scene.lines:
            return Scalar("max", "velocity", recoil_name(recoil), None, UNITS["velocity"])
    for name, measure in scene.measures.items():
        return _measure(scene, "min" if measure.LEAST else "max", name)
    at = f"{next(iter(scene.lines))}.start"
    return Scalar("max", "tension", at, None, UNITS["tension"])
