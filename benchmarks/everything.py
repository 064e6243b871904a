"""Every method, mesh and pretension, and every setting of other programs: the page in full."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchmarks.cases import seen
from benchmarks.measures import ERROR_HEADS
from benchmarks.peers.compare import LINEAR
from benchmarks.work_precision import cells

Points = Sequence[dict[str, Any]]
OTHERS = ("MoorDyn", "SciPy")


def table(points: Points, kind: str) -> str:
    """All points of a break "5 ms" or "at once": a row for each method and mesh."""
    return _rows([p for p in points if p["case"].endswith(kind)], kind, ("method",))


def others(points: Points, kind: str) -> str:
    """The same of the other programs on the parted line: a row for each setting and mesh."""
    own = [
        p for p in points
        if p["program"] in OTHERS and p["case"] != LINEAR and p["case"].endswith(kind)
    ]  # fmt: skip
    return _rows(own, kind, ("program", "setting"))


def _rows(points: Points, kind: str, keys: tuple[str, ...]) -> str:
    cases, pulls = seen(points)
    rows = [
        f"| break {kind}, {pulls} kN | N | {ERROR_HEADS} | time, ms | steps or calls |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for who in dict.fromkeys(tuple(p[key] for key in keys) for p in points):
        own = [p for p in points if tuple(p[key] for key in keys) == who]
        for n in sorted({p["segments"] for p in own}):
            mine = {p["case"]: p for p in own if p["segments"] == n}
            rows.append(f"| {', '.join(who)} | {n} | {cells([mine.get(c) for c in cases])} |")
    return "\n".join(rows)
