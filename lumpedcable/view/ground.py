"""The bed and the water's surface in a picture of lines seen from the side."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from lumpedcable.results.ground import Bed, ground_of
from lumpedcable.results.reader import ResultFile

__all__ = ["WATER", "draw_ground", "ground_note", "make_room"]

BED, WATER = "#8A6F52", "#56B4E9"
# shares of its height: how far off a level may be for a picture to be made higher, and the margin then
NEAR, EDGE = 0.25, 0.04
WORDS = {BED: "brown: the bed", WATER: "light blue: the water's surface"}


def draw_ground(ax: Axes, result: ResultFile, run: int, plane: tuple[int, int]) -> set[str]:
    """Draw both behind the lines where they are in sight, or so near that the picture is made higher.

    Args:
        ax: with limits that hold the lines.
        result: the file.
        run: whose scene it is.
        plane: which of x, y and z go across and up.

    Returns:
        The colours of what is in sight.
    """
    across, up = plane
    if up != 2:
        return set()
    ground = ground_of(result.scene_of(run))
    seen = set()
    for level, colour in ((ground.surface, WATER), (ground.bed, BED)):
        if isinstance(level, Bed):
            drawn = across == 0 and _profile(ax, level, colour)
        else:
            drawn = level is not None and _level(ax, level, colour)
        if drawn:
            seen.add(colour)
    return seen


def ground_note(seen: set[str]) -> str:
    """What the colours in sight stand for."""
    words = "; ".join(word for colour, word in WORDS.items() if colour in seen)
    return f"{words[0].upper()}{words[1:]}." if words else ""


def _level(ax: Axes, level: float, colour: str) -> bool:
    """Draw a height (m) that is near enough."""
    if not make_room(ax, level, level):
        return False
    ax.axhline(level, color=colour, linewidth=1.2, zorder=0.8)
    return True


def make_room(ax: Axes, lowest: float, highest: float) -> bool:
    """Make a picture higher for what lies between two heights (m), if that is near; whether it is."""
    low, high = ax.get_ylim()
    room, edge = NEAR * (high - low), EDGE * (high - low)
    if not (low - room < highest and lowest < high + room):
        return False
    # limits that are held would be a complaint where both axes have one scale
    ax.set_ylim(min(low, lowest - edge), max(high, highest + edge), auto=None)
    return True


def _profile(ax: Axes, bed: Bed, colour: str) -> bool:
    """Draw a bed with a profile, straight beyond its points; whether it is in sight."""
    far = 10.0 * (bed.x[-1] - bed.x[0])
    ends = bed.z[[0, -1]] + np.array([-far, far]) * bed.slopes
    x = np.concatenate([bed.x[:1] - far, bed.x, bed.x[-1:] + far])
    z = np.concatenate([ends[:1], bed.z, ends[1:]])
    drawn = LineCollection([np.column_stack([x, z])], colors=colour, linewidths=1.2, zorder=0.8)
    ax.add_collection(drawn, autolim=False)
    seen = np.interp(np.linspace(*ax.get_xlim(), 50), x, z)
    low, high = ax.get_ylim()
    return bool(np.any((seen > low) & (seen < high)))
