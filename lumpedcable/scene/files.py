"""Lists that a scene keeps in CSV files: tension tables and recorded motions.

A file has one header line with the names of its columns, then numbers in SI. Empty lines and lines
that start with # are skipped.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

from lumpedcable.scene.motions import FREEDOMS
from lumpedcable.scene.part import SIDES, Path, Problem, did_you_mean
from lumpedcable.scene.quantities import found

TABLE_COLUMNS = ("strain", "tension")
MOTION_COLUMNS = ("t", "x", "y", "z")
NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
HDF5 = b"\x89HDF\r\n\x1a\n"  # how such a file begins


class FileError(Exception):
    """A file that cannot be used; the message follows "expected ... found"."""


def fill(data: dict[str, Any], folder: FilePath) -> list[Problem]:
    """Read every file that the raw data name, and put its columns beside the name.

    Args:
        data: the scene as TOML tables; changed in place.
        folder: what the names are relative to.

    Returns:
        The problems, one per file that cannot be used.
    """
    problems = []
    for path, motion in _ships(data):
        problems += _fill_ship(path, motion, folder)
    for path, table, columns in _tables(data):
        targets = TABLE_COLUMNS if columns is TABLE_COLUMNS else ("time", "position")
        double = [key for key in targets if key in table]
        if double:
            problems.append(
                Problem(
                    (*path, double[0]),
                    f"expected {' and '.join(targets)}, or file, found both",
                )
            )
        try:
            rows = read_columns(folder / table["file"], columns)
        except FileError as fault:
            problems.append(Problem((*path, "file"), str(fault)))
            continue
        first = [row[0] for row in rows]
        rest = [row[1] if columns is TABLE_COLUMNS else list(row[1:]) for row in rows]
        table |= dict(zip(targets, (first, rest), strict=True))
    return problems


def _tables(data: dict[str, Any]) -> Iterator[tuple[Path, dict[str, Any], tuple[str, ...]]]:
    """Yield (path, raw table, columns wanted) of everything that names a file."""
    for name, material in _entries(data, "materials"):
        if material.get("law") == "table" and isinstance(material.get("file"), str):
            yield ("materials", name), material, TABLE_COLUMNS
    for name, line in _entries(data, "lines"):
        for side in SIDES:
            end = line.get(side)
            motion = end.get("motion") if isinstance(end, dict) else None
            if isinstance(motion, dict) and isinstance(motion.get("file"), str):
                yield ("lines", name, side, "motion"), motion, MOTION_COLUMNS


def _ships(data: dict[str, Any]) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield (path, raw table) of every motion of a body, and of waves on one, that names a file."""
    for name, body in _entries(data, "bodies"):
        for part, keys in (("motion", ("file", "rao")), ("waves", ("rao",))):
            table = body.get(part)
            if isinstance(table, dict) and any(isinstance(table.get(key), str) for key in keys):
                yield ("bodies", name, part), table


def _fill_ship(path: Path, motion: dict[str, Any], folder: FilePath) -> list[Problem]:
    """Put the columns of a ship's record, or of its response, beside the name of the file."""
    key, first = ("rao", "omega") if "rao" in motion else ("file", "t")
    targets = ("omega", "response") if key == "rao" else ("time", *FREEDOMS)
    double = [target for target in targets if target in motion]
    told = [
        Problem((*path, target), f"expected {key} or {target}, found both") for target in double[:1]
    ]
    for target in double:  # else they would not fit what the file gives: one mistake, told once
        del motion[target]
    try:
        header = read_header(folder / motion[key])
        named = [name for name in FREEDOMS if name in header]
        if not named:
            raise FileError(
                f"expected the columns {first} and any of {', '.join(FREEDOMS)}, "
                f"found {', '.join(header)} in {FilePath(motion[key]).name}"
            )
        pairs = [(name, f"{name}_phase") if key == "rao" else (name,) for name in named]
        columns = (first, *(column for pair in pairs for column in pair))
        rows = read_columns(folder / motion[key], columns)
    except FileError as fault:
        return [*told, Problem((*path, key), str(fault))]
    table = dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True)) if rows else {}
    if key == "file":
        motion |= {"time" if name == "t" else name: table.get(name, []) for name in columns}
        return told
    motion["omega"] = table.get("omega", [])
    motion["response"] = {
        pair[0]: [list(both) for both in zip(*(table[name] for name in pair), strict=True)]
        for pair in pairs
        if table
    }
    return told


