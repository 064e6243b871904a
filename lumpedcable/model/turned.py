"""Ends of lines that bend and are clamped to bodies: they leave them in directions that turn.

A line bends out of the direction c that a clamp has at the moment. With the energy E = k (1 - c . u),
k = EI/s and u the direction of the last segment (`Bending`), a body of coordinates q feels

    -dE/dq = (dc/dq)^T k u  (N m),  c = R(q) c0,

and what moves a body as it is told gives the line the power dE/dt = -k u . dc/dt at fixed u (W).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.ends import Attached, Driven, End
from lumpedcable.model.line import Line
from lumpedcable.model.model import LineEnd, Model
from lumpedcable.physics.bending import Bending
from lumpedcable.physics.load import Shape

__all__ = [
    "Clamped",
    "clamp_force",
    "clamp_power",
    "clamped_to",
    "pulled_round",
    "swing_of",
    "turned",
]

SIDES = {0: "start", -1: "end"}

Clamped = tuple[str, int, Attached]
"""An end that is clamped to a body: its line, 0 for the start or -1 for the end, what is there."""


def turned(
    model: Model, t: Float[Array, ""] | None = None, displacement: dict[str, Array] | None = None
) -> Model:
    """The model with its clamps as bodies have turned them at t (s), 0 if None.

    `displacement` are those of the bodies (m, rad), none if None.
    """
    t = jnp.zeros(()) if t is None else t
    lines = {}
    for name, node, end in model.outer_ends():
        if isinstance(end, Attached | Driven) and end.aim is not None:
            line = lines.get(name, model.lines[name])
            aim = _aim(model, end, t, displacement)
            lines[name] = _led(line, node, aim.astype(line.reference.dtype))
    if not lines:
        return model
    return eqx.tree_at(lambda m: m.lines, model, model.lines | lines)


def _aim(model: Model, end: Attached | Driven, t, displacement) -> Float[Array, " d"]:
    """The direction of a clamp at t (s)."""
    if isinstance(end, Driven):
        assert end.aim is not None
        return end.aim.position(t)
    body = model.bodies[end.body]
    q = body.reference
    q = q if displacement is None else q + displacement[body_key(end.body)]
    return _direction_at(body, q, end)


def _direction_at(body: AbstractBody, q: Float[Array, " m"], end: Attached) -> Float[Array, " d"]:
    """c = R(q) c0 (-) of an end that is clamped to a body."""
    assert end.aim is not None
    return body.place(q, end.aim) - body.place(q, jnp.zeros_like(end.aim))


def swing_of(body: AbstractBody, q: Float[Array, " m"], end: Attached) -> Float[Array, "d m"]:
    """dc/dq (1, 1/rad) of an end that is clamped to a body."""
    return jax.jacfwd(lambda at: _direction_at(body, at, end))(q)


def _led(line: Line, node: int, clamp: Float[Array, " d"]) -> Line:
    """A line that leaves an end in another direction."""
    loads = tuple(
        replace(load, **{SIDES[node]: clamp}) if isinstance(load, Bending) else load
        for load in line.loads
    )
    return replace(line, loads=loads)


def clamped_to(model: Model, body: str) -> list[Clamped]:
    """The ends that are clamped to a body."""
    return [
        (name, node, end)
        for name, node, end in model.outer_ends()
        if isinstance(end, Attached) and end.body == body and end.aim is not None
    ]


def pulled_round(model: Model, at: LineEnd, shape: Shape) -> Float[Array, " d"]:
    """-dE/dc = k u (N m) at a clamp."""
    name, node = at
    bending = model.lines[name].bending
    assert bending is not None
    return bending.EI / shape.node_length[node] * shape.tangent[:, node]


def clamp_force(
    model: Model, name: str, q: Float[Array, " m"], shapes: Mapping[str, Shape] | None = None
) -> Float[Array, " m"] | None:
    """What lines that are clamped to a body turn it with at q (N m), None where none is.

    `shapes` are those of the lines by name, those of their references if None.
    """
    body, total = model.bodies[name], None
    for line, node, end in clamped_to(model, name):
        shape = model.lines[line].shape() if shapes is None else shapes[line]
        pull = pulled_round(model, (line, node), shape)
        back = jax.vjp(lambda at, end=end: _direction_at(body, at, end), q)[1]
        (force,) = back(pull)
        total = force if total is None else total + force
    return total


def clamp_power(
    model: Model, at: LineEnd, end: End, t: Float[Array, ""], shape: Shape
) -> Float[Array, ""] | None:
    """Power (W) that a line gets from what turns its clamp as it is told, None where nothing does."""
    if not isinstance(end, Driven) or end.aim is None:
        return None
    t = jnp.asarray(t)
    rate = jax.jvp(end.aim.position, (t,), (jnp.ones_like(t),))[1]
    pull = pulled_round(model, at, shape)
    return -jnp.dot(pull, rate.astype(pull.dtype))
