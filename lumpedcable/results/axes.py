"""A swept number of a results file."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from lumpedcable.results.human import quantity

__all__ = ["Axis"]


class Axis(NamedTuple):
    """A swept number.

    Attributes:
        name: the dataset's name, e.g. "held_pretension".
        key: the full dotted path in the scene.
        unit: SI unit, "" if none.
        values: its value in every run, shape (run,).
        words: what it is called in labels, e.g. "pretension" or "break time".
    """

    name: str
    key: str
    unit: str
    values: NDArray[Any]
    words: str

    def text(self, run: int, digits: int = 6) -> str:
        """Its words and its value in one run, e.g. "break time 5 ms"."""
        return f"{self.words} {quantity(float(self.values[run]), self.unit, digits)}"
