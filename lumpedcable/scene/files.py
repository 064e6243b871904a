"""Lists that a scene keeps in CSV files: tension tables and recorded motions.

Their columns have names that are given here, with their units in brackets or in SI: see
:mod:`lumpedcable.scene.columns`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path as FilePath
from typing import Any

from lumpedcable.scene.columns import misspelt, places_of, read_header, read_rows, renamed, rising
from lumpedcable.scene.motions import FREEDOMS, SHIFTS
from lumpedcable.scene.part import SIDES, Path, Problem
from lumpedcable.scene.texts import FileError, named_file

__all__ = ["fill"]

TABLE = {"strain": "", "tension": "N"}
MOTION = {"t": "s", "x": "m", "y": "m", "z": "m"}
"""Columns, and their units in SI."""
RESPONSES = {"motion": ("", "rad/m"), "waves": ("N/m", "N")}
"""Units of what a metre of wave gives along an axis, and about it."""


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
        targets = tuple(TABLE) if columns is TABLE else ("time", "position")
        double = [key for key in targets if key in table]
        if double:
            problems.append(
                Problem(
                    (*path, double[0]),
                    f"expected {' and '.join(targets)}, or file, found both",
                )
            )
        try:
            file = named_file(folder, table["file"])
            numbered = read_rows(file, tuple(columns), tuple(columns.values()))
            rising(numbered, *(("strains", "") if columns is TABLE else ("times", " s")), file)
        except FileError as fault:
            problems.append(Problem((*path, "file"), str(fault)))
            continue
        rows = [row for _, row in numbered]
        first = [row[0] for row in rows]
        rest = [row[1] if columns is TABLE else list(row[1:]) for row in rows]
        table |= dict(zip(targets, (first, rest), strict=True))
    return problems


def _tables(data: dict[str, Any]) -> Iterator[tuple[Path, dict[str, Any], dict[str, str]]]:
    """Yield (path, raw table, columns wanted with their units) of everything that names a file."""
    for name, material in _entries(data, "materials"):
        if material.get("law") == "table" and isinstance(material.get("file"), str):
            yield ("materials", name), material, TABLE
    for name, line in _entries(data, "lines"):
        for side in SIDES:
            end = line.get(side)
            motion = end.get("motion") if isinstance(end, dict) else None
            if isinstance(motion, dict) and isinstance(motion.get("file"), str):
                yield ("lines", name, side, "motion"), motion, MOTION


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
        file = named_file(folder, motion[key])
        header = read_header(file, (first,))
        named = [name for name in FREEDOMS if places_of(name, header)]
        if not named:
            raise FileError(
                f"expected the columns {first} and any of {', '.join(FREEDOMS)}, "
                f"found {', '.join(header)} in {file.name}{renamed((first, *FREEDOMS), header)}"
            )
        for name, cell in misspelt(FREEDOMS, header).items():
            raise FileError(
                f'expected the column "{name}", found "{cell}" in {file.name}; rename it, for another '
                "name if it is no such motion"
            )
        units = _units(named, None if key == "file" else str(path[-1]))
        columns = tuple(units)
        numbered = read_rows(file, columns, tuple(units.values()))
        rising(numbered, *(("times", " s") if key == "file" else ("frequencies", " rad/s")), file)
    except FileError as fault:
        return [*told, Problem((*path, key), str(fault))]
    rows = [row for _, row in numbered]
    table = dict(zip(columns, map(list, zip(*rows, strict=True)), strict=True)) if rows else {}
    if key == "file":
        motion |= {"time" if name == "t" else name: table.get(name, []) for name in columns}
        return told
    motion["omega"] = table.get("omega", [])
    motion["response"] = {
        name: [list(both) for both in zip(table[name], table[f"{name}_phase"], strict=True)]
        for name in named
        if table
    }
    return told


def _units(named: Iterable[str], response: str | None) -> dict[str, str]:
    """Return the columns of some freedoms with their units: of a record, or of a response."""
    if response is None:
        return {"t": "s"} | {name: "m" if name in SHIFTS else "rad" for name in named}
    shift, turn = RESPONSES[response]
    units = {"omega": "rad/s"}
    for name in named:
        units |= {name: shift if name in SHIFTS else turn, f"{name}_phase": "rad"}
    return units


def _entries(data: dict[str, Any], section: str) -> Iterator[tuple[str, dict[str, Any]]]:
    table = data.get(section)
    if isinstance(table, dict):
        yield from ((name, entry) for name, entry in table.items() if isinstance(entry, dict))
