"""Bracketed roots of analytic functions, many at once, that carry derivatives.

A derivative is taken with a complex step: with a tiny imaginary part ih in one of the inputs, the
imaginary part of a result is h times the derivative, without a difference of near numbers (J. N.
Lyness & C. B. Moler, SIAM J. Numer. Anal. 4, 1967). A root is found with the real parts; one more
Newton step, its slope frozen, carries the imaginary ones, which is the implicit function theorem.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import Values

STEP = 1e-30
"""Size of the complex step."""

_ROUNDING = 4.0 * np.finfo(float).eps
_NEAR = 1e-10  # of a root: as near as the rounding of a function that is hard to tell may leave it


def bracketed(f: Callable[[Values], Values], lo: ArrayLike, hi: ArrayLike) -> Values:
    """Return the zeros of f between lo and hi, elementwise, to rounding.

    Newton's steps, halvings where a step leaves the bracket or shrinks too slowly. f is analytic and
    works elementwise on complex arrays; its parameters may be complex, and then so are the roots.

    Args:
        f: the function; its real part has different signs at lo and hi, or is zero at one.
        lo, hi: real bounds, broadcast against each other.
    """
    lo, hi = (np.array(b, float) for b in np.broadcast_arrays(np.real(lo), np.real(hi)))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        first = f(lo)
        below, carries = np.sign(np.real(first)), np.iscomplexobj(first)
        hi = np.where(below == 0.0, lo, hi)
        x = 0.5 * (lo + hi)
        before, done = np.abs(hi - lo), np.zeros(x.shape, bool)
        for _ in range(200):
            here, slope = _told(f, x, carries)
            change = -here / slope
            same = np.sign(here) == below
            lo, hi = np.where(same, x, lo), np.where(same, hi, x)
            # a step that is no longer halved, next to the root, is the rounding of f
            small = np.abs(change) <= _NEAR * np.abs(x)
            halved = 2.0 * np.abs(change) <= before
            done |= (np.abs(change) <= _ROUNDING * np.abs(x)) | (small & ~halved)
            inside = (x + change - lo) * (x + change - hi) <= 0.0
            newton = small | (inside & halved)
            after = np.where(newton, x + change, 0.5 * (lo + hi))
            before = np.where(done, before, np.abs(after - x))
            x = np.where(done, x, after)
            if np.all(done | (before == 0.0)):
                break
        here = f(x)
        change = here / _slope(f, x, here)
    usable = np.isfinite(change) & (np.abs(change) <= 1e-6 * np.abs(x))
    return x - np.where(usable, change, 0.0)


def _told(f: Callable[[Values], Values], x: Values, carries: bool) -> tuple[Values, Values]:
    """The real part of f at x and its derivative, by one call where f carries no steps of its own."""
    if carries:
        here = f(x)
        return np.real(here), _slope(f, x, here)
    here = f(x + 1j * STEP)
    return np.real(here), np.imag(here) / STEP


def _slope(f: Callable[[Values], Values], x: Values, here: Values) -> Values:
    """The derivative of the real part of f, which is `here` at x and may carry steps of its own."""
    return np.imag(f(x + 1j * STEP) - here) / STEP


def widened(
    f: Callable[[Values], Values], start: ArrayLike, step: ArrayLike, tries: int = 200
) -> tuple[Values, Values]:
    """Return bounds between which a function that grows changes its sign.

    They start as `start` and move away from it by `step`, 2 `step`, 4 `step`, ...; a bound that was
    too near becomes the other one. Where no sign change is found the bounds are NaN.
    """
    start, step = (np.array(b, float) for b in np.broadcast_arrays(np.real(start), np.real(step)))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        away = np.where(np.real(f(start)) > 0.0, -1.0, 1.0)
        near, far, size = start, start + away * step, step
        for _ in range(tries):
            missing = np.real(f(far)) * away < 0.0
            if not np.any(missing):
                break
            near = np.where(missing, far, near)
            size = np.where(missing, 2.0 * size, size)
            far = np.where(missing, far + away * size, far)
        crossed = np.real(f(far)) * away >= 0.0
    nan = np.where(crossed, 0.0, np.nan)
    return np.minimum(near, far) + nan, np.maximum(near, far) + nan


def met(
    f: Callable[[Values, Values], Values], x: ArrayLike, y: ArrayLike, tries: int = 30
) -> tuple[Values, Values] | None:
    """Return where two functions of x and y are both zero, to rounding: Newton's method from x, y.

    Args:
        f: both functions, (2, ...), analytic and elementwise in real x and y.
        x, y: where to begin; x moves by 1 at most in a step.
        tries: most steps.

    Returns:
        The place (2, ...) and the derivatives (2, 2, ...), of each function by x and y; None where it
        does not come to rest, and where f carries complex steps of its own.
    """
    with np.errstate(all="ignore"):
        at = np.array(np.broadcast_arrays(x, y), float)
        if np.iscomplexobj(f(*at)):
            return None
        before = np.full(at.shape[1:], np.inf)
        for _ in range(tries):
            by_x, by_y = f(at[0] + 1j * STEP, at[1]), f(at[0], at[1] + 1j * STEP)
            slopes = np.stack([np.imag(by_x), np.imag(by_y)], axis=1) / STEP
            (a, b), (c, d) = slopes
            p, q = np.real(by_x)
            step = np.array([b * q - d * p, c * p - a * q]) / (a * d - b * c)
            step[0] = np.clip(step[0], -1.0, 1.0)
            at = at + step
            size = np.max(np.abs(step) / (1.0 + np.abs(at)), axis=0)
            # small steps that no longer shrink are rounding
            if np.all((size == 0.0) | ((size < 1e-12) & (size >= 0.5 * before))):
                return at, slopes
            before = size
    return None


def carried(f: Callable[[Values, Values], Values], x: Values, y: Values) -> Values:
    """Return the place (2, ...) at which both functions are zero, with derivatives, from a real one.

    One Newton step, its slopes frozen, which carries the imaginary parts of f.
    """
    here = f(x, y)
    a, c = np.imag(f(x + 1j * STEP, y) - here) / STEP
    b, d = np.imag(f(x, y + 1j * STEP) - here) / STEP
    p, q = here
    return np.array([x, y]) + np.array([b * q - d * p, c * p - a * q]) / (a * d - b * c)


def derivatives(f: Callable[..., Any], **numbers: ArrayLike) -> Mapping[str, Any]:
    """Return the derivatives of f(**numbers) with respect to each number.

    Args:
        f: a function of this package that takes complex numbers; it returns an array, or a tuple or
            dict of arrays.
        numbers: its arguments.

    Returns:
        By name, the derivative of what f returns, in the same form.
    """
    found = {}
    for name, value in numbers.items():
        moved = f(**{**numbers, name: np.asarray(value) + 1j * STEP})
        if isinstance(moved, dict):
            found[name] = {key: np.imag(part) / STEP for key, part in moved.items()}
        elif isinstance(moved, tuple):
            found[name] = tuple(np.imag(part) / STEP for part in moved)
        else:
            found[name] = np.imag(moved) / STEP
    return found
