"""Maps of a study: a number of its runs over every pair of the swept numbers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogFormatter
from numpy.typing import NDArray

from lumpedcable.results.human import scale
from lumpedcable.results.reader import Axis, ResultFile
from lumpedcable.results.sound import NOT_YET, WELL
from lumpedcable.view import style
from lumpedcable.view.groups import ends_note, file_tag

Array = NDArray[Any]

FEWEST = 3  # values that a swept number must have to be drawn along
MOST_CELLS = 40  # of a map along an axis
BINS = 12  # at most, of more values than that, such as draws
MOST_PANELS = 6
PLAIN = (1e-3, 1e4)  # numbers between are not written as powers of ten
ENOUGH = 4 * BINS  # draws
# quantity of a recoiling end or of the run -> which run of a cell is shown
SHOWN = {
    "peak_end_speed": "largest",
    "reach": "largest",
    "front_arrival": "earliest",
    "peak_kinetic_energy": "largest",
    "peak_tension": "largest",
    "utilisation": "largest",
    "stop_time": "largest",
    "stop_distance": "largest",
}


NONE = {
    "stop_time": "did not stop",
    "stop_distance": "did not stop",
    "front_arrival": "saw no front",
}
"""What runs did that went well and have no such number."""


class Along(NamedTuple):
    """One axis of a map: its label, edges of its cells, the cell of each run, whether it is log."""

    label: str
    edges: Array
    cells: Array
    log: bool


def map_figures(result: ResultFile) -> Iterator[tuple[str, Any]]:
    """Names and makers of the maps of a study, where at least two numbers have enough values."""
    axes = [axis for axis in result.axes if len(np.unique(axis.values)) >= FEWEST]
    if len(axes) < 2 or not _fills(axes):
        return
    for end, numbers in result.summary().items():
        shown = SHOWN | result.measured if end == "run" else SHOWN
        for quantity, values in numbers.items():
            if quantity in shown and np.isfinite(values).any():
                whose = "" if end == "run" or len(result.ends) < 2 else f"_{file_tag(end)}"
                draw = partial(map_figure, result, end, quantity, axes, shown[quantity])
                yield f"map_{file_tag(quantity)}{whose}", draw


def _fills(axes: list[Axis]) -> bool:
    """Whether some pair of numbers takes more combinations than either has values."""
    return any(
        len(np.unique(np.column_stack([a.values, b.values]), axis=0))
        >= min(len(np.unique(a.values)) * len(np.unique(b.values)), ENOUGH)
        for a, b in combinations(axes, 2)
    )


def map_figure(result: ResultFile, end: str, quantity: str, axes: list[Axis], which: str) -> Figure:
    """A map for each pair of swept numbers; a cell shows the largest, least or earliest of its runs."""
    told = result.summary_attributes(end, quantity)
    values = result.summary()[end][quantity]
    unit = str(told.get("units", "1"))
    factor, shown = scale(style.largest(values), "" if unit == "1" else unit)
    every = list(combinations(axes, 2))
    pairs = every[:MOST_PANELS]
    title = str(result.attributes.get("title", ""))
    whose = "" if end == "run" else f"{end}: "
    heading = "\n".join(filter(None, [title, f"{whose}{told.get('long_name', quantity)}"]))
    figure, panels = style.panel_figure([""] * len(pairs), heading, height=2.2)
    tables = [_table(_along(a), _along(b), values * factor, which) for a, b in pairs]
    known = np.concatenate([table[np.isfinite(table)] for table in tables])
    colours = Normalize(float(known.min()), float(known.max()))
    well = np.array([end in WELL and end != NOT_YET for end in result.status])
    without = np.where(well & np.isnan(values), 1.0, np.nan)
    hatched = False
    for ax, (a, b), table in zip(panels, pairs, tables, strict=True):
        x, y = _along(a), _along(b)
        _draw(ax, x, y, table, colours)
        lacking = np.isfinite(table) & np.isfinite(_table(x, y, without, "largest"))
        _hatch(ax, x, y, lacking)
        hatched |= bool(lacking.any())
    bar = figure.colorbar(
        ScalarMappable(colours, "viridis"), ax=panels, aspect=30, pad=0.01, fraction=0.05
    )
    words = quantity.replace("_", " ")
    bar.set_label(style.with_unit(words, shown))
    note = f"Each cell: the {which} of the runs in it, over all other swept numbers."
    note += _of_white(result, pairs, tables)
    if hatched:
        count, why = int(np.nansum(without)), NONE.get(quantity, "have no such number")
        note += f" Hatched: with runs that {why} as well, {count} of {result.runs} in all."
    if len(every) > len(pairs):
        note += f" The first {len(pairs)} of {len(every)} pairs."
    ends = ends_note(result, range(result.runs), "what they came to before counts")
    style.foot(figure, f"{note} {ends}".strip())
    return figure


def _of_white(result: ResultFile, pairs: list[tuple[Axis, Axis]], tables: list[Array]) -> str:
    """What white cells say, if there are any: that no run is in them, or none that has the number."""
    everywhere = np.ones(result.runs)
    there = [_table(_along(a), _along(b), everywhere, "largest") for a, b in pairs]
    both = list(zip(tables, there, strict=True))
    reasons = [
        *(["no run"] if any(np.isnan(runs).any() for runs in there) else []),
        *(
            ["none with a number"]
            if any((np.isnan(t) > np.isnan(r)).any() for t, r in both)
            else []
        ),
    ]
    return f" White cells: {' or '.join(reasons)} in them." if reasons else ""


def _along(axis: Axis) -> Along:
    """Cells along a swept number: one for each value, or bins."""
    factor, unit = scale(style.largest(axis.values), axis.unit)
    values = axis.values * factor
    label = style.with_unit(axis.words, unit)
    known = np.unique(values)
    log = bool(
        known[0] > 0 and known[-1] / known[0] > 20 and _uneven(np.log(known)) < _uneven(known)
    )
    place = np.log if log else np.asarray
    if len(known) > MOST_CELLS:
        ends = place(known[[0, -1]])
        bins = min(BINS, int(np.sqrt(len(values) / 2)))  # two draws or more a cell, on average
        edges = np.linspace(ends[0], ends[1], bins + 1)
        cells = np.clip(np.searchsorted(edges, place(values), side="right") - 1, 0, bins - 1)
    else:
        middles = place(known)
        half = np.diff(middles) / 2
        edges = np.concatenate(
            [middles[:1] - half[:1], middles[:-1] + half, middles[-1:] + half[-1:]]
        )
        cells = np.searchsorted(known, values)
    return Along(label, np.exp(edges) if log else edges, cells, log)


def _uneven(places: Array) -> float:
    """How far places in order are from evenly spread ones, as a share of their range."""
    share = (places - places[0]) / (places[-1] - places[0])
    return float(np.max(np.abs(share - np.linspace(0.0, 1.0, len(share)))))


def _table(x: Along, y: Along, values: Array, which: str) -> Array:
    """The chosen value of each cell, shape (y, x), NaN where no run has one."""
    best = np.fmax if which == "largest" else np.fmin
    table = np.full((len(y.edges) - 1, len(x.edges) - 1), np.nan)
    best.at(table, (y.cells, x.cells), values)
    return table


def _draw(ax: Axes, x: Along, y: Along, table: Array, colours: Normalize) -> None:
    ax.grid(False)
    ax.pcolormesh(x.edges, y.edges, table, norm=colours, cmap="viridis", rasterized=True)
    ax.set_xlabel(x.label)
    ax.set_ylabel(y.label)
    for along, set_scale, axis in ((x, ax.set_xscale, ax.xaxis), (y, ax.set_yscale, ax.yaxis)):
        if not along.log:
            continue
        set_scale("log")
        if PLAIN[0] <= along.edges[0] and along.edges[-1] <= PLAIN[1]:
            formatter = _FewFormatter if along is x else _PlainFormatter  # side by side: no room
            axis.set_major_formatter(formatter())
            axis.set_minor_formatter(formatter())


def _hatch(ax: Axes, x: Along, y: Along, cells: NDArray[np.bool_]) -> None:
    look: dict[str, Any] = {"fill": False, "hatch": "////", "edgecolor": "white", "linewidth": 0.0}
    for j, i in np.argwhere(cells):
        left, right, low, high = map(float, (*x.edges[i : i + 2], *y.edges[j : j + 2]))
        ax.add_patch(Rectangle((left, low), right - left, high - low, **look))


class _PlainFormatter(LogFormatter):
    """Numbers as people write them, 0.2 and 50, beside the ticks of a log axis that get any."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The text beside a tick."""
        return f"{x:g}" if super().__call__(x, pos) else ""


class _FewFormatter(_PlainFormatter):
    """Numbers that begin with 1, 2 or 5 alone, where the axis has more than one power of ten."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The text beside a tick."""
        assert self.axis is not None  # nobody asks before it has one
        low, high = self.axis.get_view_interval()
        if high < 10.0 * low:
            return super().__call__(x, pos)
        return f"{x:g}" if f"{x:e}"[0] in "125" else ""
