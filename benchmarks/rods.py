"""What a step of lines that keep their length costs, against the number of rods: O(N)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from benchmarks.cost import advance_time
from benchmarks.engine import Runner
from lumpedcable.scene import load_study

SCENE = Path(__file__).with_name("rods.toml")
RODS = (10, 30, 100, 300, 1000, 3000, 10_000)
WORK = 300_000  # rods times steps in a measurement, at least
OUTPUTS = 2


def run(quick: bool = False) -> dict[str, Any]:
    """Every number of rods."""
    return {"rows": [_step(n) for n in (RODS[2:5:2] if quick else RODS)]}


def _step(rods: int) -> dict[str, Any]:
    runner = Runner(load_study(SCENE, (f"lines.line.segments={rods}",)).runs[0])
    assert bool(runner.ready.converged[0])
    steps = max(10, WORK // (rods * OUTPUTS))
    numbers = runner.numbers(steps * runner.every / runner.steps, steps)
    seconds = advance_time(runner.ready.packed, runner, numbers, OUTPUTS)
    return {"rods": rods, "step": seconds / (OUTPUTS * steps), "steps": OUTPUTS * steps}


def table(data: dict[str, Any]) -> str:
    """The table for the page."""
    rows = ["| rods | a step, ms | of it for a rod, µs |", "|---|---|---|"]
    for row in data["rows"]:
        each = 1e6 * row["step"] / row["rods"]
        rows.append(f"| {row['rods']} | {1e3 * row['step']:.3g} | {each:.2f} |")
    return "\n".join(rows)
