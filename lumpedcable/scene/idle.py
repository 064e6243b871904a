"""What a scene names and nothing uses, or that does less than it seems: no faults, but seldom meant."""

from __future__ import annotations

from collections.abc import Iterator

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import tie_of
from lumpedcable.scene.joints import rigid_joints
from lumpedcable.scene.part import SIDES
from lumpedcable.scene.scene import Scene

__all__ = ["idle_parts"]


def idle_parts(scene: Scene) -> Iterator[str]:
    """Yield in words the materials that no line is of and the point masses that no line ends at."""
    of = {line.material for line in scene.lines.values()}
    for name in scene.materials:
        if name not in of:
            yield f'materials.{name} is not used: no line is of "{name}"'
    ties = [tie_of(getattr(line, side)) for line in scene.lines.values() for side in SIDES]
    ends = {tie.partition(".")[0] for tie in ties if tie is not None}
    for name, body in scene.bodies.items():
        if isinstance(body, Body) and not body.rigid and name not in ends:
            yield f'bodies.{name} is not there: no line ends at "{name}", a point mass'
    yield from _hinges(scene)


def _hinges(scene: Scene) -> Iterator[str]:
    """Yield in words the joints at which the bending of one line does not reach the other."""
    bends = {name: line for name, line in scene.lines.items() if line.bending is not None}
    rigid = {end for pair in rigid_joints(scene.lines) for end in pair}
    for name, line in bends.items():
        for side in SIDES:
            tie = tie_of(getattr(line, side)) or ""
            other, _, other_side = tie.rpartition(".")
            if other in bends and not {(name, side), (other, other_side)} & rigid:
                yield (
                    f"lines.{name}.{side} is a hinge: what bends does not bend over it, as it does over "
                    f'{{ joined = "{tie}", rigid = true }}'
                )
