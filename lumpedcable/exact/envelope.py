"""Lower convex envelope of a tension law: the structure of a release wave.

A line released from strain e0 sends a wave into itself whose speed has to grow from its tail to
its front. Where the law T(e) is convex between the two states the wave is a rarefaction; where it
is not, the lower convex envelope bridges the law by a chord, and the chord is a shock. This is
the entropy solution of the p-system: O. A. Oleinik, Uspekhi Mat. Nauk 14 (1959), condition (E);
R. J. LeVeque, Finite Volume Methods for Hyperbolic Problems (2002), section 16.1.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from .law import Array, Law, LawRange, law_range, root, smallest

Kind = Literal["rarefaction", "shock", "contact"]
"""Strictly convex part, chord above which the law lies, or straight part of the law itself."""


@dataclass(frozen=True)
class EnvelopePiece:
    """One piece of the envelope.

    Attributes:
        kind: "rarefaction", "shock" or "contact".
        strain_lo: strain at its lower end.
        strain_hi: strain at its upper end.
        slope_lo: slope of the envelope at the lower end, N.
        slope_hi: slope of the envelope at the upper end, N.
    """

    kind: Kind
    strain_lo: float
    strain_hi: float
    slope_lo: float
    slope_hi: float


@dataclass(frozen=True)
class Envelope:
    """The lower convex envelope That(e) of a law on [strain_lo, strain_hi].

    Attributes:
        law: the law on its range.
        pieces: the pieces by rising strain; their slopes rise too.
    """

    law: LawRange
    pieces: tuple[EnvelopePiece, ...]

    def tension(self, strain: ArrayLike) -> Array:
        """Return That(e) in N."""
        e = np.asarray(strain, float)
        out = self.law.tension(e).copy()
        for p in self.pieces:
            if p.kind == "rarefaction":
                continue
            on = (e >= p.strain_lo) & (e <= p.strain_hi)
            chord = self.law.tension(p.strain_lo) + p.slope_lo * (e - p.strain_lo)
            out = np.where(on, chord, out)
        return out

    def slope(self, strain: ArrayLike) -> Array:
        """Return That'(e) in N."""
        e = np.asarray(strain, float)
        out = self.law.slope(e)
        for p in self.pieces:
            if p.kind != "rarefaction":
                out = np.where((e >= p.strain_lo) & (e <= p.strain_hi), p.slope_lo, out)
        return out


def lower_convex_envelope(
    tension: Law,
    strain_lo: float,
    strain_hi: float,
    *,
    derivative: Law | None = None,
    knots: Iterable[float] = (),
    samples: int = 4001,
) -> Envelope:
    """Return the lower convex envelope of T between two strains.

    The law is sampled, the lower hull of the samples found (Andrew's monotone chain), and every
    end of a chord inside the range moved from its sample to the point of tangency,

        T'(a) = (T(b) - T(a)) / (b - a),

    by bracketed root finding. A chord that is tangent at both ends is found by fixing one end and
    then the other in turn; as moving a tangent end along the law does not turn the chord, to
    first order, this converges quadratically. Features narrower than a sample are not seen.

    Args:
        tension: vectorised law T(e), N.
        strain_lo: lower strain.
        strain_hi: upper strain.
        derivative: vectorised T'(e), N; None for sixth-order differences.
        knots: strains of the law's corners, which become samples.
        samples: number of uniform samples.

    Raises:
        ValueError: if the range is empty, or the law is not finite on it.
    """
    law = law_range(tension, strain_lo, strain_hi, derivative, knots)
    e = np.unique(np.concatenate([np.linspace(law.lo, law.hi, samples), law.edges]))
    T = law.tension(e)
    if not np.all(np.isfinite(T)):
        bad = e[~np.isfinite(T)][0]
        raise ValueError(f"the tension law is not finite at strain {bad:g}")
    tol = 64.0 * np.finfo(float).eps * float(np.max(np.abs(T)))
    runs = _runs(e, T, _hull(e, T, tol), tol)
    ends = [_polish(law, e, run) for run in runs]
    return Envelope(law, tuple(_join(law, ends)))


