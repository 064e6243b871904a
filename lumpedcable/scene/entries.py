"""[sweep] as it is written: which keys stand in it, alone or in groups, and where in the file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from lumpedcable.scene.part import Path, Problem, control_character
from lumpedcable.scene.quantities import found

GROUPS = ("cases", "zip", "sample")
"""Tables of a sweep that hold several keys; they come after single keys, in this order."""
RANGE = ("from", "to", "count", "step", "spacing")
DRAW = ("from", "to", "spacing", "mean", "deviation")
SETTINGS = {"cases": (), "zip": (), "sample": ("method", "count", "seed")}

Raw = tuple[Path, Any]
"""Where something stands in the file, and its raw value."""


@dataclass(frozen=True)
class Entry:
    """One factor of a sweep as it was written: raw values by key, and the settings of a group."""

    kind: str
    place: Path
    keys: dict[str, Any]
    """By key: (place, raw); of cases a list of them, None where a case leaves the key out."""
    settings: dict[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] = ()

    def without(self, key: str) -> Entry:
        """Return the entry without a key and what is below it."""
        kept = {k: v for k, v in self.keys.items() if k != key and not k.startswith(f"{key}.")}
        return replace(self, keys=kept)


def entries_of(
    sweep: dict[str, Any], order: Callable[[Path], int] = lambda _: 0
) -> tuple[list[Entry], list[Problem]]:
    """Return the factors of a raw sweep, and what is wrong with its shape.

    A key without quotes (lines.rope.length = ...) is a nest of tables in TOML and read alike. Nests
    come in an order of their own, so `order` says where a path of the file stands in it.
    """

    def flattened(path: Path, table: dict[str, Any]) -> list[tuple[Path, str, Any]]:
        return sorted(_flattened(path, table), key=lambda found: order(found[0]))

    entries: list[Entry] = []
    problems: list[Problem] = []
    singles = {key: value for key, value in sweep.items() if key not in GROUPS}
    for place, key, value in flattened(("sweep",), singles):
        entries.append(Entry("list", place, {key: (place, value)}))
    for kind in GROUPS:
        if kind not in sweep:
            continue
        place: Path = ("sweep", kind)
        raw = sweep[kind]
        tables = [raw] if isinstance(raw, dict) and kind != "cases" else raw
        # a case without keys is the scene as it is; of the other groups an empty table says nothing
        right = _is_case if kind == "cases" else _is_table
        if not isinstance(tables, list) or not tables or not all(map(right, tables)):
            problems.append(
                Problem(place, f"expected tables, [[sweep.{kind}]], found {found(raw)}")
            )
        elif kind == "cases":
            entry, wrong = _cases(place, tables, flattened)
            entries.append(entry)
            problems += wrong
        else:
            for i, table in enumerate(tables):
                mine = place if isinstance(raw, dict) else (*place, i)
                settings = {k: v for k, v in table.items() if k in SETTINGS[kind]}
                rest = {k: v for k, v in table.items() if k not in settings}
                keys = {key: (at, value) for at, key, value in flattened(mine, rest)}
                entries.append(Entry(kind, mine, keys, settings))
    seen: set[str] = set()
    for entry in entries:
        for key in entry.keys:
            if key in seen:
                place = (*entry.place, key) if entry.kind != "list" else entry.place
                problems.append(Problem(place, f'expected each key once, found "{key}" again'))
            seen.add(key)
    return entries, problems


def _is_case(raw: Any) -> bool:
    return isinstance(raw, dict)


def _is_table(raw: Any) -> bool:
    return isinstance(raw, dict) and bool(raw)


def _flattened(path: Path, table: dict[str, Any]) -> Iterator[tuple[Path, str, Any]]:
    """Yield (path in the file, key, value) of what stands below a table of the sweep."""

    # not by recursion: a key may have more dots than calls may be nested
    left: list[tuple[Path, Any]] = [((), table)]
    while left:
        words, value = left.pop()
        if not words or (_is_table(value) and not is_spec(value)):
            left += [((*words, key), below) for key, below in reversed(value.items())]
        else:
            yield (*path, *words), ".".join(map(str, words)), value


def is_spec(raw: Any) -> bool:
    """Return whether a raw value is a range or a distribution rather than a table of keys."""
    words = {*RANGE, *DRAW}
    return isinstance(raw, dict) and any(k in words and not isinstance(raw[k], dict) for k in raw)


def _cases(
    place: Path,
    tables: list[dict[str, Any]],
    flattened: Callable[[Path, dict[str, Any]], list[tuple[Path, str, Any]]],
) -> tuple[Entry, list[Problem]]:
    keys: dict[str, list[Raw | None]] = {}
    names, problems = [], []
    for i, table in enumerate(tables):
        name = table.get("name", "")
        if not isinstance(name, str):
            problems.append(Problem((*place, i, "name"), f"expected a text, found {found(name)}"))
        elif (odd := control_character(name)) is not None:
            words = f"expected text of one line without control characters, found {odd}"
            problems.append(Problem((*place, i, "name"), words))
        elif name and name in names:
            words = f"expected each name once, found {found(name)} again"
            problems.append(Problem((*place, i, "name"), words))
        names.append(str(name))
        rest = {key: value for key, value in table.items() if key != "name"}
        for at, key, value in flattened((*place, i), rest):
            keys.setdefault(key, [None] * len(tables))[i] = (at, value)
    if not keys:
        what = "names alone" if any(names) else "none"
        words = f"expected keys with values in at least one case, found {what}"
        problems.append(Problem(place, words))
    return Entry("cases", place, keys, {}, tuple(names) if any(names) else ()), problems
