"""What a fit leaves behind: scenes ready to run, numbers in a file, and what its pictures show."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lumpedcable.fitting.laws import law_bands
from lumpedcable.fitting.report import contents_of, status_of
from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.uncertainty import Draws
from lumpedcable.results.numbers import write_numbers, write_text
from lumpedcable.scene import SceneError, Study, load_study
from lumpedcable.scene.runs import Factor
from lumpedcable.scene.writer import to_toml

__all__ = ["pictures_of", "ropes_picture", "write_fit", "write_ropes"]


def write_fit(
    fitted: Fitted, others: dict[str, Fitted], folder: Path
) -> tuple[list[Path], list[str]]:
    """Write the fitted scenes, those of other laws each in a folder of its name, and fit.json.

    Returns:
        The files made, and what is wrong with a fitted scene that would not run.

    Raises:
        OutputError: they cannot be written there.
    """
    made, wrong = _write_scenes(fitted, folder)
    more, faults = _write_each(others, folder)
    made, wrong = made + more, wrong + faults
    contents = contents_of(fitted)
    if others:
        contents["choices"] = {name: contents_of(other) for name, other in others.items()}
    write_numbers(folder / "fit.json", contents)
    made.append(folder / "fit.json")
    if fitted.draws is not None:
        write_text(folder / "draws.csv", _draw_rows(fitted, fitted.draws))
        made.append(folder / "draws.csv")
    return made, wrong


def _draw_rows(fitted: Fitted, draws: Draws) -> str:
    """One line a draw: its chain, and all numbers in SI."""
    heads = [f"{p.name.replace(',', '')} ({p.unit or '-'})" for p in fitted.problem.parameters]
    rows = [",".join(["chain", *heads])]
    for chain, values in enumerate(draws.values):
        rows += [",".join([str(chain), *(f"{x:.10g}" for x in row)]) for row in values]
    return "\n".join(rows) + "\n"


def _write_scenes(fitted: Fitted, folder: Path) -> tuple[list[Path], list[str]]:
    made, wrong = [], []
    for name, text in _scenes(fitted).items():
        path = folder / f"{name}.toml"
        write_text(path, text)
        made.append(path)
        try:
            load_study(path)
        except SceneError as error:
            wrong.append(str(error))
    return made, wrong


def _write_each(fits: Mapping[str, Fitted], folder: Path) -> tuple[list[Path], list[str]]:
    """The scenes of each fit in a folder of its name."""
    made, wrong = [], []
    for name, fitted in fits.items():
        paths, faults = _write_scenes(fitted, folder / name)
        made += paths
        wrong += faults
    return made, wrong


def write_ropes(fits: Mapping[str, Fitted], folder: Path) -> tuple[list[Path], list[str]]:
    """Write fit.json and ropes.csv of many ropes, and the fitted scenes of each in a folder.

    Returns:
        The files made, and what is wrong with a fitted scene that would not run.

    Raises:
        OutputError: they cannot be written there.
    """
    made, wrong = _write_each(fits, folder)
    write_numbers(folder / "fit.json", {"ropes": {n: contents_of(f) for n, f in fits.items()}})
    write_text(folder / "ropes.csv", _rows(fits))
    return [*made, folder / "fit.json", folder / "ropes.csv"], wrong


def _rows(fits: Mapping[str, Fitted]) -> str:
    """One line a rope: status, deviations over the noise, every number with its interval, in SI."""
    parameters = next(iter(fits.values())).problem.parameters
    heads = ["rope", "status", "left over (-)"]
    for p in parameters:
        name, unit = p.name.replace(",", ""), p.unit or "-"
        heads += [f"{name} ({unit})", f"{name} low ({unit})", f"{name} high ({unit})"]
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")  # a rope's name may hold a comma
    rows.writerow(heads)
    for name, f in fits.items():
        cells = [name, status_of(f), f"{f.certainty.factor:.6g}"]
        for k, x in enumerate(f.values):
            cells += [f"{v:.10g}" for v in (x, f.certainty.low[k], f.certainty.high[k])]
        rows.writerow(cells)
    return text.getvalue()


def ropes_picture(fits: Mapping[str, Fitted], title: str) -> dict[str, Any]:
    """What the figure of many ropes is drawn from, as plain numbers."""
    parameters = next(iter(fits.values())).problem.parameters
    numbers = [
        {
            "title": p.label, "unit": p.unit,
            "values": np.array([f.values[k] for f in fits.values()]),
            "low": np.array([f.certainty.low[k] for f in fits.values()]),
            "high": np.array([f.certainty.high[k] for f in fits.values()]),
        }
        for k, p in enumerate(parameters)
    ]  # fmt: skip
    confidence = next(iter(fits.values())).problem.method.confidence
    return {"heading": title, "ropes": list(fits), "numbers": numbers, "confidence": confidence}


def _scenes(fitted: Fitted) -> dict[str, str]:
    """Scenes with the values found, as TOML by name.

    The fit's own scene with its sweep, where a value for all experiments is one of its numbers; and
    one for every experiment that has private values, a scene of its own, or numbers of its own.
    """
    problem = fitted.problem
    base = problem.study
    found = {}
    if common := _keys(fitted, base):
        found[f"{base.path.stem}-fitted"] = _toml(fitted, base)
    private = {p.experiment for p in problem.parameters}
    for table in problem.tables:
        if table.name in private:
            found[f"{base.path.stem}-{table.name}-fitted"] = _toml(fitted, base, table.name)
    for record in problem.records:
        mine = _keys(fitted, record.study, record.name)
        own = record.name in private or record.study.path != base.path or not mine <= common
        if mine and own:
            name = f"{record.study.path.stem}-{record.name}-fitted"
            found[name] = _toml(fitted, record.study, record.name)
    return found


def _keys(fitted: Fitted, study: Study, experiment: str | None = None) -> set[str]:
    """The numbers of a scene that have a value found, for all experiments or for this one."""
    mine = {p.key for p in fitted.problem.parameters if p.experiment in (None, experiment)}
    return mine & study.scene.numbers().keys()


def _toml(fitted: Fitted, study: Study, experiment: str | None = None) -> str:
    """A scene with the values found, and its sweep of all other numbers."""
    keys = _keys(fitted, study, experiment)
    scene = fitted.scene(study.scene, experiment)
    if any(axis.key in keys for axis in study.axes):  # other runs than the references tell of
        scene = scene.model_copy(update={"references": {}})
    return to_toml(scene, [kept for factor in study.factors if (kept := _without(factor, keys))])


def _without(factor: Factor, keys: set[str]) -> Factor | None:
    """A factor of a sweep whose other numbers still move, as with `--set KEY=VALUE`; None of none."""
    axes = tuple(axis for axis in factor.axes if axis.key not in keys)
    drawn = {key: value for key, value in factor.drawn.items() if key not in keys}
    return replace(factor, axes=axes, drawn=drawn) if axes else None


def pictures_of(fitted: Fitted) -> dict[str, Any]:
    """What the figures of a fit are drawn from, as plain numbers."""
    problem = fitted.problem
    series = [
        {
            "title": s.label, "x_name": "time" if s.x_unit == "s" else "strain",
            "x_unit": s.x_unit, "x": s.x, "unit": s.unit, "measured": s.values, "model": p,
            "noise": s.noise, "time": s.time,
        }
        for s, p in zip(problem.series, fitted.predicted, strict=True)
    ]  # fmt: skip
    laws = [
        {
            "title": b.material + (f" [{b.experiment}]" if b.experiment else ""),
            "strain": b.strain, "start": b.start, "found": b.tension, "half": b.half,
            "data": b.data,
        }
        for b in law_bands(fitted)
    ]  # fmt: skip
    return {
        "heading": problem.title,
        "series": series,
        "names": [p.label for p in problem.parameters],
        "correlation": np.nan_to_num(fitted.certainty.correlation),
        "laws": laws,
        "profiles": [
            {
                "title": problem.parameters[one.parameter].label,
                "unit": problem.parameters[one.parameter].unit,
                "x": one.x,
                "root": one.root,
                "best": fitted.values[one.parameter],
                "std": fitted.certainty.std[one.parameter],
                "reach": one.reach,
                "low": one.low,
                "high": one.high,
            }
            for one in fitted.profiles
        ],
        "draws": [] if fitted.draws is None else [
            {
                "title": p.label, "unit": p.unit, "values": fitted.draws.values[:, :, k].ravel(),
                "best": fitted.values[k], "std": fitted.certainty.std[k],
                "low": fitted.draws.low[k], "high": fitted.draws.high[k],
            }
            for k, p in enumerate(problem.parameters)
        ],
        "confidence": problem.method.confidence,
    }  # fmt: skip
