"""What was asked of speed and memory, and whether it is reached: rows under those of `targets`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from benchmarks import against, jobs
from benchmarks.gradients import SPEED
from benchmarks.headline import QUANTITIES

FASTER = {100: 15.0, 200: 20.0}  # times as fast as MoorDyn, by segments
OF_C = 0.5  # of the speed of C without -ffast-math, one line
BATCH, BATCH_OF_C = 4096, 0.45  # runs; of the speed of C without -ffast-math
RATES = {"float64": 150.0, "float32": 300.0}  # million node-steps a second
GRADIENT = 4.0  # times the value
GIB = 2.0**30
MAIN_JOB, STUDY = 1.0, 4.0  # GiB
STUDY_RUNS = 65536
GPU_RUNS, GPU_DTYPE, GPU_TIME = 10**5, "float32", 20.0  # s

Row = tuple[str, str, str, bool | None]  # what, asked, found, whether it is met


def rows(parts: dict[str, Any]) -> list[str]:
    """A row for each target whose part was measured."""
    found = [
        *_of_c(parts.get("native", {}).get("rows", ())),
        *_moordyn(parts.get("peers", {}).get("points", ())),
        *_batches(parts.get("batches", {}).get("data", {}).get("rows", ())),
        *_gradients(parts.get("gradients", {}).get("data", ())),
        *_memory(parts),
    ]
    if found:
        found.append(_gpu(parts.get("gpu", {}).get("data")))
    words = {True: "met", False: "not met", None: "open"}
    return [f"| {what} | {asked} | {told} | {words[met]} |" for what, asked, told, met in found]


def _of_c(measured: Any) -> Iterator[Row]:
    for row in measured:
        if (row["lanes"], row["dtype"]) == (1, "float64"):
            share = row["exact"] / row["engine"]
            fast = row["fast"] / row["engine"]
            yield (
                f"a step of one line, N = {row['segments']}, float64", f"{OF_C:g} of C's speed",
                f"{share:.3g} (with -ffast-math {fast:.3g})", share >= OF_C,
            )  # fmt: skip


def _moordyn(points: Any) -> Iterator[Row]:
    for n, limit in FASTER.items():
        for quantity, words in QUANTITIES.items():
            pairs = against.pairs(points, n, quantity)
            if not pairs:
                continue
            least = min(p.times for p in pairs.values())
            worse = [case.split(" ")[0] for case, p in pairs.items() if p.mine > p.theirs]
            told = f"{least:.3g} times at least"
            told += f"; a larger error at {', '.join(worse)} kN" if worse else "; no worse"
            yield (
                f"{words}, N = {n}, at once",
                f"{limit:g} times faster than MoorDyn's best, no worse", told,
                least >= limit and not worse,
            )  # fmt: skip


def _batches(measured: Any) -> Iterator[Row]:
    for dtype, limit in RATES.items():
        own = [row for row in measured if row["dtype"] == dtype]
        for row in own:
            if row["runs"] != BATCH:
                continue
            rate = row["rate"] / 1e6
            what = f"{BATCH} runs, N = 100, {dtype}"
            yield what, f"{limit:g} million node-steps a second", f"{rate:.0f}", rate >= limit
            if row["exact"] is not None:
                share = row["rate"] / row["exact"]
                told = f"{share:.3g} (with -ffast-math {row['rate'] / row['fast']:.2g})"
                yield what, f"{BATCH_OF_C:g} of C's speed", told, share >= BATCH_OF_C
        if len(own) > 1:
            rates = [row["rate"] / 1e6 for row in own]
            what = f"{own[0]['runs']} to {own[-1]['runs']} runs, N = 100, {dtype}"
            told = f"{min(rates):.0f} to {max(rates):.0f}"
            yield what, f"flat, {limit:g} million at all sizes", told, min(rates) >= limit


def _gradients(measured: Any) -> Iterator[Row]:
    for row in measured:
        if row["steps"] <= 1000 and (row["of"] == SPEED or row["of"].startswith("the same")):
            n = 100 if row["of"] == SPEED else row["of"].rpartition(" ")[2]
            ratio = row["backward"]["warm"] / row["value"]["warm"]
            yield (
                f"value and 6 derivatives of a whole run, N = {n}", f"{GRADIENT:g} times the value",
                f"{ratio:.2g} times", ratio <= GRADIENT,
            )  # fmt: skip


def _memory(parts: dict[str, Any]) -> Iterator[Row]:
    for row in parts.get("jobs", {}).get("data", {}).get("rows", ()):
        if row["job"] == jobs.MAIN_JOB:
            yield _within("memory of the main job, eight runs", row["peak"], MAIN_JOB)
    for row in parts.get("study", {}).get("rows", ()):
        if row["runs"] == STUDY_RUNS:
            what = f"memory of {STUDY_RUNS} runs, summaries, {row['dtype']}"
            yield _within(what, row["peak"], STUDY)


def _within(what: str, peak: float, limit: float) -> Row:
    return what, f"{limit:g} GiB", f"{peak / GIB:.2g} GiB", peak < limit * GIB


def _gpu(measured: Any) -> Row:
    what, asked = f"10^5 runs on one GPU, N = 100, 200 ms, {GPU_DTYPE}", f"{GPU_TIME:g} s"
    if measured is None:
        return what, asked, "no GPU here", None
    (row,) = (row for row in measured["studies"] if row["dtype"] == GPU_DTYPE)
    told = (
        f"{row['first']:.1f} s from the command line, programs compiled; then {row['again']:.1f} s"
    )
    right = row["runs"] >= GPU_RUNS and row["failed"] == 0
    return what, asked, told, right and max(row["first"], row["again"]) < GPU_TIME
