"""Figure of the range of the tension along the lines: the most and the least that each place bears."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.human import quantity
from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import ResultFile
from lumpedcable.results.schema import PEAK_TENSION
from lumpedcable.view import style
from lumpedcable.view.groups import Group, foremost

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


class _Borne(NamedTuple):
    """A line and what it bears in the runs of a group, all in N.

    `largest` of each segment, (segment,), and `stepwise` whether that is of any step, by run;
    `strength` is NaN where the file tells of none, or the runs have others.
    """

    line: LineData
    largest: list[Array]
    stepwise: list[bool]
    strength: float

    @property
    def peak(self) -> float:
        """The largest of all."""
        return max(map(style.largest, self.largest))

    @property
    def drawn(self) -> bool:
        """Whether its strength is drawn beside its tensions; else the title tells of it."""
        return bool(self.strength <= _FAR * self.peak)


def range_figure(result: ResultFile, names: list[str], group: Group) -> Figure:
    """Range of tension over the unstretched place, a panel for each line.

    Of one run the largest tension of each segment, the smallest and that at the start; of several the
    largest, a curve for each run. The largest is that of any step where the file knows it. A breaking
    strength is drawn beside them, or told where it is more than three times as large.
    """
    every = [_borne(result.line(name), group) for name in names]
    shown = [every[k] for k in foremost([one.peak for one in every])]
    factor, unit = style.shared_unit([np.concatenate(one.largest) for one in shown], "N")
    titles = [_title(one, group) for one in shown]
    figure, axes = style.panel_figure(titles, group.heading(result, "Range of tension"))
    for ax, one in zip(axes, shown, strict=True):
        drawn = one.largest
        if len(group.runs) == 1:
            drawn = _draw_one(ax, one, group.runs[0], factor)
        else:
            for index, (run, curve) in enumerate(zip(group.runs, drawn, strict=True)):
                ax.plot(*_curve(one.line, run, curve * factor), **style.curve(index))
        if one.drawn:
            ax.axhline(one.strength * factor, **_STRENGTH)
            drawn = [*drawn, np.array([one.strength])]
        ax.set_ylim(style.limits(np.concatenate(drawn) * factor, zero=True))
        if not np.isfinite(np.concatenate(drawn)).any():
            style.say_empty(ax)
    style.label_outer(axes, "unstretched position (m)", style.with_unit("tension", unit))
    style.foot(figure, _note(shown, len(names), group), _entries(shown, group))
    return figure


def _borne(line: LineData, group: Group) -> _Borne:
    found = [_largest(line, run) for run in group.runs]
    strengths = {line.breaking_strength(run) for run in group.runs}
    strength = strengths.pop() if len(strengths) == 1 else float("nan")
    return _Borne(line, [most for most, _ in found], [step for _, step in found], strength)


def _largest(line: LineData, run: int) -> tuple[Array, bool]:
    """The largest tension of each segment in N, shape (segment,), and whether it is that of any step.

    That is not told of a run that went wrong: what comes after it would count.
    """
    if line.has(PEAK_TENSION):
        peak = line.field(PEAK_TENSION, run)[: _segments(line, run)]
        if np.isfinite(peak).any() or not line.has("tension"):
            return peak, True
    return _extreme(np.fmax, line, run), False


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


def _draw_one(ax: Axes, one: _Borne, run: int, factor: float) -> list[Array]:
    """The range of one run; returns what was drawn, in N."""
    line, (largest,) = one.line, one.largest
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


def most_at(name: str, values: Array, unit: str, places: Array) -> str:
    """A line's name, the largest value along it, and at which place (m)."""
    if not np.isfinite(values).any():
        return name
    at = int(np.nanargmax(values))
    most, place = quantity(float(values[at]), unit, 4), quantity(float(places[at]), "m", 4)
    return f"{name}: at most {most}, at {place}"


def run_entries(group: Group) -> list[Line2D]:
    """What a legend says of the curves of several runs."""
    return [
        Line2D([], [], label=title.replace("\n", ": "), **style.curve(index))
        for index, title in enumerate(group.titles)
    ]


def _title(one: _Borne, group: Group) -> str:
    """The line's name; of a single run also how much it bears at most, and where; a strength far off."""
    told, largest = one.line.name, one.largest[0]
    if len(group.runs) == 1:
        told = most_at(told, largest, "N", _middles(one.line, group.runs[0]))
    if np.isnan(one.strength) or one.drawn:
        return told
    return f"{told}; breaking strength {quantity(one.strength, 'N', 4)}"


def _note(shown: list[_Borne], lines: int, group: Group) -> str:
    stepwise = [step for one in shown for step in one.stepwise]
    known = all(one.line.has(PEAK_TENSION) for one in shown)
    when = "at any step" if known else "at the saved times"
    if known and not all(stepwise):
        when += ", of runs that went wrong at the saved times until then"
    told = [f"Largest tension of each segment {when}."]
    if len(shown) < lines:
        told.append(f"The {len(shown)} of {lines} lines that bear the most.")
    return " ".join([*told, group.note]).strip()


def _entries(shown: list[_Borne], group: Group) -> list[Line2D]:
    entries = run_entries(group)
    if len(group.runs) == 1:
        entries = [Line2D([], [], label="largest", **_LARGEST)]
        if any(one.line.has("tension") for one in shown):
            entries.append(Line2D([], [], label="smallest at the saved times", **_SMALLEST))
            entries.append(Line2D([], [], label="at the start", **_START))
    if any(one.drawn for one in shown):
        entries.append(Line2D([], [], label="breaking strength", **_STRENGTH))
    return entries
