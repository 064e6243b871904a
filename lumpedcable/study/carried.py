"""What a results file holds of bodies on lines, winches, drums and measures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import winch_name
from lumpedcable.model.needs import TOLERANCE
from lumpedcable.results import Variable
from lumpedcable.scene import Scene
from lumpedcable.scene.carried import CarriedBody, post_of, reel_key
from lumpedcable.scene.measures import (
    ElevationMeasure,
    Measure,
    MotionMeasure,
    PositionMeasure,
)
from lumpedcable.scene.outcomes import STATISTICS
from lumpedcable.scene.units import format_quantity
from lumpedcable.solve.observe import Sample

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = [
    "carried_bodies",
    "carried_histories",
    "carried_variables",
    "measure_names",
    "measure_outcomes",
    "missed_extremes",
    "never_counted",
    "rider_fields",
    "winch_lines",
]


ROUGH = 0.1  # share of an extreme by which it may stand out from its neighbours and be resolved


def carried_bodies(scene: Scene) -> list[str]:
    """Names of the bodies that run on lines."""
    return [name for name, body in scene.bodies.items() if isinstance(body, CarriedBody)]


def winch_lines(scene: Scene) -> list[str]:
    """Names of the lines with nodes that a winch or a drum pays out."""
    return [
        name
        for name, line in scene.lines.items()
        if line.model == "lumped" and any(post_of(e) is not None for e in (line.start, line.end))
    ]


def carried_variables(scene: Scene, histories: bool) -> list[Variable]:
    """The datasets of measures, winches and drums."""
    found = []
    for name, part in scene.measures.items():
        unit, text, best = part.UNIT, part.words, "least" if part.LEAST else "largest"
        if part.after is not None:
            text += f", from {format_quantity(part.after, 's')} on"
        attributes = {} if part.limit is None else {"limit": part.limit}
        found.append(
            Variable(
                f"summary/{name}",
                ("run",),
                "f8",
                unit,
                f"{best} {text}",
                {"extreme": best} | attributes,
            )
        )
        for word in statistics_of(scene):
            long = {"mean": "mean", "deviation": "standard deviation"}[word]
            path = f"summary/{name}_{word}"
            found.append(Variable(path, ("run",), "f8", unit, f"{long} of the {text}"))
        if histories:
            path = f"measures/{name}"
            found.append(Variable(path, ("run", "time"), "f8", unit, text, attributes))
    for name in winch_lines(scene) if histories else ():
        line = scene.lines[name]
        reel = reel_key(line.start) or reel_key(line.end)
        path, text = f"lines/{name}/payout", f"unstretched length that the {reel} has paid out"
        found.append(Variable(path, ("run", "time"), "f8", "m", text))
        path, text = f"lines/{name}/payout_speed", f"speed at which the {reel} pays out"
        found.append(Variable(path, ("run", "time"), "f8", "m/s", text))
    return found


def carried_histories(scene: Scene, samples: Sample) -> dict[str, NDArray[np.float64]]:
    """Measures, and length (m) and speed (m/s) of payout, (runs, times), by dataset."""
    found = {}
    for name in winch_lines(scene):
        q, v = np.moveaxis(np.asarray(samples.bodies[winch_name(name)], float), 2, 0)
        found[f"lines/{name}/payout"], found[f"lines/{name}/payout_speed"] = q[..., 0], v[..., 0]
    for name, values in samples.measures.items():
        found[f"measures/{name}"] = np.asarray(values, float)
    return found


def statistics_of(scene: Scene) -> tuple[str, ...]:
    """What the summary has of each measure besides its extreme."""
    return STATISTICS if scene.output.statistics else ()


def measure_names(scene: Scene) -> list[str]:
    """The names under which the summary has measures."""
    found = []
    for name in scene.measures:
        found += [name, *(f"{name}_{word}" for word in statistics_of(scene))]
    return found


def measure_outcomes(
    scene: Scene, name: str, history: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """What histories (runs, times) of a measure come down to, by name; NaN where it never counted."""
    least, counts = scene.measures[name].LEAST, np.isfinite(history)
    kept = np.where(counts, history, np.inf if least else -np.inf)
    best = kept.min(axis=1) if least else kept.max(axis=1)
    found = {name: np.where(np.isfinite(best), best, np.nan)}
    if not scene.output.statistics:
        return found
    number = counts.sum(axis=1)
    share = np.where(number > 0, 1.0 / np.maximum(number, 1), np.nan)
    mean = np.where(counts, history, 0.0).sum(axis=1) * share
    off = np.where(counts, history - mean[:, None], 0.0)
    both = zip(STATISTICS, (mean, np.sqrt((off**2).sum(axis=1) * share)), strict=True)
    return found | {f"{name}_{word}": values for word, values in both}


def missed_extremes(
    scene: Scene, histories: dict[str, NDArray[np.float64]], runs: int
) -> list[str]:
    """Of each run which extremes with a limit may lie between two of the times (runs, times), in words.

    An extreme beside which the next value before or after differs by more than a tenth of it, of what
    may be on either side of 0 by more than a tenth of the range that it goes through: what is resolved
    changes less from one output time to the next.
    """
    found: list[list[str]] = [[] for _ in range(runs)]
    for name, history in histories.items():
        part, last = scene.measures[name], history.shape[1] - 1
        if part.limit is None:
            continue
        least = -1.0 if part.LEAST else 1.0
        at = np.where(np.isfinite(history), least * history, -np.inf).argmax(axis=1)[:, None]
        own, *beside = (
            np.take_along_axis(history, np.clip(at + way, 0, last), axis=1) for way in (0, -1, 1)
        )
        whole = np.abs(own)
        if _has_sign(part):  # how large it is tells nothing
            low, high = (np.where(np.isfinite(history), history, s * np.inf) for s in (1, -1))
            whole = high.max(axis=1, keepdims=True) - low.min(axis=1, keepdims=True)
        # not as near as that also where one is NaN, beside what alone counts
        rough = [~(np.abs(other - own) <= ROUGH * whole) for other in beside]
        inside = (at > 0) & (at < last)
        for run in np.flatnonzero(inside & (rough[0] | rough[1])):
            found[run].append(name)
    words = "the extreme of {} may lie between output times: lower output.every"
    return [words.format(", ".join(names)) if names else "" for names in found]


def never_counted(scene: Scene, histories: dict[str, NDArray[np.float64]], runs: int) -> list[str]:
    """Of each run which measures with a limit have no value at any time (runs, times), in words."""
    found: list[list[str]] = [[] for _ in range(runs)]
    for name, history in histories.items():
        if scene.measures[name].limit is not None:
            for run in np.flatnonzero(~np.isfinite(history).any(axis=1)):
                found[run].append(name)
    words = "{} never counted, so that nothing tells whether its limit is kept"
    return [words.format(", ".join(names)) if names else "" for names in found]


def _has_sign(part: Measure) -> bool:
    """Whether a measure may be on either side of 0: places, waves, and components of a motion."""
    return isinstance(part, PositionMeasure | ElevationMeasure) or (
        isinstance(part, MotionMeasure) and part.component is not None
    )


def rider_fields(coordinates: Coordinates, q, v) -> dict[str, NDArray[np.float64]]:
    """Places of trolleys (m), roll, pitch and yaw of what hangs under them (rad), and their rates.

    What hangs swings and does not twist: it rolls and pitches to where its hanger points.
    """
    d = coordinates.dimensions
    swing, rate = q[..., d:], v[..., d:]
    attitude, turning = np.zeros((2, *q.shape[:-1], 3))
    if swing.shape[-1] == 1 and np.count_nonzero(np.abs(coordinates.normal) > TOLERANCE) > 1:
        attitude, turning = _swung_askew(coordinates.axes[:, 0], swing[..., 0], rate[..., 0])
    elif swing.shape[-1] == 1:
        # a swing towards the first axis turns from it towards the vertical one
        attitude, turning = -swing * coordinates.normal, -rate * coordinates.normal
    elif swing.shape[-1] == 2:
        for turned, values in ((attitude, swing), (turning, rate)):
            turned[..., 0], turned[..., 1] = values[..., 1], -values[..., 0]
    return {
        "position": coordinates.expand(q[..., :d], 2, place=True),
        "velocity": coordinates.expand(v[..., :d], 2),
        "attitude": attitude,
        "turning": turning,
    }


def _swung_askew(
    ahead: NDArray[np.float64], swing: NDArray[np.float64], rate: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Roll, pitch and yaw (.., 3) in rad, and their rates, of a swing in an upright plane `ahead`.

    The hanger n = (sin a x, sin a y, -cos a) has n = (-sin p cos r, sin r, -cos p cos r) of its roll r
    and pitch p.
    """
    (x, y, _), s, c = ahead, np.sin(swing), np.cos(swing)
    level = np.sqrt(c**2 + (s * x) ** 2)
    attitude, turning = np.zeros((2, *swing.shape, 3))
    attitude[..., 0], turning[..., 0] = np.arctan2(s * y, level), c * y * rate / level
    attitude[..., 1], turning[..., 1] = -np.arctan2(s * x, c), -x * rate / level**2
    return attitude, turning
