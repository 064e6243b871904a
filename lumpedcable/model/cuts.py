"""Where breaks along lines cut them, and whether the place of a cut may be a number of the program."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.physics.tips import FALLEN
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import post_of
from lumpedcable.scene.lines import Line

__all__ = [
    "LEAST",
    "cut_at",
    "cut_keys",
    "cuts_of",
    "has_seam",
    "is_seam",
    "layouts_of",
]

LEAST = FALLEN  # segments on either side of a seam: what an end asks of them must be the part's own
IN_SEAM = -1  # in the place of the segments before a cut, where these are a number
LENGTH_KEYS = ("length", "payout.speed", "payout.time")
"""Numbers of a line that its unstretched length follows from."""


def has_seam(scene: Scene, name: str) -> bool:
    """Whether the one place along a line at which it breaks may be a number of the program.

    Not where bending or friction on the bed reaches across it, where winches, drums, trolleys or targets
    ask for the whole line, where it may leave the water, or where segments differ.
    """
    line = scene.lines[name]
    targets = [event.target() for event in scene.events.values() if event.target()[0] == name]
    if len(targets) != 1 or targets[0][1] is not None:
        return False
    equal = line.segment_lengths is None and line.grading is None
    rigid = scene.materials[line.material].law == "inextensible"
    grips = scene.seabed is not None and scene.seabed.friction is not None
    winches = any(post_of(end) is not None for end in (line.start, line.end))
    carries = not all(isinstance(body, Body) for body in scene.bodies.values())
    leaves = scene.surface is not None
    odd = rigid or grips or winches or carries or leaves or line.bending is not None
    odd = odd or bool(scene.targets) or scene.output.static
    return equal and not odd


def is_seam(scene: Scene, name: str, cut: ArrayLike) -> NDArray[np.bool_]:
    """Whether cuts with so many segments before them are seams."""
    cut, count = np.asarray(cut), scene.lines[name].count
    return has_seam(scene, name) & (cut >= LEAST) & (cut <= count - LEAST)


def cut_at(line: Line, place: float) -> int:
    """Number of segments before a break at `place` (m), at least one on either side."""
    lengths = None if line.segment_lengths is None else np.asarray(line.segment_lengths)[:, None]
    return int(_cuts(line.count, np.array([place]), line.unstretched, line.grading, lengths)[0])


def _cuts(count: int, place, length, grading, lengths) -> NDArray[np.int64]:
    """Segments before breaks at the node nearest to each `place` (m), shape (runs,).

    Lengths (m) and grading are numbers or of shape (runs,), `lengths` of segments (segment, runs).
    """
    if count < 2:
        return np.full(place.shape, 1)
    inner = np.arange(1, count)[:, None]
    if lengths is not None:
        ends = np.cumsum(lengths, axis=0)[:-1]
    elif grading is not None and not np.all(np.asarray(grading) == 1.0):
        uneven = np.where(np.asarray(grading) == 1.0, 2.0, grading)
        ratio = uneven ** (1.0 / (count - 1))
        ends = (ratio**inner - 1.0) / (ratio**count - 1.0) * length
        ends = np.where(np.asarray(grading) == 1.0, inner * length / count, ends)
    else:
        return np.clip(np.rint(count * place / length), 1, count - 1).astype(int)
    return 1 + np.argmin(np.abs(ends - place), axis=0)


def cut_keys(scene: Scene) -> set[str]:
    """The numbers of a scene that decide where its lines are cut, by key."""
    keys: set[str] = set()
    for event, own in scene.events.items():
        name, side, _ = own.target()
        if side is None:
            keys.add(f"events.{event}.place")
            keys |= {f"lines.{name}.{key}" for key in LENGTH_KEYS} | {f"lines.{name}.grading"}
            sizes = scene.lines[name].segment_lengths or ()
            keys |= {f"lines.{name}.segment_lengths.{i}" for i in range(len(sizes))}
    return keys


def layouts_of(
    scene: Scene, numbers: Mapping[str, NDArray[np.float64]], runs: int
) -> NDArray[np.int64]:
    """What tells the layouts of `runs` runs apart, shape (runs, breaks along lines).

    Runs of one skeleton and equal rows have equal layouts: `cuts_of`, but for seams.
    """
    cuts = cuts_of(scene, numbers, runs)
    along = [event.target()[0] for event in scene.events.values() if event.target()[1] is None]
    for column, name in enumerate(along):
        mine = cuts[:, column]
        cuts[:, column] = np.where(is_seam(scene, name, mine), IN_SEAM, mine)
    return cuts


def cuts_of(
    scene: Scene, numbers: Mapping[str, NDArray[np.float64]], runs: int
) -> NDArray[np.int64]:
    """Where breaks along lines cut them in `runs` runs, shape (runs, breaks): segments before.

    `numbers` are those that differ from the scene's, each of shape (runs,).
    """
    found = []
    for event, own in scene.events.items():
        name, side, place = own.target()
        if side is not None:
            continue
        line, key = scene.lines[name], f"lines.{name}"
        places = np.broadcast_to(numbers.get(f"events.{event}.place", np.asarray(place)), runs)
        lengths = None
        if line.segment_lengths is not None:
            own_lengths = enumerate(line.segment_lengths)
            rows = [
                numbers.get(f"{key}.segment_lengths.{i}", np.asarray(v)) for i, v in own_lengths
            ]
            lengths = np.array([np.broadcast_to(row, runs) for row in rows])
        length = numbers.get(f"{key}.length", line.length)
        if line.payout is not None:
            speed = numbers.get(f"{key}.payout.speed", line.payout.speed)
            length = length + speed * numbers.get(f"{key}.payout.time", line.payout.time)
        grading = numbers.get(f"{key}.grading", line.grading)
        found.append(_cuts(line.count, places, length, grading, lengths))
    return np.array(found, int).reshape(len(found), runs).T
