"""A highline that carries a load at a known place.

Two catenaries meet at the load G (N), `lumpedcable.exact.pair`. For a given horizontal tension H the
slope at A follows from the one condition that the line ends at B, and H from what is known of the
line. Exact for an inextensible line.

`StraightHighline` is the approximation of W. Lun, Q. Li & H. Hou (2018), section 4, eqs. (23)-(33):
a line without weight, straight on both sides of its cargo. Misprints there: the first term of eq. (26)
wants its sign, f_K = (y_K - y_B) + |x_K - x_B| tan(theta), since K may lie above B; and the list under
its Fig. 4 swaps the components along the chord and across. For its cable (62.5 m of 40 N/m over 60 m
with 20 kN) it is 5.8 to 6.5 % low in tension and 2 to 8 mm off in place.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import NO_LINE, finite, hold, positive, reaching
from .highline import SHOWN, Highline
from .pair import Pair
from .roots import Values, bracketed, widened

__all__ = [
    "StraightHighline",
    "loaded_from_length",
    "loaded_from_tension",
    "straight_from_length",
    "straight_from_tension",
]


LONGEST = 100.0
"""Times the distance of its ends: a longer line is two that hang straight down, which rounding hides."""


def _closed(pair: Pair, H: Values) -> Highline:
    """The line that ends at B under the horizontal tension H (N); one, as the load's place is known."""
    size = np.real((pair.load + (pair.weights[0] + pair.weights[1]) * pair.span) / H)
    start = np.real(pair.drop / pair.span) + 0.5 * size

    def below(slope: Values) -> Values:
        return pair.below(pair.line(H, slope))

    return pair.line(H, bracketed(below, *widened(below, start, 0.1 + 0.1 * size)))


def _of_length(pair: Pair, known: Values) -> Highline:
    """The line of a known length (m), which falls as H grows."""
    start = pair.sagging(known)
    found = pair.at_once(_length, known, start)
    if found is not None:
        return pair.line(np.exp(found[0]), found[1])

    def miss(x: Values) -> Values:
        return known - _closed(pair, np.exp(x)).length

    x = bracketed(miss, *widened(miss, start, 0.25 + 0.0 * start))
    line = _closed(pair, np.exp(x))
    hold(pair.meant(line, _length, known), "found no line of this length")
    return line


def _of_tension(pair: Pair, known: Values) -> Highline:
    """The taut line with a known tension (N) at A; there H is at most that."""
    found = pair.at_once(_tension, known, pair.pulled(known), taut=True)
    if found is not None:
        return pair.line(np.exp(found[0]), found[1])

    def miss(x: Values) -> Values:
        return _closed(pair, np.exp(x)).tension_a - known

    top = np.log(np.real(known)) + 1e-12
    low, least = _turning(lambda x: np.real(miss(x)), top)
    hold(np.isfinite(least), NO_LINE)
    hold(
        least <= 0.0,
        "expected a tension F_TA of {:.6g} N or more, the least that holds this line, found {:g} N",
        least + np.real(known),
        np.real(known),
    )
    line = _closed(pair, np.exp(bracketed(miss, low, top)))
    hold(pair.meant(line, _tension, known), NO_LINE)
    return line


def _length(line: Highline) -> Values:
    return line.length


def _tension(line: Highline) -> Values:
    return line.tension_a


