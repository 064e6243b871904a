"""Reading a scene file: one call from a path to a study, or to every fault in the file."""

from __future__ import annotations

import math
import re
import sys
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path as FilePath
from typing import Any

from lumpedcable.scene import overrides as changes
from lumpedcable.scene.entries import Entry, entries_of
from lumpedcable.scene.errors import Fault, SceneError
from lumpedcable.scene.events import SHORT, with_place
from lumpedcable.scene.files import fill
from lumpedcable.scene.kinds import SCENE, other_kind
from lumpedcable.scene.locate import LineMap
from lumpedcable.scene.part import Path, Problem, dotted
from lumpedcable.scene.quantities import found
from lumpedcable.scene.references import aligned, count_problems, result_problems
from lumpedcable.scene.run import Reference
from lumpedcable.scene.run_checks import run_problems
from lumpedcable.scene.runs import Axis, Factor, Runs, by_path, with_values
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.sweep import MAX_RUNS, read_factors
from lumpedcable.scene.texts import FileError, read_text
from lumpedcable.scene.tree import Spot, spot_at
from lumpedcable.scene.validate import read_scene
from lumpedcable.scene.writer import to_toml


@dataclass(frozen=True)
class Study:
    """A scene file as read: one scene, its sweep, and every run."""

    path: FilePath
    """The file."""
    text: str
    """The text of the file as it stands."""
    overrides: tuple[str, ...]
    """The overrides that were applied."""
    scene: Scene
    """The file's own values with the overrides; the common base of the runs."""
    runs: Runs
    """Every run: its numbers by column, its scene when asked for; one run without a sweep."""
    effective_text: str
    """TOML text of scene and sweep in SI numbers, overrides included; reads back as this study."""

    @property
    def factors(self) -> tuple[Factor, ...]:
        """The factors of the sweep, slowest first; none without a sweep."""
        return self.runs.factors

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The swept numbers, in the order of their factors."""
        return self.runs.axes

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of rows of each factor."""
        return tuple(map(len, self.factors))

    @property
    def references(self) -> dict[str, Reference]:
        """Numbers from elsewhere, one per run (nan where there is none)."""
        return self.scene.references

    def fault(self, key: str, message: str) -> Fault:
        """Return a fault of a key, with its line or the override that it comes from.

        For what only shows when a scene is put to use.
        """
        for text in reversed(self.overrides):
            given = text.partition("=")[0].strip()
            if key == given or key.startswith(f"{given}."):
                return Fault("", None, key, message, text)
        return Fault(str(self.path), LineMap(self.text).line(tuple(key.split("."))), key, message)


def load_study(path: str | PathLike[str], overrides: Iterable[str] = ()) -> Study:
    """Read a scene file.

    Args:
        path: a TOML file.
        overrides: "KEY=VALUE" texts that change it; see :mod:`lumpedcable.scene.overrides`.

    Raises:
        SceneError: with every fault of file and overrides.
    """
    # a text alone is one of them
    file, overrides = (
        FilePath(path),
        (overrides,) if isinstance(overrides, str) else tuple(overrides),
    )
    text, data = read_toml(file)
    reader = _Reader(file, text)
    sweep = reader.sweep(data.pop("sweep", {}))
    for key in (key for entry in sweep for key in entry.keys):
        data = with_place(data, tuple(key.split(".")))
    own, _, wrong = read_factors(sweep, data)
    sweep_is_right = not wrong and not reader.faults

    # an override may name a number that stands in the sweep alone, which is no number of the scene's own
    lent, _ = _first_values(data, own)
    changed = changes.apply(overrides, with_values(data, lent), sweep)
    reader.origins, reader.faults = changed.origins, reader.faults + changed.faults
    for at in lent:
        if not any(at[:n] in changed.origins for n in range(1, len(at) + 1)):
            changed.data = _without(changed.data, at, data)
    data, scene, factors = reader.read(changed.data, changed.sweep)
    if scene is not None:
        reader.tell(result_problems(scene, data))
    if scene is not None and sweep_is_right:
        reader.tell(count_problems(scene.references, own))
    if scene is None or reader.faults:
        raise SceneError(reader.faults)
    scene = scene.model_copy(update={"references": aligned(scene, data, own, factors)})
    runs = Runs(data, factors, scene)
    return Study(
        file, text, overrides, scene, runs, to_toml(_as_given(scene, data, factors), factors)
    )


