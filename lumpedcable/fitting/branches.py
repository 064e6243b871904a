"""Branches of a material that relaxes: two that change places are the same material."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.arrays import Arrays, Spec
from lumpedcable.fitting.bounds import slopes
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.minimise import Found
from lumpedcable.fitting.transforms import to_unbounded, to_values

__all__ = ["as_begun", "in_order"]

Array = NDArray[np.float64]
ROUNDING = 1e-6  # relative difference of a loss and that of the same numbers in another order


def in_order(problem: FitProblem, places: Array) -> Array:
    """Places (count, p) with the times of a material's branches in the order of their starts.

    Two branches that change places are the same material, of which the file means one. Where bounds do
    not allow it they stay.
    """
    low, high, start = problem.ranges
    found = places.copy()
    for index in _times(problem):
        ranked = index[np.argsort(start[index], kind="stable")]
        turned = np.sort(places[:, ranked], axis=1)
        inside = np.all((low[ranked] < turned) & (turned < high[ranked]), axis=1)
        found[:, ranked] = np.where(inside[:, None], turned, places[:, ranked])
    return found


def as_begun(problem: FitProblem, spec: Spec, arrays: Arrays, found: Found) -> Found:
    """An end with the branches of each material in the order of their times at the start.

    On its way a search may lead the shorter of two times past the longer one, with a branch's EA going
    along. Only branches whose time and EA are both free change places, where bounds allow it.
    """
    low, high, start = problem.ranges
    where = {(p.key, p.experiment): k for k, p in enumerate(problem.parameters)}
    values = np.asarray(to_values(arrays.transform, found.z))
    turned = values.copy()
    for index in _times(problem):
        times = [problem.parameters[k] for k in index]
        stiff = [where.get((p.key.removesuffix("time") + "EA", p.experiment)) for p in times]
        free = [(k, own) for k, own in zip(index, stiff, strict=True) if own is not None]
        if len(free) < 2:
            continue
        both = np.array(free)
        begun, ended = (np.argsort(x[both[:, 0]], kind="stable") for x in (start, values))
        turned[both[begun]] = values[both[ended]]
    if np.array_equal(turned, values) or not np.all((low < turned) & (turned < high)):
        return found
    z = to_unbounded(arrays.transform, turned)
    residual, flat, slope = map(np.asarray, slopes(spec, arrays, z))
    before, after = (float(np.sum(r**2)) for r in (found.residual, residual))
    if not abs(after - before) <= ROUNDING * before:  # something else tells them apart
        return found
    return found._replace(z=z, residual=residual, flat=flat, slope=slope)


def _times(problem: FitProblem) -> Iterator[NDArray[np.int64]]:
    """Which parameters are the times of the branches of one material."""
    alike: dict[tuple[str, str | None], list[int]] = {}
    for k, p in enumerate(problem.parameters):
        if p.spread:
            alike.setdefault((p.key.split(".")[1], p.experiment), []).append(k)
    yield from map(np.array, alike.values())
