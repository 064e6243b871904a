"""A GPU: batches of steps beside what its memory and its arithmetic allow, and a study of 10^5 runs.

Bytes and operations are those of a step as XLA compiles it for the device: what its kernels read and
write, and what they reckon. What the memory allows is measured beside it, with a sum over a large array.
"""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks import jobs, on_paper, precision
from benchmarks.cost import median_of
from benchmarks.engine import SCENE
from benchmarks.machine import UnableError
from benchmarks.rested import rested
from benchmarks.studies import SWEEP, failed
from lumpedcable.study import lanes
from lumpedcable.study.compiled import advance_batch, begin_batch
from lumpedcable.study.devices import platform
from lumpedcable.study.packed import Packed
from lumpedcable.study.plan import plan_of
from lumpedcable.study.starts import rows_of

SEGMENTS, DURATION, EVERY = 100, 0.2, 5e-3  # s
LANES = (1, 1024, 8192, 65536)
DTYPES = ("float32", "float64")
REST = 1024  # runs brought to rest, which go round
REPEATS = 3
STUDY = 10**5
COPIED = 2**28  # elements of the array that is copied


def run(quick: bool) -> dict[str, Any]:
    """All of it, on the GPU that jax finds; quick: fewer lanes and a small study."""
    if platform() != "gpu":
        raise UnableError(f"no GPU: jax finds {jax.devices()[0].device_kind}")
    few, runs = (LANES[:2], 256) if quick else (LANES, STUDY)
    return {
        "device": jax.devices()[0].device_kind, "bandwidth": bandwidth(COPIED),
        "batches": [row for dtype in DTYPES for row in batches(dtype, few)],
        "studies": [study(runs, dtype) for dtype in DTYPES],
        "errors": precision.run(quick, (SEGMENTS,)),
    }  # fmt: skip


def bandwidth(elements: int) -> float:
    """Bytes a second that a copy of an array with a number added reads and writes."""
    x = jnp.arange(elements, dtype=jnp.float32)
    add = jax.jit(lambda x: x + 1.0)
    jax.block_until_ready(add(x))
    return 2.0 * x.nbytes / median_of(lambda: add(x), 9)


def batches(dtype: str, sizes: tuple[int, ...]) -> list[dict[str, Any]]:
    """Seconds that batches take from their start to their end, beside what a step of them is made of."""
    laid, ready, steps, numbers = rested(REST, SEGMENTS, EVERY, dtype)
    layout = laid.structures[0].layout
    body, shapes = on_paper.traced(SEGMENTS, dtype)
    found = []
    for size in sizes:
        plan = dataclasses.replace(plan_of(laid.scene, layout, size), outputs=laid.count)
        packed = rows_of(ready, np.arange(size) % REST).packed
        models = Packed(jax.device_put(packed.numbers), packed.form)

        def through(models: Packed = models, plan: Any = plan) -> Any:
            state, _ = begin_batch(models, plan, numbers)
            return advance_batch(
                models, plan, numbers, state, np.asarray(0), np.asarray(laid.count)
            )

        jax.block_until_ready(through())
        count = counted(body, shapes, size)
        seconds = median_of(through, REPEATS)
        found.append({
            "dtype": dtype, "lanes": size, "seconds": seconds, "steps": steps * laid.count,
            "nodes": SEGMENTS + 1, **count._asdict(),
        })  # fmt: skip
    return found


def counted(body: Any, shapes: Any, size: int) -> on_paper.Count:
    """What a step of so many runs is made of, with the runs along the last axis as in a batch."""
    # counters are common to all runs
    own = [not np.issubdtype(shape.dtype, np.integer) or shape.shape != () for shape in shapes]
    wide = [
        jax.ShapeDtypeStruct((*shape.shape, size), shape.dtype) if mine else shape
        for shape, mine in zip(shapes, own, strict=True)
    ]
    return on_paper.counted(lambda *values: lanes.evaluated(body, list(values), own, size), wide)


def study(runs: int, dtype: str) -> dict[str, Any]:
    """A study from the command line, with an empty cache and once more."""
    changes = (SWEEP.format(runs), 'output.keep="summaries"', f'solver.dtype="{dtype}"')
    command = ("study", str(SCENE), *(word for x in changes for word in ("--set", x)))
    with tempfile.TemporaryDirectory() as at:
        target, cache = Path(at) / "study", Path(at) / "cache"
        first, again = (jobs.once(command, target, cache) for _ in range(2))
        bad = failed(target)
    return {
        "runs": runs, "dtype": dtype, "first": first["seconds"], "again": again["seconds"],
        "peak": again["peak"], "failed": bad,
    }  # fmt: skip


def table(data: dict[str, Any]) -> str:
    """Batches, studies, and errors against the exact answers."""
    return "\n\n".join((_batches(data), _studies(data), precision.table(data["errors"])))


def sentence(data: dict[str, Any]) -> str:
    """How long the study takes, for who reads nothing else."""
    row = next(row for row in data["studies"] if row["dtype"] == DTYPES[0])
    return (
        f"On one {data['device']} `lumpedcable study` takes {row['again']:.0f} s for "
        f"{row['runs']} runs of {SEGMENTS} segments and {1e3 * DURATION:g} ms in {row['dtype']}, "
        f"{row['first']:.0f} s where it compiles first."
    )


def _batches(data: dict[str, Any]) -> str:
    copied = data["bandwidth"] / 1e12
    rows = [
        f"| {data['device']}, N = {SEGMENTS}, {1e3 * DURATION:g} ms | runs at once | time, ms "
        "| µs a step | million node-steps a second | kernels | bytes a node-step | TB/s "
        f"| of a copy's {copied:.2f} TB/s | operations a node-step | TFLOP/s |",
        "|---" * 11 + "|",
    ]
    for row in data["batches"]:
        node_steps = row["lanes"] * row["nodes"] * row["steps"]
        each = row["bytes"] / (row["lanes"] * row["nodes"])
        work = row["operations"] / (row["lanes"] * row["nodes"])
        rate = node_steps / row["seconds"]
        rows.append(
            f"| {row['dtype']} | {row['lanes']} | {1e3 * row['seconds']:.3g} "
            f"| {1e6 * row['seconds'] / row['steps']:.3g} | {rate / 1e6:.0f} | {row['kernels']} "
            f"| {each:.0f} | {each * rate / 1e12:.2g} | {each * rate / data['bandwidth']:.0%} "
            f"| {work:.0f} | {work * rate / 1e12:.2g} |"
        )
    return "\n".join(rows)


def _studies(data: dict[str, Any]) -> str:
    rows = [
        "| `lumpedcable study` of the parted line, summaries | precision | time, s: first "
        "| again, programs in the cache | runs a second, again | peak memory of the host, MB | not ok |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in data["studies"]:
        rows.append(
            f"| {row['runs']} runs, outputs each 1 ms | {row['dtype']} | {row['first']:.1f} "
            f"| {row['again']:.1f} | {row['runs'] / row['again']:.0f} | {row['peak'] / 1e6:.0f} "
            f"| {row['failed']} |"
        )
    return "\n".join(rows)
