"""Whole studies from the command line: runs a second, node-steps a second, memory."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.engine import SCENE

Tell = Callable[[str], None]

RUNS = (256, 4096, 65536)
DTYPES = ("float64", "float32")
SEGMENTS, DURATION = 100, 0.2
SWEEP = "pretension={{from='45 kN', to='450 kN', count={}}}"
# the memory of the process and of all that it started, in kB, as the kernel counts it
WATCH = """import resource, subprocess, sys
code = subprocess.call(sys.argv[1:])
print("peak", resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)
"""


def run(quick: bool, tell: Tell) -> dict[str, Any]:
    """Every size in either precision, each a process of its own."""
    sizes = RUNS[:1] if quick else RUNS
    return {
        "rows": [one(runs, dtype, tell) for dtype in DTYPES for runs in sizes],
        "cores": os.cpu_count() or 1,
    }


def one(runs: int, dtype: str, tell: Tell) -> dict[str, Any]:
    """A study of so many pretensions: seconds in all, steps taken, the largest memory of its process."""
    import h5py

    tell(f"a study of {runs} runs, {dtype}")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "study"
        command = [
            sys.executable, "-c", WATCH, sys.executable, "-m", "lumpedcable", "study", str(SCENE),
            "-o", str(target), "--set", SWEEP.format(runs), "--set", 'output.keep="summaries"',
            "--set", f'solver.dtype="{dtype}"', "--set", f"segments={SEGMENTS}",
        ]  # fmt: skip
        # a cache of programs of its own: what compiling costs belongs to it
        own = {**os.environ, "LUMPEDCABLE_CACHE": str(Path(folder) / "cache")}
        begin = time.perf_counter()
        done = subprocess.run(command, env=own, capture_output=True, text=True, check=True)
        seconds = time.perf_counter() - begin
        with h5py.File(target / "study.h5") as file:
            steps = DURATION / file["summary/solver_step"][:]
        bad = failed(target)
        ended = sorted(path.stat().st_mtime for path in (target / "shards").glob("*.h5"))
    peak = next(int(x.split()[1]) for x in done.stdout.splitlines() if x.startswith("peak"))
    return {
        "runs": runs, "dtype": dtype, "seconds": seconds, "peak": 1024 * peak, "failed": bad,
        "node_steps": float(steps.sum()) * (SEGMENTS + 1), "under_way": _under_way(ended),
    }  # fmt: skip


def failed(target: Path) -> int:
    """How many runs of a study did not end well."""
    import h5py

    with h5py.File(target / "study.h5") as file:
        return int((file["status"][:] != 0).sum())


def _under_way(ended: list[float]) -> float:
    """Seconds that a study takes for all its work at the pace of its later shards; NaN of few.

    Args:
        ended: when each shard was finished (s), rising. The first ones waited for the compiler.
    """
    left_out = len(ended) // 4
    if left_out < 2:
        return math.nan
    return (ended[-1] - ended[left_out]) * len(ended) / (len(ended) - 1 - left_out)


def table(data: dict[str, Any]) -> str:
    """Time, rates and memory of each study."""
    rows = [
        "| runs | precision | time, s | runs a second | million node-steps a second "
        "| the same once under way | peak memory, MB | not ok |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in data["rows"]:
        rate, speed = row["runs"] / row["seconds"], row["node_steps"] / row["seconds"] / 1e6
        later = row["node_steps"] / row["under_way"] / 1e6
        later = "" if math.isnan(later) else f"{later:.0f}"
        rows.append(
            f"| {row['runs']} | {row['dtype']} | {row['seconds']:.1f} | {rate:.0f} | {speed:.0f} "
            f"| {later} | {row['peak'] / 1e6:.0f} | {row['failed']} |"
        )
    return "\n".join(rows)
