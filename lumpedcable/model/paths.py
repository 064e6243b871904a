"""Inextensible lines as paths: nodes and bodies one after the other, rods between them.

Structure alone, plain Python over a model: lines that are joined end to end, from a free or held end or
a body to the next, make one path. Along it everything couples to its neighbours only.
"""

from dataclasses import dataclass, field

from lumpedcable.model.ends import Attached, Joined, end_name
from lumpedcable.model.model import LineEnd, Model

__all__ = ["AFTER", "BEFORE", "Leg", "Path", "paths_of"]

BEFORE, AFTER = 0, 1  # sides of a place: that of the rod before it, and of the rod after it


@dataclass(frozen=True)
class Leg:
    """A line of a path: its first place and rod there, and whether it runs from its end to its start."""

    line: str
    first: int
    rods: int
    backward: bool


@dataclass(frozen=True)
class Path:
    """A chain of `places`, with `places` - 1 rods. Bodies and junctions by their place."""

    legs: tuple[Leg, ...]
    places: int
    bodies: dict[int, str] = field(hash=False)
    junctions: dict[int, int] = field(hash=False)
    points: dict[tuple[int, int], LineEnd] = field(hash=False)  # by place and side


def _knot(model: Model, side: LineEnd):
    """What an end is tied to that other ends may be tied to as well, None where nothing is."""
    end = model.end(*side)
    if isinstance(end, Attached):
        return ("body", end.body)
    if isinstance(end, Joined):
        return ("junction", end.junction)
    return None


def _other(side: LineEnd) -> LineEnd:
    return side[0], -1 - side[1]


def paths_of(model: Model) -> tuple[Path, ...]:
    """The paths of a model whose lines are all inextensible.

    Raises:
        ValueError: three ends meet at one place, or a path closes on itself.
    """
    at: dict[tuple, list[LineEnd]] = {}
    for name in sorted(model.lines):
        for node in (0, -1):
            if (knot := _knot(model, (name, node))) is not None:
                at.setdefault(knot, []).append((name, node))
    for (kind, name), sides in at.items():
        if len(sides) > 2:
            ends = ", ".join(end_name(line, node) for line, node in sides)
            where = f'at the body "{name}"' if kind == "body" else "at one place"
            raise ValueError(
                f"expected at most two ends of inextensible lines {where}, found {ends}"
            )
    left = set(model.lines)
    paths = []
    while left:
        path = _walk(model, at, left, _loose_end(model, at, left))
        left -= {leg.line for leg in path.legs}
        paths.append(path)
    return tuple(paths)


def _next(at, model: Model, side: LineEnd) -> LineEnd | None:
    """The end that goes on from an end, None where the path ends."""
    knot = _knot(model, side)
    sides = [] if knot is None else [s for s in at[knot] if s != side]
    return sides[0] if sides else None


def _loose_end(model: Model, at, left: set[str]) -> LineEnd:
    for name in sorted(left):
        for node in (0, -1):
            if _next(at, model, (name, node)) is None:
                return name, node
    raise ValueError(
        f"expected inextensible lines that end somewhere, found a loop of {', '.join(sorted(left))}"
    )


def _walk(model: Model, at, left: set[str], side: LineEnd) -> Path:
    legs, bodies, junctions, points = [], {}, {}, {}
    place, here = 0, side
    while here is not None:
        name, node = here
        if name not in left:
            raise ValueError(
                f"expected inextensible lines that end somewhere, found a loop at {name}"
            )
        rods = model.lines[name].segments
        legs.append(Leg(name, place, rods, node == -1))
        for end, where, which in ((here, place, AFTER), (_other(here), place + rods, BEFORE)):
            knot = _knot(model, end)
            if knot is not None:
                (bodies if knot[0] == "body" else junctions)[where] = knot[1]
            points[where, which] = end
        place += rods
        here = _next(at, model, _other(here))
        left = left - {name}
    return Path(tuple(legs), place + 1, bodies, junctions, points)
