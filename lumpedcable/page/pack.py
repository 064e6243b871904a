"""Arrays for the page: one compressed block of numbers, and where in it each array lies."""

from __future__ import annotations

import base64
import gzip
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Pack"]

_STEPS = 32000  # of a field on either side of its middle; a screen shows a tenth of that
_MISSING = -32768


class Pack:
    """Collects arrays; each `add` returns what the page needs to find its array again."""

    def __init__(self) -> None:
        self._blocks: list[bytes] = []
        self._size = 0

    def exact(self, values: ArrayLike) -> dict[str, Any]:
        """Numbers as float32, for read-outs and histories: seven digits."""
        return self._put(np.asarray(values, "<f4"), "f4", {})

    def field(self, values: ArrayLike) -> dict[str, Any]:
        """Numbers in 64000 steps over their range, for what is drawn; NaN stays NaN."""
        array = np.asarray(values, np.float64)
        good = np.isfinite(array)
        low = float(array.min(initial=np.inf, where=good))
        high = float(array.max(initial=-np.inf, where=good))
        low, high = (low, high) if low <= high else (0.0, 0.0)
        middle, step = (low + high) / 2, (high - low) / (2 * _STEPS) or 1.0
        steps = np.rint((np.where(good, array, middle) - middle) / step)
        packed = np.where(good, steps, _MISSING).astype("<i2")
        return self._put(packed, "i2", {"step": step, "middle": middle})

    def _put(self, array: NDArray[Any], kind: str, how: dict[str, Any]) -> dict[str, Any]:
        pad = -self._size % 4  # typed arrays start at multiples of their item
        block = bytes(pad) + array.tobytes()
        found = {"kind": kind, "start": self._size + pad, "shape": list(array.shape), **how}
        self._blocks.append(block)
        self._size += len(block)
        return found

    def text(self) -> str:
        """The block, gzipped, as base64."""
        packed = gzip.compress(b"".join(self._blocks), 6, mtime=0)
        return base64.b64encode(packed).decode("ascii")
