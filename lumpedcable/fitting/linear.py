"""Numbers that enter tables of tensions linearly: solved for at once, and how far off they begin."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import islice

import jax
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from lumpedcable.fitting.data import FitProblem, Table
from lumpedcable.fitting.parameters import Parameter
from lumpedcable.model.materials import relaxation_of
from lumpedcable.physics.strain_history import relaxing_tension
from lumpedcable.scene import TanhMaterial
from lumpedcable.scene.units import format_quantity

__all__ = ["is_linear", "linear_start", "start_faults"]

Array = NDArray[np.float64]

LINEAR = {
    "linear": ("EA",), "tanh": ("p1", "p4", "p5"), "polynomial": ("coefficients",),
}  # fmt: skip
"""Keys of a law of which the tension is a sum of multiples; so it is of the EA of what relaxes."""
MOST_LAWS = 5000
"""Evaluations of laws at most, a second's worth: fewer places are tried where each needs many."""
OFF_BOUND = 1e-3
"""Share of the way from a bound to the start that a number keeps from that bound."""
LARGE = 50.0
"""Factor between data and the law at the start, or a scene's duration and a record's, from which a unit
is in doubt."""
AGAINST = -0.5
"""Correlation of data with the law at the start, below which a sign is in doubt."""
SPREAD = 0.1
"""Range of strains over the largest, below which a table tells of one strain alone."""


def is_linear(problem: FitProblem) -> bool:
    """Whether every free number enters the data linearly and their squares are summed.

    The sum then has one minimum within bounds, wherever a search begins.
    """
    only = not problem.records and not problem.smooth and problem.method.loss == "squares"
    return only and all(_is_linear(problem, p) for p in problem.parameters)


