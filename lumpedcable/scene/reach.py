"""What no line can do: carry cargo beyond its posts, or hang with less tension than its shape needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried_checks import anchor
from lumpedcable.scene.lines import Line
from lumpedcable.scene.materials import LinearMaterial
from lumpedcable.scene.part import Problem
from lumpedcable.scene.targets import Target
from lumpedcable.scene.units import format_quantity

__all__ = ["least_tension", "reach_problems"]

WIDENED = 100  # times at most that a bracket is tripled: depths of 1e47 spans
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
Span = tuple[tuple[float, ...], tuple[float, ...], tuple[str, ...], str | None]
"""Where a cable starts and ends (m), its lines, and the body between two of them."""


def reach_problems(
    targets: Mapping[str, Target | None],
    lines: Mapping[str, Line | None],
    bodies: Mapping[str, Any],
    materials: Mapping[str, Any],
    others: Mapping[str, Any],
) -> Iterator[Problem]:
    """Yield targets that ask for a place off the span, or for a tension that is too low.

    None in a current: it may carry a body beyond the span, and what a line weighs.
    """
    fluid = others.get("water") or others.get("air")
    if fluid is not None and fluid.current is not None:
        return
    good = {
        name: target
        for name, target in targets.items()
        if target is not None and next(target.problems(), None) is None
    }
    if not good or None in lines.values() or None in bodies.values() or None in materials.values():
        return
    for span in _spans(lines, bodies):
        off = list(_places(good, span))
        yield from off
        if not off and not {"seabed", "sea"} & others.keys():
            yield from _tensions(good, span, lines, bodies, materials, others)


def _spans(lines: Mapping[str, Any], bodies: Mapping[str, Any]) -> Iterator[Span]:
    """Yield single lines between two places, and pairs with a point body between them."""
    for name, line in lines.items():
        first = anchor(bodies, line.start)
        if first is None or line.bending is not None:
            continue
        last = anchor(bodies, line.end)
        if last is not None:
            yield first, last, (name,), None
            continue
        body = bodies.get(line.end) if isinstance(line.end, str) else None
        tied = [
            other
            for other, part in lines.items()
            if other != name and line.end in (part.start, part.end)
        ]
        if not isinstance(body, Body) or body.rigid or len(tied) != 1:
            continue
        after = lines[tied[0]]
        last = anchor(bodies, after.end)
        if after.start == line.end and last is not None and after.bending is None:
            yield first, last, (name, tied[0]), line.end


def _places(targets: Mapping[str, Target], span: Span) -> Iterator[Problem]:
    first, last, lines, body = span
    for name, target in targets.items():
        if body is None or target.of != body or target.measure not in ("x", "y"):
            continue
        axis = "xyz".index(target.measure)
        low, high = sorted((first[axis], last[axis]))
        if high - low > 1e-9 * math.dist(first, last) and not low < target.wanted < high:
            yield Problem(
                ("targets", name, target.measure),
                f'expected a place on the span of "{" + ".join(lines)}", between '
                f"{format_quantity(low, 'm')} and {format_quantity(high, 'm')}, "
                f"found {format_quantity(target.wanted, 'm')}",
            )


def _tensions(
    targets: Mapping[str, Target],
    span: Span,
    lines: Mapping[str, Any],
    bodies: Mapping[str, Any],
    materials: Mapping[str, Any],
    others: Mapping[str, Any],
) -> Iterator[Problem]:
    first, last, names, body = span
    gravity = others.get("gravity")
    water = others.get("water") or others.get("air")
    if gravity is None or (water is not None and water.surface is not None):
        return
    density = 0.0 if water is None else water.density
    weights = [gravity * (lines[n].mass - density * lines[n].section) for n in names]
    level = math.dist(first[:2], last[:2])
    if min(weights) <= 0.0 or max(weights) > min(weights) * (1 + 1e-9) or level == 0.0:
        return
    load, share = 0.0, 0.5
    if body is not None:
        placed = [t for t in targets.values() if t.of == body and t.measure in ("x", "y")]
        moved = [t for t in placed if abs(_along(t, first, last)[1]) > 1e-9 * level]
        if not moved:
            return
        begin, way = _along(moved[0], first, last)
        share = (moved[0].wanted - begin) / way
        load = gravity * (bodies[body].mass - density * (bodies[body].volume or 0.0))
        if load < 0.0:
            return
    for name, target in targets.items():
        ends = {f"{names[0]}.start": "start", f"{names[-1]}.end": "end"}
        if target.measure != "tension" or target.of not in ends:
            continue
        drop = first[2] - last[2]
        least = least_tension(level, drop, weights[0], load, share * level, ends[target.of])
        if not math.isfinite(100.0 * least):
            continue  # numbers too far apart for arithmetic: statics says what is wrong with them
        if target.wanted < least / (1.0 + _strain(materials.get(lines[names[0]].material), least)):
            carry = "" if body is None else f' and "{body}"'
            yield Problem(
                ("targets", name, "tension"),
                f"expected {format_quantity(math.ceil(least * 100.0) / 100.0, 'N')} or more, the least "
                f'tension with which "{" + ".join(names)}" can carry itself{carry}, '
                f"found {format_quantity(target.wanted, 'N')}",
            )


def _along(target: Target, first, last) -> tuple[float, float]:
    """Return where the span begins and how long it is (m) on the axis of a target."""
    axis = "xyz".index(target.measure)
    return first[axis], last[axis] - first[axis]


def _strain(material: Any, tension: float) -> float:
    """Return a strain that the material surely has not at a tension, so that stretch is no fault."""
    return tension / material.EA if isinstance(material, LinearMaterial) else 0.5


def least_tension(
    span: float, drop: float, weight: float, load: float, place: float, side: str
) -> float:
    """Return the least tension (N) at an end of an inextensible line that carries a load.

    NaN where numbers are too far apart for arithmetic.

    Two catenaries meet under the load G at x = `place`. For a horizontal tension H the depth y of the
    load follows from H (s1 - s2) = G, with the slopes s of the parts there; the tension at the end is
    H cosh of its slope's argument. It rises with H where the line is taut and falls where it is slack.

    Args:
        span: horizontal distance of the ends, m.
        drop: depth of the end under the start, m.
        weight: of the line, N/m.
        load: G, N.
        place: horizontal distance of the load from the start, m.
        side: "start" or "end".
    """

    def slope(level: float, down: float, scale: float) -> float:
        # asinh of the slope at the left end of a catenary, z down: y' = sinh(p - x / scale)
        half = 0.5 * level / scale
        return half + math.asinh(0.5 * down / (scale * math.sinh(half)))

    def end(horizontal: float) -> float:
        scale = horizontal / weight
        rest = span - place

        def lift(depth: float) -> float:
            left, right = slope(place, depth, scale), slope(rest, drop - depth, scale)
            return horizontal * (math.sinh(left - place / scale) - math.sinh(right))

        chord = drop * place / span
        low, high = chord - span, chord + span
        for _ in range(WIDENED):
            if lift(low) <= load:
                break
            low -= 2.0 * (chord - low)
        for _ in range(WIDENED):
            if lift(high) >= load:
                break
            high += 2.0 * (high - chord)
        if not lift(low) <= load <= lift(high):
            raise ArithmeticError
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if lift(middle) < load else (low, middle)
        if side == "start":
            return horizontal * math.cosh(slope(place, high, scale))
        return horizontal * math.cosh(slope(rest, drop - high, scale) - rest / scale)

    try:
        # a span of 60 times the scale is a line that hangs down from both posts
        tall = math.log(weight * span / 60.0)
        wide = math.log(100.0 * (weight * span + load) * (1.0 + abs(drop) / span) * span
                        / min(place, span - place))  # fmt: skip
        return _smallest(lambda x: end(math.exp(x)), tall, wide)
    except (ArithmeticError, ValueError):
        return math.nan


def _smallest(value: Callable[[float], float], low: float, high: float) -> float:
    """Return the least value of a function with one minimum, by golden sections."""
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_a, at_b = value(a), value(b)
    for _ in range(60):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - GOLDEN * (high - low)
            at_a = value(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + GOLDEN * (high - low)
            at_b = value(b)
    return min(at_a, at_b)
