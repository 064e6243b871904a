"""Picks what to draw of a result: times at a round spacing, node places, motion along the line."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.errors import ResultError
from lumpedcable.results.lines import LineData
from lumpedcable.results.reader import ResultFile
from lumpedcable.results.schema import END_SPEED, exact_name

Array = NDArray[Any]

EXACT_SPEED = exact_name(END_SPEED)
_USUAL = 0.010  # s; the spacing of curves in published snap-back figures
_MOST_CURVES = 31
_ROUNDING = 1e-6  # share of the spacing


def curve_times(time: Array) -> tuple[Array, float]:
    """Indices of saved times at a round spacing: 10 ms, or coarser or finer by 1-2-5 steps.

    Args:
        time: saved times in s, shape (time,), increasing.

    Returns:
        Indices of the saved times nearest to the multiples of the spacing after the first time, and
        the spacing in s. Where times were saved more coarsely than that, all of them; where it is no
        multiple of theirs, every so many of them, and their spacing.
    """
    span = float(time[-1] - time[0])
    if span <= 0:
        return np.arange(len(time)), 0.0
    spacing = _USUAL
    if not 8 <= span / spacing < _MOST_CURVES:
        rough = span / 20
        power = 10.0 ** np.floor(np.log10(rough))
        spacing = float(power * min((1, 2, 5, 10), key=lambda m: abs(np.log(m * power / rough))))
    saved = float(np.median(np.diff(time)))
    every = max(1, round(spacing / saved))
    if abs(every * saved - spacing) > _ROUNDING * spacing:
        return np.arange(0, len(time), every), every * saved
    wanted = time[0] + spacing * np.arange(int(span / spacing + 1e-9) + 1)
    picked = np.unique(np.abs(time[None, :] - wanted[:, None]).argmin(axis=1))
    if len(picked) < len(wanted):
        return np.arange(len(time)), saved
    return picked, spacing


def along(line: LineData, run: int) -> tuple[Array, Array]:
    """Velocity along the line as it lay at first, and the nodes' unstretched places.

    The direction is that of the line at each node at the first saved time (for a straight line, its
    direction), positive from the start of the line to its end.

    Returns:
        Unstretched places in m, shape (node,), and velocities in m/s, shape (time, node).
    """
    nodes = line.node_count(run)
    first = line.position(run, 0)[:nodes]
    secant = np.empty_like(first)
    secant[1:-1] = first[2:] - first[:-2]
    secant[0], secant[-1] = first[1] - first[0], first[-1] - first[-2]
    length = np.linalg.norm(secant, axis=-1, keepdims=True)
    direction = np.divide(secant, length, out=np.zeros_like(secant), where=length > 0)
    velocity = line.velocity(run)[:, :nodes]
    return line.unstretched_position(run)[:nodes], np.sum(velocity * direction, axis=-1)


def side_view(shapes: list[Array]) -> tuple[int, int]:
    """Components to draw across and up: the longer horizontal one; z, or y where z is nothing."""
    points = np.concatenate([shape.reshape(-1, 3) for shape in shapes])
    extents = [extent(points[:, component]) for component in range(3)]
    across = 0 if extents[0] >= extents[1] else 1
    flat = extents[2] <= 1e-9 * max(extents) and extents[1 - across] > 0
    return (0, 1) if flat else (across, 2)


def extent(values: Array) -> float:
    """Largest less smallest finite value, 0 if there is none."""
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if finite.size else 0.0


class RecoilingEnd:
    """An end of a line that breaks, found from its name in the summary.

    Attributes:
        name: e.g. "rope.end".
        line: the fields of its line.
        at_end: whether it is the line's end, not its start.
    """

    def __init__(self, result: ResultFile, name: str) -> None:
        owner, _, side = name.rpartition(".")
        if owner not in result.lines or side not in ("start", "end"):
            known = ", ".join(result.lines)
            raise ResultError(
                f"{result.path}: the summary tells of {name!r}, expected LINE.start or LINE.end"
                f" of one of the lines {known}"
            )
        self.name = name
        self.line: LineData = result.line(owner)
        self.at_end: bool = side == "end"
        self._result = result
        self._numbers = result.summary()[name]

    def places(self, run: int) -> tuple[float, float]:
        """Unstretched places (m) of the broken end and of the other end."""
        node = self.line.unstretched_position(run)
        low, high = float(np.nanmin(node)), float(np.nanmax(node))
        return (high, low) if self.at_end else (low, high)

    def start(self, run: int) -> float | None:
        """When the break begins, in s: 0 where the file does not say, None where it never does."""
        return self._number("break_start", run) if "break_start" in self._numbers else 0.0

    @property
    def has_speed(self) -> bool:
        """Whether the file tells of its speed: of that itself, or of the line's."""
        return self.line.has(self._own) or self.line.has("velocity")

    @property
    def _own(self) -> str:
        return f"{'end' if self.at_end else 'start'}_velocity"

    @property
    def has_place(self) -> bool:
        """Whether the file tells where it is."""
        return self.line.has(self._place)

    def displacement(self, run: int) -> Array:
        """Distance of the broken end from where it was when its break began in m, shape (time,).

        NaN where it did not break before the run ended.
        """
        place = self.line.field(self._place, run)
        known, begin = np.isfinite(place).all(axis=-1), self.start(run)
        time = self._result.time[known]
        if begin is None or not known.any() or begin > time[-1]:
            return np.full(len(place), np.nan)  # it did not break, or nobody knows where
        from_there = np.array([np.interp(begin, time, along) for along in place[known].T])
        return np.linalg.norm(place - from_there, axis=-1)

    @property
    def _place(self) -> str:
        return f"{'end' if self.at_end else 'start'}_position"

    def speed(self, run: int) -> Array:
        """Speed of the broken end in m/s, shape (time,)."""
        if self.line.has(self._own):
            return np.linalg.norm(self.line.field(self._own, run), axis=-1)
        node = self.line.node_count(run) - 1 if self.at_end else 0
        return np.linalg.norm(self.line.velocity(run)[:, node], axis=-1)

    def recoil(self, run: int) -> tuple[Array, Array]:
        """Like `along`, but positive away from the break, into the line."""
        place, velocity = along(self.line, run)
        return place, -velocity if self.at_end else velocity

    def exact_speed(self, run: int) -> float | None:
        """The exact end speed in m/s, None where the file holds none."""
        return self._number(EXACT_SPEED, run)

    def arrivals(self, run: int) -> list[tuple[str, bool, float]]:
        """When fronts reach the other end: (label, exact or else reported, s after the break).

        Taken from `exact_front_arrival`, any other `exact_..._arrival` and the references' values
        of the same, where the file holds them.
        """
        found = []
        for name in self._numbers:
            exact, reference = name.startswith("exact_"), name.startswith("reference_")
            value = self._number(name, run)
            if not name.endswith("_arrival") or value is None or not (exact or reference):
                continue
            known = self._result.summary_attributes(self.name, name)
            if exact:
                what = name.removeprefix("exact_").removesuffix("_arrival").replace("_", " ")
                why = f" ({known['holds']})" if "holds" in known else ""
                found.append((f"exact {what}{why}", True, value))
            else:
                source = known.get("source") or name.removeprefix("reference_").split("_")[0]
                told = self._result.attributes.get("overrides")
                changed = " for the scene without --set" if told else ""
                found.append((f"front arrival in {source}{changed}", False, value))
        return found

    def holds(self) -> str:
        """For which idealisation the exact end speed holds, "" where the file does not say."""
        if EXACT_SPEED not in self._numbers:
            return ""
        return str(self._result.summary_attributes(self.name, EXACT_SPEED).get("holds", ""))

    def _number(self, name: str, run: int) -> float | None:
        values = self._numbers.get(name)
        if values is None or not np.isfinite(values[run]):
            return None
        return float(values[run])
