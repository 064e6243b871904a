"""The least value of a number of a scene with which its results keep within limits, by derivatives."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumpedcable.fitting.parameters import numbers_of
from lumpedcable.fitting.scalar import Scalar, read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes
from lumpedcable.scene import Study, format_quantity
from lumpedcable.scene.units import UnitError, parse_quantity
from lumpedcable.status import MEANING, Status

__all__ = ["Design", "Limit", "Trial", "least_design", "next_number", "read_limit"]

MOST_TRIALS = 30
CLOSE = 1e-7  # relative change of the number at which the search ends
STRIDE = 2.0  # by which factor a trial may differ from the one before
_LIMIT = re.compile(r"(.+?)\s*(<=|>=)\s*(.+)")


@dataclass(frozen=True)
class Limit:
    """A scalar of a run and the most (`sign` 1) or least (-1) that it may be (SI)."""

    scalar: Scalar
    sign: float
    bound: float

    def excess(self, value: float) -> float:
        """How far a value is beyond the bound (SI), negative within it."""
        return self.sign * (value - self.bound)


@dataclass(frozen=True)
class Trial:
    """A value of the number (SI), what it makes of the limited scalars, and their derivatives by it.

    It is `strained` where a line was stretched beyond max_strain of its material.
    """

    number: float
    values: tuple[float, ...]
    slopes: tuple[float, ...]
    strained: bool = False


@dataclass(frozen=True)
class Design:
    """What the search came to: its trials, the last of which is the answer, and which limit decides."""

    key: str
    unit: str
    limits: tuple[Limit, ...]
    trials: tuple[Trial, ...]
    decides: int

    @property
    def value(self) -> float:
        """The least value of the number that keeps within all limits (SI)."""
        return self.trials[-1].number


def read_limit(text: str, study: Study, run: int = 0) -> Limit:
    """The limit that a text means: "last position at rod.end in x <= 190 m".

    Raises:
        ValueError: it means none; the message says what was expected.
    """
    match = _LIMIT.fullmatch(text.strip())
    if match is None:
        raise ValueError(
            f'expected a limit such as "max tension at chain.start <= 400 kN", found "{text}"'
        )
    words, sense, bound = match.groups()
    scalar = read_scalar(words, study.runs[run])
    try:
        value = parse_quantity(bound, scalar.unit)
    except UnitError as error:
        raise ValueError(f"expected a bound ({scalar.unit}) after {sense}, found {error}") from None
    return Limit(scalar, 1.0 if sense == "<=" else -1.0, value)


def least_design(
    study: Study, key: str, limits: tuple[Limit, ...], run: int = 0, along: tuple[str, ...] = ()
) -> Design:
    """The least value of the number `key` with which a run keeps within all limits.

    Newton's method on the limits: each, taken as the straight line of its derivative, allows the
    numbers on one side of where it meets its bound; the least that all allow is tried next. The
    derivatives are those of the discrete model, through its stop where it has one. A trial is half to
    twice the one before, so that the number keeps its sign. Numbers `along` stay in proportion to
    `key`, an anchor's volume to its mass.

    Args:
        study: scene and sweep, of which one `run` is taken.
        key: path of the number; its value in the scene is the first trial.
        limits: one or more.
        run: which run.
        along: paths of numbers that change with it.

    Raises:
        ValueError: there is no such number, a run fails, no value keeps within all limits, or the
            search does not end.
    """
    if not limits:
        raise ValueError("expected a limit, found none")
    names = tuple(_number(study, k) for k in (key, *along))
    keys = tuple(n.key for n in names)
    start = np.array([study.runs[run].numbers()[k] for k in keys])
    if start[0] == 0.0:
        raise ValueError(f"{key}: expected a number to begin with, found 0")
    trials: list[Trial] = []
    number = float(start[0])
    while len(trials) < MOST_TRIALS:
        trial = _tried(study, limits, keys, start, number, run)
        trials.append(trial)
        after, decides = next_number(trial, limits, trials[:-1])
        if abs(after - number) <= CLOSE * abs(number):
            if trial.strained:
                raise ValueError(_failed(key, number, Status.STRAIN_EXCEEDED))
            return Design(key, names[0].kind.unit, limits, tuple(trials), decides)
        low, high = sorted((number / STRIDE, number * STRIDE))  # below 0 the other way round
        number = float(np.clip(after, low, high))
    last = trials[-1]
    raise ValueError(
        f"{key}: expected an end of the search within {MOST_TRIALS} runs, found none: it went to "
        f"{format_quantity(last.number, names[0].kind.unit)}, where a limit is still not met"
    )


def _number(study: Study, key: str):
    found, wrong = numbers_of(study, key)
    if len(found) != 1:
        told = wrong if isinstance(wrong, str) else getattr(wrong, "message", "")
        raise ValueError(f"{key}: {told or 'expected the path of one number of the scene'}")
    return found[0]


def _tried(study, limits, keys, start, number: float, run: int) -> Trial:
    scale = start / start[0]
    values, slopes, strained = [], [], False
    for limit in limits:
        value, status, slope = scalar_slopes(study, limit.scalar, keys, number * scale, run)
        if status not in (Status.OK, Status.STRAIN_EXCEEDED):  # on the way a law may be carried on
            raise ValueError(_failed(keys[0], number, status))
        values.append(value)
        slopes.append(float(slope @ scale))
        strained |= status is Status.STRAIN_EXCEEDED
    return Trial(number, tuple(values), tuple(slopes), strained)


def _failed(key: str, number: float, status: Status) -> str:
    return f"{key} = {number:g}: {MEANING[status]}"


def next_number(
    trial: Trial, limits: tuple[Limit, ...], before: Sequence[Trial] = ()
) -> tuple[float, int]:
    """The least number that the limits allow as straight lines, and which of them asks for it.

    Where none does, the trials `before` tell why: a limit that asked for more and now asks for less has
    been passed at its best.

    Straight lines that meet their bounds far from the trial and leave no number between them say
    nothing yet of the limits themselves: those contradict each other where at one trial one asks for
    more, or for no less, and another for less.

    Raises:
        ValueError: they allow none, or any however small.
    """
    low, high, decides = -np.inf, np.inf, -1
    for k, limit in enumerate(limits):
        slope = limit.sign * trial.slopes[k]
        excess = limit.excess(trial.values[k])
        if slope == 0.0:
            if excess > 0.0:
                raise ValueError(
                    f"expected a number that {limit.scalar} depends on, found one that it does not"
                )
            continue
        meets = trial.number - excess / slope
        if slope < 0.0 and meets > low:
            low, decides = meets, k
        elif slope > 0.0:
            high = min(high, meets)
    if decides < 0:
        for k, limit in enumerate(limits):
            beyond = [limit.excess(t.values[k]) for t in (*before, trial)]
            more = [limit.sign * t.slopes[k] < 0.0 for t in before]
            if min(beyond) > 0.0 and any(more):
                best = (*before, trial)[int(np.argmin(beyond))]
                raise ValueError(
                    f"expected a bound that some number keeps, found {limit.scalar} beyond it wherever "
                    f"tried, at best {best.values[k]:.6g} at {best.number:.6g} (SI)"
                )
        raise ValueError("expected a limit that keeps the number from falling, found none")
    near = CLOSE * abs(trial.number)
    if low >= trial.number - near and high < trial.number - near:
        raise ValueError(
            f"expected limits that one number can keep, found that {limits[decides].scalar} asks for "
            f"{low:.6g} or more (SI), and another for {high:.6g} or less"
        )
    return float(low), decides
