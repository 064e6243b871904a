"""Beams: deflection under uniform load, natural frequencies, and large rotations."""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipeinc, ellipkinc, ellipkm1

from .checks import finite, positive
from .law import Array, root

Ends = Literal["cantilever", "pinned", "clamped", "free"]
"""How a beam is held: clamped-free, pinned-pinned, clamped-clamped, free-free."""

_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(40)


def cantilever_deflection(x: ArrayLike, length: float, load: float, EI: float) -> Array:
    """Return y = q x^2 (6 L^2 - 4 L x + x^2)/(24 EI), m, of a cantilever under uniform load.

    Args:
        x: distance from the clamped end, m.
        length: L, m.
        load: q, N/m.
        EI: bending stiffness, N m^2.

    Source: W. C. Young, Roark's Formulas for Stress and Strain, 7th ed. (2002), table 8.1, case 2a.
    """
    _checked(length, EI)
    finite(load=load)
    x = np.asarray(x, float)
    return load * x**2 * (6.0 * length**2 - 4.0 * length * x + x**2) / (24.0 * EI)


def simply_supported_deflection(x: ArrayLike, length: float, load: float, EI: float) -> Array:
    """Return y = q x (L^3 - 2 L x^2 + x^3)/(24 EI), m, of a beam on two supports.

    Args:
        x: distance from one support, m.
        length: L, m.
        load: q, N/m.
        EI: bending stiffness, N m^2.

    Source: W. C. Young, Roark's Formulas for Stress and Strain, 7th ed. (2002), table 8.1, case 2e.
    """
    _checked(length, EI)
    finite(load=load)
    x = np.asarray(x, float)
    return load * x * (length**3 - 2.0 * length * x**2 + x**3) / (24.0 * EI)


def beam_frequencies(
    length: float, EI: float, mass: float, count: int, ends: Ends = "cantilever"
) -> Array:
    """Return bending frequencies of an Euler-Bernoulli beam, f = b^2/(2 pi L^2) sqrt(EI/m), Hz.

    b are the roots of cos b cosh b = -1 (cantilever) or 1 (clamped; free, without the rigid
    modes), or n pi (pinned).

    Args:
        length: L, m.
        EI: bending stiffness, N m^2.
        mass: mass per length m, kg/m.
        count: number of modes.
        ends: "cantilever", "pinned", "clamped" or "free".

    Source: K. F. Graff, Wave Motion in Elastic Solids (1975), chapter 3.
    """
    _checked(length, EI)
    positive("mass per length", "kg/m", mass)
    n = np.arange(1, count + 1)
    if ends == "pinned":
        b = n * np.pi
    elif ends == "cantilever":
        b = np.array([_beam_root(-1.0, (k - 0.5) * np.pi) for k in n])
    elif ends in ("clamped", "free"):
        b = np.array([_beam_root(1.0, (k + 0.5) * np.pi) for k in n])
    else:
        raise ValueError(f"expected ends cantilever, pinned, clamped or free, found {ends!r}")
    return b**2 / (2.0 * np.pi * length**2) * np.sqrt(EI / mass)


def _beam_root(value: float, near: float) -> float:
    # 1/cosh b without overflow
    return root(
        lambda b: np.cos(b) - 2.0 * value * np.exp(-b) / (1.0 + np.exp(-2.0 * b)),
        near - 0.6,
        near + 0.6,
    )


def tensioned_beam_frequencies(
    length: float, tension: float, EI: float, mass: float, count: int
) -> Array:
    """Return bending frequencies of a pinned beam under tension, Hz, shape (count,).

    f_n = n/(2 L) sqrt(T/m + (n pi/L)^2 EI/m): a string that is stiff, or a beam that is taut.

    Args:
        length: L, m.
        tension: T, N; negative in compression, down to Euler's load.
        EI: bending stiffness, N m^2.
        mass: mass per length m, kg/m.
        count: number of modes.

    Raises:
        ValueError: if the beam buckles.

    Source: K. F. Graff, Wave Motion in Elastic Solids (1975), chapter 3.
    """
    _checked(length, EI)
    positive("mass per length", "kg/m", mass)
    finite(tension=tension)
    k = np.arange(1, count + 1) * (np.pi / length)
    stiffness = tension + k**2 * EI
    if np.any(stiffness <= 0.0):
        raise ValueError(
            f"the beam buckles under {-tension:g} N, Euler's load is {k[0] ** 2 * EI:g} N"
        )
    return np.asarray(k / (2.0 * np.pi) * np.sqrt(stiffness / mass), float)


