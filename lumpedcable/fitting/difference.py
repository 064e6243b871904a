"""Whether a derivative foretells what a small change does: the same by a central difference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Check", "checked"]

Array = NDArray[np.float64]

STEPS = (1e-3, 1e-5)  # relative changes: one that a person may make, one for the derivative itself
CLOSE = 0.05  # of the larger by which the two may differ: more than kinks and curvature leave


class Check(NamedTuple):
    """A relative derivative, and central differences over relative changes, the largest first.

    `share` and `differences` are per cent of the result per per cent of the number `key`; NaN where
    a changed run fails. The last difference is the first that is close, if any is.
    """

    key: str
    share: float
    steps: tuple[float, ...]
    differences: tuple[float, ...]

    @property
    def close(self) -> bool:
        """Whether the derivative is the difference over the smallest step that was tried."""
        return _close(self.share, self.differences[-1])

    @property
    def good(self) -> bool:
        """Whether it is so over the largest step, which a person may mean by a small change."""
        return _close(self.share, self.differences[0])

    def __str__(self) -> str:
        found = [
            f"over ±{100.0 * step:g} % " + (f"{d:+.4g}" if np.isfinite(d) else "none (a run fails)")
            for step, d in zip(self.steps, self.differences, strict=True)
        ]
        words = (
            f"By {self.key} the derivative is {self.share:+.4g} % per %, a difference "
            f"{' and '.join(found)}"
        )
        if self.good:
            return f"{words}."
        if self.close:
            return f"{words}: the derivatives hold for very small changes alone."
        return f"{words}: derivatives of this size do not foretell here what a change does."


def checked(
    keys: Sequence[str],
    values: Array,
    shares: Array,
    value: float,
    result: Callable[[Array], float],
) -> Check:
    """Compare the largest relative derivative with differences, over smaller changes until close.

    Args:
        keys: of the numbers.
        values: of the numbers, in SI.
        shares: relative derivatives of the result by them.
        value: the result, not zero.
        result: the result with other values of the numbers; NaN where that run fails.
    """
    k = int(np.argmax(np.abs(shares)))
    one = np.arange(values.size) == k
    tried: list[float] = []
    for step in STEPS:
        more, less = (result(values * (1.0 + x * one)) for x in (step, -step))
        tried.append((more - less) / (2.0 * step * value))
        if _close(shares[k], tried[-1]):
            break
    return Check(keys[k], float(shares[k]), STEPS[: len(tried)], tuple(tried))


def _close(share: float, difference: float) -> bool:
    return abs(difference - share) <= CLOSE * max(abs(share), abs(difference))
