"""Checks of the numbers that the closed forms are given; they tell the first that is wrong."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Values = NDArray[Any]
"""Array of float64, or of complex128 where derivatives are carried."""

NO_LINE = "found no line for these numbers"


def finite(**numbers: ArrayLike) -> None:
    """Raise ValueError where one of the numbers, called by their names, is NaN or infinite."""
    for name, value in numbers.items():
        real = np.real(np.asarray(value))
        hold(np.isfinite(real), f"expected a finite {name}, found {{:g}}", real)


def positive(name: str, unit: str, value: ArrayLike) -> None:
    """Raise ValueError where a number is not positive and finite."""
    real = np.real(np.asarray(value))
    hold((real > 0.0) & np.isfinite(real), f"expected a positive {name}, found {{:g}} {unit}", real)


def hold(good: Values, message: str, *values: Values) -> None:
    """Raise ValueError with the values of the first element that is not good."""
    if not np.all(good):
        first = int(np.argmin(np.ravel(good)))
        told = [float(np.ravel(np.broadcast_to(v, np.shape(good)))[first]) for v in values]
        raise ValueError(message.format(*told))


def reaching(span: Values, drop: Values, length: Values, what: str = "a length S") -> None:
    """Raise ValueError where a length (m) is not over the distance of the ends, sqrt(l^2 + c^2)."""
    chord, real = np.hypot(np.real(span), np.real(drop)), np.real(length)
    message = f"expected {what} over the distance of the ends, {{:g}} m, found {{:g}} m"
    hold(real > chord, message, chord, real)
