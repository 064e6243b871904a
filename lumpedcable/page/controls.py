"""Sliders of the live page, and what a browser may ask of them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lumpedcable.results.errors import nearest
from lumpedcable.results.human import scale

__all__ = ["Control", "FaultError", "Model", "chosen"]


class FaultError(ValueError):
    """What a page asks for cannot be; the message, for its reader, says why."""


@dataclass(frozen=True)
class Control:
    """A number that can be dragged.

    Attributes:
        key: its name in what the page asks.
        group: the heading that it stands under.
        words: what it is.
        unit: its SI unit, "" if none.
        value: where it starts.
        low, high: the range of its slider; a number typed in may lie outside.
    """

    key: str
    group: str
    words: str
    unit: str
    value: float
    low: float
    high: float

    def head(self) -> dict[str, Any]:
        """It for the page, with the factor and unit to show it in."""
        largest = max(abs(self.low), abs(self.high))
        factor, unit = (1.0, self.unit) if self.unit == "m" else scale(largest, self.unit)
        return {
            "key": self.key,
            "group": self.group,
            "words": self.words,
            "value": self.value,
            "low": self.low,
            "high": self.high,
            "factor": factor,
            "unit": unit,
            "top": largest * factor,
        }


@dataclass(frozen=True)
class Model:
    """Something at rest that depends on numbers.

    Attributes:
        key: its name in what the page asks.
        words: its title.
        controls: its numbers.
        solve: values by key to what the page draws; FaultError with words for the reader.
        toml: values by key to a scene's text.
        remark: what its numbers are of, "" if it needs no words.
    """

    key: str
    words: str
    controls: Sequence[Control]
    solve: Callable[[dict[str, float]], dict[str, Any]]
    toml: Callable[[dict[str, float]], str]
    remark: str = ""

    def head(self) -> dict[str, Any]:
        """It for the page."""
        return {
            "key": self.key,
            "words": self.words,
            "remark": self.remark,
            "controls": [control.head() for control in self.controls],
        }


def chosen(models: Mapping[str, Model], asked: Any) -> tuple[Model, dict[str, float]]:
    """The model and the values that a page asks for.

    Args:
        models: by key.
        asked: the JSON value {"model": key, "values": {key: number, ...}}.

    Raises:
        FaultError: it is not such a value.
    """
    if not isinstance(asked, dict) or not isinstance(asked.get("values"), dict):
        raise FaultError('expected {"model": ..., "values": {...}}')
    key = asked.get("model")
    if not isinstance(key, str) or key not in models:
        raise FaultError(f"expected a model, one of {', '.join(models)}, found {key!r}")
    model = models[key]
    known = {control.key: control for control in model.controls}
    values = {}
    for name, value in asked["values"].items():
        if name not in known:
            close = nearest(name, known)
            raise FaultError(f"no number {name!r}" + (f"; nearest: {close}" if close else ""))
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not abs(value) <= sys.float_info.max:
            raise FaultError(f"{known[name].words}: expected a number, found {value!r:.40}")
        values[name] = float(value)
    return model, values
