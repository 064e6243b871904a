"""Columns of numbers in CSV files, and the units that their names may hold: "load (kN)".

A file has one header line with the names of its columns, then numbers, all between commas. Lines
that are empty, or of empty cells, and lines that start with # are skipped, but not rows that begin
with what a spreadsheet writes in place of a number, as #N/A.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path as FilePath
from typing import NamedTuple

from lumpedcable.scene.quantities import found
from lumpedcable.scene.texts import FileError, read_text
from lumpedcable.scene.units import Dimension, UnitError, describe, nearest, unit_of

__all__ = ["factor_of", "places_of", "read_header", "read_rows", "renamed", "rising"]

Rows = list[tuple[int, tuple[float, ...]]]
"""Values of the columns asked for, row by row, each after its line number."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_BRACKETS = re.compile(r"[(\[]([^()\[\]]+)[)\]]")
_SEPARATORS = {";": "semicolons", "\t": "tabs"}
_FAILED = re.compile(r"#(?:N/A|DIV/0!|REF!|VALUE!|NUM!|NAME\?|NULL!)", re.IGNORECASE)
"""What a spreadsheet writes where a formula has no number; other languages have other words."""


# --- units ---------------------------------------------------------------------------------------


def factor_of(name: str, unit: str, given: str | None = None) -> float:
    """Return the size in SI of the unit of a column; 1 where none is written.

    Args:
        name: the column's name, with its unit in brackets or without.
        unit: the SI unit of what it holds.
        given: the unit, where it is written elsewhere.

    Raises:
        FileError: what is written is no unit of that kind, or there are two.
    """
    in_name, told = _bracket(name)
    if given is None and told is not None:
        raise FileError(told)
    written = in_name if given is None else given
    if written is None:
        return 1.0
    wanted = unit_of(unit)[1]
    expected = f"expected a unit of {describe(wanted)}"
    try:
        factor, dimension = unit_of(written)
    except UnitError as error:
        raise FileError(f"{expected}, found {error}") from None
    if dimension != wanted:
        raise FileError(f'{expected}, found "{written}"')
    named = None if told is not None else _unit_or_none(in_name)
    if named is not None and named != (factor, dimension):
        raise FileError(f'expected the unit in the column\'s name, "{in_name}", found "{written}"')
    return factor


def _bracket(name: str) -> tuple[str | None, str | None]:
    """Return what stands in the brackets of a column's name as its unit, and what is wrong with it.

    Of several brackets the one that is a unit, wherever it stands; the last where none is.
    """
    brackets = [match.group(1) for match in _BRACKETS.finditer(name)]
    units = [text for text in brackets if _unit_or_none(text) is not None]
    if len({unit_of(text) for text in units}) > 1:
        return None, f'expected one unit in brackets, found "{units[0]}" and "{units[-1]}"'
    return (units or brackets or [None])[-1], None


def _unit_or_none(text: str | None) -> tuple[float, Dimension] | None:
    try:
        return None if text is None else unit_of(text)
    except UnitError:
        return None


# --- names ---------------------------------------------------------------------------------------


def places_of(name: str, header: Sequence[str]) -> list[int]:
    """Return which columns have a name: just so, or else before a unit in brackets."""
    exact = [k for k, cell in enumerate(header) if cell == name]
    return exact or [k for k, cell in enumerate(header) if _bare(cell) == name]


def _bare(cell: str) -> str:
    return _BRACKETS.sub("", cell).strip()


def misspelt(columns: Iterable[str], header: Sequence[str]) -> dict[str, str]:
    """Cells of a header, by the missing column that each would be but for its case or a unit behind."""
    found = {}
    for column in columns:
        like = re.compile(rf"{column}(?:[ _](?:mm|cm|m|deg|rad))?", re.IGNORECASE)
        cells = [cell for cell in header if like.fullmatch(_bare(cell))]
        if cells and not places_of(column, header):
            found[column] = cells[0]
    return found


def renamed(columns: Iterable[str], header: Sequence[str]) -> str:
    """Return '; rename "T" to "t"' for columns that are missing from a header, but resembled."""
    columns, pairs = list(columns), []
    spare = {_bare(cell): cell for cell in header if _bare(cell) not in columns}
    for column in columns:
        guess = None if places_of(column, header) else nearest(column, spare)
        if guess is not None:
            cell = spare.pop(guess)
            pairs.append(f'"{cell}" to "{cell.replace(guess, column, 1)}"')
    return f"; rename {', '.join(pairs)}" if pairs else ""


# --- files ---------------------------------------------------------------------------------------


class _Sheet(NamedTuple):
    """The lines of a CSV file that hold something: names of columns, and rows after their numbers."""

    name: str
    number: int
    header: list[str]
    rows: list[tuple[int, str]]


def read_header(path: FilePath, wanted: Sequence[str] = ()) -> list[str]:
    """Return the names of the columns of a CSV file; none of an empty one.

    Args:
        path: the file.
        wanted: columns that are looked for; where one is missing, other separators are noticed.

    Raises:
        FileError: no text, or other separators than commas.
    """
    return _sheet(path, wanted).header


