"""What stands around the lines: water surface, bed and bodies, read from the scene that was run."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from typing import Any

from lumpedcable.results.ground import Bed, ground_of, number_in

__all__ = ["points_apart", "surroundings"]


def surroundings(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Surface and bed heights (m), whether there is water, and point bodies with the ends they tie.

    Args:
        scene: tables of the scene in SI numbers.

    Returns:
        {"water": bool, "surface": height or None, "bed": height, curve or None, "points": [...]}. A
        curve is {"x", "z", "slopes"} (m, m, -): heights at places, and the slopes before and beyond
        them. A point is {"name", "mass" in kg or None, "line", "at_end"}.
    """
    ground = ground_of(scene)
    bed = ground.bed
    if isinstance(bed, Bed):
        bed = {"x": bed.x.tolist(), "z": bed.z.tolist(), "slopes": list(bed.slopes)}
    return {
        "water": ground.water, "surface": ground.surface, "bed": bed, "points": _points(scene),
    }  # fmt: skip


def points_apart(
    points: Iterable[Mapping[str, Any]], lines: Iterable[str], bodies: Container[str]
) -> list[dict[str, Any]]:
    """The points of `surroundings` that are no body with a motion of its own, at lines of a file.

    Args:
        points: of `surroundings`.
        lines: names of lines; of a line that parts, "rope-1" and so on, the first or the last holds on.
        bodies: names of those whose motion is known.
    """
    names, found = list(lines), []
    for point in points:
        whole = point["line"]
        parts = [n for n in names if n.startswith(f"{whole}-") and n[len(whole) + 1 :].isdecimal()]
        parts.sort(key=lambda name: int(name.rpartition("-")[2]))
        held = [whole] if whole in names else parts[-1:] if point["at_end"] else parts[:1]
        if held and point["name"] not in bodies:
            found.append({**point, "line": held[0]})
    return found


def _points(scene: Mapping[str, Any]) -> list[dict[str, Any]]:
    """One end of a line for each body that lines are tied to: one that does not break, if any."""
    found: dict[str, dict[str, Any]] = {}
    bodies = scene.get("bodies") or {}
    broken = {event.get("breaks") for event in (scene.get("events") or {}).values()}
    ends = [
        (name, side, line.get(side))
        for name, line in (scene.get("lines") or {}).items()
        for side in ("start", "end")
    ]
    for name, side, body in sorted(ends, key=lambda end: f"{end[0]}.{end[1]}" in broken):
        if isinstance(body, str) and body in bodies and body not in found:
            mass = number_in(bodies[body], "mass")
            found[body] = {"name": body, "mass": mass, "line": name, "at_end": side == "end"}
    return list(found.values())
