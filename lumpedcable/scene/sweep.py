"""A sweep: the grid over chosen numbers of a scene, and its runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

from pydantic_core import PydanticCustomError

from lumpedcable.scene.part import Path, Problem, did_you_mean
from lumpedcable.scene.quantities import found
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import Absent, Spot, is_broken, is_open_list, numeric, paths, spot_at
from lumpedcable.scene.units import format_quantity
from lumpedcable.scene.validate import SECTIONS, read_scene

MAX_RUNS = 10_000_000
"""Largest number of runs of one sweep."""
_CHECKED = 1000  # up to this many runs are all checked; beyond it, axis by axis and the corners


@dataclass(frozen=True)
class Axis:
    """One swept number."""

    key: str
    """Dotted path in the scene: "lines.rope.end.held.pretension"."""
    values: tuple[float, ...] | tuple[int, ...]
    """Its values in SI, in the order of the file."""
    unit: str
    """SI unit, "" for a pure number."""
    label: str
    """Short name for people: "rope pretension"."""

    @property
    def path(self) -> Path:
        """The key as a path."""
        return tuple(self.key.split("."))

    def text(self, index: int) -> str:
        """Return one value with its unit, for people."""
        return format_quantity(self.values[index], self.unit)


class Runs(Sequence[Scene]):
    """The scenes of a grid in order, first axis slowest; each is built when it is asked for."""

    def __init__(self, data: dict[str, Any], axes: Sequence[Axis], base: Scene):
        self._data = {key: value for key, value in data.items() if key != "references"}
        self._axes, self._base = tuple(axes), base
        self._shape = tuple(len(axis.values) for axis in axes)

    def __len__(self) -> int:
        return math.prod(self._shape)

    @overload
    def __getitem__(self, index: int) -> Scene: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Scene, ...]: ...
    def __getitem__(self, index: int | slice) -> Scene | tuple[Scene, ...]:
        if isinstance(index, slice):
            return tuple(self[i] for i in range(*index.indices(len(self))))
        if not -len(self) <= index < len(self):
            raise IndexError(f"run {index} of {len(self)}")
        if not self._axes:
            return self._base
        values = at_indices(self._axes, self.indices(index % len(self)))
        scene = Scene.model_validate(with_values(self._data, values))
        return scene.model_copy(update={"references": self._base.references})

    def indices(self, run: int) -> tuple[int, ...]:
        """Return the place of a run on each axis."""
        places = []
        for size in reversed(self._shape):
            run, place = divmod(run, size)
            places.append(place)
        return tuple(reversed(places))

    def values(self, run: int) -> dict[str, float]:
        """Return the swept values of a run in SI, by key."""
        places = self.indices(range(len(self))[run])
        return {a.key: a.values[i] for a, i in zip(self._axes, places, strict=True)}


def at_indices(axes: Sequence[Axis], indices: Sequence[int]) -> dict[Path, float]:
    """Return the values at one point of the grid, by path."""
    return {axis.path: axis.values[i] for axis, i in zip(axes, indices, strict=True)}


def with_values(data: dict[str, Any], values: dict[Path, Any]) -> dict[str, Any]:
    """Return raw data with values put in, missing tables made, and nothing changed in place."""
    for path, value in values.items():
        data = _put(data, path, value)
    return data


def _put(raw: Any, path: Path, value: Any) -> Any:
    if not path:
        return value
    key, rest = path[0], path[1:]
    if isinstance(raw, list):
        index = int(key)
        return [*raw[:index], _put(raw[index], rest, value), *raw[index + 1 :]]
    table = raw if isinstance(raw, dict) else {}
    return {**table, key: _put(table.get(key), rest, value)}


def flattened(sweep: Any) -> Iterator[tuple[Path, str, Any]]:
    """Yield (path in the file, key, values) of a raw sweep.

    A key without quotes ("lines.rope.length = ...") is a nest of tables in TOML and read alike.
    """

    def walk(path: Path, table: dict[str, Any]) -> Iterator[tuple[Path, str, Any]]:
        for key, value in table.items():
            if isinstance(value, dict):
                yield from walk((*path, key), value)
            else:
                yield (*path, key), ".".join(map(str, (*path[1:], key))), value

    yield from walk(("sweep",), sweep)


def read_axes(
    sweep: Mapping[str, tuple[Path, Any]], data: dict[str, Any]
) -> tuple[list[Axis], dict[str, Path], list[Problem]]:
    """Return the axes of a sweep, where each stands in the file, and what is wrong with it.

    Args:
        sweep: place in the file and raw values, by key.
        data: the scene that is swept, as TOML tables.
    """
    axes, places, problems = [], {}, []
    root = Spot(Scene, data)
    for key, (place, raw) in sweep.items():
        kind, message = swept_number(root, key)
        if kind is None:
            problems += [Problem(place, message)] if message else []
            continue
        if not isinstance(raw, list) or not raw:
            problems.append(
                Problem(
                    place, f"expected a list of values, each {kind.expected}, found {found(raw)}"
                )
            )
            continue
        values = []
        for i, item in enumerate(raw):
            try:
                value = kind.read(item)
            except PydanticCustomError as error:
                problems.append(Problem((*place, i), error.message()))
                continue
            if value in values:
                problems.append(
                    Problem((*place, i), f"expected each value once, found {found(item)} again")
                )
            values.append(value)
        if values:
            axes.append(Axis(key, tuple(values), kind.unit, label_of(root, key)))
            places[key] = place
    return _distinct(axes), places, problems


def swept_number(root: Spot, key: str) -> tuple[Any, str]:
    """Return what kind of number a key holds, or None and what is wrong with the key.

    Nothing is said to be wrong below something that is no table or of no kind: told elsewhere.
    """
    path = tuple(key.split("."))
    if any(is_broken(spot_at(root, path[:n])) for n in range(1, len(path))):
        return None, ""
    expected = "expected the full path of a number of the scene"
    spot = spot_at(root, path)
    if spot is not None and numeric(spot) is not None and path[0] not in ("output", "references"):
        parent = spot_at(root, path[:2])
        if path[0] not in SECTIONS or (parent is not None and parent.value is not Absent):
            return numeric(spot), ""
    if path[0] == "output":
        return None, f'{expected}, found "{key}": all runs share one [output]'
    known = [".".join(map(str, p)) for p, _ in paths(root) if _is_swept(root, p)]
    ending = [k for k in known if k.endswith(f".{key}")]
    hint = f'; did you mean "{ending[0]}"?' if len(ending) == 1 else did_you_mean(key, known)
    if spot is not None and spot.value is not Absent:
        return None, f'{expected}, found "{key}", which is no number'
    return None, f'{expected}, found "{key}"{hint}'


def _is_swept(root: Spot, path: Path) -> bool:
    spot = spot_at(root, path)
    return (
        path[0] not in ("output", "references") and spot is not None and numeric(spot) is not None
    )


def label_of(root: Spot, key: str) -> str:
    """Return "rope pretension" for lines.rope.end.held.pretension, "rope fixed z" for ... .2."""
    words = key.split(".")
    vector = spot_at(root, tuple(words[:-1]))
    if vector is not None and isinstance(vector.value, list):
        component = words[-1] if is_open_list(vector) else "xyz"[int(words[-1])]
        words[-2:] = [f"{words[-2]} {component}"]
    return f"{words[1]} {words[-1]}" if words[0] in SECTIONS and len(words) > 2 else words[-1]


def _distinct(axes: list[Axis]) -> list[Axis]:
    """Return the axes with their keys as labels where short labels would be the same."""
    labels = [axis.label for axis in axes]
    return [
        Axis(a.key, a.values, a.unit, a.key if labels.count(a.label) > 1 else a.label) for a in axes
    ]


def run_problems(
    data: dict[str, Any], axes: Sequence[Axis], places: dict[str, Path], known: Iterable[Problem]
) -> list[Problem]:
    """Return what is wrong in the runs of a grid but not in the file's own scene."""
    told = {problem.path for problem in known}
    points = list(_looked_at([len(axis.values) for axis in axes]))
    # Problems by where they are told: the swept value itself, or a value that it does not fit.
    found_at: dict[Path, list[tuple[str, tuple[int, ...]]]] = {}
    runs_of: dict[Path, int] = {}
    for indices in points:
        swept = {a.path: (*places[a.key], i) for a, i in zip(axes, indices, strict=True)}
        for place in swept.values():
            runs_of[place] = runs_of.get(place, 0) + 1
        for problem in read_scene(with_values(data, at_indices(axes, indices)))[1]:
            if problem.path not in told:
                place = swept.get(problem.path, problem.path)
                found_at.setdefault(place, []).append((problem.message, indices))
    problems = []
    for place, failures in found_at.items():
        message, indices = failures[0]
        if len(failures) < runs_of.get(place, math.inf):
            run = ", ".join(f"{a.key} = {a.text(i)}" for a, i in zip(axes, indices, strict=True))
            message = f"{message} (in the run with {run})"
        problems.append(Problem(place, message))
    return problems


def _looked_at(shape: Sequence[int]) -> Iterable[tuple[int, ...]]:
    if math.prod(shape) <= _CHECKED:
        return itertools.product(*map(range, shape))
    one_by_one = (
        tuple(place if axis == moved else 0 for axis in range(len(shape)))
        for moved, size in enumerate(shape)
        for place in range(size)
    )
    corners = itertools.islice(itertools.product(*({0, n - 1} for n in shape)), _CHECKED)
    return dict.fromkeys(itertools.chain(one_by_one, corners))
