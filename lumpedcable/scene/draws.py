"""Numbers drawn for a sweep: independent, in a Latin hypercube, or by Sobol's sequence.

The same seed, count and keys in the same order draw the same numbers anywhere.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

METHODS = ("random", "latin-hypercube", "sobol")
LEAST_SHARE = 1e-9  # of the smaller tail: with less between cuts, few numbers are left to draw


def unit_draws(method: str, count: int, keys: int, seed: int) -> NDArray[np.float64]:
    """Return points of the unit cube, shape (count, keys), each column in (0, 1).

    Latin hypercube: one point in each of `count` equal slices of every column (McKay, Beckman &
    Conover 1979). Sobol: Owen-scrambled (scipy.stats.qmc); best where count is a power of two.
    """
    rng = np.random.default_rng(seed)
    if method == "random":
        points = rng.random((count, keys))
    else:
        from scipy.stats import qmc  # takes a second to load

        engine = (
            qmc.Sobol(keys, rng=rng) if method == "sobol" else qmc.LatinHypercube(keys, rng=rng)
        )
        with warnings.catch_warnings():
            # a count that is no power of two costs balance, and is the user's choice
            warnings.filterwarnings("ignore", "The balance properties", UserWarning)
            points = engine.random(count)
    tiny = np.finfo(float).tiny
    return np.clip(points, tiny, np.nextafter(1.0, 0.0))


def spread(points: NDArray[np.float64], how: dict[str, Any]) -> NDArray[np.float64]:
    """Return numbers of a distribution at points u of (0, 1), by its inverse distribution function.

    Infinite where they are beyond arithmetic.

    Args:
        points: u, shape (count,).
        how: `from` and `to` alone, uniform: x = a + (b - a) u; with spacing "log", log-uniform:
            x = a^(1 - u) b^u; `mean` and `deviation`, normal: x = m + s Phi^-1(u), cut to [from, to]
            where these are given by u -> Phi(a') + u (Phi(b') - Phi(a')), a' = (a - m) / s.
    """
    low, high = how.get("from", -np.inf), how.get("to", np.inf)
    with np.errstate(over="ignore"):
        if "mean" not in how:
            if how.get("spacing") == "log":
                values = low ** (1.0 - points) * high**points
            else:
                values = low + (high - low) * points
        else:
            from scipy.special import ndtri

            side, (first, last) = _shares(how)
            rising = points if side > 0.0 else 1.0 - points
            values = how["mean"] + side * how["deviation"] * ndtri(first + rising * (last - first))
    # cuts take away what rounding adds, and not what overflows
    return np.where(np.isfinite(values), np.clip(values, low, high), values)


def cut_off(how: dict[str, Any]) -> tuple[float, float] | None:
    """Return how far cuts lie from the mean and from each other, in deviations, if nothing is between.

    None where numbers can be told apart there, and where nothing is cut.
    """
    if "mean" not in how:
        return None
    _, (first, last) = _shares(how)
    if last > np.finfo(float).tiny and last - first > LEAST_SHARE * last:
        return None
    low, high = _cuts(how)
    return min(abs(low), abs(high)), high - low


def _cuts(how: dict[str, Any]) -> tuple[float, float]:
    """Return the cuts of a normal distribution in deviations from its mean."""
    mean, deviation = how["mean"], how["deviation"]
    low, high = how.get("from", -np.inf), how.get("to", np.inf)
    return (low - mean) / deviation, (high - mean) / deviation


def _shares(how: dict[str, Any]) -> tuple[float, tuple[float, float]]:
    """Return which side the cuts of a normal distribution are seen from, and Phi at either.

    Above the mean Phi comes close to 1 and has no digits left: cuts there are mirrored (-1).
    """
    from scipy.special import ndtr

    low, high = _cuts(how)
    side, low, high = (-1.0, -high, -low) if low > 0.0 else (1.0, low, high)
    return side, (float(ndtr(low)), float(ndtr(high)))
