"""A highline at rest: inextensible catenaries between two posts, with and without cargo.

x runs from the sending end A towards the receiving end B, z up, both 0 at A; B lies `drop` below A
(negative: above). With H the horizontal tension, q the weight per length and u = dz/dx at the start
of a part, downwards positive as sinh a = -u,

    z(x) = (H/q) [cosh(a - q x/H) - cosh a],    T(x) = H cosh(a - q x/H).

Source: W. Lun, Q. Li & H. Hou, Visual simulation model of highline cable alongside replenishment
for solid cargo (2018), section 3, eqs. (1)-(22), whose y is -z. With beta = q l/(2 H), eq. (2), and
alpha = a, eq. (3). Misprints there: in eq. (7) the first term wants cosh^2(beta/2) for cosh^2 beta;
eq. (8) wants u(beta_k), u'(beta_k); eq. (19) wants p(beta_k) (beta_k - beta_{k-1}) over the
difference, as it is, but of p and not of its absolute value; the upper bound beta = 1 of eq. (22)
misses roots at low tension: with l = 60 m, c = 16 m, q = 40 N/m it finds none below 2218.77 N, though
there are some down to 2170.67 N (beta = 1.2156), and none below that.

All functions take arrays, broadcast against each other, and complex numbers, with which
`lumpedcable.exact.roots.derivatives` finds derivatives.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from .checks import NO_LINE, finite, hold, positive, reaching
from .roots import Values, bracketed

__all__ = [
    "Highline",
    "Part",
    "highline_from_length",
    "highline_from_sag",
    "highline_from_tension",
    "least_tension",
]

# the symbols of the paper's screens and what they stand for here
SHOWN = {
    "S": "length",
    "f": "sag",
    "F_TA": "tension_a",
    "F_TB": "tension_b",
    "F_H": "horizontal",
}


@dataclass(frozen=True)
class Part:
    """One catenary of a highline.

    Attributes:
        x, z: where it starts, m.
        reach: how far it leads in x, m.
        weight: weight per length q, N/m.
        horizontal: horizontal tension H, N.
        angle: a = asinh of the slope at its start, downwards positive.
    """

    x: Values
    z: Values
    reach: Values
    weight: Values
    horizontal: Values
    angle: Values

    @cached_property
    def turn(self) -> Values:
        """By how much `angle` falls from start to end, q reach/H."""
        return self.weight * self.reach / self.horizontal

    @property
    def end_angle(self) -> Values:
        """asinh of the slope at its end, downwards positive."""
        return self.angle - self.turn

    @property
    def drop(self) -> Values:
        """How far its end lies below its start, m."""
        # cosh a - cosh b = 2 sinh((a + b)/2) sinh((a - b)/2): no difference of near numbers
        half = 0.5 * self.turn
        size = 2.0 * self.horizontal / self.weight
        return size * np.sinh(self.angle - half) * np.sinh(half)

    @property
    def length(self) -> Values:
        """Length S of the part, m (eq. (10))."""
        half = 0.5 * self.turn
        size = 2.0 * self.horizontal / self.weight
        return size * np.cosh(self.angle - half) * np.sinh(half)

    @property
    def tension(self) -> Values:
        """Tension at its start, N (eq. (12))."""
        return self.horizontal * np.cosh(self.angle)

    @property
    def end_tension(self) -> Values:
        """Tension at its end, N (eq. (13))."""
        return self.horizontal * np.cosh(self.end_angle)

    def height(self, x: ArrayLike) -> Values:
        """Return z at x, m (eq. (1))."""
        half = 0.5 * self.weight * (np.asarray(x) - self.x) / self.horizontal
        size = 2.0 * self.horizontal / self.weight
        return self.z - size * np.sinh(self.angle - half) * np.sinh(half)

    def tension_at(self, x: ArrayLike) -> Values:
        """Return the tension at x, N (eq. (11))."""
        turned = self.weight * (np.asarray(x) - self.x) / self.horizontal
        return self.horizontal * np.cosh(self.angle - turned)


@dataclass(frozen=True)
class Highline:
    """A line from A to B in one part, or in two that meet at a load or a joint.

    Attributes:
        span: horizontal distance l from A to B, m.
        drop: how far B lies below A, c, m.
        parts: the catenaries, from A on.
    """

    span: Values
    drop: Values
    parts: tuple[Part, ...]

    @property
    def horizontal(self) -> Values:
        """Horizontal tension F_H, N."""
        return self.parts[0].horizontal

    @property
    def length(self) -> Values:
        """Length S of all parts, m."""
        return sum((part.length for part in self.parts[1:]), self.parts[0].length)

    @property
    def tension_a(self) -> Values:
        """Tension at the sending end, F_TA, N."""
        return self.parts[0].tension

    @property
    def tension_b(self) -> Values:
        """Tension at the receiving end, F_TB, N."""
        return self.parts[-1].end_tension

    @property
    def beta(self) -> Values:
        """q l/(2 H) of a line in one part, eq. (2)."""
        return 0.5 * self.parts[0].turn

    @property
    def alpha(self) -> Values:
        """The angle of eq. (3) of a line in one part."""
        return self.parts[0].angle

    @property
    def middle(self) -> tuple[Values, Values]:
        """x and z, m, of the load or joint; of mid-span where the line is in one part."""
        first, *others = self.parts
        if others:
            return others[0].x, others[0].z
        return 0.5 * self.span, first.height(0.5 * self.span)

    @property
    def sag(self) -> Values:
        """Depth f under the chord AB at `middle`, m (eqs. (4), (26))."""
        x, z = self.middle
        return -z - x * self.drop / self.span

    def height(self, x: ArrayLike) -> Values:
        """Return z at x, m."""
        return self._of_part(x, [part.height(x) for part in self.parts])

    def tension(self, x: ArrayLike) -> Values:
        """Return the tension at x, N; right of the load where x is its place."""
        return self._of_part(x, [part.tension_at(x) for part in self.parts])

    def _of_part(self, x: ArrayLike, values: list[Values]) -> Values:
        if len(values) == 1:
            return values[0]
        return np.where(np.real(x) < np.real(self.parts[1].x), *values)

    def numbers(self) -> dict[str, Values]:
        """S, f, F_TA, F_TB, F_H as the paper's screens show them, in m and N."""
        return {symbol: getattr(self, name) for symbol, name in SHOWN.items()}


