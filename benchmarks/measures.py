"""How far a history is from the reference: one number per quantity, all relative but for the front's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.problem import Array


class Histories(NamedTuple):
    """What happens at the ends of the line: times (s), then one value per time.

    Wall tension (N) and velocity of the broken end (m/s, negative towards the wall). Times are
    equal steps from 0. `displacement` is that of the end at the last time (m), and `front` the time
    at which the wall has lost half its tension (s).
    """

    time: Array
    tension: Array
    velocity: Array
    displacement: float
    front: float

    def at(self, every: float) -> Histories:
        """The same each `every` (s), linear between what is known."""
        count = round(self.time[-1] / every)
        t = np.arange(count + 1) * every
        tension, velocity = (np.interp(t, self.time, v) for v in (self.tension, self.velocity))
        return self._replace(time=t, tension=tension, velocity=velocity)


class Errors(NamedTuple):
    """Errors against a reference.

    displacement: of the broken end at the last time, relative. velocity: of the end's history at
    1 ms samples, relative L2. tension: of the wall's at 1 ms samples, relative L2. tension_fine: the
    same at 0.1 ms samples (T_c). front: of the time at which the wall has lost half its tension
    (s), positive if late; NaN if it never does.
    """

    displacement: float
    velocity: float
    tension: float
    tension_fine: float
    front: float


COARSE, FINE = 1e-3, 1e-4  # s


def relative(values: Array, truth: Array) -> float:
    """Relative L2 distance of two histories."""
    return float(np.linalg.norm(values - truth) / np.linalg.norm(truth))


def front_time(time: Array, tension: Array) -> float:
    """When the tension (N) has fallen half way from its first value to its least (s), linear between."""
    level = 0.5 * (tension[0] + tension.min())
    below = np.flatnonzero(tension < level)
    if not below.size or below[0] == 0:
        return float("nan")
    i = int(below[0])
    share = (tension[i - 1] - level) / (tension[i - 1] - tension[i])
    return float(time[i - 1] + share * (time[i] - time[i - 1]))


def errors(found: Histories, truth: Histories, fine: Histories | None = None) -> Errors:
    """Errors of `found`; of T_c and the front from `fine`, sampled more often, if it is given."""
    fine = found if fine is None else fine
    a, b = found.at(COARSE), truth.at(COARSE)
    c, d = fine.at(FINE), truth.at(FINE)
    return Errors(
        abs(a.displacement / b.displacement - 1.0),
        relative(a.velocity, b.velocity),
        relative(a.tension, b.tension),
        relative(c.tension, d.tension),
        fine.front - truth.front,
    )


ERROR_HEADS = "end displacement, % | end velocity, % | tension, % | T_c, % | front, ms"
MISSING = "-"  # what was not measured, or has no history


def short(value: float) -> str:
    """Two digits, or all before the point."""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.2g}"


def error_cells(found: Sequence[Mapping[str, float] | None]) -> list[str]:
    """A cell of a table for each kind of error, under `ERROR_HEADS`; in each all cases, by " / "."""

    def cell(errors: Mapping[str, float] | None, key: str) -> str:
        if errors is None or not np.isfinite(errors[key]):
            return MISSING
        return f"{1e3 * errors[key]:+.3f}" if key == "front" else short(100.0 * errors[key])

    return [" / ".join(cell(errors, key) for errors in found) for key in Errors._fields]
