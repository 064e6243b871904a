"""A scene through the engine without a file, from its equilibrium or from a given shape and speed."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from engine_runs import scene_of

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.numbers import number
from lumpedcable.physics.precision import cast
from lumpedcable.scene import Scene
from lumpedcable.solve.integrate import METHODS, advance, initial_state
from lumpedcable.solve.leapfrog import CableTerm
from lumpedcable.solve.observe import watches
from lumpedcable.solve.plan import Numbers, Plan, Progress
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE, prepare_batch
from lumpedcable.study.plan import (
    plan_of,
    rounded_steps,
    structure_of,
    tolerances,
)

Array = np.ndarray


class Seen(NamedTuple):
    """What is seen of the only line: at each output, or of several outputs with time first.

    time (s); s (nodes,) the unstretched distance from the start (m); place (nodes, 3) at rest (m);
    moved and velocity (.., nodes, 3) in m and m/s; tension (.., segments) in N.
    """

    time: Array
    s: Array
    place: Array
    moved: Array
    velocity: Array
    tension: Array


# (s (nodes,), place at rest (nodes, 3)) -> displacement (m) and velocity (m/s), each (nodes, 3)
Kick = Callable[[Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Setting:
    """A scene and how it is stepped, made from a text; `steps` are those per output interval."""

    scene: Scene
    coordinates: Coordinates
    plan: Plan
    count: int

    @property
    def line(self) -> str:
        return next(iter(self.scene.lines))


@cache
def setting_of(text: str, *overrides: str) -> Setting:
    """The setting of a scene text; overrides as on the command line, "key=value"."""
    with tempfile.TemporaryDirectory() as folder:
        scene = scene_of(Path(folder), text, *overrides)
    count = scene.output.count
    layout = structure_of(scene).layout
    plan = replace(plan_of(scene, layout), watch_peaks=False)
    assert count <= plan.outputs  # so that one call of the engine does it all
    return Setting(scene, coordinates_of([scene]), plan, count)


class Played(NamedTuple):
    """What was seen, the steps in an output interval (1 for adaptive ones), and whether it ended."""

    seen: Seen
    steps: int
    finite: bool


def play(text: str, *overrides: str, kick: Kick | None = None, steps: int | None = None) -> Played:
    """Run a scene; `kick` moves it out of its equilibrium, `steps` replaces the step's choice."""
    setting = setting_of(text, *overrides)
    scene, coordinates, plan = setting.scene, setting.coordinates, setting.plan
    structure = structure_of(scene)
    shared = {key: number(value) for key, value in scene.numbers().items()}
    swept = {"output.duration": jnp.asarray([shared.pop("output.duration")])}
    ready = prepare_batch(
        structure, scene.solver.dtype, coordinates.axes, coordinates.origin, shared, swept
    )
    assert bool(ready.converged[0])
    if plan.adaptive:
        steps = 1
    elif steps is None:
        steps = int(rounded_steps(scene, np.asarray(ready.bound))[0])
    numbers = numbers_of(scene, jnp.asarray(steps))
    model = jax.tree.map(lambda x: x[0], ready.model)
    line = model.lines[setting.line]
    s, place = rest_of(line, coordinates)
    shift, speed = _start(kick, s, place, coordinates)
    fields, run = _through(model, plan, numbers, shift, speed, jnp.asarray(setting.count))
    fields = {key: np.asarray(x, float)[: setting.count] for key, x in fields[setting.line].items()}
    time = np.arange(1, setting.count + 1) * scene.output.every
    seen = Seen(time, s, place, *in_space(fields, coordinates))
    ended = bool(np.all(np.isfinite(seen.moved))) and not bool(run.stuck)
    return Played(seen, steps, ended)


def rest_of(line, coordinates: Coordinates):
    """Unstretched distances (nodes,) and places at rest (nodes, 3) in m of a line's nodes."""
    lengths = np.broadcast_to(np.asarray(line.segment_length, float), line.segments)
    s = np.concatenate([[0.0], np.cumsum(lengths)])
    return s, (coordinates.axes @ np.asarray(line.reference, float)).T + coordinates.origin


