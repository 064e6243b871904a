"""What stands around the lines: water surface, bed and bodies, read from the scene that was run."""

from __future__ import annotations

import tomllib
from collections.abc import Container, Iterable, Mapping
from typing import Any

__all__ = ["points_apart", "surroundings", "tables"]


def tables(text: str) -> dict[str, Any]:
    """The tables of a scene's text; none where there is no text or it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return {}


def surroundings(scene: Mapping[str, Any]) -> dict[str, Any]:
    """Surface and bed heights (m), whether there is water, and point bodies with the ends they tie.

    The surface is drawn where the scene says how high it is, or at z = 0 where there is a bed below it
    or something floats; water without any of these is everywhere.

    Args:
        scene: tables of the scene in SI numbers.

    Returns:
        {"water": bool, "surface": height or None, "bed": height, curve or None, "points": [...]}. A
        curve is {"x", "z", "slopes"} (m, m, -): heights at places, and the slopes before and beyond
        them. A point is {"name", "mass" in kg or None, "line", "at_end"}.
    """
    water, bed = scene.get("water"), scene.get("seabed")
    surface = None
    if isinstance(water, dict):
        hulls = [body.get("hull") for body in (scene.get("bodies") or {}).values()]
        tellers = [water, water.get("current"), *hulls]
        told = [_number(t.get("surface")) for t in tellers if isinstance(t, dict)]
        surface = next((height for height in told if height is not None), None)
        if surface is None and (isinstance(bed, dict) or any(h is not None for h in hulls)):
            surface = 0.0
    return {
        "water": isinstance(water, dict),
        "surface": surface,
        "bed": _bed(bed) if isinstance(bed, dict) else None,
        "points": _points(scene),
    }


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
            mass = _number(bodies[body].get("mass"))
            found[body] = {"name": body, "mass": mass, "line": name, "at_end": side == "end"}
    return list(found.values())


def _bed(bed: Mapping[str, Any]) -> float | dict[str, Any] | None:
    """How high the bed is (m), or its curve."""
    height, profile = _number(bed.get("height")), bed.get("profile")
    if height is None or profile is None:
        return height
    from lumpedcable.study.moved import bed_of

    told = [profile.get("x", ()), profile.get("depth", ())]
    x, depth = ([n for n in map(_number, values) if n is not None] for values in told)
    if len(x) < 2 or [len(x), len(depth)] != [len(values) for values in told]:
        return None
    curve = bed_of(height, x, depth)
    return {"x": curve.x.tolist(), "z": curve.z.tolist(), "slopes": list(curve.slopes)}


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
