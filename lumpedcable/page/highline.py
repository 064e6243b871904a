"""Which scenes are highlines, and which stage in closed form has the numbers of one at rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from lumpedcable.exact import loaded_from_length, stage_shape
from lumpedcable.exact.stages import STAGES
from lumpedcable.scene import Body, Line, Scene
from lumpedcable.scene.ends import held_place

__all__ = ["SceneHighline", "highline_of"]

_NEAR = 0.01  # by which stretch may change the numbers of a stage that the page opens with
_MARGIN = 1e-3  # of the span, between a load and the ends


@dataclass(frozen=True)
class SceneHighline:
    """A scene that is a highline.

    Attributes:
        numbers: by the keys of the sliders of `STAGES`, as far as the scene tells them: span, drop,
            length, place, sag (m), weight, traction_weight (N/m), load, tension, traction (N),
            speed (m/s), time (s), start (m).
        stage: the key of the stage whose inextensible line has the numbers of this scene at rest, None
            where there is none: what it stretches by changes them, or no stage asks as it does.
    """

    numbers: dict[str, float]
    stage: str | None


def highline_of(scene: Scene) -> SceneHighline | None:
    """A scene as a highline, None if it is none.

    A highline is what hangs in still air between two places that are fixed or held: one line, or several
    that are joined or carry one body. An end that is moved is held at no place.
    """
    bodies = [body for body in scene.bodies.values() if isinstance(body, Body)]
    if len(bodies) < len(scene.bodies):  # moved or carried along a line
        return None
    fluid = scene.fluid
    if scene.gravity is None or scene.water is not None or scene.seabed is not None:
        return None
    if (
        len(scene.bodies) > 1
        or not 1 <= len(scene.lines) <= 2
        or (fluid is not None and fluid.current is not None)
    ):
        return None
    ends = {
        f"{name}.{side}": getattr(line, side)
        for name, line in scene.lines.items()
        for side in ("start", "end")
    }
    held = {name: place for name, end in ends.items() if (place := held_place(end)) is not None}
    if len(held) != 2:
        return None
    first, last = map(np.asarray, held.values())
    way = last - first
    span = float(np.hypot(way[0], way[1]))
    if span <= 0.0:
        return None
    numbers = _numbers(scene, span, float(-way[2]), float(np.linalg.norm(way)))
    asked = _asked(scene, [*held], first, way)
    stage = None
    if asked is not None and _alike(scene, ends):
        numbers |= asked
        stage = _stage(scene, asked, numbers)
    if stage is not None and not _stiff(scene, stage, numbers):
        stage = None
    return SceneHighline(numbers, stage)


def _numbers(scene: Scene, span: float, drop: float, chord: float) -> dict[str, float]:
    """What the scene tells without its targets."""
    assert scene.gravity is not None
    first, *others = scene.lines.values()
    found = {"span": span, "drop": drop, "weight": first.mass * scene.gravity}
    if first.payout is not None:
        found["speed"] = abs(first.payout.speed)
    if others and not scene.bodies:  # dragged by another line
        found["traction_weight"] = others[0].mass * scene.gravity
        speed = found.setdefault("speed", 1.0) or 1.0
        if _hauled(first):
            assert first.payout is not None
            return found | {"start": first.length, "time": first.payout.time}
        return found | {"time": first.unstretched / speed}
    length = first.unstretched + sum(line.unstretched for line in others)
    if length > chord:  # a first guess, whose targets change it, need not reach
        found["length"] = length
    for body in scene.bodies.values():
        assert isinstance(body, Body)
        found |= {"load": body.mass * scene.gravity, "place": 0.5 * span}
    return found


def _hauled(line: Line) -> bool:
    return line.payout is not None and line.payout.speed < 0.0


def _asked(
    scene: Scene, held: list[str], first: NDArray[Any], way: NDArray[Any]
) -> dict[str, float] | None:
    """What the targets ask for by the sliders' keys, None where no slider says it."""
    known: dict[tuple[str, frozenset[str]], str] = {
        ("tension", frozenset([held[0]])): "tension",
        ("length", frozenset(scene.lines)): "length",
    }
    if scene.bodies:
        axis = 0 if way[1] == 0.0 else 1
        if way[1 - axis] == 0.0:
            known["xy"[axis], frozenset(scene.bodies)] = "place"
    elif len(scene.lines) == 1:
        known["sag", frozenset(scene.lines)] = "sag"
    else:
        known["tension", frozenset([held[1]])] = "traction"
    found = {}
    for target in scene.targets.values():
        key = known.get((target.measure, frozenset(target.parts)))
        if key is None or key in found:
            return None
        found[key] = target.wanted
        if key == "place":
            axis = "xy".index(target.measure)
            found[key] = float((target.wanted - first[axis]) * np.sign(way[axis]))
    return found


