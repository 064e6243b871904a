"""What derivatives cost over the value, in time and in memory: of motion alone, and of a whole run."""

from __future__ import annotations

import dataclasses
import statistics
import time
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.cost import PARAMETERS, median_of
from benchmarks.engine import Runner, scene_of
from lumpedcable.fitting.residual import run_group
from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import RUN_BACK, setting_of
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.numbers import number
from lumpedcable.solve.integrate import advance, begin
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_OFTEN, RUN_ONCE
from lumpedcable.study.lanes import across
from lumpedcable.study.plan import structure_of

OUTPUTS = 100  # so long a time, of which only the end is looked at
SHORTER = (1, 10, 100, 1000)  # steps so many times as short
MESHES = (100, 200)  # segments, of whole runs
ROUNDS, STEPS = 151, 3000  # measured so often; fewer times from so many steps on
MOVED, SPEED = "end displacement, 100 ms", "largest end velocity, statics and 200 samples"


def run(quick: bool) -> list[dict[str, Any]]:
    """A row for each number of steps of the motion alone, and one for a whole run of each mesh."""
    meshes = MESHES[:1] if quick else MESHES
    return [*of_motion(SHORTER[:1] if quick else SHORTER), *map(of_a_run, meshes)]


def of_a_run(segments: int) -> dict[str, Any]:
    """The same six derivatives of a number of a whole run: statics, every step, all samples."""
    scene = scene_of(f"segments={segments}")
    scalar = read_scalar("max velocity at rope.end", scene)
    x = jnp.array([scene.numbers()[name] for name in PARAMETERS])
    spec, arrays = setting_of(scene, scalar, PARAMETERS, back=False)
    back, more = setting_of(scene, scalar, PARAMETERS, back=True)
    assert back.steps is not None

    def value(spec, arrays, x):
        return jnp.max(run_group(spec, arrays, x)[0][0, 0])

    work = {
        "value": (partial(value, spec), (arrays, x)),
        "forward": (jax.jacfwd(partial(value, spec), argnums=1), (arrays, x)),
        "backward": (jax.value_and_grad(partial(value, back), argnums=1), (more, x)),
    }
    of = SPEED if segments == MESHES[0] else f"the same, N = {segments}"
    return {"of": of, "steps": back.steps * back.count, **_measured(work, ROUNDS)}


def of_motion(shorter: tuple[int, ...], segments: int = 100) -> list[dict[str, Any]]:
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
    numbers = runner.numbers(OUTPUTS * runner.every, OUTPUTS * runner.steps)
    plan = dataclasses.replace(runner.plan, outputs=1, recoils=(), watch_peaks=False)
    x = jnp.stack([base[name] for name in PARAMETERS])

    def at_rest(x):
        mine = scene.with_numbers({**base, **dict(zip(PARAMETERS, x, strict=True))})
        return start_of(mine, structure.layout, coordinates).model

    def moved(model, steps):
        mine = numbers._replace(steps=steps)
        state, _ = begin(model, plan, mine)
        state, _ = advance(model, plan, mine, state, 0, 1)
        return state.y.displacement["rope"][0, -1]

    model = jax.jit(at_rest, compiler_options=RUN_ONCE)(x)
    tangents = jax.jit(jax.jacfwd(at_rest), compiler_options=RUN_ONCE)(x)
    lanes = jax.tree.map(lambda s: jnp.moveaxis(s, -1, 0), tangents)
    depends = jax.tree.map(lambda s: bool(jnp.any(s != 0.0)), lanes)
    model, same = eqx.partition(model, depends)
    lanes = eqx.filter(lanes, depends)

    def value(model, steps):
        return moved(eqx.combine(model, same), steps)

    def forward(model, lanes, steps):
        return across(lambda v: jax.jvp(lambda m: value(m, steps), (model,), (v,))[1], lanes)

    def backward(model, lanes, *, steps):
        by = jax.grad(value)(model, steps)
        parts = jax.tree.map(lambda g, s: jnp.tensordot(s, g, g.ndim), by, lanes)
        return sum(jax.tree.leaves(parts))

    found = []
    for times in shorter:
        steps = times * OUTPUTS * runner.steps
        counted = jnp.asarray(steps)
        work = {
            "value": (lambda model, _, n: value(model, n), (model, lanes, counted)),
            "forward": (forward, (model, lanes, counted)),
            "backward": (partial(backward, steps=steps), (model, lanes)),
        }
        found.append(
            {
                "of": MOVED,
                "steps": steps,
                **_measured(work, max(5, ROUNDS * STEPS // max(steps, STEPS))),
            }
        )
    return found


def _measured(work: dict[str, Any], rounds: int) -> dict[str, Any]:
    """Result, warm time (s), time to compile (s) and memory beside arguments (bytes) of each."""
    result, calls = {}, {}
    for name, (compute, arguments) in work.items():
        begun = time.perf_counter()
        # as the package compiles what it calls often
        options = RUN_BACK if name == "backward" else RUN_OFTEN
        compiled = jax.jit(compute, compiler_options=options).lower(*arguments).compile()
        taken = time.perf_counter() - begun
        calls[name] = partial(compiled, *arguments)
        result[name] = {
            "compile": taken,
            "result": jax.tree.map(lambda y: np.asarray(y).tolist(), calls[name]()),
            "memory": compiled.memory_analysis().temp_size_in_bytes,
        }
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):  # one after the other, so that the machine is the same for all
        for name, call in calls.items():
            jax.block_until_ready(call())  # what it needs is then near
            times[name].append(median_of(call, 1))
    for name, seconds in times.items():
        result[name]["warm"] = statistics.median(seconds)
    return result


def table(data: list[dict[str, Any]]) -> str:
    """Times, and memory where a way back keeps states, by number of steps."""
    lines = [
        "| N = 100 | steps | time, ms | over the value | memory, MB | compiling, s |",
        "|---|---|---|---|---|---|",
    ]
    for row in data:
        for key in ("value", "forward", "backward"):
            one = row[key]
            told = f"{row['of']}: value" if key == "value" else f"6 derivatives, {key}"
            lines.append(
                f"| {told} | {row['steps']} | {1e3 * one['warm']:.3g} "
                f"| {one['warm'] / row['value']['warm']:.1f} | {one['memory'] / 1e6:.2g} "
                f"| {one['compile']:.1f} |"
            )
    return "\n".join(lines)
