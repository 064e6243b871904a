"""What every self-similar release wave has to satisfy, from the law alone.

Each checker returns a defect, zero for a right answer; the tests also show it a wrong one.
"""

from itertools import pairwise

import numpy as np


def rankine_hugoniot(law, mass, pieces):
    """Largest relative defect of the jump conditions m s^2 [e] = [T], [w] = -s [e] (speed s)."""
    worst = 0.0
    for p in pieces:
        if p.kind == "rarefaction":
            continue
        de, dT = p.strain_hi - p.strain_lo, float(law(p.strain_hi) - law(p.strain_lo))
        dw = p.velocity_lo - p.velocity_hi
        worst = max(worst, abs(mass * p.speed_hi**2 * de / dT - 1.0))
        worst = max(worst, abs(dw / (p.speed_hi * de) - 1.0), abs(p.speed_lo / p.speed_hi - 1.0))
    return worst


def oleinik(law, pieces):
    """How far the law dips below the chord of a jump (condition E), over the tension jump."""
    worst = 0.0
    for p in pieces:
        if p.kind == "rarefaction":
            continue
        e = np.linspace(p.strain_lo, p.strain_hi, 2001)
        chord = law(e[0]) + (law(e[-1]) - law(e[0])) * (e - e[0]) / (e[-1] - e[0])
        worst = max(worst, float(np.max(chord - law(e))) / float(law(e[-1]) - law(e[0])))
    return worst


def order(pieces):
    """How far a wave is ahead of the one in front of it, m/s; heads must not trail rears."""
    worst = 0.0
    for p in pieces:
        worst = max(worst, p.speed_lo - p.speed_hi)
    for ahead, behind in pairwise(pieces):
        worst = max(worst, behind.speed_hi - ahead.speed_lo)
    return worst


def characteristics(law_slope, mass, wave, points=9):
    """Relative defect of T'(e(xi)) = m xi^2 inside the fans."""
    worst = 0.0
    for p in wave.pieces:
        if p.kind == "rarefaction":
            xi = p.speed_lo + (p.speed_hi - p.speed_lo) * np.linspace(0.05, 0.95, points)
            defect = law_slope(wave.strain(xi)) / (mass * xi**2) - 1.0
            worst = max(worst, float(np.max(np.abs(defect))))
    return worst


def gauss(f, a, b, panels=40):
    """Composite Gauss-Legendre of a vectorised f; a and b may be arrays."""
    x, weight = np.polynomial.legendre.leggauss(12)
    a, b = np.asarray(a, float)[..., None, None], np.asarray(b, float)[..., None, None]
    half = 0.5 * (b - a) / panels
    middle = a + (2.0 * np.arange(panels)[:, None] + 1.0) * half
    return np.sum(weight * half * f(middle + half * x), axis=(-2, -1))


def _over_xi(wave, f):
    speeds = sorted({0.0, *(v for p in wave.pieces for v in (p.speed_lo, p.speed_hi))})
    return sum(float(gauss(f, a, b)) for a, b in pairwise(speeds))


def momentum(law, mass, wave):
    """Relative defect of the impulse: integral of m w dxi = T(e0) - F."""
    impulse = float(law(wave.strain0)) - wave.end_tension
    return abs(mass * _over_xi(wave, wave.velocity) / impulse - 1.0)


def continuity(wave):
    """Relative defect of the length: integral of (e0 - e) dxi = speed of the end."""
    lost = _over_xi(wave, lambda x: wave.strain0 - wave.strain(x))
    return abs(lost / wave.end_speed - 1.0)


def energy(law, mass, wave):
    """Defect of the energy over what was released: kinetic + shocks + work on F - elastic."""

    def stored(x):
        return gauss(law, wave.strain(x), wave.strain0, 8)

    released = _over_xi(wave, stored)
    kinetic = 0.5 * mass * _over_xi(wave, lambda x: wave.velocity(x) ** 2)
    work = wave.end_tension * wave.end_speed
    return abs(kinetic + wave.dissipation_rate + work - released) / released
