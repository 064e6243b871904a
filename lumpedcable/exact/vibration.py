"""Small vibrations of strings, sagging cables and hanging chains; swings of a pendulum."""

import numpy as np
from scipy.special import ellipkm1, jn_zeros

from .checks import finite, hold, positive
from .law import Array, root

STANDARD_GRAVITY = 9.80665
"""Standard gravity, m/s^2."""


def string_frequencies(length: float, tension: float, mass: float, count: int) -> Array:
    """Return the first natural frequencies of a taut string, f_n = n/(2 L) sqrt(T/m), Hz.

    Args:
        length: length L, m.
        tension: T, N.
        mass: mass per length m (with added mass in water), kg/m.
        count: number of modes.

    Source: H. M. Irvine, Cable Structures (1981), chapter 3, without sag.
    """
    positive("length", "m", length)
    positive("mass per length", "kg/m", mass)
    _not_negative("tension", "N", tension)
    return np.arange(1, count + 1) / (2.0 * length) * np.sqrt(tension / mass)


def rod_frequencies(
    length: float, EA: float, mass: float, count: int, *, free_end: bool = False
) -> Array:
    """Return the axial natural frequencies of a rod in Hz, shape (count,).

    f_n = n c/(2 L) with both ends fixed, (2 n - 1) c/(4 L) with one of them free, c = sqrt(EA/m);
    L is the unstretched length (m) and m the mass per unstretched length (kg/m).

    Source: K. F. Graff, Wave Motion in Elastic Solids (1975), chapter 2.
    """
    positive("length", "m", length)
    positive("EA", "N", EA)
    positive("mass per length", "kg/m", mass)
    n = np.arange(1, count + 1)
    return (n - 0.5 * free_end) / (2.0 * length) * np.sqrt(EA / mass)


def irvine_parameter(span: float, H: float, weight: float, EA: float) -> float:
    """Return lambda^2 = (w l/H)^2 l/(H L_e/EA) of a level cable with small sag.

    L_e = l (1 + (w l/H)^2/8) is the length over which the cable stretches.

    Args:
        span: l, m.
        H: horizontal tension, N.
        weight: w per length, N/m.
        EA: axial stiffness, N.

    Source: H. M. Irvine and T. K. Caughey, Proc. R. Soc. Lond. A 341 (1974), 299-315.
    """
    positive("span", "m", span)
    positive("horizontal tension H", "N", H)
    positive("EA", "N", EA)
    finite(weight=weight)
    slope = weight * span / H
    return slope**2 * EA / (H * (1.0 + slope**2 / 8.0))


def sagged_cable_frequencies(
    span: float, H: float, mass: float, parameter: float, count: int
) -> tuple[Array, Array]:
    """Return the in-plane frequencies of a sagging cable in Hz: (symmetric, antisymmetric).

    Antisymmetric: omega l sqrt(m/H) = 2 n pi. Symmetric: the roots of

        tan(W/2) = W/2 - (4/lambda^2) (W/2)^3,    W = omega l sqrt(m/H).

    Out of its plane the cable swings like a string (`string_frequencies`).

    Args:
        span: l, m.
        H: horizontal tension, N.
        mass: mass per length, kg/m.
        parameter: Irvine's lambda^2, see `irvine_parameter`; 0 is a taut string.
        count: number of modes of each kind.

    Source: H. M. Irvine and T. K. Caughey, Proc. R. Soc. Lond. A 341 (1974), 299-315.
    """
    positive("span", "m", span)
    positive("horizontal tension H", "N", H)
    positive("mass per length", "kg/m", mass)
    finite(**{"lambda^2": parameter})
    if parameter < 0.0:
        raise ValueError(f"expected lambda^2 of 0 or more, found {parameter:g}")
    unit = np.sqrt(H / mass) / (2.0 * np.pi * span)

    def characteristic(half: float) -> float:
        # Times lambda^2 cos: no poles, and the taut string is no special case of the sign.
        return parameter * np.sin(half) - np.cos(half) * (parameter * half - 4.0 * half**3)

    n = np.arange(1, count + 1)
    if parameter < 1e-10:
        halves = (n - 0.5) * np.pi
    else:
        # One root between two odd multiples of pi/2: tan rises there faster than the cubic.
        halves = np.array([root(characteristic, (k - 0.5) * np.pi, (k + 0.5) * np.pi) for k in n])
    return 2.0 * halves * unit, 2.0 * np.pi * n * unit


def hanging_chain_frequencies(
    length: float, count: int, gravity: float = STANDARD_GRAVITY
) -> Array:
    """Return the swinging frequencies of a chain hanging from one end, f_n = j_n/(4 pi) sqrt(g/L).

    j_n are the zeros of the Bessel function J0. In water gravity is g times wet weight over
    (dry plus added) mass.

    Args:
        length: L, m.
        count: number of modes.
        gravity: m/s^2.

    Source: D. Bernoulli (1733), see G. N. Watson, Theory of Bessel Functions (1944), chapter 1.
    """
    positive("length", "m", length)
    positive("gravity", "m/s^2", gravity)
    return jn_zeros(0, count) * np.sqrt(gravity / length) / (4.0 * np.pi)


def pendulum_period(
    length: float, amplitude: float = 0.0, gravity: float = STANDARD_GRAVITY
) -> float:
    """Return the period of a point mass on a rigid weightless rod, T = 4 sqrt(L/g) K(m), s.

    K is the complete elliptic integral of the first kind, m = sin^2(amplitude/2).

    Args:
        length: L, m.
        amplitude: largest angle from the vertical, rad; 0 is the limit 2 pi sqrt(L/g).
        gravity: m/s^2.

    Raises:
        ValueError: unless 0 <= amplitude < pi.

    Source: L. D. Landau and E. M. Lifshitz, Mechanics (1976), section 11, problem 1.
    """
    positive("length", "m", length)
    positive("gravity", "m/s^2", gravity)
    if not 0.0 <= amplitude < np.pi:
        raise ValueError(f"expected an amplitude between 0 and pi, found {amplitude:g} rad")
    # by 1 - m, which is not lost next to the upright rod
    return 4.0 * float(np.sqrt(length / gravity) * ellipkm1(np.cos(0.5 * amplitude) ** 2))


def elastic_pendulum_periods(
    length: float, EA: float, mass: float, gravity: float = STANDARD_GRAVITY
) -> tuple[float, float]:
    """Return the small-amplitude periods of a heavy bob on a light elastic line, s.

    The swing, 2 pi sqrt(L'/g) with the stretched length L' = L (1 + M g/EA), and the bounce,
    2 pi sqrt(M L/EA); at first order they do not mix.

    Args:
        length: unstretched length L, m.
        EA: axial stiffness, N.
        mass: bob M, kg.
        gravity: m/s^2.

    Source: linearised Lagrangian of the elastic pendulum, L. D. Landau and E. M. Lifshitz,
    Mechanics (1976), section 23.
    """
    positive("length", "m", length)
    positive("mass", "kg", mass)
    positive("gravity", "m/s^2", gravity)
    hold(np.asarray(EA > 0.0), "expected a positive EA, found {:g} N", np.asarray(EA))
    stretched = length * (1.0 + mass * gravity / EA)
    swing = 2.0 * np.pi * float(np.sqrt(stretched / gravity))
    return swing, 2.0 * np.pi * float(np.sqrt(mass * length / EA))


def _not_negative(name: str, unit: str, value: float) -> None:
    finite(**{name: value})
    hold(
        np.asarray(value) >= 0.0,
        f"expected a {name} of 0 {unit} or more, found {{:g}} {unit}",
        np.asarray(value),
    )
