"""Where lines go when one parts: all that they sweep, coloured by the largest speed there.

Who stands near a line under load asks where it may come, seen from the side and from above. Where it
recoils along itself alone nothing is swept, and there is no such picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lumpedcable.results.lines import LineData
from lumpedcable.results.sound import SoundFile
from lumpedcable.results.spread import even
from lumpedcable.view import style
from lumpedcable.view.general import true_to_scale
from lumpedcable.view.ground import draw_ground, ground_note
from lumpedcable.view.groups import Group
from lumpedcable.view.sampling import side_view

__all__ = ["swept_figure", "swept_planes"]

Array = NDArray[Any]
Plane = tuple[int, int]

_AXES = "xyz"
_ABOVE: Plane = (0, 1)
_BROAD = 0.02  # share of the length of what is swept from which it has a breadth
_MOST_NAMES = 4  # of lines in the heading
_MOST_NODES, _MOST_TIMES = 100, 400  # of a line, in a panel


class _Swept(NamedTuple):
    """A line on its way: places (time, node, 3) in m and speeds (time, node) in m/s."""

    places: Array
    speeds: Array


def swept_planes(lines: Sequence[LineData], group: Group) -> dict[str, Plane]:
    """Which of x, y and z go across and up in the pictures that show more than a stroke, by name."""
    points = [line.position(run)[:, : line.node_count(run)] for line in lines for run in group.runs]
    side = side_view(points)
    whole = np.concatenate([shape.reshape(-1, 3) for shape in points])
    whole = whole[np.isfinite(whole).all(axis=1)]
    planes = {"swept": side} if side != _ABOVE else {}
    planes["swept_above"] = _ABOVE
    return {name: plane for name, plane in planes.items() if _is_broad(whole[:, list(plane)])}


def _is_broad(points: Array) -> bool:
    """Whether points (n, 2) fill more than a stroke, however that may lie."""
    if len(points) < 2:
        return False
    centred = points - points.mean(axis=0)
    ways = np.linalg.svd(centred.T @ centred)[0]
    long, broad = np.ptp(centred @ ways, axis=0)
    return bool(broad > _BROAD * long)


def swept_figure(
    result: SoundFile, lines: Sequence[LineData], plane: Plane, group: Group
) -> Figure:
    """What lines sweep, a panel for each run, coloured by speed, the fastest in front."""
    swept = {run: [_of(line, run, result.last_frame(run)) for line in lines] for run in group.runs}
    every = [line for run in swept.values() for line in run]
    fastest = max((style.largest(line.speeds) for line in every), default=0.0) or 1.0
    note = true_to_scale([line.places for line in every], plane)
    names = ", ".join(line.name for line in lines) if len(lines) <= _MOST_NAMES else "the lines"
    where = "seen from above" if plane == _ABOVE else "seen from the side"
    heading = group.heading(result, f"Swept by {names}, {where}")
    figure, axes = style.panel_figure(group.titles, heading)
    colours = Normalize(0.0, fastest)
    ground: set[str] = set()
    for ax, run in zip(axes, group.runs, strict=True):
        _draw(ax, swept[run], plane, colours)
        ground |= draw_ground(ax, result, run, plane)
        if not note:
            ax.set_aspect("equal", adjustable="datalim")
    across, up = plane
    style.label_outer(axes, f"{_AXES[across]} (m)", f"{_AXES[up]} (m)")
    shown = ScalarMappable(colours, "inferno_r")
    figure.colorbar(shown, ax=axes, label="largest speed there (m/s)", aspect=35, pad=0.02)
    words = f"Black: as the run starts. Straight between saved times. {note}"
    style.foot(figure, f"{words} {ground_note(ground)}".strip() + f"\n{group.note}")
    return figure


def _of(line: LineData, run: int, last: int) -> _Swept:
    """A line up to a frame, thinned to what a panel can show."""
    nodes = line.node_count(run)
    kept, times = even(nodes, _MOST_NODES), even(last + 1, _MOST_TIMES)
    places = line.position(run)[times][:, kept]
    speeds = np.linalg.norm(line.velocity(run)[times][:, kept], axis=-1)
    return _Swept(places, speeds)


def _draw(ax: Axes, lines: Sequence[_Swept], plane: Plane, colours: Normalize) -> None:
    """The four-sided cells between nodes and times, each in the colour of its fastest corner."""
    corners, speeds = [], []
    for places, speed in lines:
        flat = places[..., list(plane)]
        around = (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, 1:], np.s_[1:, :-1])
        corners.append(np.stack([flat[at] for at in around], axis=2).reshape(-1, 4, 2))
        speeds.append(np.max([speed[at] for at in around], axis=0).ravel())
        ax.plot(*flat[0].T, color="black", linewidth=1.0, zorder=3)
    quads, speed = np.concatenate(corners), np.concatenate(speeds)
    good = np.isfinite(quads).all(axis=(1, 2)) & np.isfinite(speed)
    if not good.any():
        style.say_empty(ax)
        return
    quads, speed = quads[good], speed[good]
    order = np.argsort(speed)
    drawn = PolyCollection(
        list(quads[order]), cmap="inferno_r", norm=colours, rasterized=True, linewidths=0.2
    )
    drawn.set_array(speed[order])
    drawn.set_edgecolor("face")
    ax.add_collection(drawn)
    ax.autoscale_view()
