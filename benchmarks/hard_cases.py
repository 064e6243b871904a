"""The hard cases: their scene files in configs/hard/, what is measured of each, and the exact answer.

Nothing here comes from the engine but what a results file holds; `hard_exact` has the answers.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks import hard_exact as exact
from lumpedcable.exact import LinearRelease
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.status import Status
from lumpedcable.study.outcome import Outcome
from lumpedcable.study.run import run_study

FOLDER = Path(__file__).parents[1] / "configs" / "hard"
Array = NDArray[np.float64]


class Ran(NamedTuple):
    """A finished run: how it ended, times (s), and fields by "LINE.QUANTITY", time first."""

    outcome: Outcome
    time: Array
    fields: dict[str, Array]

    def during(self, first: float, last: float) -> NDArray[np.bool_]:
        """Which times (s) lie in an interval."""
        return (self.time >= first) & (self.time <= last)

    def top_speed(self) -> float:
        """Largest speed anywhere at any output time until something went wrong (m/s), or NaN."""
        when = self.outcome.status_time
        good = self.time < when if np.isfinite(when) else np.ones(self.time.shape, bool)
        with np.errstate(over="ignore"):  # of a run that has blown up
            speeds = [
                np.linalg.norm(v[good], axis=-1)
                for k, v in self.fields.items()
                if k.endswith(".velocity")
            ]
        return max((float(np.max(v)) for v in speeds if v.size), default=float("nan"))


def run_case(scene: str | Path, *changes: str) -> Ran:
    """Run a case by its name, or any scene file, with some values changed ("KEY=VALUE")."""
    path = scene if isinstance(scene, Path) else FOLDER / f"{scene}.toml"
    study = load_study(path, list(changes))
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "result.h5"
        (outcome,) = run_study(study, target)
        with open_result(target) as found:
            fields = {
                f"{line}.{quantity}": found.line(line).field(quantity)[0]
                for line in found.lines
                for quantity in found.line(line).fields
            }
            return Ran(outcome, found.time, fields)


def mean_speed(ran: Ran, line: str, node: int, first: float, last: float) -> float:
    """Mean speed along the line of one of its ends between two times (m/s, s)."""
    along = ran.fields[f"{line}.velocity"][ran.during(first, last), node, 0]
    return float(abs(along.mean()))


def arrival(ran: Ran, end: str) -> float:
    """When the far end felt the break (s)."""
    return float(ran.outcome.recoils[end]["front_arrival"])


def break_at_once(ran: Ran) -> dict[str, float]:
    return {
        "end speed, m/s": mean_speed(ran, "rope", -1, 10e-3, 50e-3),
        "front arrival, ms": 1e3 * arrival(ran, "rope.end"),
    }


def pile_up(ran: Ran) -> dict[str, float]:
    return {"reversed after, ms": 1e3 * ran.outcome.status_time}


def snap(ran: Ran) -> dict[str, float]:
    tension = ran.fields["rope.tension"]
    middle = tension.shape[1] // 2
    # plateaus, less 5 ms after the exact fronts: 60.4, 85.4 and 110.4 ms
    return {
        "first load at the ends, N": float(tension[ran.during(10e-3, 80e-3), 0].mean()),
        "load in the middle, N": float(tension[ran.during(65e-3, 105e-3), middle].mean()),
        "load at the ends, N": float(tension[ran.during(90e-3, 130e-3), 0].mean()),
        "peak, N": float(tension.max()),
    }


def history_error(ran: Ran, line: str, release: LinearRelease) -> float:
    """Largest error of the end's displacement over its largest value (-)."""
    x = ran.fields[f"{line}.position"][:, -1, 0]
    wanted = release.end_displacement(ran.time)
    return float(np.max(np.abs(x[0] - x - wanted)) / np.max(np.abs(wanted)))


def stiff_and_soft(ran: Ran) -> dict[str, float]:
    return {
        "stiff history, % off": 100.0 * history_error(ran, "stiff", exact.STIFF),
        "soft history, % off": 100.0 * history_error(ran, "soft", exact.SOFT),
    }


def graded(ran: Ran) -> dict[str, float]:
    return {"history, % off": 100.0 * history_error(ran, "rope", exact.GRADED)}


def mid_break(ran: Ran) -> dict[str, float]:
    return {
        "left end, m/s": mean_speed(ran, "rope-1", -1, 8e-3, 40e-3),
        "right end, m/s": mean_speed(ran, "rope-2", 0, 8e-3, 40e-3),
        "left arrival, ms": 1e3 * arrival(ran, "rope-1.end"),
        "right arrival, ms": 1e3 * arrival(ran, "rope-2.start"),
    }


