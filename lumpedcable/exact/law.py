"""A tension law on a range of strain: slope, sound speed and inverse of any vectorised T(e).

The exact waves of this package accept any law given as a callable. What they need beyond T itself
(slope, curvature, the strain of a given tension, the integral of the sound speed) is made here,
to near rounding and without assuming a form of the law.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq, minimize_scalar

from .checks import finite

Array = NDArray[np.float64]
"""Array of float64."""

Law = Callable[[Array], ArrayLike]
"""Vectorised law: strain (dimensionless, any shape) to tension in N, or to its slope in N."""

Truth = NDArray[np.bool_]
"""Array of bool."""

_STENCIL = np.arange(-3.0, 4.0)
_STENCIL_INVERSE = np.linalg.inv(np.vander(_STENCIL, increasing=True))
_POWERS = np.arange(1.0, 7.0)
_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(16)
_BISECTIONS = 110


def bisect(grows: Callable[[Array], Truth], lo: ArrayLike, hi: ArrayLike) -> Array:
    """Return where a monotone predicate turns true, for many unknowns at once.

    `grows(x)` is False at `lo` and True at `hi`, elementwise. Halving goes on until neighbouring
    floats are reached, so the answer does not depend on the smoothness of what lies behind the
    predicate. Returns the midpoint of the last interval, shape of the broadcast inputs.
    """
    lo, hi = np.broadcast_arrays(np.asarray(lo, float), np.asarray(hi, float))
    lo, hi = lo.copy(), hi.copy()
    for _ in range(_BISECTIONS):
        mid = 0.5 * (lo + hi)
        if np.all((mid == lo) | (mid == hi)):
            break
        up = grows(mid)
        hi = np.where(up, mid, hi)
        lo = np.where(up, lo, mid)
    return 0.5 * (lo + hi)


def root(g: Callable[[float], float], lo: float, hi: float) -> float:
    """Return the zero of `g` between `lo` and `hi`, where it changes sign, to rounding."""
    found: Any = brentq(g, lo, hi, xtol=1e-300, rtol=np.float64(8.9e-16), maxiter=500)
    return float(found)


def smallest(g: Callable[[float], float], lo: float, hi: float) -> tuple[float, float]:
    """Return the place and value of the minimum of `g` between `lo` and `hi`."""
    options: Any = {"xatol": 1e-10 * (hi - lo)}
    found: Any = minimize_scalar(g, bounds=(lo, hi), method="bounded", options=options)
    return float(found.x), float(found.fun)


def _derivative(values: Callable[[Array], Array], e: Array, lo: Array, hi: Array) -> Array:
    """Return the derivative of `values` at `e` from seven points that stay inside [lo, hi]."""
    h = 2e-4 * (hi - lo)
    centre = np.clip(e, lo + 3.0 * h, hi - 3.0 * h)
    u = (e - centre) / h
    # d/du of the interpolating polynomial sum_k a_k u^k, with a = V^-1 f.
    row = (_POWERS * u[..., None] ** (_POWERS - 1.0)) @ _STENCIL_INVERSE[1:]
    return np.sum(row * values(centre[..., None] + h[..., None] * _STENCIL), axis=-1) / h


@dataclass(frozen=True)
class LawRange:
    """A tension law T(e) between two strains.

    Attributes:
        law: vectorised T(e), N.
        derivative: vectorised T'(e), N, or None for a sixth-order difference of T.
        edges: increasing strains; the ends of the range and, inside it, the corners of the law
            (points of a table). Differences and quadratures never step over an edge.
    """

    law: Law
    derivative: Law | None
    edges: tuple[float, ...]

    @property
    def lo(self) -> float:
        """Lower end of the range (strain)."""
        return self.edges[0]

    @property
    def hi(self) -> float:
        """Upper end of the range (strain)."""
        return self.edges[-1]

    def tension(self, strain: ArrayLike) -> Array:
        """Return T(e) in N, in the shape of `strain`."""
        return tension_values(self.law, strain)

    def _segment(self, e: Array, side: str) -> tuple[Array, Array]:
        edges = np.asarray(self.edges)
        j = np.searchsorted(edges, e, side="right" if side == "right" else "left") - 1
        j = np.clip(j, 0, len(edges) - 2)
        return edges[j], edges[j + 1]

    def slope(self, strain: ArrayLike, side: str = "right") -> Array:
        """Return T'(e) in N; at an edge the limit from the given side ("left" or "right")."""
        e = np.asarray(strain, float)
        lo, hi = self._segment(e, side)
        if self.derivative is None:
            return _derivative(self.tension, e, lo, hi)
        # A step inside: a law cut at zero has no slope at the cut itself, and the rounding of T
        # decides on which side of the cut a point next to it falls.
        inside = 1e-12 * (hi - lo)
        e = np.clip(e, lo + inside, hi - inside)
        return np.broadcast_to(np.asarray(self.derivative(e), float), e.shape)

    def curvature(self, strain: ArrayLike) -> Array:
        """Return T''(e) in N, from differences of the slope."""
        e = np.asarray(strain, float)
        return _derivative(self.slope, e, *self._segment(e, "right"))

    def sound_speed(self, strain: ArrayLike, mass: float, side: str = "right") -> Array:
        """Return c = sqrt(T'(e)/m) in m/s, per unstretched length; 0 where T' is negative."""
        return np.sqrt(np.maximum(self.slope(strain, side), 0.0) / mass)


def tension_values(law: Law, strain: ArrayLike) -> Array:
    """Return T(e) in N as a float64 array in the shape of `strain`."""
    e = np.asarray(strain, float)
    return np.broadcast_to(np.asarray(law(e), float), e.shape)