class _Reader:
    """The faults of one file, gathered while it is read."""

    def __init__(self, file: FilePath, text: str):
        self.file, self.map = file, LineMap(text)
        self.origins: dict[Path, str] = {}
        self.faults: list[Fault] = []

    def tell(self, problems: Iterable[Problem]) -> None:
        self.faults += map(self.fault, problems)

    def fault(self, problem: Problem) -> Fault:
        path = tuple(str(key) for key in problem.path)
        key = dotted(path)
        if path[0] in SHORT and path[-1] == "place" and not self._given(path):
            # the place may be written "LINE@DISTANCE"
            path = next((p for k in SHORT[path[0]] if self._given(p := (*path[:-1], k))), path)
        for size in range(len(path), 0, -1):
            if path[:size] in self.origins:
                return Fault("", None, key, problem.message, self.origins[path[:size]])
        return Fault(str(self.file), self.map.line(path), key, problem.message)

    def _given(self, path: Path) -> bool:
        """Whether the file or an override has a value of its own at a path."""
        return path in self.origins or path in self.map

    def sweep(self, raw: Any) -> list[Entry]:
        """Return the file's sweep as it is written."""
        if not isinstance(raw, dict):
            self.tell([Problem(("sweep",), f"expected a table, found {found(raw)}")])
            return []
        entries, problems = entries_of(raw, self.map.order)
        self.tell(problems)
        return entries

    def read(
        self, data: dict[str, Any], sweep: list[Entry]
    ) -> tuple[dict[str, Any], Scene | None, list[Factor]]:
        """Return raw data, base scene (None where it is faulty) and factors, telling every fault."""
        factors, places, wrong = read_factors(sweep, data)
        axes = [axis for factor in factors for axis in factor.axes]
        lent = {a.path: places[a.key](0) for a in axes if _is_open(data, a.path)}
        data, scene, problems = self._base(data, factors)
        # A number that only a faulty axis gives is missing for that reason: told once.
        read = {axis.path for axis in axes}
        faulty = {tuple(key.split(".")) for entry in sweep for key in entry.keys} - read
        problems = [p for p in problems if not (p.path in faulty and _is_open(data, p.path))]
        known = list(problems)
        # what is wrong with a number that the sweep alone gives stands there
        problems = [p._replace(path=lent.get(p.path, p.path)) for p in problems] + wrong
        count = math.prod(map(len, factors))
        if count > MAX_RUNS:
            problems.append(Problem(("sweep",), f"expected at most {MAX_RUNS} runs, found {count}"))
        if factors:
            problems += run_problems(data, factors, places, [*known, *problems])
        self.tell(problems)
        return data, scene, factors

    def _base(
        self, data: dict[str, Any], factors: Sequence[Factor]
    ) -> tuple[dict[str, Any], Scene | None, list[Problem]]:
        """The scene that all runs have in common, with what stands in the sweep alone; its faults.

        A number that the scene has keeps its value, unless that does not go with the first row.
        """
        alone, rows = _first_values(data, factors)
        found = self._whole(data, alone)
        if found[2] and rows != alone:
            other = self._whole(data, rows)
            found = found if other[2] else other
        return found

    def _whole(
        self, data: dict[str, Any], values: dict[Path, Any]
    ) -> tuple[dict[str, Any], Scene | None, list[Problem]]:
        """Raw data with values put in, the scene that this is, None where it is faulty, its faults."""
        whole = with_values(data, values)
        scene, problems = read_scene(whole, fill(whole, self.file.parent))
        return whole, scene, list(problems)


def _first_values(
    data: dict[str, Any], factors: Iterable[Factor]
) -> tuple[dict[Path, Any], dict[Path, Any]]:
    """The first values of what stands in the sweep alone, and these with what moves together with it."""
    alone: dict[Path, Any] = {}
    rows: dict[Path, Any] = {}
    for factor in factors:
        row = by_path(factor.at(0))
        mine = {path: value for path, value in row.items() if _is_open(data, path)}
        alone |= mine
        rows |= row if mine else {}
    return alone, rows