def momentum(ran: Ran, line: str, mass: float, lengths: Array) -> Array:
    """Momentum along x of a line (N s) at each time; `lengths` are its segments' (m)."""
    nodes = 0.5 * (np.append(lengths, 0.0) + np.append(0.0, lengths))
    return ran.fields[f"{line}.velocity"][:, :, 0] @ (mass * nodes)


def ringing(ran: Ran) -> dict[str, float]:
    n = ran.fields["rope.tension"].shape[1]
    after = ran.during(0.27, 0.5)
    return {
        "momentum, N s": float(momentum(ran, "rope", 1.0, np.full(n, 100.0 / n))[after].mean()),
    }


def dead_band(ran: Ran) -> dict[str, float]:
    return {
        "end speed, m/s": mean_speed(ran, "rope", -1, 10e-3, 80e-3),
        "strain behind, %": 100.0 * float(ran.fields["rope.strain"][-1, -1]),
    }


def single_precision(ran: Ran) -> dict[str, float]:
    return {
        "end speed, m/s": mean_speed(ran, "rope", -1, 8e-3, 56e-3),
        "front arrival, ms": 1e3 * arrival(ran, "rope.end"),
    }


def light_in_current(ran: Ran) -> dict[str, float]:
    place, tension = (ran.fields[f"rope.{key}"] for key in ("position", "tension"))
    last = place[-1, -1] - place[-1, 0]
    # the tension grows evenly along the line; a segment's is that of its middle
    anchor = 1.5 * tension[:, 0] - 0.5 * tension[:, 1]
    return {
        "held, anchor, N": float(anchor[0]),
        "free, angle, deg": float(np.degrees(np.arctan2(last[2], last[0]))),
        "free, anchor, N": float(anchor[ran.time > ran.time[-1] - 10.0].mean()),
    }


def stiff_bending(ran: Ran) -> dict[str, float]:
    tip = ran.fields["rod.position"][:, -1, 2]
    wanted = exact.rod_tip(ran.time)
    return {
        "tip at rest, mm": 1e3 * float(tip[0]),
        "tip history, % off": 100.0 * float(np.max(np.abs(tip - wanted)) / np.max(np.abs(wanted))),
    }


@dataclass(frozen=True)
class Case:
    """A hard case: its file, its lines with their number of segments, and what is expected of it."""

    name: str
    title: str
    lines: tuple[str, ...]
    segments: int
    measure: Callable[[Ran], dict[str, float]]
    exact: Callable[[], dict[str, float]]
    status: Status = Status.OK

    def sized(self, segments: int) -> tuple[str, ...]:
        """The changes that give every line a number of segments."""
        return tuple(f"lines.{line}.segments={segments}" for line in self.lines)


def none_off(*names: str) -> Callable[[], dict[str, float]]:
    """Errors, whose exact value is zero."""
    return lambda: dict.fromkeys(names, 0.0)


CASES: Sequence[Case] = (
    Case("break-at-once", "Break in no time, 450 kN", ("rope",), 200, break_at_once,
         exact.break_at_once),
    Case("pile-up", "Pile-up at the wall", ("rope",), 200, pile_up, exact.pile_up,
         Status.LINE_REVERSED),
    Case("snap", "Slack line snaps taut", ("rope",), 100, snap, exact.snap),
    Case("stiff-and-soft", "EA 1 GN beside 10 kN", ("stiff", "soft"), 40, stiff_and_soft,
         none_off("stiff history, % off", "soft history, % off")),
    Case("graded", "Segments a hundred to one", ("rope",), 200, graded, none_off("history, % off")),
    Case("mid-break", "Break in the middle", ("rope",), 160, mid_break, exact.mid_break),
    Case("ringing", "Break while ringing", ("rope",), 100, ringing, exact.ringing),
    Case("dead-band", "Law with a dead band", ("rope",), 200, dead_band, exact.dead_band),
    Case("single-precision", "float32, 1600 segments", ("rope",), 1600, single_precision,
         exact.single_precision),
    Case("light-in-current", "Light line, 5 m/s current", ("rope",), 50, light_in_current,
         exact.light_in_current),
    Case("stiff-bending", "Stiff rod, no tension", ("rod",), 40, stiff_bending, exact.stiff_bending),
)  # fmt: skip
