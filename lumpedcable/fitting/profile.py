"""Profile likelihood: how the best fit worsens as one number is held at other values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from lumpedcable.fitting.bounds import AT_BOUND, way_of
from lumpedcable.fitting.minimise import Found, search
from lumpedcable.fitting.residual import unpacked
from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.transforms import to_unbounded
from lumpedcable.fitting.uncertainty import Profile, reach_of
from lumpedcable.status import Status

__all__ = ["departing", "flagged", "profile_of", "untold", "with_profiles"]

Array = NDArray[np.float64]

PARTS = 4
"""Steps in which the limit is to be reached, on either side."""
MOST, MOST_BACK = 16, 12
"""Most steps on a side: one that has not come to the limit by then is open. And most that are taken
back, since a run failed there or the root rose by too much."""
TOO_MUCH = 2.0
"""Rise of the root, over that of one step, at which a step is taken back."""
NEAREST = 1e-2
"""Step, over the way so far, below which the edge of what runs can do is known well enough."""
LARGE_GAP, MOST_POLISH = 1.25, 3
"""Difference of two roots, over one step, between which the limit is not interpolated but looked for,
and in how many searches at most."""
FARTHEST = 1e3
"""Largest std, over the value or its start, by which a first step is measured; and the farthest place
where data without noise still tell a limit from rounding, of 1e-16 beside `LEAST_NOISE`."""
LEAST_GROWTH, MOST_GROWTH, LEAST_BACK = 0.5, 4.0, 0.1
"""Factors by which a step may change from one to the next, and by how much at most when taken back."""
LEAST_NOISE = 1e-12
"""Noise that data without any are taken to have, over their largest value."""
BETTER = 1e-3
"""Fall of the loss on the way, over the loss or the square of the noise if that is more, that shows
that the fit was not the best: less is rounding, or changes no interval."""
RUGGED = 1.5
"""Width of a profile, over that of the interval by the standard deviation, that is worth a word."""
WIDE = 100.0
"""Width of an interval, over the number or its start, from which the data do not tell the number."""


def with_profiles(fitted: Fitted, indices: Sequence[int] | None = None) -> Fitted:
    """A fit with the profiles of some numbers, or of those that are flagged, as their intervals."""
    chosen = flagged(fitted) if indices is None else indices
    profiles = tuple(profile_of(fitted, k) for k in chosen)
    low, high = np.array(fitted.certainty.low), np.array(fitted.certainty.high)
    for one in profiles:
        low[one.parameter], high[one.parameter] = one.low, one.high
    certainty = fitted.certainty._replace(low=low, high=high)
    return replace(fitted, profiles=profiles, certainty=certainty)


def flagged(fitted: Fitted) -> list[int]:
    """Numbers whose file asks for a profile; else those that the data do not tell, or at a bound."""
    vague = {int(np.argmax(np.abs(c.parts))) for c in fitted.certainty.vague()}
    found = []
    for k, p in enumerate(fitted.problem.parameters):
        asked = (k in vague or fitted.at_bound[k]) if p.profile is None else p.profile
        if asked and not fitted.failures and np.isfinite(fitted.certainty.noise):
            found.append(k)
    return found


def untold(fitted: Fitted) -> set[int]:
    """Numbers that the data do not tell: most of a combination that is not told, or of wide interval.

    That is one that is open, or `WIDE` times as wide as the number or its start is large. Not where no
    noise is known, nor where an interval is open since runs fail.
    """
    certainty = fitted.certainty
    if not np.isfinite(certainty.noise):
        return set()
    failed = {one.parameter for one in fitted.profiles if any(one.failed)}
    found = {int(np.argmax(np.abs(c.parts))) for c in certainty.vague()}
    for k, p in enumerate(fitted.problem.parameters):
        width, size = certainty.high[k] - certainty.low[k], max(abs(fitted.values[k]), abs(p.start))
        wide = not np.isfinite(width) or (size > 0.0 and width > WIDE * size)
        if wide and k not in failed and not fitted.at_bound[k]:
            found.add(k)
    return found


def departing(fitted: Fitted) -> tuple[int, float] | None:
    """The number whose profile is widest beside its standard deviation, and how many times as wide.

    None where none is `RUGGED` times as wide, or where all numbers have profiles. Of those alone that
    the data tell, between bounds and runs that fail.
    """
    sure, method = fitted.certainty, fitted.problem.method
    if len(fitted.profiles) == len(fitted.values):
        return None
    reach = reach_of(fitted.problem.known_noise, method.confidence, sure.free)
    vague, found = untold(fitted), []
    for one in fitted.profiles:
        k = one.parameter
        std = sure.std[k]
        told = 0.0 < std < np.inf and k not in vague and not fitted.at_bound[k]
        share = (one.high - one.low) / (2.0 * reach * std) if told else 0.0
        if RUGGED < share < np.inf:
            found.append((k, float(share)))
    return max(found, key=lambda each: each[1], default=None)


class _Side(NamedTuple):
    """A walk away from the best value: places and roots in order, and how it ended.

    `limit`: where the interval ends on this side. `failed`: runs fail beyond the last place, before
    the root is at its limit. `fell`: a better fit was met. `taken`: evaluations.
    """

    x: Array
    root: Array
    limit: float
    failed: bool
    fell: bool
    taken: int


def profile_of(fitted: Fitted, k: int) -> Profile:
    """The profile of a number.

    S(x) is found by searches with the number held, each from the end of the one before, in steps of
    x that raise the root by about a quarter of its limit (Bates & Watts, Nonlinear Regression
    Analysis, 1988, section 6.1). The limit is the normal quantile of the confidence, or Student's t
    where the noise was found from the fit; where the root passes it is interpolated. At a bound on
    which the number sits already the interval ends. A side on which runs fail before is open.
    """
    method, sure = fitted.problem.method, fitted.certainty
    reach = reach_of(fitted.problem.known_noise, method.confidence, sure.free)
    below, above = (
        _side(fitted, k, side, max(sure.noise, LEAST_NOISE), reach) for side in (-1.0, 1.0)
    )
    best = float(fitted.values[k])
    return Profile(
        k, np.concatenate([below.x[::-1], [best], above.x]),
        np.concatenate([-below.root[::-1], [0.0], above.root]), reach, below.limit, above.limit,
        below.fell or above.fell, below.taken + above.taken, (below.failed, above.failed),
    )  # fmt: skip


def _side(fitted: Fitted, k: int, side: float, s: float, reach: float) -> _Side:
    """The walk to one side, and where exactly the root passes its limit."""
    p, best = fitted.problem.parameters[k], float(fitted.values[k])
    edge = p.low if side < 0.0 else p.high
    if fitted.at_bound[k] and abs(edge - best) <= AT_BOUND * way_of(p):
        return _Side(np.zeros(0), np.zeros(0), edge, False, False, 0)
    met, z, ended, failed, fell, count = _walk(fitted, k, side, s, reach)
    limit = _limit(best, met, reach)
    for _ in range(MOST_POLISH):
        if not np.isfinite(limit) or _gap(met, reach) < LARGE_GAP * reach / PARTS:
            break
        found, root, better = _held(fitted, k, limit, z, s)
        count, fell = count + int(found.steps), fell or better
        if not np.isfinite(root):
            break
        met[limit] = root
        limit = _limit(best, met, reach)
    far = abs(limit - best) > FARTHEST * max(abs(best), abs(p.start))
    if s <= LEAST_NOISE and np.isfinite(limit) and far:
        limit = edge  # which rounding has come before
    failed = failed and not np.isfinite(limit)
    if not np.isfinite(limit):
        limit = edge if ended else side * float(np.inf)
    places = sorted(met, key=lambda place: abs(place - best))
    roots = np.array([met[place] for place in places])
    return _Side(np.array(places), roots, limit, failed, fell, count)


def _walk(fitted: Fitted, k: int, side: float, s: float, reach: float):
    """Roots by place, the last z, whether a bound or a failed run ended it, `fell` and `count`."""
    p, z, best = fitted.problem.parameters[k], fitted.sought.best.z, float(fitted.values[k])
    edge, part = p.low if side < 0.0 else p.high, reach / PARTS
    x, last, step, wall, back = best, 0.0, part * _measure(fitted, k), np.inf, 0
    met: dict[float, float] = {}
    ended, failed, fell, count = False, False, False, 0
    for _ in range(MOST + MOST_BACK):
        ended = bool(np.isfinite(edge) and abs(edge - x) <= step * (1.0 + 1e-9))
        place = x + side * step
        if ended:  # a bound itself is infinitely far away for the search
            place = edge - side * 1e-6 * max(abs(edge - x), 1e-12 * max(abs(x), abs(p.start)))
        found, root, better = _held(fitted, k, place, z, s)
        count, fell = count + int(found.steps), fell or better
        if not np.isfinite(root):
            wall, back, ended = abs(place - x), back + 1, False
            step, failed = 0.5 * wall, back >= MOST_BACK or 0.5 * wall < NEAREST * abs(x - best)
            if failed:
                break
            continue
        met[place] = root
        if root - last > TOO_MUCH * part and back < MOST_BACK:
            # the limit is interpolated between places that lie near each other
            back, ended = back + 1, False
            step = abs(place - x) * float(np.clip(part / (root - last), LEAST_BACK, 0.5))
            continue
        if root >= reach or ended or len(met) >= MOST:
            break
        wall -= abs(place - x)
        grown = part / max(root - last, 1e-9)
        step = min(step * float(np.clip(grown, LEAST_GROWTH, MOST_GROWTH)), 0.5 * wall)
        x, last, z = place, root, found.z
        failed = 0.5 * wall < NEAREST * abs(x - best)
        if failed:
            break
    return met, z, ended, failed, fell, count


def _measure(fitted: Fitted, k: int) -> float:
    """What the first step is a part of: the std, where it is one, or the number's size."""
    p, best, std = fitted.problem.parameters[k], float(fitted.values[k]), fitted.certainty.std[k]
    size = max(abs(best), way_of(p)) if fitted.at_bound[k] else abs(best) or abs(p.start) or 1.0
    return float(std if 0.0 < std < FARTHEST * max(size, abs(p.start)) else size)


