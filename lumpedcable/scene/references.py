"""Reference numbers put beside the runs they belong to."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from lumpedcable.scene.part import Problem
from lumpedcable.scene.run import Reference
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.sweep import Axis


def count_problems(references: dict[str, Reference], axes: Sequence[Axis]) -> list[Problem]:
    """Return a problem for each list that has not one value per run of the file's own sweep."""
    runs = math.prod(len(axis.values) for axis in axes)
    return [
        Problem(
            ("references", name, "values", key),
            f"expected {runs} value{'s' if runs > 1 else ''}, one per run, found {len(values)}",
        )
        for name, reference in references.items()
        for key, values in reference.values.items()
        if len(values) != runs
    ]


def aligned(scene: Scene, file_axes: Sequence[Axis], axes: Sequence[Axis]) -> dict[str, Reference]:
    """Return the references of a scene, one value per run of ``axes``.

    Overrides may have changed the sweep. A run keeps the values of the file's run with the same
    numbers on the file's axes; a run without such a one has nan, and what is nan throughout is
    left out.
    """
    if tuple(file_axes) == tuple(axes):
        return scene.references
    places = [_place(run, file_axes) for run in _coordinates(scene, file_axes, axes)]
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


def _coordinates(
    scene: Scene, file_axes: Sequence[Axis], axes: Sequence[Axis]
) -> list[tuple[float, ...]]:
    """Return where each run stands on the axes of the file."""
    numbers = scene.numbers()
    grid = itertools.product(*(axis.values for axis in axes))
    return [
        tuple(
            {axis.key: value for axis, value in zip(axes, point, strict=True)}.get(
                own.key, numbers.get(own.key, math.nan)
            )
            for own in file_axes
        )
        for point in grid
    ]


def _place(point: tuple[float, ...], axes: Sequence[Axis]) -> int | None:
    """Return the number of the file's run at a point, or None."""
    run = 0
    for value, axis in zip(point, axes, strict=True):
        near = (i for i, own in enumerate(axis.values) if math.isclose(own, value, rel_tol=1e-12))
        index = next(near, None)
        if index is None:
            return None
        run = run * len(axis.values) + index
    return run
