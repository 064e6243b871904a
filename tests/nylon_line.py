"""The nylon line of Zhu, Yin & Shen (2018), and its exact waves computed independently.

Law and line data are the paper's; the waves were computed with prototypes that share no code
with this package (instantaneous break, no weight, no drag, s the unstretched coordinate).
"""

from dataclasses import dataclass

import numpy as np

P1, P2, P3, P4, P5 = 2.703e5, 10.2, -2.128, 2.627e5, 135.5  # N, -, -, N, N
MASS = 2.238  # kg/m
LENGTH = 60.0  # m
SLACK_STRAIN = 0.0002755803798


def tension(e):
    return P1 * np.tanh(P2 * e + P3) + P4 + P5 * e


def slope(e):
    return P1 * P2 / np.cosh(P2 * e + P3) ** 2 + P5


def cut(e):
    return np.maximum(tension(e), 0.0)


def cut_slope(e):
    return np.where(tension(e) > 0.0, slope(e), 0.0)


@dataclass(frozen=True)
class Run:
    """T0 N, e0, c(e0) m/s, L/c(e0) ms, tangent strain, shock m/s, front ms, end speeds m/s."""

    T0: float
    e0: float
    c0: float
    characteristic_ms: float
    tangent: float | None
    shock_speed: float | None
    front_ms: float
    isentropic: float
    end_speed: float


RUNS = (
    Run(45e3, 0.09941749867, 657.8555771, 91.2054288, None, None, 91.2054288,
        43.17086886, 43.17086886),
    Run(180e3, 0.177629779, 1056.694654, 56.78083048, None, None, 56.78083048,
        111.227207, 111.227207),
    Run(315e3, 0.2278274905, 1089.001565, 55.09633957, 0.1990639609, 1104.691056, 54.31382797,
        166.2499775, 166.250409),
    Run(450e3, 0.2922838839, 800.4503367, 74.95780469, 0.1694560471, 1026.893159, 58.42866851,
        228.3583965, 228.8391582),
)  # fmt: skip
