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
    scene, coordinates = ended.part.structure.scene, ended.contents.laid.coordinates
    said = ["" for _ in ended.part.runs]
    if scene.seabed is None:
        return said
    for name, body in scene.bodies.items():
        moved = ended.account.displacement.get(body_key(name))
        if (
            not isinstance(body, Body)
            or not body.rigid
            or body.bearing is not None
            or moved is None
        ):
            continue
        d, start = coordinates.dimensions, np.asarray(ended.ready.model.bodies[name].reference)
        places = coordinates.expand((start[: len(moved)] + moved)[:, :d], 1, place=True)
        for run, place in enumerate(places):
            deep = scene.seabed.height_at(place[0]) - place[2]
            if deep > 0.0 and not said[run]:
                said[run] = (
                    f"{name} ends {quantity(deep, 'm', 2)} under the bed, which bears no body without "
                    f"bearing: give bodies.{name}.bearing"
                )
    return said
