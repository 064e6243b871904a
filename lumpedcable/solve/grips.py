"""Coulomb friction of inextensible lines on the bed, for the iterates of a step.

Rods that stick share a load in a way that no law of rigid bodies tells: so places that stick hold on to
the bed by a force f - c v that grows against any motion v along the bed from the force f of the step
before, with c = m / dt for a place of the mass m. What a constant pull moves it by dies out by 0.7 a
step, to rounding: it does not creep, and has given mu g dt^2 by then, twice that under a load that
comes at once. Where that force would exceed mu N the place slides, with mu N against its motion, until
the motion turns round.

A stiffer hold gives less, but which places stick and which slide is then not found within a few
iterates: with c = 1e4 m / dt tensions of single steps were up to hundreds of times too large, the more
the shorter the step.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.grip import grip_limit
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path
from lumpedcable.model.rods import along_path, forces_along_path, to_lines
from lumpedcable.physics.vectors import dot
from lumpedcable.physics.vectors import size as norm
from lumpedcable.solve.matrices import at_first, at_last

__all__ = [
    "Bed",
    "LineGrip",
    "bed_of",
    "first_grip",
    "next_grip",
    "on_lines",
    "remembered",
    "terms",
]


class Bed(NamedTuple):
    """What the bed offers the P places of a path in a kick: mu N (N) and unit normals.

    `hold` is c dt (kg); limits are 0 at places that have no friction.
    """

    limit: Float[Array, " P"]
    normal: Float[Array, "P d"]
    hold: Float[Array, " P"]


class LineGrip(NamedTuple):
    """What friction does to the places in one iterate: which stick, and the force (N) on the others.

    Of those that stick it is the force of the step before.
    """

    sticking: Bool[Array, " P"]
    force: Float[Array, "P d"]


def bed_of(model: Model, path: Path, t, found, before, across: Float[Array, " n"]) -> Bed | None:
    """The bed under a path whose rods have the masses `across` (kg), None where it has no friction."""
    if all(model.lines[leg.line].grip is None for leg in path.legs):
        return None
    limits, normals = {}, {}
    for leg in path.legs:
        e, grip = found[leg.line], model.lines[leg.line].grip
        assert grip is not None  # the bed is the same for all lines
        limits[leg.line] = grip_limit(model, leg.line, t, e, before[leg.line])[None]
        normals[leg.line] = jnp.broadcast_to(grip.bed.normal(e.line.shape), e.force.shape)
    once = forces_along_path(path, limits)
    limit = (at_first(once.first.T) + at_last(once.last.T))[:, 0]
    ends = along_path(path, normals)
    normal = jnp.concatenate([ends.first, ends.last[:, -1:]], axis=1).T
    mass = at_first(0.5 * across) + at_last(0.5 * across)
    return Bed(limit, normal, mass)


def first_grip(bed: Bed) -> LineGrip:
    """All that lie on the bed stick, without force."""
    return LineGrip(bed.limit > 0.0, jnp.zeros_like(bed.normal))


def _level(bed: Bed, vectors: Float[Array, "P d"]) -> Float[Array, "P d"]:
    """The parts of vectors that lie in the plane of the bed."""
    return vectors - bed.normal * dot(vectors.T, bed.normal.T)[:, None]


def terms(bed: Bed, grip: LineGrip, before: Float[Array, "P d"], dt):
    """What friction adds to the inertia (P, d, d) and to the force (P, d) of an iterate."""
    hold = jnp.where(grip.sticking, bed.hold, 0.0)
    eye = jnp.eye(bed.normal.shape[1], dtype=bed.normal.dtype)
    plane = eye - bed.normal[:, :, None] * bed.normal[:, None, :]
    force = _level(bed, grip.force) - hold[:, None] / dt * _level(bed, before)
    return hold[:, None, None] * plane, force


def next_grip(
    bed: Bed, start: LineGrip, grip: LineGrip, before: Float[Array, "P d"],
    gain: Float[Array, "P d"], dt,
) -> tuple[LineGrip, Float[Array, "P d"]]:  # fmt: skip
    """The friction of the next iterate, and the force (N) that this one used.

    `start` is that of the first iterate of the step; `gain` are the accelerations found (m/s2).
    """
    level = _level(bed, before + dt * gain)
    held = _level(bed, start.force)
    trial = held - (bed.hold / dt)[:, None] * level
    used = jnp.where(grip.sticking[:, None], trial, _level(bed, grip.force))
    size = norm(trial.T)
    full = trial * (bed.limit / jnp.where(size > 0.0, size, 1.0))[:, None]
    turned = dot(used.T, level.T) > 0.0
    sticks = jnp.where(grip.sticking, size <= bed.limit, turned) & (bed.limit > 0.0)
    return LineGrip(sticks, jnp.where(sticks[:, None], held, full)), used


def remembered(bed: Bed, grip: LineGrip, used: Float[Array, "P d"]) -> LineGrip:
    """What the next step starts from: the last force, which is at most mu N."""
    size = norm(used.T)
    within = jnp.minimum(1.0, bed.limit / jnp.where(size > 0.0, size, 1.0))
    return LineGrip(grip.sticking, used * within[:, None])


def on_lines(path: Path, used: Float[Array, "P d"]) -> dict[str, Float[Array, "d nodes"]]:
    """Forces on places by line and node (N), each once: with the line that begins there."""
    found = to_lines(path, used.T)
    for leg in path.legs[:-1]:
        last = 0 if leg.backward else -1
        found[leg.line] = found[leg.line].at[:, last].set(0.0)
    return found
