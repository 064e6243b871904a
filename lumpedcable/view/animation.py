"""A run as a moving picture: the line's shape coloured by tension, and its tension along it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lumpedcable.results.disk import reported
from lumpedcable.results.errors import OutputError, ResultError
from lumpedcable.results.human import scale
from lumpedcable.results.reader import ResultFile
from lumpedcable.results.sound import SoundFile
from lumpedcable.results.target import keep_others, whole
from lumpedcable.view import style
from lumpedcable.view.ground import WATER, draw_ground, make_room
from lumpedcable.view.sampling import extent, side_view

__all__ = ["MOVIES", "animate_result"]

Array = NDArray[Any]
# lines by name, places (time, 3) of balls, faces (time, face, 4, 3) of boxes, in m; height (m) of the
# waves at a time (s) and places (n, 3) in m, None without waves
Water = Callable[[float, Array], Array]
Beside = tuple[Mapping[str, Any], Sequence[Array], Sequence[Array], Water | None]

MOVIES = (".gif", ".mp4")
LONGEST = 3600.0  # s that a film may last
_DPI = 100
SEEN = 300  # places at which waves are drawn
_TRUE_SHAPE = 6.0  # as in the figure of shapes: longer lines get a stretched vertical scale


def animate_result(
    path: str | Path,
    target: str | Path,
    run: int = 0,
    seconds: float = 8.0,
    fps: int = 15,
    beside: Callable[[ResultFile, int], Beside] | None = None,
) -> Path:
    """Write a run as a GIF, or as an MP4 with the extra `video`; one that went wrong until then.

    Args:
        path: the results file, finished or not.
        target: *.gif or *.mp4.
        run: which run, from 0.
        seconds: how long the film lasts; the text beside the clock says how much slower or faster
            than real time that is.
        fps: frames in a second; of a GIF, whose frames last whole hundredths of a second, about so many.
        beside: from the open file and the run to what it does not hold or holds otherwise: lines by
            name, read as its own are; places (m) of bodies without a size; faces (m) of those with one;
            the height (m) of waves at a time (s) and places (m), None without any.

    Returns:
        The file made.

    Raises:
        ResultError: the file cannot be read, has no such run, or holds no positions and tensions.
        OutputError: the film cannot be written there, not in that format, or another file is there.
    """
    target = Path(target)
    if target.suffix not in MOVIES:
        known = " or ".join(MOVIES)
        raise OutputError(f"cannot write {target}: expected a name that ends in {known}")
    if not (0.0 < seconds <= LONGEST and fps > 0):
        raise OutputError(
            f"expected a film of some length, of {LONGEST:g} s at most, found {seconds:g} s at {fps} "
            "frames/s"
        )
    keep_others(target, target.suffix)
    rate = 100.0 / max(2, round(100.0 / fps)) if target.suffix == ".gif" else float(fps)
    frames = max(2, round(seconds * rate))
    with SoundFile.open(path) as result, style.styled():
        result.hold(run)
        more = beside(result, run) if beside is not None else ({}, (), (), None)
        film = _Film(result, run, frames / rate, more)
        with reported(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            with whole(target) as partial:
                _write(film, _writer(target, rate), partial, frames)
    return target


def _writer(target: Path, rate: float) -> AbstractMovieWriter:
    if target.suffix == ".gif":
        # a hundredth that rounding makes a little less is cut off
        return PillowWriter(fps=rate * (1.0 - 1e-9))  # pyright: ignore[reportArgumentType]
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise OutputError(
            f'cannot write {target}: MP4 needs the extra "video": pip install "lumpedcable[video]"; '
            "a *.gif needs none"
        ) from None
    matplotlib.rcParams["animation.ffmpeg_path"] = imageio_ffmpeg.get_ffmpeg_exe()
    # sizes must be even, and players want this pixel format
    filters = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"]
    return FFMpegWriter(fps=round(rate), extra_args=filters)


def _write(film: _Film, writer: AbstractMovieWriter, target: Path, frames: int) -> None:
    times = film.times
    wanted = np.linspace(times[0], times[-1], frames)
    nearest = np.abs(times[None, :] - wanted[:, None]).argmin(axis=1)
    with writer.saving(film.figure, str(target), _DPI):
        for sample in nearest:
            film.show(int(sample))
            writer.grab_frame()


class _Film:
    """The figure, and how to bring it to a saved time."""

    def __init__(self, result: SoundFile, run: int, seconds: float, more: Beside) -> None:
        self.result, self.run = result, run
        self.saved = result.field_time
        self.times = self.saved[result.shown[run]]
        others, self.balls, self.faces, self.water = more
        stored = {name: result.line(name) for name in result.lines}
        shown = {
            name: line
            for name, line in {**stored, **others}.items()
            if all(map(line.has, ("position", "tension")))
        }
        if not shown:
            raise ResultError(f"{result.path} holds no positions with tensions to show")
        names, lines = list(shown), list(shown.values())
        counts = [line.node_count(run) for line in lines]
        self.position = [li.position(run)[:, :n] for li, n in zip(lines, counts, strict=True)]
        self.tension = [
            _from_both(li.tension(run)[:, : n - 1]) for li, n in zip(lines, counts, strict=True)
        ]
        if not any(np.isfinite(place).any() for place in self.position):
            said = result.reason(run)
            raise ResultError(f"{result.path}: run {run} has no positions to show: {said}")
        self.middle = [
            _to_the_ends(li.unstretched_segment(run)[: n - 1], li.unstretched_position(run)[:n])
            for li, n in zip(lines, counts, strict=True)
        ]
        self.across, self.up = side_view(self.position)
        everything = np.concatenate([t.ravel() for t in self.tension])
        self.factor, self.unit = scale(style.largest(everything), "N")
        self.limits = style.limits(everything * self.factor, zero=True)
        self.to_time, self.time_unit = scale(float(result.time[-1]), "s")
        span = float(self.times[-1] - self.times[0])
        self.pace = _pace(span / seconds)
        self.figure, (self.top, self.bottom), wavy = self._laid_out()
        self.sea = self.top.add_collection(_sea(), autolim=False) if wavy else None
        self.solids = [self.top.add_collection(_solid(), autolim=False) for _ in self.faces]
        self.shapes = [self._shape(self.top) for _ in names]
        (self.marks,) = self.top.plot([], [], "o", color=style.NEUTRAL, markersize=5, zorder=3)
        self.curves = [
            self.bottom.plot([], [], **style.curve(k), label=name)[0]
            for k, name in enumerate(names)
        ]
        if len(names) > 1:
            self.bottom.legend(loc="upper right")
        self.show(0)
        style.literal(self.figure).canvas.draw()
        self.figure.set_layout_engine("none")  # nothing moves but the lines

    def _laid_out(self) -> tuple[Figure, Array, bool]:
        title = "\n".join(
            filter(
                None, [str(self.result.attributes.get("title", "")), self.result.label(self.run)]
            )
        )
        figure = style.new_figure(4.6, title)
        top, bottom = axes = figure.subplots(2, 1, height_ratios=[3, 2])
        points = np.concatenate(
            [p.reshape(-1, 3) for p in (*self.position, *self.balls, *self.faces)]
        )
        x, z = points[:, self.across], points[:, self.up]
        wide, high = extent(x), extent(z)
        top.set_xlim(style.limits(x, scene=high))
        top.set_ylim(style.limits(z, margin=0.15, scene=wide))
        draw_ground(top, self.result, self.run, (self.across, self.up))
        # waves halfway between what is nearest and farthest
        self.places = np.tile(
            0.5 * (np.nanmin(points, axis=0) + np.nanmax(points, axis=0)), (SEEN, 1)
        )
        left, right = top.get_xlim()
        self.places[:, self.across] = np.linspace(left, right, SEEN)
        wavy = False
        if self.water is not None and self.up == 2:
            some = self.times[:: max(1, len(self.times) // SEEN)]
            heights = np.array([self.water(float(t), self.places) for t in some])
            wavy = make_room(top, float(heights.min()), float(heights.max()))
        true = wide <= _TRUE_SHAPE * high or high <= style.ROUNDING * wide
        if true:
            top.set_aspect("equal", adjustable="box")
        stretched = "" if true else ", stretched"
        top.set_xlabel(f"{'xyz'[self.across]} (m)")
        top.set_ylabel(f"{'xyz'[self.up]} (m{stretched})")
        paid = any(self.result.line(name).has("payout") for name in self.result.lines)
        start = " at the start" if paid else ""  # a winch makes its line longer, or shorter
        bottom.set_xlabel(f"distance along the line, unstretched{start} (m)")
        bottom.set_ylabel(style.with_unit("tension", self.unit))
        bottom.set_xlim(0.0, max(float(np.nanmax(m)) for m in self.middle) * 1.01)
        bottom.set_ylim(self.limits)
        self.clock = top.text(
            1.0, 1.02, "", transform=top.transAxes, ha="right", va="bottom", color=style.NEUTRAL
        )
        return figure, axes, wavy

    def _shape(self, ax: Axes) -> LineCollection:
        colours = Normalize(*self.limits)
        drawn = LineCollection([], cmap=style.time_colours(), norm=colours, linewidths=2.4)
        ax.add_collection(drawn, autolim=False)
        return drawn

    def show(self, sample: int) -> None:
        """Bring everything to one saved time."""
        view = [self.across, self.up]
        parts = zip(self.shapes, self.curves, self.position, self.tension, self.middle, strict=True)
        for shape, curve, position, tension, middle in parts:
            points = position[sample][:, view]
            shape.set_segments(list(np.stack([points[:-1], points[1:]], axis=1)))
            shape.set_array(tension[sample] * self.factor)
            curve.set_data(middle, tension[sample] * self.factor)
        if self.water is not None and self.sea is not None:
            x, low = self.places[:, self.across], self.top.get_ylim()[0]
            z = self.water(float(self.saved[sample]), self.places)
            self.sea.set_verts([[(x[0], low), *zip(x, z, strict=True), (x[-1], low)]])
        for solid, faces in zip(self.solids, self.faces, strict=True):
            solid.set_verts(list(faces[sample][..., view]))
        self.marks.set_data(*np.reshape([ball[sample][view] for ball in self.balls], (-1, 2)).T)
        now = self.saved[sample] * self.to_time
        last = self.result.time[-1] * self.to_time
        places = max(0, 2 - int(np.floor(np.log10(last)))) if last > 0 else 0
        self.clock.set_text(f"{now:.{places}f} {self.time_unit}, {self.pace}")


def _sea() -> PolyCollection:
    """Water under waves, behind all else."""
    return PolyCollection(
        [], facecolors=[(WATER, 0.25)], edgecolors=WATER, linewidths=1.2, zorder=0.7
    )


def _solid() -> PolyCollection:
    """A body, over the water and behind the lines."""
    return PolyCollection([], facecolors="#F1F1F1", edgecolors=style.NEUTRAL, linewidths=0.6)


def _to_the_ends(middles: Array, places: Array) -> Array:
    """Where tensions are drawn: a segment has one from node to node, the first and last to the ends."""
    drawn = np.array(_from_both(middles))
    drawn[[0, -1]] = places[[0, -1]]
    return drawn


def _from_both(values: Array) -> Array:
    """Values of segments to draw a curve through: of a single one twice, at its either node."""
    return np.repeat(values, 2, axis=-1) if values.shape[-1] == 1 else values


def _pace(rate: float) -> str:
    """How fast the film runs, from simulated seconds in a second of it."""
    if rate <= 0.0 or abs(rate - 1.0) < 0.01:
        return "real time"
    return f"{1 / rate:.3g}× slower" if rate < 1.0 else f"{rate:.3g}× faster"
