"""Figures of bodies: how far they have come and how fast they are, against time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lumpedcable.results.human import scale
from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group

__all__ = ["body_figure"]


def body_figure(result: ResultFile, name: str, group: Group) -> Figure:
    """Distance of a body from its start and its speed against time, a curve for each run."""
    to_time, time_unit = scale(float(result.time[-1]), "s")
    figure, axes = style.panel_figure(["", ""], group.heading(result, name), height=3.0)
    drawn: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    entries = []
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        look = style.curve(index)
        place = result.body(name, "position", run)
        far = np.linalg.norm(place - place[0], axis=-1)
        fast = np.linalg.norm(result.body(name, "velocity", run), axis=-1)
        for ax, values, kept in zip(axes, (far, fast), drawn, strict=True):
            ax.plot(result.time * to_time, values, **look)
            kept.append(values)
        entries.append(Line2D([], [], label=title.replace("\n", ", ") or name, **look))
    words = (("distance from the start", "m"), ("speed", "m/s"))
    for ax, kept, named in zip(axes, drawn, words, strict=True):
        values = np.concatenate(kept)
        if np.isfinite(values).any():
            ax.set_ylim(style.limits(values, zero=True))
        else:
            style.say_empty(ax)
        ax.set_ylabel(style.with_unit(*named))
        ax.set_xlabel(style.with_unit("time", time_unit))
        ax.set_xlim(style.limits(result.time * to_time, margin=0.02))
    style.foot(figure, group.note, entries if len(entries) > 1 else [])
    return figure
