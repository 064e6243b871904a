"""What may happen at an end of a line: a known force, a known motion, or a joint; and its breaking."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.physics.afloat import BodyLift
from lumpedcable.physics.motion import AbstractMotion
from lumpedcable.physics.ramp import release_ramp
from lumpedcable.physics.tips import AFTER, BEFORE

__all__ = [
    "Attached",
    "Driven",
    "End",
    "Joined",
    "Junction",
    "Loaded",
    "Release",
    "end_name",
    "solve_small",
]

# the parts of a line that is cut are "rope-1" and "rope-2"
END_NAMES = {0: ".start", -1: ".end", BEFORE: "-1.end", AFTER: "-2.start"}


def end_name(line: str, node: int) -> str:
    """ "rope.start" for node 0 of rope, "rope.end" for -1; at its cut "rope-1.end", "rope-2.start"."""
    return f"{line}{END_NAMES[node]}"


class Release(eqx.Module):
    """A break: from `start` on (s) the force at the end decays to zero over `time` (s).

    One that begins at a `tension` (N) has a start that nobody knows before, inf until then.
    """

    start: Float[Array, ""]
    time: Float[Array, ""]
    tension: Float[Array, ""] | None = None

    def begun(self, t: Float[Array, ""]) -> Bool[Array, ""]:
        """Whether the break has begun at t (s)."""
        return t >= self.start

    def held(self, t: Float[Array, ""]) -> Float[Array, ""]:
        """Share of the force that is still held (-)."""
        return release_ramp(t, self.start, self.time)

    def carried(
        self, t: Float[Array, ""], dt: Float[Array, ""] | None, before: Float[Array, " d"],
        now: Float[Array, " d"],
    ) -> Float[Array, " d"]:  # fmt: skip
        """The force (N) at t (s) on an end that holds, `before` the step of dt (s) that ends then; once
        the break has begun, what it was when it began.

        That instant falls between steps: the last one before it goes on to it as it went, so that what
        decays depends on the instant smoothly.
        """
        force = now
        if dt is not None:
            left = (self.start - t) / dt
            share = jnp.where(left < 1.0 + 1e-9, left, 0.0)
            force = now + share.astype(now.dtype) * (now - before)
        return jnp.where(self.begun(t), before, force)


class Loaded(eqx.Module):
    """An end on which a known force acts: free (None), or held by a force (d,) in N."""

    force: Float[Array, " d"] | None = None
    release: Release | None = None

    def external(self, t: Float[Array, ""]) -> Float[Array, " d"] | None:
        """The force on the end node (N) at t (s)."""
        if self.force is None or self.release is None:
            return self.force
        return self.force * self.release.held(t).astype(self.force.dtype)


class Driven(eqx.Module):
    """An end whose motion is known, until it breaks: then the reaction that it had decays.

    `aim` is the way of the direction (d,) out of which a line with bending leaves it, None where it is
    free to turn or that direction stays as it is.
    """

    motion: AbstractMotion
    release: Release | None = None
    aim: AbstractMotion | None = None


class Joined(eqx.Module):
    """An end that shares its node with others at a junction, until it breaks away."""

    junction: int = eqx.field(static=True)
    release: Release | None = None


class Attached(eqx.Module):
    """An end tied to a point of a body, in the body's own axes (m), until it breaks away.

    `aim` (d,) is the direction in these axes out of which a line with bending leaves it, None where it
    is free to turn.
    """

    body: str = eqx.field(static=True)
    point: Float[Array, " d"]
    release: Release | None = None
    aim: Float[Array, " d"] | None = None


End = Loaded | Driven | Joined | Attached


class Junction(eqx.Module):
    """A point at which ends of lines meet, with a mass of its own or none.

    `members` names the ends, ("line", 0) for a start and ("line", -1) for an end. `mass` (kg) and
    `load` (d,), the weight less buoyancy of the point (N), are None where it is a mere joint. `lift` is
    the buoyancy of a point that may leave the water. `cut` is True where it does no more than cut one
    line of the scene into two.
    """

    members: tuple[tuple[str, int], ...] = eqx.field(static=True)
    mass: Float[Array, ""] | None = None
    load: Float[Array, " d"] | None = None
    lift: BodyLift | None = None
    cut: bool = eqx.field(static=True, default=False)


def solve_small(matrix: Float[Array, "d d"], vector: Float[Array, " d"]) -> Float[Array, " d"]:
    """Solution of a symmetric positive system of a few equations, without a library call."""
    d = vector.shape[0]
    if d == 1:
        return vector / matrix[0]
    if d == 2:
        (a, b), (c, e) = matrix
        x, y = vector
        return jnp.stack([e * x - b * y, a * y - c * x]) / (a * e - b * c)
    if d > 3:
        # one unknown less at a time
        row = matrix[0] / matrix[0, 0]
        rest = solve_small(
            matrix[1:, 1:] - jnp.outer(matrix[1:, 0], row[1:]),
            vector[1:] - matrix[1:, 0] * (vector[0] / matrix[0, 0]),
        )
        first = vector[0] / matrix[0, 0] - jnp.dot(row[1:], rest)
        return jnp.concatenate([first[None], rest])
    columns = jnp.stack(
        [jnp.cross(matrix[1], matrix[2]), jnp.cross(matrix[2], matrix[0]),
         jnp.cross(matrix[0], matrix[1])]
    )  # fmt: skip
    return columns.T @ vector / jnp.dot(matrix[0], columns[0])
