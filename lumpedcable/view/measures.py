"""Figures of the numbers that a scene asks for: against time, and one bar a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group, ends_note

__all__ = ["MOST_BARS", "bars_figure", "measure_figure"]

Array = NDArray[Any]

MOST_BARS = 40  # runs in one figure
LONG_LABEL = 16  # letters beyond which labels stand in lines beside their bars
LABEL_WIDTH, LABEL_SIZE, ROW = 2.8, 7, 0.13  # of such labels: inches, points, inches a line


def measure_figure(result: ResultFile, name: str, group: Group) -> Figure:
    """One measure against time, a curve for each run of the group, and its limit."""
    table, attributes = result.measures()[name]
    mine = [table[run] for run in group.runs]
    factor, unit = _unit(mine, attributes)
    clock = group.clock(result, result.time)
    figure, (ax,) = style.panel_figure([""], group.heading(result, name), height=3.0)
    entries, drawn = [], []
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        look = {
            "color": style.COLOURS[index % len(style.COLOURS)],
            "linestyle": style.DASHES[index % len(style.DASHES)],
        }
        ax.plot(clock.shown, table[run] * factor, **look)
        if title:  # a run alone has nothing to be told from
            entries.append(Line2D([], [], label=title.replace("\n", ", "), **look))
        drawn.append(table[run] * factor)
    _draw_limit(ax, attributes.get("limit"), factor, entries, drawn)
    values = np.concatenate(drawn)
    if np.isfinite(values).any():
        ax.set_ylim(style.limits(values))
    else:
        style.say_empty(ax)
    ax.set_xlim(clock.limits)
    text = str(attributes.get("long_name", name))
    style.label_outer([ax], clock.label, style.with_unit(text, unit))
    style.foot(figure, group.note, entries)
    return figure


def _unit(values: list[Array], told: Mapping[str, Any]) -> tuple[float, str]:
    """Factor and unit that suit values of a measure and its limit, which is drawn beside them."""
    limit = told.get("limit")
    both = values if limit is None else [*values, np.array([float(limit)])]
    return style.shared_unit(both, str(told.get("units", "1")))


def bars_figure(result: ResultFile, name: str) -> Figure:
    """What a measure comes down to in each run, as bars, and its limit."""
    told = result.summary_attributes("run", name)
    values = result.summary()["run"][name]
    factor, unit = _unit([values], told)
    values = values * factor
    heading = "\n".join(filter(None, [str(result.attributes.get("title", "")), name]))
    labels = result.cases or [result.label(run) or f"run {run}" for run in range(result.runs)]
    lying = max(map(len, labels)) > LONG_LABEL
    if lying:
        labels = [style.wrapped(label, LABEL_WIDTH, LABEL_SIZE) for label in labels]
    rows = sum(label.count("\n") + 2 for label in labels) if lying else 0
    figure, (ax,) = style.panel_figure([""], heading, height=max(3.0, ROW * rows))
    places = np.arange(result.runs)
    drawn, entries = [values, np.zeros(1)], []
    _draw_limit(ax, told.get("limit"), factor, entries, drawn, upright=lying)
    ends = style.limits(np.concatenate(drawn))
    words = style.with_unit(str(told.get("long_name", name)), unit)
    if lying:
        ax.barh(places, values, color=style.COLOURS[0], height=0.7)
        ax.set_yticks(places, labels)
        ax.set_ylim(result.runs - 0.5, -0.5)  # the first run on top, as in a table
        ax.set_xlim(ends)
        ax.set_xlabel(style.wrapped(words, style.WIDTH - LABEL_WIDTH - 1.0))
    else:
        ax.bar(places, values, color=style.COLOURS[0], width=0.7)
        ax.set_xticks(places, labels, rotation=90 if max(map(len, labels)) > 3 else 0)
        ax.set_xlim(-0.5, result.runs - 0.5)
        ax.set_ylim(ends)
        ax.set_ylabel(style.wrapped(words, 2.0))
    ax.grid(False, axis="y" if lying else "x")
    note = ends_note(result, range(result.runs), "what they came to before counts")
    style.foot(figure, note, entries)
    return figure


def _draw_limit(
    ax: Axes, limit: Any, factor: float, entries: list[Line2D], drawn: list[Array],
    upright: bool = False,
) -> None:  # fmt: skip
    """A line at the limit of a measure, if it has one, with its legend entry and its place.

    `factor` leads to the units of the figure.
    """
    if limit is None:
        return
    look = {"color": style.NEUTRAL, "linewidth": 0.8}
    (ax.axvline if upright else ax.axhline)(float(limit) * factor, **look)
    entries.append(Line2D([], [], label="limit", **look))
    drawn.append(np.asarray([float(limit) * factor]))
