"""Figures of a fit: data against model, what is left, correlations, laws with their bands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from lumpedcable.results.human import scale
from lumpedcable.view import style

Array = NDArray[Any]

MOST_PANELS = 12
NEAREST = 1e-12  # distance of two points of a profile over the largest, below which they are one
SHOWN_NUMBERS = 12  # parameters up to which a correlation is written into its square


class Compared(NamedTuple):
    """A measured series, the model's answer and its noise (None where not given), in SI.

    `time` (s) is that of a bench's points over strain, which are then in its order; else None.
    """

    title: str
    x_name: str
    x_unit: str
    x: Array
    unit: str
    measured: Array
    model: Array
    noise: float | None
    time: Array | None = None

    def over_time(self) -> Compared:
        """The same over time, where it has one."""
        if self.time is None:
            return self
        return self._replace(x_name="time", x_unit="s", x=self.time, time=None)


class Law(NamedTuple):
    """A tension law (N over strain) at the start and found, half its band, and measured points."""

    title: str
    strain: Array
    start: Array
    found: Array
    half: Array
    data: Sequence[tuple[str, Array, Array]]


class Profile(NamedTuple):
    """Signed roots of the rise of the sum of squares over a number (SI), its best value and std.

    `low` and `high` are where the root passes `reach`.
    """

    title: str
    unit: str
    x: Array
    root: Array
    best: float
    std: float
    reach: float
    low: float
    high: float


class Drawn(NamedTuple):
    """Draws (draws,) of a number (SI) with their interval, its best value and its std by the fit."""

    title: str
    unit: str
    values: Array
    best: float
    std: float
    low: float
    high: float


class FitPictures(NamedTuple):
    """All that is drawn of a fit."""

    heading: str
    series: Sequence[Compared]
    names: Sequence[str]
    correlation: Array
    laws: Sequence[Law]
    profiles: Sequence[Profile]
    draws: Sequence[Drawn]
    confidence: float


def pictures_from(numbers: Mapping[str, Any]) -> FitPictures:
    """The pictures of a fit from plain numbers by name."""
    return FitPictures(
        **{
            **numbers,
            "series": [Compared(**one) for one in numbers["series"]],
            "laws": [Law(**one) for one in numbers["laws"]],
            "draws": [Drawn(**one) for one in numbers["draws"]],
            "profiles": [Profile(**one) for one in numbers["profiles"]],
        }
    )


def plot_fit(pictures: FitPictures, folder: Path, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Draw the figures of a fit and return the files made.

    Raises:
        OutputError: they cannot be written there, or not in that format.
    """
    made: list[Path] = []
    style.ready(folder, formats)
    for name, draw in _figures(pictures):
        made += style.save(draw, folder / name, formats)
    return made


def fit_figures(pictures: FitPictures) -> dict[str, Figure]:
    """The figures of a fit by the names that `plot_fit` gives their files."""
    with style.styled():
        return {name: style.literal(draw()) for name, draw in _figures(pictures)}


def _figures(pictures: FitPictures) -> list[tuple[str, Callable[[], Figure]]]:
    """Names and makers of the figures that there is something to draw in."""
    all_ = [
        ("data", data_figure, True),
        ("history", history_figure, any(s.time is not None for s in pictures.series)),
        ("residuals", residual_figure, True),
        ("correlations", correlation_figure, len(pictures.names) > 1),
        ("laws", law_figure, bool(pictures.laws)),
        ("profiles", profile_figure, any(map(_drawable, pictures.profiles))),
        ("sample", sample_figure, bool(pictures.draws)),
    ]
    return [(name, partial(draw, pictures)) for name, draw, wanted in all_ if wanted]


def data_figure(pictures: FitPictures) -> Figure:
    """A panel a series: what was measured and what the model says, loops in the order of time."""
    return _compared(pictures.series, f"Data and model: {pictures.heading}")


def history_figure(pictures: FitPictures) -> Figure:
    """A panel for each bench that tells the times of its rows: the same over time."""
    timed = [s.over_time() for s in pictures.series if s.time is not None]
    return _compared(timed, f"Data and model over time: {pictures.heading}")


