"""float32 beside float64: the errors of the default method, and what it takes, on two meshes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.cases import MAIN, seen
from benchmarks.measures import ERROR_HEADS
from benchmarks.methods import DEFAULT, Method, point
from benchmarks.reference import load
from benchmarks.work_precision import cells

DTYPES = ("float64", "float32")
MESHES = (100, 1600)
KINDS = ("5 ms", "at once")


def run(quick: bool, meshes: tuple[int, ...] = MESHES) -> dict[str, Any]:
    """Every main case in both precisions; quick: three of them on the first mesh."""
    references, points = load(), []
    cases = MAIN[::3] if quick else MAIN
    for n in meshes[:1] if quick else meshes:
        for dtype in DTYPES:
            method, compiled = Method(DEFAULT, (f'solver.dtype="{dtype}"',)), None
            for case in cases:
                found = point(method, case, n, references[case.name], compiled)
                compiled = found.compile
                points.append(found.record())
    return {"points": points}


def table(data: dict[str, Any]) -> str:
    """A row for each break, mesh and precision, all pretensions in each cell."""
    points: Sequence[dict[str, Any]] = data["points"]
    _, pulls = seen([p for p in points if p["case"].endswith(KINDS[0])])
    rows = [
        f"| default, {pulls} kN | N | precision | {ERROR_HEADS} | time, ms | steps |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for kind in KINDS:
        here = [p for p in points if p["case"].endswith(kind)]
        cases = seen(here)[0]
        for n in sorted({p["segments"] for p in here}):
            for dtype in DTYPES:
                own = {p["case"]: p for p in here if (p["segments"], p["dtype"]) == (n, dtype)}
                told = cells([own.get(case) for case in cases])
                rows.append(f"| break {kind} | {n} | {dtype} | {told} |")
    return "\n".join(rows)
