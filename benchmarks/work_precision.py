"""Error against time: every method on every mesh, at four pretensions and two break times."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from benchmarks.cases import MAIN, Case, seen
from benchmarks.measures import ERROR_HEADS, MISSING, error_cells, short
from benchmarks.methods import METHODS, Method, point
from benchmarks.reference import Reference, load

Tell = Callable[[str], None]

QUICK_METHODS = 4
QUICK_MESHES = (50, 100)


def run(quick: bool, tell: Tell) -> dict[str, Any]:
    """All points, and where a method was cut off."""
    references = load()
    cases = tuple(c for c in MAIN if not quick or c.name in ("45 kN, 5 ms", "450 kN, 5 ms"))
    points, cut = [], {}
    for method in METHODS[:QUICK_METHODS] if quick else METHODS:
        meshes = tuple(n for n in method.meshes if not quick or n in QUICK_MESHES)
        found, last = measure(method, meshes, cases, references, method.budget, tell)
        points += found
        if last is not None:
            cut[method.name] = last
    budgets = {method.name: method.budget for method in METHODS}
    return {"points": points, "budgets": budgets, "cut": cut}


def measure(
    method: Method, meshes: Sequence[int], cases: Sequence[Case],
    references: dict[str, Reference], budget: float, tell: Tell,
) -> tuple[list[dict[str, Any]], int | None]:  # fmt: skip
    """The points of one method, and the mesh at which its time ran out (None if it did not)."""
    points, spent = [], 0.0
    for n in meshes:
        compiled: float | None = None
        for case in cases:
            tell(f"{method.name}, {n} segments, {case.name}")
            begin = time.perf_counter()
            found = point(method, case, n, references[case.name], compiled)
            spent += time.perf_counter() - begin - (found.compile if compiled is None else 0.0)
            compiled = found.compile
            points.append(found.record())
            if spent > budget:
                return points, n
    return points, None


def table(points: Sequence[dict[str, Any]], kind: str, segments: int = 100) -> str:
    """Errors of every method on one mesh, and what they cost, for a break "5 ms" or "at once"."""
    points = [p for p in points if p["case"].endswith(kind) and p["segments"] == segments]
    cases, pulls = seen(points)
    rows = [
        f"| N = {segments}, break {kind}, {pulls} kN | {ERROR_HEADS} | time, ms | steps |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(p["method"] for p in points):
        own = {p["case"]: p for p in points if p["method"] == name}
        rows.append(f"| {name} | {cells([own.get(case) for case in cases])} |")
    return "\n".join(rows)


def cells(points: Sequence[dict[str, Any] | None]) -> str:
    """Errors, times and steps of one row, by " / "; "-" where nothing was measured."""
    found = error_cells([None if p is None else p["errors"] for p in points])
    found.append(" / ".join(MISSING if p is None else short(1e3 * p["warm"]) for p in points))
    found.append(" / ".join(MISSING if p is None else f"{p['steps']}" for p in points))
    return " | ".join(found)


def compile_table(points: Sequence[dict[str, Any]]) -> str:
    """Seconds that the first call of every program took to compile, by method and mesh."""
    meshes = sorted({p["segments"] for p in points})
    rows = [
        "| compile time, s | " + " | ".join(f"N = {n}" for n in meshes) + " |",
        "|---" * (len(meshes) + 1) + "|",
    ]
    for name in dict.fromkeys(p["method"] for p in points):
        own = {p["segments"]: p["compile"] for p in points if p["method"] == name}
        cells = (f"{own[n]:.1f}" if n in own else "" for n in meshes)
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def cut_off(data: dict[str, Any]) -> str:
    """Which methods ran out of time, and where; which runs the engine warns of."""
    budgets = data["budgets"]
    told = [f"{name} after {budgets[name]:g} s at N = {n}" for name, n in data["cut"].items()]
    few, many = min(budgets.values()), max(budgets.values())
    warned: dict[str, list[str]] = {}
    for p in data["points"]:
        if p["status"] != "OK":
            what = f"{p['method']}, {p['case']}, {p['status'].lower().replace('_', ' ')}"
            warned.setdefault(what, []).append(str(p["segments"]))
    faults = "; ".join(f"{what} at N = {', '.join(meshes)}" for what, meshes in warned.items())
    return (
        f"Each method had {few:g} to {many:g} s for all its meshes and cases, compiling left out. "
        f"Cut off: {'; '.join(told) if told else 'none'}.\n\n"
        f"The engine warned of these runs, whose errors count as far as they have a history: "
        f"{faults or 'none'}."
    )
