"""A highline that carries a load, and one that is dragged across by a traction cable.

Two catenaries share their horizontal tension H and meet at a point K, where a load G hangs (N) or
the line passes into another one. With the slopes of `lumpedcable.exact.highline`, downwards positive,
the upward pulls of both parts carry the load: H (u- - u+) = G, u- and u+ the slopes left and right of
K. For a given H the slope at A follows from the one condition that the line ends at B, and H from what
is known of the line. Exact for an inextensible line.

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

from .highline import SHOWN, Highline, Part, hold, positive
from .roots import Values, bracketed, met, widened

__all__ = [
    "StraightHighline",
    "dragged_from_length",
    "dragged_from_tension",
    "loaded_from_length",
    "loaded_from_tension",
    "straight_from_length",
    "straight_from_tension",
]

Meets = Callable[[Values, Values], Values]
"""H (N) and the slope at A to the x (m) at which the first part ends."""


@dataclass(frozen=True)
class _Pair:
    """What is known of two catenaries between A and B but for H and one more number."""

    span: Values
    drop: Values
    weights: tuple[Values, Values]
    load: Values
    meets: Meets

    def line(self, H: Values, slope: Values) -> Highline:
        """The line that leaves A with a slope, wherever it ends."""
        reach = self.meets(H, slope)
        zero = np.zeros_like(reach)
        first = Part(zero, zero, reach, self.weights[0], H, np.arcsinh(slope))
        beyond = np.arcsinh(np.sinh(first.end_angle) - self.load / H)
        second = Part(reach, -first.drop, self.span - reach, self.weights[1], H, beyond)
        return Highline(self.span, self.drop, (first, second))

    def closed(self, H: Values) -> Highline:
        """The line that ends at B under the horizontal tension H (N)."""

        def below(slope: Values) -> Values:
            line = self.line(H, slope)
            return line.parts[0].drop + line.parts[1].drop - self.drop

        size = np.real((self.load + (self.weights[0] + self.weights[1]) * self.span) / H)
        start = np.real(self.drop / self.span) + 0.5 * size
        return self.line(H, bracketed(below, *widened(below, start, 0.1 + 0.1 * size)))

    def of_length(self, length: Callable[[Highline], Values], known: Values) -> Highline:
        """The line with a known length (m), which falls as H grows."""
        sag = np.sqrt(np.maximum(np.real(known - self.span) * np.real(known + self.span), 1e-300))
        weight = np.real(self.load + self.weights[0] * self.span)
        start = np.log(np.real(0.25 * weight * self.span) / sag)
        line = self._at_once(lambda line: length(line) - known, start)
        if line is not None:
            return line
        miss = self._of_log(lambda line: known - length(line))
        x = bracketed(miss, *widened(miss, start, 0.25 + 0.0 * start))
        line = self.closed(np.exp(x))
        hold(np.real(np.abs(length(line) / known - 1.0)) < 1e-9, "found no line of this length")
        return _found(line)

    def of_tension(
        self, tension: Callable[[Highline], Values], known: Values, name: str
    ) -> Highline:
        """The taut line with a known tension (N) at one end; there H is at most that."""
        hung = np.real(self.load + (self.weights[0] + self.weights[1]) * self.span)
        start = 0.5 * np.log(np.maximum(np.real(known) ** 2 - 0.25 * hung**2, 1e-300))
        line = self._at_once(lambda line: tension(line) - known, start, rises=True)
        if line is not None:
            return line
        miss = self._of_log(lambda line: tension(line) - known)
        top = np.log(np.real(known)) + 1e-12
        low, least = _turning(lambda x: np.real(miss(x)), top)
        told = least + np.real(known)
        hold(
            least <= 0.0,
            f"expected a tension {name} of {{:.6g}} N or more, the least that holds this line, "
            "found {:g} N",
            told,
            np.real(known),
        )
        return _found(self.closed(np.exp(bracketed(miss, low, top))))

    def _at_once(
        self, miss: Callable[[Highline], Values], x: Values, rises: bool = False
    ) -> Highline | None:
        """The line that ends at B and for which `miss` is 0: Newton's method for both, from log H = x.

        Tens of times as quick as one root inside another, to which it leaves what it does not find:
        None where it comes to no line, where `miss` should rise with H and falls, and where the
        numbers carry derivatives.
        """

        def off(x: Values, slope: Values) -> Values:
            line = self.line(np.exp(x), slope)
            end = line.parts[0].drop + line.parts[1].drop - self.drop
            return np.array([end, miss(line)])

        hung = np.real(self.load + (self.weights[0] + self.weights[1]) * self.span)
        slope = np.real(self.drop / self.span) + 0.5 * hung / np.exp(x)
        found = met(off, x, slope)
        if found is None:
            return None
        (x, slope), ((a, b), (c, d)) = found
        return self.line(np.exp(x), slope) if not rises or np.all(c - a * d / b > 0.0) else None

    def _of_log(self, value: Callable[[Highline], Values]) -> Callable[[Values], Values]:
        return lambda x: value(self.closed(np.exp(x)))


def _found(line: Highline) -> Highline:
    hold(np.isfinite(np.real(line.length)), "found no line for these numbers")
    return line


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
        ValueError: a load off the span, a line that is too short, a weight that is not positive.
    """
    l, c, q, G, x, S = _checked(span, drop, weight, load, place, length)
    hold(
        np.real(S) > np.hypot(np.real(l), np.real(c)),
        "expected a length S over the distance of the ends, {:g} m, found {:g} m",
        np.hypot(np.real(l), np.real(c)),
        np.real(S),
    )
    return _at(l, c, q, G, x).of_length(lambda line: line.length, S)


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
    return _at(l, c, q, G, x).of_tension(lambda line: line.tension_a, F, "F_TA")


