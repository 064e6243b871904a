"""When breaks begin in the runs of a study, and whose waves an end may feel."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.scene import Scene, Study
from lumpedcable.solve.observe import FAR, Recoil
from lumpedcable.study.plan import recoil_event

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.run import Part

__all__ = ["begins_of", "other_begins", "source_of"]


def begins_of(study: Study, part: Part, recoil: Recoil) -> NDArray[np.float64]:
    """When the break of a recoiling end begins in each run (s): its own, or its partner's."""
    event = recoil_event(part.structure.layout, recoil)
    start = study.runs.numbers(part.runs).get(
        f"events.{event}.start", part.structure.scene.events[event].start
    )
    return np.broadcast_to(start, len(part.runs)).astype(float)


def other_begins(study: Study, part: Part, recoil: Recoil) -> NDArray[np.float64]:
    """When another break whose waves the far end of a recoiling one may feel begins in each run (s).

    Any before its own, and the far end's own; inf where there is none.
    """
    scene, layout = part.structure.scene, part.structure.layout
    piece = next(piece for piece in layout.pieces if piece.name == recoil.line)
    node = FAR[recoil.node]
    far = {piece.starts_at if node == 0 else piece.ends_at, layout.event_at(piece.name, node)}
    if recoil.node in (0, -1):
        far.add(piece.seam)  # which lies on the way
    begins = begins_of(study, part, recoil)
    first = np.full(len(part.runs), np.inf)
    moved = study.runs.numbers(part.runs)
    for name, event in scene.events.items():
        if event.target()[0] == piece.line:
            start = moved.get(f"events.{name}.start", np.asarray(event.start))
            first = np.where((name in far) | (start < begins), np.fmin(first, start), first)
    return first


def source_of(scene: Scene, piece: str) -> str:
    """The scene's line that a piece belongs to: "rope" for "rope" and for "rope-2"."""
    return piece if piece in scene.lines else piece.rpartition("-")[0]
