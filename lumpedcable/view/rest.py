"""Figures of a scene at rest: the shape of a cable, and its numbers over what is swept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.chord import along_chord
from lumpedcable.results.human import quantity, scale
from lumpedcable.results.reader import Axis, ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group, ends_note

Array = NDArray[Any]
Numbers = Mapping[str, Array]

_TENSIONS = {
    "start_tension": "tension at the start",
    "end_tension": "tension at the end",
    "horizontal_tension": "horizontal tension",
}
_COLOURS = dict(zip(_TENSIONS, (style.COLOURS[0], style.COLOURS[2], style.COLOURS[3]), strict=True))
_PANELS = {"length": "length S", "sag": "sag f"}
_MODELS: dict[str, dict[str, Any]] = {
    "exact": {"color": "black", "linestyle": "-", "linewidth": 0.8},
    "straight": {"color": style.COLOURS[1], "linestyle": (0, (5, 1.5)), "linewidth": 0.9},
}


def rest_figure(result: ResultFile, cable: str, group: Group) -> Figure:
    """A cable seen from the side in all runs of a group; below it S, f and the tensions.

    The lower panels need one number that differs between the runs. Dots are what was computed, lines
    the inextensible catenaries and, where something hangs on the cable, the straight segments.
    """
    numbers = result.rest(cable)
    axis = _moved(result, group)
    heading = group.heading(result, "" if len(result.cables) == 1 else cable)
    figure = style.new_figure(3.0 if axis is None else 5.4, heading)
    if axis is None:
        (ax,) = figure.subplots(1, 1, squeeze=False).ravel()
    else:
        grid = figure.add_gridspec(2, 3, height_ratios=[1.15, 1.0])
        ax = figure.add_subplot(grid[0, :])
        below = [figure.add_subplot(grid[1, k]) for k in range(3)]
        _curves(below, numbers, axis, group)
    handles = _shapes(figure, ax, result, cable, group, axis)
    _joints(ax, numbers, group)
    if len(group.runs) == 1:
        ax.set_title(_told(numbers, group.runs[0]))
    note = f"{ends_note(result, group.every)} {group.note}".strip()
    style.foot(figure, note, [*handles, *_legend(numbers, axis)])
    return figure


def _moved(result: ResultFile, group: Group) -> Axis | None:
    """The one swept number that tells the runs of a group apart; None without one."""
    runs = list(group.every)
    moved = [axis for axis in result.axes if len(set(axis.values[runs].tolist())) > 1]
    if len(moved) != 1 or moved[0].values.dtype.kind not in "if":
        return None
    alone = len(set(moved[0].values[runs].tolist())) == len(runs)  # no names of cases beside it
    return moved[0] if alone else None


def _places(result: ResultFile, cable: str, run: int) -> tuple[Array, Array]:
    """Horizontal distance towards its end and height of a cable's nodes from its start, m."""
    lines = [result.line(name) for name in cable.split("+")]
    nodes = np.concatenate([line.position(run, 0) for line in lines if line.has("position")])
    return along_chord(nodes.T[None])[0], nodes[:, 2] - nodes[0, 2]


def _shapes(
    figure: Figure, ax: Axes, result: ResultFile, cable: str, group: Group, axis: Axis | None
) -> list[Line2D]:
    """All shapes of a group, coloured by the swept number; else each its own, with a legend."""
    ax.set_xlabel(style.with_unit("horizontal distance from the start", "m"))
    ax.set_ylabel(style.with_unit("height over the start", "m"))
    if not all(result.line(name).has("position") for name in cable.split("+")):
        style.say_empty(ax)
        return []
    table, colours, factor = style.time_colours(), Normalize(0.0, 1.0), 1.0
    if axis is not None:
        values = axis.values[list(group.runs)].astype(float)
        factor, unit = scale(float(np.abs(values).max()), axis.unit)
        colours = Normalize(values.min() * factor, values.max() * factor)
        shown = ScalarMappable(colours, table)
        figure.colorbar(shown, ax=ax, label=style.with_unit(axis.words, unit), aspect=20, pad=0.02)
    ax.set_aspect("equal", adjustable="datalim")
    handles: list[Line2D] = []
    named = axis is None and len(group.runs) > 1
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        look: dict[str, Any] = {"color": table(0.3)}
        if axis is not None:
            look = {"color": table(colours(float(axis.values[run]) * factor))}
        elif named:
            look = style.curve(index) | {"label": title.replace("\n", ": ")}
        drawn = ax.plot(*_places(result, cable, run), **look, linewidth=1.0)
        handles += drawn if named else []
    return handles


