"""Which of many things are shown where there is no room for all: an even choice of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["even"]


def even(count: int, most: int) -> NDArray[Any]:
    """Indices of at most `most` of `count` things, evenly spread, first and last among them."""
    if count <= most:
        return np.arange(count)
    return np.unique(np.linspace(0, count - 1, most).round().astype(int))
