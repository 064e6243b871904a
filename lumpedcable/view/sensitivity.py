"""A figure of what a result depends on: a bar for each number, the longest on top."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lumpedcable.view import style

Array = NDArray[Any]

MOST_BARS = 24
SEEN = 1e-4  # share of the longest bar below which one would not be seen


def plot_sensitivity(
    heading: str,
    names: Sequence[str],
    shares: Array,
    stem: Path,
    formats: Sequence[str] = ("png",),
    note: str = "",
) -> list[Path]:
    """Draw the bars and return the files made.

    Args:
        heading: title of the figure.
        names: of the numbers, the longest bar first.
        shares: per cent of the result per per cent of the number.
        stem: path of the files without their suffix.
        formats: any of "png", "pdf", "svg".
        note: what is to be known of the bars, in small print.

    Raises:
        OutputError: they cannot be written there, or not in that format.
    """
    style.ready(stem.parent, formats)
    return style.save(partial(sensitivity_figure, heading, names, shares, note), stem, formats)


def sensitivity_bars(heading: str, names: Sequence[str], shares: Array, note: str = "") -> Figure:
    """The bars that `plot_sensitivity` writes."""
    with style.styled():
        return style.literal(sensitivity_figure(heading, names, shares, note))


def sensitivity_figure(heading: str, names: Sequence[str], shares: Array, note: str = "") -> Figure:
    """Horizontal bars, what raises the result to the right."""
    longest = style.largest(shares)
    shown = [k for k in range(len(names)) if abs(shares[k]) > SEEN * longest][:MOST_BARS]
    figure = style.new_figure(1.2 + 0.2 * max(len(shown), 3), heading)
    ax = figure.subplots()
    if not shown:
        style.say_empty(ax)
        return figure
    values = np.array([shares[k] for k in shown])
    colours = [style.COLOURS[0] if v > 0 else style.COLOURS[1] for v in values]
    ax.barh(range(len(shown)), values, color=colours, height=0.7)
    ax.axvline(0.0, color=style.NEUTRAL, linewidth=0.7)
    ax.set_yticks(range(len(shown)), [names[k] for k in shown])
    ax.invert_yaxis()
    ax.grid(False, axis="y")
    room = 0.14 * (max(values.max(), 0.0) - min(values.min(), 0.0))
    ax.set_xlim(min(values.min(), 0.0) - room, max(values.max(), 0.0) + room)
    for k, v in enumerate(values):
        side = 3 if v > 0 else -3
        ax.annotate(f"{v:+.3g}", (v, k), xytext=(side, 0), textcoords="offset points",
                    ha="left" if v > 0 else "right", va="center", fontsize=6.5)  # fmt: skip
    ax.set_xlabel("change of the result over the number's own (% per %)")
    left = len(names) - len(shown) - int(np.sum(~np.isfinite(shares)))
    said = [f"{left} more numbers change it by less, or are zero."] if left else []
    said += [note] if note else []
    style.foot(figure, " ".join(said))
    return figure
