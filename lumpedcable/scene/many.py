"""One number of many runs, for checks that take the same way for all of them."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Apart", "Many"]


class Apart(Exception):  # noqa: N818 (no error: the runs part ways)
    """A comparison that is true of some runs only: of those where `where` (runs,) is true."""

    def __init__(self, where: NDArray[np.bool_]):
        super().__init__("true of some runs only")
        self.where = where


def _arithmetic(function: Callable[[Any, Any], Any]) -> Any:
    def of(self: Many, other: Any) -> Many:
        if not isinstance(other, Many | float | int):
            return NotImplemented
        with np.errstate(all="ignore"):  # as Python's own numbers, which are silent too
            return Many(function(self.values, _plain(other)))

    return of


def _swapped(function: Callable[[Any, Any], Any]) -> Any:
    return _arithmetic(lambda mine, other: function(other, mine))


def _divided(above: Any, below: Any) -> Any:
    if _agreed(np.equal(below, 0.0)):
        raise ZeroDivisionError("division by zero")
    return above / below


def _compared(function: Callable[[Any, Any], Any]) -> Any:
    def of(self: Many, other: Any) -> bool:
        if not isinstance(other, Many | float | int):
            return NotImplemented
        return _agreed(function(self.values, _plain(other)))

    return of


class Many:
    """A float of many runs: what is the same of all is told, what differs raises `Apart`.

    It has arithmetic and comparisons and nothing else, so that code that needs more ends with a
    TypeError instead of going on with a number that is not every run's.
    """

    __slots__ = ("values",)
    __array_ufunc__ = None  # arrays have no place for it
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, values: NDArray[np.float64]):
        self.values = values

    __add__, __radd__ = _arithmetic(operator.add), _swapped(operator.add)
    __sub__, __rsub__ = _arithmetic(operator.sub), _swapped(operator.sub)
    __mul__, __rmul__ = _arithmetic(operator.mul), _swapped(operator.mul)
    __truediv__, __rtruediv__ = _arithmetic(_divided), _swapped(_divided)
    __lt__, __le__ = _compared(operator.lt), _compared(operator.le)
    __gt__, __ge__ = _compared(operator.gt), _compared(operator.ge)
    __eq__, __ne__ = _compared(operator.eq), _compared(operator.ne)

    def __neg__(self) -> Many:
        return Many(-self.values)

    def __pos__(self) -> Many:
        return self

    def __abs__(self) -> Many:
        return Many(np.abs(self.values))

    def __bool__(self) -> bool:
        return _agreed(self.values != 0.0)


def _plain(value: Any) -> Any:
    return value.values if isinstance(value, Many) else value


def _agreed(found: Any) -> bool:
    """What is found of all runs alike."""
    found = np.asarray(found)
    if found.all():
        return True
    if found.any():
        raise Apart(found)
    return False
