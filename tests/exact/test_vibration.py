"""Frequencies and periods against discretised eigenproblems, integration and limits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh, eigh_tridiagonal
from scipy.optimize import brentq

from lumpedcable.exact import (
    STANDARD_GRAVITY,
    elastic_pendulum_periods,
    hanging_chain_frequencies,
    irvine_parameter,
    pendulum_period,
    rod_frequencies,
    sagged_cable_frequencies,
    string_frequencies,
)


def spring_matrix(stiffness):
    """Chain of springs between n + 1 points, both ends fixed: (n - 1, n - 1)."""
    K = np.diag(stiffness[:-1] + stiffness[1:])
    return K - np.diag(stiffness[1:-1], 1) - np.diag(stiffness[1:-1], -1)


def frequencies(K, masses, count):
    """Lowest frequencies (Hz) of a stiffness between points with masses, as many as they are or one."""
    root = np.sqrt(np.broadcast_to(masses, len(K)))
    scaled, lowest = K / np.outer(root, root), (0, count - 1)
    if np.count_nonzero(np.triu(K, 2)):
        squares = eigh(scaled, eigvals_only=True, subset_by_index=lowest)
    else:  # a chain, each point bound to its neighbours alone
        squares = eigh_tridiagonal(
            np.diag(scaled), np.diag(scaled, 1), True, select="i", select_range=lowest
        )
    return np.sqrt(squares) / (2 * np.pi)


def test_string_and_rod():
    L, T, m, n = 60.0, 45e3, 2.238, 400
    h = L / n
    by_matrix = frequencies(spring_matrix(np.full(n, T / h)), m * h, 4)
    assert string_frequencies(L, T, m, 4) == pytest.approx(by_matrix, rel=1e-3)
    assert rod_frequencies(L, T, m, 4) == pytest.approx(by_matrix, rel=1e-3)
    # One end free: the odd modes of a rod twice as long.
    free = rod_frequencies(L, T, m, 3, free_end=True)
    assert free == pytest.approx(rod_frequencies(2 * L, T, m, 5)[::2])


@pytest.mark.parametrize("parameter", [0.5, 4 * np.pi**2, 150.0, 5e3])
def test_sagged_cable(parameter):
    # H v'' + h y'' = m v_tt, h = (EA/L_e) (m g/H) integral of v: a string plus a rank-one term.
    l, H, m, n = 100.0, 2e4, 5.0, 400
    d = l / n
    unit = parameter * H / l**3 * np.ones((n - 1, n - 1)) * d * d
    by_matrix = frequencies(spring_matrix(np.full(n, H / d)) + unit, m * d, 6)
    both = np.sort(np.concatenate(sagged_cable_frequencies(l, H, m, parameter, 4)))[:6]
    assert both == pytest.approx(by_matrix, rel=2e-3)
    if parameter < 1e3:  # above, the cable is as good as inextensible
        other = np.sort(np.concatenate(sagged_cable_frequencies(l, H, m, 1.3 * parameter, 4)))[:6]
        assert np.max(np.abs(other / by_matrix - 1)) > 5e-3


def test_sagged_cable_limits():
    taut, odd = sagged_cable_frequencies(100.0, 2e4, 5.0, 0.0, 3)
    string = string_frequencies(100.0, 2e4, 5.0, 6)
    assert taut == pytest.approx(string[0::2])
    assert odd == pytest.approx(string[1::2])
    nearly = sagged_cable_frequencies(100.0, 2e4, 5.0, 1e-6, 3)[0]
    assert nearly == pytest.approx(taut, rel=1e-6)
    # First crossover at lambda^2 = 4 pi^2; inextensible limit tan b = b.
    cross, odd = sagged_cable_frequencies(100.0, 2e4, 5.0, 4 * np.pi**2, 1)
    assert cross[0] == pytest.approx(odd[0], rel=1e-12)
    stiff = sagged_cable_frequencies(100.0, 2e4, 5.0, 1e14, 1)[0][0]
    b = brentq(lambda b: np.sin(b) - b * np.cos(b), 4.0, 4.7)
    assert stiff == pytest.approx(2 * b * np.sqrt(2e4 / 5.0) / (2 * np.pi * 100.0), rel=1e-9)
    with pytest.raises(ValueError, match="0 or more"):
        sagged_cable_frequencies(100.0, 2e4, 5.0, -1.0, 1)


def test_irvine_parameter():
    # Sag/span 1/50: w l/H = 8/50, L_e = l (1 + 8/50^2).
    H, l, EA = 2e4, 100.0, 1e7
    w = 8 * H / (50 * l)
    expected = (8 / 50) ** 2 * EA / (H * (1 + 8 / 2500))
    assert irvine_parameter(l, H, w, EA) == pytest.approx(expected, rel=1e-14)


def test_hanging_chain():
    # Lumped chain: horizontal springs of stiffness tension/h; top fixed, last node half a mass.
    L, n, m = 12.0, 1500, 3.0
    h = L / n
    tension = m * STANDARD_GRAVITY * (L - (np.arange(n) + 0.5) * h)
    K = spring_matrix(np.concatenate([tension / h, [0.0]]))
    masses = m * h * np.concatenate([np.ones(n - 1), [0.5]])
    assert hanging_chain_frequencies(L, 3) == pytest.approx(frequencies(K, masses, 3), rel=1e-3)
    # Twice the frequency in four times the gravity.
    four = hanging_chain_frequencies(L, 3, 4 * STANDARD_GRAVITY)
    assert four == pytest.approx(2 * hanging_chain_frequencies(L, 3))


def swing_period(length, angle, stiffness=None, mass=1.0):
    """Period of a bob released from rest at an angle, by integration; stiffness N/m or rigid."""
    g = STANDARD_GRAVITY
    if stiffness is None:

        def motion(_, y):
            return [y[1], -g / length * np.sin(y[0])]

        start = [angle, 0.0]
    else:

        def motion(_, y):
            x, z, vx, vz = y
            r = np.hypot(x, z)
            pull = stiffness * (r - length) / (mass * r)
            return [vx, vz, -pull * x, -pull * z - g]

        r = length + mass * g / stiffness
        start = [r * np.sin(angle), -r * np.cos(angle), 0.0, 0.0]

    def bottom(_, y):
        return y[0]

    end = 5.0 * 2 * np.pi * np.sqrt(length / g)
    path = solve_ivp(
        motion, (0, end), start, method="DOP853", events=bottom, rtol=1e-11, atol=1e-11
    )
    t = path.t_events[0]
    return t[2] - t[0]


@pytest.mark.parametrize("angle", [0.1, 1.0, 2.5, 3.1])
def test_pendulum(angle):
    assert pendulum_period(7.0, angle) == pytest.approx(swing_period(7.0, angle), rel=1e-8)


def test_pendulum_limits():
    assert pendulum_period(7.0) == pytest.approx(2 * np.pi * np.sqrt(7.0 / STANDARD_GRAVITY))
    # First terms of the series: 1 + a^2/16 + 11 a^4/3072.
    a = 0.3
    series = pendulum_period(7.0) * (1 + a**2 / 16 + 11 * a**4 / 3072)
    assert pendulum_period(7.0, a) == pytest.approx(series, rel=1e-6)
    with pytest.raises(ValueError, match="between 0 and pi"):
        pendulum_period(7.0, np.pi)


@pytest.mark.parametrize("short", [1e-3, 1e-6, 1e-8, 1e-12])
def test_a_pendulum_let_go_next_to_upright(short):
    # K(m) goes to log(4/sqrt(1 - m)), and 1 - m = cos^2 is the square of half of what is short of pi
    short = np.pi - (np.pi - short)  # as the number for the amplitude has it
    limit = 4.0 * np.sqrt(7.0 / STANDARD_GRAVITY) * np.log(8.0 / short)
    assert pendulum_period(7.0, np.pi - short) == pytest.approx(limit, rel=1e-5)


def test_heavy_bob_on_a_long_line():
    # 100 t on 100.5 m of neutrally buoyant line: 20.114 s is the small-amplitude rigid value.
    assert pendulum_period(100.5) == pytest.approx(20.114, abs=5e-4)
    # EA = 1e9 N stretches it by 98.6 mm, and from (10, -100) m it swings through 0.0997 rad.
    swing, bounce = elastic_pendulum_periods(100.5, 1e9, 1e5)
    assert swing == pytest.approx(20.114 * (1 + 0.5 * 0.00098067), abs=1e-3)
    assert bounce == pytest.approx(2 * np.pi * np.sqrt(1e5 * 100.5 / 1e9))
    small = swing_period(100.5, 1e-3, 1e9 / 100.5, 1e5)
    assert swing == pytest.approx(small, rel=1e-6)
