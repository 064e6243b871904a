"""Reads the input files of MoorDyn, both layouts: types, bodies, points, lines, failures and options.

What the columns mean is told by position, as MoorDyn itself has it; which of two layouts a table has, by
how many numbers its rows have. Source: MoorDyn documentation, "Input Files" (moordyn.readthedocs.io).
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from math import radians
from pathlib import Path

from lumpedcable.adopt.names import KINDS, OWN, TAKEN, WATER, WEIGHTY, bare, body_of
from lumpedcable.adopt.parts import (
    Failure,
    LineType,
    Mooring,
    MooringBody,
    MooringLine,
    Point,
    RodType,
    triple,
)
from lumpedcable.adopt.sections import HEAD_ROWS, Row, is_number, number_of, sections
from lumpedcable.scene.errors import Fault, SceneError

__all__ = ["read_moordyn"]

LEFT = ("control", "external loads")
ON_RODS = " (rods are taken that are fixed, coupled or on a body)"
WITH_LOAD = "; of one that goes with the load, give EA_d at the load that the line carries"
ANY, POSITIVE, NOT_NEGATIVE = "a number", "a positive number", "a number from 0 on"
COUNT = "a whole number from 1 on"


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
        self.rod_types: dict[str, RodType] = {}
        self.loose: dict[str, Row] = {}  # bodies that move by what pulls them
        self.sections = dict(sections(text))

    def mooring(self) -> Mooring:
        found = Mooring()
        for section in ("types", "points", "lines"):
            if next(self.table(section), None) is None:
                self.told(None, section, f"expected a table of {section}, found none")
            self.units(section)
        early = len(self.head("types")) < 10 and self.numbers("types", 1) < 9
        for row in self.table("types"):
            if self.wide(row, "types", 9 if early else 10) and self.new(
                row, found.types, any_name=True
            ):
                found.types[row.words[0]] = self.line_type(row, early, found)
        self.misnamed(found)
        for row in self.table("bodies"):
            if self.wide(row, "bodies", 14) and self.new(row, found.bodies):
                found.bodies[row.words[0]] = self.body(row)
        # a table of the early layout that lacks a column is none of the other
        early = self.numbers("points", 2) > 7 and len(self.head("points")) >= 12
        for row in self.table("points"):
            if self.wide(row, "points", 12 if early else 9) and self.new(row, found.points):
                found.points[row.words[0]] = self.point(row, early, found)
        for row in self.table("rod types"):
            if self.wide(row, "rod types", 5):
                self.rod_type(row)
        for row in self.table("rods"):
            if self.wide(row, "rods", 10):
                self.rod(row, found)
        self.unweighed(found)
        early = any(name.lower().startswith(("unstr", "len")) for name in self.head("lines")[2:3])
        for row in self.table("lines"):
            if self.wide(row, "lines", 6) and self.new(row, found.lines):
                found.lines[row.words[0]] = self.line(row, early, found)
        for row in self.table("failure"):
            if self.wide(row, "failure", 5):
                self.failure(row, found)
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
        return next((k for k, w in enumerate(words) if not is_number(w)), len(words))

    def units(self, section: str) -> None:
        """Tell of a table without a row of units, for which its first row would be taken."""
        for row in self.sections.get(section, [])[1:HEAD_ROWS]:
            if not any("(" in word for word in row.words):
                self.told(row, section, "expected a row of units, such as (-), under that of names")

    def new(self, row: Row, known: Container[str], any_name: bool = False) -> bool:
        """Whether a row has a name of its own, one that a scene can have or can be given."""
        name = row.words[0]
        if name in known:
            self.told(row, name, f"expected a name of its own, found {name!r} again")
        elif not any_name and not re.fullmatch(r"[\w-]+", name, re.ASCII):
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
            if bar and key not in ("EA", "BA"):
                found.left.append(f"the dynamic part of {key} of {name}, {word} (line {row.line})")
            kind = {"BA": ANY, "mass": POSITIVE, "EA": POSITIVE}.get(key, NOT_NEGATIVE)
            values[key] = self.number(row, f"{key} of {name}", first, kind)
        more = numbers[len(keys) :]  # Cl, dF and cF
        if more and number_of(more[0]):
            shaken = f"what vortices do to lines of type {name}, {' '.join(more)}"
            found.left.append(f"{shaken} (line {row.line})")
        EA_d, BA_d = self.dynamic(row, values["EA"])
        return LineType(name, **values, EA_d=EA_d, BA_d=BA_d)

    def dynamic(self, row: Row, EA: float) -> tuple[float, float]:
        """Stiffness and damping of the dynamic part of a line type, 0 and 0 where it has none.

        MoorDyn itself refuses a second BA without a second EA, takes 0 for one that is not there, and
        finds no motion where the dynamic part is no stiffer or nothing damps.
        """
        name, EAs, BAs = row.words[0], *(word.split("|") for word in row.words[3:5])
        of_EA, of_BA = f"EA of {name}", f"BA of {name}"
        if len(EAs) == 1:
            if len(BAs) > 1:
                words = "expected one number, as there is one EA"
                self.told(row, of_BA, f"{words}, found {row.words[4]!r}")
            return 0.0, 0.0
        if len(EAs) > 2:
            words = "expected one number or two, EA_s|EA_d, found"
            self.told(row, of_EA, f"{words} {row.words[3]!r}{WITH_LOAD}")
            return 0.0, 0.0
        EA_d = self.number(row, of_EA, EAs[1], POSITIVE)
        if 0.0 < EA_d <= EA:
            words = "expected a dynamic stiffness above the static one, EA_s|EA_d"
            self.told(row, of_EA, f"{words}, found {row.words[3]!r}")
        if len(BAs) > 2:
            self.told(row, of_BA, f"expected one number or two, BA_s|BA_d, found {row.words[4]!r}")
        BA_d = self.number(row, f"dynamic {of_BA}", BAs[1], NOT_NEGATIVE) if len(BAs) > 1 else 0.0
        if number_of(BAs[0]) == 0.0 == BA_d:
            words = "expected damping BA_s|BA_d beside EA_s|EA_d, one of them above 0"
            self.told(row, of_BA, f"{words}, found {row.words[4]!r}")
        return EA_d, BA_d

    def body(self, row: Row) -> MooringBody:
        name, kind, *numbers = row.words
        key = f"body {name}"
        if kind.lower() not in KINDS:
            words = f"expected a body that is fixed, coupled or free, found {kind!r}"
            self.told(row, key, words)
        place = [self.number(row, key, word) for word in numbers[:3]]
        turned = [radians(self.number(row, key, word)) for word in numbers[3:6]]
        mass, volume = (self.number(row, key, numbers[k], NOT_NEGATIVE) for k in (6, 9))
        centre, inertia, area, added = (self.several(row, key, numbers[k]) for k in (7, 8, 10, 11))
        if len(centre) == 1:
            centre = [0.0, 0.0, *centre]
        triples = [values * (3 if len(values) == 1 else 1) for values in (inertia, added)]
        for word, values in zip((numbers[7], *numbers[8:12:3]), (centre, *triples), strict=True):
            if len(values) != 3:
                self.told(row, key, f"expected one number or three, x|y|z, found {word!r}")
        found = KINDS.get(kind.lower(), "free")
        if found == "free":
            self.loose[name] = row
        return MooringBody(
            found, triple(place), triple(turned), mass, triple(centre), triple(triples[0]),
            volume, any(area), triple(triples[1]),
        )  # fmt: skip

    def unweighed(self, found: Mooring) -> None:
        """Tell of free bodies that weigh nothing, what is on them counted."""
        for name, row in self.loose.items():
            body = found.bodies[name]
            if not (body.mass > 0.0 and min(body.inertia) > 0.0):
                words = "expected a free body with mass and moments of inertia above 0"
                self.told(row, f"body {name}", f"{words}, found {row.words[8]} and {row.words[10]}")

    def several(self, row: Row, key: str, word: str) -> list[float]:
        """The numbers of a word such as 1|2|3."""
        return [self.number(row, key, part) for part in word.split("|")]

    def point(self, row: Row, early: bool, found: Mooring) -> Point:
        name, kind, *numbers = row.words
        body = body_of(kind, found.bodies)
        if not body and kind.lower() not in KINDS:
            words = f"expected a point that is fixed, coupled, free or on a body, found {kind!r}"
            self.told(row, f"point {name}", words)
        if early:  # with forces
            forces = [self.number(row, f"force of point {name}", word) for word in numbers[5:8]]
            if any(forces):
                self.told(row, f"point {name}", "expected no steady force on a point, found one")
            del numbers[5:8]
        place = triple([self.number(row, f"point {name}", word) for word in numbers[:3]])
        mass, volume, CdA, Ca = (
            self.number(row, f"point {name}", word, NOT_NEGATIVE) for word in numbers[3:7]
        )
        kind = KINDS.get(kind.lower(), "body" if body else "free")
        if body in self.loose and (mass or volume):
            part = mass, volume, place, triple([]), triple([Ca] * 3)
            found.bodies[body] = found.bodies[body].with_part(*part)
            found.remarks.append(f"mass and volume of point {name} are in those of body {body}")
        return Point(kind, place, mass, volume, CdA, Ca, body)

    def rod_type(self, row: Row) -> None:
        name, *numbers = row.words
        diameter, mass, _, Ca = (
            self.number(row, f"rod type {name}", word, NOT_NEGATIVE) for word in numbers[:4]
        )
        self.rod_types[name] = RodType(diameter, mass, Ca)

    def rod(self, row: Row, found: Mooring) -> None:
        """The two ends of a rod that does not move by itself, as points that have its direction."""
        name, of, kind, *numbers = row.words
        key = f"rod {name}"
        body = body_of(kind, found.bodies)
        taken = KINDS.get(kind.lower(), "body" if body else "free")
        if taken == "free":
            found.left.append(f"rod {name}, which is {kind} (line {row.line})")
            return
        first, last = (
            triple([self.number(row, key, word) for word in numbers[k : k + 3]]) for k in (0, 3)
        )
        count = self.number(row, f"segments of {key}", numbers[6], NOT_NEGATIVE)
        if first == last:
            self.told(row, key, "expected two ends that lie apart, found one place")
        elif count and body in self.loose:
            if of not in self.rod_types:
                known = ", ".join(self.rod_types)
                self.told(row, key, f"expected a rod type ({known}), found {of!r}")
                return
            along = triple([b - a for a, b in zip(first, last, strict=True)])
            middle = triple([0.5 * (a + b) for a, b in zip(first, last, strict=True)])
            mass, volume, inertia, Ca = self.rod_types[of].inertia(along)
            part = mass, volume, middle, inertia, Ca
            found.bodies[body] = found.bodies[body].with_part(*part)
            found.remarks.append(
                f"mass, volume and Ca of rod {name} are in those of body {body}; water lifts that at "
                "its centre of gravity, not at its rods, and Cd of the rod is left out"
            )
        for end, place in (("A", first), ("B", last if count else first)):  # of no length without
            found.points[f"R{name}{end}"] = Point(
                taken, place, 0.0, 0.0, 0.0, 0.0, body, axis=(first, last)
            )

    def failure(self, row: Row, found: Mooring) -> None:
        name, point, lines, *when = row.words
        point, key = bare(point), f"failure {name}"
        time, tension = (self.number(row, key, word, NOT_NEGATIVE) for word in when[:2])
        lets = [line for line in lines.split(",") if line]
        if point not in found.points:
            words = f"expected the number of a point, found {row.words[1]!r}"
            self.told(row, key, f"{words}{ON_RODS}")
        for line in lets:
            if line not in found.lines:
                self.told(row, key, f"expected the number of a line, found {line!r}")
            elif point not in (found.lines[line].start, found.lines[line].end):
                self.told(
                    row, key, f"expected a line that ends at point {point}, found line {line}"
                )
        if not time and not tension:
            self.told(row, key, "expected a time or a tension above 0, found neither")
        while name in found.failures:  # MoorDyn does not mind
            name += "_"
        found.failures[name] = Failure(point, tuple(lets), time, tension)

    def line(self, row: Row, early: bool, found: Mooring) -> MooringLine:
        name, kind, *more = row.words
        length, segments, start, end = more[:4] if early else (more[2], more[3], *more[:2])
        if kind not in found.types:
            known = ", ".join(found.types)
            self.told(row, f"line {name}", f"expected a line type ({known}), found {kind!r}")
        ends = [bare(point) for point in (start, end)]
        start, end = ends
        if start == end:
            self.told(row, f"line {name}", f"expected two points, found {start} twice")
        for point in ends:
            if point not in found.points:
                words = f"expected the number of a point, found {point!r}"
                self.told(row, f"line {name}", f"{words}{ON_RODS}")
        count = self.number(row, f"segments of line {name}", segments, COUNT)
        metres = self.number(row, f"length of line {name}", length, POSITIVE)
        return MooringLine(kind, start, end, metres, int(count))

    def option(self, row: Row, found: Mooring) -> None:
        value, *names = row.words
        key = names[0].lower() if names else ""
        if key in WATER and value.strip('"') and number_of(value) != 0.0:
            found.left.append(f"{names[0]} = {value} (line {row.line}): {WATER[key]}")
        number = number_of(value)
        if number is not None:
            found.options[key] = number
        elif key in TAKEN:
            wanted = "a depth (m)" if key == "wtrdpth" else "a number"
            self.told(row, names[0], f"expected {wanted}, found {value!r}")
        elif names and number_of(names[0]) is not None:
            self.told(row, value, f"expected a value before its name, found {names[0]} behind it")
        if key and not {key, value.lower()} & {*TAKEN, *OWN, *WATER}:
            found.left.append(f"option {names[0]} = {value} (line {row.line})")
        if key in WEIGHTY and number is not None:
            self.number(row, names[0], value, POSITIVE)

    # --- numbers ----------------------------------------------------------------------------------

    def number(self, row: Row, key: str, word: str, kind: str = ANY) -> float:
        found = number_of(word)
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
