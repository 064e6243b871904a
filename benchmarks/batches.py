"""Thousands of runs on all cores, batch after batch: node-steps a second, beside the same steps in C."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RUNS = (256, 1024, 4096, 16384, 65536)
DTYPES = ("float64", "float32")
SEGMENTS = 100
EVERY = 5e-3  # s between samples
ROUNDS, MANY = 5, 10_000  # measured so often, and once of more runs than that
PREPARED = 1024  # runs brought to rest, which go round


def run(quick: bool) -> dict[str, Any]:
    """Either precision, each in a process of its own that has all cores as devices."""
    rows = []
    for dtype in DTYPES:
        command = [sys.executable, "-m", "benchmarks.batches", dtype, "quick" if quick else "all"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        rows += json.loads(done.stdout)
    return {"rows": rows, "cores": os.cpu_count() or 1}


def table(data: dict[str, Any]) -> str:
    """Million node-steps a second by precision and number of runs, and the share of C's."""
    runs = list(dict.fromkeys(row["runs"] for row in data["rows"]))
    head = [f"million node-steps a second, {data['cores']} cores", *(f"{n} runs" for n in runs)]
    lines = [_line(head), "|---" * len(head) + "|"]
    for dtype in DTYPES:
        own = [row for row in data["rows"] if row["dtype"] == dtype]
        lines.append(_line([dtype, *(f"{row['rate'] / 1e6:.0f}" for row in own)]))
        for flags, told in (("exact", "`-O3`"), ("fast", "`-O3 -ffast-math`")):
            if own and own[0][flags] is not None:
                shares = (f"{row['rate'] / row[flags]:.2f}" for row in own)
                lines.append(_line([f"its share of C's, {told}", *shares]))
    return "\n".join(lines)


def _line(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"


def rows(dtype: str, counts: tuple[int, ...]) -> list[dict[str, Any]]:
    """Node-steps a second of the engine and of C for every number of runs."""
    import jax
    import numpy as np

    from benchmarks.native.line import FLAGS, compiler, go, parameters
    from benchmarks.rested import rested
    from lumpedcable.study.batches import batch_sizes
    from lumpedcable.study.compiled import advance_batch, begin_batch
    from lumpedcable.study.plan import plan_of
    from lumpedcable.study.starts import rows_of

    laid, ready, steps, numbers = rested(PREPARED, SEGMENTS, EVERY, dtype)
    size = batch_sizes(PREPARED)[-1]
    plan = plan_of(laid.scene, laid.structures[0].layout, size)
    models = [rows_of(ready, np.arange(k, k + size)).packed for k in range(0, PREPARED, size)]

    def through(runs: int) -> float:
        """Seconds that so many runs take from their start to the numbers of their last sample."""
        begun = time.perf_counter()
        for k in range(runs // size):
            state, _ = begin_batch(models[k % len(models)], plan, numbers)
            for done in range(0, laid.count, plan.outputs):
                now = np.asarray(min(plan.outputs, laid.count - done))
                state, samples = advance_batch(
                    models[k % len(models)], plan, numbers, state, np.asarray(done), now
                )
                jax.tree.map(np.asarray, samples)
        return time.perf_counter() - begun

    (hold,) = laid.study.runs.columns(np.arange(PREPARED)).values()
    strain = np.asarray(ready.model.lines["rope"].reference_strain)[:, 0]
    line = parameters(rows_of(ready, np.arange(1)).model.lines["rope"], 5e-3)
    dt, all_steps, cores = EVERY / steps, steps * laid.count, jax.device_count()

    def in_c(flags: str) -> float:
        made = go(line, strain, hold, SEGMENTS, all_steps, dt, dtype, flags, cores)
        return PREPARED * (SEGMENTS + 1) * all_steps / made.seconds

    through(size)
    found = []
    for runs in counts:
        rates: dict[str, list[float]] = {"rate": [], **{flags: [] for flags in FLAGS}}
        for _ in range(1 if runs > MANY else ROUNDS):
            rates["rate"].append(runs * (SEGMENTS + 1) * all_steps / through(runs))
            for flags in FLAGS if compiler() is not None else ():
                rates[flags].append(in_c(flags))
        middle = {key: statistics.median(v) if v else None for key, v in rates.items()}
        found.append({"runs": runs, "dtype": dtype, **middle})
    return found


if __name__ == "__main__":
    from lumpedcable.commands.console import share_cores

    share_cores(None)  # before jax looks at the machine
    print(json.dumps(rows(sys.argv[1], RUNS[:1] if sys.argv[2] == "quick" else RUNS)))