def _compared(series: Sequence[Compared], heading: str) -> Figure:
    shown = series[:MOST_PANELS]
    figure, axes = style.panel_figure([s.title for s in shown], heading)
    for ax, s in zip(axes, shown, strict=True):
        fx, ux = scale(style.largest(s.x), s.x_unit)
        fy, uy = scale(style.largest(s.measured), s.unit)
        order = np.argsort(s.x, kind="stable") if s.time is None else np.arange(s.x.size)
        ax.plot(fx * s.x, fy * s.measured, ".", color=style.COLOURS[0], markersize=2.5)
        ax.plot(fx * s.x[order], fy * s.model[order], color=style.COLOURS[1])
        ax.set_xlabel(style.with_unit(s.x_name, ux))
        ax.set_ylabel(style.with_unit(s.title.split(": ")[-1].split(" at ")[0], uy))
    handles = [
        Line2D([], [], marker=".", linestyle="", color=style.COLOURS[0], label="measured"),
        Line2D([], [], color=style.COLOURS[1], label="model with the values found"),
    ]
    style.foot(figure, _left_out(series), handles)
    return figure


def residual_figure(pictures: FitPictures) -> Figure:
    """A panel a series: measured less model, with the noise where it is known; loops over time."""
    shown = [s.over_time() for s in pictures.series[:MOST_PANELS]]
    figure, axes = style.panel_figure(
        [s.title for s in shown], f"Measured less model: {pictures.heading}"
    )
    for ax, s in zip(axes, shown, strict=True):
        left = s.measured - s.model
        fx, ux = scale(style.largest(s.x), s.x_unit)
        fy, uy = scale(style.largest(left), s.unit)
        if s.noise is not None:
            ax.axhspan(-2 * fy * s.noise, 2 * fy * s.noise, color="#DDE8F0", linewidth=0)
        ax.axhline(0.0, color=style.NEUTRAL, linewidth=0.7)
        ax.plot(fx * s.x, fy * left, ".", color=style.COLOURS[0], markersize=2.5)
        ax.set_xlabel(style.with_unit(s.x_name, ux))
        ax.set_ylabel(style.with_unit("difference", uy))
    handles = [Line2D([], [], marker=".", linestyle="", color=style.COLOURS[0], label="difference")]
    if any(s.noise is not None for s in shown):
        handles.append(Patch(color="#DDE8F0", label="2 standard deviations of the noise"))  # type: ignore[arg-type]
    style.foot(figure, _left_out(pictures.series), handles)
    return figure


def _left_out(series: Sequence[Compared]) -> str:
    count = len(series)
    return f"The first {MOST_PANELS} of {count} series." if count > MOST_PANELS else ""


