"""Energies against time, with the residual of their balance on a scale of its own."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group

Array = NDArray[Any]

RESIDUAL = "residual"
VISIBLE = 2e-3
"""A term that stays below this share of the largest one in every run is named, not drawn."""
STEADY = 0.1
"""What changes by less than this share of what is stored at the start is drawn by its change."""
LESS = ", less that at the start"


def energy_figure(result: ResultFile, group: Group) -> Figure:
    """Every energy term against time, a panel for each run, each over a panel of the residual.

    Terms that are zero throughout are left out; those too small to be seen are named in a note. What is
    stored from an arbitrary level, or hardly changes, is drawn less what it was at the start.
    """
    count, runs = len(group.runs), list(group.runs)
    names = [name for name in result.energy_terms if name != RESIDUAL]
    every = {name: result.energy(name) for name in names}
    lowered = [name for name, values in every.items() if _is_lowered(name, values)]
    whole = _moving(every | {name: _from_start(every[name]) for name in lowered})
    # by what any run of the file shows, so that a term looks the same in all its figures
    hidden = _too_small(whole)
    shown = [name for name in whole if name not in hidden]
    looks = {name: style.curve(index) for index, name in enumerate(shown)}
    terms = _moving({name: values[runs] for name, values in whole.items()})
    small = _too_small(terms)
    terms = {name: values for name, values in terms.items() if name not in small}
    rest = result.energy(RESIDUAL)[runs] if RESIDUAL in result.energy_terms else None
    panels = [np.array([values[place] for values in terms.values()]) for place in range(count)]
    factor, unit = style.shared_unit(panels, "J")
    clock = group.clock(result, result.time)
    rest_unit = ""
    figure, upper, lower = _stacked(result, group, rest is not None)
    for ax, curves in zip(upper, panels, strict=True):
        for name, values in zip(terms, curves, strict=True):
            ax.plot(clock.shown, values * factor, **looks[name])
        ax.set_ylim(style.limits(curves * factor, zero=True))
        if not np.isfinite(curves).any():
            style.say_empty(ax)
    if rest is not None:
        rest_unit = _residuals(lower, clock.shown, rest)
    for ax in (*upper, *lower):
        ax.set_xlim(clock.limits)
    label = clock.label
    style.label_outer(upper, "" if lower else label, style.with_unit("energy", unit))
    if lower:
        style.label_outer(lower, label, style.with_unit("residual\n", rest_unit))
    labels = {name: result.energy_name(name) + LESS * (name in lowered) for name in terms}
    handles = [Line2D([], [], label=labels[name], **looks[name]) for name in terms]
    note = group.note
    if small:
        names = ", ".join(name.replace("_", " ") for name in small)
        note = f"{note} Below {100 * VISIBLE:g} % of the largest, not drawn: {names}.".strip()
    style.foot(figure, note, handles)
    figure.align_ylabels()
    return figure


def _is_lowered(name: str, values: Array) -> bool:
    """Whether a term, J of shape (run, time), is drawn less its value at the start.

    Heights count from an arbitrary level; strain energy that hardly changes would be a line far above
    all that does.
    """
    if name == "gravitational":
        return True
    if name.startswith(("work_", "lost_", "kinetic")):
        return False
    change = np.abs(_finite(_from_start(values)))
    return bool(np.all(change <= STEADY * np.abs(_finite(values[:, :1]))))


def _from_start(values: Array) -> Array:
    return values - values[:, :1]


def _moving(terms: dict[str, Array]) -> dict[str, Array]:
    """The terms that are not zero throughout."""
    return {name: values for name, values in terms.items() if style.largest(values) > 0}


def _too_small(terms: dict[str, Array]) -> list[str]:
    """Names of the terms that no run would show on the scale of its largest term."""
    if not terms:
        return []
    sizes = {name: np.nanmax(np.abs(_finite(values)), axis=1) for name, values in terms.items()}
    top = np.max(list(sizes.values()), axis=0)
    return [name for name, size in sizes.items() if np.all(size < VISIBLE * top)]


def _finite(values: Array) -> Array:
    return np.where(np.isfinite(values), values, 0.0)


def _stacked(
    result: ResultFile, group: Group, residual: bool
) -> tuple[Figure, list[Axes], list[Axes]]:
    """Panels in the usual grid, each split into energies above and residual below."""
    heading = group.heading(result, "Energy")
    if not residual:
        return *style.panel_figure(group.titles, heading), []
    rows, columns = style.grid_shape(len(group.runs))
    figure = style.new_figure(max(2.7 * rows, 3.6) + 0.4, heading)
    cells = figure.add_gridspec(2 * rows, columns, height_ratios=(3, 1) * rows)
    upper, lower = [], []
    for place, title in enumerate(group.titles):
        row, column = divmod(place, columns)
        above = figure.add_subplot(cells[2 * row, column])
        below = figure.add_subplot(cells[2 * row + 1, column], sharex=above)
        above.tick_params(labelbottom=False)
        above.set_title(style.panel_title(title, columns))
        upper.append(above)
        lower.append(below)
    return figure, upper, lower


def _residuals(axes: list[Axes], time: Array, rest: Array) -> str:
    """Draw the residual of each run; returns the unit it is drawn in."""
    factor, unit = style.shared_unit(list(rest), "J")
    for ax, values in zip(axes, rest, strict=True):
        ax.plot(time, values * factor, color=style.NEUTRAL, linewidth=0.8)
        ax.set_ylim(style.limits(values * factor, zero=True, margin=0.12))
        ax.locator_params(axis="y", nbins=3)
    return unit
