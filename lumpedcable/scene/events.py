"""What happens while a scene runs."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, model_validator

from lumpedcable.scene.part import Part, Problem, Text
from lumpedcable.scene.quantities import NAME_PATTERN, Length, NonNegativeTime, fault, found

_TARGET = re.compile(rf"({NAME_PATTERN})(?:\.(start|end)|@(.+))?", re.DOTALL)


def _target(text: str) -> str:
    if not _TARGET.fullmatch(text):
        raise fault(
            'expected a place on a line: "LINE.start", "LINE.end" or "LINE@DISTANCE", '
            f"found {found(text)}"
        )
    return text


class Event(Part):
    """A line parts: the force at the break falls as F(t) = F0 cos^2(pi/2 (t - start)/time).

    ``breaks = "rope@37.5 m"`` is short for ``breaks = "rope"`` with ``place = "37.5 m"`` and is
    read as that, so that the place is a number like any other.
    """

    breaks: Annotated[Text, AfterValidator(_target)]
    """The end that breaks ("rope.end"), or the line ("rope") that breaks at ``place``."""
    place: Length | None = None
    """Unstretched distance in m from the start of the line."""
    time: NonNegativeTime
    """How long the break takes in s; 0 is instantaneous."""
    start: NonNegativeTime = 0.0
    """When it begins, in s."""

    @model_validator(mode="before")
    @classmethod
    def _split_place(cls, data: Any) -> Any:
        if isinstance(data, dict) and "place" not in data and isinstance(data.get("breaks"), str):
            line, at, place = data["breaks"].partition("@")
            if at and _TARGET.fullmatch(data["breaks"]):
                return {**data, "breaks": line, "place": place.strip()}
        return data

    def target(self) -> tuple[str, Literal["start", "end"] | None, float | None]:
        """Return (line, "start" or "end", None) or (line, None, place in m)."""
        line, _, side = self.breaks.partition(".")
        return line, (side or None), self.place  # type: ignore[return-value]

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where the place is missing or given twice."""
        whole_line = re.fullmatch(NAME_PATTERN, self.breaks) is not None
        if whole_line and self.place is None:
            yield Problem(
                ("breaks",),
                f'expected where: "{self.breaks}.start", "{self.breaks}.end", '
                f"or a place (m), found {found(self.breaks)} alone",
            )
        elif not whole_line and self.place is not None:
            yield Problem(
                ("place",), f"expected one place, found place and breaks = {found(self.breaks)}"
            )
