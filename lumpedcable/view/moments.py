"""Figure of the bending moments along lines: the most that each place bears, and what it is at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.lines import LineData
from lumpedcable.results.sound import SoundFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group, foremost
from lumpedcable.view.ranges import most_at, run_entries

__all__ = ["has_moments", "moment_figure"]

Array = NDArray[Any]

_LARGEST: dict[str, Any] = {"color": style.COLOURS[0]}
_START: dict[str, Any] = {"color": style.NEUTRAL, "linestyle": style.DASHES[2]}


def has_moments(line: LineData) -> bool:
    """Whether the file tells of the bending moments of a line."""
    return line.has("bending_moment")


def moment_figure(result: SoundFile, names: list[str], group: Group) -> Figure:
    """Bending moment over the unstretched place, a panel for each line.

    The largest of the saved times at each node, of one run also that at the start; of several a curve
    for each run. Lines beyond as many as there is room for are left out, those that bear the least.
    """
    moving = len(result.field_time) > 1
    curves = {name: [_along(result.line(name), run) for run in group.runs] for name in names}
    peaks = [max(style.largest(most) for _, most, _ in curves[name]) for name in names]
    shown = [names[k] for k in foremost(peaks)]
    every = [np.concatenate([most for _, most, _ in curves[name]]) for name in shown]
    factor, unit = style.shared_unit(every, "N m")
    alone = len(group.runs) == 1
    titles = shown
    if alone:
        firsts = [curves[name][0] for name in shown]
        titles = [most_at(n, m, "N m", p) for n, (p, m, _) in zip(shown, firsts, strict=True)]
    heading = group.heading(result, "Bending moment")
    figure, axes = style.panel_figure(titles, heading)
    for ax, name, values in zip(axes, shown, every, strict=True):
        for index, (place, most, start) in enumerate(curves[name]):
            ax.plot(place, most * factor, **(_LARGEST if alone else style.curve(index)))
            if alone and moving:
                ax.plot(place, start * factor, **_START)
        ax.set_ylim(style.limits(values * factor, zero=True))
        if not np.isfinite(values).any():
            style.say_empty(ax)
    style.label_outer(axes, "unstretched position (m)", style.with_unit("bending moment", unit))
    entries = run_entries(group)
    if alone:
        looks = {"largest": _LARGEST, "at the start": _START} if moving else {}
        entries = [Line2D([], [], label=label, **look) for label, look in looks.items()]
    told = ["Largest bending moment of each node at the saved times."] if moving else []
    if len(shown) < len(names):
        told.append(f"The {len(shown)} of {len(names)} lines that bear the most.")
    style.foot(figure, " ".join([*told, group.note]).strip(), entries)
    return figure


def _along(line: LineData, run: int) -> tuple[Array, Array, Array]:
    """Places (m) of the nodes of a run, their largest moment as far as it went well, and the first."""
    count = line.node_count(run)
    moment = line.field("bending_moment", run)[:, :count]
    return line.unstretched_position(run)[:count], np.fmax.reduce(moment, axis=0), moment[0]
