"""Faults of a scene, each with its place in the file, and pydantic's errors put in plain words."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import ValidationError

from lumpedcable.scene.part import Expected, Path, Problem, did_you_mean, either
from lumpedcable.scene.quantities import found
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import Spot, fields, model, numeric, plain, spot_at


@dataclass(frozen=True)
class Fault:
    """One mistake in a scene."""

    file: str
    """The scene file, or "" for a fault of an override."""
    line: int | None
    """Line in the file, from 1; None where there is none."""
    key: str
    """Dotted path of the value, or "" for the file as a whole."""
    message: str
    """What was expected, what was found, and the nearest valid name."""
    override: str | None = None
    """The override ("KEY=VALUE") that brought the value in, instead of the file."""

    def __str__(self) -> str:
        if self.override is not None:
            place = f"--set {self.override}"
        else:
            place = self.file if self.line is None else f"{self.file}:{self.line}"
        return ": ".join(part for part in (place, self.key, self.message) if part)


class SceneError(Exception):
    """A scene that cannot be used, with every fault found in it."""

    def __init__(self, faults: Iterable[Fault]):
        unique = dict.fromkeys(faults)
        # Overrides come after the file, in the order they were given.
        self.faults: tuple[Fault, ...] = tuple(
            sorted(unique, key=lambda f: (f.override is not None, f.line if f.line else 0))
        )
        super().__init__(str(self))

    def __str__(self) -> str:
        return "\n".join(str(fault) for fault in self.faults)

    def __reduce__(self) -> tuple[type[SceneError], tuple[Any, ...]]:
        return SceneError, (self.faults,)


def problems_of(error: ValidationError, root: Spot) -> list[Problem]:
    """Return one problem per mistake behind a validation error.

    Args:
        error: what pydantic raised.
        root: the model that was validated, with the raw data.
    """
    reports = [(_path(report["loc"]), report) for report in error.errors(include_url=False)]
    bad_names = {path[:-1] for path, _ in reports if path and path[-1] == "[key]"}
    # A misspelt key makes the key that was meant missing as well: one mistake, told once.
    meant = {
        (*path[:-1], guess)
        for path, report in reports
        if report["type"] == "extra_forbidden"
        and (guess := _meant(str(path[-1]), spot_at(root, path[:-1])))
    }
    problems: dict[Path, Problem] = {}
    for path, report in reports:
        if path in bad_names or (report["type"] == "missing" and path in meant):
            continue
        problem = _problem(path, report, root)
        problems.setdefault(problem.path, problem)
    # Wrong items are not counted as items, so that their list seems too short as well.
    lists = {p[:n] for p in problems for n, key in enumerate(p) if isinstance(key, int)}
    return [problem for path, problem in problems.items() if path not in lists]


def _path(location: tuple[str | int, ...]) -> Path:
    """Return a location without the tags of unions."""
    return tuple(key for key in location if not re.fullmatch(r"<\w+>", str(key)))


def _meant(word: str, table: Spot | None) -> str | None:
    hint = re.search(r'mean "(.*)"', did_you_mean(word, _keys(table)))
    return hint.group(1) if hint else None


def _keys(table: Spot | None) -> list[str]:
    cls = model(table) if table is not None else None
    if cls is None:
        return []
    # The sweep stands in the file beside the keys of the scene.
    return [*fields(cls), "sweep"] if cls is Scene else list(fields(cls))


def _problem(path: Path, report: Any, root: Spot) -> Problem:
    kind, value, context = report["type"], report["input"], report.get("ctx", {})
    if kind == "scene":
        key = context.get("key")
        return Problem(path if key is None else (*path, key), report["msg"])
    if kind == "missing":
        if isinstance(path[-1], int):
            return _wrong_length(path[:-1], root)
        return Problem(path, f"expected {_expected(spot_at(root, path))}, found nothing")
    if kind == "extra_forbidden":
        keys = _keys(spot_at(root, path[:-1]))
        hint = did_you_mean(str(path[-1]), keys) or f"; known keys are {', '.join(keys)}"
        return Problem(path, f'expected a known key, found "{path[-1]}"{hint}')
    if kind in ("too_short", "too_long") and "actual_length" in context:
        return _wrong_length(path, root)
    if kind == "string_pattern_mismatch" and path[-1] == "[key]":
        return Problem(
            path[:-1],
            "expected a name of letters, digits, _ and -, starting with a letter, "
            f"found {found(value)}",
        )
    if kind == "literal_error":
        words = re.findall(r"'([^']*)'", context["expected"])
        expected = either(f'"{word}"' for word in words)
        return Problem(
            path, f"expected {expected}, found {found(value)}{did_you_mean(value, words)}"
        )
    return Problem(path, f"expected {_expected(spot_at(root, path))}, found {found(value)}")


def _wrong_length(path: Path, root: Spot) -> Problem:
    spot = spot_at(root, path)
    given = found(spot.value) if spot is not None else "another length"
    return Problem(path, f"expected {_expected(spot)}, found {given}")


def _expected(spot: Spot | None) -> str:
    """Return what may stand at a spot, in words."""
    if spot is None:
        return "another value"
    number = numeric(spot)
    if number is not None:
        return number.expected
    cls = model(spot)
    if cls is not None:
        required = [name for name, field in cls.model_fields.items() if field.is_required()]
        return f"a table with {', '.join(required)}" if required else "a table"
    annotation, notes = plain(spot)
    kinds = next((note for note in notes if isinstance(note, Expected)), None)
    return kinds.words if kinds else _words(annotation)


def _words(annotation: Any) -> str:
    origin, arguments = get_origin(annotation) or annotation, get_args(annotation)
    if origin is tuple:
        number = numeric(Spot(arguments[0]))
        name = f", each {number.expected}" if number else ""
        return ("a list" if Ellipsis in arguments else f"a list of {len(arguments)}") + name
    if origin is Literal:
        return either(f'"{word}"' for word in arguments)
    return {dict: "a table", bool: "true or false", str: "text"}.get(origin, "another value")
