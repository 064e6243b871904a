"""A fit of five numbers to four break histories: its time, and its evaluations beside SciPy's."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
from scipy.optimize import minimize

from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.load import load_fit
from lumpedcable.fitting.residual import penalised, predict
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.transforms import to_unbounded
from lumpedcable.study.compiled import RUN_ONCE

FILE = Path(__file__).parents[1] / "configs" / "fit" / "nylon-breaks.toml"
TRUTH = np.array([270.3e3, 10.2, -2.128, 262.7e3, 135.5])
NOISE, SEED = 0.01, 1
STARTS = {"30 % above": 1.3, "half": 0.5, "half as much again": 1.5}
METHODS = {"Nelder-Mead": {"maxfev": 4000, "adaptive": True}, "Powell": {"maxfev": 4000}}
NEAR = 0.1  # above the least sum of squares (over the noise squared): as good as there


def run(quick: bool = False) -> dict[str, Any]:
    """All starts at one mesh."""
    segments = 50 if quick else 100
    problem = measured(segments)
    spec, arrays = arrays_of(problem)
    plain = jax.jit(penalised, static_argnames=("spec",))
    fit_problem(begun(problem, 1.1 * TRUTH))  # compiles
    rows = []
    for name, factor in STARTS.items():
        mine = begun(problem, factor * TRUTH)
        begin = time.perf_counter()
        fitted = fit_problem(mine)
        seconds = time.perf_counter() - begin
        row = {
            "start": name, "seconds": seconds, "evaluations": fitted.evaluations,
            "plain": fitted.sampled, "searches": len(fitted.starts), "loss": fitted.loss,
            "failed": sum(s.failed for s in fitted.starts), "converged": fitted.converged,
            "others": {},
        }  # fmt: skip
        _, arrays = arrays_of(mine)
        at = to_unbounded(arrays.transform, factor * TRUTH)
        for method in METHODS if not quick else ():
            row["others"][method] = derivative_free(
                lambda z, arrays=arrays: float(np.sum(np.square(plain(spec, arrays, z)[0]))),
                at, method, fitted.loss,
            )  # fmt: skip
        rows.append(row)
    return {"segments": segments, "values": problem.points, "rows": rows}


def measured(segments: int) -> FitProblem:
    """The four break tests with data of the model itself at the truth, and noise."""
    with tempfile.TemporaryDirectory() as folder:
        text = FILE.read_text(encoding="utf-8").replace("../", f"{FILE.parents[1]}/")
        text = text.replace('file = "', f'file = "{FILE.parent}/')
        path = Path(folder) / "fit.toml"
        path.write_text(text.replace('segments" = 50', f'segments" = {segments}'))
        problem = load_fit(path).problem
    spec, arrays = arrays_of(begun(problem, TRUTH))
    said = jax.jit(predict, static_argnames=("spec",), compiler_options=RUN_ONCE)
    (answers,) = said(spec, arrays, TRUTH).groups
    random = np.random.default_rng(SEED)
    records = []
    for record, rows in zip(problem.records, np.asarray(answers), strict=True):
        series = []
        for s, values in zip(record.series, rows, strict=True):
            size = NOISE * float(np.max(np.abs(values)))
            noisy = values + size * random.standard_normal(values.size)
            series.append(replace(s, values=noisy, noise=size))
        records.append(replace(record, series=tuple(series)))
    return replace(problem, records=tuple(records))


def begun(problem: FitProblem, values: np.ndarray) -> FitProblem:
    """The same from other start values."""
    parameters = [
        replace(p, start=float(x)) for p, x in zip(problem.parameters, values, strict=True)
    ]
    return replace(problem, parameters=tuple(parameters))


def derivative_free(loss, at: np.ndarray, method: str, least: float) -> dict[str, Any]:
    """What a method of SciPy takes from the same start: evaluations until as good as there."""
    count, reached, best = 0, None, np.inf

    def counted(z):
        nonlocal count, reached, best
        value, count = loss(z), count + 1
        best = min(best, value)
        if reached is None and value <= least + NEAR:
            reached = count
        return value

    begin = time.perf_counter()
    minimize(counted, at, method=method, options=METHODS[method])
    seconds = time.perf_counter() - begin
    return {"evaluations": count, "reached": reached, "loss": best, "seconds": seconds}


def table(data: dict[str, Any]) -> str:
    """The table for the page."""
    heads = ["start", "time, s", "evaluations with derivatives", "plain", "failed runs",
             *(f"{m}, plain" for m in METHODS)]  # fmt: skip
    rows = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for row in data["rows"]:
        cells = [
            row["start"], f"{row['seconds']:.2g}", str(row["evaluations"]), str(row["plain"]),
            str(row["failed"]),
        ]  # fmt: skip
        for method in METHODS:
            other = row["others"].get(method)
            cells.append("-" if other is None else _said(other, row["loss"]))
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


def _said(other: dict[str, Any], least: float) -> str:
    if other["reached"] is not None:
        return str(other["reached"])
    return f"not in {other['evaluations']}: {other['loss'] - least:+.2g} above"