def law_range(
    law: Law, lo: float, hi: float, derivative: Law | None = None, knots: Iterable[float] = ()
) -> LawRange:
    """Return the law on [lo, hi]; raises ValueError unless the range is finite and increasing."""
    if not (np.isfinite(lo) and np.isfinite(hi) and lo < hi):
        raise ValueError(f"expected an increasing range of strain, found [{lo:g}, {hi:g}]")
    inner = sorted({float(k) for k in knots if lo < k < hi})
    return LawRange(law, derivative, (float(lo), *inner, float(hi)))


def inverse_tension(
    tension: Law, T0: float, bracket: tuple[float, float] = (-0.5, 2.0), samples: int = 2001
) -> float:
    """Return the smallest strain in `bracket` from which the tension is T0: T(e) = T0.

    The bracket is sampled, the first cell in which T reaches T0 from below is taken, and halved
    down to neighbouring floats. This needs no derivative and stands corners, slack parts
    (T = 0 there, so T0 = 0 gives the end of the slack part) and laws that fall again further up.

    Args:
        tension: vectorised law T(e), N.
        T0: tension, N.
        bracket: strains between which to look.
        samples: number of samples of the bracket.

    Returns:
        The strain (dimensionless).

    Raises:
        ValueError: if T does not cross T0 upwards between the two strains.
    """
    lo, hi = bracket
    if not lo < hi:
        raise ValueError(f"expected an increasing bracket of strain, found [{lo:g}, {hi:g}]")
    e = np.linspace(lo, hi, samples)
    above = tension_values(tension, e) > T0
    up = np.flatnonzero(~above[:-1] & above[1:])
    if up.size == 0:
        values = tension_values(tension, e)
        if values[-1] == T0:  # the crossing is the end of the bracket itself
            return float(e[np.argmax(values >= T0)])
        raise ValueError(
            f"no strain between {lo:g} and {hi:g} carries {T0:g} N: the law gives "
            f"{np.nanmin(values):g} N to {np.nanmax(values):g} N there"
        )
    i = int(up[0])
    return float(bisect(lambda x: tension_values(tension, x) > T0, e[i], e[i + 1]))


def released_strain(tension: Law, strain0: float, end_tension: float = 0.0) -> float:
    """Return the largest strain below `strain0` at which T(e) = `end_tension`.

    This is the strain a released line falls to: for a law cut at zero it is the slack strain,
    the largest strain at which the tension is zero. Looked for in [0, strain0] first, then in
    compression down to -0.9.

    Args:
        tension: vectorised law T(e), N.
        strain0: strain before the release.
        end_tension: force on the end after the release, N.

    Raises:
        ValueError: if the tension at `strain0` is not above `end_tension`, or never falls to it.
    """
    start = float(tension_values(tension, strain0))
    if not start > end_tension:
        raise ValueError(
            f"a release lowers the tension: expected T(strain0) above {end_tension:g} N, "
            f"found {start:g} N at strain {strain0:g}"
        )
    finite(**{"strain before the release": strain0, "end tension": end_tension})
    for lo in (0.0, -0.9) if strain0 > 0.0 else (-0.9,):
        e = np.linspace(lo, strain0, 4001)
        below = np.flatnonzero(tension_values(tension, e) <= end_tension)
        if below.size:
            i = int(below[-1])
            found = float(bisect(lambda x: tension_values(tension, x) > end_tension, *e[i : i + 2]))
            # The sample itself, for instance e = 0 of a linear law.
            return float(e[i]) if found - e[i] < 1e-15 * (strain0 - lo) else found
    raise ValueError(f"the law does not fall to {end_tension:g} N between strain -0.9 and strain0")


@dataclass(frozen=True)
class SpeedIntegral:
    """The velocity a simple wave picks up, w(e) = integral of c from e to the upper end, m/s.

    Composite 16-point Gauss-Legendre over panels that end at the corners of the law and shrink
    towards both ends of the range, where c may start like a square root.
    """

    law: LawRange
    mass: float
    panels: Array
    tail: Array

    def __call__(self, strain: ArrayLike) -> Array:
        """Return w(e) in m/s, in the shape of `strain` (clipped to the range)."""
        e = np.clip(np.asarray(strain, float), self.law.lo, self.law.hi)
        j = np.clip(np.searchsorted(self.panels, e, side="right") - 1, 0, len(self.panels) - 2)
        return self.tail[j + 1] + _gauss(self.law, self.mass, e, self.panels[j + 1])


def _gauss(law: LawRange, mass: float, lo: Array, hi: Array) -> Array:
    half = 0.5 * (hi - lo)
    e = (0.5 * (hi + lo))[..., None] + half[..., None] * _GAUSS_X
    return half * np.sum(_GAUSS_W * law.sound_speed(e, mass), axis=-1)


def speed_integral(law: LawRange, mass: float) -> SpeedIntegral:
    """Return the integral of the sound speed of `law` for the mass per length `mass` (kg/m)."""
    edges = np.asarray(law.edges)
    uniform = [np.linspace(a, b, max(2, 64 // (len(edges) - 1))) for a, b in pairwise(edges)]
    panels = np.unique(np.concatenate(uniform))
    shrink = 0.5 ** np.arange(1, 25)
    first = panels[0] + (panels[1] - panels[0]) * shrink
    last = panels[-1] - (panels[-1] - panels[-2]) * shrink
    panels = np.unique(np.concatenate([panels, first, last]))
    parts = _gauss(law, mass, panels[:-1], panels[1:])
    tail = np.concatenate([np.cumsum(parts[::-1])[::-1], [0.0]])
    return SpeedIntegral(law, mass, panels, tail)
