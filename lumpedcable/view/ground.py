"""The bed and the water's surface in a picture of lines seen from the side."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from lumpedcable.results.ground import Bed, ground_of
from lumpedcable.results.reader import ResultFile

__all__ = ["draw_ground", "ground_note"]

BED, WATER = "#8A6F52", "#56B4E9"
NEAR, EDGE = (
    0.25,
    0.04,
)  # shares of its height by which a picture is made higher at most, and a margin
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
    low, high = ax.get_ylim()
    height = high - low
    seen = set()
    for level, colour in ((ground.surface, WATER), (ground.bed, BED)):
        if isinstance(level, Bed):
            if across == 0:
                # straight beyond its points, ten times as far as they reach
                far = 10.0 * (level.x[-1] - level.x[0])
                x = np.concatenate([level.x[:1] - far, level.x, level.x[-1:] + far])
                ends = level.z[[0, -1]] + np.array([-far, far]) * level.slopes
                z = np.concatenate([ends[:1], level.z, ends[1:]])
                _add(ax, x, z, colour)
                wide = ax.get_xlim()
                z = np.interp(np.linspace(*wide, 50), x, z)
                if np.any((z > low) & (z < high)):
                    seen.add(colour)
        elif level is not None and low - NEAR * height < level < high + NEAR * height:
            now = ax.get_ylim()
            ax.axhline(level, color=colour, linewidth=1.2, zorder=0.8)
            ax.set_ylim(min(now[0], level - EDGE * height), max(now[1], level + EDGE * height))
            seen.add(colour)
    return seen


def ground_note(seen: set[str]) -> str:
    """What the colours in sight stand for."""
    words = [word for colour, word in WORDS.items() if colour in seen]
    return (words[0][0].upper() + "; ".join(words)[1:] + ".") if words else ""


def _add(ax: Axes, x, z, colour: str) -> None:
    drawn = LineCollection([np.column_stack([x, z])], colors=colour, linewidths=1.2, zorder=0.8)
    ax.add_collection(drawn, autolim=False)
