"""What is wrong with a fit that can only be seen once data, scene and free numbers are together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from lumpedcable.fitting.columns import Columns
from lumpedcable.fitting.data import FitProblem, Smooth
from lumpedcable.fitting.language import FitFile, Free, RecordExperiment, TableExperiment
from lumpedcable.fitting.parameters import Parameter
from lumpedcable.scene import Scene, Study, TableMaterial
from lumpedcable.scene.part import Path, Problem, did_you_mean, dotted
from lumpedcable.scene.record_checks import record_problems
from lumpedcable.scene.units import format_quantity

__all__ = [
    "bench_problems",
    "length_problems",
    "smooth_tables",
    "uncovered_problems",
    "unknown_start",
    "whole_problems",
]

TOO_LONG = 50.0
"""Times a scene's duration from which a record is not believed: of seconds taken for minutes 60."""


def bench_problems(
    one: TableExperiment, study: Study, columns: Columns | None, path: Path
) -> list[Problem]:
    """What is wrong with the material of a bench's table, and with its strains."""
    material = study.scene.materials.get(one.material)
    if material is None:
        known = study.scene.materials
        hint = did_you_mean(one.material, known) or f"; known: {', '.join(known) or 'none'}"
        message = f'expected a material of the scene, found "{one.material}"{hint}'
        return [Problem((*path, "material"), message)]
    if material.law == "inextensible":
        message = (
            "expected a material whose tension follows from its strain, found "
            f'"{one.material}", which is inextensible'
        )
        return [Problem((*path, "material"), message)]
    if columns is None:
        return []
    strain = columns.values[0]
    table = isinstance(material, TableMaterial)
    top = material.strain[-1] if table else material.max_strain
    if strain.max() <= top:
        return []
    k = int(np.argmax(strain > top))
    what = "last strain of the table" if table else "max_strain"
    message = (
        f"expected strains up to the {what} of materials.{one.material}, {top:g}, "
        f"found {strain[k]:g} in {columns.at(k)}"
    )
    return [Problem((*path, "strain"), message)]


def uncovered_problems(study: Study, last: float, path: Path) -> list[Problem]:
    """Motions of a record's scene that end before its data do, at `last` (s), and not at rest.

    What a scene says itself is of its own duration, which a fit does not use.
    """
    scene = study.scene
    return [
        Problem((*path, "time"), f"{dotted(problem.path)}: {problem.message}")
        for problem in record_problems(scene.lines, scene.bodies, last, "the data end")
    ]


def unknown_start(scene: Scene) -> str | None:
    """What is wrong with a scene of which derivatives are wanted, where a break begins at a tension.

    Its beginning is found as the run goes, and no number of the program.
    """
    for name, event in scene.events.items():
        if event.tension is not None:
            return (
                f"expected breaks that begin at a time (start), found events.{name}, which begins at "
                f"{format_quantity(event.tension, 'N')}"
            )
    return None


def length_problems(
    study: Study, columns: Columns, one: RecordExperiment, path: Path
) -> list[Problem]:
    """Times that are so far beyond the scene's duration that another unit is likely meant."""
    own, last = study.scene.output.duration, float(columns.values[0][-1])
    if own == 0.0 or last < TOO_LONG * own:
        return []
    message = (
        f"expected times of about output.duration, {format_quantity(own, 's')}, found "
        f"{format_quantity(last, 's')} at the end of column {one.time.column} in {columns.name}: "
        "correct its unit, or give a longer output.duration in set"
    )
    return [Problem((*path, "time"), message)]


def smooth_tables(
    free: Mapping[str, Free], parameters: list[Parameter], at: Path
) -> tuple[list[Smooth], list[Problem]]:
    """The tables of tensions that are to be smooth, and what is wrong with them."""
    found, wrong = [], []
    for key, one in free.items():
        if one.smooth is None:
            continue
        place: Path = (*at, key, "smooth")
        mine = [p for p in parameters if p.key.startswith(f"{key}.")]
        if not key.startswith("materials.") or not key.endswith(".tension") or len(mine) < 3:
            message = (
                "expected the tensions of a table, materials.NAME.tension, of at least 3 "
                f'points, found "{key}"'
            )
            wrong.append(Problem(place, message))
            continue
        for owner in dict.fromkeys(p.experiment for p in mine):
            ends = [p.start for p in mine if p.experiment == owner]
            if ends[0] == ends[-1]:
                message = (
                    "expected tensions that start at a slope, of whose mean this is a share, found "
                    f"{format_quantity(ends[0], 'N')} at both ends"
                )
                wrong.append(Problem(place, message))
                break
            found.append(Smooth(key, owner, one.smooth))
    return found, wrong


def whole_problems(problem: FitProblem, file: FitFile, at: Path) -> list[Problem]:
    """What is wrong with a problem as a whole."""
    told = []
    if problem.points < len(problem.parameters) and not problem.smooth:
        told.append(
            Problem(
                at,
                f"expected at least as many measured values as free numbers, found "
                f"{problem.points} values for {len(problem.parameters)} numbers",
            )
        )
    if not problem.known_noise:
        told += _without_noise(problem, at)
    if (file.method.starts or 1) > 1:
        for p in problem.parameters:
            if not np.all(np.isfinite([p.low, p.high])):
                told.append(
                    Problem(
                        (*at, p.key),
                        "expected low and high, since several starts are drawn between them, "
                        f"found {_bounds(p)}",
                    )
                )
    return told


def _without_noise(problem: FitProblem, at: Path) -> list[Problem]:
    """What cannot be asked for where the noise of a column is missing."""
    missing = next(series for series in problem.series if series.noise is None)
    if any(series.noise is not None for series in problem.series):
        message = f"expected the noise of every column or of none, found none for {missing.label}"
        return [Problem(("experiments", missing.name), message)]
    # without it a deviation is a share of the largest value, which is no standard deviation
    told = []
    loss = problem.method.loss
    if loss != "squares":
        message = (
            f"expected the noise of every column, since {loss} forgives deviations by how many "
            f"standard deviations they are, found none for {missing.label}"
        )
        told.append(Problem(("method", "loss"), message))
    for key in dict.fromkeys(one.key for one in problem.smooth):
        message = (
            "expected the noise of every column, against which changes of slope are weighed, "
            f"found none for {missing.label}"
        )
        told.append(Problem((*at, key, "smooth"), message))
    return told


def _bounds(p: Parameter) -> str:
    found = [
        f"{key} = {format_quantity(getattr(p, key), p.unit)}"
        for key in ("low", "high")
        if np.isfinite(getattr(p, key))
    ]
    return f"{found[0]} alone" if found else "neither"
