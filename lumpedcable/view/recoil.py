"""Figures of a line that parts: tension and velocity along it, end speed, and the x-t diagram.

The first three show what Zhu, Yin and Shen (2018), figures 2-7, show: curves over the unstretched
line every 10 ms, a panel for each run, and the speed of the broken end against time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.human import quantity
from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group
from lumpedcable.view.sampling import RecoilingEnd, curve_times

Array = NDArray[Any]

_PLACE = "unstretched position (m)"
_PUSHED = 0.05  # share of the largest tension from which compression gets a hue of its own
_MOST_CELLS = 600  # of the x-t diagram, along each axis: more than a printed panel resolves


def tension_figure(result: ResultFile, end: RecoilingEnd, group: Group) -> Figure:
    """Tension along the unstretched line at a round spacing of time, a panel for each run."""

    def tension(run: int, times: Array) -> tuple[Array, Array]:
        kept = end.line.node_count(run) - 1
        values = end.line.tension(run)[times, :kept]
        if kept == 1:  # which is a point, and nothing of a curve
            return np.sort(end.places(run)), np.repeat(values, 2, axis=1)
        return end.line.unstretched_segment(run)[:kept], values

    return _families(result, end, group, tension, "tension", "N")


def velocity_figure(result: ResultFile, end: RecoilingEnd, group: Group) -> Figure:
    """Velocity along the initial line, positive away from the break, a panel for each run."""

    def recoil(run: int, times: Array) -> tuple[Array, Array]:
        place, velocity = end.recoil(run)
        return place, velocity[times]

    return _families(result, end, group, recoil, "recoil velocity", "m/s")


def _families(
    result: ResultFile,
    end: RecoilingEnd,
    group: Group,
    field: Callable[[int, Array], tuple[Array, Array]],
    words: str,
    unit: str,
) -> Figure:
    clock = group.clock(result, result.field_time)
    times, spacing = curve_times(result.field_time[: clock.last + 1])
    data = {run: field(run, times) for run in group.runs}
    factor, text = style.shared_unit([values for _, values in data.values()], unit)
    note = f"A curve every {quantity(spacing, 's')}." if spacing else ""
    if words == "recoil velocity":
        note += f" Positive: away from the broken end ({end.name}), along the line as it lay."
    heading = group.heading(result, f"{words.capitalize()} along {end.line.name}")
    figure, axes = style.panel_figure(group.titles, heading)
    colours = Normalize(clock.shown[0], clock.shown[clock.last])
    for ax, (place, values) in zip(axes, data.values(), strict=True):
        style.family(ax, place, values * factor, clock.shown[times], colours)
        ax.set_xlim(style.limits(place, margin=0.02))
        ax.set_ylim(style.limits(values * factor, zero=True))
        if not np.isfinite(values).any():
            style.say_empty(ax)
    style.label_outer(axes, _PLACE, style.with_unit(words, text))
    shown = ScalarMappable(colours, style.time_colours())
    figure.colorbar(shown, ax=axes, label=clock.label, aspect=35, pad=0.02)
    style.foot(figure, f"{note}\n{group.note}")
    return figure


def end_speed_figure(result: ResultFile, end: RecoilingEnd, group: Group) -> Figure:
    """Speed of the broken end against time, one curve a run, with the exact speed where known."""
    curves, levels = end.speed, end.exact_speed
    return _against_time(
        result, end, group, "Speed", "speed of the broken end (m/s)", curves, levels
    )


def end_displacement_figure(result: ResultFile, end: RecoilingEnd, group: Group) -> Figure:
    """Distance of the broken end from where its break began against time, one curve a run."""
    words = "displacement of the broken end (m)"
    return _against_time(result, end, group, "Displacement", words, end.displacement)


def _against_time(
    result: ResultFile,
    end: RecoilingEnd,
    group: Group,
    what: str,
    words: str,
    curves: Callable[[int], Array],
    levels: Callable[[int], float | None] = lambda run: None,
) -> Figure:
    """What the broken end does against time, one curve a run; its exact level where known."""
    clock = group.clock(result, result.time)
    figure = style.new_figure(3.4, group.heading(result, f"{what} of {end.name}"))
    ax = figure.subplots()
    exact = False
    drawn = [np.zeros(1)]
    handles: list[Line2D] = []
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        curve, look = curves(run), style.curve(index)
        drawn.append(curve)
        name = title.replace("\n", ": ") or "this run"
        handles += ax.plot(clock.shown, curve, **look, label=name)
        value = levels(run)
        if value is not None:
            exact = True
            drawn.append(np.array([value]))
            ax.axhline(value, color=look["color"], linewidth=0.7, linestyle=(0, (1, 2)), zorder=1)
    if exact:
        why = f": {end.holds()}" if end.holds() else ""
        dotted = Line2D([], [], color=style.NEUTRAL, linewidth=0.7, linestyle=(0, (1, 2)))
        dotted.set_label(style.wrapped(f"exact{why}", style.WIDTH / 3, 7))
        handles.append(dotted)
    ax.set_xlim(clock.limits)
    ax.set_ylim(style.limits(np.concatenate(drawn), zero=True))
    ax.set_xlabel(clock.label)
    ax.set_ylabel(words)
    named = len(handles) > 1 or bool(group.titles[0])
    style.foot(figure, group.note, handles if named else [])
    return figure


def xt_figure(result: ResultFile, end: RecoilingEnd, group: Group) -> Figure:
    """Tension as colour over the unstretched line and time, with the exact fronts drawn in."""
    clock = group.clock(result, result.field_time)
    figure, axes = style.panel_figure(
        group.titles,
        group.heading(result, f"Tension over {end.line.name} and time"),
        height=2.3,
    )
    fields = [end.line.tension(run)[:, : end.line.node_count(run) - 1] for run in group.runs]
    pushed = any(np.nanmin(t, initial=0) < -_PUSHED * style.largest(t) for t in fields)
    entries: dict[str, Line2D] = {}
    for ax, run, tension in zip(axes, group.runs, fields, strict=True):
        ax.grid(False)
        ax.set_ylim(*(clock.shown[[0, clock.last]]) if len(clock.shown) > 1 else (0, 1))
        ax.set_xlim(*sorted(end.places(run)))
        if not np.isfinite(tension).any():
            style.say_empty(ax)
            continue
        factor, unit = style.shared_unit([tension], "N")
        node = end.line.unstretched_position(run)[: tension.shape[1] + 1]
        mesh = _coloured(ax, node, clock.shown, tension * factor, pushed)
        figure.colorbar(mesh, ax=ax, label=style.with_unit("tension", unit), aspect=25, pad=0.02)
        entries |= _fronts(ax, end, run, clock.factor)
    style.label_outer(axes, _PLACE, clock.label)
    style.foot(figure, group.note, list(entries.values()))
    return figure


def _coloured(ax: Axes, node: Array, time: Array, tension: Array, pushed: bool) -> Any:
    """Cells between the nodes and between the middles of the saved times.

    Where lines are pushed as well as pulled, zero stands in the middle of two hues.
    """
    stride = -(-tension.shape[1] // _MOST_CELLS)
    skip = -(-tension.shape[0] // _MOST_CELLS)
    time, tension = time[::skip], tension[::skip, ::stride]
    node = np.append(node[:-1:stride], node[-1])
    middle = (time[1:] + time[:-1]) / 2
    edges = np.concatenate([time[:1], middle, time[-1:]])
    top = style.largest(tension) or 1.0
    bottom = -top if pushed else float(np.nanmin(tension, initial=0))
    table = matplotlib.colormaps["PuOr_r" if pushed else "viridis"].with_extremes(bad="#D9D9D9")
    colours = Normalize(bottom, top)
    masked = np.ma.masked_invalid(tension)
    return ax.pcolormesh(node, edges, masked, cmap=table, norm=colours, rasterized=True)


def _fronts(ax: Axes, end: RecoilingEnd, run: int, to_time: float) -> dict[str, Line2D]:
    """Draw fronts as straight lines and reported arrivals as marks; returns legend entries."""
    broken, other = end.places(run)
    start = end.start(run)
    entries: dict[str, Line2D] = {}
    if start is None:
        return entries
    fronts = 0
    halo = [patheffects.withStroke(linewidth=2.4, foreground="black")]
    for label, exact, arrival in end.arrivals(run):
        until = (start + arrival) * to_time
        if exact:
            look: dict[str, Any] = {
                "color": "white",
                "linewidth": 1.2,
                "linestyle": style.DASHES[(fronts + 1) % len(style.DASHES)],
                "path_effects": halo,
            }
            fronts += 1
            ax.plot([broken, other], [start * to_time, until], **look)
        else:
            look = {
                "color": "white",
                "linestyle": "none",
                "marker": "D",
                "markersize": 5,
                "markeredgecolor": style.COLOURS[1],
                "markeredgewidth": 1.2,
            }
            if until <= ax.get_ylim()[1]:  # on the frame, so drawn over it, not cut by it
                ax.plot([other], [until], **look, clip_on=False, zorder=5)
        entries[label] = Line2D([], [], label=style.wrapped(label, style.WIDTH / 2.2, 7), **look)
    return entries
