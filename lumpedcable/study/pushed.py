"""Lines that rest pushed together, which nothing but their own stiffness keeps straight, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lumpedcable.scene import Scene
    from lumpedcable.study.endings import Ended

__all__ = ["pushed"]

MUCH = (
    0.01  # shortening at rest that is told: the ways in which lumps fold under a weight have less
)


def pushed(ended: Ended) -> list[str]:
    """Of each run which lines without bending rest shorter than they are, by more than a hundredth.

    A chain of lumps can balance so on a straight line; a rope that may give way to the side cannot.
    """
    runs, scene = ended.part.runs, ended.part.structure.scene
    said = ["" for _ in runs]
    lines = [name for name in scene.lines if _may_be_pushed(scene, name)]
    if not lines or ended.contents.laid.coordinates.dimensions == 1:
        return said
    model = ended.ready.model
    for piece in ended.part.structure.layout.pieces:
        if piece.line not in lines:
            continue
        shorter = -np.min(np.asarray(model.lines[piece.name].reference_strain), axis=-1)
        for k in np.flatnonzero(shorter[: len(runs)] > MUCH):
            if not said[k]:
                material = scene.lines[piece.line].material
                said[k] = (
                    f"{piece.line} rests pushed together by {100.0 * shorter[k]:.2g} %, which no line "
                    f"without bending bears: give it materials.{material}.tension_only"
                )
    return said


def _may_be_pushed(scene: Scene, name: str) -> bool:
    """Whether a line has a law that pushes and nothing that keeps it straight."""
    line = scene.lines[name]
    material = scene.materials[line.material]
    pushes = material.law != "inextensible" and not material.tension_only
    return pushes and line.bending is None and line.model == "lumped"
