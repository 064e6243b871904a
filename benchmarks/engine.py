"""A scene through the engine without a file: histories of its ends, and how long it took."""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.scene import Scene, load_study
from lumpedcable.solve.integrate import CHUNK, Numbers
from lumpedcable.study.compiled import advance_batch, begin_batch, number, prepare_batch
from lumpedcable.study.plan import (
    DEFAULT_ATOL,
    DEFAULT_RTOL,
    batches,
    output_count,
    plan_of,
    rounded_steps,
)

HERE = Path(__file__).parent
SCENE = HERE / "parted-line.toml"


class Histories(NamedTuple):
    """What happens at the ends of the rope: times (s), then one value per time.

    wall tension (N), velocity of the broken end (m/s, negative towards the wall), and its
    displacement (m), found by integrating nothing: it is part of the state.
    """

    time: NDArray[np.float64]
    tension: NDArray[np.float64]
    velocity: NDArray[np.float64]
    displacement: float


class Timed(NamedTuple):
    """Histories with the seconds of the first call (compiling included), of a warm one, and steps."""

    histories: Histories
    first: float
    warm: float
    steps: int


def scene_of(*overrides: str) -> Scene:
    """The parted line with some numbers changed ("KEY=VALUE")."""
    return load_study(SCENE, overrides).runs[0]


def run(scene: Scene, repeats: int = 3) -> Timed:
    """Statics once, then through time `repeats` + 1 times; the warm time is the median."""
    batch = batches([scene])[0]
    coordinates = coordinates_of([scene])
    shared = {key: number(value) for key, value in scene.numbers().items()}
    swept = {"output.duration": jnp.asarray([shared.pop("output.duration")])}
    ready = prepare_batch(
        batch.structure, scene.solver.dtype, coordinates.axes, coordinates.origin, shared, swept
    )
    plan = plan_of(scene, batch.structure.layout)
    steps = 1 if plan.adaptive else int(rounded_steps(scene, np.asarray(ready.bound))[0])
    numbers = Numbers(
        number(scene.output.every), jnp.asarray(steps),
        number(scene.solver.rtol or DEFAULT_RTOL), number(scene.solver.atol or DEFAULT_ATOL),
    )  # fmt: skip
    count = output_count(scene)

    def through():
        state, first = begin_batch(ready.model, plan, numbers)
        kept, done = [], 0
        while done < count:
            now = min(CHUNK, count - done)
            state, samples = advance_batch(
                ready.model, plan, numbers, state, jnp.asarray(done), jnp.asarray(now)
            )
            kept.append((samples, now))
            done += now
        jax.block_until_ready(state)
        return first, kept, state

    started = time.perf_counter()
    first, kept, state = through()
    first_time = time.perf_counter() - started
    warm = []
    for _ in range(repeats):
        started = time.perf_counter()
        through()
        warm.append(time.perf_counter() - started)
    line = next(iter(ready.model.lines))
    wall = [np.asarray(first.ends[line])[0, None, 0]]
    speed = [np.asarray(first.fields[line]["velocity"])[0, None, 0, -1]]
    for samples, now in kept:
        wall.append(np.asarray(samples.ends[line])[0, :now, 0])
        speed.append(np.asarray(samples.fields[line]["velocity"])[0, :now, 0, -1])
    times = np.arange(count + 1) * scene.output.every
    moved = float(np.asarray(state.y.displacement[line])[0, 0, -1])
    histories = Histories(times, np.concatenate(wall), np.concatenate(speed), moved)
    return Timed(histories, first_time, statistics.median(warm), steps * count)
