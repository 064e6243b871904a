"""The sections of an input file of MoorDyn: rows of words, with their lines in the file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

__all__ = ["HEAD_ROWS", "Row", "is_number", "number_of", "sections"]

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


@dataclass(frozen=True)
class Row:
    """A row of a table: its line in the file, from 1, and its words."""

    line: int
    words: list[str]


def sections(text: str) -> Iterator[tuple[str, list[Row]]]:
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
            counts = not rows and name != "options" and number_of(words[0]) is not None
            if not counts:  # before the names some say how many rows there are
                rows.append(Row(number, words))
    yield name, rows


def _words(line: str, head: bool) -> list[str]:
    """The words of a row without its comment; of names and units all, which may have such signs."""
    return (line if head else re.split(r"[!#%]", line, maxsplit=1)[0]).split()


def is_number(word: str) -> bool:
    """Whether a word of a table is a number, or one with a dynamic part."""
    return number_of(word.partition("|")[0]) is not None


def number_of(word: str) -> float | None:
    """The finite number that a word is, if it is one."""
    try:
        found = float(re.sub("[dD]", "e", word))
    except ValueError:
        return None
    return found if isfinite(found) else None
