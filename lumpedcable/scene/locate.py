"""Line numbers of TOML keys.

The standard reader returns values only. This one reads a text that is known to be valid TOML a
second time and keeps nothing but where each key and each item of a list stands.
"""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_right

from lumpedcable.scene.part import Path

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_BLANK = re.compile(r"(?:[ \t\r\n]+|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_STRING = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}(?!")' r"|'''.*?'{3,5}(?!')" r'|"(?:[^"\\\n]|\\.)*"' r"|'[^'\n]*'",
    re.DOTALL,
)
_OTHER = re.compile(r"[^,\]}#\n]+")


class LineMap:
    """Where the keys of a TOML text stand: :meth:`line` of a path, as line numbers from 1."""

    def __init__(self, text: str):
        self._lines = _Reader(text).read() if text else {}
        self._ranks = {path: rank for rank, path in enumerate(self._lines)}

    def line(self, path: Path) -> int:
        """Return the line of the longest part of ``path`` that the text holds (1 for none)."""
        keys = tuple(str(key) for key in path)
        for size in range(len(keys), 0, -1):
            if keys[:size] in self._lines:
                return self._lines[keys[:size]]
        return 1

    def order(self, path: Path) -> int:
        """Return the rank of a path among all in the text, in the order in which they first stand."""
        return self._ranks.get(tuple(str(key) for key in path), len(self._ranks))

    def __contains__(self, path: Path) -> bool:
        return tuple(str(key) for key in path) in self._lines


class _Reader:
    def __init__(self, text: str):
        self.text, self.at = text, 0
        self.starts = [0, *(match.end() for match in re.finditer("\n", text))]
        self.lines: dict[tuple[str, ...], int] = {}
        self.tables: dict[tuple[str, ...], int] = {}  # how often [[a.b]] was opened

    def read(self) -> dict[tuple[str, ...], int]:
        table: tuple[str, ...] = ()
        while self._skip(_BLANK) < len(self.text):
            if self.text.startswith("[", self.at):
                table = self._header()
            else:
                self._pair(table)
        return self.lines

    def _skip(self, pattern: re.Pattern[str]) -> int:
        match = pattern.match(self.text, self.at)
        if match is not None:
            self.at = match.end()
        return self.at

    def _note(self, path: tuple[str, ...], start: int) -> None:
        line = bisect_right(self.starts, start)
        for size in range(1, len(path) + 1):
            self.lines.setdefault(path[:size], line)

    def _header(self) -> tuple[str, ...]:
        start, many = self.at, self.text.startswith("[[", self.at)
        self.at += 2 if many else 1
        path = self._inside_lists(self._key())
        self.at += 2 if many else 1
        if many:
            count = self.tables[path] = self.tables.get(path, -1) + 1
            path = (*path, str(count))
        self._note(path, start)
        return path

    def _inside_lists(self, keys: tuple[str, ...]) -> tuple[str, ...]:
        """Return the path of a header: below a [[list]], its keys belong to the last item."""
        path: tuple[str, ...] = ()
        for key in keys[:-1]:
            path = (*path, key)
            if path in self.tables:
                path = (*path, str(self.tables[path]))
        return (*path, keys[-1])

    def _key(self) -> tuple[str, ...]:
        keys = []
        while True:
            self._skip(_SPACE)
            quoted = _STRING.match(self.text, self.at)
            match = quoted or _BARE_KEY.match(self.text, self.at)
            assert match is not None, "the text was valid TOML"
            word = match.group()
            keys.append(tomllib.loads(f"k = {word}")["k"] if quoted else word)
            self.at = match.end()
            self._skip(_SPACE)
            if not self.text.startswith(".", self.at):
                return tuple(keys)
            self.at += 1

    def _pair(self, table: tuple[str, ...]) -> None:
        start = self.at
        path = (*table, *self._key())
        self._note(path, start)
        self.at += 1  # the equals sign
        self._skip(_SPACE)
        self._value(path)

    def _value(self, path: tuple[str, ...]) -> None:
        if self.text.startswith("[", self.at):
            self._items(path)
        elif self.text.startswith("{", self.at):
            self._inline_table(path)
        elif _STRING.match(self.text, self.at):
            self._skip(_STRING)
        else:
            self._skip(_OTHER)

    def _items(self, path: tuple[str, ...]) -> None:
        self.at += 1
        index = 0
        while self.text[self._skip(_BLANK)] != "]":
            if self.text[self.at] == ",":
                self.at += 1
                continue
            item = (*path, str(index))
            self._note(item, self.at)
            self._value(item)
            index += 1
        self.at += 1

    def _inline_table(self, path: tuple[str, ...]) -> None:
        self.at += 1
        while self.text[self._skip(_BLANK)] != "}":
            if self.text[self.at] == ",":
                self.at += 1
                continue
            self._pair(path)
        self.at += 1
