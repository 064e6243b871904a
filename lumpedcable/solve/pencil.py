"""The lowest modes of K u = omega^2 M u where some combinations of u do not move, G u = 0.

For masses that couple neighbours and lengths that are kept. Everything is sparse; G may have rows that
follow from others, as of a taut straight line between two fixed points.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from lumpedcable.solve.spectrum import (
    ATTEMPTS,
    DENSE,
    EPS,
    SPARE,
    SymmetricBlocks,
    rounding,
    told_apart,
)

__all__ = ["BORDER", "Pencil"]

YIELD = 1e-13  # what ties give by, over what K does: too little to see, enough for rows that repeat
SAME = 1e-9  # singular values of G below this are rows that repeat
BORDER = -1
"""The block of unknowns that couple to any others."""


@dataclass(frozen=True)
class Pencil:
    """K u = omega^2 M u with G u = 0: n unknowns, m rows of ties.

    `stiffness` (N/m) and `mass` (kg) are sparse (n, n), K symmetric and M positive; `ties` (m, n) is G,
    with rows of the size of 1. `blocks` (n,) says in which block an unknown stands: K, M and G couple
    blocks to their neighbours alone, but for the few unknowns of the block `BORDER`.
    """

    stiffness: Any
    mass: Any
    ties: Any
    blocks: Int[np.ndarray, " n"]

    @property
    def unknowns(self) -> int:
        """Number of unknowns n, before any are tied."""
        return self.mass.shape[0]

    @cached_property
    def size(self) -> float:
        """A bound (rad2/s2) on the size of omega^2 of all that is not tied, but for a small factor."""
        root = np.sqrt(self.mass.diagonal())
        return float(np.max(abs(self.stiffness) @ (1.0 / root) / root))

    def lowest(
        self, count: int
    ) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, "n k"], Float[np.ndarray, " k"], int]:
        """The k algebraically lowest omega^2 (rad2/s2), or all if there are fewer.

        Of few unknowns the tied combinations are taken out and the rest is solved whole. Of many,
        Lanczos on the inverse of K - shift M with its ties (ARPACK), checked by `below`. Two steps of
        inverse iteration then clear the vectors of what stiff or light parts left in them.

        Returns:
            omega^2, ascending; vectors v with v . M v = 1 (kg); the accuracy that rounding leaves to
            each omega^2; and the number of all modes.

        Raises:
            ValueError: nothing can move.
        """
        many = self.unknowns > DENSE and count + SPARE < self.unknowns // 4 and self.size > 0.0
        free = None if many else self._untied()
        number = self.below(1e3 * self.size) if free is None else free.shape[1]
        if number == 0:
            raise ValueError("nothing can move: lines that keep their length hold every node")
        count = min(count, number)
        if free is not None and self.size == 0.0:
            nothing = np.zeros(count)
            return nothing, self._scaled(free[:, :count]), nothing, number
        shift = -64.0 * EPS * self.size
        while self.below(shift) > 0:
            shift *= 64.0
        solve = self._solver(self.stiffness - shift * self.mass)
        vectors = None if free is not None else self._by_inverse(count, shift, solve)
        if vectors is None:
            vectors = self._whole(self._untied() if free is None else free, count)
        for _ in range(2):
            vectors = solve(self.mass @ self._scaled(vectors))
        vectors = self._scaled(vectors)
        values, vectors = told_apart(self.stiffness, vectors)
        return values, vectors, rounding(self.stiffness, vectors), number

    def below(self, shift: float) -> int:
        """Number of modes with omega^2 below `shift` (rad2/s2), by the signs of pivots.

        With ties that give, [[A, G^T], [G, -e]] has a negative pivot for each tie and one for each mode
        of A + G^T G / e, A = K - shift M, below 0 (Haynsworth, Linear Algebra Appl. 1, 1968). So
        has what elimination of all others leaves of the border.
        """
        m = self.ties.shape[0]
        whole: Any = self._bordered(self.stiffness - shift * self.mass)
        label = np.concatenate([self.blocks, np.zeros(m, int)])
        rows, columns = self.ties.nonzero()
        np.maximum.at(label, self.unknowns + rows, self.blocks[columns])
        edge, inner = np.flatnonzero(label == BORDER), np.flatnonzero(label != BORDER)
        count, rest = 0, whole[edge][:, edge].toarray()
        if inner.size:
            count = _negative(whole[inner][:, inner], label[inner])
        if inner.size and edge.size:
            from scipy.sparse.linalg import splu

            across = whole[inner][:, edge].toarray()
            rest -= across.T @ splu(whole[inner][:, inner].tocsc()).solve(across)
        return count + int(np.count_nonzero(np.linalg.eigvalsh(rest) < 0.0)) - m

    def _bordered(self, matrix):
        """[[A, k G^T], [k G, -k e]], k the size of A."""
        from scipy.sparse import bmat, identity

        m = self.ties.shape[0]
        if m == 0:
            return matrix.tocsc()
        size = float(abs(matrix).sum(axis=1).max())
        ties = size * self.ties
        return bmat([[matrix, ties.T], [ties, -YIELD * size * identity(m)]], format="csc")

    def _solver(self, matrix):
        """What turns forces (n, k) into the u (n, k) of A u + G^T T = f, G u = 0."""
        from scipy.sparse.linalg import splu

        (m, n), factors = self.ties.shape, splu(self._bordered(matrix))

        def solve(force):
            return factors.solve(np.concatenate([force, np.zeros((m, force.shape[1]))]))[:n]

        return solve

    def _untied(self) -> Float[np.ndarray, "n r"]:
        """Orthonormal columns of all that the ties let move."""
        if self.ties.shape[0] == 0:
            return np.eye(self.unknowns)
        _, sizes, rows = np.linalg.svd(self.ties.toarray(), full_matrices=True)
        return rows[int(np.count_nonzero(sizes > SAME)) :].T

    def _whole(self, free: np.ndarray, count: int) -> Float[np.ndarray, "n k"]:
        """The lowest vectors by way of all."""
        from scipy.linalg import eigh

        stiffness, mass = (free.T @ (matrix @ free) for matrix in (self.stiffness, self.mass))
        return free @ eigh(stiffness, mass, subset_by_index=(0, count - 1))[1]

    def _scaled(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors of the same space that are orthonormal by M, each cleared of earlier ones.

        So small modes come out of a step of inverse iteration that has blown up what rounding left in
        them of a mode that nothing resists, which comes first.
        """
        found = np.empty_like(vectors)
        for k, own in enumerate(vectors.T):
            own = own / np.sqrt(own @ (self.mass @ own))
            for _ in range(2):
                own = own - found[:, :k] @ (found[:, :k].T @ (self.mass @ own))
                own = own / np.sqrt(own @ (self.mass @ own))
            found[:, k] = own
        return found

    def _by_inverse(self, count: int, shift: float, solve) -> np.ndarray | None:
        """The lowest vectors by Lanczos on the inverse; None where it does not find all."""
        from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

        n = self.unknowns

        def inverse(force):
            return solve(np.reshape(force, (n, 1)))[:, 0]

        start = inverse(self.mass @ np.random.default_rng(0).standard_normal(n))
        wanted = count + SPARE
        for attempt in range(ATTEMPTS):
            room = min(n, (2 + attempt) * wanted + 20)
            operator = LinearOperator((n, n), matvec=inverse, dtype=float)  # pyright: ignore
            try:
                values, vectors = eigsh(
                    self.stiffness, wanted, self.mass, shift, v0=start, ncv=room, OPinv=operator
                )
            except ArpackNoConvergence:
                continue
            order = np.argsort(values)
            values, vectors = values[order], vectors[:, order]
            last = values[count - 1]
            edge = last - max(1e-6 * abs(last), 16.0 * abs(shift))
            missed = self.below(edge) - int(np.count_nonzero(values < edge))
            if missed == 0:
                return vectors[:, :count]
            wanted = min(wanted + abs(missed) + SPARE, n // 2)
        return None


def _negative(matrix, label: Int[np.ndarray, " n"]) -> int:
    """Number of negative eigenvalues of a sparse matrix whose blocks couple to neighbours alone."""
    matrix = matrix.tocoo()
    order = np.argsort(label, kind="stable")
    first = np.searchsorted(label[order], np.arange(label.max() + 1))
    slot = np.empty(label.size, int)
    slot[order] = np.arange(label.size) - first[label[order]]
    b = int(slot.max()) + 1
    shape = (int(label.max()) + 1, b, b)
    diagonal, lower = np.zeros(shape), np.zeros(shape)
    for part, step in ((diagonal, 0), (lower, 1)):
        here = label[matrix.row] - label[matrix.col] == step
        row, column = matrix.row[here], matrix.col[here]
        part[label[row], slot[row], slot[column]] = matrix.data[here]
    free = np.zeros(shape[:2], bool)
    free[label, slot] = True
    return SymmetricBlocks(diagonal, lower, free.ravel()).below(0.0)