def correlation_figure(pictures: FitPictures) -> Figure:
    """The correlation of every pair of parameters."""
    count = len(pictures.names)
    figure = style.new_figure(min(1.6 + 0.42 * count, 9.0), f"Correlations: {pictures.heading}")
    ax = figure.subplots()
    drawn = ax.imshow(pictures.correlation, cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
    ax.grid(False)
    ax.set_xticks(range(count), pictures.names, rotation=30, ha="right", rotation_mode="anchor")
    ax.set_yticks(range(count), pictures.names)
    if count <= SHOWN_NUMBERS:
        for k in range(count):
            for j in range(count):
                value = pictures.correlation[k, j]
                colour = "white" if abs(value) > 0.6 else "black"
                ax.text(j, k, f"{value:.3f}", ha="center", va="center", color=colour, fontsize=7)
    figure.colorbar(drawn, ax=ax, label="correlation (-)")
    return figure


def law_figure(pictures: FitPictures) -> Figure:
    """A panel a law: at the start, found, its band, and what a bench measured."""
    laws = pictures.laws[:MOST_PANELS]
    figure, axes = style.panel_figure(
        [law.title for law in laws], f"Tension laws: {pictures.heading}", height=2.6
    )
    sizes = [x for law in laws for x in (law.found, *(tension for *_, tension in law.data))]
    factor, unit = style.shared_unit(sizes, "N")
    for ax, law in zip(axes, laws, strict=True):
        good = np.isfinite(law.half)
        low, high = factor * (law.found - law.half), factor * (law.found + law.half)
        ax.fill_between(law.strain, low, high, where=good, color="#F3CDB4", linewidth=0)
        ax.plot(law.strain, factor * law.start, color=style.NEUTRAL, linestyle=style.DASHES[1])
        ax.plot(law.strain, factor * law.found, color=style.COLOURS[1])
        for _, strain, tension in law.data:
            ax.plot(strain, factor * tension, ".", color=style.COLOURS[0], markersize=3)
        # a law of which the data show nothing but its zero has axes as well
        drawn = [law.found, law.start, *(tension for _, _, tension in law.data)]
        top = factor * max(map(style.largest, drawn)) or 1.0
        ax.set_ylim(-0.15 * top, 1.15 * top)
    style.label_outer(axes, "strain (-)", style.with_unit("tension", unit))
    handles = [
        Line2D([], [], color=style.COLOURS[1], label="found"),
        Patch(color="#F3CDB4", label=f"{100 * pictures.confidence:g} % band"),
        Line2D([], [], color=style.NEUTRAL, linestyle=style.DASHES[1], label="at the start"),
    ]
    if any(law.data for law in laws):
        handles.append(
            Line2D([], [], marker=".", linestyle="", color=style.COLOURS[0], label="bench")
        )
    style.foot(figure, "", handles)  # type: ignore[arg-type]
    return figure


def _drawn(profile: Profile) -> Profile:
    """A profile with the points that are finite and far enough apart to be drawn as several."""
    good = np.isfinite(profile.x) & np.isfinite(profile.root)
    x, root = profile.x[good], profile.root[good]
    numbers = np.finfo(float)
    # below the last of these slopes overflow
    least = max(NEAREST * style.largest(x), float(numbers.tiny / numbers.eps))
    apart = np.diff(x, prepend=-np.inf) > least
    return profile._replace(x=x[apart], root=root[apart])


def _drawable(profile: Profile) -> bool:
    """Whether there is more than the best value itself, from which runs may fail either way."""
    return len(_drawn(profile).x) > 1


def profile_figure(pictures: FitPictures) -> Figure:
    """A panel a number: the rise of the sum of squares as it is held elsewhere, with its interval."""
    shown = list(map(_drawn, filter(_drawable, pictures.profiles)))[:MOST_PANELS]
    figure, axes = style.panel_figure(
        [p.title for p in shown], f"Profiles: {pictures.heading}", height=2.4
    )
    for ax, p in zip(axes, shown, strict=True):
        factor, unit = scale(style.largest(p.x), p.unit)
        left, right = (factor * float(x) for x in (p.x[0], p.x[-1]))
        inside = [factor * p.low, factor * p.high]
        low, high = (
            x if np.isfinite(x) else end for x, end in zip(inside, (left, right), strict=True)
        )
        ax.axvspan(low, high, color="#F3CDB4", linewidth=0)
        ax.axhline(p.reach**2, color=style.NEUTRAL, linewidth=0.7)
        if np.isfinite(p.std) and p.std > 0.0 and p.x[0] < p.best < p.x[-1]:
            x = np.linspace(left, right, 201)
            rise = ((x / factor - p.best) / p.std) ** 2
            ax.plot(x, rise, color=style.NEUTRAL, linestyle=style.DASHES[1])
        x = np.linspace(p.x[0], p.x[-1], 201)
        ax.plot(factor * x, PchipInterpolator(p.x, p.root)(x) ** 2, color=style.COLOURS[1])
        ax.plot(factor * p.x, p.root**2, ".", color=style.COLOURS[1], markersize=4)
        ax.set_ylim(0.0, 1.15 * max(p.reach**2, float(np.max(p.root**2))))
        ax.set_xlabel(style.with_unit(p.title, unit))
        ax.set_ylabel("rise of the sum of squares\nover the noise squared (-)")
    handles = [
        Line2D([], [], marker=".", color=style.COLOURS[1], label="best fit with the number held"),
        Line2D(
            [],
            [],
            color=style.NEUTRAL,
            linestyle=style.DASHES[1],
            label="linear about the best fit",
        ),
        Patch(color="#F3CDB4", label=f"{100 * pictures.confidence:g} % interval"),
    ]
    style.foot(figure, "", handles)  # type: ignore[arg-type]
    return figure


def sample_figure(pictures: FitPictures) -> Figure:
    """A panel a number: the density of what was drawn, and the normal one of the fit."""
    shown = pictures.draws[:MOST_PANELS]
    figure, axes = style.panel_figure([d.title for d in shown], f"Sampled: {pictures.heading}")
    for ax, d in zip(axes, shown, strict=True):
        factor, unit = scale(style.largest(d.values), d.unit)
        ax.axvspan(factor * d.low, factor * d.high, color="#F3CDB4", linewidth=0)
        ax.hist(factor * d.values, bins=40, density=True, color=style.COLOURS[0])
        if np.isfinite(d.std) and d.std > 0.0:
            x = np.linspace(np.min(d.values), np.max(d.values), 201)
            normal = np.exp(-0.5 * ((x - d.best) / d.std) ** 2) / (
                factor * d.std * np.sqrt(2 * np.pi)
            )
            ax.plot(factor * x, normal, color=style.COLOURS[1])
        ax.set_yticks([])
        ax.set_xlabel(style.with_unit(d.title, unit))
    handles = [
        Patch(color=style.COLOURS[0], label="density of the draws"),
        Line2D([], [], color=style.COLOURS[1], label="normal, by the fit's std"),
        Patch(color="#F3CDB4", label=f"{100 * pictures.confidence:g} % of the draws"),
    ]
    style.foot(figure, "", handles)  # type: ignore[arg-type]
    return figure


class RopeNumbers(NamedTuple):
    """One number of every rope (SI), with its interval."""

    title: str
    unit: str
    values: Array
    low: Array
    high: Array


def plot_ropes(
    heading: str, ropes: Sequence[str], numbers: Sequence[Mapping[str, Any]], confidence: float,
    folder: Path, formats: Sequence[str] = ("png",),
) -> list[Path]:  # fmt: skip
    """Draw the numbers of many ropes beside each other and return the files made.

    Raises:
        OutputError: they cannot be written there, or not in that format.
    """
    style.ready(folder, formats)
    all_ = [RopeNumbers(**one) for one in numbers]
    draw = partial(ropes_figure, heading, ropes, all_, confidence)
    return style.save(draw, folder / "ropes", formats)


def ropes_figure(
    heading: str, ropes: Sequence[str], numbers: Sequence[RopeNumbers], confidence: float
) -> Figure:
    """A panel a number: its value for every rope, with its interval."""
    shown = numbers[:MOST_PANELS]
    figure, axes = style.panel_figure([n.title for n in shown], f"Ropes: {heading}", height=2.2)
    place = np.arange(len(ropes))
    for ax, n in zip(axes, shown, strict=True):
        factor, unit = scale(style.largest(n.values), n.unit)
        good = np.isfinite(n.low) & np.isfinite(n.high)
        ax.vlines(place[good], factor * n.low[good], factor * n.high[good], color="#F3CDB4", lw=3)
        ax.plot(place, factor * n.values, ".", color=style.COLOURS[1])
        ax.set_ylabel(style.with_unit(n.title, unit))
        every = -(-len(ropes) // SHOWN_NUMBERS)
        ax.set_xticks(place[::every], list(ropes[::every]), rotation=45, ha="right")
        ax.set_xlim(-0.6, len(ropes) - 0.4)
    handles = [
        Line2D([], [], marker=".", linestyle="", color=style.COLOURS[1], label="found"),
        Patch(color="#F3CDB4", label=f"{100 * confidence:g} % interval"),
    ]
    style.foot(figure, "", handles)  # type: ignore[arg-type]
    return figure
