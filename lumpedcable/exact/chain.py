"""Exact statics of a chain of lumped nodes: what a lumped-mass line must settle to.

Segment i of unstretched length l_i joins node i to node i + 1. With the load P_j (N) on node j the
tension vector t_i (from node i towards node i + 1) is constant in a segment, every free node
balances, t_j - t_{j-1} + P_j = 0, so that the vectors are sums from one end,

    t_i = t_0 - sum of P_j over 1 <= j <= i,

and each segment points along its own tension, x_{i+1} = x_i + l_i (1 + e(|t_i|)) t_i/|t_i|. No
iteration is needed where the force on one end is known; between two fixed ends t_0 is the
minimum of the convex complementary energy sum l_i (|t_i| + integral of e dT) - t_0.X, X the
vector from end to end.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite
from .law import Array, Law, bisect, tension_values
from .newton import convex_minimum

StrainOfTension = Callable[[Array], Array]
"""Vectorised inverse law: tension in N (any shape) to strain."""


def linear_strain(EA: float) -> StrainOfTension:
    """Return e(T) = T/EA for the stiffness EA (N); inf is inextensible."""
    if not EA > 0.0:
        raise ValueError(f"expected a positive EA in N, found {EA:g}")
    return lambda T: np.asarray(T, float) / EA


def strain_of_tension(tension: Law, bracket: tuple[float, float] = (-0.5, 2.0)) -> StrainOfTension:
    """Return the vectorised inverse e(T) of a rising law T(e), by bisection to neighbouring floats.

    The returned function raises ValueError for a tension the law does not reach in `bracket`.
    """
    lo, hi = bracket
    low, high = (float(T) for T in tension_values(tension, [lo, hi]))

    def strain(T: Array) -> Array:
        T = np.asarray(T, float)
        if np.any((low > T) | (high < T)):
            raise ValueError(
                f"the law carries {low:g} N to {high:g} N between strain {lo:g} and {hi:g}; "
                f"asked for {np.min(T):g} N to {np.max(T):g} N"
            )
        lows, highs = np.full(T.shape, lo), np.full(T.shape, hi)
        return bisect(lambda e: tension_values(tension, e) > T, lows, highs)

    return strain


@dataclass(frozen=True)
class ChainShape:
    """Equilibrium of a lumped chain.

    Attributes:
        positions: nodes, m, shape (n + 1, 3).
        tensions: tension vectors of the segments, pointing from node i to i + 1, N, shape (n, 3).
        strains: strains of the segments, shape (n,).
    """

    positions: Array
    tensions: Array
    strains: Array

    @property
    def tension(self) -> Array:
        """Tensions of the segments, N, shape (n,)."""
        return np.linalg.norm(self.tensions, axis=1)


def hanging_nodes(
    start: ArrayLike,
    lengths: ArrayLike,
    loads: ArrayLike,
    end_force: ArrayLike,
    strain: StrainOfTension,
) -> ChainShape:
    """Return the chain fixed at node 0 with known loads on all other nodes.

    The tension vector of segment i is `end_force` plus the loads on nodes i + 1 to n.

    Args:
        start: position of node 0, m, shape (3,).
        lengths: unstretched lengths, m, shape (n,).
        loads: loads on the nodes, N, shape (n + 1, 3); row 0 goes into the fixed end.
        end_force: force on node n besides its load, N, shape (3,).
        strain: inverse law e(T).

    Raises:
        ValueError: for shapes that do not fit, or a segment without tension (no direction).
    """
    lengths, loads = _shapes(lengths, loads)
    finite(start=start, **{"end force": end_force})
    t = np.asarray(end_force, float) + np.cumsum(loads[:0:-1], axis=0)[::-1]
    return _follow(np.asarray(start, float), lengths, t, strain)


def pinned_nodes(
    start: ArrayLike,
    end: ArrayLike,
    lengths: ArrayLike,
    loads: ArrayLike,
    strain: StrainOfTension,
) -> ChainShape:
    """Return the chain between two fixed nodes: the lumped catenary.

    Args:
        start: position of node 0, m, shape (3,).
        end: position of node n, m, shape (3,).
        lengths: unstretched lengths, m, shape (n,).
        loads: loads on the nodes, N, shape (n + 1, 3); the end rows go into the fixed ends.
        strain: inverse law e(T), rising.

    Raises:
        ValueError: for shapes that do not fit, or a chain that does not reach its end.
    """
    lengths, loads = _shapes(lengths, loads)
    start, end = np.asarray(start, float), np.asarray(end, float)
    finite(start=start, end=end)
    drop = np.concatenate([np.zeros((1, 3)), np.cumsum(loads[1:-1], axis=0)])  # t_i = t_0 - drop_i
    size = float(max(np.linalg.norm(end - start), np.sum(lengths)))

    def gradient(F: Array) -> tuple[Array, Array]:
        t = F - drop
        T = np.maximum(np.linalg.norm(t, axis=1), 1e-300)
        u = t / T[:, None]
        e = strain(T)
        step = 1e-6 * np.maximum(T, 1e-6 * np.max(T))
        soft = np.maximum((strain(T + step) - e) / step, 0.0)
        along = np.einsum("i,ij,ik->jk", lengths * soft, u, u)
        turn = lengths * (1.0 + e) / T
        across = np.sum(turn) * np.eye(3) - np.einsum("i,ij,ik->jk", turn, u, u)
        return (lengths * (1.0 + e)) @ u - (end - start), along + across

    chord = (end - start) / max(float(np.linalg.norm(end - start)), 1e-300)
    guess = 0.5 * drop[-1] + chord * max(float(np.linalg.norm(drop[-1])), 1.0)
    F = convex_minimum(gradient, guess, size)
    return _follow(start, lengths, F - drop, strain)


def _shapes(lengths: ArrayLike, loads: ArrayLike) -> tuple[Array, Array]:
    lengths, loads = np.asarray(lengths, float), np.asarray(loads, float)
    if lengths.ndim != 1 or lengths.size == 0 or np.any(lengths <= 0.0):
        raise ValueError("expected a list of positive segment lengths in m")
    if loads.shape != (lengths.size + 1, 3):
        raise ValueError(
            f"expected loads of shape ({lengths.size + 1}, 3), one row a node; found {loads.shape}"
        )
    finite(length=lengths, load=loads)
    return lengths, loads


def _follow(start: Array, lengths: Array, t: Array, strain: StrainOfTension) -> ChainShape:
    T = np.linalg.norm(t, axis=1)
    if np.any(T == 0.0):
        raise ValueError(f"segment {int(np.argmin(T))} carries no tension: it has no direction")
    e = strain(T)
    steps = (lengths * (1.0 + e) / T)[:, None] * t
    positions = np.vstack([start, start + np.cumsum(steps, axis=0)])
    return ChainShape(positions, t, e)