def _alike(scene: Scene, ends: dict[str, Any]) -> bool:
    """Whether its lines are what the closed forms are of: without bending, and one after the other."""
    lines = list(scene.lines.values())
    if any(line.bending is not None or line.model == "ideal" for line in lines):
        return False
    free = [end for end in ends.values() if held_place(end) is None]
    if not scene.bodies:
        return not free or (len(free) == 2 and all(end in ends for end in map(str, free)))
    ((name, body),) = scene.bodies.items()
    assert isinstance(body, Body)
    tied = len(free) == 2 and all(end == name for end in free)
    return tied and not body.rigid and lines[0].mass == lines[1].mass


def _stage(scene: Scene, asked: dict[str, float], numbers: dict[str, float]) -> str | None:
    """The stage that asks for what the scene asks for; completes its numbers."""
    first, *others = scene.lines.values()
    keys = frozenset(asked)
    if not scene.bodies:
        if not others:
            return {
                frozenset(): "stabilisation-length",
                frozenset(["length"]): "stabilisation-length",
                frozenset(["sag"]): "stabilisation",
                frozenset(["tension"]): "adjustment",
            }.get(keys)
        # the highline's own length is given, the traction cable's is found
        chosen = [target.line for target in scene.targets.values()]
        if keys != {"traction"} or chosen != [[*scene.lines][1]]:
            return None
        return "withdrawal" if _hauled(first) else "erection"
    if keys == {"place", "tension"}:
        return "delivery-tension"
    if keys == {"place", "length"}:
        return "delivery"
    if keys or "length" not in numbers:
        return None
    place = _place(numbers, first.unstretched)
    if place is None:
        return None
    numbers["place"] = place
    return "delivery"


def _place(numbers: dict[str, float], length: float) -> float | None:
    """Where a load hangs (m from the sending end) that has so much line before it (m)."""
    span, drop, weight, load = (numbers[key] for key in ("span", "drop", "weight", "load"))

    def miss(place: float) -> float:
        line = loaded_from_length(span, drop, weight, load, place, numbers["length"])
        return float(line.parts[0].length) - length

    edges = _MARGIN * span, (1.0 - _MARGIN) * span
    try:
        return float(brentq(miss, *edges, xtol=1e-9 * span))  # pyright: ignore
    except (ValueError, ArithmeticError):
        return None


def _stiff(scene: Scene, stage: str, numbers: dict[str, float]) -> bool:
    """Whether the line stretches so little that the stage has its numbers.

    By the tension F_TA or F_TB of the inextensible line, the larger, it stretches by e; a line longer by
    that and as much lighter per length must have the same tensions and deflection. A taut line hangs by
    the little that it is longer than its chord: there e may be far below 1 % and yet change all.
    """
    own = {key: numbers[key] for key in STAGES[stage].sliders if key in numbers}
    lines = [scene.materials[line.material] for line in scene.lines.values()]
    try:
        with np.errstate(all="ignore"):
            shape = stage_shape(stage, points=3, **own)
            pull = max(shape.numbers["F_TA"], shape.numbers["F_TB"])
            stretch = max(_strain(material, pull) for material in lines)
            if stretch > _NEAR:
                return False
            longer = {"weight": own["weight"] / (1.0 + stretch)}
            if "length" in own:
                longer["length"] = own["length"] * (1.0 + stretch)
            other = stage_shape(stage, points=3, **own | longer)
    except (ValueError, ArithmeticError):
        return False  # numbers without a line
    return all(
        abs(other.numbers[key] - value) <= _NEAR * abs(value)
        for key, value in shape.numbers.items()
    )


def _strain(material: Any, tension: float) -> float:
    """The strain of a law at a tension: the first of those that it is sampled at, inf beyond them."""
    if material.law == "inextensible":
        return 0.0 if material.EA is None else tension / material.EA
    if material.law == "linear":
        return tension / material.EA
    reached = np.flatnonzero(material.sampled() >= tension)
    if not len(reached):
        return np.inf
    return float(np.linspace(0.0, material.top_strain(), len(material.sampled()))[reached[0]])