def highline_from_sag(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, sag: ArrayLike
) -> Highline:
    """Return the line of a known mid-span deflection f (m), eq. (5).

    beta lies between 0 and 4 f/l, the paper's first guess: f >= l beta/4 for every beta.

    Raises:
        ValueError: a span, weight or sag that is not positive.
    """
    l, c, q, f = _checked(span, drop, weight, ("sag f", "m", sag))

    def miss(beta: Values) -> Values:
        return np.tanh(0.5 * beta) * np.sqrt(0.25 * c**2 + (0.5 * l * _sinhc(beta)) ** 2) - f

    most = 4.0 * np.real(f / l)
    return _one_part(l, c, q, bracketed(miss, 0.0 * most, (1.0 + 1e-12) * most))


def highline_from_length(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike
) -> Highline:
    """Return the line of a known length S (m), eq. (14); bracketed by eqs. (16) and (18).

    Raises:
        ValueError: a length that does not reach from A to B.
    """
    l, c, q, S = _checked(span, drop, weight, ("length S", "m", length))
    reaching(l, c, S)
    ratio = np.sqrt(S**2 - c**2) / l
    excess = np.real((S**2 - c**2 - l**2) / (l**2 * (ratio + 1.0)))  # ratio - 1
    low, high = np.log1p(excess), np.sqrt(6.0 * excess)
    beta = bracketed(lambda b: _sinhc(b) - ratio, (1.0 - 1e-12) * low, (1.0 + 1e-12) * high)
    return _one_part(l, c, q, beta)


def highline_from_tension(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, tension: ArrayLike
) -> Highline:
    """Return the taut line of a known tension F_TA (N) at the sending end, eqs. (12), (20).

    A tension above the least one belongs to two lines, a taut and a slack one; the taut one has
    beta between q l/(2 F_TA), since H <= F_TA, and the beta of the least tension.

    Raises:
        ValueError: a tension below `least_tension`, which no line between these ends has.
    """
    l, c, q, F = _checked(span, drop, weight, ("tension F_TA", "N", tension))
    slackest, least = least_tension(np.real(l), np.real(c), np.real(q))
    hold(np.isfinite(least), NO_LINE)
    hold(
        np.real(F) >= least,
        "expected a tension F_TA of {:.6g} N or more, the least between these ends, found {:g} N",
        least,
        np.real(F),
    )
    low = np.real(0.5 * q * l / F)

    def miss(beta: Values) -> Values:
        return 0.5 * q * l / beta * np.cosh(_alpha(beta, c / l)) - F

    return _one_part(l, c, q, bracketed(miss, np.minimum(low, slackest), slackest))


def least_tension(span: ArrayLike, drop: ArrayLike, weight: ArrayLike) -> tuple[Values, Values]:
    """Return beta and the tension (N) of the line whose sending end is pulled least.

    There dF_TA/dbeta = 0, which with eq. (12) is beta alpha'(beta) tanh(alpha) = 1.
    """
    l, c, q, _ = _checked(span, drop, weight, ("", "", 1.0))
    t = c / l

    def slope(beta: Values) -> Values:
        r = 1.0 / _sinhc(beta)
        rate = 1.0 + t * r * (1.0 / beta - 1.0 / np.tanh(beta)) / np.sqrt(1.0 + (t * r) ** 2)
        return beta * rate * np.tanh(_alpha(beta, t)) - 1.0

    beta = bracketed(slope, 1e-6 + 0.0 * np.real(t), 50.0 + 2.0 * np.arcsinh(np.abs(np.real(t))))
    return beta, 0.5 * q * l / beta * np.cosh(_alpha(beta, t))


def _sinhc(x: Values) -> Values:
    """sinh(x)/x, 1 at 0."""
    small = np.abs(x) < 1e-4
    safe = np.where(small, 1.0, x)
    return np.where(small, 1.0 + x**2 / 6.0, np.sinh(safe) / safe)


def _alpha(beta: Values, slope: Values) -> Values:
    """alpha of eq. (3) for the slope tan(theta) = c/l of the chord."""
    return np.arcsinh(slope / _sinhc(beta)) + beta


def _one_part(l: Values, c: Values, q: Values, beta: Values) -> Highline:
    zero = np.zeros_like(beta)
    part = Part(zero, zero, l, q, 0.5 * q * l / beta, _alpha(beta, c / l))
    return Highline(l, c, (part,))


def _checked(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, known: tuple[str, str, ArrayLike]
) -> tuple[Values, Values, Values, Values]:
    """The inputs broadcast against each other; ValueError where one is not positive."""
    name, unit, value = known
    l, c, q, k = np.broadcast_arrays(*map(np.asarray, (span, drop, weight, value)))
    positive("span l", "m", l)
    positive("weight q", "N/m", q)
    positive(name, unit, k)
    finite(**{"drop c": c})
    return l, c, q, k
