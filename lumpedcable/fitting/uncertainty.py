"""How sure the found values are: covariance, intervals, and what the data cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

__all__ = [
    "VAGUE",
    "Certainty",
    "Combination",
    "Criteria",
    "Draws",
    "Profile",
    "certainty_of",
    "criteria_of",
    "decomposed",
    "effective_of",
    "reach_of",
    "words",
]

Array = NDArray[np.float64]

VAGUE = 0.5  # relative standard deviation from which a combination is not told by the data
ALIKE = 0.98  # correlation from which two parameters are named together
LEAST_FREE = 1e-6  # degrees of freedom, not whole with smoothness, below which there are none
NAMED = 0.1  # share of the largest part of a combination below which a parameter is not named


class Combination(NamedTuple):
    """A combination of relative changes of the parameters, sum parts_k dx_k / size_k.

    `spread` is its standard deviation: 0.01 is known to 1 %, 1 not at all, inf not even its sign.
    """

    parts: Array
    spread: float


class Certainty(NamedTuple):
    """What the data say about the parameters around the best fit.

    std (p,), low, high (p,) in SI, those of a profile where there is one; correlation (p, p);
    combinations, the worst known first;
    factor: deviations over the noise that was given, or the noise itself where none was given;
    effective: how many numbers the data, not the smoothness, determine; free: degrees of freedom
    that they leave, 0 where there are no more values than numbers; noise: what std is reckoned with,
    over the noise that was given, infinite where none was and nothing is left to find it from.

    Parameters at their bound are held there for all others: covariance and correlation have zeros in
    their rows, no combination has a part of them, and their own std is that of all numbers left free.
    """

    std: Array
    low: Array
    high: Array
    covariance: Array
    correlation: Array
    combinations: tuple[Combination, ...]
    factor: float
    effective: float
    free: float
    noise: float

    def vague(self) -> list[Combination]:
        """The combinations that the data do not tell; none where the noise itself is unknown."""
        if not np.isfinite(self.noise):
            return []
        return [c for c in self.combinations if not c.spread < VAGUE]

    def alike(self) -> list[tuple[int, int, float]]:
        """Pairs of parameters that change nearly together: (k, j, correlation)."""
        found = []
        for k in range(self.std.size):
            for j in range(k):
                if abs(self.correlation[k, j]) > ALIKE:
                    found.append((j, k, float(self.correlation[k, j])))
        return sorted(found, key=lambda pair: -abs(pair[2]))


def reach_of(known: bool, confidence: float, free: float) -> float:
    """Half an interval in standard deviations: normal, or Student's t where the noise was found."""
    half = 0.5 + 0.5 * confidence
    if not known and not free:
        return float(np.inf)
    return float(stats.norm.ppf(half) if known else stats.t.ppf(half, free))


def certainty_of(
    values: Array, slope: Array, deviation: Array, points: int, known: bool, confidence: float,
    sizes: Array | None = None, held: NDArray[np.bool_] | None = None, given: float = 1.0,
) -> Certainty:  # fmt: skip
    """Covariance and intervals of a least-squares fit (linear about its minimum).

    cov = s^2 (J' J)^-1 with J the derivatives of the weighted deviations r. Where the noise is known
    s = 1 and an interval is x +- z std; else s^2 = r'r / (points - p) and z is Student's t
    (Seber & Wild, Nonlinear Regression, 1989, section 5.1), p numbers being away from their bounds; with
    no more values than these s is infinite. With rows of smoothness the numbers that the data determine
    take the place of p: the trace of (J' J)^-1 J_data' J_data. The inverse is taken by the singular
    values of J diag(size), so that a combination without data has an infinite spread and the others keep
    theirs.

    Args:
        values: the parameters (p,) in SI.
        slope: J (n, p) by the parameters in SI, rows of smoothness behind those of the data.
        deviation: r (m,) of the data alone; J's first m rows belong to it.
        points: number of measured values.
        known: whether the noise was given.
        confidence: probability of the intervals.
        sizes: what a parameter is measured by (p,); its own value if not given, 1 where that is 0.
        held: parameters at their bound (p,), see `Certainty`; none if not given.
        given: s where the noise is known, 1 for squares; see `forgiven` of `outliers.py`.
    """
    count = values.size
    if sizes is None:
        sizes = np.where(values != 0.0, np.abs(values), 1.0)
    inner = np.ones(count, bool) if held is None else ~held
    whole = slope * sizes
    v, inverse = _directions(whole)
    effective = effective_of(whole, deviation.size)
    # what is held at a bound has met nothing of the noise
    smooth = whole.shape[0] > deviation.size
    told = effective_of(whole[:, inner], deviation.size) if smooth else np.sum(inner)
    free = points - told
    free = float(free) if free > LEAST_FREE else 0.0
    reached = float(np.sqrt(np.sum(deviation**2) / (free or 1.0)))
    s = given if known else reached if free else np.inf
    std = _times(s, _spreads(v, inverse)) * sizes
    if not np.all(inner):
        v, inverse = _directions(whole[:, inner])
        std[inner] = _times(s, _spreads(v, inverse)) * sizes[inner]
    covariance, correlation = np.zeros((count, count)), np.eye(count)
    square = np.ix_(inner, inner)
    with np.errstate(invalid="ignore"):
        scaled = np.where(v == 0.0, 0.0, v * inverse[:, None])
        product = _times(s**2, scaled.T @ scaled)
        covariance[square] = product * np.outer(sizes[inner], sizes[inner])
    correlation[square] = _correlation(v, inverse)
    reach = reach_of(known, confidence, free)
    combinations, spreads = [], _times(s, inverse)
    for k in np.argsort(-inverse, kind="stable"):
        parts = np.zeros(count)
        parts[inner] = _signed(v[k])
        combinations.append(Combination(parts, float(spreads[k])))
    return Certainty(
        std, values - reach * std, values + reach * std, covariance, correlation,
        tuple(combinations), reached, effective, free, s,
    )  # fmt: skip


