"""Numbers drawn for a sweep: independent, in a Latin hypercube, or by Sobol's sequence.

The same seed, count and keys draw the same numbers anywhere.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

METHODS = ("random", "latin-hypercube", "sobol")


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

    Args:
        points: u, shape (count,).
        how: `from` and `to` alone, uniform: x = a + (b - a) u; with spacing "log", log-uniform:
            x = a (b / a)^u; `mean` and `deviation`, normal: x = m + s Phi^-1(u), cut to [from, to]
            where these are given by u -> Phi(a') + u (Phi(b') - Phi(a')), a' = (a - m) / s.
    """
    low, high = how.get("from", -np.inf), how.get("to", np.inf)
    if "mean" not in how:
        if how.get("spacing") == "log":
            values = low * np.exp(points * np.log(high / low))
        else:
            values = low + (high - low) * points
    else:
        from scipy.special import ndtr, ndtri

        mean, deviation = how["mean"], how["deviation"]
        first, last = ndtr((low - mean) / deviation), ndtr((high - mean) / deviation)
        values = mean + deviation * ndtri(first + points * (last - first))
    return np.clip(values, low, high)