def _turning(f: Callable[[Values], Values], top: Values) -> tuple[Values, Values]:
    """Walk down from `top`, where f > 0, to a point with f <= 0; else to the minimum of f.

    Returns the places and the values there.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        a = b = c = np.array(top, float)
        value = f(c)
        step = np.full_like(c, 0.05)
        for _ in range(60):
            trial = a - step
            there = f(trial)
            walking = (value > 0.0) & (a == b)
            falls = there < value
            c = np.where(walking & falls, b, c)
            b, value = (np.where(walking & falls, *n) for n in ((trial, b), (there, value)))
            a = np.where(walking, trial, a)
            step = 1.5 * step
            if not np.any((value > 0.0) & (a == b)):
                break
        ratio = 0.5 * (np.sqrt(5.0) - 1.0)
        for _ in range(60 if np.any(value > 0.0) else 0):
            left = np.abs(b - a) > np.abs(c - b)  # try in the longer half
            trial = np.where(left, a + ratio * (b - a), c - ratio * (c - b))
            there = f(trial)
            lower = there < value
            a, c = (
                np.where(left, np.where(lower, a, trial), np.where(lower, b, a)),
                np.where(left, np.where(lower, b, c), np.where(lower, c, trial)),
            )
            b, value = np.where(lower, trial, b), np.where(lower, there, value)
    return b, value


def loaded_from_length(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, load: ArrayLike, place: ArrayLike,
    length: ArrayLike,
) -> Highline:  # fmt: skip
    """Return the line of a known length S (m) with a load G (N) at x = place (m).

    Raises:
        ValueError: a load off the span, a line that is too short or a hundred times too long, a weight
            that is not positive.
    """
    l, c, q, G, x, S = _checked(span, drop, weight, load, place, length)
    reaching(l, c, S)
    longest, found = LONGEST * np.hypot(np.real(l), np.real(c)), np.real(S)
    hold(found <= longest, "expected a length S of {:g} m or less, found {:g} m", longest, found)
    return _of_length(_at(l, c, q, G, x), S)


def loaded_from_tension(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, load: ArrayLike, place: ArrayLike,
    tension: ArrayLike,
) -> Highline:  # fmt: skip
    """Return the taut line of a known tension F_TA (N) with a load G (N) at x = place (m).

    Raises:
        ValueError: a load off the span, a tension too low to carry it, a weight not positive.
    """
    l, c, q, G, x, F = _checked(span, drop, weight, load, place, tension)
    positive("tension F_TA", "N", F)
    return _of_tension(_at(l, c, q, G, x), F)


def _at(l: Values, c: Values, q: Values, G: Values, x: Values) -> Pair:
    return Pair(l, c, (q, q), G, lambda H, slope: x + 0.0 * (H + slope))


def _checked(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, load: ArrayLike, place: ArrayLike,
    known: ArrayLike,
) -> list[Values]:  # fmt: skip
    """The inputs of a loaded line, broadcast against each other and looked at."""
    found = list(np.broadcast_arrays(*map(np.asarray, (span, drop, weight, load, place, known))))
    l, c, q, G, x, k = found
    finite(**{"drop c": c, "load G": G, "length or tension": k})
    positive("span l", "m", l)
    positive("weight q", "N/m", q)
    hold(np.real(G) >= 0.0, "expected a load G of 0 N or more, found {:g} N", np.real(G))
    hold(
        (np.real(x) > 0.0) & (np.real(x) < np.real(l)),
        "expected the cargo on the span, between 0 m and {:g} m, found {:g} m",
        np.real(l),
        np.real(x),
    )
    return found


@dataclass(frozen=True)
class StraightHighline:
    """The straight-segment approximation: no weight but the load, straight to it and from it.

    Attributes:
        span, drop: of B from A, m.
        load: G, N.
        place: x of the load, m.
        sag: its depth f_K under the chord, m.
        horizontal: F_H = M_K/f_K, N (eq. (25)).
    """

    span: Values
    drop: Values
    load: Values
    place: Values
    sag: Values
    horizontal: Values

    @property
    def middle(self) -> tuple[Values, Values]:
        """x and z of the load, m."""
        return self.place, -self.sag - self.place * self.drop / self.span

    @property
    def length(self) -> Values:
        """S of eq. (33), m."""
        x, z = self.middle
        return np.sqrt(x**2 + z**2) + np.sqrt((self.span - x) ** 2 + (self.drop + z) ** 2)

    @property
    def tension_a(self) -> Values:
        """F_TA of eqs. (24), (31), N."""
        up = self.load * (1.0 - self.place / self.span)
        return np.sqrt((up + self.horizontal * self.drop / self.span) ** 2 + self.horizontal**2)

    @property
    def tension_b(self) -> Values:
        """F_TB of eqs. (24), (31), N."""
        up = self.load * self.place / self.span
        return np.sqrt((up - self.horizontal * self.drop / self.span) ** 2 + self.horizontal**2)

    def height(self, x: ArrayLike) -> Values:
        """Return z at x, m (eq. (32))."""
        at, z = self.middle
        x = np.asarray(x)
        before, after = z / at, (z + self.drop) / (at - self.span)
        return np.where(np.real(x) < np.real(at), before * x, after * (x - self.span) - self.drop)

    def numbers(self) -> dict[str, Values]:
        """S, f, F_TA, F_TB, F_H in m and N."""
        return {symbol: getattr(self, name) for symbol, name in SHOWN.items()}


def straight_from_length(
    span: ArrayLike, drop: ArrayLike, load: ArrayLike, place: ArrayLike, length: ArrayLike
) -> StraightHighline:
    """Return the straight segments of a known length S (m); the load lies on an ellipse about A, B.

    Raises:
        ValueError: a load off the span or not positive, a line that is too short.
    """
    l, c, _, G, x, S = _checked(span, drop, 1.0, load, place, length)
    positive("load G", "N", G)
    reaching(l, c, S)
    # with d the length from A to the load: d + d' = S and d^2 - d'^2 = x^2 - (l - x)^2 - c^2 + 2 c y
    D = 0.5 * S + 0.5 * (x**2 - (l - x) ** 2 - c**2) / S
    r = c / S
    y = (r * D + np.sqrt(D**2 - (1.0 - r**2) * x**2)) / (1.0 - r**2)
    sag = y - x * c / l
    return StraightHighline(l, c, G, x, sag, G * x * (l - x) / (l * sag))


def straight_from_tension(
    span: ArrayLike, drop: ArrayLike, load: ArrayLike, place: ArrayLike, tension: ArrayLike
) -> StraightHighline:
    """Return the straight segments of a known tension F_TA (N); F_H solves a quadratic.

    Where B lies above A two lines may have this tension; this is the taut one.

    Raises:
        ValueError: a load off the span or not positive, a tension too low to carry it.
    """
    l, c, _, G, x, F = _checked(span, drop, 1.0, load, place, tension)
    positive("load G", "N", G)
    up, t = G * (1.0 - x / l), c / l
    # F_TA of eq. (24) is least at F_H = 0 where B lies below A, else at F_H = -up t/(1 + t^2)
    steep = np.sqrt(1.0 + np.minimum(np.real(t), 0.0) ** 2)
    hold(
        np.real(F) * steep > np.real(up),
        "expected a tension F_TA over {:.6g} N, the least that holds the load, found {:g} N",
        np.real(up) / steep,
        np.real(F),
    )
    width = np.sqrt(1.0 + t**2)
    H = (np.sqrt((F * width - up) * (F * width + up)) - up * t) / width**2
    return StraightHighline(l, c, G, x, G * x * (l - x) / (l * H), H)
