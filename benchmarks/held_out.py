"""Cases that nothing was tuned on: the default beside plain leapfrog at N = 100."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.cases import HELD_OUT
from benchmarks.measures import ERROR_HEADS, error_cells
from benchmarks.methods import DEFAULT, METHODS
from benchmarks.reference import load
from benchmarks.work_precision import measure

PLAIN = "leapfrog, plain"
SEGMENTS = 100


def run(quick: bool, tell: Callable[[str], None]) -> dict[str, Any]:
    """Both methods on all cases (three of them if quick)."""
    cases, references, points = HELD_OUT[::5] if quick else HELD_OUT, load(), []
    for method in METHODS:
        if method.name in (DEFAULT, PLAIN):
            points += measure(method, (SEGMENTS,), cases, references, float("inf"), tell)[0]
    return {"points": points}


def table(data: dict[str, Any]) -> str:
    """Errors in per cent, default / plain."""
    rows = [
        f"| N = 100, default / plain | {ERROR_HEADS} |",
        "|---|---|---|---|---|---|",
    ]
    for case in dict.fromkeys(p["case"] for p in data["points"]):
        both = [
            next(p for p in data["points"] if (p["case"], p["method"]) == (case, name))["errors"]
            for name in (DEFAULT, PLAIN)
        ]
        rows.append(f"| {case} | {' | '.join(error_cells(both))} |")
    return "\n".join(rows)
