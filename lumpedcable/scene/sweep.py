"""Reading [sweep]: lists, ranges, cases, keys that move together, and draws."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from pydantic_core import PydanticCustomError

from lumpedcable.scene.draws import METHODS, cut_off, spread, unit_draws
from lumpedcable.scene.entries import DRAW, RANGE, Entry
from lumpedcable.scene.labels import label_of
from lumpedcable.scene.part import Path, Problem, did_you_mean, either
from lumpedcable.scene.quantities import Count, Quantity, found
from lumpedcable.scene.runs import Axis, Factor, distinct
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import (
    Absent,
    Spot,
    is_broken,
    is_drawn,
    number_at,
    numeric,
    paths,
    spot_at,
)
from lumpedcable.scene.units import format_quantity
from lumpedcable.scene.validate import SECTIONS

MAX_RUNS = 10_000_000
"""Largest number of runs of one sweep."""


class Reading(NamedTuple):
    """A sweep as far as it could be read."""

    factors: list[Factor]
    places: dict[str, Callable[[int], Path]]
    """By key: where the value of a row stands in the file."""
    problems: list[Problem]


def read_factors(entries: Iterable[Entry], data: dict[str, Any]) -> Reading:
    """Return the factors of a sweep, where each value stands in the file, and what is wrong.

    Args:
        entries: the sweep as written.
        data: the scene that is swept, as TOML tables.
    """
    reader = _Reader(Spot(Scene, data))
    factors = []
    for entry in entries:
        wrong = len(reader.problems)
        factor = getattr(reader, entry.kind)(entry) if entry.keys or entry.settings else None
        if (
            factor is not None
            and factor.axes
            and (entry.kind == "list" or not reader.problems[wrong:])
        ):
            factors.append(factor)
    return Reading(distinct(factors), reader.places, reader.problems)


class _Reader:
    """The kinds of factors, each by the name it has in the file."""

    def __init__(self, root: Spot):
        self.root = root
        self.places: dict[str, Callable[[int], Path]] = {}
        self.problems: list[Problem] = []

    def list(self, entry: Entry) -> Factor | None:
        """One key with its list or range."""
        ((key, (place, raw)),) = entry.keys.items()
        axis = self._column(key, place, raw, once=True)
        return None if axis is None else Factor((axis,))

    def zip(self, entry: Entry) -> Factor | None:
        """Keys with lists or ranges of one length."""
        columns = {key: self._column(key, *raw) for key, raw in entry.keys.items()}
        axes = [axis for axis in columns.values() if axis is not None]
        if len(axes) < len(columns):
            return None
        for axis in axes[1:]:
            if len(axis.values) != len(axes[0].values):
                self._tell(
                    entry.keys[axis.key][0],
                    f'expected {len(axes[0].values)} values, as "{axes[0].key}" has, since they '
                    f"move together, found {len(axis.values)}",
                )
        return Factor(tuple(axes), "zip")

    def cases(self, entry: Entry) -> Factor | None:
        """Rows with keys of their own; what a row leaves out is as in the scene."""
        axes = []
        for key, cells in entry.keys.items():
            first = next(cell for cell in cells if cell is not None)
            kind = self._kind(key, first[0])
            if kind is None:
                continue
            own = number_at(self.root, tuple(key.split(".")))
            values = []
            for i, cell in enumerate(cells):
                place = (*entry.place, i, key) if cell is None else cell[0]
                if cell is None and own is Absent:
                    self._tell(
                        place, f'expected "{key}" in every case or in the scene, found nothing'
                    )
                    continue
                value = self._read(kind, place, own if cell is None else cell[1])
                values += [] if value is None else [value]
            if len(values) == len(cells):
                axes.append(self._axis(key, values, kind))
                self.places[key] = lambda row, key=key: (*entry.place, row, key)
        return Factor(tuple(axes), "cases", entry.names)

    def sample(self, entry: Entry) -> Factor | None:
        """Keys with distributions, drawn together."""
        method, count, seed = self._settings(entry)
        laws: dict[str, tuple[Any, dict[str, Any]]] = {}
        for key, (place, raw) in entry.keys.items():
            kind = self._kind(key, place)
            law = None if kind is None else self._law(kind, place, raw)
            if law is not None:
                laws[key] = (kind, law)
        if not entry.keys:
            self._tell(entry.place, "expected at least one key with its distribution, found none")
        if (
            count is None
            or method is None
            or seed is None
            or len(laws) < len(entry.keys)
            or not laws
        ):
            return None
        points = unit_draws(method, count, len(laws), seed)
        axes = []
        for column, (key, (kind, law)) in zip(points.T, laws.items(), strict=True):
            values = spread(column, law)
            place = entry.keys[key][0]
            self._in_range(kind, place, values)
            axes.append(self._axis(key, array("d", values.tobytes()), kind))
            self.places[key] = lambda row, place=place: place
        drawn = {"method": method, "count": count, "seed": seed}
        return Factor(tuple(axes), "sample", (), drawn | {k: law for k, (_, law) in laws.items()})

    # --- pieces -----------------------------------------------------------------------------

    def _tell(self, place: Path, message: str) -> None:
        self.problems.append(Problem(place, message))

    def _axis(self, key: str, values: Sequence[float], kind: Any) -> Axis:
        values = values if isinstance(values, array) else tuple(values)
        return Axis(key, values, kind.unit, label_of(self.root, key))

    def _kind(self, key: str, place: Path) -> Any:
        kind, message = swept_number(self.root, key)
        if kind is None and message:
            self._tell(place, message)
        return kind

    def _read(self, kind: Any, place: Path, raw: Any) -> Any:
        try:
            return kind.read(raw)
        except PydanticCustomError as error:
            self._tell(place, error.message())
            return None

    def _column(self, key: str, place: Path, raw: Any, once: bool = False) -> Axis | None:
        """An axis from a list or a range."""
        kind = self._kind(key, place)
        if kind is None:
            return None
        if isinstance(raw, dict):
            values = self._range(kind, place, raw)
            self.places[key] = lambda row: place
            return None if values is None else self._axis(key, values, kind)
        if not isinstance(raw, list) or not raw:
            self._tell(
                place, f"expected a list of values, each {kind.expected}, found {found(raw)}"
            )
            return None
        values = []
        seen: set[float] = set()
        for i, item in enumerate(raw):
            value = self._read(kind, (*place, i), item)
            if value is None:
                continue
            if once and value in seen:
                self._tell((*place, i), f"expected each value once, found {found(item)} again")
            seen.add(value)
            values.append(value)
        self.places[key] = lambda row: (*place, row)
        return self._axis(key, values, kind) if values else None

    def _keys(self, place: Path, raw: dict[str, Any], known: Sequence[str]) -> bool:
        unknown = [key for key in raw if key not in known]
        for key in unknown:
            words = f"expected {either(known)}, found {found(key)}{did_you_mean(key, known)}"
            words += "; distributions are drawn in sweep.sample" * (key in DRAW)
            self._tell((*place, key), words)
        return not unknown

    def _bounds(self, kind: Any, place: Path, raw: dict[str, Any]) -> tuple[Any, Any] | None:
        """`from` and `to`, in order, of a range or distribution that needs both."""
        ends = []
        for key in ("from", "to"):
            if key not in raw:
                self._tell(place, f"expected from and to, found no {key}")
                return None
            ends.append(self._read(kind, (*place, key), raw[key]))
        if None in ends:
            return None
        low, high = ends
        if not low < high:
            self._tell((*place, "to"), f"expected more than from, found {found(raw['to'])}")
            return None
        if not math.isfinite(high - low):
            words = (
                f"expected a way from {found(raw['from'])} that is finite, found {found(raw['to'])}"
            )
            self._tell((*place, "to"), words)
            return None
        spacing = raw.get("spacing", "linear")
        if spacing not in ("linear", "log"):
            self._tell((*place, "spacing"), f'expected "linear" or "log", found {found(spacing)}')
            return None
        if spacing == "log" and low <= 0:
            self._tell(
                (*place, "from"),
                f'expected more than 0 with spacing = "log", found {found(raw["from"])}',
            )
            return None
        return low, high

    def _range(self, kind: Any, place: Path, raw: dict[str, Any]) -> list[Any] | None:
        """Values from a to b: `count` of them in equal steps or ratios, or `step` apart."""
        if not self._keys(place, raw, RANGE):
            return None
        ends = self._bounds(kind, place, raw)
        if ends is None:
            return None
        low, high = ends
        if ("count" in raw) == ("step" in raw):
            both = "both" if "count" in raw else "neither"
            self._tell(place, f"expected count or step, found {both}")
            return None
        if "step" in raw:
            if raw.get("spacing") == "log":
                self._tell(place, 'expected count with spacing = "log", found step')
                return None
            of_step = (
                replace(kind, sign="positive", maximum=None)
                if isinstance(kind, Quantity)
                else Count()
            )
            step = self._read(of_step, (*place, "step"), raw["step"])
            if step is None:
                return None
            steps = (high - low) / step * (1 + 1e-9)
            if steps >= MAX_RUNS:
                many = math.floor(steps) + 1 if math.isfinite(steps) else "more than can be counted"
                self._tell((*place, "step"), f"expected at most {MAX_RUNS} values, found {many}")
                return None
            count = math.floor(steps) + 1
            if (high - low) / step - (count - 1) > 1e-9 * count:
                near = [format_quantity(low + step * n, kind.unit) for n in (count - 1, count)]
                self._tell(
                    (*place, "to"),
                    f"expected a whole number of steps from {found(raw['from'])}, to {near[0]} or "
                    f"{near[1]}, found {found(raw['to'])}",
                )
                return None
            values = low + step * np.arange(count)
        else:
            count = self._read(Count(2, MAX_RUNS), (*place, "count"), raw["count"])
            if count is None:
                return None
            space = np.geomspace if raw.get("spacing") == "log" else np.linspace
            values = space(low, high, count)
        if isinstance(kind, Count):
            if np.any(np.abs(values - np.rint(values)) > 1e-9):
                self._tell(place, f"expected steps that are whole numbers, found {values[1]:.6g}")
                return None
            return [int(v) for v in np.rint(values)]
        return np.minimum(values, high).tolist()

    def _settings(self, entry: Entry) -> tuple[str | None, int | None, int | None]:
        given = entry.settings
        method = given.get("method", "latin-hypercube")
        if method not in METHODS:
            known = either(f'"{m}"' for m in METHODS)
            hint = did_you_mean(method, METHODS)
            self._tell((*entry.place, "method"), f"expected {known}, found {found(method)}{hint}")
            method = None
        if "count" not in given:
            self._tell(entry.place, "expected count, the number of draws, found none")
        count = (
            self._read(Count(1, MAX_RUNS), (*entry.place, "count"), given["count"])
            if "count" in given
            else None
        )
        seed = self._read(Count(0, 2**32), (*entry.place, "seed"), given.get("seed", 0))
        return method, count, seed

    def _law(self, kind: Any, place: Path, raw: Any) -> dict[str, Any] | None:
        """A distribution in SI numbers."""
        if not isinstance(kind, Quantity):
            self._tell(place, "expected a number to draw that is no count; sweep a count by a list")
            return None
        if not isinstance(raw, dict):
            self._tell(
                place,
                f"expected a table with from and to, or mean and deviation, found {found(raw)}",
            )
            return None
        if not self._keys(place, raw, DRAW):
            return None
        if "mean" not in raw and "deviation" not in raw:
            ends = self._bounds(kind, place, raw)
            log = {"spacing": "log"} if raw.get("spacing") == "log" else {}
            return None if ends is None else {"from": ends[0], "to": ends[1], **log}
        if "mean" not in raw or "deviation" not in raw or "spacing" in raw:
            self._tell(
                place, "expected mean and deviation (with from and to as cuts), or from and to"
            )
            return None
        law = {}
        for key, own in (
            ("mean", replace(kind, sign="any")),
            ("deviation", replace(kind, sign="positive", maximum=None)),
            ("from", kind),
            ("to", kind),
        ):
            if key in raw:
                law[key] = self._read(own, (*place, key), raw[key])
        if None in law.values():
            return None
        if not law.get("from", -math.inf) < law.get("to", math.inf):
            self._tell((*place, "to"), f"expected more than from, found {found(raw['to'])}")
            return None
        if (off := cut_off(law)) is not None:
            apart = f" and {off[1]:.3g} apart" if math.isfinite(off[1]) else ""
            self._tell(
                place,
                "expected from and to that leave numbers to draw, found cuts that lie "
                f"{off[0]:.3g} deviations from the mean{apart}",
            )
            return None
        return law

    def _in_range(self, kind: Quantity, place: Path, values: np.ndarray) -> None:
        """Tell the draw that is farthest out of a kind's range, if any is."""
        for worst in (int(np.argmin(values)), int(np.argmax(values))):
            try:
                kind.read(float(values[worst]))
            except PydanticCustomError as error:
                self._tell(place, f"{error.message()} in draw {worst}; from and to cut the draws")
                return


