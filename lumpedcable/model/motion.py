"""The equations of motion: what forces and masses, ends, junctions and bodies make of a step."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.attached import attached_ends, body_gain, follow_rate
from lumpedcable.model.bodies import body_key
from lumpedcable.model.correction import corrected_ends
from lumpedcable.model.couple import Found
from lumpedcable.model.ends import Release, end_name
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.forces import evaluate
from lumpedcable.model.grip import held_back
from lumpedcable.model.hauled import steered, steered_gain
from lumpedcable.model.inertia import end_matrices
from lumpedcable.model.junctions import junction_gain
from lumpedcable.model.line import Workspace
from lumpedcable.model.model import Model, Vectors
from lumpedcable.physics.linear import pick
from lumpedcable.physics.motion import mean_velocity_of, velocity_of
from lumpedcable.physics.place import place_at_end

__all__ = ["Kick", "acceleration", "carries", "driven_velocities", "kick"]


class Kick(NamedTuple):
    """What a kick of leapfrog leads to.

    Velocities (m/s) in its middle and half a step later, the reactions (N) of ends that can break, and
    the evaluation in its middle.
    """

    middle: Vectors
    after: Vectors
    reaction: dict[str, Float[Array, " d"]]
    found: Found


def kick(
    model: Model,
    t: Float[Array, ""],
    displacement: Vectors,
    before: Vectors,
    reaction: dict[str, Float[Array, " d"]],
    dt: Float[Array, ""],
    over: dict[str, Workspace] | None = None,
) -> Kick:
    """One kick of leapfrog, centred on t (s) with length dt (s).

    It starts from the velocities `before` (m/s) half a step earlier.
    """
    found = evaluate(model, t, displacement, before, reaction, dt, over)
    middle, after = {}, {}
    for name, e in found.items():
        _, w = inertia.kick(e.nodes, e.force, before[name], dt)
        change = corrected_ends(model.lines[name], e, w - before[name], dt, dt)
        middle[name], after[name] = before[name] + 0.5 * change, before[name] + change
        if model.lines[name].grip is not None:
            after[name], found[name] = held_back(model, name, t, e, before[name], change, dt)
            middle[name] = 0.5 * (before[name] + after[name])
    reaction = dict(reaction)
    for name, node, end in model.driven():
        now = velocity_of(end.motion, t)
        half = mean_velocity_of(end.motion, t, dt)
        now, half = now.astype(middle[name].dtype), half.astype(middle[name].dtype)
        if end.release is not None:
            begun = end.release.begun(t)
            key = end_name(name, node)
            push = _reaction(found[name], node, now, (half - before[name][:, node]) / dt)
            reaction[key] = end.release.carried(t, dt, reaction[key], push)
            now = jnp.where(begun, middle[name][:, node], now)
            half = jnp.where(begun, after[name][:, node], half)
        middle[name] = place_at_end(middle[name], node, now)
        after[name] = place_at_end(after[name], node, half)
    for index in range(len(model.junctions)):
        gains, pushes = junction_gain(model, index, t, found, before, dt)
        reaction.update(_carried(t, dt, reaction, pushes))
        for (name, side), (active, gain) in gains.items():
            node = model.lines[name].node(side)
            start = pick(before[name], node)
            mid, end_ = start + 0.5 * dt * gain, start + dt * gain
            mid = jnp.where(active, mid, pick(middle[name], node))
            end_ = jnp.where(active, end_, pick(after[name], node))
            middle[name] = place_at_end(middle[name], node, mid)
            after[name] = place_at_end(after[name], node, end_)
    found.add_passing(model, t, before, middle)
    for name in model.bodies:
        key = body_key(name)
        found_gain = body_gain(model, name, t, found, displacement, before, dt)
        middle[key] = before[key] + 0.5 * dt * found_gain.gain
        after[key] = before[key] + dt * found_gain.gain
        reaction.update(_carried(t, dt, reaction, _pulls(model, name, found_gain.pulls)))
    if model.bodies:
        middle = follow_rate(model, t, displacement, steered(model, t, None, middle))
        after = follow_rate(model, t, displacement, steered(model, t, dt, after), dt)
    return Kick(middle, after, reaction, found)


def driven_velocities(
    model: Model,
    t: Float[Array, ""],
    dt: Float[Array, ""],
    displacement: Vectors,
    velocity: Vectors,
) -> Vectors:
    """The same velocities (m/s), but for ends whose motion is given: theirs land on their paths, or
    on the bodies that they are tied to, at t + dt (s)."""
    velocity = steered(model, t, dt, velocity)
    velocity = follow_rate(model, t, displacement, velocity, dt) if model.bodies else velocity
    velocity = dict(velocity)
    for name, node, end in model.driven():
        own = velocity[name]
        given = mean_velocity_of(end.motion, t, dt).astype(own.dtype)
        if end.release is not None:
            given = jnp.where(end.release.begun(t), own[:, node], given)
        velocity[name] = place_at_end(own, node, given)
    return velocity


def acceleration(
    model: Model,
    t: Float[Array, ""],
    displacement: Vectors,
    velocity: Vectors,
    reaction: dict[str, Float[Array, " d"]],
    dt: Float[Array, ""] | None = None,
) -> tuple[Vectors, Found]:
    """Accelerations of all nodes (m/s2) at t (s), constrained at the ends, for any integrator.

    `dt` is the step (s) that starts here, if steps are fixed: what corrects a step knows it then.
    """
    gain, _, found = _moved(model, t, displacement, velocity, reaction, dt)
    return gain, found


def carries(
    model: Model, t: Float[Array, ""], displacement: Vectors, velocity: Vectors, reaction: Vectors,
    dt: Float[Array, ""] | None,
) -> Vectors:  # fmt: skip
    """What ends that can break carry (N) at t (s), after `reaction` a step of dt (s) ago."""
    return _moved(model, t, displacement, velocity, reaction, dt)[1]


def _moved(model: Model, t, displacement, velocity, reaction, dt) -> tuple[Vectors, Vectors, Found]:
    """What `acceleration` and `carries` tell: accelerations, reactions, and the evaluation."""
    found = evaluate(model, t, displacement, velocity, reaction, dt)
    result, reaction = {}, dict(reaction)
    for name, e in found.items():
        gain = inertia.acceleration(e.nodes, e.force, velocity[name])
        result[name] = corrected_ends(model.lines[name], e, gain, dt)
    for name, node, end in model.driven():
        given = jax.jvp(lambda s, m=end.motion: velocity_of(m, s), (t,), (jnp.ones_like(t),))[1]
        given = given.astype(result[name].dtype)
        if end.release is not None:
            begun, key = end.release.begun(t), end_name(name, node)
            push = _reaction(found[name], node, velocity[name][:, node], given)
            reaction[key] = end.release.carried(t, dt, reaction[key], push)
            given = jnp.where(begun, result[name][:, node], given)
        result[name] = place_at_end(result[name], node, given)
    for index in range(len(model.junctions)):
        gains, pushes = junction_gain(model, index, t, found, velocity, None)
        reaction.update(_carried(t, dt, reaction, pushes))
        for (name, side), (active, gain) in gains.items():
            node = model.lines[name].node(side)
            gain = jnp.where(active, gain, pick(result[name], node))
            result[name] = place_at_end(result[name], node, gain)
    found.add_passing(model, t, velocity, velocity)
    for name, body in model.bodies.items():
        key = body_key(name)
        found_gain = body_gain(model, name, t, found, displacement, velocity, None)
        result[key] = found_gain.gain
        reaction.update(_carried(t, dt, reaction, _pulls(model, name, found_gain.pulls)))
        for line, node, end in attached_ends(model, name):
            q, v = body.reference + displacement[key], velocity[key]
            turn, _, bias = body.rate(q, v, end.point)
            gain = turn @ result[key] + bias
            if end.release is not None:
                gain = jnp.where(end.release.begun(t), result[line][:, node], gain)
            result[line] = place_at_end(result[line], node, gain)
    return steered_gain(model, t, result), reaction, found


def _reaction(e: Evaluation, node: int, velocity, gain) -> Float[Array, " d"]:
    """Force (N) that whatever drives an end node exerts on it: M a - F - drag."""
    mass, drag, flow = end_matrices(e.nodes, node, velocity)
    return mass @ gain - e.force[:, node] + drag @ (velocity - flow)


def _carried(
    t, dt, reaction: Vectors, pushes: dict[str, tuple[Release, Float[Array, " d"]]]
) -> dict[str, Float[Array, " d"]]:
    """What ends that can break carry (N) at t (s), after `reaction` a step of dt (s) ago.

    `pushes` are, by end, its release and what it carries while it holds (N).
    """
    return {
        key: release.carried(t, dt, reaction[key], push) for key, (release, push) in pushes.items()
    }


def _pulls(model: Model, body: str, pulls) -> dict[str, tuple[Release, Float[Array, " d"]]]:
    """What a body pulls the ends with that can still break away from it (N), and their releases."""
    return {
        end_name(name, node): (end.release, pulls[name, node])
        for name, node, end in attached_ends(model, body)
        if end.release is not None
    }
