"""A shape at rest for the live page: what it draws, and the numbers that it shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.page.controls import FaultError
from lumpedcable.results.human import scale

__all__ = ["NO_SHAPE", "drawn_line", "shown_number"]

NO_SHAPE = "these numbers have no shape at rest that can be worked out"  # no JSON has inf or NaN


def drawn_line(
    name: str,
    position: NDArray[Any],
    tension: ArrayLike,
    place: ArrayLike,
    ends: ArrayLike,
    length: float,
    diameter: float = 0.0,
) -> dict[str, Any]:
    """A line for the page.

    Args:
        name: its name.
        position: places (m), shape (node, 3).
        tension: of the segments between them (N), shape (segment,).
        place: distance along the line of the segments' middles (m), shape (segment,).
        ends: tension at its two ends (N), as the read-outs have it.
        length: of the whole line, as `place` counts it (m).
        diameter: m.

    Raises:
        FaultError: a number is not finite.
    """
    if not all(np.isfinite(values).all() for values in (position, tension, place, ends, length)):
        raise FaultError(NO_SHAPE)
    return {
        "name": name,
        "diameter": diameter,
        "length": float(length),
        "position": np.asarray(position, float).tolist(),
        "tension": np.asarray(tension, float).tolist(),
        "ends": np.asarray(ends, float).tolist(),
        "place": np.asarray(place, float).tolist(),
    }


def shown_number(
    key: str, words: str, value: float, unit: str, second: float | None = None
) -> dict[str, Any]:
    """A read-out: SI value with the factor and unit to show it in; `second` is an approximation.

    Raises:
        FaultError: a value is not finite.
    """
    if not (np.isfinite(value) and (second is None or np.isfinite(second))):
        raise FaultError(NO_SHAPE)
    largest = max(abs(value), abs(second or 0.0))
    factor, text = (1.0, unit) if unit in ("m", "deg") else scale(largest, unit)
    if unit == "N":  # kilonewtons throughout, so that digits keep their place under a slider
        factor, text = 1e-3, "kN"
    return {
        "key": key, "words": words, "value": value, "second": second,
        "factor": factor, "unit": text, "top": largest * factor,
    }  # fmt: skip
