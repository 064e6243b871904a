"""Beams against known numbers, finite elements and integration."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq

from lumpedcable.exact import (
    beam_frequencies,
    cantilever_deflection,
    drag_line,
    rolled_beam,
    simply_supported_deflection,
    tensioned_beam_frequencies,
    tip_loaded_cantilever,
)

Q = 100.0 * 9.80665  # 100 kg/m, N/m


def assembled(n, L, EI, m, T=0.0):
    """Stiffness and mass of n cubic beam elements under tension T; (deflection, slope) a node."""
    h = L / n
    k = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]) * EI / h**3
    g = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]) * T / 30 / h
    w = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    scale = np.outer([1, h, 1, h], [1, h, 1, h])
    K, M = np.zeros((2 * n + 2, 2 * n + 2)), np.zeros((2 * n + 2, 2 * n + 2))
    for i in range(n):
        at = slice(2 * i, 2 * i + 4)
        K[at, at] += (k + g) * scale
        M[at, at] += np.array(w) * (m * h / 420) * scale
    return K, M


def held(n, ends):
    last = 2 * n
    return {"cantilever": [0, 1], "pinned": [0, last], "clamped": [0, 1, last, last + 1],
            "free": []}[ends]  # fmt: skip


def without(A, gone):
    keep = np.setdiff1d(np.arange(len(A)), gone)
    return A[np.ix_(keep, keep)]


def test_uniform_load_numbers():
    # 10 m, 100 kg/m, EI 1e7 N m2: tip 0.12258 m; on two supports 0.01277 m at mid-span.
    assert cantilever_deflection(10.0, 10.0, Q, 1e7) == pytest.approx(0.12258, abs=5e-6)
    assert simply_supported_deflection(5.0, 10.0, Q, 1e7) == pytest.approx(0.01277, abs=5e-6)


@pytest.mark.parametrize(
    ("ends", "closed"),
    [("cantilever", cantilever_deflection), ("pinned", simply_supported_deflection)],
)
def test_uniform_load_by_finite_elements(ends, closed):
    n, L, EI = 10, 10.0, 1e7
    K, _ = assembled(n, L, EI, 100.0)
    h = L / n
    load = np.zeros(2 * n + 2)
    for i in range(n):  # consistent loads: cubic elements are exact at the nodes
        load[2 * i : 2 * i + 4] += Q * np.array([h / 2, h**2 / 12, h / 2, -(h**2) / 12])
    free = np.setdiff1d(np.arange(2 * n + 2), held(n, ends))
    y = np.zeros(2 * n + 2)
    y[free] = np.linalg.solve(K[np.ix_(free, free)], load[free])
    assert closed(np.linspace(0.0, L, n + 1), L, Q, EI) == pytest.approx(y[::2], abs=1e-9)


@pytest.mark.parametrize("ends", ["cantilever", "pinned", "clamped", "free"])
def test_frequencies(ends):
    L, EI, m, n = 10.0, 1e7, 100.0, 80
    K, M = assembled(n, L, EI, m)
    w2 = eigh(without(K, held(n, ends)), without(M, held(n, ends)), eigvals_only=True)
    w2 = w2[2:] if ends == "free" else w2
    by_elements = np.sqrt(w2[:4]) / (2 * np.pi)
    assert beam_frequencies(L, EI, m, 4, ends) == pytest.approx(by_elements, rel=1e-5)


def test_frequency_constants():
    # Roots of the characteristic equations: 1.875104069, 4.694091133 and 4.730040745.
    unit = 2 * np.pi
    assert beam_frequencies(1.0, 1.0, 1.0, 2) * unit == pytest.approx(
        [1.875104069**2, 4.694091133**2], rel=1e-8
    )
    assert beam_frequencies(1.0, 1.0, 1.0, 1, "clamped") * unit == pytest.approx(
        [4.730040745**2], rel=1e-8
    )
    many = beam_frequencies(1.0, 1.0, 1.0, 30, "free")
    assert np.sqrt(many * unit)[-1] == pytest.approx(30.5 * np.pi, rel=1e-12)
    with pytest.raises(ValueError, match="expected ends cantilever"):
        beam_frequencies(1.0, 1.0, 1.0, 1, "hinged")


def test_tensioned_beam():
    L, EI, m, T, n = 10.0, 1e5, 20.0, 3e4, 40
    K, M = assembled(n, L, EI, m, T)
    w2 = eigh(without(K, held(n, "pinned")), without(M, held(n, "pinned")), eigvals_only=True)
    closed = tensioned_beam_frequencies(L, T, EI, m, 4)
    assert closed == pytest.approx(np.sqrt(w2[:4]) / (2 * np.pi), rel=1e-5)
    euler = np.pi**2 * EI / L**2
    with pytest.raises(ValueError, match="buckles"):
        tensioned_beam_frequencies(L, -1.001 * euler, EI, m, 1)
    assert tensioned_beam_frequencies(L, -0.999 * euler, EI, m, 1)[0] < 0.05 * closed[0]


def test_rolled_beam():
    # Half a circle of radius 2 m: EI/M = 2, L = 2 pi.
    x, y = rolled_beam([np.pi, 2 * np.pi], 0.5, 1.0)
    assert x == pytest.approx([2.0, 0.0], abs=1e-14)
    assert y == pytest.approx([2.0, 4.0])
    x, y = rolled_beam(3.0, 1e-12, 1.0)
    assert (float(x), float(y)) == pytest.approx((3.0, 4.5e-12))
    x, y = rolled_beam(4 * np.pi, 0.5, 1.0)
    assert (float(x), float(y)) == pytest.approx((0.0, 0.0), abs=1e-14)


@pytest.mark.parametrize("load", [0.1, 1.0, 5.0, 10.0])
def test_tip_load_by_boundary_value_problem(load):
    # EI theta'' = -P cos(theta), theta(0) = 0, theta'(L) = 0, x' = cos theta, y' = sin theta.
    def bend(_, y):
        return [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    def ends(a, b):
        return [a[0], b[1], a[2], a[3]]

    s = np.linspace(0.0, 1.0, 41)
    shape = solve_bvp(bend, ends, s, np.array([s, 1 - s, s, 0.5 * s**2]), tol=1e-9)
    x, y, angle = tip_loaded_cantilever(1.0, load, 1.0)
    assert (angle, x, y) == pytest.approx(tuple(shape.y[[0, 2, 3], -1]), rel=1e-7)
    # Linear theory, P L^3/3 EI, holds for small loads only.
    assert (abs(y / (load / 3) - 1) < 1e-2) == (load < 0.5)


def shot(a):
    """x/L, y/L and the tip angle by shooting from the tip, for a = P L^2/EI.

    From the tip back, the angle to the load's direction p'' = a sin p grows from d: in its logarithm
    the root is as plain at any a. A beam that is bent little is shot by its angle over a.
    """

    def little(_, v):  # angle/a, its slope, and x, y/a
        return [v[1], -np.cos(a * v[0]), np.cos(a * v[0]), np.sin(a * v[0]) / a]

    def much(_, p):
        return [p[1], a * np.sin(p[0]), np.sin(p[0]), np.cos(p[0])]

    def path(rates, start):
        exact = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-60}
        return solve_ivp(rates, (0.0, 1.0), [start, 0.0, 0.0, 0.0], **exact).y[:, -1]

    if a < 1.0:
        tip = brentq(lambda v: path(little, v)[0], 0.1, 0.6, xtol=1e-15)
        return path(little, tip)[2], a * path(little, tip)[3], a * tip
    near = 1.2 - np.sqrt(a)
    tip = brentq(lambda u: path(much, np.exp(u))[0] - np.pi / 2, near - 1.0, near + 0.5, xtol=1e-13)
    return *path(much, np.exp(tip))[2:], np.pi / 2 - np.exp(tip)


@pytest.mark.parametrize(
    "a", [1e-8, 1e-6, 1e-3, 0.3, 0.99, 1.01, 20.0, 305.0, 310.0, 400.0, 2e3, 1e4]
)
def test_tip_load_of_any_size(a):
    found = tip_loaded_cantilever(1.0, a, 1.0)
    assert found == pytest.approx(shot(a), rel=1e-9)
    if a >= 400.0:  # bent into the direction of the load but for a short piece at the clamp
        limit = (np.sqrt(2.0 / a), 1.0 - (2.0 - np.sqrt(2.0)) / np.sqrt(a), np.pi / 2)
        assert found == pytest.approx(limit, rel=1e-7)
    if a <= 1e-6:
        assert found == pytest.approx((1.0, a / 3.0, a / 2.0), rel=1e-10)


def test_tip_load_scales():
    x, y, angle = tip_loaded_cantilever(3.0, 7.0, 21.0)
    x1, y1, angle1 = tip_loaded_cantilever(1.0, 3.0, 1.0)
    assert (x, y, angle) == pytest.approx((3 * x1, 3 * y1, angle1))
    with pytest.raises(ValueError, match="positive load"):
        tip_loaded_cantilever(1.0, 0.0, 1.0)


def test_high_modes_do_not_overflow():
    # cosh b is beyond all numbers there, and b is (n + 1/2) pi
    b = 300.5 * np.pi
    assert beam_frequencies(1.0, 1.0, 1.0, 300, "clamped")[-1] == pytest.approx(b**2 / (2 * np.pi))


# -- the line in a current ----------------------------------------------------------------------


@pytest.mark.parametrize("length", [10.001, 12.0, 45.0])
def test_drag_line_by_shooting(length):
    line = drag_line(10.0, length, 30.0)

    def along(_, y):  # position across and along the flow, and the angle phi to the flow
        return [np.sin(y[2]), np.cos(y[2]), 30.0 / line.tension * np.sin(y[2]) ** 2]

    k = 10.0 * 30.0 / (2 * line.tension)
    start = np.arctan2(1.0, np.sinh(k))  # dx/dy at the end of the curve is sinh(B/2a)
    path = solve_ivp(along, (0.0, length), [-5.0, 0.0, start], rtol=1e-11, atol=1e-11)
    assert path.y[:2, -1] == pytest.approx([5.0, 0.0], abs=1e-7)
    middle = solve_ivp(along, (0.0, length / 2), [-5.0, 0.0, start], rtol=1e-11, atol=1e-11)
    assert middle.y[:2, -1] == pytest.approx([0.0, line.sag], abs=1e-7)
    y, x = line.position([0.0, length])
    assert y == pytest.approx([-5.0, 5.0])
    assert x == pytest.approx([0.0, 0.0], abs=1e-9)


def test_drag_line_balance_and_errors():
    # Half the drag on each end: 2 T cos(phi_end) = D integral of sin^2(phi) sin(phi) ds.
    line = drag_line(10.0, 14.0, 30.0)
    s = (np.arange(20000) + 0.5) * 14.0 / 20000
    y, x = line.position(np.linspace(0, 14.0, 20001))
    sin = np.diff(y) / np.hypot(np.diff(x), np.diff(y))
    k = 10.0 * 30.0 / (2 * line.tension)
    drag = 30.0 * np.sum(sin**3) * (s[1] - s[0])
    assert 2 * line.tension * np.tanh(k) == pytest.approx(drag, rel=1e-7)
    with pytest.raises(ValueError, match="span < length"):
        drag_line(10.0, 10.0, 1.0)
    with pytest.raises(ValueError, match="positive drag"):
        drag_line(10.0, 11.0, 0.0)