def swept_number(root: Spot, key: str) -> tuple[Any, str]:
    """Return what kind of number a key holds, or None and what is wrong with the key.

    Nothing is said to be wrong below something that is no table or of no kind: told elsewhere.
    """
    path = tuple(key.split("."))
    if any(is_broken(spot_at(root, path[:n])) for n in range(1, len(path))):
        return None, ""
    expected = "expected the full path of a number of the scene"
    if is_drawn(root, path):
        return None, f'{expected}, found "{key}", which pictures alone read'
    if path[0] == "output":
        return None, f'{expected}, found "{key}": all runs share one [output]'
    spot, table = spot_at(root, path), spot_at(root, path[:2])
    named = path[0] in (*SECTIONS, "references")
    if spot is not None and (not named or (table is not None and table.value is not Absent)):
        if numeric(spot) is not None and path[0] != "references":
            return numeric(spot), ""
        return None, f'{expected}, found "{key}", which is no number'
    known = [".".join(map(str, p)) for p, _ in paths(root) if _is_swept(root, p)]
    ending = [k for k in known if k.endswith(f".{key}")]
    hint = f'; did you mean "{ending[0]}"?' if len(ending) == 1 else did_you_mean(key, known)
    return None, f'{expected}, found "{key}"{hint}'


def _is_swept(root: Spot, path: Path) -> bool:
    spot = spot_at(root, path)
    return (
        path[0] not in ("output", "references")
        and spot is not None
        and numeric(spot) is not None
        and not is_drawn(root, path)
    )
