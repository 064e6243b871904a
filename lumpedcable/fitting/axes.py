"""The line, plane or space in which derivatives and searches are right: where free numbers lead."""

from __future__ import annotations

from collections.abc import Iterable
from math import copysign

import numpy as np

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.scene import Scene
from lumpedcable.study.plan import STEEP_START

__all__ = ["axes_reached", "axes_seen", "changed_scenes"]

SEEN = 1e-9  # of an axis of space, by which it may miss the scene's own axes
FAR = 1e3  # times a number, or one over it: a length that is slack, a weight that floats


def changed_scenes(scene: Scene, keys: Iterable[str]) -> list[Scene]:
    """The scene with each of the numbers changed by itself, as far as it is part of a vector.

    No other number leads out of the line or plane that a scene lies in.
    """
    values, found = scene.numbers(), []
    for key in keys:
        vector, _, part = key.rpartition(".")
        if not part.isdigit() or key.startswith("materials."):
            continue
        parts = (abs(values.get(f"{vector}.{k}", 0.0)) for k in range(3))
        # as far as the vector is long, so that no rounding hides it; towards 0, where nothing overflows
        change = -copysign(max(1.0, *parts), values[key])
        found.append(scene.with_numbers({key: values[key] + change}))
    return found


def axes_seen(scene: Scene, keys: Iterable[str], component: int | None) -> Coordinates:
    """Coordinates in which derivatives by the numbers are right of what is seen along x, y or z.

    Those of the scene, in which all is alike on both sides: what has no direction there, a tension, or
    lies in them, changes by nothing as long as a number leads out of them. A `component` (0 to 2) that
    does not lie in them changes with it, so that they are those that hold the changed scenes too.

    Raises:
        ValueError: there are none, or not for a body.
    """
    found = coordinates_of([scene])
    if component is not None and np.linalg.norm(found.axes[component]) < 1.0 - SEEN:
        freed = scene.model_copy(update={"dimensions": None})  # which asks for those of the scene
        found = coordinates_of([freed], changed_scenes(freed, keys))
    return _not_steep(scene, found)


def axes_reached(scene: Scene, keys: Iterable[str]) -> Coordinates:
    """Coordinates that hold the scene whatever values the numbers have, and no more than that takes.

    A line may become slack then, and needs a plane to fold into unless the scene asks for a line.

    Raises:
        ValueError: the scene asks for fewer dimensions, or there are none for a body.
    """
    keys = list(keys)
    changed = changed_scenes(scene, keys)
    try:
        found = coordinates_of([scene], changed)
    except ValueError as error:
        raise ValueError(f"dimensions: {error} where {', '.join(keys)} vary") from None
    if found.dimensions == 1 and scene.dimensions is None and _may_fold(scene, keys, bool(changed)):
        found = coordinates_of([scene.model_copy(update={"dimensions": 2})], changed)
    return _not_steep(scene, found)


def _may_fold(scene: Scene, keys: list[str], moved: bool) -> bool:
    """Whether a line along one axis may leave it at other values, of which some may move its ends."""
    if moved:  # its ends may come as near to each other as it takes
        return scene.gravity is not None or any(x.bending is not None for x in scene.lines.values())
    values = scene.numbers()
    far = [scene.with_numbers({k: values[k] * by}) for k in keys for by in (1.0 / FAR, FAR)]
    return any(coordinates_of([one]).dimensions > 1 for one in far)


def _not_steep(scene: Scene, found: Coordinates) -> Coordinates:
    if found.dimensions == 3 and scene.steep:
        raise ValueError(f"bodies.{scene.steep[0]}.attitude: {STEEP_START}")
    return found