def _joints(ax: Axes, numbers: Numbers, group: Group) -> None:
    """Where the joint or the load is by every model."""
    runs = list(group.runs)
    if "joint_x" not in numbers:
        return
    ax.plot(numbers["joint_x"][runs], numbers["joint_z"][runs], **_dots("black"))
    for model, marker in (("exact", "o"), ("straight", "x")):
        if f"{model}_joint_x" in numbers:
            x, z = numbers[f"{model}_joint_x"][runs], numbers[f"{model}_joint_z"][runs]
            look: dict[str, Any] = {"color": _MODELS[model]["color"], "linestyle": ""}
            look |= {"marker": marker, "markersize": 5, "markerfacecolor": "none"}
            ax.plot(x, z, **look, markeredgewidth=0.8)


def _dots(colour: str) -> dict[str, Any]:
    return {"color": colour, "linestyle": "", "marker": ".", "markersize": 5}


def _curves(panels: list[Axes], numbers: Numbers, axis: Axis, group: Group) -> None:
    """Length, sag and tensions of the runs of a group over the swept number."""
    runs = np.array(group.every)
    order = runs[np.argsort(axis.values[runs])]
    to_axis, axis_unit = scale(float(np.abs(axis.values[runs]).max()), axis.unit)
    x = axis.values[order] * to_axis
    tensions = [numbers[key][runs] for key in _TENSIONS]
    factor, unit = style.shared_unit(tensions, "N")
    for ax, (key, words) in zip(panels, _PANELS.items(), strict=False):
        _curve(ax, numbers, key, x, order, 1.0)
        ax.set_title(style.with_unit(words, "m"))
    for key in _TENSIONS:
        _curve(panels[2], numbers, key, x, order, factor)
    panels[2].set_title(style.with_unit("tension", unit))
    for ax in panels:
        ax.set_xlabel(style.with_unit(axis.words, axis_unit))


def _curve(ax: Axes, numbers: Numbers, key: str, x: Array, order: Array, factor: float) -> None:
    for model, look in _MODELS.items():
        if f"{model}_{key}" in numbers:
            ax.plot(x, numbers[f"{model}_{key}"][order] * factor, **look)
    ax.plot(x, numbers[key][order] * factor, **_dots(_COLOURS.get(key, "black")))
    ax.ticklabel_format(useOffset=False)


def _told(numbers: Numbers, run: int) -> str:
    """The numbers of one run as a title, the exact ones in brackets."""
    told = []
    for key, words in {**_PANELS, **_TENSIONS}.items():
        unit = "N" if key in _TENSIONS else "m"
        text = f"{words} {quantity(float(numbers[key][run]), unit)}"
        if f"exact_{key}" in numbers:
            text += f" ({quantity(float(numbers[f'exact_{key}'][run]), unit)})"
        told.append(text)
    return style.wrapped(", ".join(told), style.WIDTH - 0.8)


def _legend(numbers: Numbers, axis: Axis | None) -> list[Line2D]:
    if axis is None and "joint_x" not in numbers:
        return []
    entries = [Line2D([], [], label="computed", **_dots("black"))]
    if axis is not None:
        entries += [Line2D([], [], label=_TENSIONS[key], **_dots(c)) for key, c in _COLOURS.items()]
    for model, marker in (("exact", "o"), ("straight", "x")):
        if f"{model}_sag" in numbers:
            words = "exact, inextensible" if model == "exact" else "straight segments"
            look: dict[str, Any] = {**_MODELS[model]}
            if "joint_x" in numbers:
                look |= {"marker": marker, "markerfacecolor": "none"}
            entries.append(Line2D([], [], label=words, **look))
    return entries
