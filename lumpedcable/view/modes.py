"""A figure of natural modes: each drawn over the shape at equilibrium, in a panel of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lumpedcable.view import style

Array = NDArray[Any]

MOST_PANELS = 12
TRUE_SHAPE = 6.0  # shapes longer than so many times their height get a stretched scale
ACROSS_FROM = 0.9  # share of a mode's motion along the lines from which it is drawn across them
_AXES = "xyz"
_REST = {"color": style.NEUTRAL, "linestyle": style.DASHES[2], "linewidth": 0.8}
_MODE = {"color": style.COLOURS[0], "linestyle": "-", "linewidth": 1.3}
_OPPOSITE = {"color": style.COLOURS[5], "linestyle": "-", "linewidth": 0.8}


class ModeShapes(NamedTuple):
    """What is drawn: lines at rest and modes.

    nodes: places at rest by line, (nodes, 3) in m. shapes: displacements by line,
    (modes, nodes, 3), of any size. titles: a text for each mode. outlines and moves: the same of
    rigid bodies, along a way over their edges.
    """

    nodes: Mapping[str, Array]
    shapes: Mapping[str, Array]
    titles: Sequence[str]
    outlines: Mapping[str, Array] = MappingProxyType({})
    moves: Mapping[str, Array] = MappingProxyType({})


class _Panel(NamedTuple):
    """How one mode is drawn: components across and up, size, and true or stretched scales."""

    plane: tuple[int, int]
    size: float
    true: bool
    across: bool


def plot_modes(
    modes: ModeShapes, heading: str, stem: Path, formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Draw the shapes of the first modes and return the files made.

    Args:
        modes: shapes and titles.
        heading: title of the figure.
        stem: path of the files without their suffix; its folder is made if it does not exist.
        formats: any of "png", "pdf", "svg".

    Raises:
        OutputError: they cannot be written there, or not in that format.
    """
    style.ready(stem.parent, formats)
    return style.save(partial(mode_figure, modes, heading), stem, formats)


def mode_figure(modes: ModeShapes, heading: str) -> Figure:
    """A panel for each of the first modes, seen from where it moves the most."""
    count = min(len(modes.titles), MOST_PANELS)
    panels = [_panel(modes, mode) for mode in range(count)]
    titles = [
        f"{title}{', along the line' if panel.across else ''}"
        for title, panel in zip(modes.titles[:count], panels, strict=True)
    ]
    figure, axes = style.panel_figure(titles, heading, height=1.75)
    for mode, (ax, panel) in enumerate(zip(axes, panels, strict=True)):
        _draw(ax, modes, mode, panel)
    if len({panel.plane for panel in panels}) == 1:
        style.label_outer(axes, *(f"{_AXES[c]} (m)" for c in panels[0].plane))
    else:
        for ax, panel in zip(axes, panels, strict=True):
            ax.set_xlabel(f"{_AXES[panel.plane[0]]} (m)")
            ax.set_ylabel(f"{_AXES[panel.plane[1]]} (m)")
    notes = ["The size of a mode is arbitrary."]
    if any(panel.across for panel in panels):
        notes.append("Motion along a line is drawn across it.")
    if not all(panel.true for panel in panels):
        where = " in some panels" if any(panel.true for panel in panels) else ""
        notes.append(f"The two scales differ{where}.")
    if count < len(modes.titles):
        notes.append(f"The first {count} of {len(modes.titles)} modes.")
    words = ("at equilibrium", "mode", "half a period later")
    handles = [
        Line2D([], [], label=label, **look)
        for label, look in zip(words, (_REST, _MODE, _OPPOSITE), strict=True)
    ]
    style.foot(figure, " ".join(notes), handles)
    return figure


def _panel(modes: ModeShapes, mode: int) -> _Panel:
    rest = np.concatenate([*modes.nodes.values(), *modes.outlines.values()])
    drawn = [*modes.shapes.values(), *modes.moves.values()]
    motion = np.concatenate([shape[mode] for shape in drawn])
    extent = np.ptp(rest, axis=0)
    longest = int(np.argmax(extent))
    others = [c for c in (2, 0, 1) if c != longest]
    moving = np.sum(motion**2, axis=0)
    along, whole = 0.0, float(np.sum(moving))
    for name, nodes in modes.nodes.items():
        along += float(np.sum(_along(nodes, modes.shapes[name][mode]) ** 2))
    across = along > ACROSS_FROM * whole
    # the plane of the shape, or that of the motion where the shape has no second extent there
    wide = max(others, key=lambda c: extent[c])
    busy = max(others, key=lambda c: moving[c])
    if moving[busy] > max(moving[wide], 1e-6 * whole):
        wide = busy
    elif extent[wide] <= 1e-9 * extent[longest]:
        wide = busy if moving[busy] > 1e-6 * whole else others[0]
    plane = (min(longest, wide), max(longest, wide))
    long, short = float(extent[longest]), float(extent[wide])
    true = short * TRUE_SHAPE >= long
    stretched = 0.4 * short if short > 0.003 * long else 0.05 * long
    size = 0.07 * long if true else stretched
    top = np.sqrt(np.max(np.sum(motion**2, axis=1)))
    return _Panel(plane, float(size / top) if top > 0.0 else 0.0, true, across)


def _along(nodes: Array, motion: Array) -> Array:
    """The part of a line's motion along itself, (nodes,)."""
    tangent = np.gradient(nodes, axis=0)
    length = np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.sum(motion * tangent / np.where(length > 0.0, length, 1.0), axis=1)


def _draw(ax: Axes, modes: ModeShapes, mode: int, panel: _Panel) -> None:
    plane = list(panel.plane)
    for name, nodes in modes.nodes.items():
        motion = modes.shapes[name][mode]
        moved = motion[:, plane]
        if panel.across:
            tangent = np.gradient(nodes[:, plane], axis=0)
            length = np.linalg.norm(tangent, axis=1, keepdims=True)
            tangent = tangent / np.where(length > 0.0, length, 1.0)
            normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
            moved = _along(nodes, motion)[:, None] * normal
        rest = nodes[:, plane]
        for sign, look in ((-1.0, _OPPOSITE), (1.0, _MODE)):
            drawn = rest + sign * panel.size * moved
            ax.plot(drawn[:, 0], drawn[:, 1], **look)
        ax.plot(rest[:, 0], rest[:, 1], **_REST)
    for name, points in modes.outlines.items():
        moved = panel.size * modes.moves[name][mode][:, plane]
        for sign, look in ((-1.0, _OPPOSITE), (1.0, _MODE), (0.0, _REST)):
            ax.plot(*(points[:, plane] + sign * moved).T, **look)
    if panel.true:
        ax.set_aspect("equal", adjustable="datalim")
    ax.locator_params(nbins=5)