def _hull(e: Array, T: Array, tol: float) -> list[int]:
    """Return the indices of the lower hull; a point on a chord to within `tol` is no vertex."""
    hull: list[int] = []
    for k in range(len(e)):
        while len(hull) > 1:
            i, j = hull[-2], hull[-1]
            chord = T[i] + (T[k] - T[i]) * ((e[j] - e[i]) / (e[k] - e[i]))
            if T[j] < chord - tol:
                break
            hull.pop()
        hull.append(k)
    return hull


def _runs(e: Array, T: Array, hull: list[int], tol: float) -> list[tuple[Kind, int, int]]:
    """Name every edge of the hull and join neighbouring cells of rarefaction."""
    runs: list[tuple[Kind, int, int]] = []
    for i, j in pairwise(hull):
        kind: Kind = "rarefaction"
        if j - i > 1:
            chord = T[i] + (T[j] - T[i]) * ((e[i : j + 1] - e[i]) / (e[j] - e[i]))
            gap = T[i : j + 1] - chord
            if np.max(gap) > tol:
                kind = "shock"
            elif np.min(gap) >= -tol and j - i > 2:
                kind = "contact"
        if runs and kind == "rarefaction" == runs[-1][0]:
            runs[-1] = (kind, runs[-1][1], j)
        else:
            runs.append((kind, i, j))
    return runs


def _polish(law: LawRange, e: Array, run: tuple[Kind, int, int]) -> tuple[Kind, float, float]:
    """Move the free ends of a shock to the points of tangency."""
    kind, i, j = run
    a, b = float(e[i]), float(e[j])
    if kind != "shock":
        return kind, a, b
    last = len(e) - 1
    for _ in range(30):
        before = (a, b)
        if i > 0:
            a = _tangent(law, b, float(e[i - 1]), a, float(e[i + 1]))
        if j < last:
            b = _tangent(law, a, float(e[j - 1]), b, float(e[j + 1]))
        if abs(a - before[0]) + abs(b - before[1]) <= 1e-15 * (law.hi - law.lo):
            break
    return kind, a, b


def _tangent(law: LawRange, fixed: float, lo: float, guess: float, hi: float) -> float:
    """Return the point in [lo, hi] at which the chord to `fixed` supports the law."""

    def chord(x: float) -> float:
        return float((law.tension(fixed) - law.tension(x)) / (fixed - x))

    k = chord(guess)
    if guess in law.edges and float(law.slope(guess, "left")) <= k <= float(law.slope(guess)):
        return guess  # a corner of the law carries the chord

    def g(x: float) -> float:
        return float(law.slope(x)) - chord(x)

    if g(lo) * g(hi) < 0.0:
        return root(g, lo, hi)
    # No change of sign: the law is rough on the scale of a sample. The supporting chord is the
    # steepest one seen from the right and the flattest one seen from the left.
    sign = -1.0 if fixed > guess else 1.0
    return smallest(lambda x: sign * chord(x), lo, hi)[0]


def _join(law: LawRange, ends: list[tuple[Kind, float, float]]) -> list[EnvelopePiece]:
    """Make the pieces meet again after their ends have moved, and give them their slopes."""
    pieces: list[EnvelopePiece] = []
    least = 1e-12 * (law.hi - law.lo)
    at = law.lo
    for n, (kind, a, b) in enumerate(ends):
        if kind == "shock" and a - at > least:  # a rarefaction narrower than a sample
            pieces.append(_piece(law, "rarefaction", at, a))
            at = a
        if n + 1 == len(ends):
            b = law.hi
        elif kind == "rarefaction":
            b = ends[n + 1][1]
        elif kind == "contact":
            b = min(b, ends[n + 1][1])
        if b - at > least:
            pieces.append(_piece(law, kind, at, b))
            at = b
    return pieces


def _piece(law: LawRange, kind: Kind, a: float, b: float) -> EnvelopePiece:
    if kind == "rarefaction":
        return EnvelopePiece(kind, a, b, float(law.slope(a)), float(law.slope(b, "left")))
    chord = float((law.tension(b) - law.tension(a)) / (b - a))
    return EnvelopePiece(kind, a, b, chord, chord)
