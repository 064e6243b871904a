"""What a step costs: against segments, batch size, for gradients, in memory and to compile."""

from __future__ import annotations

import dataclasses
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.engine import Runner, scene_of
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.model import Model
from lumpedcable.solve.integrate import Numbers, advance, begin
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE, advance_batch, begin_batch, number, prepare_batch
from lumpedcable.study.lanes import across
from lumpedcable.study.plan import plan_of, structure_of

Tell = Callable[[str], None]

MESHES = (25, 50, 100, 200, 400, 800, 1600, 3200, 6400)
WAVES = ("corrected", "plain")
LANES = (1, 4, 16, 64, 256, 1024)
PARAMETERS = (
    "materials.nylon.p1", "materials.nylon.p2", "materials.nylon.p3", "materials.nylon.p4",
    "lines.rope.mass", "lines.rope.end.held.pretension",
)  # fmt: skip
GRADIENT_OUTPUTS = 100
ROUNDS = 151
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
        "gradient": gradients(GRADIENT_OUTPUTS, tell),
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
    seconds = advance_time(runner.ready.model, runner, numbers, 2)
    return {"segments": segments, "waves": waves, "step": seconds / (2 * steps), "steps": 2 * steps}


def advance_time(model: Model, runner: Runner, numbers: Numbers, outputs: int) -> float:
    """Median time (s) of some outputs from the start, which itself is not counted."""

    def through() -> float:
        state, _ = begin_batch(model, runner.plan, numbers)
        jax.block_until_ready(state)
        start = time.perf_counter()
        done = advance_batch(
            model, runner.plan, numbers, state, jnp.asarray(0), jnp.asarray(outputs)
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
    model = prepare_batch(
        structure, "float64", coordinates.axes, coordinates.origin, shared, swept
    ).model
    numbers, found = runner.numbers(runner.every, runner.steps), []
    for lanes in sizes:
        tell(f"a batch of {lanes} lines")
        some = jax.tree.map(lambda x, b=lanes: x[:b], model)
        outputs = max(2, 1024 // lanes)
        runner.plan = plan_of(scene, structure.layout, lanes)
        outputs = min(outputs, runner.plan.outputs)

        seconds = advance_time(some, runner, numbers, outputs)
        work = lanes * (segments + 1) * outputs * runner.steps
        found.append({"lanes": lanes, "rate": work / seconds, "segments": segments})
    return found


def gradients(outputs: int, tell: Tell, segments: int = 100) -> dict[str, Any]:
    """Cost of the derivative of the end's displacement by six parameters over that of its value.

    Followed is the motion alone, without outputs or watches on the way, as a fit does. Forward: six
    tangents through statics and motion at once, side by side along the last axis. Backward: JAX
    transposes a loop only if it knows the number of its turns when it compiles, so that here the
    number of steps is part of the program. The start, which takes Newton's method, stays forward;
    derivatives go by those of the model's numbers alone that depend on the parameters.
    """
    scene = scene_of(f"segments={segments}")
    runner = Runner(scene)
    structure, coordinates = structure_of(scene), coordinates_of([scene])
    base = {key: number(value) for key, value in scene.numbers().items()}
    numbers = runner.numbers(outputs * runner.every, outputs * runner.steps)
    plan = dataclasses.replace(runner.plan, outputs=1, recoils=())
    x = jnp.stack([base[name] for name in PARAMETERS])

    def at_rest(x):
        mine = scene.with_numbers({**base, **dict(zip(PARAMETERS, x, strict=True))})
        return start_of(mine, structure.layout, coordinates).model

    def moved(model, steps):
        mine = numbers._replace(steps=steps)
        state, _ = begin(model, plan, mine)
        state, _ = advance(model, plan, mine, state, 0, 1)
        return state.y.displacement["rope"][0, -1]

    tell("gradients: statics")
    start = jax.jit(at_rest, compiler_options=RUN_ONCE)
    tangents = jax.jit(jax.jacfwd(at_rest), compiler_options=RUN_ONCE)
    model = start(x)
    lanes = jax.tree.map(lambda s: jnp.moveaxis(s, -1, 0), tangents(x))
    depends = jax.tree.map(lambda s: bool(jnp.any(s != 0.0)), lanes)
    model, same = eqx.partition(model, depends)
    lanes = eqx.filter(lanes, depends)

    def value(model, steps):
        return moved(eqx.combine(model, same), steps)

    def forward(model, lanes, steps):
        return across(lambda v: jax.jvp(lambda m: value(m, steps), (model,), (v,))[1], lanes)

    def backward(model, lanes, steps):
        by = jax.grad(value)(model, steps)
        parts = jax.tree.map(lambda g, s: jnp.tensordot(s, g, g.ndim), by, lanes)
        return sum(jax.tree.leaves(parts))

    work = {
        "value": jax.jit(lambda model, _, steps: value(model, steps)),
        "forward": jax.jit(forward),
        "backward": jax.jit(backward, static_argnums=2),
    }
    result: dict[str, Any] = {"outputs": outputs, "steps": outputs * runner.steps}
    calls, times = {}, {}
    for name, compute in work.items():
        tell(f"gradients: {name}")
        steps = outputs * runner.steps
        steps = steps if name == "backward" else jnp.asarray(steps)
        calls[name], times[name] = partial(compute, model, lanes, steps), []
        begun = time.perf_counter()
        found = jax.block_until_ready(calls[name]())
        first = time.perf_counter() - begun
        result[name] = {"compile": first, "result": np.asarray(found).tolist()}
    for _ in range(ROUNDS):  # one after the other, so that the machine is the same for all
        for name, call in calls.items():
            jax.block_until_ready(call())  # what it needs is then near
            times[name].append(median_of(call, 1))
    for name, seconds in times.items():
        result[name]["warm"] = statistics.median(seconds)
        result[name]["compile"] -= result[name]["warm"]
    return result


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
    g = data["gradient"]
    rows = [
        f"| end displacement after {g['steps']} steps, N = 100 | time, ms | over the value "
        "| compiling, s |",
        "|---|---|---|---|",
    ]
    for key, text in (
        ("value", "value"), ("forward", "6 derivatives, forward"),
        ("backward", "6 derivatives, backward"),
    ):  # fmt: skip
        ratio = g[key]["warm"] / g["value"]["warm"]
        rows.append(
            f"| {text} | {1e3 * g[key]['warm']:.3g} | {ratio:.1f} | {g[key]['compile']:.1f} |"
        )
    memories = [
        "| segments | lines | peak memory, MB | of it before the run |",
        "|---|---|---|---|",
    ] + [
        f"| {m['segments']} | {m['lanes']} | {m['peak'] / 1e6:.0f} | {m['before'] / 1e6:.0f} |"
        for m in data["memory"]
    ]
    return {
        "step": "\n".join(lines), "batch": "\n".join(many), "gradient": "\n".join(rows),
        "memory": "\n".join(memories),
    }  # fmt: skip
