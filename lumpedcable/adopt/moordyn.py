"""Reads the input files of MoorDyn, both layouts: line types, points, lines and options.

What the columns mean is told by position, as MoorDyn itself has it; which of two layouts a table has, by
how many numbers its rows have. Source: MoorDyn documentation, "Input Files" (moordyn.readthedocs.io).
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from dataclasses import dataclass, field
from math import isfinite
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
ANY, POSITIVE, NOT_NEGATIVE = "a number", "a positive number", "a number from 0 on"
COUNT = "a whole number from 1 on"
WEIGHTY = ("rho", "rhow", "wtrdnsty", "wtrdens", "g", "gravity", "kbot", "kb")  # positive
TAKEN = (*WEIGHTY, "cbot", "cb", "frictioncoefficient", "wtrdpth")
# options of MoorDyn's own stepping, start and output, of which a scene has nothing
OWN = (
    "dtm", "dt", "tscheme", "writelog", "writeunits", "dtic", "icdt", "tmaxic", "ictmax", "cdscaleic",
    "icdfac", "threshic", "icthresh", "icgendynamic", "icgenstationary", "icstationary", "dtout",
    "outswitch", "disableouttime", "disableoutput", "fricdamp", "statdynfricscale", "dtwave", "echo",
)  # fmt: skip
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
        text = path.read_text(encoding="utf-8-sig", errors="replace")
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
            if next(self.table(section), None) is None:
                self.told(None, section, f"expected a table of {section}, found none")
            self.units(section)
        early = len(self.head("types")) < 10 and self.numbers("types", 1) < 9
        for row in self.table("types"):
            if self.wide(row, "types", 9 if early else 10) and self.new(row, found.types):
                found.types[row.words[0]] = self.line_type(row, early, found)
        self.misnamed(found)
        # a table of the early layout that lacks a column is none of the other
        early = self.numbers("points", 2) > 7 and len(self.head("points")) >= 12
        for row in self.table("points"):
            if self.wide(row, "points", 12 if early else 9) and self.new(row, found.points):
                found.points[row.words[0]] = self.point(row, early)
        early = any(name.lower().startswith(("unstr", "len")) for name in self.head("lines")[2:3])
        for row in self.table("lines"):
            if self.wide(row, "lines", 6) and self.new(row, found.lines):
                found.lines[row.words[0]] = self.line(row, early, found)
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

    def head(self, section: str) -> list[str]:
        """The names of the columns."""
        rows = self.sections.get(section, [])
        return rows[0].words if rows else []

    def numbers(self, section: str, first: int) -> int:
        """How many numbers stand one after the other in the first row, from a column on."""
        row = next(self.table(section), None)
        words = [] if row is None else row.words[first:]
        return next((k for k, w in enumerate(words) if not _is_number(w)), len(words))

    def units(self, section: str) -> None:
        """Tell of a table without a row of units, for which its first row would be taken."""
        for row in self.sections.get(section, [])[1:HEAD_ROWS]:
            if not any("(" in word for word in row.words):
                self.told(row, section, "expected a row of units, such as (-), under that of names")

    def new(self, row: Row, known: Container[str]) -> bool:
        """Whether a row has a name of its own, one that a scene can have."""
        name = row.words[0]
        if name in known:
            self.told(row, name, f"expected a name of its own, found {name!r} again")
        elif not re.fullmatch(r"[\w-]+", name, re.ASCII):
            self.told(row, name, f"expected letters, digits, _ and -, found {name!r}")
        else:
            return True
        return False

    def wide(self, row: Row, section: str, least: int) -> bool:
        if len(row.words) < least:
            words = f"expected at least {least} columns, found {len(row.words)}"
            self.told(row, section, words)
        return len(row.words) >= least

    def misnamed(self, found: Mooring) -> None:
        """Remark coefficients under names in the early order that are read in the late one."""
        named = self.head("types")[6:10]
        if len(named) == 4 and named[0].lower().startswith("ca"):
            found.remarks.append(
                f"coefficients are taken as Cd, Ca, CdAx, CaAx, as MoorDyn takes them, which the file "
                f"calls {', '.join(named)}"
            )

    def line_type(self, row: Row, early: bool, found: Mooring) -> LineType:
        name, *numbers = row.words
        # the early layout has no EI, and the coefficients in another order
        keys = ("diameter", "mass", "EA", "BA")
        keys += ("Ca", "CaAx", "Cd", "CdAx") if early else ("EI", "Cd", "Ca", "CdAx", "CaAx")
        values = {"EI": 0.0}
        for key, word in zip(keys, numbers, strict=False):
            first, bar, _ = word.partition("|")
            if bar:
                found.left.append(f"the dynamic part of {key} of {name}, {word}")
            kind = {"BA": ANY, "mass": POSITIVE, "EA": POSITIVE}.get(key, NOT_NEGATIVE)
            values[key] = self.number(row, f"{key} of {name}", first, kind)
        return LineType(name, **values)

    def point(self, row: Row, early: bool) -> Point:
        name, kind, *numbers = row.words
        if kind.lower() not in KINDS:
            words = f"expected a point that is fixed, coupled, free, found {kind!r}"
            self.told(row, f"point {name}", f"{words}: bodies and rods have no counterpart")
        if early:  # with forces
            forces = [self.number(row, f"force of point {name}", word) for word in numbers[5:8]]
            if any(forces):
                self.told(row, f"point {name}", "expected no steady force on a point, found one")
            del numbers[5:8]
        x, y, z = (self.number(row, f"point {name}", word) for word in numbers[:3])
        rest = [self.number(row, f"point {name}", word, NOT_NEGATIVE) for word in numbers[3:7]]
        return Point(KINDS.get(kind.lower(), "free"), (x, y, z), *rest)

    def line(self, row: Row, early: bool, found: Mooring) -> MooringLine:
        name, kind, *more = row.words
        length, segments, start, end = more[:4] if early else (more[2], more[3], *more[:2])
        if kind not in found.types:
            known = ", ".join(found.types)
            self.told(row, f"line {name}", f"expected a line type ({known}), found {kind!r}")
        ends = [re.sub(r"(?i)^p(oint)?(?=\d)", "", point) for point in (start, end)]
        start, end = ends
        if start == end:
            self.told(row, f"line {name}", f"expected two points, found {start} twice")
        for point in ends:
            if point not in found.points:
                words = f"expected the number of a point, found {point!r}"
                self.told(row, f"line {name}", f"{words}: bodies and rods have no counterpart")
        count = self.number(row, f"segments of line {name}", segments, COUNT)
        metres = self.number(row, f"length of line {name}", length, POSITIVE)
        return MooringLine(kind, start, end, metres, int(count))

    def option(self, row: Row, found: Mooring) -> None:
        value, *names = row.words
        key = names[0].lower() if names else ""
        if key in WATER and value.strip('"') and _number(value) != 0.0:
            found.left.append(f"{names[0]} = {value}: {WATER[key]}")
        number = _number(value)
        if number is not None:
            found.options[key] = number
        elif key in TAKEN:
            wanted = "a depth (m)" if key == "wtrdpth" else "a number"
            self.told(row, names[0], f"expected {wanted}, found {value!r}")
        elif names and _number(names[0]) is not None:
            self.told(row, value, f"expected a value before its name, found {names[0]} behind it")
        if key and not {key, value.lower()} & {*TAKEN, *OWN, *WATER}:
            found.left.append(f"option {names[0]} = {value}")
        if key in WEIGHTY and number is not None:
            self.number(row, names[0], value, POSITIVE)

    # --- numbers ----------------------------------------------------------------------------------

    def number(self, row: Row, key: str, word: str, kind: str = ANY) -> float:
        found = _number(word)
        right = {
            ANY: found is not None,
            POSITIVE: found is not None and found > 0.0,
            NOT_NEGATIVE: found is not None and found >= 0.0,
            COUNT: found is not None and found >= 1.0 and found % 1.0 == 0.0,
        }
        if not right[kind]:
            self.told(row, key, f"expected {ANY if found is None else kind}, found {word!r}")
        return found or 0.0

    def told(self, row: Row | None, key: str, words: str) -> None:
        self.faults.append(Fault(self.file, row and row.line, key, words))


def _sections(text: str) -> Iterator[tuple[str, list[Row]]]:
    """Yield each section that is known by name, with all of its rows."""
    name, rows, before, heads = "", list[Row](), dict[str, list[Row]](), 0
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("--"):
            before[name] = rows
            yield name, rows
            fits = (key for key, header in HEADERS.items() if re.search(header, line.upper()))
            name = next(fits, "")
            # what has been told before goes on, without another head
            rows = list(before.get(name, []))
            heads = HEAD_ROWS if rows and name != "options" else 0
        elif heads and line.strip():
            heads -= 1
        elif name and (words := _words(line, len(rows) < HEAD_ROWS and name != "options")):
            counts = not rows and name != "options" and _number(words[0]) is not None
            if not counts:  # before the names some say how many rows there are
                rows.append(Row(number, words))
    yield name, rows


def _words(line: str, head: bool) -> list[str]:
    """The words of a row without its comment; of names and units all, which may have such signs."""
    return (line if head else re.split(r"[!#%]", line, maxsplit=1)[0]).split()


def _is_number(word: str) -> bool:
    """Whether a word of a table is a number, or one with a dynamic part."""
    return _number(word.partition("|")[0]) is not None


def _number(word: str) -> float | None:
    try:
        found = float(re.sub("[dD]", "e", word))
    except ValueError:
        return None
    return found if isfinite(found) else None
