"""Bodies that have sunk through a bed that does not bear them, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.bodies import body_key
from lumpedcable.results.human import quantity
from lumpedcable.scene.bodies import Body

if TYPE_CHECKING:
    from lumpedcable.study.endings import Ended

__all__ = ["sunk"]


def sunk(ended: Ended) -> list[str]:
    """Of each run which rigid bodies without `bearing` end with their centre under the bed."""
    laid, runs, first = ended.contents.laid, ended.part.runs, ended.part.structure.scene
    said = ["" for _ in runs]
    if first.seabed is None:
        return said
    for name, body in first.bodies.items():
        moved = ended.account.displacement.get(body_key(name))
        if moved is None or not isinstance(body, Body) or not _may_sink(body):
            continue
        start = np.asarray(ended.ready.model.bodies[name].reference)[: len(runs)]
        own = (start + moved)[:, : laid.coordinates.dimensions]
        for k, place in enumerate(laid.coordinates.expand(own, 1, place=True)):
            bed = laid.study.runs[int(runs[k])].seabed
            deep = -np.inf if bed is None else bed.height_at(place[0]) - place[2]
            if deep > 0.0 and not said[k]:
                said[k] = (
                    f"{name} ends {quantity(deep, 'm', 2)} under the bed, which bears no body without "
                    f"bearing: give bodies.{name}.bearing"
                )
    return said


def _may_sink(body: Body) -> bool:
    """Whether nothing but lines holds up a rigid body."""
    rises = body.free is None or "z" in body.free
    return body.rigid and rises and body.bearing is None and body.hull is None
