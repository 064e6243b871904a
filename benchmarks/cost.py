"""What a step costs: against segments, batch size, in memory and to compile."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from benchmarks.engine import Runner, scene_of
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.numbers import number
from lumpedcable.solve.plan import Numbers
from lumpedcable.study.compiled import advance_batch, begin_batch, prepare_batch
from lumpedcable.study.packed import Packed
from lumpedcable.study.plan import plan_of, structure_of

Tell = Callable[[str], None]

MESHES = (25, 50, 100, 200, 400, 800, 1600, 3200, 6400)
WAVES = ("corrected", "plain")
LANES = (1, 4, 16, 64, 256, 1024)
PARAMETERS = (
    "materials.nylon.p1", "materials.nylon.p2", "materials.nylon.p3", "materials.nylon.p4",
    "lines.rope.mass", "lines.rope.end.held.pretension",
)  # fmt: skip
MEMORY = ((100, 1), (6400, 1), (100, 64), (100, 1024))  # segments, lanes
ROOT = Path(__file__).parents[1]


def run(quick: bool, tell: Tell) -> dict[str, Any]:
    """All of it."""
    return {
        "step": [
            step_cost(n, waves, tell)
            for waves in WAVES
            for n in (MESHES[2:5:2] if quick else MESHES)
        ],
        "batch": throughput((1, 16) if quick else LANES, tell),
        "memory": [memory(n, lanes, tell) for n, lanes in (MEMORY[:1] if quick else MEMORY)],
    }


def median_of(work: Callable[[], Any], repeats: int = 5) -> float:
    """Median time (s) of some runs."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        jax.block_until_ready(work())
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def step_cost(segments: int, waves: str, tell: Tell) -> dict[str, Any]:
    """Seconds of a step on one mesh, with outputs so rare that they do not count."""
    tell(f"cost of a step, {segments} segments, {waves}")
    runner = Runner(scene_of(f"segments={segments}", f'solver.waves="{waves}"'))
    steps = max(1000, 10 * runner.steps)
    numbers = runner.numbers(10 * runner.every, steps)
    seconds = advance_time(runner.ready.packed, runner, numbers, 2)
    return {"segments": segments, "waves": waves, "step": seconds / (2 * steps), "steps": 2 * steps}


def advance_time(models: Packed, runner: Runner, numbers: Numbers, outputs: int) -> float:
    """Median time (s) of some outputs from the start, which itself is not counted."""

    def through() -> float:
        state, _ = begin_batch(models, runner.plan, numbers)
        jax.block_until_ready(state)
        start = time.perf_counter()
        done = advance_batch(
            models, runner.plan, numbers, state, jnp.asarray(0), jnp.asarray(outputs)
        )
        jax.block_until_ready(done)
        return time.perf_counter() - start

    through()
    return statistics.median(through() for _ in range(5))


def throughput(sizes: tuple[int, ...], tell: Tell, segments: int = 100) -> list[dict[str, Any]]:
    """Node-steps per second of batches of one line at different pretensions."""
    scene = scene_of(f"segments={segments}")
    runner = Runner(scene)
    structure, coordinates = structure_of(scene), coordinates_of([scene])
    shared = {key: number(value) for key, value in scene.numbers().items()}
    shared.pop(PARAMETERS[-1])
    tell("statics of the largest batch")
    swept = {PARAMETERS[-1]: jnp.linspace(45e3, 450e3, max(sizes))}
    models = prepare_batch(
        structure, "float64", coordinates.axes, coordinates.origin, shared, swept
    ).packed
    numbers, found = runner.numbers(runner.every, runner.steps), []
    for lanes in sizes:
        tell(f"a batch of {lanes} lines")
        some = jax.tree.map(lambda x, b=lanes: x[:b], models)
        outputs = max(2, 1024 // lanes)
        runner.plan = plan_of(scene, structure.layout, lanes)
        outputs = min(outputs, runner.plan.outputs)

        seconds = advance_time(some, runner, numbers, outputs)
        work = lanes * (segments + 1) * outputs * runner.steps
        found.append({"lanes": lanes, "rate": work / seconds, "segments": segments})
    return found


def memory(segments: int, lanes: int, tell: Tell) -> dict[str, Any]:
    """Largest resident memory (bytes) of a process of its own that runs such a batch."""
    tell(f"memory of {lanes} lines of {segments} segments")
    command = [sys.executable, "-m", "benchmarks.memory", str(segments), str(lanes)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return {"segments": segments, "lanes": lanes, **json.loads(done.stdout)}


def tables(data: dict[str, Any]) -> dict[str, str]:
    """Markdown tables by name."""
    steps = data["step"]
    meshes = sorted({row["segments"] for row in steps})
    lines = [
        "| | " + " | ".join(f"N = {n}" for n in meshes) + " |",
        "|---" * (len(meshes) + 1) + "|",
    ]
    for waves in WAVES:
        own = {row["segments"]: row for row in steps if row["waves"] == waves}
        cells = " | ".join(f"{1e6 * own[n]['step']:.3g}" for n in meshes)
        lines.append(f"| {waves}: a step, us | {cells} |")
    batch = data["batch"]
    many = [
        "| lines in a batch | " + " | ".join(str(b["lanes"]) for b in batch) + " |",
        "|---" * (len(batch) + 1) + "|",
        "| million node-steps a second | "
        + " | ".join(f"{b['rate'] / 1e6:.3g}" for b in batch)
        + " |",
    ]
    memories = [
        "| segments | lines | peak memory, MB | of it before the run |",
        "|---|---|---|---|",
    ] + [
        f"| {m['segments']} | {m['lanes']} | {m['peak'] / 1e6:.0f} | {m['before'] / 1e6:.0f} |"
        for m in data["memory"]
    ]
    return {
        "step": "\n".join(lines), "batch": "\n".join(many), "memory": "\n".join(memories),
    }  # fmt: skip
