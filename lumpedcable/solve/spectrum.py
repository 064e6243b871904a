"""The lowest eigenvalues of a block tridiagonal symmetric matrix, counted so that none is missed."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

__all__ = ["SymmetricBlocks", "lowest", "rounding", "told_apart"]

EPS = float(np.finfo(float).eps)
DENSE = 400  # unknowns up to which all eigenvalues are as cheap as a few
ATTEMPTS = 4  # of the iterative solver, each with a larger space, before all are computed
SPARE = 4  # vectors computed beyond those asked for: the last of a close group may come late


@dataclass(frozen=True)
class SymmetricBlocks:
    """A symmetric matrix A of blocks that couple to their neighbours alone.

    `diagonal` (m, b, b) and `lower` (m, b, b), of which lower[i] couples block i to block i - 1 and
    lower[0] is not used. `free` (m b,) marks the unknowns; the rows and columns of the others
    are not part of A.
    """

    diagonal: Float[np.ndarray, "m b b"]
    lower: Float[np.ndarray, "m b b"]
    free: np.ndarray

    @property
    def unknowns(self) -> int:
        """Number of rows of A."""
        return int(np.count_nonzero(self.free))

    def sparse(self):
        """A as a sparse matrix in compressed columns."""
        from scipy.sparse import coo_matrix

        b = self.diagonal.shape[1]
        place = np.cumsum(self.free) - 1
        rows, columns, values = [], [], []
        for blocks, shift in ((self.diagonal, 0), (self.lower[1:], 1)):
            first = np.arange(blocks.shape[0])[:, None, None] * b
            row = np.broadcast_to(first + shift * b + np.arange(b)[:, None], blocks.shape)
            column = np.broadcast_to(first + np.arange(b), blocks.shape)
            keep = (blocks != 0.0) & self.free[row] & self.free[column]
            rows.append(place[row[keep]])
            columns.append(place[column[keep]])
            values.append(blocks[keep])
            if shift:
                rows.append(columns[-1])
                columns.append(rows[-2])
                values.append(values[-1])
        n = self.unknowns
        entries = (np.concatenate(rows), np.concatenate(columns))
        return coo_matrix((np.concatenate(values), entries), shape=(n, n)).tocsc()

    def bound(self) -> float:
        """The largest row sum of |A|: no eigenvalue is larger in size."""
        matrix = abs(self.sparse())
        return float(matrix.sum(axis=1).max()) if matrix.nnz else 0.0

    def below(self, shift: float) -> int:
        """Number of eigenvalues below `shift`, from the signs of the pivots of A - shift I.

        Block elimination is a congruence, and Sylvester's law of inertia keeps the signs
        (Haynsworth, Linear Algebra Appl. 1, 1968): exact but for rounding, in O(m b^3).
        """
        m, b, _ = self.diagonal.shape
        free = self.free.reshape(m, b)
        both = free[:, :, None] & free[:, None, :]
        diagonal = np.where(both, self.diagonal - shift * np.eye(b), np.eye(b))
        lower = self.lower[1:] * (free[1:, :, None] & free[:-1, None, :])
        tiny = np.finfo(float).tiny ** 0.5
        count, pivot = 0, diagonal[0]
        for row in range(m):
            values, vectors = np.linalg.eigh(pivot)
            values = np.where(np.abs(values) < tiny, tiny, values)
            count += int(np.count_nonzero(values < 0.0))
            if row + 1 < m:
                carried = lower[row] @ vectors
                pivot = diagonal[row + 1] - (carried / values) @ carried.T
        return count


def lowest(
    matrix: SymmetricBlocks, count: int
) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, "n k"], Float[np.ndarray, " k"]]:
    """The k = min(count, n) algebraically lowest eigenvalues, their vectors, and what rounding is.

    Small matrices are solved whole. Large ones by Lanczos on the inverse of A - shift I with the
    shift below the whole spectrum (ARPACK), and checked by `SymmetricBlocks.below`: equal
    eigenvalues, such as those of a string in space, are found as often as they are there. Two
    steps of inverse iteration then clear the vectors of what the largest eigenvalues left in them.

    Returns:
        eigenvalues, ascending; orthonormal vectors v (n, k); and sum |v_i A_ij v_j| times some
        rounding errors, the accuracy that each eigenvalue can have.
    """
    n = matrix.unknowns
    count = min(count, n)
    sparse = matrix.sparse()
    size = matrix.bound()
    if size == 0.0:
        return np.zeros(count), np.eye(n, count), np.zeros(count)
    shift = -64.0 * EPS * size
    while matrix.below(shift) > 0:
        shift *= 64.0
    found = None
    if n > DENSE and count + SPARE < n // 2:
        found = _by_inverse(matrix, sparse, count, shift)
    vectors = _whole(sparse, count) if found is None else found
    values, vectors = _refined(sparse, vectors, shift)
    return values, vectors, rounding(sparse, vectors)


def rounding(sparse, vectors: np.ndarray) -> np.ndarray:
    """16 rounding errors of sum |v_i A_ij v_j|, for each vector v."""
    return 16.0 * EPS * np.sum(np.abs(vectors) * (abs(sparse) @ np.abs(vectors)), axis=0)


def _whole(sparse, count: int) -> np.ndarray:
    """The lowest vectors by way of all."""
    from scipy.linalg import eigh

    return eigh(sparse.toarray(), subset_by_index=(0, count - 1))[1]


def _by_inverse(matrix: SymmetricBlocks, sparse, count: int, shift: float) -> np.ndarray | None:
    """The lowest vectors by Lanczos on the inverse; None where it does not find all."""
    from scipy.sparse.linalg import ArpackNoConvergence, eigsh

    n = matrix.unknowns
    first = np.random.default_rng(0).standard_normal(n)  # the same result every time
    wanted = count + SPARE
    for attempt in range(ATTEMPTS):
        room = min(n, (2 + attempt) * wanted + 20)
        try:
            values, vectors = eigsh(sparse, wanted, sigma=shift, ncv=room, v0=first)
        except ArpackNoConvergence:
            continue
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
        # everything clearly below the last one kept must have been found
        last = values[count - 1]
        edge = last - max(1e-6 * abs(last), rounding(sparse, vectors[:, count - 1]))
        missed = matrix.below(edge) - int(np.count_nonzero(values < edge))
        if missed == 0:
            return vectors[:, :count]
        wanted = min(wanted + abs(missed) + SPARE, n // 2)
    return None


def _refined(sparse, vectors: np.ndarray, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and vectors in the space of `vectors` after two inverse iterations.

    Where masses or stiffnesses differ by many orders of magnitude the lowest eigenvalues of the
    whole matrix are lost in the rounding of the largest; elimination, row by row, is not.
    """
    from scipy.sparse import identity
    from scipy.sparse.linalg import splu

    solver = splu((sparse - shift * identity(sparse.shape[0], format="csc")).tocsc())
    for _ in range(2):
        vectors, _ = np.linalg.qr(solver.solve(vectors))
    return told_apart(sparse, vectors)


def told_apart(
    sparse, vectors: Float[np.ndarray, "n k"]
) -> tuple[Float[np.ndarray, " k"], Float[np.ndarray, "n k"]]:
    """Eigenvalues, ascending, and vectors in the space of `vectors` (n, k), which are nearly those.

    Only those are mixed that differ by more than rounding then: beside the largest the lowest would be
    lost otherwise.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    form = vectors.T @ (sparse @ vectors)
    form = 0.5 * (form + form.T)
    values, doubt = np.diagonal(form).copy(), rounding(sparse, vectors)
    gap = np.abs(values[:, None] - values)
    mixed = form**2 > gap * np.minimum(doubt[:, None], doubt)
    _, label = connected_components(coo_matrix(mixed))
    vectors = vectors.copy()
    for group in (np.flatnonzero(label == k) for k in range(label.max() + 1)):
        values[group], turn = np.linalg.eigh(form[np.ix_(group, group)])
        vectors[:, group] = vectors[:, group] @ turn
    order = np.argsort(values, kind="stable")
    return values[order], vectors[:, order]
