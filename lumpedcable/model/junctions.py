"""How ends that meet at a junction move: as one, but for those that have broken away."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.couple import Found
from lumpedcable.model.ends import Release, end_name, solve_small
from lumpedcable.model.grip import joint_held_back
from lumpedcable.model.inertia import end_matrices
from lumpedcable.model.model import LineEnd, Model, Vectors
from lumpedcable.physics.linear import pick

__all__ = ["junction_gain"]


def junction_gain(
    model: Model, index: int, t: Float[Array, ""], found: Found, before: Vectors,
    dt: Float[Array, ""] | None,
) -> tuple[dict[LineEnd, tuple[Any, Array]], dict[str, tuple[Release, Array]]]:  # fmt: skip
    """Common acceleration (m/s2) of a junction's members, and what each breakable one carries.

    (sum M + dt/2 D) a = sum F - D (v - w), D = k |v| lagging by half a step of length dt (s), if any.
    By member: whether it still moves with the others, and the acceleration (d,). By the name of each
    end that can break away: its release, and the force (d,) on it (N).
    """
    junction = model.junctions[index]
    leaving = dict(model.leavers(index))
    name, node = model.carrier(index)
    velocity = pick(before[name], model.lines[name].node(node))
    d, dtype = velocity.shape[0], velocity.dtype
    half = 0.0 if dt is None else 0.5 * dt
    matrix, vector = jnp.zeros((d, d), dtype), jnp.zeros((d,), dtype)
    if junction.mass is not None:
        matrix = matrix + junction.mass * jnp.eye(d, dtype=dtype)
    if junction.load is not None:
        vector = vector + junction.load
    if junction.lift is not None:
        place = pick(found[name].line.shape.position, model.lines[name].node(node))
        vector = vector + junction.lift.force(place)
    parts = {}
    for member in junction.members:
        e, place = found[member[0]], model.lines[member[0]].node(member[1])
        mass, drag, flow = end_matrices(e.nodes, place, velocity)
        force = pick(e.force, place) - drag @ (velocity - flow)
        parts[member] = (mass + half * drag, force)
        active = 1.0
        if member in leaving:
            active = jnp.where(leaving[member].begun(t), 0.0, 1.0).astype(dtype)
        matrix = matrix + active * parts[member][0]
        vector = vector + active * force
    gain = solve_small(matrix, vector)
    if dt is not None:
        gain = joint_held_back(model, junction.members, t, found, before, matrix, gain, dt)
    gains, pushes, parting = {}, {}, model.parting(index)
    for member in junction.members:
        active = True
        if member in leaving:
            active = ~leaving[member].begun(t)
            mass, force = parts[member]
            pushes[end_name(*member)] = (leaving[member], mass @ gain - force)
        elif parting is not None:
            active = ~parting.begun(t)  # left to itself it moves like any other end
        gains[member] = (active, gain)
    return gains, pushes
