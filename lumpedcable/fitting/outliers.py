"""What data tell where a loss forgives outliers: less than where each deviation counts in full."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

__all__ = ["Forgiven", "deviations_of", "forgiven", "influence"]

Array = NDArray[np.float64]

FAR = 9.0  # standard deviations that normal noise is taken to reach
POINTS = 80  # of its quadrature on either side of the threshold


class Forgiven(NamedTuple):
    """The mean curvature of a loss (1 of squares), and the noise that an interval is reckoned with.

    `curvature` m is the mean of psi' (-), `noise` the root of v/m (over the noise that was given), v the
    mean of psi^2: covariances are v/m^2 (J' J)^-1, and the sum of the losses rises by v/m times what a
    sum of squares would.
    """

    curvature: float
    noise: float


def deviations_of(g: Array, loss: str, c: float) -> Array:
    """The deviations r whose loss is g^2: `robust` of `residual.py` the other way round."""
    if loss == "huber":
        return np.where(np.abs(g) <= c, g, np.sign(g) * (g**2 + c**2) / (2.0 * c))
    return np.sign(g) * c * np.sqrt(np.expm1((g / c) ** 2))


def influence(r: Array, loss: str, c: float) -> tuple[Array, Array]:
    """psi(r) = rho'(r)/2 of huber or cauchy (`robust` of `residual.py`), and its slope."""
    if loss == "huber":
        return np.clip(r, -c, c), np.where(np.abs(r) <= c, 1.0, 0.0)
    u = (r / c) ** 2
    return r / (1.0 + u), (1.0 - u) / (1.0 + u) ** 2


def forgiven(r: Array, loss: str, c: float, count: float) -> Forgiven:
    """How sure `count` numbers are that were found with a loss, from the deviations (n,) left.

    v/m^2 = K^2 [sum psi^2/(n - p)] / [sum psi'/n]^2 with K = 1 + (p/n) var(psi')/mean(psi')^2 (Huber &
    Ronchetti, Robust Statistics, 2nd ed., 2009, eq. 7.81), but no less than normal noise of the size
    that was given would leave: few data that happen to lie near say nothing against it.

    Args:
        r: deviations over the noise that was given.
        loss: huber or cauchy.
        c: its threshold.
        count: numbers found, p.
    """
    m, v = _of_normal_noise(loss, c)
    psi, slope = influence(r, loss, c)
    n, mean = r.size, float(np.mean(slope)) if r.size else 0.0
    if n > count and mean > 0.0:
        k = 1.0 + count / n * float(np.var(slope)) / mean**2
        found = k**2 * float(psi @ psi) / (n - count)
        if found / mean**2 > v / m**2:
            m, v = mean, found
    elif r.size and mean <= 0.0:
        m = 0.0  # nothing is left that counts
    return Forgiven(m, float(np.sqrt(v / m)) if m else 1.0)


def _of_normal_noise(loss: str, c: float) -> tuple[float, float]:
    """The means of psi' and psi^2 for deviations of a standard deviation of 1."""
    x, weight = np.polynomial.legendre.leggauss(POINTS)
    m = v = 0.0
    for low, high in ((0.0, min(c, FAR)), (min(c, FAR), FAR)):
        half = 0.5 * (high - low)
        r = low + half * (x + 1.0)
        psi, slope = influence(r, loss, c)
        chance = 2.0 * half * weight * stats.norm.pdf(r)
        m, v = m + float(chance @ slope), v + float(chance @ psi**2)
    return m, v
