"""What must hold between trolleys, winches, drums and the rest of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody, WinchEnd, post_of, reel_key, stands_at
from lumpedcable.scene.drum_checks import drum_problems
from lumpedcable.scene.ends import (
    HarmonicMotion,
    HeldEnd,
    JoinedEnd,
    MovingEnd,
    held_force,
    held_place,
    joined_to,
    tie_of,
)
from lumpedcable.scene.events import Event
from lumpedcable.scene.lines import Line
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.part import SIDES, Path, Problem, did_you_mean
from lumpedcable.scene.quantities import found
from lumpedcable.scene.units import format_quantity

__all__ = ["anchor", "carried_problems", "is_point", "named", "points_of"]

# what an ideal cable has no winch, no trolley and no line for
REAL = ("schedule", "speed", "control", "sheave", "inertia", "damping")
TOUCHING = ("friction", "contact")
WIRE = ("bending", "drag", "added_mass")
Lines = Mapping[str, Line | None]
Bodies = Mapping[str, Any]


def carried_problems(
    lines: Lines,
    bodies: Bodies,
    events: Mapping[str, Event | None],
    gravity: float | None,
    duration: float | None,
) -> Iterator[Problem]:
    """Yield what is wrong with carried bodies, winches, drums and breaks of lines on them.

    None stands for the unreadable, and for a `duration` (s) that is not known.
    """
    for name, line in lines.items():
        if line is not None:
            yield from _ends(bodies, ("lines", name), line)
            yield from _across(lines, bodies, ("lines", name), line)
            yield from _ideal(bodies, name, line)
    for name, body in bodies.items():
        if isinstance(body, CarriedBody):
            yield from _carried(lines, bodies, ("bodies", name), body, gravity, duration)
    yield from drum_problems(lines, bodies, duration)
    for name, event in events.items():
        if event is not None and next(event.problems(), None) is None:
            yield from _parted(lines, ("events", name, "breaks"), event)


def named(path: Path, word: str, known: list[str], what: str) -> Problem:
    """Return a problem with a name that is not among the `known` ones of `what` is expected."""
    hint = did_you_mean(word, known) or (f"; known: {', '.join(known)}" if known else "")
    return Problem(path, f"expected {what}, found {found(word)}{hint or '; there is none'}")


def points_of(bodies: Bodies) -> list[str]:
    """Return the points of all rigid and moved bodies, as "ship.post"."""
    ships = ((name, body) for name, body in bodies.items() if isinstance(body, MovedBody | Body))
    return [f"{name}.{point}" for name, body in ships for point in body.points]


def is_point(bodies: Bodies, name: str) -> bool:
    """Return whether a text names a point of a body, or may do so."""
    body, _, _ = name.partition(".")
    return name in points_of(bodies) or (body in bodies and bodies[body] is None)


def _ends(bodies: Bodies, path: Path, line: Line) -> Iterator[Problem]:
    for side in SIDES:
        end = getattr(line, side)
        at, reel = post_of(end), reel_key(end)
        if isinstance(at, str) and reel is not None and not is_point(bodies, at):
            yield named((*path, side, reel, "at"), at, points_of(bodies), "a point of a moved body")
        if not isinstance(end, WinchEnd):
            continue
        if side == "end" and isinstance(line.start, WinchEnd):
            yield Problem((*path, side), "expected one winch on a line, found one at either end")


def _across(lines: Lines, bodies: Bodies, path: Path, line: Line) -> Iterator[Problem]:
    """Yield a fault where nothing holds the end across from a winch: what it pulls in has no length."""
    for side, other in zip(SIDES, reversed(SIDES), strict=True):
        end = getattr(line, other)
        if not isinstance(getattr(line, side), WinchEnd) or isinstance(end, WinchEnd):
            continue
        what = None
        if held_force(end) is not None:
            what = "a force"
        elif end == "free":
            what = "a free end"
        tie = tie_of(end)
        body = bodies.get(tie) if tie is not None else None
        if isinstance(body, Body) and not body.rigid:
            what = f'the point mass "{tie}"'
        beyond = joined_to(lines, end)
        loose = isinstance(beyond, str | JoinedEnd | HeldEnd) and anchor(bodies, beyond) is None
        name, _, which = (tie or "").rpartition(".")
        if loose and name in lines and which in SIDES:
            what = f'a joint with "{tie}"'
        if what is not None:
            yield Problem(
                (*path, other),
                f"expected a place, a motion or a point of a body across from a winch, found {what}",
            )


def _ideal(bodies: Bodies, name: str, line: Line) -> Iterator[Problem]:
    if line.model != "ideal":
        return
    path: Path = ("lines", name)
    if not any(post_of(getattr(line, side)) is not None for side in SIDES):
        yield Problem(
            (*path, "model"),
            "expected a winch at an end of an ideal line, which has no tension of its own, found none",
        )
    for side in SIDES:
        end = getattr(line, side)
        for key in REAL if isinstance(end, WinchEnd) else ():
            if getattr(end.winch, key) is not None:
                where = (*path, side, "winch", key)
                yield _lumped(where, f"a winch with {key}", "has a winch that keeps its tension")
    for key in WIRE:
        if getattr(line, key) is not None:
            yield _lumped((*path, key), f"a line with {key}", "is two straight parts without mass")
    if any(body is None for body in bodies.values()):
        return
    for rider, body in bodies.items():
        if isinstance(body, CarriedBody) and body.on.line == name:
            for key in TOUCHING:
                if getattr(body.on, key) is not None:
                    where = ("bodies", rider, "on", key)
                    yield _lumped(where, f"a trolley with {key}", "has no line that it could touch")
    riders = [n for n, b in bodies.items() if isinstance(b, CarriedBody) and b.on.line == name]
    if len(riders) != 1:
        yield Problem(
            (*path, "model"),
            f"expected one body on an ideal line, found {', '.join(riders) or 'none'}",
        )


def _parted(lines: Lines, path: Path, event: Event) -> Iterator[Problem]:
    """Yield a fault where an ideal line parts, or a line from its winch or along what that pays out.

    What a winch or a drum pays out is spread over its whole line: it has no part of a line to haul in,
    and no line once that has left it. Across from it a line may part.
    """
    name, side, _ = event.target()
    line = lines.get(name)
    if line is None:
        return
    if line.model == "ideal":
        yield Problem(
            path, f'expected model = "lumped" for a line that breaks, found "{name}", ideal'
        )
        return
    for held, other in zip(SIDES, reversed(SIDES), strict=True):
        reel = reel_key(getattr(line, held))
        if reel is not None and side != other:
            what = f'"{name}.{side}", which its {reel} holds'
            if side is None:
                what = f'a place along "{name}", all of which the {reel} at its {held} pays out'
            yield Problem(
                path,
                f'expected "{name}.{other}", the end across from the {reel}, or a line without a '
                f"{reel}, found {what}",
            )
            return


def _lumped(path: Path, what: str, ideal: str) -> Problem:
    """What an ideal line cannot honour, and what to do about it."""
    return Problem(
        path,
        f'expected model = "lumped" for {what}, or no {path[-1]}, found "ideal", which {ideal}',
    )


def anchor(bodies: Bodies, end: Any) -> tuple[float, ...] | None:
    """Return where an end is held, or its mean place (m); None where the scene does not say.

    Nor of an end with a motion that does not begin at its mean place.
    """
    end = stands_at(end)
    if isinstance(end, MovingEnd) and isinstance(end.motion, HarmonicMotion):
        from_mean = end.motion.phase == 0.0 or end.motion.ramp is not None
        return end.motion.position if from_mean else None
    if (place := held_place(end)) is not None:
        return place
    if isinstance(end, tuple):
        return end
    name, _, point = (tie_of(end) or "").partition(".")
    body = bodies.get(name)
    centre = not point and isinstance(body, Body) and body.rigid
    if isinstance(body, MovedBody | Body) and body.position and (centre or point in body.points):
        arm = (0.0, 0.0, 0.0) if centre else body.points[point]
        if isinstance(body, Body) and body.attitude is not None:
            arm = tuple(map(float, body.turned @ np.asarray(arm)))
        return tuple(a + b for a, b in zip(body.position, arm, strict=True))
    return None


def _carried(
    lines: Lines, bodies: Bodies, path: Path, body: CarriedBody, gravity: float | None,
    duration: float | None,
) -> Iterator[Problem]:  # fmt: skip
    name = body.on.line
    if name not in lines:
        yield named((*path, "on", "line"), name, list(lines), "the name of a line")
        return
    line = lines[name]
    if line is None:
        return
    if line.grading is not None or line.segment_lengths is not None:
        yield Problem(
            (*path, "on", "line"), f'expected a line of equal segments, found "{name}", graded'
        )
    winches = [end for side in SIDES if isinstance(end := getattr(line, side), WinchEnd)]
    if not any(post_of(getattr(line, side)) is not None for side in SIDES):
        yield Problem(
            (*path, "on", "line"),
            f'expected a winch at an end of a line that carries a body, found none on "{name}"',
        )
    for side in SIDES:
        end = getattr(line, side)
        if isinstance(end, WinchEnd) and end.winch.schedule is not None:
            yield Problem(
                ("lines", name, side, "winch", "schedule"),
                f'expected no schedule where "{path[1]}" runs on the line: how it lies there goes by '
                "the one tension of the winch",
            )
    if winches and gravity is not None:
        tension, weight = winches[0].winch.tension, body.mass * gravity
        if 2.0 * tension <= weight:
            side = "start" if isinstance(line.start, WinchEnd) else "end"
            yield Problem(
                ("lines", name, side, "winch", "tension"),
                f"expected more than {format_quantity(weight / 2.0, 'N')}, half the weight of "
                f'"{path[1]}", which the line could not carry otherwise, '
                f"found {format_quantity(tension, 'N')}",
            )
    places = [anchor(bodies, joined_to(lines, getattr(line, side))) for side in SIDES]
    if places[0] is None or places[1] is None:
        return
    span = math.dist(places[0][:2], places[1][:2])
    if body.on.place >= span:
        yield Problem(
            (*path, "on", "place"),
            f'expected a place on the span of "{name}", between 0 m and '
            f"{format_quantity(span, 'm')}, found {format_quantity(body.on.place, 'm')}",
        )
    elif line.model == "lumped" and line.count:
        yield from _beside_posts((*path, "on"), body, span, span / line.count, duration or 0.0)
    if body.on.speed is None:
        return
    if body.on.place + body.on.stop + body.on.speed * body.on.ease >= span:
        yield Problem(
            (*path, "on", "stop"),
            f"expected room to haul it from {format_quantity(body.on.place, 'm')} on a span of "
            f"{format_quantity(span, 'm')}, found a stop {format_quantity(body.on.stop, 'm')} from "
            "its end",
        )
    if all(
        abs(a - b) > 1e-9 * span
        for a, b in zip(*(p[:2] for p in places if p is not None), strict=True)
    ):
        yield Problem(
            (*path, "on", "speed"),
            f'expected "{name}" along x or along y where a body is hauled on it, found it aslant',
        )


def _beside_posts(
    path: Path, body: CarriedBody, span: float, segment: float, duration: float
) -> Iterator[Problem]:
    """Yield a fault where a trolley starts, or comes in `duration` (s), within a segment (m) of a post.

    Nearer it hangs too low: on 5 m in 50 segments by 4 % at half a segment and by 36 % at a quarter.
    """
    least = segment * (1.0 - 1e-9)
    far = format_quantity(segment, "m")
    place, stop = body.on.place, body.on.stop
    if place < least or span - place < least:
        yield Problem(
            (*path, "place"),
            f"expected a place at least a segment, {far}, from either post, found "
            f"{format_quantity(place, 'm')} on a span of {format_quantity(span, 'm')}: move it, or take "
            "more segments",
        )
    speed = body.on.speed
    if speed is not None and stop < least and speed * duration > span - place - least:
        yield Problem(
            (*path, "stop"),
            f"expected a stop at least a segment, {far}, from the line's end, found "
            f"{format_quantity(stop, 'm')}: stop it before, or take more segments",
        )