def _gap(met: Mapping[float, float], reach: float) -> float:
    """How far apart the roots are between which the limit is interpolated; less if one is nearly it."""
    roots = [0.0, *met.values()]
    over = min(root for root in roots if root >= reach)
    under = max(root for root in roots if root < reach)
    return min(over - under, 10.0 * (over - reach), 10.0 * (reach - under))


def _held(
    fitted: Fitted, k: int, x: float, z: Array, s: float
) -> tuple[Found, float, bool]:  # fmt: skip
    """The best fit with one number held at x, its root (nan if a run fails), and if it is better."""
    method, arrays = fitted.problem.method, fitted.sought.arrays
    values = np.array(fitted.values)
    values[k] = x
    held = np.arange(values.size) == k
    at = np.where(held, to_unbounded(arrays.transform, values), 0.0)
    arrays = arrays._replace(held=held, at=at)
    begin = np.where(held, at, z)
    found = search(
        fitted.spec, arrays, begin, method.solver, method.tolerance, method.max_steps
    )  # fmt: skip
    found = jax.tree.map(np.asarray, found)
    status = unpacked(arrays, found.flat).status
    loss = float(np.sum(found.residual**2))
    if not np.isfinite(loss) or any(bool(np.any(one != Status.OK)) for one in status):
        return found, float(np.nan), False
    root = float(np.sqrt(max(loss - fitted.loss, 0.0))) / s
    return found, root, fitted.loss - loss > BETTER * max(fitted.loss, s**2)


def _limit(best: float, met: Mapping[float, float], reach: float) -> float:
    """Where the root passes its limit, infinity where it does not."""
    rising, places = [0.0], [best]
    for place in sorted(met, key=lambda place: abs(place - best)):
        if met[place] > rising[-1]:
            rising.append(met[place])
            places.append(place)
        if met[place] >= reach:
            return float(PchipInterpolator(rising, places)(reach))
    return float(np.inf)
