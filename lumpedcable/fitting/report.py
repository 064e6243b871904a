"""What a person sees of a fit: a table of the values found, and plain words about their worth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from lumpedcable.fitting.bounds import way_of
from lumpedcable.fitting.linear import start_faults
from lumpedcable.fitting.profile import untold
from lumpedcable.fitting.remarks import read_roughly, remarks_of
from lumpedcable.fitting.run import Fitted
from lumpedcable.fitting.sensitivity import Sensitivity
from lumpedcable.fitting.uncertainty import VAGUE
from lumpedcable.scene import format_quantity
from lumpedcable.study.tables import console_of, rows_shown, table_of

__all__ = [
    "WIDE",
    "contents_of",
    "print_fit",
    "print_ropes",
    "print_sensitivity",
    "slopes_contents",
    "status_of",
]

WIDE = 140  # columns where no terminal says how many there are
MOST_ROWS = 30
MOST_NUMBERS = 5
ROUNDING = 1e-9  # of the way to a bound: a number is at it


def print_fit(fitted: Fitted, others: Mapping[str, Fitted] | None = None) -> None:
    """Print the values, what the data say about them, and the other laws if there are any."""
    console = console_of(WIDE)
    console.print(Text(fitted.problem.title, "bold"))
    console.print(_values(fitted))
    for remark in remarks_of(fitted):
        console.print(Text(remark))
    if fitted.draws is not None:
        console.print(_drawn(fitted))
    if others:
        console.print(_choices({"as given": fitted, **others}))
    console.print(
        f"{fitted.evaluations} evaluations with derivatives in {fitted.seconds:.3g} s, "
        f"{_failed(fitted)}"
    )


def _drawn(fitted: Fitted) -> Table:
    """The distribution that was sampled, number by number."""
    found = _sample(fitted) or {}
    share = f"{100 * fitted.problem.method.confidence:g} %"
    heads = ("sampled", "mean", "std", share, "R-hat", "worth draws")
    table = table_of(heads, wrap=range(len(heads)))
    for k, p in enumerate(fitted.problem.parameters):
        digits = _digits(found["mean"][k], found["std"][k], 4)
        low, high = (
            format_quantity(float(found[key][k]), p.unit, digits) for key in ("low", "high")
        )
        mean = format_quantity(float(found["mean"][k]), p.unit, max(digits, 6))
        std = format_quantity(float(found["std"][k]), p.unit, 2)
        table.add_row(
            Text(p.label), mean, std, f"{low} to {high}", f"{found['r_hat'][k]:.3f}",
            f"{found['effective_size'][k]:.0f}",
        )  # fmt: skip
    return table


def print_ropes(fits: Mapping[str, Fitted], title: str) -> None:
    """Print the numbers found of every rope, with their standard deviations."""
    console = console_of(WIDE)
    console.print(Text(title, "bold"))
    shown = next(iter(fits.values())).problem.parameters[:MOST_NUMBERS]
    heads = ("rope", *(p.label for p in shown), "left over", "remark")
    texts = (0, len(shown) + 2)
    table = table_of(heads, left=texts, wrap=texts)
    for name, f in list(fits.items())[:MOST_ROWS]:
        found = [
            f"{format_quantity(_at_its_bound(f, k), p.unit, 5)} ± {format_quantity(float(s), p.unit, 2)}"
            for k, (p, s) in enumerate(zip(shown, f.certainty.std, strict=False))
        ]
        said = [] if f.converged else [status_of(f)]
        said += ["at a bound"] if any(f.at_bound) else []
        said += ["numbers not told by the data"] if untold(f) else []
        said += ["a unit or a sign in doubt"] if start_faults(f.problem, f.began) else []
        said += [] if f.certainty.free else ["no more values than numbers"]
        said += ["steps too long for its times"] if read_roughly(f) else []
        table.add_row(Text(name), *found, f"{f.certainty.factor:.3g}", Text(", ".join(said)))
    console.print(table)
    for note in rows_shown(MOST_ROWS, len(fits), "ropes", "the files hold"):
        console.print(note)
    seconds = sum(f.seconds for f in fits.values())
    evaluations = sum(f.evaluations for f in fits.values())
    console.print(
        f"{len(fits)} ropes in {seconds:.3g} s, {evaluations} evaluations with derivatives"
    )


def _failed(fitted: Fitted) -> str:
    counts = [start.failed for start in fitted.starts]
    if min(counts) < 0:
        return "failed runs on the way not counted by this solver"
    return f"{sum(counts)} failed runs on the way"


def _digits(value: float, std: float, least: int) -> int:
    """Digits that show a number as far as its standard deviation tells it, and two more."""
    if not (0.0 < std < abs(value)):
        return least
    return max(least, min(2 + math.ceil(math.log10(abs(value) / std)), 12))


def _values(fitted: Fitted) -> Table:
    share = f"{100 * fitted.problem.method.confidence:g} %"
    heads = ("number", "start", "found", "std", f"{share} interval", "remark")
    table = table_of(heads, left=(0, 5), wrap=(0, 5))
    certainty = fitted.certainty
    vague = untold(fitted)
    profiles = {one.parameter for one in fitted.profiles}
    for k, p in enumerate(fitted.problem.parameters):

        def show(x: float, unit: str = p.unit, digits: int = 6) -> str:
            return format_quantity(float(x), unit, digits)

        remark = "at its bound" if fitted.at_bound[k] else "not told by the data"
        said = remark if fitted.at_bound[k] or k in vague else ""
        low, high = certainty.low[k], certainty.high[k]
        if k in profiles:
            said = f"{said}, interval by profile" if said else "interval by profile"
        value, std = _at_its_bound(fitted, k), certainty.std[k]
        digits = _digits(value, std, 4)
        interval = f"{show(low, digits=digits)} to {show(high, digits=digits)}"
        table.add_row(
            Text(p.label), show(p.start), show(value, digits=max(digits, 6)), show(std, digits=2),
            interval, said,
        )  # fmt: skip
    return table


def _at_its_bound(fitted: Fitted, k: int) -> float:
    """A number as it was found; the bound itself, of one that is nothing but rounding away from it."""
    p, value = fitted.problem.parameters[k], float(fitted.values[k])
    edge = p.low if abs(value - p.low) < abs(value - p.high) else p.high
    near = fitted.at_bound[k] and abs(value - edge) <= ROUNDING * way_of(p)
    return edge if near else value


def _choices(all_: Mapping[str, Fitted]) -> Table:
    """The laws compared, the best by BIC first."""
    heads = ("law", "numbers", "left over", "AIC", "BIC", "status")
    table = table_of(heads, left=(0, 5), wrap=range(len(heads)))
    aic, bic = (min(getattr(f.criteria, key) for f in all_.values()) for key in ("aic", "bic"))
    for name, f in sorted(all_.items(), key=lambda item: item[1].criteria.bic):
        numbers, status = f"{f.certainty.effective:.3g}", status_of(f)
        if f.failures:
            table.add_row(Text(name), numbers, "-", "-", "-", status)
            continue
        table.add_row(
            Text(name), numbers, f"{f.certainty.factor:.3g}",
            f"+{f.criteria.aic - aic:.1f}", f"+{f.criteria.bic - bic:.1f}", status,
        )  # fmt: skip
    return table


def _sample(fitted: Fitted) -> dict[str, Any] | None:
    """What was drawn, in few numbers."""
    draws = fitted.draws
    if draws is None:
        return None
    values = draws.values.reshape(-1, fitted.values.size)
    return {
        "chains": draws.values.shape[0], "draws": draws.values.shape[1],
        "mean": values.mean(axis=0), "std": values.std(axis=0, ddof=1), "low": draws.low,
        "high": draws.high, "r_hat": draws.r_hat, "effective_size": draws.size,
        "diverging": draws.diverging, "evaluations": draws.evaluations,
    }  # fmt: skip


def status_of(fitted: Fitted) -> str:
    """How a fit ended, in one word or two."""
    if fitted.failures:
        return "run failed"
    return "ok" if fitted.converged else "not converged"


def contents_of(fitted: Fitted) -> dict[str, Any]:
    """A fit as JSON values: parameters with their units, what is left, correlations, searches."""
    problem, certainty = fitted.problem, fitted.certainty
    counts = [start.failed for start in fitted.starts]
    names = [p.name for p in problem.parameters]
    parameters = [
        {
            "key": p.key, "experiment": p.experiment, "unit": p.unit, "start": p.start,
            "low": p.low, "high": p.high, "value": x, "std": certainty.std[k],
            "interval": [certainty.low[k], certainty.high[k]], "at_bound": fitted.at_bound[k],
        }
        for k, (p, x) in enumerate(zip(problem.parameters, fitted.values, strict=True))
    ]  # fmt: skip
    series = [
        {
            "experiment": s.name, "what": s.label, "unit": s.unit, "noise": s.noise,
            "x_unit": s.x_unit, "x": s.x, "time": s.time, "measured": s.values, "model": p,
        }
        for s, p in zip(problem.series, fitted.predicted, strict=True)
    ]  # fmt: skip
    return {
        "title": problem.title,
        "converged": fitted.converged,
        "status": status_of(fitted),
        "remarks": remarks_of(fitted),
        "method": problem.method.model_dump(),
        "confidence": problem.method.confidence,
        "parameters": parameters,
        "profiles": [
            {
                "name": names[one.parameter], "interval": [one.low, one.high], "value": one.x,
                "signed_root": one.root, "limit": one.reach, "better_fit_met": one.better,
                "runs_fail_beyond": [
                    float(one.x[end]) if failed else None
                    for failed, end in zip(one.failed, (0, -1), strict=True)
                ],
                "evaluations": one.evaluations,
            }
            for one in fitted.profiles
        ],
        "sample": _sample(fitted),
        "names": names,
        "correlation": {"rows": [list(row) for row in certainty.correlation]},
        "covariance": {"rows": [list(row) for row in certainty.covariance]},
        "combinations": [
            {"parts_of_relative_change": c.parts, "std": c.spread, "told": bool(c.spread < VAGUE)}
            for c in certainty.combinations
        ],
        "loss": fitted.loss,
        "values": problem.points,
        "left_over": certainty.factor,
        "noise_known": problem.known_noise,
        "aic": fitted.criteria.aic,
        "bic": fitted.criteria.bic,
        "evaluations": fitted.evaluations,
        "plain_evaluations": fitted.sampled,
        "seconds": fitted.seconds,
        "failed": {name: status.name.lower() for name, status in fitted.failures},
        "failed_runs": None if min(counts) < 0 else sum(counts),
        "searches": [
            {
                "start": s.start, "values": s.values, "loss": s.loss, "evaluations": s.steps,
                "failed_runs": s.failed, "converged": s.converged,
            }
            for s in fitted.starts
        ],
        "series": series,
    }  # fmt: skip


def print_sensitivity(heading: str, found: Sensitivity) -> None:
    """Print what a scalar depends on, the largest share first."""
    console = console_of(WIDE)
    unit = found.scalar.unit
    console.print(Text(heading, "bold"))
    console.print(f"{found.scalar}: {format_quantity(found.value, unit)}")
    table = table_of(("number", "value", "% per %", "per SI unit of it"), wrap=(0,))
    for k, key in enumerate(found.keys[:MOST_ROWS]):
        per = f"{unit}/({found.units[k]})" if found.units[k] else unit
        known = np.isfinite(found.slopes[k])
        table.add_row(
            Text(key), format_quantity(float(found.values[k]), found.units[k]),
            f"{found.shares[k]:+.4g}" if known and found.values[k] else "-",
            f"{found.slopes[k]:+.4g} {per}" if known else "no derivative here",
        )  # fmt: skip
    console.print(table)
    for note in rows_shown(MOST_ROWS, len(found.keys), "numbers"):
        console.print(note)
    if found.check is not None and found.check.good:
        console.print(Text(str(found.check)))
    for remark in found.remarks:
        console.print(Text(remark))


def slopes_contents(heading: str, found: Sensitivity) -> dict[str, Any]:
    """A sensitivity as JSON values."""
    numbers = [
        {
            "key": key, "unit": found.units[k], "value": found.values[k],
            "derivative": found.slopes[k], "percent_per_percent": found.shares[k],
        }
        for k, key in enumerate(found.keys)
    ]  # fmt: skip
    return {
        "title": heading,
        "result": str(found.scalar),
        "value": found.value,
        "unit": found.scalar.unit,
        "status": found.status.name.lower(),
        "remarks": found.remarks,
        "check": None if found.check is None else found.check._asdict(),
        "numbers": numbers,
    }
