"""The start states of many runs: those that start alike are brought to rest together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import jax
import numpy as np
from numpy.typing import NDArray

from lumpedcable.model.numbers import number
from lumpedcable.study.batches import lanes
from lumpedcable.study.compiled import (
    Ready,
    Structure,
    prepare_batch,
    prepare_cells,
    prepare_many,
)
from lumpedcable.study.laying import Laid, equal_rows
from lumpedcable.study.packed import Form

__all__ = ["batched", "filled", "rows_of", "starts"]

CELL = 128  # runs that start alike, at most, in one cell of a batch
CELLS = 4  # cells of a batch
STATICS = 10  # steps of an output interval that statics may take as long as
FEWEST = 4  # runs in a cell on average for which cells are worth their lanes
SOME = 64  # runs of a study for which a program that is slow but soon compiled is the quicker one
Tree = TypeVar("Tree")


def starts(
    laid: Laid,
    structure: Structure,
    runs: NDArray[np.int64],
    expect: Callable[[Form], None] = lambda form: None,
) -> Ready:
    """Models at rest for runs of one structure, in their order; `expect` is told their form before.

    Numbers that most often do not move the equilibrium (when and how fast something breaks, drag)
    go beside the others: the compiled program then seeks the equilibrium once for all runs that
    differ in these alone. Where they do move it, it does so for each.
    """
    numbers = laid.study.runs.numbers(runs)
    beside = {key: v for key, v in numbers.items() if _is_late(key)}
    own = np.array([v for key, v in numbers.items() if key not in beside])
    cells = _cells(own.reshape(len(numbers) - len(beside), len(runs)).T) if beside else []
    if not cells or len(runs) < FEWEST * len(cells):
        sizes = laid.sizes_for(structure, [STATICS], [len(runs)])
        found = [
            rows_of(
                _prepare(laid, structure, runs[filled(mine, size)], (), expect),
                np.arange(len(mine)),
            )
            for mine, size in batched(np.arange(len(runs)), sizes)
        ]
        return _joined(found)
    found, order = [], []
    for first in range(0, len(cells), CELLS):
        group = cells[first : first + CELLS]
        table = np.array([filled(cell, CELL) for cell in group])
        table = np.pad(table, ((0, CELLS - len(group)), (0, 0)), mode="edge")
        ready = _prepare(laid, structure, runs[table], tuple(sorted(beside)), expect)
        used = np.concatenate([k * CELL + np.arange(len(c)) for k, c in enumerate(group)])
        found.append(rows_of(ready, used))
        order += group
    return rows_of(_joined(found), np.argsort(np.concatenate(order), kind="stable"))


def _is_late(key: str) -> bool:
    """Whether a number, most often, says nothing about the equilibrium."""
    event = key.startswith("events.") and not key.endswith(".place")
    past = key.startswith("materials.") and ".relaxation." in key
    return event or past or ".drag." in key or ".added_mass." in key or key.startswith("solver.")


def _cells(table: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Rows of equal numbers, at most CELL in each cell."""
    return [g[k : k + CELL] for g in equal_rows(table) for k in range(0, len(g), CELL)]


def _prepare(
    laid: Laid,
    structure: Structure,
    runs: NDArray[np.int64],
    late: tuple[str, ...],
    expect: Callable[[Form], None],
) -> Ready:
    """Static equilibria of a batch of runs (runs,), or with late numbers of cells (cells, runs)."""
    scene = structure.scene
    numbers = {
        key: values.reshape(runs.shape)
        for key, values in laid.study.runs.numbers(runs.ravel()).items()
    }
    numbers["output.duration"] = np.full(runs.shape, scene.output.duration)
    beside = {key: numbers[key] for key in late}
    swept = {
        key: values if runs.ndim == 1 else values[:, 0]
        for key, values in numbers.items()
        if key not in beside
    }
    shared = {key: number(v) for key, v in scene.numbers().items() if key not in numbers}
    axes, origin = laid.coordinates.axes, laid.coordinates.origin
    common = structure, scene.solver.dtype, axes, origin, shared, swept
    given = (*common, beside) if beside else common
    few = prepare_batch if len(laid.study.runs) <= SOME else prepare_many
    program = prepare_cells if beside else few
    expect(program.eval_shape(*given).packed.form)
    return program(*given)


def _joined(found: list[Ready]) -> Ready:
    return jax.tree.map(lambda *x: np.concatenate(x), *found) if len(found) > 1 else found[0]


def rows_of(batch: Tree, rows: NDArray[np.int64]) -> Tree:
    """Chosen rows of all arrays of a batch; the first ones, in their order, are not copied."""
    count = rows.size
    first = rows.ndim == 1 and count > 0 and np.array_equal(rows, np.arange(count))
    chosen = slice(count) if first else rows
    return jax.tree.map(lambda x: np.asarray(x)[chosen], batch)


def batched(
    rows: NDArray[np.int64], sizes: tuple[int, ...]
) -> Iterator[tuple[NDArray[np.int64], int]]:
    """Rows cut into batches, each with the lanes of its batch."""
    first = 0
    for size in lanes(len(rows), sizes):
        yield rows[first : first + size], size
        first += size


def filled(rows: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Rows, and the last one again up to `size`."""
    return np.pad(rows, (0, size - len(rows)), mode="edge")
