"""The lumped chain at rest: equilibrium of every node, closed forms, and the catenary limit."""

import numpy as np
import pytest
from nylon_line import tension as nylon
from scipy.integrate import solve_ivp

from lumpedcable.exact import (
    HangingRod,
    elastic_catenary,
    hanging_nodes,
    linear_strain,
    pinned_nodes,
    strain_of_tension,
)


def out_of_balance(shape, lengths, loads, law, held):
    """Largest force on a free node, N, with the tensions read off the positions by the law."""
    step = np.diff(shape.positions, axis=0)
    size = np.linalg.norm(step, axis=1)
    t = (law(size / lengths - 1.0) / size)[:, None] * step
    force = np.array(loads, float)
    force[:-1] += t
    force[1:] -= t
    return np.max(np.abs(np.delete(force, held, axis=0)))


def random_chain(n):
    random = np.random.default_rng(3)
    loads = random.normal(size=(n + 1, 3)) * [30, 30, 10] + [0, 0, -50.0]
    return random.uniform(0.5, 2.0, n), loads


def test_hanging_chain_balances():
    lengths, loads = random_chain(25)
    law, strain = (lambda e: 4e4 * e), linear_strain(4e4)
    pull = np.array([200.0, -100.0, 400.0])
    shape = hanging_nodes([1.0, 2.0, 3.0], lengths, loads, pull, strain)
    assert shape.positions[0] == pytest.approx([1.0, 2.0, 3.0])
    loads[-1] += pull
    assert out_of_balance(shape, lengths, loads, law, [0]) < 1e-8
    # The checker sees a node that is 1 mm off.
    shape.positions[12, 1] += 1e-3
    assert out_of_balance(shape, lengths, loads, law, [0]) > 1.0


def test_hanging_chain_of_nylon_balances():
    lengths, loads = random_chain(15)
    loads *= 100.0
    shape = hanging_nodes(np.zeros(3), lengths, loads, [5e4, 0, 0], strain_of_tension(nylon))
    loads[-1] += [5e4, 0, 0]
    assert out_of_balance(shape, lengths, loads, nylon, [0]) < 1e-5
    assert nylon(shape.strains) == pytest.approx(shape.tension, rel=1e-10)


@pytest.mark.parametrize(
    ("law", "strain", "scale"),
    [(lambda e: 4e4 * e, linear_strain(4e4), 1.0), (nylon, strain_of_tension(nylon), 30.0)],
)
def test_pinned_chain_balances(law, strain, scale):
    lengths, loads = random_chain(25)
    loads *= scale
    end = np.array([0.7, 0.2, -0.3]) * np.sum(lengths)
    shape = pinned_nodes(np.zeros(3), end, lengths, loads, strain)
    assert shape.positions[-1] == pytest.approx(end, abs=1e-9)
    assert out_of_balance(shape, lengths, loads, law, [0, 25]) < 1e-6 * scale


def test_two_segments_by_hand():
    # A load P amid two stiff 5 m segments over a span of 8 m: 3-4-5 triangles, T = 5 P/6.
    shape = pinned_nodes(
        [0, 0, 0], [8, 0, 0], [5, 5], [[0, 0, 0], [0, 0, -60.0], [0, 0, 0]], linear_strain(np.inf)
    )
    assert shape.tension == pytest.approx([50.0, 50.0])
    assert shape.positions[1] == pytest.approx([4.0, 0.0, -3.0])


@pytest.mark.parametrize("length", [95.0, 130.0])
def test_converges_to_the_catenary(length):
    w, EA = 60.0, 2e5
    exact = elastic_catenary(100.0, 20.0, length, EA, w)
    error = []
    for n in (20, 80):
        loads = np.zeros((n + 1, 3))
        loads[:, 2] = -w * length / n
        shape = pinned_nodes(
            [0, 0, 0], [100.0, 0, 20.0], np.full(n, length / n), loads, linear_strain(EA)
        )
        x, z = exact.position(np.linspace(0.0, length, n + 1))
        error.append(np.max(np.hypot(shape.positions[:, 0] - x, shape.positions[:, 2] - z)))
        assert shape.positions[:, 1] == pytest.approx(np.zeros(n + 1), abs=1e-12)
    assert error[0] / error[1] == pytest.approx(16.0, rel=0.03)  # second order in the segment


def test_errors():
    stiff = linear_strain(np.inf)
    with pytest.raises(ValueError, match=r"shape \(3, 3\)"):
        hanging_nodes([0, 0, 0], [1, 1], np.zeros((2, 3)), [0, 0, 1], stiff)
    with pytest.raises(ValueError, match="positive segment lengths"):
        hanging_nodes([0, 0, 0], [1, -1], np.zeros((3, 3)), [0, 0, 1], stiff)
    with pytest.raises(ValueError, match="segment 0 carries no tension"):
        hanging_nodes([0, 0, 0], [1, 1], np.zeros((3, 3)), [0, 0, 0], stiff)
    with pytest.raises(ValueError, match="away from its place"):
        pinned_nodes([0, 0, 0], [9, 0, 0], [4, 4], np.full((3, 3), -1.0), stiff)
    with pytest.raises(ValueError, match="positive EA"):
        linear_strain(0.0)
    with pytest.raises(ValueError, match="asked for"):
        strain_of_tension(nylon)(np.array([1e6]))


# -- the hanging rod ----------------------------------------------------------------------------


def test_linear_rod():
    L, w, F, EA = 250.0, 130.0, 4e4, 7e6
    rod = HangingRod(L, w, F, linear_strain(EA))
    s = np.linspace(0.0, L, 7)
    assert rod.displacement(s) == pytest.approx((F * s + w * (L * s - s**2 / 2)) / EA, abs=1e-13)
    assert rod.stretch == pytest.approx((F * L + w * L**2 / 2) / EA, rel=1e-13)
    assert rod.tension([0.0, L]) == pytest.approx([F + w * L, F])


def test_rod_of_nylon_by_integration():
    L, w, F = 300.0, 400.0, 2e4
    rod = HangingRod(L, w, F, strain_of_tension(nylon))
    # The other way round: march the tension, dT/ds = -w, with the strain by de/ds = -w/T'(e).

    def along(_, y):
        h = 1e-6
        return [-w * 2 * h / (nylon(y[0] + h) - nylon(y[0] - h)), y[0]]

    top = float(strain_of_tension(nylon)(np.array(F + w * L)))
    path = solve_ivp(along, (0.0, L), [top, 0.0], rtol=1e-10, atol=1e-12)
    assert rod.stretch == pytest.approx(path.y[1, -1], rel=1e-8)
    # A linear rod with the slope of the law at rest stretches much more.
    assert HangingRod(L, w, F, linear_strain(1.53e5)).stretch > 1.5 * rod.stretch


def test_rod_without_stiffness_at_rest():
    # T = k e^2 and F = 0: u(L) = integral of sqrt(w x/k) = 2/3 sqrt(w/k) L^1.5.
    L, w, k = 40.0, 12.0, 3e5
    rod = HangingRod(L, w, 0.0, lambda T: np.sqrt(T / k))
    assert rod.stretch == pytest.approx(np.sqrt(w / k) * L**1.5 / 1.5, rel=1e-10)
    with pytest.raises(ValueError, match="40 m"):
        rod.displacement(41.0)