def rolled_beam(s: ArrayLike, moment: float, EI: float) -> tuple[Array, Array]:
    """Return x(s), y(s), m, of a cantilever bent into an arc by a moment at its end.

    The curvature is M/EI everywhere; 2 pi EI/L closes the circle.

    Args:
        s: distance from the clamped end along the beam, m.
        moment: M, N m.
        EI: bending stiffness, N m^2.
    """
    positive("bending stiffness EI", "N m^2", EI)
    finite(moment=moment)
    s = np.asarray(s, float)
    half = 0.5 * s * moment / EI
    # sin(k s)/k and (1 - cos(k s))/k, finite for a straight beam.
    chord = s * np.sinc(half / np.pi)
    return chord * np.cos(half), chord * np.sin(half)


def tip_loaded_cantilever(length: float, load: float, EI: float) -> tuple[float, float, float]:
    """Return tip x (m), tip deflection (m) and tip angle (rad) at any size of deflection.

    An inextensible cantilever with a load P that keeps its direction, across the straight beam.
    With a = P L^2/EI, k^2 = (1 + sin phi)/2 for the tip angle phi, and sin t = 1/(k sqrt 2),

        sqrt(a) = K(k) - F(t, k),   y/L = 1 - 2 (E(k) - E(t, k))/sqrt(a),
        x/L = sqrt(2 sin(phi)/a).

    Args:
        length: L, m.
        load: P, N, positive.
        EI: bending stiffness, N m^2.

    Source: K. E. Bisshopp and D. C. Drucker, Quart. Appl. Math. 3 (1945), 272-275.
    """
    _checked(length, EI)
    positive("load", "N", load)
    a = load * length**2 / EI
    phi, y = _little_bent(a) if a < 1.0 else _much_bent(a)
    return length * float(np.sqrt(2.0 * np.sin(phi) / a)), length * y, phi


def _checked(length: float, EI: float) -> None:
    positive("length", "m", length)
    positive("bending stiffness EI", "N m^2", EI)


def _little_bent(a: float) -> tuple[float, float]:
    """phi and y/L for a < 1, by Gauss's rule, where K and F, E and E(t) are too near each other.

    With u = pi/2 - t from 0 to atan sqrt(sin phi), sin(theta) = sin phi - 2 k^2 sin(u)^2 is the slope
    along the beam and du/(sqrt(a) sqrt(1 - k^2 cos(u)^2)) its length.
    """

    def along(phi: float) -> tuple[Array, Array]:
        m = 0.5 * (1.0 + np.sin(phi))
        half = 0.5 * np.arctan(np.sqrt(np.sin(phi)))
        u = half * (1.0 + _GAUSS_X)
        each = half * _GAUSS_W / np.sqrt(1.0 - m * np.cos(u) ** 2)
        return each, np.sin(phi) - 2.0 * m * np.sin(u) ** 2

    phi = root(lambda phi: float(np.sum(along(phi)[0])) - np.sqrt(a), 0.2 * a, 0.6 * a)
    each, slope = along(phi)
    return phi, float(np.sum(each * slope) / np.sqrt(a))


def _much_bent(a: float) -> tuple[float, float]:
    """phi and y/L for a of 1 or more, with d = pi/2 - phi on a scale of its logarithm.

    d is some 3.3 exp(-sqrt(a)): beyond sqrt(a) = 40 phi is pi/2 to rounding and k = 1.
    """

    def start(d: float) -> tuple[float, float]:
        m = np.cos(0.5 * d) ** 2
        return m, float(np.arcsin(1.0 / np.sqrt(2.0 * m)))

    def miss(log_d: float) -> float:
        d = np.exp(log_d)
        m, t = start(d)
        return float(ellipkm1(np.sin(0.5 * d) ** 2) - ellipkinc(t, m) - np.sqrt(a))

    d = float(np.exp(root(miss, -45.0, 0.25))) if a < 1600.0 else 0.0
    m, t = start(d)
    return 0.5 * np.pi - d, 1.0 - 2.0 * float(ellipe(m) - ellipeinc(t, m)) / float(np.sqrt(a))
