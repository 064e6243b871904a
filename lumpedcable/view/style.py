"""How every figure looks: print size, colour-blind-safe colours, units on all axes.

Colours of single curves are those of Okabe and Ito, less the yellow that vanishes on white paper,
each also with a dash pattern of its own, so that a black-and-white copy can be read.
"""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple, cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter
from numpy.typing import NDArray

from lumpedcable.results.disk import reported
from lumpedcable.results.errors import OutputError
from lumpedcable.results.human import scale
from lumpedcable.results.target import whole

Array = NDArray[Any]

WIDTH = 7.2
"""Width of a figure in inches: two columns of a journal page."""

FORMATS = ("pdf", "png", "svg")
"""File formats a figure can be saved in."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (2, 1)), (0, (6, 1.2, 1.5, 1.2)))
NEUTRAL = "#555555"
ROUNDING = 1e-6
"""Share of the size of a scene below which differences are not shown as such."""

_RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so looks alike everywhere
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "grid.color": "#E2E2E2",
    "grid.linewidth": 0.5,
    "figure.facecolor": "white",
    "figure.titlesize": 9,
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "lines.linewidth": 1.1,
    "savefig.dpi": 200,
    "savefig.facecolor": "white",
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
}


def styled() -> AbstractContextManager[None]:
    """A context in which figures take the style of this package."""
    return matplotlib.rc_context(cast(Any, _RC))


def time_colours() -> Colormap:
    """Viridis without its last, lightest part, for curves on white paper."""
    whole = matplotlib.colormaps["viridis"]
    return LinearSegmentedColormap.from_list("time", whole(np.linspace(0, 0.9, 256)))


def curve(index: int) -> dict[str, Any]:
    """Colour and dashes of the n-th curve of an axes; repeats only after 28."""
    dashes = DASHES[(index // len(COLOURS) + index % len(COLOURS)) % len(DASHES)]
    return {"color": COLOURS[index % len(COLOURS)], "linestyle": dashes}


def grid_shape(panels: int) -> tuple[int, int]:
    """Rows and columns for so many panels: 2 x 2 for four, at most three side by side."""
    columns = 1 if panels == 1 else 2 if panels in (2, 4) else 3
    return -(-panels // columns), columns


def panel_figure(
    titles: Sequence[str], heading: str, *, height: float = 2.1
) -> tuple[Figure, list[Axes]]:
    """A figure with one panel per title, and a heading above.

    Args:
        titles: the panels' titles; longer ones are wrapped.
        heading: title of the figure.
        height: height of one row of panels in inches.

    Returns:
        The figure and its axes in the order of the titles.
    """
    rows, columns = grid_shape(len(titles))
    height = max(height, 3.2) if rows == columns == 1 else height
    figure = new_figure(height * rows + 0.5, heading)
    made = figure.subplots(rows, columns, squeeze=False).ravel()
    for spare in made[len(titles) :]:
        spare.remove()
    axes = list(made[: len(titles)])
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(panel_title(title, columns))
    return figure, axes


def panel_title(title: str, columns: int) -> str:
    """A panel's title broken into lines that fit it, with room left for a colour bar."""
    return wrapped(title, (WIDTH - 1.0) / columns)


