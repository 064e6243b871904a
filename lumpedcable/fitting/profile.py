"""Profile likelihood: how the best fit worsens as one number is held at other values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import jax
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from lumpedcable.fitting.minimise import Found, search
from lumpedcable.fitting.residual import unpacked
from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.transforms import to_unbounded
from lumpedcable.fitting.uncertainty import Profile, reach_of
from lumpedcable.status import Status

__all__ = ["flagged", "profile_of", "with_profiles"]

Array = NDArray[np.float64]

PARTS = 4
"""Steps in which the limit is to be reached, on either side."""
MOST = 16
"""Most steps on a side: a side that has not come to the limit by then is open."""
LEAST_GROWTH, MOST_GROWTH = 0.5, 4.0
"""Factors by which a step may change from one to the next."""
BETTER = 1e-3
"""Relative fall of the loss on the way that shows that the fit was not the best."""


def with_profiles(fitted: Fitted, indices: Sequence[int] | None = None) -> Fitted:
    """A fit with the profiles of some numbers, or of those that are flagged."""
    chosen = flagged(fitted) if indices is None else indices
    return replace(fitted, profiles=tuple(profile_of(fitted, k) for k in chosen))


def flagged(fitted: Fitted) -> list[int]:
    """Numbers whose file asks for a profile; else those that the data do not tell, or at a bound."""
    vague = {int(np.argmax(np.abs(c.parts))) for c in fitted.certainty.vague()}
    found = []
    for k, p in enumerate(fitted.problem.parameters):
        asked = (k in vague or fitted.at_bound[k]) if p.profile is None else p.profile
        if asked and not fitted.failures:
            found.append(k)
    return found


def profile_of(fitted: Fitted, k: int) -> Profile:
    """The profile of a number.

    S(x) is found by searches with the number held, each from the end of the one before, in steps of
    x that raise the root by about a quarter of its limit (Bates & Watts, Nonlinear Regression
    Analysis, 1988, section 6.1). The limit is the normal quantile of the confidence, or Student's t
    where the noise was found from the fit; where the root passes it is interpolated.
    """
    free = fitted.problem.freedom
    s = 1.0 if fitted.problem.known_noise else float(np.sqrt(fitted.loss / free))
    reach = reach_of(fitted.problem.known_noise, fitted.problem.method.confidence, free)
    best, count = float(fitted.values[k]), 0
    sides, limits, better = [], [], False
    for side in (-1.0, 1.0):
        x, root, ended, taken, fell = _side(fitted, k, side, s, reach)
        sides.append((x, side * root))
        limits.append(_limit(best, x, root, reach, side, ended))
        count, better = count + taken, better or fell
    (x0, r0), (x1, r1) = sides
    return Profile(
        k, np.concatenate([x0[::-1], [best], x1]), np.concatenate([r0[::-1], [0.0], r1]),
        reach, limits[0], limits[1], better, count,
    )  # fmt: skip


def _side(fitted: Fitted, k: int, side: float, s: float, reach: float):
    """Values on one side, their roots, whether a bound or a failed run ended it, and what it took."""
    p, z, x = fitted.problem.parameters[k], fitted.sought.best.z, float(fitted.values[k])
    edge = p.low if side < 0.0 else p.high
    std = fitted.certainty.std[k]
    size = abs(x) or (abs(p.start) or 1.0)
    step = (std if np.isfinite(std) and std > 0.0 else size) * reach / PARTS
    places, roots, count, fell, last = [], [], 0, False, 0.0
    for _ in range(MOST):
        ended = np.isfinite(edge) and abs(edge - x) <= step * (1.0 + 1e-9)
        # a bound itself is infinitely far away for the search
        x = edge - side * 1e-6 * max(abs(edge - x), 1e-12 * size) if ended else x + side * step
        found, failed = _held(fitted, k, x, z)
        count += int(found.steps)
        loss = float(np.sum(found.residual**2))
        if failed or not np.isfinite(loss):
            return np.array(places), np.array(roots), True, count, fell
        fell = fell or loss < fitted.loss * (1.0 - BETTER)
        root = float(np.sqrt(max(loss - fitted.loss, 0.0))) / s
        places.append(x)
        roots.append(root)
        if root >= reach or ended:
            return np.array(places), np.array(roots), ended, count, fell
        grown = (reach / PARTS) / max(root - last, 1e-9)
        step, last, z = step * float(np.clip(grown, LEAST_GROWTH, MOST_GROWTH)), root, found.z
    return np.array(places), np.array(roots), False, count, fell


def _held(fitted: Fitted, k: int, x: float, z: Array) -> tuple[Found, bool]:
    """The best fit with one number held at x, and whether a run failed there."""
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
    status = unpacked(fitted.spec, arrays, found.flat).status
    return found, any(bool(np.any(one != Status.OK)) for one in status)


def _limit(best: float, x: Array, root: Array, reach: float, side: float, ended: bool) -> float:
    """Where the root passes its limit; the end of the side if a bound cut it off, else infinity."""
    if not root.size:
        return best
    if root[-1] < reach:
        return float(x[-1]) if ended else side * float(np.inf)
    rising, places = [0.0], [best]
    for one, place in zip(root, x, strict=True):
        if one > rising[-1]:
            rising.append(float(one))
            places.append(float(place))
    return float(PchipInterpolator(rising, places)(reach))