def read_rows(path: FilePath, columns: Sequence[str], units: Sequence[str] | None = None) -> Rows:
    """Return the rows of a CSV file, with the values of ``columns`` in that order.

    Args:
        path: the file.
        columns: names of the columns.
        units: their SI units, where their names may have a unit in brackets that is not among
            ``columns``; values are then in SI. Without, names are as they stand and values too.

    Raises:
        FileError: no file, a column that is missing or there twice, a unit of another kind, a row
            with more cells than the header, or something that is not a finite number.
    """
    sheet = _sheet(path, columns)
    expected, header = f"expected the columns {', '.join(columns)}", sheet.header
    if not header:
        raise FileError(f"{expected}, found nothing in {sheet.name}")
    place = f"{sheet.name}:{sheet.number}"
    indices, factors = [], []
    for k, column in enumerate(columns):
        mine = [i for i in places_of(column, header) if units is not None or header[i] == column]
        if not mine:
            listed = ", ".join(header)
            raise FileError(f"{expected}, found {listed} in {place}{renamed(columns, header)}")
        if len(mine) > 1:
            raise FileError(
                f"expected one column {column}, found {len(mine)} of that name in {place}"
            )
        indices.append(mine[0])
        try:
            factors.append(1.0 if units is None else factor_of(header[mine[0]], units[k]))
        except FileError as fault:
            raise FileError(f"{fault} for column {column} in {place}") from None
    rows = [(number, _row(sheet, number, line, indices)) for number, line in sheet.rows]
    return [(n, tuple(x * f for x, f in zip(row, factors, strict=True))) for n, row in rows]


def rising(rows: Rows, what: str, unit: str, path: FilePath) -> None:
    """See that the first column increases.

    Args:
        rows: as read.
        what: what the column holds, "times".
        unit: its unit as it stands behind a number, " s".
        path: the file.

    Raises:
        FileError: it does not, with the line where.
    """
    for (_, before), (number, after) in pairwise(rows):
        if after[0] <= before[0]:
            raise FileError(
                f"expected {what} that increase, found {after[0]:g}{unit} after "
                f"{before[0]:g}{unit} in {path.name}:{number}"
            )


def _sheet(path: FilePath, wanted: Sequence[str]) -> _Sheet:
    lines = _filled(path)
    # comments before the header have no number of cells to be measured by
    first = next((k for k, (_, line) in enumerate(lines) if not _is_comment(line, 0)), None)
    if first is None:
        return _Sheet(path.name, 0, [], [])
    number, line = lines[first]
    other = _other_separator(line)
    try:
        header = _cells(path.name, number, line)
    except FileError:
        if other is None:
            raise
        header = []
    if other is not None and not all(places_of(name, header) for name in wanted):
        raise FileError(
            "expected columns separated by commas, and numbers with a decimal point, found "
            f"{other} in {path.name}:{number}"
        )
    rows = [(n, row) for n, row in lines[first + 1 :] if not _is_comment(row, len(header))]
    return _Sheet(path.name, number, header, rows)


def _filled(path: FilePath) -> list[tuple[int, str]]:
    """Return the lines that hold anything, each after its number."""
    lines: Iterator[tuple[int, str]] = enumerate(read_text(path).splitlines(), start=1)
    return [(number, line) for number, line in lines if line.strip(", \t")]


def _other_separator(line: str) -> str | None:
    """Return what separates the cells of a header line rather than commas do."""
    most = max(_SEPARATORS, key=line.count)
    return _SEPARATORS[most] if line.count(most) > line.count(",") else None


def _is_comment(line: str, cells: int) -> bool:
    """Return whether a line that starts with # is a remark, and not a row without its first number.

    Such a row begins with the word for it right behind the #, and has numbers in all other cells of
    as many as the header. A row of numbers behind a # is one that a person has taken out.
    """
    text = line.strip()
    if not text.startswith("#") or _FAILED.match(text):
        return False
    first, *others = text.split(",")
    a_row = len(others) == cells - 1 > 0 and all(_NUMBER.fullmatch(w.strip()) for w in others)
    word = first[1:2].strip() and not _NUMBER.fullmatch(first[1:].strip())
    return not (a_row and word)


def _cells(name: str, number: int, line: str) -> list[str]:
    try:
        return [word.strip() for word in next(csv.reader([line], strict=True))]
    except csv.Error:
        raise FileError(
            f"expected cells of at most {csv.field_size_limit()} characters, every quote closed, "
            f"found {found(line.strip())} in {name}:{number}"
        ) from None


def _row(sheet: _Sheet, number: int, line: str, indices: Iterable[int]) -> tuple[float, ...]:
    words, count = _cells(sheet.name, number, line), len(sheet.header)
    if any(words[count:]):
        # read on, a cell cut in two would be taken for a number a thousand times too small
        raise FileError(
            f"expected {count} cells, as in the header, found {len(words)} "
            f"in {sheet.name}:{number}; write numbers with a decimal point, without separators "
            "of thousands"
        )
    row = []
    for place in indices:
        word = words[place] if place < len(words) else ""
        value = float(word) if _NUMBER.fullmatch(word) else math.nan
        if not math.isfinite(value):
            given = found(word) if word else "nothing"
            hint = ""
            if word.startswith("#") and not _FAILED.match(word):
                hint = "; a remark begins with # and a space"
            elif _NUMBER.fullmatch(word.replace(",", "")):
                hint = "; write numbers with a decimal point, without separators of thousands"
            raise FileError(
                f"expected a finite number in column {sheet.header[place]}, found {given} "
                f"in {sheet.name}:{number}{hint}"
            )
        row.append(value)
    return tuple(row)