def new_figure(height: float, heading: str) -> Figure:
    """An empty figure of the usual width in a layout that leaves room for all text."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    if heading:
        figure.suptitle(wrapped(heading, WIDTH, 9))
    return figure


def literal(figure: Figure) -> Figure:
    """The figure with words as they are: a dollar in a title or a name opens no formula.

    Numbers at the axes are formulas of Matplotlib's own, 10 with an exponent, and stay so.
    """
    every = (axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis))
    counted = [axis for axis in every if not isinstance(axis.get_major_formatter(), FixedFormatter)]
    numbers = {
        id(text) for axis in counted for text in axis.findobj(Text) if text is not axis.label
    }
    for text in figure.findobj(Text):
        if isinstance(text, Text) and id(text) not in numbers:
            text.set_parse_math(False)
    return figure


def foot(figure: Figure, note: str = "", handles: Sequence[Line2D] = ()) -> None:
    """A legend below the panels, in as many columns as fit, and small print above it.

    The figure grows by the height of what is added.
    """
    note = wrapped(note.strip(), WIDTH, 6.5)
    rows = note.count("\n") + 1 if note else 0
    if handles:
        labels = [str(handle.get_label()).split("\n") for handle in handles]
        longest = max(len(line) for label in labels for line in label)
        columns = min(max(int(WIDTH / (0.55 * 7 / 72 * longest + 0.6)), 1), len(handles), 4)
        rows += -(-len(handles) // columns) * max(len(label) for label in labels)
        made = figure.legend(
            handles=list(handles),
            loc="outside lower center",
            ncols=columns,
            title=note or None,
            title_fontsize=6.5,
        )
        made.get_title().set_color(NEUTRAL)
    elif note:
        figure.supxlabel(note, fontsize=6.5, color=NEUTRAL)
    figure.set_figheight(figure.get_figheight() + 0.15 * rows)


def wrapped(text: str, inches: float, size: float = 8) -> str:
    """Text broken into lines that fit a width at a font size in points, after stops if it can."""
    letters = int(0.92 * inches / (0.58 * size / 72))
    parts = re.split(r"(?<=[,.:]) |(?=\n)", text)
    glued = " ".join(part.replace(" ", "\xa0") if len(part) <= letters else part for part in parts)
    lines = [textwrap.fill(line, letters, break_long_words=False) for line in glued.split("\n")]
    return "\n".join(lines).replace("\xa0", " ")


def label_outer(axes: Sequence[Axes], x: str, y: str) -> None:
    """Axis labels on the left and bottom panels only; ticks stay on all."""
    _, columns = grid_shape(len(axes))
    for place, ax in enumerate(axes):
        if place + columns >= len(axes):
            ax.set_xlabel(x)
        if place % columns == 0:
            ax.set_ylabel(y)


def with_unit(words: str, unit: str) -> str:
    """An axis label, e.g. "tension (kN)"."""
    return f"{words} ({unit or '-'})".replace("\n ", "\n")


class Clock(NamedTuple):
    """How a figure tells time: `factor` from s to the unit of `label`, and all output times in it.

    `last` is the number of the last of them that its axes reach to.
    """

    factor: float
    shown: Array
    label: str
    last: int

    @property
    def limits(self) -> tuple[float, float]:
        """Of an axis of time."""
        return limits(self.shown[: self.last + 1], margin=0.02)


def clock(time: Array, until: float | None = None) -> Clock:
    """How a figure tells output times (s), up to `until` (s) or the first after it; None: all."""
    last = len(time) - 1
    if until is not None:
        last = min(last, max(int(np.searchsorted(time, until)), 1))
    factor, unit = scale(float(time[last]), "s")
    return Clock(factor, time * factor, with_unit("time", unit), last)


def shared_unit(panels: Sequence[Array], unit: str) -> tuple[float, str]:
    """The factor and the unit that suit all panels of a figure: those of the middle magnitude.

    Args:
        panels: what each panel shows, in `unit`.
        unit: an SI unit.

    Returns:
        (factor, text): value * factor is in units of text.
    """
    tops = np.array([largest(values) for values in panels])
    tops = tops[tops > 0]
    return scale(float(np.exp(np.log(tops).mean())) if tops.size else 0.0, unit)


def largest(values: Array) -> float:
    """The largest finite magnitude in an array, 0 if there is none."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def limits(
    values: Array, *, zero: bool = False, margin: float = 0.04, scene: float = 0.0
) -> tuple[float, float]:
    """Axis limits that hold all finite values with a margin, and zero if asked for.

    What varies by less than a millionth of its size, or of the size of the `scene` that it belongs to,
    is rounding: it is drawn as a constant, with a margin of that size.
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    size = max(abs(low), abs(high), scene)
    varies = high - low > ROUNDING * size
    room = margin * (high - low if varies else size or 1.0)
    return low - room, high + room


def family(ax: Axes, x: Array, curves: Array, keys: Array, colours: Normalize) -> None:
    """Many curves over one abscissa, coloured by a key such as time.

    Args:
        ax: where to draw.
        x: abscissa, shape (points,).
        curves: one row per curve, shape (curves, points); rows without data are left out.
        keys: what colours each curve, shape (curves,).
        colours: range of the keys.
    """
    good = np.isfinite(curves).any(axis=1)
    lines = [np.column_stack([x, row]) for row in curves[good]]
    drawn = LineCollection(lines, cmap=time_colours(), norm=colours, linewidths=0.9)
    drawn.set_array(keys[good])
    ax.add_collection(drawn, autolim=False)


def say_empty(ax: Axes) -> None:
    """Write into a panel that there is nothing to draw."""
    ax.text(0.5, 0.5, "no data", transform=ax.transAxes, ha="center", va="center", color=NEUTRAL)


def ready(folder: Path, formats: Sequence[str]) -> None:
    """Make the folder of some figures.

    Raises:
        OutputError: it cannot be made, or there is no such format.
    """
    for kind in formats:
        if kind not in FORMATS:
            known = ", ".join(FORMATS)
            raise OutputError(f"cannot draw in the format {kind!r}, expected one of {known}")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise OutputError(f"expected a folder for the pictures, found the file {folder}") from None
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise OutputError(f"cannot make the folder {folder}: {reason}") from error


def save(draw: Callable[[], Figure], stem: Path, formats: Sequence[str]) -> list[Path]:
    """Draw a figure in the style and save it, once per format, whole or not at all.

    Raises:
        OutputError: it cannot be written there.
    """
    made = []
    with styled():
        figure = literal(draw())
        for kind in formats:
            path = stem.with_name(f"{stem.name}.{kind}")
            with reported(path), whole(path) as partial:
                figure.savefig(partial)
            made.append(path)
    return made
