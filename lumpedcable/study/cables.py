"""The cables of a scene: lines that follow each other from one fixed place to another."""

from __future__ import annotations

from dataclasses import dataclass

from lumpedcable.scene import Scene
from lumpedcable.scene.ends import held_place

__all__ = ["Cable", "cables"]

NUMBERS = {
    "length": ("m", "unstretched length S"),
    "sag": ("m", "depth f under the chord, of the joint or of mid-span"),
    "start_tension": ("N", "tension F_TA at the start"),
    "end_tension": ("N", "tension F_TB at the end"),
    "horizontal_tension": ("N", "horizontal tension F_H"),
}
JOINT = {
    "joint_length": ("m", "unstretched length from the start to the joint"),
    "joint_x": ("m", "horizontal distance of the joint from the start, towards the end"),
    "joint_z": ("m", "height of the joint over the start"),
}


@dataclass(frozen=True)
class Cable:
    """Lines that follow each other from one place to another; `body` is between two of them."""

    lines: tuple[str, ...]
    body: str | None = None
    spans: bool = False

    @property
    def name(self) -> str:
        """What it is called in results: "before+after"."""
        return "+".join(self.lines)

    @property
    def numbers(self) -> dict[str, tuple[str, str]]:
        """Unit and meaning of each of its numbers."""
        return NUMBERS | (JOINT if len(self.lines) > 1 else {})


def cables(scene: Scene) -> list[Cable]:
    """The cables of a scene, each line in one of them but ideal ones, which have no nodes."""
    found: list[Cable] = []
    for name, line in scene.lines.items():
        if line.model == "ideal":
            continue
        if any(name in cable.lines for cable in found) or _follows(scene, name):
            continue
        after = _next(scene, name)
        if after is not None and held_place(line.start) is not None:
            body = line.end if line.end in scene.bodies else None
            found.append(Cable((name, after), body, True))  # type: ignore[arg-type]
        else:
            spans = held_place(line.start) is not None and held_place(line.end) is not None
            found.append(Cable((name,), None, spans))
    return found


def _next(scene: Scene, name: str) -> str | None:
    """The line that goes on alone, from the joint at the end of another to a fixed place."""
    end = scene.lines[name].end
    here = {f"{name}.end", *([end] if isinstance(end, str) and end != "free" else [])}
    others = [
        (other, side)
        for other, line in scene.lines.items()
        for side in ("start", "end")
        if (other, side) != (name, "end")
        and (f"{other}.{side}" in here or getattr(line, side) in here)
    ]
    if len(others) != 1 or others[0][1] != "start" or others[0][0] == name:
        return None
    after = others[0][0]
    return after if held_place(scene.lines[after].end) is not None else None


def _follows(scene: Scene, name: str) -> bool:
    """Whether a line is the second one of a cable."""
    return any(
        _next(scene, other) == name and held_place(line.start) is not None
        for other, line in scene.lines.items()
        if other != name
    )
