"""The engine's steps beside the same steps in C: one line, and many at once."""

from __future__ import annotations

import dataclasses
import os
import statistics
import time
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.engine import Runner, scene_of
from benchmarks.native.line import FLAGS, compiler, go, parameters
from lumpedcable.study.batches import CPU
from lumpedcable.study.compiled import advance_batch, begin_batch

Tell = Callable[[str], None]

MESHES = (100, 200)
DTYPES = ("float64", "float32")
ROUNDS = 15  # each of them times all programs once, so that noise hits them alike
PRETENSION = 450e3  # N
STEPS = 600


def run(quick: bool, tell: Tell) -> dict[str, Any]:
    """Microseconds of a step of a line, for lines alone and in batches of as many as go together."""
    if compiler() is None:
        return {"rows": []}
    rounds = 3 if quick else ROUNDS
    rows = [
        case(segments, lanes, dtype, rounds, tell)
        for dtype in DTYPES
        for segments in MESHES
        for lanes in (1, CPU.lanes)
    ]
    return {"rows": rows, "cores": os.cpu_count() or 1}


def case(segments: int, lanes: int, dtype: str, rounds: int, tell: Tell) -> dict[str, Any]:
    """One size: the engine, and C with either set of flags."""
    tell(f"C and the engine, {lanes} lines of {segments} segments, {dtype}")
    runner = Runner(
        scene_of(
            f"segments={segments}",
            f'solver.dtype="{dtype}"',
            f"rope.end.held.pretension={PRETENSION} N",
        )
    )
    models = jax.tree.map(lambda x: jnp.repeat(x, lanes, axis=0), runner.ready.packed)
    # the steps themselves: two outputs, so that writing them does not count
    steps = max(STEPS // lanes, 50)
    plan = dataclasses.replace(runner.plan, outputs=2)
    numbers = runner.numbers(steps * runner.every / runner.steps, steps)
    line = runner.ready.model.lines[runner.line]
    own = parameters(line, 5e-3)
    strain = np.full(lanes, float(line.reference_strain[0, 0]))
    hold = np.full(lanes, PRETENSION)

    def engine() -> float:
        state, _ = begin_batch(models, plan, numbers)
        jax.block_until_ready(state)
        begin = time.perf_counter()
        done = advance_batch(models, plan, numbers, state, jnp.asarray(0), jnp.asarray(2))
        jax.block_until_ready(done)
        return time.perf_counter() - begin

    dt = runner.every / runner.steps
    work: dict[str, Callable[[], float]] = {"engine": engine} | {
        flags: lambda flags=flags: (
            go(own, strain, hold, segments, 2 * steps, dt, dtype, flags).seconds
        )
        for flags in FLAGS
    }
    times: dict[str, list[float]] = {name: [] for name in work}
    for name in work:
        work[name]()
    for _ in range(rounds):
        for name, once in work.items():
            times[name].append(once() / (2 * steps * lanes))
    found = {name: statistics.median(values) for name, values in times.items()}
    return {"segments": segments, "lanes": lanes, "dtype": dtype, **found}


def table(data: dict[str, Any]) -> str:
    """Steps of a line in microseconds, and the engine's speed as a share of C's."""
    lines = [
        "| | a step, us | C, `-O3 -march=native` | C, the same and `-ffast-math` | speed over C's "
        "| million node-steps a second on one core |",
        "|---|---|---|---|---|---|",
    ]
    for row in data["rows"]:
        who = "one line" if row["lanes"] == 1 else f"{row['lanes']} lines at once"
        shares = " / ".join(f"{row[flags] / row['engine']:.2f}" for flags in FLAGS)
        rate = (row["segments"] + 1) / row["engine"] / 1e6
        lines.append(
            f"| {who}, N = {row['segments']}, {row['dtype']} | {1e6 * row['engine']:.2f} "
            f"| {1e6 * row['exact']:.2f} | {1e6 * row['fast']:.2f} | {shares} | {rate:.0f} |"
        )
    return "\n".join(lines)