def _times(s: float, spread: Array) -> Array:
    """A spread per unit of noise times the noise: what no data tell has none, even if s is 0."""
    return np.where(np.isfinite(spread), s * np.where(np.isfinite(spread), spread, 1.0), spread)


def _directions(slope: Array) -> tuple[Array, Array]:
    """Directions (p, p), a row each, and one over their singular values, inf where there is none."""
    if not slope.shape[1]:
        return np.zeros((0, 0)), np.zeros(0)
    v, singular = decomposed(slope)
    floor = singular[0] * max(slope.shape) * np.finfo(float).eps
    with np.errstate(divide="ignore"):
        return v, np.where(singular > floor, 1.0 / singular, np.inf)


def decomposed(slope: Array) -> tuple[Array, Array]:
    """Directions (p, p), a row each, and their singular values (p,), 0 for what no row of J sees.

    The n x n matrix of the other side is never made where n is larger than p.
    """
    rows, count = slope.shape
    _, singular, v = np.linalg.svd(slope, full_matrices=rows < count)
    return v, np.concatenate([singular, np.zeros(count - singular.size)])


def _spreads(v: Array, inverse: Array) -> Array:
    """Root of the diagonal of the inverse of J'J: inf where a direction that takes part has none."""
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.sum(np.where(v == 0.0, 0.0, v * inverse[:, None]) ** 2, axis=0))


def _correlation(v: Array, inverse: Array) -> Array:
    """Which parameters change together is a matter of the directions that are known at all."""
    most = 1e8 * inverse[0] if inverse.size and np.isfinite(inverse[0]) else 1.0
    tame = v * np.minimum(inverse, most)[:, None]
    outer = tame.T @ tame
    root = np.sqrt(np.diag(outer))
    return outer / np.outer(root, root)


def effective_of(whole: Array, data: int) -> float:
    """How many numbers the first `data` rows of J determine, those behind them being given."""
    if whole.shape[0] > data:
        part = whole[:data].T @ whole[:data]
        return float(np.trace(np.linalg.pinv(whole.T @ whole) @ part))
    return float(min(whole.shape[1], data))


def _signed(parts: Array) -> Array:
    """The same direction with its largest part positive."""
    return parts * np.sign(parts[np.argmax(np.abs(parts))])


def words(combination: Combination, names: Sequence[str]) -> str:
    """A combination for people: "0.71 d(p1)/p1 - 0.70 d(p4)/p4"."""
    top, text = np.max(np.abs(combination.parts)), ""
    order = [k for k in np.argsort(-np.abs(combination.parts)) if
             abs(combination.parts[k]) >= NAMED * top]  # fmt: skip
    if len(order) == 1:
        return str(names[int(order[0])])
    for k in order:
        part = combination.parts[k]
        sign = ("-" if part < 0 else "+") if text else ("-" if part < 0 else "")
        text += f" {sign} {abs(part):.2f} d({names[k]})/{names[k]}" if text else (
            f"{sign}{abs(part):.2f} d({names[k]})/{names[k]}")  # fmt: skip
    return text


class Profile(NamedTuple):
    """The profile of one number, by its place among the parameters.

    root = sign(x - x_best) sqrt((S(x) - S_best)/s^2), S(x) the least sum of squares with the number
    held at x, s the noise (1 where it was given): a straight line where the model is linear. The
    interval is where |root| stays below `reach`; -inf or inf where a side is open. `failed`: by
    side, whether it is open since runs fail beyond the last x, which tells nothing of the data.
    """

    parameter: int
    x: Array
    root: Array
    reach: float
    low: float
    high: float
    better: bool
    evaluations: int
    failed: tuple[bool, bool] = (False, False)


class Draws(NamedTuple):
    """Draws from the distribution of the parameters: values (chains, draws, p) in SI.

    low, high (p,): quantiles of the confidence. r_hat (p,): spread of all chains over that within
    them, 1 where they agree; size (p,): how many independent draws they are worth (Gelman et al.,
    Bayesian Data Analysis, 3rd ed., 2013, sections 11.4 and 11.5). `diverging` steps went wrong;
    `evaluations` of the model with its gradient were made after the warm-up.
    """

    values: Array
    low: Array
    high: Array
    r_hat: Array
    size: Array
    diverging: int
    evaluations: int


class Criteria(NamedTuple):
    """How well a law explains the data for its number of parameters; less is better."""

    aic: float
    bic: float


def criteria_of(deviation: Array, points: int, effective: float, known: bool) -> Criteria:
    """AIC and BIC for normal noise, up to a constant that all laws on the same data share.

    Noise given: chi^2 + 2 k and chi^2 + k ln n. Noise found from the fit: n ln(chi^2/n) in place of
    chi^2, and k counts it too (Burnham & Anderson, Model Selection and Multimodel Inference, 2002,
    section 2.2).
    """
    square = float(np.sum(deviation**2))
    count = effective if known else effective + 1.0
    fit = square if known else points * float(np.log(max(square / points, 1e-300)))
    return Criteria(fit + 2.0 * count, fit + count * float(np.log(points)))