def linear_start(problem: FitProblem, places: Iterable[Array], turned: bool = True) -> Array | None:
    """The place whose linear numbers, solved for by least squares, leave the least.

    With the other numbers held, the tensions are T = T0 + sum x_k dT/dx_k, and the x_k within their
    bounds that make the sum of squared weighted deviations least follow from one linear system. So
    of p1, p4 and p5 of a tanh law, of EA, and of the coefficients of a polynomial.

    Args:
        problem: parameters and data; where it has records, there is no such system.
        places: values (p,) in SI of which those of the other numbers are taken.
        turned: take them of a tanh law with the sign of p3 turned as well, which is the law of the other
            sign of strain.

    Returns:
        The values (p,), None where no number is linear, or the start is beyond arithmetic: the search
        measures changes by it.
    """
    linear = np.array([_is_linear(problem, p) for p in problem.parameters])
    if problem.records or problem.smooth or not np.any(linear):
        return None
    data = np.concatenate([t.series.values * t.series.weight for t in problem.tables])
    start = np.array([p.start for p in problem.parameters])
    with np.errstate(over="ignore", invalid="ignore"):
        if not np.isfinite(np.sum((_tensions(problem, start) - data) ** 2)):
            return None
    signs = np.array([-1.0 if _is_phase(problem, p) else 1.0 for p in problem.parameters])
    best, least = None, np.inf
    # numbers that every table has of its own make many columns
    few = max(MOST_LAWS // (len(problem.tables) * (int(np.sum(linear)) + 1)), 1)
    for place in islice(places, few):
        for values in (place, place * signs) if turned and np.any(signs < 0.0) else (place,):
            found, left = _solved(problem, values, linear, data)
            if left < least:
                best, least = found, left
    return best


def _solved(
    problem: FitProblem, values: Array, linear: NDArray[np.bool_], data: Array
) -> tuple[Array, float]:
    """The values with the linear ones solved for, and the sum of squares that they leave."""
    low, high, start = problem.ranges
    indices = np.flatnonzero(linear)
    nothing = np.where(linear, 0.0, values)
    base = _tensions(problem, nothing)
    columns = np.stack(
        [_tensions(problem, np.where(np.arange(values.size) == k, 1.0, nothing)) - base
         for k in indices], axis=1,
    )  # fmt: skip
    if not (np.all(np.isfinite(columns)) and np.all(np.isfinite(base))):
        return values, np.inf
    with np.errstate(invalid="ignore"):
        low = np.where(np.isfinite(low), low + OFF_BOUND * (start - low), low)
        high = np.where(np.isfinite(high), high - OFF_BOUND * (high - start), high)
    size = np.max(np.abs(columns), axis=0)
    size = np.where(size > 0.0, size, 1.0)
    found = lsq_linear(
        columns / size, data - base, (low[indices] * size, high[indices] * size), method="bvls"
    )
    solved = nothing
    solved[indices] = np.clip(found.x / size, low[indices], high[indices])
    left = float(np.sum((base + columns @ solved[indices] - data) ** 2))
    return solved, left


def start_faults(problem: FitProblem, began: Sequence[Array] | None = None) -> list[str]:
    """Columns so far from what the start values give that a unit or a sign is in doubt.

    A table is compared by how it changes over the strains, which is what it tells of a law, and a
    record by the mean size of what it holds.

    Args:
        problem: parameters and data.
        began: what the start values give, one array a series; None leaves records out.
    """
    start, said = np.array([p.start for p in problem.parameters]), []
    for table in problem.tables:
        x, data = table.series.x, table.series.values
        if np.ptp(x) < SPREAD * np.max(np.abs(x)):
            continue
        with np.errstate(all="ignore"):
            law = _tension(problem, table, start)
            change, own = data - np.mean(data), law - np.mean(law)
            ratio = float(np.std(data) / np.std(law))
            cosine = float(np.mean(change * own) / (np.std(data) * np.std(law)))
        if cosine < AGAINST:
            said.append(
                f"{table.series.label}: the data fall where the law at the start rises: check the "
                "signs of the columns."
            )
        else:
            said += _unit_in_doubt(table.series.label, ratio, "law", "units of the columns")
    for series, law in zip(problem.series, began or (), strict=False):
        if series.x_unit != "s":
            continue
        with np.errstate(all="ignore"):
            ratio = float(np.sqrt(np.mean(series.values**2) / np.mean(law**2)))
        said += _unit_in_doubt(series.label, ratio, "scene", "unit of the column")
    for record in problem.records if began else ():
        own = record.study.scene.output.duration
        times = [series.x[-1] for series in record.series if series.x_unit == "s"]
        if times and max(times) * LARGE < own:
            said.append(
                f"{record.name}: the times end at {format_quantity(max(times), 's')}, where the scene "
                f"goes on to {format_quantity(own, 's')}: check their unit."
            )
    return said


def _unit_in_doubt(label: str, ratio: float, what: str, where: str) -> list[str]:
    if not 0.0 < ratio < np.inf or 1.0 / LARGE < ratio < LARGE:
        return []
    return [
        f"{label}: the data are about {float(f'{ratio:.1g}'):g} times what the {what} gives at the "
        f"start: check the {where}."
    ]


def _tensions(problem: FitProblem, values: Array) -> Array:
    """Tensions of all tables over their noise, or over their largest value."""
    return np.concatenate([_tension(problem, t, values) * t.series.weight for t in problem.tables])


def _tension(problem: FitProblem, table: Table, values: Array) -> Array:
    """Tensions (N) of a table's material at its strains, for parameters (p,) in SI."""
    scene = table.study.scene
    numbers = {
        p.key: float(x)
        for p, x in zip(problem.parameters, values, strict=True)
        if p.experiment in (None, table.name) and p.key.startswith(f"materials.{table.material}.")
    }
    known = scene.numbers()
    mine = {key: x for key, x in numbers.items() if key in known}
    material = scene.with_numbers(mine).materials[table.material]
    tension, branches = material.curve(table.series.x), relaxation_of(material)
    if table.series.time is None or branches is None:
        return tension
    return tension + np.asarray(_relaxing(branches, table.series.x, table.series.time))


_relaxing = jax.jit(relaxing_tension)


def _law(problem: FitProblem, p: Parameter):
    """The material that a number is of."""
    name = p.key.split(".")[1] if p.key.startswith("materials.") else ""
    users = (t.study.scene.materials.get(name) for t in problem.tables if t.material == name)
    return next((law for law in users if law is not None), None)


def _is_linear(problem: FitProblem, p: Parameter) -> bool:
    law = _law(problem, p)
    if law is None:
        return False
    _, _, key, *inner = p.key.split(".")
    return key in LINEAR.get(law.law, ()) or (key == "relaxation" and inner[-1] == "EA")


def _is_phase(problem: FitProblem, p: Parameter) -> bool:
    return isinstance(_law(problem, p), TanhMaterial) and p.key.endswith(".p3")
