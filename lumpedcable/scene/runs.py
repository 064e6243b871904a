"""The runs of a sweep: its axes, which of them move together, and the scene of every run.

Ten million runs are ten million rows of a few numbers, not ten million scenes: numbers are asked for
by column, a scene is built when somebody asks for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import ValidationError

from lumpedcable.scene import checks
from lumpedcable.scene.many import Apart, Many
from lumpedcable.scene.part import Path, dotted
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.units import format_quantity

ALONE = 16
"""Runs that are sooner checked one by one than together."""


@dataclass(frozen=True)
class Axis:
    """One swept number."""

    key: str
    """Dotted path in the scene: "lines.rope.end.held.pretension"."""
    values: Sequence[float]
    """Its values in SI, in order: a tuple, or a packed array where they are drawn."""
    unit: str
    """SI unit, "" for a pure number."""
    label: str
    """Short name for people: "rope pretension"."""

    @property
    def path(self) -> Path:
        """The key as a path."""
        return tuple(self.key.split("."))

    def text(self, index: int) -> str:
        """Return one value with its unit, for people."""
        return format_quantity(self.values[index], self.unit)


@dataclass(frozen=True)
class Factor:
    """Axes that move together: a run of the sweep takes one row of each factor."""

    axes: tuple[Axis, ...]
    kind: str = "list"
    """How it is written: "list", "cases", "zip" or "sample"."""
    names: tuple[str, ...] = ()
    """Names of its rows; none where they have none."""
    drawn: dict[str, Any] = field(default_factory=dict)
    """How its rows were drawn, in SI numbers; empty where they were not."""

    def __len__(self) -> int:
        return len(self.axes[0].values)

    def at(self, row: int) -> dict[str, float]:
        """Return the values of a row by key."""
        return {axis.key: axis.values[row] for axis in self.axes}

    def text(self, row: int) -> str:
        """Return a row for people: "events.break.time = 5 ms"."""
        return ", ".join(f"{axis.key} = {axis.text(row)}" for axis in self.axes)


def distinct(factors: list[Factor]) -> list[Factor]:
    """Return the factors with keys as labels where short labels would be the same."""
    labels = [axis.label for factor in factors for axis in factor.axes]
    return [
        replace(
            factor,
            axes=tuple(
                replace(axis, label=axis.key) if labels.count(axis.label) > 1 else axis
                for axis in factor.axes
            ),
        )
        for factor in factors
    ]


class Runs(Sequence[Scene]):
    """The scenes of a sweep in order, first factor slowest; each is built when it is asked for."""

    def __init__(self, data: dict[str, Any], factors: Sequence[Factor], base: Scene):
        self._data = {key: value for key, value in data.items() if key != "references"}
        self.factors: tuple[Factor, ...] = tuple(factors)
        self._base = base
        self._shape = tuple(map(len, factors))
        self.axes: tuple[Axis, ...] = tuple(axis for factor in factors for axis in factor.axes)
        self._whole = frozenset(a.key for a in self.axes if isinstance(a.values[0], int))

    def __len__(self) -> int:
        return math.prod(self._shape)

    @overload
    def __getitem__(self, index: int) -> Scene: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Scene, ...]: ...
    def __getitem__(self, index: int | slice) -> Scene | tuple[Scene, ...]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        if not -len(self) <= index < len(self):
            raise IndexError(f"run {index} of {len(self)}")
        if not self.factors:
            return self._base
        values = self.values(index % len(self))
        return self._base.with_numbers(values) if self._plain else self._read(values)

    def _read(self, values: dict[str, float]) -> Scene:
        scene = Scene.model_validate(with_values(self._data, by_path(values)))
        return scene.model_copy(update={"references": self._base.references})

    @property
    def _plain(self) -> bool:
        """Whether a run's scene is the common one with its swept numbers put in."""
        return not self._whole and not self._followed

    @cached_property
    def _judged(self) -> frozenset[str]:
        """The swept numbers that results are compared with, which move nothing."""
        known = self._base.numbers().keys() | self._whole
        return frozenset(axis.key for axis in self.axes if axis.key not in known)

    @cached_property
    def moved(self) -> frozenset[str]:
        """The numbers that differ between runs, by key: the swept ones and what follows from them.

        A direction is made a unit vector when it is read, so that one component moves all three.
        """
        found = {axis.key for axis in self.axes} | self._followed
        return frozenset(found - self._whole - self._judged)

    @cached_property
    def _followed(self) -> frozenset[str]:
        """The numbers that reading a run makes others than those put in, by key.

        Swept ones too: three components of a direction are each divided by its length.
        """
        found: set[str] = set()
        for axis in self.axes:
            if axis.key in self._whole:
                continue
            low, high = min(axis.values), max(axis.values)
            # between them, too: of length 1 a direction may be at both ends alone
            for value in {low, high, low + 0.382 * (high - low)}:
                known = self._base.with_numbers({axis.key: value}).numbers()
                try:
                    read = self._read({axis.key: value}).numbers()
                except ValidationError:
                    continue  # right only beside another number: told when the file was read
                found |= {key for key in read if read[key] != known.get(key)}
        return frozenset(found)

    def indices(self, run: int) -> tuple[int, ...]:
        """Return the row of a run in each factor."""
        return tuple(int(i) for i in np.unravel_index(run, self._shape)) if self._shape else ()

    def values(self, run: int) -> dict[str, float]:
        """Return the swept values of a run in SI, by key."""
        found: dict[str, float] = {}
        for factor, row in zip(self.factors, self.indices(range(len(self))[run]), strict=True):
            found |= factor.at(row)
        return found

    def numbers(self, runs: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Return the numbers of :attr:`moved` in SI of chosen runs, each of shape (len(runs),)."""
        if self._plain:
            return {k: column for k, column in self.columns(runs).items() if k in self.moved}
        found = [self[int(run)].numbers() for run in np.asarray(runs)]
        return {key: np.array([numbers[key] for numbers in found]) for key in sorted(self.moved)}

    def columns(self, runs: ArrayLike) -> dict[str, NDArray[Any]]:
        """Return the swept values in SI of chosen runs by key, each of shape (len(runs),)."""
        if not self.factors:
            return {}
        rows = np.unravel_index(np.asarray(runs), self._shape)
        return {
            axis.key: np.asarray(axis.values)[mine]
            for factor, mine in zip(self.factors, rows, strict=True)
            for axis in factor.axes
        }

    def problem(self, run: int) -> str | None:
        """Return what is wrong with a run, or None."""
        try:
            found = next(checks.problems(checks.Draft.of(self[run], self._sound)), None)
        except ValidationError as error:
            return str(error.errors()[0]["msg"])
        return None if found is None else f"{dotted(found.path)}: {found.message}"

    def problems(self, runs: ArrayLike) -> dict[int, str]:
        """Return what is wrong with chosen runs, by run; of those that are right there is nothing.

        Runs that take the same way through the checks are checked together, as long as all are right.
        """
        found: dict[int, str] = {}
        groups = [np.asarray(runs)]
        while groups:
            some = groups.pop()
            parts = self._ways(some) if self._plain and len(some) > ALONE else None
            if parts is None:
                wrong = {int(run): self.problem(int(run)) for run in some}
                found |= {run: words for run, words in wrong.items() if words is not None}
            groups += parts or []
        return found

    def _ways(self, runs: NDArray[np.int64]) -> list[NDArray[np.int64]] | None:
        """Return the runs, parted, if they take different ways through the checks, [] if all are right.

        None: there is something wrong with all of them, or they cannot be checked together.
        """
        columns = self.columns(runs)
        values = {key: Many(column.astype(float)) for key, column in columns.items()}
        try:
            scene = self._base.with_numbers(values)
            wrong = next(checks.problems(checks.Draft.of(scene, self._sound)), None)
        except Apart as apart:
            return [runs[apart.where], runs[~apart.where]]
        except (TypeError, ArithmeticError):
            return None
        return [] if wrong is None else None

    @cached_property
    def _sound(self) -> frozenset[int]:
        """The parts of the common scene, which was found right: runs that share one need not ask it."""
        return frozenset(map(id, checks.parts_of(self._base)))

    def name(self, run: int) -> str:
        """Return the names of a run's rows, "" where they have none."""
        rows = zip(self.factors, self.indices(run), strict=True)
        return ", ".join(factor.names[row] for factor, row in rows if factor.names)

    @property
    def named(self) -> bool:
        """Whether runs have names."""
        return any(factor.names for factor in self.factors)

    @property
    def counts(self) -> frozenset[str]:
        """The swept keys that hold whole numbers, and so change the structure of a run."""
        return self._whole


def by_path(values: dict[str, float]) -> dict[Path, float]:
    """Return values by path instead of by dotted key."""
    return {tuple(key.split(".")): value for key, value in values.items()}


def with_values(data: dict[str, Any], values: dict[Path, Any]) -> dict[str, Any]:
    """Return raw data with values put in, missing tables made, and nothing changed in place."""
    for path, value in values.items():
        data = _put(data, path, value)
    return data


def _put(raw: Any, path: Path, value: Any) -> Any:
    if not path:
        return value
    key, rest = path[0], path[1:]
    if isinstance(raw, list):
        index = int(key)
        return [*raw[:index], _put(raw[index], rest, value), *raw[index + 1 :]]
    table = raw if isinstance(raw, dict) else {}
    return {**table, key: _put(table.get(key), rest, value)}