def _at(l: Values, c: Values, q: Values, G: Values, x: Values) -> _Pair:
    return _Pair(l, c, (q, q), G, lambda H, slope: x + 0.0 * (H + slope))


def _checked(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, load: ArrayLike, place: ArrayLike,
    known: ArrayLike,
) -> list[Values]:  # fmt: skip
    """The inputs of a loaded line, broadcast against each other and looked at."""
    found = list(np.broadcast_arrays(*map(np.asarray, (span, drop, weight, load, place, known))))
    l, _, q, G, x, _ = found
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


def dragged_from_tension(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, tension: ArrayLike, load: ArrayLike = 0.0,
) -> Highline:  # fmt: skip
    """Return a highline of length S paid out from A, dragged by a traction cable from B.

    Its end L is the joint with the traction cable, `line.middle`; S = v t where it is paid out at v.

    Args:
        span, drop: of B from A, m.
        weight: weight per length of the highline, N/m.
        length: its length S, m.
        traction_weight: weight per length of the traction cable, N/m.
        tension: tension of the traction cable at B, N.
        load: weight of the joint, N.

    Raises:
        ValueError: a tension too low to hold the line, or a length that reaches beyond B.
    """
    pair, F = _dragged(span, drop, weight, length, traction_weight, tension, load)
    positive("tension of the traction cable", "N", F)
    return _reaching(pair.of_tension(lambda line: line.tension_b, F, "of the traction cable"))


def dragged_from_length(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, traction_length: ArrayLike, load: ArrayLike = 0.0,
) -> Highline:  # fmt: skip
    """Return the line of `dragged_from_tension` for a known length of the traction cable (m).

    Raises:
        ValueError: lengths that do not reach from A to B, or a highline that reaches beyond B.
    """
    pair, S = _dragged(span, drop, weight, length, traction_weight, traction_length, load)
    chord, whole = np.hypot(np.real(pair.span), np.real(pair.drop)), np.real(S) + np.real(length)
    hold(
        whole > chord,
        "expected both lengths together over the distance of the ends, {:g} m, found {:g} m",
        chord,
        whole,
    )
    return _reaching(pair.of_length(lambda line: line.length, S + np.asarray(length)))


def _dragged(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, known: ArrayLike, load: ArrayLike,
) -> tuple[_Pair, Values]:  # fmt: skip
    inputs = (span, drop, weight, length, traction_weight, known, load)
    l, c, q, s, p, k, G = np.broadcast_arrays(*map(np.asarray, inputs))
    positive("span l", "m", l)
    positive("weight q", "N/m", q)
    positive("weight of the traction cable", "N/m", p)
    hold(np.real(s) >= 0.0, "expected a length S of 0 m or more, found {:g} m", np.real(s))
    hold(np.real(G) >= 0.0, "expected a load of 0 N or more, found {:g} N", np.real(G))

    def meets(H: Values, slope: Values) -> Values:
        return H / q * (np.arcsinh(slope) - np.arcsinh(slope - q * s / H))

    return _Pair(l, c, (q, p), G, meets), k


def _reaching(line: Highline) -> Highline:
    x = np.real(line.middle[0])
    hold(
        x < np.real(line.span),
        "expected a highline that ends before B, at {:g} m, found its joint at {:.6g} m",
        np.real(line.span),
        x,
    )
    return line


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
    hold(
        np.real(S) > np.hypot(np.real(l), np.real(c)),
        "expected a length S over the distance of the ends, {:g} m, found {:g} m",
        np.hypot(np.real(l), np.real(c)),
        np.real(S),
    )
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

    Raises:
        ValueError: a load off the span or not positive, a tension too low to carry it.
    """
    l, c, _, G, x, F = _checked(span, drop, 1.0, load, place, tension)
    positive("load G", "N", G)
    up, t = G * (1.0 - x / l), c / l
    hold(
        np.real(F) > np.real(up),
        "expected a tension F_TA over {:.6g} N, what the load hangs on A, found {:g} N",
        np.real(up),
        np.real(F),
    )
    H = (np.sqrt(F**2 * (1.0 + t**2) - up**2) - up * t) / (1.0 + t**2)
    return StraightHighline(l, c, G, x, G * x * (l - x) / (l * H), H)
