"""Reads the input files of MoorDyn, both layouts: line types, points, lines and options.

What the columns mean is told by position, as MoorDyn itself has it; which of two layouts a table has, by
how many there are. Source: MoorDyn documentation, "Input Files" (moordyn.readthedocs.io).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf
from pathlib import Path

from lumpedcable.scene.errors import Fault, SceneError

__all__ = ["LineType", "Mooring", "MooringLine", "Point", "read_moordyn"]

# by section, what its header says; the first that fits is taken
HEADERS = {
    "end": r"NEED THIS LINE",
    "types": r"\bLINE\s+(TYPES|DICTIONARY)",
    "rod types": r"\bROD\s+(TYPES|DICTIONARY)",
    "bodies": r"\bBOD(IES|Y\s+(LIST|PROPERTIES))\b",
    "rods": r"\b(RODS|ROD\s+(LIST|PROPERTIES))\b",
    "points": r"\b(POINTS|POINT\s+(LIST|PROPERTIES)|(CONNECTION|NODE)S?(\s+PROPERTIES)?)\b",
    "lines": r"\b(LINES|LINE\s+(LIST|PROPERTIES))\b",
    "failure": r"\bFAILURE\b",
    "control": r"\bCONTROL\b",
    "external loads": r"\bEXTERNAL\s+LOADS\b",
    "options": r"\bOPTIONS\b",
    "outputs": r"\bOUTPUTS?\b",
}
HEAD_ROWS = 2  # of a table: names and units
LEFT = ("rod types", "bodies", "rods", "failure", "control", "external loads")
FIXED, COUPLED = ("fix", "fixed", "anchor"), ("vessel", "coupled", "fairlead", "ves", "cpld")
FREE = ("connect", "con", "free", "point")
KINDS = (
    dict.fromkeys(FIXED, "fixed") | dict.fromkeys(COUPLED, "coupled") | dict.fromkeys(FREE, "free")
)
# options whose place in a scene is another one, by what to do about it
WATER = {
    "wavekin": "give a scene its waves",
    "currents": "give a scene its current",
    "waterkin": "give a scene its current and waves",
    "seafloorfile": "give the bed a profile",
}


@dataclass(frozen=True)
class LineType:
    """A row of the line types: diameter (m), mass (kg/m), EA (N), damping and coefficients (-).

    `BA` is in N s, or where negative the share of critical damping with its sign turned; EI in N m2.
    """

    name: str
    diameter: float
    mass: float
    EA: float
    BA: float
    EI: float
    Cd: float
    Ca: float
    CdAx: float
    CaAx: float


@dataclass(frozen=True)
class Point:
    """A point: "fixed", "coupled" or "free", its place (m), mass (kg), volume (m3), CdA (m2) and Ca."""

    kind: str
    place: tuple[float, float, float]
    mass: float
    volume: float
    CdA: float
    Ca: float


@dataclass(frozen=True)
class MooringLine:
    """A line of so many segments from point `start` to point `end`, `length` (m) unstretched."""

    kind: str
    start: str
    end: str
    length: float
    segments: int


@dataclass
class Mooring:
    """What an input file holds, in `left` what of it is not taken over, and remarks, in words."""

    types: dict[str, LineType] = field(default_factory=dict)
    points: dict[str, Point] = field(default_factory=dict)
    lines: dict[str, MooringLine] = field(default_factory=dict)
    options: dict[str, float] = field(default_factory=dict)
    left: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def option(self, default: float, *names: str) -> float:
        """The value of an option by any of its names."""
        return next((self.options[name] for name in names if name in self.options), default)


@dataclass(frozen=True)
class Row:
    """A row of a table: its line in the file, from 1, and its words."""

    line: int
    words: list[str]


def read_moordyn(path: Path) -> Mooring:
    """Read an input file of MoorDyn.

    Raises:
        SceneError: it cannot be read, is none, or holds what has no counterpart in a scene.
    """
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise SceneError(
            [Fault(str(path), None, "", f"cannot be read: {error.strerror}")]
        ) from error
    return _Reader(str(path), text).mooring()


class _Reader:
    def __init__(self, file: str, text: str):
        self.file, self.faults = file, list[Fault]()
        self.sections = dict(_sections(text))

    def mooring(self) -> Mooring:
        found = Mooring()
        for section in ("types", "points", "lines"):
            if not self.sections.get(section):
                self.told(None, section, f"expected a table of {section}, found none")
        for row in self.table("types"):
            if self.wide(row, "types", 9):
                kind = self.line_type(row, found)
                found.types[kind.name] = kind
        self.misnamed(found)
        for row in self.table("points"):
            if self.wide(row, "points", 9):
                found.points[row.words[0]] = self.point(row)
        early = _is_early(self.sections.get("lines", []))
        for row in self.table("lines"):
            if self.wide(row, "lines", 6):
                found.lines[f"line{row.words[0]}"] = self.line(row, early, found)
        for row in self.sections.get("options", []):
            self.option(row, found)
        for section in LEFT:
            rows = len(list(self.table(section)))
            if rows:
                found.left.append(f"{rows} row{'s' * (rows > 1)} of {section}")
        if self.faults:
            raise SceneError(self.faults)
        return found

    # --- tables -----------------------------------------------------------------------------------

    def table(self, section: str) -> Iterator[Row]:
        yield from self.sections.get(section, [])[HEAD_ROWS:]

    def wide(self, row: Row, section: str, least: int) -> bool:
        if len(row.words) < least:
            words = f"expected at least {least} columns, found {len(row.words)}"
            self.told(row, section, words)
        return len(row.words) >= least

    def misnamed(self, found: Mooring) -> None:
        """Remark coefficients under names in the early order that are read in the late one."""
        rows = self.sections.get("types", [])
        if len(rows) <= HEAD_ROWS or len(rows[0].words) < 10:
            return
        named = rows[0].words[6:10]
        if named[0].lower().startswith("ca") and len(rows[HEAD_ROWS].words) >= 10:
            found.remarks.append(
                f"coefficients are taken as Cd, Ca, CdAx, CaAx, as MoorDyn takes them, which the file "
                f"calls {', '.join(named)}"
            )

    def line_type(self, row: Row, found: Mooring) -> LineType:
        name, *numbers = row.words
        # the early layout has no EI, and the coefficients in another order
        early = len(row.words) == 9
        keys = ("diameter", "mass", "EA", "BA")
        keys += ("Ca", "CaAx", "Cd", "CdAx") if early else ("EI", "Cd", "Ca", "CdAx", "CaAx")
        values = {"EI": 0.0}
        for key, word in zip(keys, numbers, strict=False):
            first, bar, _ = word.partition("|")
            if bar:
                found.left.append(f"the dynamic part of {key} of {name}, {word}")
            values[key] = self.number(row, f"{key} of {name}", first)
            if key in ("mass", "EA") and values[key] <= 0.0 and _number(first) is not None:
                words = f"expected a positive number, found {first}"
                self.told(row, f"{key} of {name}", words)
        return LineType(name, **values)

    def point(self, row: Row) -> Point:
        name, kind, *numbers = row.words
        if kind.lower() not in KINDS:
            known = ", ".join(("fixed", "coupled", "free"))
            words = f"expected a point that is {known}, found {kind!r}"
            self.told(row, f"point {name}", f"{words}: bodies and rods have no counterpart")
        if len(numbers) >= 10:  # the early layout has forces
            forces = [self.number(row, f"force of point {name}", word) for word in numbers[5:8]]
            if any(forces):
                self.told(row, f"point {name}", "expected no steady force on a point, found one")
            del numbers[5:8]
        x, y, z, *rest = (self.number(row, f"point {name}", word) for word in numbers[:7])
        return Point(KINDS.get(kind.lower(), "free"), (x, y, z), *rest)

    def line(self, row: Row, early: bool, found: Mooring) -> MooringLine:
        name, kind, *more = row.words
        length, segments, start, end = more[:4] if early else (more[2], more[3], *more[:2])
        if kind not in found.types:
            known = ", ".join(found.types)
            self.told(row, f"line {name}", f"expected a line type ({known}), found {kind!r}")
        for point in (start, end):
            if point not in found.points:
                words = f"expected the number of a point, found {point!r}"
                self.told(row, f"line {name}", f"{words}: bodies and rods have no counterpart")
        count = self.number(row, f"segments of line {name}", segments)
        if _number(segments) is not None and (count < 1.0 or count % 1.0):
            words = f"expected a whole number from 1 on, found {segments}"
            self.told(row, f"segments of line {name}", words)
        metres = self.number(row, f"length of line {name}", length)
        if _number(length) is not None and not 0.0 < metres < inf:
            words = f"expected a positive length (m), found {length}"
            self.told(row, f"length of line {name}", words)
        return MooringLine(kind, start, end, metres, int(count))

    def option(self, row: Row, found: Mooring) -> None:
        value, *names = row.words
        key = names[0].lower() if names else ""
        if key in WATER and value.strip('"') not in ("0", ""):
            found.left.append(f"{names[0]} = {value}: {WATER[key]}")
        number = _number(value)
        if number is not None:
            found.options[key] = number
        elif key == "wtrdpth":
            self.told(row, names[0], f"expected a depth (m), found {value!r}")

    # --- numbers ----------------------------------------------------------------------------------

    def number(self, row: Row, key: str, word: str) -> float:
        found = _number(word)
        if found is None:
            self.told(row, key, f"expected a number, found {word!r}")
        return found or 0.0

    def told(self, row: Row | None, key: str, words: str) -> None:
        self.faults.append(Fault(self.file, row and row.line, key, words))


def _sections(text: str) -> Iterator[tuple[str, list[Row]]]:
    """Yield each section that is known by name, with all of its rows."""
    name, rows = "", list[Row]()
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("--"):
            yield name, rows
            rows = []
            fits = (key for key, header in HEADERS.items() if re.search(header, line.upper()))
            name = next(fits, "")
        elif name and (words := _words(line, len(rows) < HEAD_ROWS and name != "options")):
            rows.append(Row(number, words))
    yield name, rows


def _words(line: str, head: bool) -> list[str]:
    """The words of a row without its comment; of names and units all, which may have such signs."""
    return (line if head else re.split(r"[!#%]", line, maxsplit=1)[0]).split()


def _is_early(rows: list[Row]) -> bool:
    """Whether the table of lines has lengths before points."""
    return (
        bool(rows)
        and len(rows[0].words) > 2
        and rows[0].words[2].lower().startswith(("unstr", "len"))
    )


def _number(word: str) -> float | None:
    try:
        return float(re.sub("[dD]", "e", word))
    except ValueError:
        return None
