"""What statics must reach by choosing lengths of lines: [targets], and whether it can be asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import WinchEnd
from lumpedcable.scene.events import Event
from lumpedcable.scene.part import SIDES, Part, Path, Problem, Text, did_you_mean, either
from lumpedcable.scene.quantities import Length, PositiveForce, PositiveLength, found

MEASURES = ("tension", "x", "y", "z", "sag", "length")
"""What a target may ask for; each is a key of :class:`Target`."""


class Target(Part):
    """A condition on the state of rest, and the length that is found to meet it."""

    change: Text
    """The number that is found: "lines.NAME.length". Its value in the file is a first guess."""
    of: Text
    """What is asked for a number: a line, its end ("NAME.start"), a body, or "NAME + NAME"."""
    tension: PositiveForce | None = None
    """Tension in N at an end of a line."""
    x: Length | None = None
    """Coordinate in m of a body or of an end of a line."""
    y: Length | None = None
    """Coordinate in m of a body or of an end of a line."""
    z: Length | None = None
    """Coordinate in m of a body or of an end of a line."""
    sag: PositiveLength | None = None
    """Depth in m of a line under the middle of its chord."""
    length: PositiveLength | None = None
    """Unstretched length in m of one line, or of several together."""

    @property
    def measure(self) -> str:
        """The one number of `MEASURES` that is asked for."""
        return next(name for name in MEASURES if getattr(self, name) is not None)

    @property
    def wanted(self) -> float:
        """Its value, in SI."""
        return getattr(self, self.measure)

    @property
    def line(self) -> str:
        """The line whose length is found."""
        return self.change.split(".")[1]

    @property
    def parts(self) -> list[str]:
        """The names in ``of``."""
        return [name.strip() for name in self.of.split("+")]

    def problems(self) -> Iterator[Problem]:
        """Yield a fault where not exactly one number is asked for."""
        given = [name for name in MEASURES if getattr(self, name) is not None]
        if len(given) != 1:
            told = " and ".join(given) or "none"
            yield Problem((), f"expected one of {either(MEASURES)}, found {told}")


def target_problems(
    targets: Mapping[str, Target | None],
    lines: Mapping[str, Any],
    bodies: Mapping[str, Any],
    events: Mapping[str, Event | None],
) -> Iterator[Problem]:
    """Yield what is wrong between targets and the lines, bodies and breaks that they name."""
    cut = {event.target()[0] for event in events.values() if event and event.target()[1] is None}
    taken: dict[str, str] = {}
    for name, target in targets.items():
        if target is None or next(target.problems(), None) is not None:
            continue
        path: Path = ("targets", name)
        known = [f"lines.{line}.length" for line in lines]
        if target.change not in known:
            yield Problem(
                (*path, "change"),
                f'expected the length of a line, "lines.NAME.length", found '
                f"{found(target.change)}{did_you_mean(target.change, known)}",
            )
        elif target.change in taken:
            yield Problem(
                (*path, "change"),
                f'expected each length once, found that of target "{taken[target.change]}" again',
            )
        else:
            taken[target.change] = name
            line = lines[target.line]
            if line is not None and line.segment_lengths is not None:
                yield Problem(
                    (*path, "change"),
                    f'expected a line with segments, found "{target.line}" with segment_lengths',
                )
            elif line is not None and WinchEnd in (type(line.start), type(line.end)):
                yield Problem(
                    (*path, "change"),
                    f'expected a line without a winch, found "{target.line}", whose winch finds how '
                    "much of it is out: ask for the winch's tension",
                )
        yield from _of(target, (*path, "of"), lines, bodies)
        if target.measure == "sag" and target.of in cut:
            yield Problem(
                (*path, "of"),
                f'expected a line in one piece, found "{target.of}", which breaks along itself',
            )


def _of(
    target: Target, path: Path, lines: Mapping[str, Any], bodies: Mapping[str, Any]
) -> Iterator[Problem]:
    ends = [f"{line}.{side}" for line in lines for side in SIDES]
    if target.measure == "tension":
        words, known = "the end of a line", ends
    elif target.measure in ("x", "y", "z"):
        words, known = "a body or the end of a line", [*bodies, *ends]
    else:
        words, known = "a line", list(lines)
    if target.measure == "length":
        words = 'a line, or several as "NAME + NAME"'
    elif len(target.parts) > 1:
        yield Problem(path, f"expected {words}, found {found(target.of)}")
        return
    for name in target.parts:
        if name not in known:
            yield Problem(path, f"expected {words}, found {found(name)}{did_you_mean(name, known)}")
        elif name in bodies and _is_held(bodies[name]):
            yield Problem(
                path,
                f'expected a body that statics moves, found "{name}", which is held where the scene '
                "puts it: a rigid body is found at rest with settle = true",
            )
        elif target.measure == "sag" and lines[name] is not None and lines[name].count == 1:
            told = f'"{name}" with one, which is its chord'
            yield Problem(path, f"expected a line of two segments at least, found {told}")


def _is_held(body: Any) -> bool:
    """Whether statics leaves a body where it is: all but points between lines and what settles."""
    return body is not None and not (isinstance(body, Body) and (body.settle or not body.rigid))