def _as_given(scene: Scene, data: dict[str, Any], factors: Iterable[Factor]) -> Scene:
    """The scene with directions of which a component is swept as long as they are given.

    Of length 1, as they are read, they would be others beside the swept component.
    """
    given: dict[str, float] = {}
    for axis in (axis for factor in factors for axis in factor.axes):
        spot = spot_at(Spot(Scene, data), axis.path[:-1])
        vector = None if spot is None else spot.value
        if isinstance(vector, list) and all(isinstance(x, int | float) for x in vector):
            at = axis.key.rpartition(".")[0]
            given |= {f"{at}.{k}": float(x) for k, x in enumerate(vector)}
    return scene.with_numbers(given) if given else scene


def _without(data: Any, path: Path, own: Any) -> Any:
    """Return data without the value at a path, nor tables on the way to it that `own` has not."""
    key, *more = path
    if not isinstance(data, dict) or key not in data:
        return data
    rest = {name: value for name, value in data.items() if name != key}
    if not more:
        return rest
    mine = own if isinstance(own, dict) else {}
    inner = _without(data[key], tuple(more), mine.get(key))
    return data | {key: inner} if inner or key in mine else rest


def _is_open(data: Any, path: Path) -> bool:
    """Return whether a path is absent, and no value but a table stands on the way to it."""
    for key in path:
        if not isinstance(data, dict):
            return False
        if key not in data:
            return True
        data = data[key]
    return False


def read_toml(file: FilePath, holds: str = SCENE) -> tuple[str, dict[str, Any]]:
    """Return the text of a file and its tables; ``holds`` is what is expected in it.

    Raises:
        SceneError: no file, no text, no TOML, nothing in it, or what is the other kind of file.
    """
    try:
        text = read_text(file)
    except FileError as fault:
        raise SceneError([Fault(str(file), None, "", str(fault))]) from None
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        fault = _syntax_fault(file, text, str(error))
        if file.suffix in _OTHERS:
            message = f"expected {holds} (*.toml), found a file *{file.suffix}"
            fault = Fault(str(file), None, "", message)
        raise SceneError([fault]) from None
    if not data:
        message = f"expected {holds}, found an empty file"
        raise SceneError([Fault(str(file), 1, "", message)])
    if (said := other_kind(file, data, holds)) is not None:
        raise SceneError([Fault(str(file), None, "", said)])
    return text, data


_OTHERS = (".csv", ".json")  # data and numbers that commands take or write, but not as a scene
_AGAIN = re.compile("Cannot (overwrite|declare|mutate)")  # tomllib of what has been given already
_LONG = re.compile(rf"(?<![\w.])[+-]?\d(?:_?\d){{{sys.get_int_max_str_digits()},}}(?![\w.])")
_WORD = re.compile(r"\s*([\w.\"-]+\s*=)\s*([A-Za-z_][\w.@-]*)\s*(?:#.*)?")
_UNQUOTED = re.compile(r"\s*([\w.\"-]+\s*=)\s*([+-]?[\d.]+\s*[A-Za-z%°µ][^#\"]*?)\s*(?:#.*)?")


def _syntax_fault(file: FilePath, text: str, reason: str) -> Fault:
    """Return the fault of a text that is not TOML; a number with its unit gets its quotes."""
    if (long := _LONG.search(text)) is not None and "digits" in reason:
        digits = sum(map(str.isdecimal, long[0]))
        line = text.count("\n", 0, long.start()) + 1
        message = f"expected numbers of fewer digits, found one of {digits}"
        return Fault(str(file), line, "", message)
    place = re.search(r"\s*\(at (?:line (\d+), column \d+|end of document)\)", reason)
    lines = text.splitlines()
    line = int(place.group(1)) if place and place.group(1) else max(1, len(lines))
    reason = reason[: place.start()] if place else reason
    if _AGAIN.match(reason) and 0 < line <= len(lines):
        name = lines[line - 1].split("#")[0].split("=")[0].strip()
        message = f"expected each key and table once, found {name} again"
        return Fault(str(file), line, "", message)
    last = lines[line - 1] if line <= len(lines) else ""
    bare = _UNQUOTED.fullmatch(last) or _WORD.fullmatch(last)
    hint = ""
    if bare:
        value = bare[2].lower() if bare[2] in ("True", "False") else f'"{bare[2]}"'
        hint = f"; did you mean {bare[1]} {value}?"
    reason = reason[:1].lower() + reason[1:]
    return Fault(str(file), line, "", f"expected TOML, found a mistake: {reason}{hint}")
