"""Figures of any scene: tension at the lines' ends against time, and their shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import ResultFile
from lumpedcable.results.sound import SoundFile
from lumpedcable.results.spread import even
from lumpedcable.view import style
from lumpedcable.view.ground import draw_ground, ground_note
from lumpedcable.view.groups import Group
from lumpedcable.view.sampling import extent, side_view

Array = NDArray[Any]

_SHAPES = 5  # times at which the shape is drawn
_TRUE_SHAPE = 6.0  # lines longer than so many times their height get a stretched vertical scale
_AXES = "xyz"


def end_tension_figure(result: ResultFile, group: Group) -> Figure:
    """Tension at both ends of every line against time, a panel for each run."""
    names = [name for name in result.lines if has_end_tension(result.line(name))]
    data: dict[int, list[tuple[str, int, Array]]] = {run: [] for run in group.runs}
    for run in group.runs:
        for index, name in enumerate(names):
            for side, tension in zip(
                ("start", "end"), _end_tensions(result.line(name), run), strict=True
            ):
                data[run].append((f"{name}.{side}", index, tension))
    together = [np.array([tension for _, _, tension in curves]) for curves in data.values()]
    factor, unit = style.shared_unit(together, "N")
    clock = group.clock(result, result.time)
    heading = group.heading(result, "Tension at the ends")
    figure, axes = style.panel_figure(group.titles, heading)
    entries: dict[str, Line2D] = {}
    for ax, curves, values in zip(axes, data.values(), together, strict=True):
        for name, index, tension in curves:
            look = {
                "color": style.COLOURS[index % len(style.COLOURS)],
                # of lines that share a colour the later one has other dashes
                "linestyle": style.DASHES[
                    (2 * (index // len(style.COLOURS)) + name.endswith(".end")) % len(style.DASHES)
                ],
            }
            ax.plot(clock.shown, tension * factor, **look)
            entries[name] = Line2D([], [], label=name, **look)
        ax.set_xlim(clock.limits)
        ax.set_ylim(style.limits(values * factor, zero=True))
        if not np.isfinite(values).any():
            style.say_empty(ax)
    style.label_outer(axes, clock.label, style.with_unit("tension", unit))
    style.foot(figure, group.note, list(entries.values()))
    return figure


def has_end_tension(line: LineData) -> bool:
    """Whether the file tells of the tension at a line's ends: of that itself, or of its segments."""
    return _has_ends(line) or line.has("tension")


def _has_ends(line: LineData) -> bool:
    return line.has("start_tension") and line.has("end_tension")


def _end_tensions(line: LineData, run: int) -> tuple[Array, Array]:
    """Tension (N) at the start and the end, (time,); where it is not kept that of the end segments."""
    if _has_ends(line):
        return line.field("start_tension", run), line.field("end_tension", run)
    tension = line.tension(run)
    return tension[:, 0], tension[:, line.node_count(run) - 2]


def shape_figure(result: SoundFile, group: Group) -> Figure:
    """All lines seen from the side at a few times, a panel for each run, at its end if that is early."""
    ends = {run: result.last_frame(run) for run in group.runs}
    times = even(max(ends.values()) + 1, _SHAPES)
    seen = {run: np.unique(np.minimum(times, end)) for run, end in ends.items()}
    shapes = {run: _shapes(result, run, seen[run]) for run in group.runs}
    across, up = side_view([shape for run in shapes.values() for shape in run])
    clock = style.clock(result.field_time)
    note = true_to_scale([shape for run in shapes.values() for shape in run], (across, up))
    heading = group.heading(result, "Shape")
    figure, axes = style.panel_figure(group.titles, heading)
    shown_times = clock.shown[times]
    colours = Normalize(shown_times[0], shown_times[-1])
    ground: set[str] = set()
    for ax, run in zip(axes, group.runs, strict=True):
        _draw(ax, shapes[run], (across, up), clock.shown[seen[run]], colours)
        ground |= draw_ground(ax, result, run, (across, up))
        if not note:
            ax.set_aspect("equal", adjustable="datalim")
    style.label_outer(axes, f"{_AXES[across]} (m)", f"{_AXES[up]} (m)")
    shown = ScalarMappable(colours, style.time_colours())
    bar = figure.colorbar(shown, ax=axes, label=clock.label, aspect=35, pad=0.02)
    bar.set_ticks(shown_times.tolist())
    style.foot(figure, f"{note} {ground_note(ground)}".strip() + f"\n{group.note}")
    return figure


def true_to_scale(shapes: Sequence[Array], plane: tuple[int, int]) -> str:
    """What to say of shapes (..., 3) that are too long to be drawn in one scale, "" of others."""
    everything = np.concatenate([shape.reshape(-1, 3) for shape in shapes])
    wide, high = (extent(everything[:, component]) for component in plane)
    # what is flat but for rounding has no height to stretch
    true = wide <= _TRUE_SHAPE * high or high <= style.ROUNDING * wide
    words = "Vertical scale" if plane[1] == 2 else f"Scale of {_AXES[plane[1]]}"
    return "" if true else f"{words} stretched."


def _shapes(result: ResultFile, run: int, times: Array) -> list[Array]:
    found = []
    for name in result.lines:
        line = result.line(name)
        if line.has("position"):
            found.append(line.position(run)[times, : line.node_count(run)])
    return found


def _draw(
    ax: Axes, lines: list[Array], plane: tuple[int, int], keys: Array, colours: Normalize
) -> None:
    table = style.time_colours()
    for shape in lines:
        for key, points in zip(keys, shape, strict=True):
            ax.plot(points[:, plane[0]], points[:, plane[1]], color=table(colours(key)))
    points = np.concatenate([shape.reshape(-1, 3) for shape in lines])
    if not np.isfinite(points).any():
        style.say_empty(ax)