def _entries(data: dict[str, Any], section: str) -> Iterator[tuple[str, dict[str, Any]]]:
    table = data.get(section)
    if isinstance(table, dict):
        yield from ((name, entry) for name, entry in table.items() if isinstance(entry, dict))


def read_text(path: FilePath) -> str:
    """Return the text of a UTF-8 file.

    Raises:
        FileError: there is no such file, it is a directory, or it is not UTF-8 text.
    """
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        siblings = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = did_you_mean(path.name, [name for name in siblings if name.endswith(path.suffix)])
        raise FileError(f'expected a file, found none at "{path}"{hint}') from None
    except IsADirectoryError:
        raise FileError("expected a file, found a directory") from None
    except UnicodeDecodeError as error:
        if error.object.startswith(HDF5):
            raise FileError(
                "expected text, found a results file (HDF5): lumpedcable info, plot and view take it"
            ) from None
        line = error.object.count(b"\n", 0, error.start) + 1
        byte = error.object[error.start]
        raise FileError(f"expected UTF-8 text, found byte 0x{byte:02x} in line {line}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"expected a file that can be read, found: {reason}") from None


def read_header(path: FilePath) -> list[str]:
    """Return the names of the columns of a CSV file; none of an empty one. Raises FileError."""
    first = next(_lines(path), None)
    return [] if first is None else _cells(path, *first)


def read_columns(path: FilePath, columns: tuple[str, ...]) -> list[tuple[float, ...]]:
    """Return the rows of a CSV file, with the values of ``columns`` in that order.

    Raises:
        FileError: see :func:`read_rows`.
    """
    return [row for _, row in read_rows(path, columns)]


def read_rows(path: FilePath, columns: tuple[str, ...]) -> list[tuple[int, tuple[float, ...]]]:
    """Return the rows of a CSV file, each after its line number; see :func:`read_columns`.

    Raises:
        FileError: no file, a column that is missing or there twice, a row with more cells than the
            header, or something that is not a finite number.
    """
    kept = list(_lines(path))
    expected = f"expected the columns {', '.join(columns)}"
    if not kept:
        raise FileError(f"{expected}, found nothing in {path.name}")
    header = _cells(path, *kept[0])
    for column in columns:
        if column not in header:
            raise FileError(
                f"{expected}, found {', '.join(header)} in {path.name}:{kept[0][0]}"
                f"{did_you_mean(column, header)}"
            )
        if header.count(column) > 1:
            raise FileError(
                f"expected one column {column}, found {header.count(column)} of that name "
                f"in {path.name}:{kept[0][0]}"
            )
    return [(number, _row(path, number, line, columns, header)) for number, line in kept[1:]]


def _lines(path: FilePath) -> Iterator[tuple[int, str]]:
    """Yield the lines of a CSV file that hold anything, each after its number."""
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _cells(path: FilePath, number: int, line: str) -> list[str]:
    try:
        return [word.strip() for word in next(csv.reader([line], strict=True))]
    except csv.Error:
        raise FileError(
            f"expected cells of at most {csv.field_size_limit()} characters, every quote closed, "
            f"found {found(line.strip())} in {path.name}:{number}"
        ) from None


def _row(
    path: FilePath, number: int, line: str, columns: tuple[str, ...], header: list[str]
) -> tuple[float, ...]:
    words = _cells(path, number, line)
    if any(words[len(header) :]):
        # read on, a cell cut in two would be taken for a number a thousand times too small
        raise FileError(
            f"expected {len(header)} cells, as in the header, found {len(words)} "
            f"in {path.name}:{number}; write numbers with a decimal point, without separators "
            "of thousands"
        )
    row = []
    for column in columns:
        place = header.index(column)
        word = words[place] if place < len(words) else ""
        value = float(word) if NUMBER.fullmatch(word) else math.nan
        if not math.isfinite(value):
            given = found(word) if word else "nothing"
            raise FileError(
                f"expected a finite number in column {column}, found {given} "
                f"in {path.name}:{number}"
            )
        row.append(value)
    return tuple(row)
