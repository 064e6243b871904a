"""What a film shows beside the lines of a file: ideal cables, ships, bodies and waves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lumpedcable.page.bodies import posts_of, size_of, solids_of, turned
from lumpedcable.page.surroundings import points_apart, surroundings
from lumpedcable.page.unrecorded import StraightLine, Unrecorded
from lumpedcable.results.reader import ResultFile

__all__ = ["Beside", "beside_lines"]

Array = NDArray[Any]

# corners of a box, in halves of its size, and its faces
_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
_FACES = np.array(
    [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
)


class Beside(NamedTuple):
    """What is drawn of a run besides the lines that its file holds.

    Attributes:
        lines: ideal cables by name, read as the file's own are.
        balls: places (m) of bodies without a size, point masses among them, each (time, 3).
        faces: of bodies with a size, each (time, face, 4, 3) in m; a post is a face without breadth.
        water: the height (m) of the waves at a time (s) and places (n, 3) in m; None without waves.
    """

    lines: dict[str, StraightLine]
    balls: list[Array]
    faces: list[Array]
    water: Callable[[float, Array], Array] | None


def beside_lines(result: ResultFile, run: int) -> Beside:
    """Ideal cables, ships, bodies and waves of a run, at the times with fields."""
    scene = result.scene_of(run)
    more = Unrecorded(result, np.array([run]), scene)
    ways = {
        name: (result.body(name, "position", run), result.body(name, "attitude", run))
        for name in result.bodies
    }
    ways |= {name: (places[0], angles[0]) for name, (places, angles) in more.ships.items()}
    ways = {name: tuple(way[result.frames] for way in both) for name, both in ways.items()}
    waves = more.waves.get(run)
    found = Beside(more.lines, [], [], None if waves is None else waves.height)
    for _, told, places, angles in solids_of(ways, scene):
        size = size_of(told)
        if size is None:
            found.balls.append(places)
        else:
            found.faces.append(_box(places, angles, np.asarray(size, float), posts_of(told)))
    drawn = [name for name in result.lines if result.line(name).has("position")]
    for point in points_apart(surroundings(scene)["points"], drawn, ways):
        line = result.line(point["line"])
        node = line.node_count(run) - 1 if point["at_end"] else 0
        found.balls.append(line.position(run)[:, node])
    return found


def _box(places: Array, angles: Array, size: Array, posts: list[Any]) -> Array:
    """Faces of a box about its middle, and posts from it to points outside."""
    shapes = list((_CORNERS * size)[_FACES])
    for point in np.asarray(posts, float).reshape(-1, 3):
        foot = np.clip(point, -size / 2, size / 2)
        shapes.append(np.array([foot, point, point, foot]))
    corners = [places + turned(angles, at) for at in np.reshape(shapes, (-1, 3))]
    return np.stack(corners, axis=1).reshape(len(places), -1, 4, 3)
