"""The lowest eigenvalues of block tridiagonal matrices, against all of them."""

import numpy as np
import pytest
from scipy.linalg import eigh

from lumpedcable.solve import spectrum
from lumpedcable.solve.spectrum import SymmetricBlocks, lowest


def random_blocks(blocks, size, seed, held=0.1):
    rng = np.random.default_rng(seed)
    diagonal = rng.standard_normal((blocks, size, size))
    diagonal = diagonal + np.swapaxes(diagonal, 1, 2)
    lower = rng.standard_normal((blocks, size, size))
    return SymmetricBlocks(diagonal, lower, rng.random(blocks * size) > held)


def dense(matrix):
    """The matrix put together by hand."""
    m, b, _ = matrix.diagonal.shape
    full = np.zeros((m * b, m * b))
    for i in range(m):
        here, before = slice(i * b, (i + 1) * b), slice((i - 1) * b, i * b)
        full[here, here] = matrix.diagonal[i]
        if i:
            full[here, before] = matrix.lower[i]
            full[before, here] = matrix.lower[i].T
    return full[np.ix_(matrix.free, matrix.free)]


def chain(count, copies=1, spring=1.0):
    """A chain of unit masses between walls, `copies` of it side by side."""
    eye = np.eye(copies)
    return SymmetricBlocks(
        np.broadcast_to(2.0 * spring * eye, (count, copies, copies)).copy(),
        np.broadcast_to(-spring * eye, (count, copies, copies)).copy(),
        np.ones(count * copies, bool),
    )


@pytest.mark.parametrize(("blocks", "size"), [(1, 4), (7, 1), (40, 3), (60, 6)])
def test_the_sparse_matrix_is_the_matrix(blocks, size):
    matrix = random_blocks(blocks, size, 1)
    full = dense(matrix)
    assert matrix.sparse().toarray() == pytest.approx(full, abs=0.0)
    assert matrix.unknowns == len(full)
    assert matrix.bound() == pytest.approx(np.abs(full).sum(axis=1).max())
    every = np.linalg.eigvalsh(full)
    for shift in (-100.0, -1.0, 0.0, 0.3, 2.0, 100.0):
        assert matrix.below(shift) == np.count_nonzero(every < shift)


@pytest.mark.parametrize("limit", [0, 10_000])
def test_lowest_by_both_ways(monkeypatch, limit):
    monkeypatch.setattr(spectrum, "DENSE", limit)
    matrix = random_blocks(60, 3, 2)
    full = dense(matrix)
    every = np.linalg.eigvalsh(full)
    values, vectors, rounding = lowest(matrix, 7)
    assert values == pytest.approx(every[:7], abs=1e-11)
    assert np.all((rounding > 1e-15) & (rounding < 1e-12))
    assert full @ vectors == pytest.approx(vectors * values, abs=1e-10)
    assert vectors.T @ vectors == pytest.approx(np.eye(7), abs=1e-12)


def test_equal_eigenvalues_are_found_as_often_as_they_are_there(monkeypatch):
    monkeypatch.setattr(spectrum, "DENSE", 0)
    values, vectors, _ = lowest(chain(200, 3), 9)
    known = 4.0 * np.sin(np.arange(1, 4) * np.pi / 402) ** 2  # a chain of 200 masses
    assert values == pytest.approx(np.repeat(known, 3), rel=1e-9)
    assert vectors.T @ vectors == pytest.approx(np.eye(9), abs=1e-12)


def test_a_missed_one_is_noticed(monkeypatch):
    # a solver that always overlooks the lowest: its space is enlarged, and in the end not used
    import scipy.sparse.linalg as real

    honest, asked = real.eigsh, []

    def careless(matrix, k, **options):
        asked.append(k)
        values, vectors = honest(matrix, k, **options)
        order = np.argsort(values)[1:]
        return values[order], vectors[:, order]

    monkeypatch.setattr(real, "eigsh", careless)
    monkeypatch.setattr(spectrum, "DENSE", 0)
    values, _, _ = lowest(chain(60), 3)
    assert len(asked) == spectrum.ATTEMPTS
    assert asked == sorted(set(asked))
    assert values == pytest.approx(4.0 * np.sin(np.arange(1, 4) * np.pi / 122) ** 2, rel=1e-10)


def test_the_lowest_survive_the_rounding_of_the_largest():
    # a soft chain whose odd masses are 1e-12 of the others: the pencil's large eigenvalues drown
    # the small ones of a solver that looks at norms alone
    count = 30
    weight = np.where(np.arange(count) % 2, 1e6, 1.0)
    soft = chain(count)
    matrix = SymmetricBlocks(
        soft.diagonal * weight[:, None, None] ** 2,
        soft.lower * (weight * np.roll(weight, 1))[:, None, None],
        soft.free,
    )
    # with the light masses gone the heavy ones hang on springs of half the stiffness
    heavy = np.flatnonzero(weight == 1.0)
    full = dense(soft)
    light = np.flatnonzero(weight > 1.0)
    cross = full[np.ix_(heavy, light)]
    left = full[np.ix_(heavy, heavy)] - cross @ np.linalg.solve(full[np.ix_(light, light)], cross.T)
    known = np.linalg.eigvalsh(left)[:3]
    values, _, _ = lowest(matrix, 3)
    assert values == pytest.approx(known, rel=1e-10)
    plain = eigh(matrix.sparse().toarray(), eigvals_only=True)[:3]
    assert np.abs(plain / known - 1.0).max() > 1e-7  # what is gained


def test_more_than_there_are():
    values, vectors, _ = lowest(chain(3), 10)
    assert values == pytest.approx(4.0 * np.sin(np.arange(1, 4) * np.pi / 8) ** 2)
    assert vectors.shape == (3, 3)


def test_nothing_at_all_has_no_stiffness():
    values, vectors, rounding = lowest(chain(4, spring=0.0), 2)
    assert values.tolist() == rounding.tolist() == [0.0, 0.0]
    assert vectors.T @ vectors == pytest.approx(np.eye(2))
