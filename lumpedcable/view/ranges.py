"""Figure of the range of the tension along the lines: the most and the least that each place bears."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.human import quantity
from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import OK, ResultFile
from lumpedcable.results.schema import PEAK_TENSION
from lumpedcable.view import style
from lumpedcable.view.groups import MOST_PANELS, Group

Array = NDArray[Any]

_LARGEST: dict[str, Any] = {"color": style.COLOURS[0]}
_SMALLEST: dict[str, Any] = {"color": style.COLOURS[1], "linestyle": style.DASHES[1]}
_STRENGTH: dict[str, Any] = {"color": style.NEUTRAL, "linewidth": 0.8}
_FAR = 3.0  # times the largest tension: a strength beyond it would leave the tensions no room
_START: dict[str, Any] = {"color": style.NEUTRAL, "linestyle": style.DASHES[2]}


def has_range(line: LineData) -> bool:
    """Whether the file tells what each segment of a line bears, and where it is."""
    bears = line.has(PEAK_TENSION) or line.has("tension")
    return bears and line.has("unstretched_position")


def range_figure(result: ResultFile, names: list[str], group: Group) -> Figure:
    """Range of tension over the unstretched place, a panel for each line.

    Of one run the largest tension of each segment, the smallest and that at the start; of several the
    largest, a curve for each run. The largest is that of any step where the file knows it. A breaking
    strength is drawn beside them, or told where it is more than three times as large.
    """
    shown = _foremost(result, names, group)
    largest = {name: [_largest(result.line(name), run) for run in group.runs] for name in shown}
    factor, unit = style.shared_unit([np.concatenate(found) for found in largest.values()], "N")
    alone = len(group.runs) == 1
    titles = [_title(result.line(name), group, largest[name]) for name in shown]
    figure, axes = style.panel_figure(titles, group.heading(result, "Range of tension"))
    for ax, name in zip(axes, shown, strict=True):
        line, drawn = result.line(name), largest[name]
        if alone:
            drawn = _draw_one(ax, line, group.runs[0], drawn[0], factor)
        else:
            for index, (run, curve) in enumerate(zip(group.runs, drawn, strict=True)):
                ax.plot(*_curve(line, run, curve * factor), **style.curve(index))
        strength = _strength(line, group)
        if _drawn(strength, largest[name]):
            ax.axhline(strength * factor, **_STRENGTH)
            drawn = [*drawn, np.array([strength])]
        ax.set_ylim(style.limits(np.concatenate(drawn) * factor, zero=True))
        if not np.isfinite(np.concatenate(drawn)).any():
            style.say_empty(ax)
    style.label_outer(axes, "unstretched position (m)", style.with_unit("tension", unit))
    entries = _entries(result, shown, group)
    if any(_drawn(_strength(result.line(name), group), largest[name]) for name in shown):
        entries.append(Line2D([], [], label="breaking strength", **_STRENGTH))
    style.foot(figure, _note(result, names, shown, group), entries)
    return figure


def _foremost(result: ResultFile, names: list[str], group: Group) -> list[str]:
    """The lines that bear the most, as many as there is room for, in the order of the file."""
    peak = {
        name: max(style.largest(_largest(result.line(name), run)) for run in group.runs)
        for name in names
    }
    first = sorted(names, key=lambda name: -peak[name])[:MOST_PANELS]
    return [name for name in names if name in first]


def _largest(line: LineData, run: int) -> Array:
    """The largest tension of each segment in N, shape (segment,).

    That of any step is not told of a run that went wrong: what comes after it would count.
    """
    if line.has(PEAK_TENSION):
        peak = line.field(PEAK_TENSION, run)[: _segments(line, run)]
        if np.isfinite(peak).any() or not line.has("tension"):
            return peak
    return _extreme(np.fmax, line, run)


def _extreme(which: np.ufunc, line: LineData, run: int) -> Array:
    """Of the saved times, as far as the run went well."""
    return which.reduce(line.tension(run)[:, : _segments(line, run)], axis=0)


def _segments(line: LineData, run: int) -> int:
    return max(line.node_count(run) - 1, 0)  # a run that has not begun has no places


def _middles(line: LineData, run: int) -> Array:
    return line.unstretched_segment(run)[: _segments(line, run)]


def _curve(line: LineData, run: int, values: Array) -> tuple[Array, Array]:
    """Values of segments over the whole line: to its ends as they are in the end segments."""
    node = line.unstretched_position(run)[: line.node_count(run)]
    place = np.concatenate([node[:1], _middles(line, run), node[-1:]])
    return place, np.concatenate([values[:1], values, values[-1:]])


def _draw_one(ax: Axes, line: LineData, run: int, largest: Array, factor: float) -> list[Array]:
    """The range of one run; returns what was drawn, in N."""
    place, most = _curve(line, run, largest * factor)
    ax.plot(place, most, **_LARGEST)
    if not line.has("tension"):
        return [largest]
    smallest = _extreme(np.fmin, line, run)
    start = line.tension(run, 0)[: len(smallest)]
    _, least = _curve(line, run, smallest * factor)
    ax.fill_between(place, least, most, color=style.COLOURS[0], alpha=0.12, linewidth=0)
    ax.plot(place, least, **_SMALLEST)
    ax.plot(*_curve(line, run, start * factor), **_START)
    return [largest, smallest, start]


def _strength(line: LineData, group: Group) -> float:
    """Its strength in N, NaN where the file tells of none, or runs of the group have others."""
    every = {line.breaking_strength(run) for run in group.runs}
    return every.pop() if len(every) == 1 else float("nan")


def _drawn(strength: float, largest: list[Array]) -> bool:
    """Whether a strength is drawn beside these tensions; else the title tells of it."""
    return bool(strength <= _FAR * style.largest(np.concatenate(largest)))


def _title(line: LineData, group: Group, largest: list[Array]) -> str:
    """The line's name; of a single run also how much it bears at most, and where; a strength far off."""
    told = line.name
    if len(group.runs) == 1 and np.isfinite(largest[0]).any():
        at = int(np.nanargmax(largest[0]))
        most = quantity(float(largest[0][at]), "N", 4)
        place = quantity(float(_middles(line, group.runs[0])[at]), "m", 4)
        told = f"{line.name}: at most {most}, at {place}"
    strength = _strength(line, group)
    if np.isnan(strength) or _drawn(strength, largest):
        return told
    return f"{told}; breaking strength {quantity(strength, 'N', 4)}"


def _note(result: ResultFile, names: list[str], shown: list[str], group: Group) -> str:
    stepwise = all(result.line(name).has(PEAK_TENSION) for name in shown)
    when = "at any step" if stepwise else "at the saved times"
    if stepwise and any(result.status[run] not in (OK, "still_moving") for run in group.runs):
        when += ", of runs that went wrong at the saved times until then"
    told = [f"Largest tension of each segment {when}."]
    if len(shown) < len(names):
        told.append(f"The {len(shown)} of {len(names)} lines that bear the most.")
    return " ".join([*told, group.note]).strip()


def _entries(result: ResultFile, shown: list[str], group: Group) -> list[Line2D]:
    if len(group.runs) == 1:
        entries = [Line2D([], [], label="largest", **_LARGEST)]
        if any(result.line(name).has("tension") for name in shown):
            entries.append(Line2D([], [], label="smallest at the saved times", **_SMALLEST))
            entries.append(Line2D([], [], label="at the start", **_START))
        return entries
    return [
        Line2D([], [], label=title.replace("\n", ": "), **style.curve(index))
        for index, title in enumerate(group.titles)
    ]
