"""Which of many numbers the page keeps beside an even choice of them: what is extreme."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.spread import even

__all__ = ["extremes", "with_peaks"]

Array = NDArray[Any]


def with_peaks(count: int, most: int, histories: Iterable[Array]) -> Array:
    """As `even`, with the places of the histories' largest values among them, if there are so few.

    Args:
        count: how many values each history has.
        most: how many places at most; peaks take half of them at most.
        histories: each of shape (count,); NaN is no value.
    """
    if count <= most:
        return np.arange(count)
    peaks = np.unique([np.nanargmax(h) for h in histories if np.isfinite(h).any()]).astype(int)
    peaks = peaks[even(len(peaks), most // 2)]
    return np.union1d(even(count, most - len(peaks)), peaks)


def extremes(time: Array, values: Array) -> Array:
    """[[time, value] of the smallest, of the largest] of a history, NaN where it has no value."""
    if not np.isfinite(values).any():
        return np.full((2, 2), np.nan)
    places = [np.nanargmin(values), np.nanargmax(values)]
    return np.column_stack([time[places], values[places]])
