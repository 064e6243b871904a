"""A scene through the engine without a file: histories of its ends, and how long it took."""

from __future__ import annotations

import statistics
import time
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.measures import FINE, Histories, front_time
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.numbers import number
from lumpedcable.scene import Scene, load_study
from lumpedcable.solve.plan import Numbers
from lumpedcable.solve.signs import signs
from lumpedcable.status import SIGNS, Status
from lumpedcable.study.compiled import advance_batch, begin_batch, prepare_batch
from lumpedcable.study.packed import unpacked
from lumpedcable.study.plan import (
    courant_of,
    plan_of,
    rounded_steps,
    structure_of,
    tolerances,
)

HERE = Path(__file__).parent
SCENE = HERE / "parted-line.toml"
MOST_REPEATS, REPEAT_TIME = 31, 0.5  # warm runs, and s after which no other is begun


class Timed(NamedTuple):
    """How a run went: histories at its outputs, the status, seconds and steps.

    `first` is the first call (s), compiling included if the program is new; `warm` the median of the
    later ones (s) and `repeats` their number; `steps` those taken (accepted ones, if the method
    chooses them).
    """

    histories: Histories
    status: Status
    first: float
    warm: float
    repeats: int
    steps: int


def scene_of(*overrides: str) -> Scene:
    """The parted line with some numbers changed ("KEY=VALUE")."""
    return load_study(SCENE, overrides).runs[0]


class Runner:
    """A scene at rest, ready to go through time as often as one likes.

    `stretch` replaces the scene's Courant number, and may be more than 1 for a method that stands it.
    """

    def __init__(self, scene: Scene, stretch: float | None = None):
        structure = structure_of(scene)
        coordinates = coordinates_of([scene])
        shared = {key: number(value) for key, value in scene.numbers().items()}
        swept = {"output.duration": jnp.asarray([shared.pop("output.duration")])}
        self.scene = scene
        self.ready = prepare_batch(
            structure, scene.solver.dtype, coordinates.axes, coordinates.origin, shared, swept
        )
        self.plan = plan_of(scene, structure.layout)
        self.every, self.count = scene.output.every, scene.output.count
        # the largest Courant number that is not a fault
        self.limit = 1.0 if stretch is None else stretch
        bound = np.asarray(self.ready.bound)
        if stretch is not None:
            bound = bound * stretch / courant_of(scene)
        self.steps = 1 if self.plan.adaptive else int(rounded_steps(scene, bound)[0])
        self.line = next(iter(self.ready.model.lines))

    def numbers(self, every: float, steps: int) -> Numbers:
        """The numbers of the plan for outputs each `every` (s), `steps` apart."""
        solver = self.scene.solver
        return Numbers(
            number(every), jnp.asarray(steps),
            *map(number, tolerances(solver)),
        )  # fmt: skip

    def through(self, every: float, steps: int, count: int, most: int | None = None):
        """Yield what begin_batch and then every advance_batch return, and how many outputs of it.

        At most `most` outputs a call; without it, as many as the plan allows.
        """
        models, plan, numbers = self.ready.packed, self.plan, self.numbers(every, steps)
        state, samples = begin_batch(models, plan, numbers)
        yield state.tree(), jax.tree.map(lambda x: x[:, None], samples).tree(), 1
        done = 0
        while done < count:
            now = min(most or plan.outputs, count - done)
            # numbers of the kind that `seconds` gives, or the program is compiled twice
            state, samples = advance_batch(
                models, plan, numbers, state, np.asarray(done), np.asarray(now)
            )
            yield state.tree(), unpacked(samples), now
            done += now

    def seconds(self) -> float:
        """Run once without looking at anything (s)."""
        models, plan, numbers = self.ready.packed, self.plan, self.numbers(self.every, self.steps)
        begin, done = time.perf_counter(), 0
        state, _ = begin_batch(models, plan, numbers)
        while done < self.count:
            now = min(plan.outputs, self.count - done)
            state, _ = advance_batch(
                models, plan, numbers, state, np.asarray(done), np.asarray(now)
            )
            done += now
        jax.block_until_ready(state)
        return time.perf_counter() - begin

    def histories(self, every: float, steps: int, count: int) -> tuple[Histories, Status]:
        """Ends and status at `count` + 1 times `every` (s) apart."""
        wall, speed, bad, last = [], [], dict.fromkeys(SIGNS, False), None
        for state, samples, now in self.through(every, steps, count):
            last = state
            wall.append(np.asarray(samples.ends[self.line])[0, :now, 0])
            speed.append(np.asarray(samples.fields[self.line]["velocity"])[0, :now, 0, -1])
            for status, shown in signs(jax.tree.map(np.asarray, samples), self.limit).items():
                bad[status] |= bool(np.any(shown[0, :now]))
        assert last is not None
        moved = float(np.asarray(last.y.displacement[self.line])[0, 0, -1])
        times, tension = np.arange(count + 1) * every, np.concatenate(wall)
        status = next((status for status, found in bad.items() if found), Status.OK)
        if not bool(np.asarray(self.ready.converged)[0]):
            status = Status.STATICS_NOT_CONVERGED
        front = front_time(times, tension)
        return Histories(times, tension, np.concatenate(speed), moved, front), status

    def fine(self) -> Histories:
        """The same run seen at least each 0.1 ms, or at every step where steps are longer.

        A method that chooses its step is stopped at these times, which makes its steps shorter.
        """
        if self.plan.adaptive:
            parts = round(self.every / FINE)
            return self.histories(FINE, 1, self.count * parts)[0]
        parts = next(
            (k for k in range(1, self.steps + 1) if self.steps % k == 0 and self.every / k <= FINE),
            self.steps,
        )
        return self.histories(self.every / parts, self.steps // parts, self.count * parts)[0]

    def accepted(self) -> int:
        """Steps of a method that chooses them, from the mean step of every output interval."""
        total = 0
        for state, _, _ in self.through(self.every, 1, self.count, 1):
            total += round(self.every / float(np.asarray(state.solver_state)[0]))
        return total - 1

    def run(self) -> Timed:
        """Once with all eyes, then as often as the time allows."""
        begin = time.perf_counter()
        found, status = self.histories(self.every, self.steps, self.count)
        first = time.perf_counter() - begin
        warm: list[float] = []
        while len(warm) < MOST_REPEATS and sum(warm) < REPEAT_TIME:
            warm.append(self.seconds())
        steps = self.accepted() if self.plan.adaptive else self.steps * self.count
        return Timed(found, status, first, statistics.median(warm), len(warm), steps)


def run(scene: Scene) -> Timed:
    """Statics once, then through time, several times."""
    return Runner(scene).run()
