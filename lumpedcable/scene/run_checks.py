"""Checks of the runs of a sweep, all of them or, of very many, the ones at its edges."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lumpedcable.scene.part import Path, Problem
from lumpedcable.scene.runs import Factor, by_path, with_values
from lumpedcable.scene.validate import read_scene

CHECKED = 1000
"""Up to this many runs are all checked when a file is read; beyond it, row by row and the corners."""


def run_problems(
    data: dict[str, Any],
    factors: Sequence[Factor],
    places: Mapping[str, Callable[[int], Path]],
    known: Iterable[Problem],
) -> list[Problem]:
    """Return what is wrong in the runs of a sweep but not in the file's own scene."""
    told = {problem.path for problem in known}
    points = list(_looked_at(factors))
    # Problems by where they are told: the swept value itself, or a value that it does not fit.
    found_at: dict[Path, list[tuple[str, tuple[int, ...]]]] = {}
    runs_of: dict[Path, int] = {}
    for rows in points:
        values, swept = {}, {}
        for factor, row in zip(factors, rows, strict=True):
            values |= by_path(factor.at(row))
            swept |= {axis.path: places[axis.key](row) for axis in factor.axes}
        for place in set(swept.values()):
            runs_of[place] = runs_of.get(place, 0) + 1
        for problem in read_scene(with_values(data, values))[1]:
            if problem.path not in told:
                place = swept.get(problem.path, problem.path)
                found_at.setdefault(place, []).append((problem.message, rows))
    problems = []
    for place, failures in found_at.items():
        message, rows = failures[0]
        if len(failures) < runs_of.get(place, math.inf):
            run = ", ".join(f.text(row) for f, row in zip(factors, rows, strict=True))
            message = f"{message} (in the run with {run})"
        problems.append(Problem(place, message))
    return problems


def _looked_at(factors: Sequence[Factor]) -> Iterable[tuple[int, ...]]:
    """Return the rows of the runs that are checked when a file is read."""
    shape = list(map(len, factors))
    if math.prod(shape) <= CHECKED:
        return itertools.product(*map(range, shape))
    one_by_one = (
        tuple(row if other == moved else 0 for other in range(len(shape)))
        for moved, factor in enumerate(factors)
        for row in _rows(factor)
    )
    corners = itertools.islice(itertools.product(*({0, n - 1} for n in shape)), CHECKED)
    return dict.fromkeys(itertools.chain(one_by_one, corners))


def _rows(factor: Factor) -> Iterable[int]:
    """Return rows to check: all, or of very many the extremes of every key and a share between."""
    if len(factor) <= CHECKED:
        return range(len(factor))
    ends = [int(f(axis.values)) for axis in factor.axes for f in (np.argmin, np.argmax)]
    return sorted({*ends, *range(0, len(factor), -(-len(factor) // CHECKED))})
