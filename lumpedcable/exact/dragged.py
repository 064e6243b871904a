"""A highline that is dragged across by a traction cable.

Two catenaries meet at their joint, where a load may hang, `lumpedcable.exact.pair`. Exact for
inextensible lines.

Under a heavy highline with a loaded joint up to three lines with the same horizontal tension H end at
B, and a line with a given tension at B need not be the only one. With both lengths given there is one:
with H and W the components of the tension at A, W downwards, w(s) the weight between A and s and
t = sqrt(H^2 + (W - w)^2),

    integral of t ds - H l - W c,

strictly convex, has its minimum there, where its gradient, the place of the end less that of B, is 0.
So all lines that end at B are a function of the length of the traction cable, along which the taut
line of a given tension is looked for, from short to long.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .checks import NO_LINE, finite, hold, positive, reaching
from .highline import Highline
from .law import Array, root, smallest
from .newton import convex_minimum
from .pair import Known, Pair
from .roots import STEP, Values, carried

__all__ = ["dragged_from_length", "dragged_from_tension"]

_TRIES = 32  # lengths of the traction cable, each so many times as long as the one before


def dragged_from_tension(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, tension: ArrayLike, load: ArrayLike = 0.0,
) -> Highline:  # fmt: skip
    """Return a highline of length S paid out from A, dragged by a traction cable from B.

    Its end L is the joint with the traction cable, `line.middle`; S = v t where it is paid out at v.
    The line is taut: with a little less of the traction cable its tension would be higher.

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
    numbers, F = _checked(span, drop, weight, length, traction_weight, tension, load)
    positive("tension of the traction cable", "N", F)
    return _line(numbers, F, tension=True)


def dragged_from_length(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, traction_length: ArrayLike, load: ArrayLike = 0.0,
) -> Highline:  # fmt: skip
    """Return the line of `dragged_from_tension` for a known length of the traction cable (m).

    Raises:
        ValueError: lengths that do not reach from A to B, or a highline that reaches beyond B.
    """
    numbers, S = _checked(span, drop, weight, length, traction_weight, traction_length, load)
    l, c, _, s, *_ = map(np.real, numbers)
    hold(
        np.real(S) > 0.0,
        "expected a highline that ends before B, and over 0 m of traction cable, found {:g} m",
        np.real(S),
    )
    reaching(l, c, np.real(S) + s, "both lengths together")
    return _line(numbers, S, tension=False)


def _checked(
    span: ArrayLike, drop: ArrayLike, weight: ArrayLike, length: ArrayLike,
    traction_weight: ArrayLike, known: ArrayLike, load: ArrayLike,
) -> tuple[Sequence[Values], Values]:  # fmt: skip
    inputs = (span, drop, weight, length, traction_weight, load, known)
    l, c, q, s, p, G, k = np.broadcast_arrays(*map(np.asarray, inputs))
    positive("span l", "m", l)
    positive("weight q", "N/m", q)
    positive("weight of the traction cable", "N/m", p)
    finite(**{"drop c": c, "length S": s, "load": G, "length or tension of the traction cable": k})
    hold(np.real(s) >= 0.0, "expected a length S of 0 m or more, found {:g} m", np.real(s))
    hold(np.real(G) >= 0.0, "expected a load of 0 N or more, found {:g} N", np.real(G))
    return (l, c, q, s, p, G), k


def _line(numbers: Sequence[Values], known: Values, tension: bool) -> Highline:
    """The lines of these numbers, all at once where that leads to them, else one by one."""
    pair, real = _pair(*numbers), [np.real(n) for n in numbers]
    found = _quick(real, np.real(known), tension)
    if found is None:
        found = np.empty((2, *np.shape(known)))
        for at in np.ndindex(np.shape(known)):
            one, value = [np.asarray(n[at]) for n in real], np.asarray(np.real(known)[at])
            quick = _quick(one, value, tension)
            found[(slice(None), *at)] = _sought(one, value, tension) if quick is None else quick
    if any(map(np.iscomplexobj, (*numbers, known))):
        x, slope = map(np.asarray, found)
        found = carried(pair.off(*_wanted(numbers, known, tension)), x, slope)
    return pair.line(np.exp(found[0]), found[1])


def _wanted(numbers: Sequence[Values], known: Values, tension: bool) -> tuple[Known, Values]:
    if tension:
        return lambda line: line.tension_b, known
    return lambda line: line.length, known + numbers[3]


def _pair(l: Values, c: Values, q: Values, s: Values, p: Values, G: Values) -> Pair:
    def meets(H: Values, slope: Values) -> Values:
        return H / q * (np.arcsinh(slope) - np.arcsinh(slope - q * s / H))

    return Pair(l, c, (q, p), G, meets)


