"""What happens while a scene runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from lumpedcable.scene.part import Part, Path, Problem, Text
from lumpedcable.scene.quantities import (
    NAME_PATTERN,
    Length,
    NonNegativeTime,
    PositiveForce,
    fault,
    found,
)

_TARGET = re.compile(rf"({NAME_PATTERN})(?:\.(start|end)|@(.+))?", re.DOTALL)


def target_text(text: str) -> str:
    """Return a text that names a place on a line; a fault where it does not."""
    if not _TARGET.fullmatch(text):
        raise fault(
            'expected a place on a line: "LINE.start", "LINE.end" or "LINE@DISTANCE", '
            f"found {found(text)}"
        )
    return text


def split_place(data: Any, key: str) -> Any:
    """Return a table with "rope@37.5 m" under ``key`` as one with "rope" and place = "37.5 m"."""
    if isinstance(data, dict) and "place" not in data and isinstance(data.get(key), str):
        line, at, place = data[key].partition("@")
        if at and _TARGET.fullmatch(data[key]):
            return {**data, key: line, "place": place.strip()}
    return data


SHORT = {
    "events": ("breaks",),
    "measures": ("tension", "bending_moment", "speed", "position", "velocity", "displacement"),
}
"""Keys under which "LINE@DISTANCE" may stand, by section."""


def with_place(data: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return raw data in which a place that `path` names stands under its own key, if it is given.

    So a place written "rope@37.5 m" can be swept and overridden like any other.
    """
    if len(path) != 3 or path[0] not in SHORT or path[2] != "place":
        return data
    section, name = data.get(path[0]), path[1]
    if not isinstance(section, dict) or name not in section:
        return data
    entry = section[name]
    for key in SHORT[path[0]]:
        entry = split_place(entry, key)
    return {**data, path[0]: {**section, name: entry}}


def target_of(
    name: str, place: float | None
) -> tuple[str, Literal["start", "end"] | None, float | None]:
    """Return (line, "start" or "end", None) or (line, None, place in m)."""
    line, _, side = name.partition(".")
    return line, (side or None), place  # type: ignore[return-value]


def place_problems(key: str, name: str, place: float | None) -> Iterator[Problem]:
    """Yield a fault where the place is missing or given twice."""
    whole_line = re.fullmatch(NAME_PATTERN, name) is not None
    if whole_line and place is None:
        yield Problem(
            (key,),
            f'expected where: "{name}.start", "{name}.end", '
            f"or a place (m), found {found(name)} alone",
        )
    elif not whole_line and place is not None:
        yield Problem(("place",), f"expected one place, found place and {key} = {found(name)}")


class Event(Part):
    """A line parts: the force at the break falls as F(t) = F0 cos^2(pi/2 (t - start)/time).

    ``breaks = "rope@37.5 m"`` is short for ``breaks = "rope"`` with ``place = "37.5 m"`` and is
    read as that, so that the place is a number like any other.
    """

    breaks: Annotated[Text, AfterValidator(target_text)]
    """The end that breaks ("rope.end"), or the line ("rope") that breaks at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    time: NonNegativeTime
    """How long the break takes in s; 0 is instantaneous."""
    start: NonNegativeTime = 0.0
    """When it begins, in s; before the run ends."""
    tension: PositiveForce | None = None
    """Instead of a start: it begins when what holds the line there first pulls with this, in N."""

    @model_validator(mode="before")
    @classmethod
    def _split_place(cls, data: Any) -> Any:
        return split_place(data, "breaks")

    def target(self) -> tuple[str, Literal["start", "end"] | None, float | None]:
        """Return (line, "start" or "end", None) or (line, None, place in m)."""
        return target_of(self.breaks, self.place)

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where the place is missing or given twice, or when it begins is given twice."""
        yield from place_problems("breaks", self.breaks, self.place)
        if self.tension is not None and "start" in self.model_fields_set:
            yield Problem(
                ("start",),
                "expected one beginning, at a time or at a tension, found start and tension",
            )
