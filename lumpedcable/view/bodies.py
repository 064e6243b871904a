"""Figures of bodies: how far they have come and how fast they are, against time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group

__all__ = ["body_figure"]


def body_figure(result: ResultFile, name: str, group: Group) -> Figure:
    """Distance of a body from its start and its speed against time, a curve for each run."""
    clock = group.clock(result, result.time)
    figure, axes = style.panel_figure(["", ""], group.heading(result, name), height=3.0)
    drawn: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    entries = []
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        look = style.curve(index)
        place = result.body(name, "position", run)
        far = np.linalg.norm(place - place[0], axis=-1)
        fast = np.linalg.norm(result.body(name, "velocity", run), axis=-1)
        for ax, values, kept in zip(axes, (far, fast), drawn, strict=True):
            ax.plot(clock.shown, values, **look)
            kept.append(values)
        entries.append(Line2D([], [], label=title.replace("\n", ", ") or name, **look))
    words = (("distance from the start", "m"), ("speed", "m/s"))
    size = _scene_size(result, group.runs)
    sizes = (size, size / (float(result.time[-1]) or 1.0))
    for ax, kept, named, whole in zip(axes, drawn, words, sizes, strict=True):
        values = np.concatenate(kept)
        if np.isfinite(values).any():
            ax.set_ylim(style.limits(values, zero=True, scene=whole))
        else:
            style.say_empty(ax)
        ax.set_ylabel(style.with_unit(*named))
        ax.set_xlabel(clock.label)
        ax.set_xlim(clock.limits)
    style.foot(figure, group.note, entries if len(entries) > 1 else [])
    return figure


def _scene_size(result: ResultFile, runs: Sequence[int]) -> float:
    """How large a scene is (m): the longest of its lines, or how far a body is from its origin."""
    lines = [result.line(name) for name in result.lines]
    lines = [line for line in lines if line.has("unstretched_position")]
    sizes = [style.largest(line.unstretched_position(run)) for line in lines for run in runs]
    places = (result.body(name, "position", run) for name in result.bodies for run in runs)
    return max([*sizes, *map(style.largest, places)], default=0.0)
