"""Reference numbers put beside the runs they belong to."""

from __future__ import annotations

import itertools
import math
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic_core import PydanticCustomError

from lumpedcable.scene.outcomes import RESULTS
from lumpedcable.scene.part import Path, Problem, did_you_mean
from lumpedcable.scene.quantities import Quantity
from lumpedcable.scene.run import Reference
from lumpedcable.scene.runs import Factor
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.tree import Absent, Spot, number_at, numeric, spot_at


def result_problems(scene: Scene, data: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield values of no result, and those whose unit is not their result's.

    Args:
        scene: as read, its references without units.
        data: the same as TOML tables, with units.
    """
    known = RESULTS | {name: measure.UNIT for name, measure in scene.measures.items()}
    for name, reference in scene.references.items():
        for key in reference.values:
            path: Path = ("references", name, "values", key)
            if key not in known:
                hint = did_you_mean(key, known) or f"; known: {', '.join(known)}"
                yield Problem(path, f'expected the name of a result, found "{key}"{hint}')
                continue
            raw = data["references"][name]["values"][key]
            for i, item in enumerate(raw if isinstance(raw, list) else [raw]):
                try:
                    if isinstance(item, str):
                        Quantity(known[key]).read(item)
                except PydanticCustomError as error:
                    yield Problem((*path, i), error.message())


def count_problems(references: dict[str, Reference], factors: Sequence[Factor]) -> list[Problem]:
    """Return a problem for each list that has not one value per run of the file's own sweep."""
    runs = math.prod(map(len, factors))
    return [
        Problem(
            ("references", name, "values", key),
            f"expected {runs} value{'s' if runs > 1 else ''}, one per run, found {len(values)}",
        )
        for name, reference in references.items()
        for key, values in reference.values.items()
        if len(values) != runs
    ]


def aligned(
    scene: Scene, data: Any, file_factors: Sequence[Factor], factors: Sequence[Factor]
) -> dict[str, Reference]:
    """Return the references of a scene, read from `data`, one value per run of ``factors``.

    Overrides may have changed the sweep. A run keeps the values of the file's run with the same
    swept numbers; a run without such a one has nan, and what is nan throughout is left out.
    """
    if not scene.references or tuple(file_factors) == tuple(factors):
        return scene.references
    asked = [axis.key for factor in file_factors for axis in factor.axes]
    stated = {key: _stated(Spot(Scene, data), key) for key in asked}
    places = [_place(run, file_factors) for run in _numbers(stated, factors)]
    kept = {}
    for name, reference in scene.references.items():
        values = {
            key: tuple(math.nan if place is None else column[place] for place in places)
            for key, column in reference.values.items()
        }
        told = {key: column for key, column in values.items() if not all(map(math.isnan, column))}
        if told:
            kept[name] = reference.model_copy(update={"values": told})
    return kept


def _stated(root: Spot, key: str) -> float:
    """The number of a scene at a key in SI, of a direction as it is given; NaN without one."""
    path = tuple(key.split("."))
    raw, spot = number_at(root, path), spot_at(root, path)
    kind = None if spot is None or raw is Absent else numeric(spot)
    return math.nan if kind is None else float(kind.read(raw))


def _numbers(numbers: dict[str, float], factors: Sequence[Factor]) -> Iterator[Mapping[str, float]]:
    """Yield the numbers of each run by key, those that are not swept from `numbers`."""
    for rows in itertools.product(*(range(len(factor)) for factor in factors)):
        own: dict[str, float] = {}
        for factor, row in zip(factors, rows, strict=True):
            own |= factor.at(row)
        yield ChainMap(own, numbers)


def _place(run: Mapping[str, float], factors: Sequence[Factor]) -> int | None:
    """Return the number of the file's run that has a run's numbers, or None."""
    place = 0
    for factor in factors:
        near = (row for row in range(len(factor)) if _same(factor.at(row), run))
        row = next(near, None)
        if row is None:
            return None
        place = place * len(factor) + row
    return place


def _same(own: Mapping[str, float], run: Mapping[str, float]) -> bool:
    return all(math.isclose(v, run.get(k, math.nan), rel_tol=1e-12) for k, v in own.items())
