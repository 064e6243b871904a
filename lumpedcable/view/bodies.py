"""Figures of bodies, winches and drums: how far they have come and how fast they are, against time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import ResultFile
from lumpedcable.view import style
from lumpedcable.view.groups import Group

__all__ = ["body_figure", "has_payout", "payout_figure"]

Array = NDArray[Any]


def body_figure(result: ResultFile, name: str, group: Group) -> Figure:
    """Distance of a body from its start and its speed against time, a curve for each run."""

    def both(run: int) -> tuple[Array, Array]:
        place = result.body(name, "position", run)
        far = np.linalg.norm(place - place[0], axis=-1)
        return far, np.linalg.norm(result.body(name, "velocity", run), axis=-1)

    size = _scene_size(result, group.runs)
    return _side_by_side(
        result, name, group, both, ("distance from the start", "speed"), size, True
    )


def has_payout(line: LineData) -> bool:
    """Whether the file tells what a winch or drum pays out of a line."""
    return line.has("payout") and line.has("payout_speed")


def payout_figure(result: ResultFile, name: str, group: Group) -> Figure:
    """What a winch or drum has paid out of a line, and how fast it does, against time."""
    line = result.line(name)

    def both(run: int) -> tuple[Array, Array]:
        return line.field("payout", run), line.field("payout_speed", run)

    size = _scene_size(result, group.runs)
    heading = f"payout of {name}"
    words = "unstretched length paid out", "speed of payout"
    return _side_by_side(result, heading, group, both, words, size, False)


def _side_by_side(
    result: ResultFile,
    heading: str,
    group: Group,
    both: Callable[[int], tuple[Array, Array]],
    words: tuple[str, str],
    size: float,
    zero: bool,
) -> Figure:
    """A length (m) and a speed (m/s) of each run against time, in a scene so large (m).

    `zero` asks for the zero on the axis of lengths; that of speeds has it.
    """
    clock = group.clock(result, result.time)
    figure, axes = style.panel_figure(["", ""], group.heading(result, heading), height=3.0)
    drawn: tuple[list[Array], list[Array]] = ([], [])
    entries = []
    for index, (run, title) in enumerate(zip(group.runs, group.titles, strict=True)):
        look = style.curve(index)
        for ax, values, kept in zip(axes, both(run), drawn, strict=True):
            ax.plot(clock.shown, values, **look)
            kept.append(values)
        entries.append(Line2D([], [], label=title.replace("\n", ", ") or heading, **look))
    named = zip(words, ("m", "m/s"), (size, size / (float(result.time[-1]) or 1.0)), strict=True)
    for ax, kept, (text, unit, whole), from_zero in zip(
        axes, drawn, named, (zero, True), strict=True
    ):
        values = np.concatenate(kept)
        if np.isfinite(values).any():
            ax.set_ylim(style.limits(values, zero=from_zero, scene=whole))
        else:
            style.say_empty(ax)
        ax.set_ylabel(style.with_unit(text, unit))
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
