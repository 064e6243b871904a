"""Measured columns: numbers in SI from a CSV file, or what is wrong with them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from lumpedcable.fitting.language import Column
from lumpedcable.scene.columns import factor_of, places_of, read_header, read_rows
from lumpedcable.scene.part import Path, Problem, did_you_mean
from lumpedcable.scene.quantities import Quantity, found
from lumpedcable.scene.texts import FileError
from lumpedcable.scene.units import format_quantity

__all__ = ["Columns", "check_history", "check_times", "noise_of", "read_data"]

MOST = 1e100
"""Largest size of a measured value in SI: squares of what is larger are no numbers any more."""
NOISES = (1e-12, 1e6)
"""Least and largest noise over the largest value: beyond, the data tell nothing, or more than digits."""


class Columns(NamedTuple):
    """Columns of a file in SI (columns, points), the line of each point, and the file's name."""

    values: NDArray[np.float64]
    lines: tuple[int, ...]
    name: str

    def at(self, point: int) -> str:
        """Where a point stands, for people."""
        return f"{self.name}:{self.lines[point]}"


def read_data(
    file: FilePath, path: Path, wanted: Sequence[tuple[Path, Column, str]]
) -> tuple[Columns | None, list[Problem]]:
    """Read columns of a file.

    Args:
        file: the CSV file.
        path: where the fit file names it.
        wanted: path in the fit file, column and SI unit of each.

    Returns:
        The columns in SI, None where there are problems; the problems.
    """
    problems: list[Problem] = []
    factors = []
    try:
        names = tuple(column.column for _, column, _ in wanted)
        header = read_header(file, names)
        wanted = [(where, _named(column, header), unit) for where, column, unit in wanted]
        for where, column, unit in wanted:
            factor, problem = _factor(where, column, unit)
            factors.append(factor)
            problems += [problem] if problem else []
        names = tuple(column.column for _, column, _ in wanted)
        missing = [_missing(where, column.column, header, file) for where, column, _ in wanted
                   if header and header.count(column.column) != 1]  # fmt: skip
        if missing:
            return None, problems + missing
        rows = read_rows(file, names)
    except FileError as error:
        return None, [*problems, Problem((*path, "file"), str(error))]
    if len(rows) < 2:
        message = f"expected at least 2 rows of numbers, found {len(rows)} in {file.name}"
        problems.append(Problem((*path, "file"), message))
    if problems:
        return None, problems
    with np.errstate(over="ignore"):  # told
        values = np.array([row for _, row in rows]).T * np.array(factors)[:, None]
    columns = Columns(values, tuple(line for line, _ in rows), file.name)
    huge = [_huge(columns, k, one) for k, one in enumerate(wanted) if np.any(abs(values[k]) > MOST)]
    return (None, huge) if huge else (columns, [])


def _named(column: Column, header: Sequence[str]) -> Column:
    """A column by its whole name, of which what stands before a unit in brackets is enough."""
    places = places_of(column.column, header)
    return column.model_copy(update={"column": header[places[0]]}) if len(places) == 1 else column


def _huge(columns: Columns, k: int, wanted: tuple[Path, Column, str]) -> Problem:
    """What is wrong with a column of sizes that nothing has."""
    where, column, unit = wanted
    point = int(np.argmax(abs(columns.values[k]) > MOST))
    size = f"{columns.values[k][point]:g} {unit}".strip()
    if not np.isfinite(columns.values[k][point]):
        size = "what is too large for a number"
    message = (
        f"expected values up to {MOST:g} {unit}".rstrip()
        + f" in column {column.column}, found {size} in {columns.at(point)}"
    )
    return Problem((*where, "column"), message)


def _missing(where: Path, name: str, header: Sequence[str], file: FilePath) -> Problem:
    """What is wrong with a column that a file does not have, or has twice."""
    if name in header:
        message = f"expected one column {found(name)} of {file.name}, found {header.count(name)}"
        return Problem((*where, "column"), message)
    hint = did_you_mean(name, header) or f"; it has {', '.join(header)}"
    return Problem(
        (*where, "column"), f"expected a column of {file.name}, found {found(name)}{hint}"
    )


def _factor(where: Path, column: Column, unit: str) -> tuple[float, Problem | None]:
    """The size of a column's unit in SI, and what is wrong with it."""
    place = (*where, "unit" if column.unit is not None else "column")
    try:
        return factor_of(column.column, unit, column.unit), None
    except FileError as fault:
        return 1.0, Problem(place, str(fault))


def check_times(columns: Columns, path: Path) -> list[Problem]:
    """What is wrong with the times in the first column: they start at 0 or later and increase."""
    times = columns.values[0]
    if times[0] < 0.0:
        message = (
            "expected times from 0, the start of the run, found "
            f"{format_quantity(times[0], 's')} in {columns.at(0)}"
        )
        return [Problem((*path, "time"), message)]
    wrong = np.flatnonzero(np.diff(times) <= 0.0)
    if not wrong.size:
        return []
    k = int(wrong[0]) + 1
    now, before = (format_quantity(times[i], "s") for i in (k, k - 1))
    what = f"{now} again" if times[k] == times[k - 1] else f"{now} after {before}"
    return [
        Problem((*path, "time"), f"expected times that increase, found {what} in {columns.at(k)}")
    ]


def check_history(columns: Columns, path: Path) -> list[Problem]:
    """What is wrong with a bench's strains, tensions and times, which are the columns.

    Times may stay, as at a jump, but not fall; and strains change, from where nothing has to relax.
    """
    strain, _, times = columns.values
    wrong = np.flatnonzero(np.diff(times) < 0.0)
    if not wrong.size and np.ptp(strain) == 0.0:
        message = (
            f"expected strains that change with time, found {strain[0]:g} alone in {columns.name}: "
            "begin with a row at the strain where the material was at rest"
        )
        return [Problem((*path, "strain"), message)]
    if not wrong.size:
        return []
    k = int(wrong[0]) + 1
    now, before = (format_quantity(times[i], "s") for i in (k, k - 1))
    message = f"expected times that never fall, found {now} after {before} in {columns.at(k)}"
    return [Problem((*path, "time"), message)]


def noise_of(
    raw: Any, values: NDArray[np.float64], unit: str, path: Path, column: Column
) -> tuple[float | None, Problem | None]:
    """The standard deviation in SI that a fit file gives, None where it gives none."""
    if raw is None:
        return None, None
    quantity, top = Quantity(unit, "positive"), float(np.max(np.abs(values)))
    try:
        if isinstance(raw, str) and raw.rstrip().endswith("%"):
            share = Quantity("", "positive").read(raw)
            if share * top == 0.0:
                message = (
                    f"expected a value other than 0 in column {column.column}, of whose largest "
                    f"{raw} is meant, found zeros alone; give the noise with a unit there"
                )
                return None, Problem(path, message)
            noise = share * top
        else:
            noise = quantity.read(raw)
    except PydanticCustomError:
        message = f"expected {quantity.expected} or a percentage, found {found(raw)}"
        return None, Problem(path, message)
    low, high = (share * top for share in NOISES)
    if top > 0.0 and not low <= noise <= high:
        low, high, told = (format_quantity(value, unit) for value in (low, high, noise))
        message = (
            f"expected a noise from {low} to {high}, since column {column.column} goes up to "
            f"{format_quantity(top, unit)}, found {told}"
        )
        return None, Problem(path, message)
    return noise, None