def numbers_of(scene: Scene, steps) -> Numbers:
    """The numbers of a plan for a scene."""
    return Numbers(
        number(scene.output.every), steps,
        *map(number, tolerances(scene.solver)),
    )  # fmt: skip


def _start(kick: Kick | None, s, place, coordinates: Coordinates):
    """Displacement and velocity (d, nodes) that are given to a line at rest."""
    if kick is None:
        zero = jnp.zeros((coordinates.dimensions, s.shape[0]))
        return zero, zero
    return tuple(jnp.asarray(coordinates.axes).T @ jnp.asarray(x).T for x in kick(s, place))


class InSpace(NamedTuple):
    """Displacement, velocity (.., nodes, 3) and tension (.., segments)."""

    moved: Array
    velocity: Array
    tension: Array


def in_space(fields, coordinates: Coordinates) -> InSpace:
    """Fields of the engine, in its own coordinates, as they are in space."""
    moved, velocity = (
        (coordinates.axes @ fields[key]).swapaxes(-1, -2) for key in ("position", "velocity")
    )
    return InSpace(moved, velocity, fields["tension"])


def sensitivity(
    text: str, key: str, reader, *overrides: str, kick: Kick | None = None, reverse: bool = False
):
    """What `reader` makes of a run, and its derivative with respect to the number `key`.

    Through statics, start and every step; forward mode, or reverse mode as the gradient of the sum
    of squares. The number of steps stays what it is; the kick follows the places at rest.
    """
    setting = setting_of(text, *overrides)
    scene, coordinates, plan = setting.scene, setting.coordinates, setting.plan
    base = play(text, *overrides, kick=kick)
    layout, values = structure_of(scene).layout, scene.numbers()

    def f(value):
        found = start_of(scene.with_numbers({**values, key: value}), layout, coordinates)
        model = cast(found.model, plan.dtype)
        rest = (jnp.asarray(coordinates.axes) @ model.lines[setting.line].reference).T
        shift, speed = _start(kick, base.seen.s, rest + coordinates.origin, coordinates)
        # plain numbers of steps and outputs make loops that reverse mode can go back through
        numbers = numbers_of(scene, base.steps)
        run = begun(model, plan, numbers, shift, speed)
        _, samples = advance(model, plan, numbers, run, 0, setting.count)
        fields = {k: x[: setting.count] for k, x in samples.fields[setting.line].items()}
        return reader(base.seen._replace(**in_space(fields, coordinates)._asdict()))

    at = jnp.asarray(values[key])
    if reverse:
        gradient = jax.jit(jax.grad(lambda x: jnp.sum(f(x) ** 2)), compiler_options=RUN_ONCE)
        return np.asarray(reader(base.seen)), np.asarray(gradient(at))
    both = jax.jit(lambda x: jax.jvp(f, (x,), (jnp.ones(()),)), compiler_options=RUN_ONCE)
    return tuple(np.asarray(x) for x in both(at))


def begun(model, plan: Plan, numbers: Numbers, shift, speed) -> Progress:
    """The start of a run with a displacement and a velocity (d, nodes) added to its only line."""
    y = initial_state(model, False, False)
    name = next(iter(model.lines))
    dtype = y.displacement[name].dtype
    y = eqx.tree_at(
        lambda y: (y.displacement[name], y.velocity[name]), y,
        (y.displacement[name] + shift.astype(dtype), y.velocity[name] + speed.astype(dtype)),
    )  # fmt: skip
    dt = numbers.every / numbers.steps
    state = dt
    if not plan.adaptive:
        state = METHODS[plan.method]().init(CableTerm(jnp.zeros(())), jnp.zeros(()), dt, y, model)
    return Progress(
        y, state, watches(model, y, plan.recoils), jnp.zeros((), jnp.int32), jnp.full((), jnp.nan), {},
        jnp.zeros((), bool),
    )  # fmt: skip


@partial(jax.jit, static_argnames=("plan",), compiler_options=RUN_ONCE)
def _through(model, plan: Plan, numbers: Numbers, shift, speed, count):
    run = begun(model, plan, numbers, shift, speed)
    run, samples = advance(model, plan, numbers, run, jnp.asarray(0), count)
    return samples.fields, run
