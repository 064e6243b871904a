"""Whole jobs from the command line: the main job, a buoy, a study with fields, 10,000 breaks and maps.

Each in a process of its own with a cache of programs of its own, and then once more with what the
cache has by then: seconds, largest memory, what is written, and how fast.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.engine import SCENE
from benchmarks.studies import WATCH

CONFIGS = Path(__file__).parents[1] / "configs"
MAP = CONFIGS / "studies" / "snapback-map.toml"
FEW = (  # what a quick look leaves of the 10,000: nine
    "events.break.place=['5.4 m', '27 m', '54 m']", "events.break.time=['5 ms']",
    "lines.rope.end.fixed.0=['65.97 m', '72.68 m', '77.54 m']", "lines.rope.drag.tangential=[0.01]",
)  # fmt: skip
FIELD_RUNS = 1024
BUOY_SCENE = CONFIGS / "surface" / "buoy.toml"
BRIEF = ("output.duration=11 s", "output.every=0.5 s")
MAIN_JOB, BUOY, FIELDS, TEN_THOUSAND, MAPS = (
    "main job",
    "buoy",
    "fields",
    "10,000 breaks",
    "their maps",
)


class Job(NamedTuple):
    """A command of lumpedcable without its output: its name, in words, and how many runs it is."""

    name: str
    words: str
    runs: int
    command: tuple[str, ...]


def jobs(quick: bool) -> tuple[Job, ...]:
    """All but the maps, which need what one of them leaves."""
    count = 16 if quick else FIELD_RUNS
    swept = f"pretension={{from='45 kN', to='450 kN', count={count}}}"
    few = FEW if quick else ()
    return (
        Job(MAIN_JOB, "`run configs/snapback.toml`, N = 200, fields each 1 ms", 8,
            ("run", str(CONFIGS / "snapback.toml"), *_set("lines.rope.segments=20" if quick else ""))),
        Job(BUOY, "`run configs/surface/buoy.toml`: a body on three chains in waves", 1,
            ("run", str(BUOY_SCENE), *_set(*BRIEF if quick else ()))),
        Job(FIELDS, "`study` of the parted line, N = 100, fields each 1 ms", count,
            ("study", str(SCENE), *_set(swept, 'output.keep="fields"', "segments=100"))),
        Job(TEN_THOUSAND, "`study configs/studies/snapback-map.toml`", 9 if quick else 10_000,
            ("study", str(MAP), *_set(*few))),
    )  # fmt: skip


def _set(*changes: str) -> tuple[str, ...]:
    return tuple(word for change in changes if change for word in ("--set", change))


def run(quick: bool) -> dict[str, Any]:
    """Every job twice, and the maps of the last."""
    rows = []
    with tempfile.TemporaryDirectory() as at:
        folder = Path(at)
        for job in jobs(quick):
            target = folder / (f"{job.name}.h5" if job.command[0] == "run" else job.name)
            both = [once(job.command, target, folder / f"cache of {job.name}") for _ in range(2)]
            rows.append({"job": job.name, "words": job.words, "runs": job.runs, **_joined(both)})
        drawn = once(("plot", str(target)), folder / "maps", folder / "cache of maps")
        words = "`plot` of its folder: maps over every pair of numbers"
        rows.append({"job": MAPS, "words": words, "runs": job.runs, **_joined([drawn])})
    return {"rows": rows, "cores": os.cpu_count() or 1}


def once(command: tuple[str, ...], target: Path, cache: Path) -> dict[str, float]:
    """Seconds, largest memory and output (bytes) of a command; what it wrote before is removed."""
    own = {**os.environ, "LUMPEDCABLE_CACHE": str(cache)}
    if target.is_dir():
        shutil.rmtree(target)
    target.unlink(missing_ok=True)
    words = [sys.executable, "-c", WATCH, sys.executable, "-m", "lumpedcable", *command]
    begin = time.perf_counter()
    done = subprocess.run(
        [*words, "-o", str(target)], env=own, capture_output=True, text=True, check=False
    )
    seconds = time.perf_counter() - begin
    if done.returncode not in (0, 1) or not target.exists():  # 1: some runs ended with a reason
        raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
    peak = next(int(x.split()[1]) for x in done.stdout.splitlines() if x.startswith("peak"))
    return {"seconds": seconds, "peak": 1024.0 * peak, "written": float(size(target))}


def _joined(both: list[dict[str, float]]) -> dict[str, float | None]:
    return {
        "first": both[0]["seconds"],
        "again": both[1]["seconds"] if len(both) > 1 else None,
        "peak": max(one["peak"] for one in both),
        "written": both[-1]["written"],
    }


def size(target: Path) -> int:
    """Bytes of a file, or of all files in a folder."""
    files = [target] if target.is_file() else [x for x in target.rglob("*") if x.is_file()]
    return sum(x.stat().st_size for x in files)


def table(data: dict[str, Any]) -> str:
    """A row for each job."""
    rows = [
        f"| {data['cores']} cores | runs | time, s: first | again, programs in the cache "
        "| peak memory, MB | written, MB | MB a second, again |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in data["rows"]:
        again, written = row["again"], row["written"] / 1e6
        told = ("", "") if again is None else (f"{again:.1f}", f"{written / again:.3g}")
        rows.append(
            f"| {row['words']} | {row['runs']} | {row['first']:.1f} | {told[0]} "
            f"| {row['peak'] / 1e6:.0f} | {written:.3g} | {told[1]} |"
        )
    return "\n".join(rows)