def _quick(numbers: Sequence[Values], known: Values, tension: bool) -> Values | None:
    """log H and slope by Newton's method from a guess, which finds most lines; else None."""
    pair, (of, whole) = _pair(*numbers), _wanted(numbers, known, tension)
    start = pair.pulled(known) if tension else pair.sagging(whole)
    found = pair.at_once(of, whole, start, taut=tension)
    if found is None:
        return None
    joint, _ = pair.line(np.exp(found[0]), found[1]).middle
    return found if np.all(joint < pair.span) else None  # else it is at B or past it


# --- one line, surely ---------------------------------------------------------------------------


def _sought(numbers: Sequence[Values], known: Values, tension: bool) -> Values:
    """log H and the slope at A of one line, by the lengths of the traction cable."""
    plain = [float(n) for n in numbers]
    H, W = _taut(plain, float(known)) if tension else _held(plain, float(known))
    pair, (of, whole) = _pair(*numbers), _wanted(numbers, known, tension)
    found = np.array([np.log(H), W / H])
    better = pair.at_once(of, whole, *found)
    if better is not None and np.max(np.abs(better - found)) < 1e-4 * (1.0 + abs(found[1])):
        return better
    hold(pair.meant(pair.line(np.exp(found[0]), found[1]), of, whole), NO_LINE)
    return found


def _held(numbers: Sequence[float], traction: float, start: Array | None = None) -> Array:
    """H and W (N) of the line with so long a traction cable (m)."""
    l, c, q, s, p, G = numbers
    size = q * s + G + p * traction

    def missed(H: complex, W: complex) -> tuple[complex, complex]:
        x, z, end = _hung(H, W, q, s)
        further, lower, _ = _hung(H, end - G, p, traction)
        return x + further - l, z + lower - c

    def gradient(force: Array) -> tuple[Array, Array]:
        H, W = force
        both = np.array([missed(H + 1j * STEP, W), missed(H, W + 1j * STEP)])
        return np.real(both[0]), np.imag(both).T / STEP

    if start is None:
        start = 0.5 * size * np.array([1.0, 1.0 + c / l])
    try:
        return convex_minimum(gradient, start, s + traction, positive=1)
    except ValueError:  # lengths so far over the span that rounding hides it
        raise ValueError(NO_LINE) from None


def _hung(H: complex, W: complex, weight: float, length: float) -> tuple[complex, complex, complex]:
    """How far a part leads in x and down (m), and the W (N) at its end."""
    end = W - weight * length
    both = np.sqrt(H**2 + W**2) + np.sqrt(H**2 + end**2)
    ratio = weight * length / both
    # the first of a taut part, the second of one that hangs down and up: no near numbers subtracted
    turn = 2.0 * np.arctanh(ratio) if ratio.real < 0.9 else np.arcsinh(W / H) - np.arcsinh(end / H)
    return H / weight * turn, length * (W + end) / both, end


def _taut(numbers: Sequence[float], F: float) -> Array:
    """H and W (N) of the line with the shortest traction cable whose tension at B falls to F (N)."""
    l, c, q, s, p, G = numbers
    chord = float(np.hypot(l, c))
    shortest = max(chord - s, 0.0)
    last: Array | None = None

    def over(x: float) -> float:
        nonlocal last
        traction = shortest + np.exp(x)
        last = _held(numbers, traction, last)
        return float(np.hypot(last[0], last[1] - q * s - G - p * traction)) - F

    x, most = np.log(1e-3 * chord), np.log(2.0 * (l + abs(c) + s + 2.0 * F / p))
    while over(x) <= 0.0 and x > np.log(1e-12 * chord):
        x -= 3.0
    # a line whose tension at B is F or less lies at most F/p under it, which bounds its length
    places = np.linspace(x, most, _TRIES)
    tensions = [over(x)]
    for low, high in pairwise(places):
        tensions.append(over(high))
        if tensions[-2] > 0.0 >= tensions[-1]:
            return _held(numbers, shortest + np.exp(root(over, low, high)), last)
    k = int(np.argmin(tensions))
    low, high = places[max(k - 1, 0)], places[min(k + 1, _TRIES - 1)]
    turn, least = smallest(over, low, high)
    if tensions[0] <= 0.0:
        raise ValueError(
            "expected a highline that ends before B, for which the traction cable pulls with less "
            f"than {tensions[0] + F:.6g} N, found {F:g} N"
        )
    if least > 0.0:
        raise ValueError(
            f"expected a tension of the traction cable of {least + F:.6g} N or more, the least that "
            f"holds this line, found {F:g} N"
        )
    return _held(numbers, shortest + np.exp(root(over, low, turn)), last)
