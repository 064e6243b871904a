"""What rigid bodies that are at rest bring into natural modes.

With q the coordinates of a body, lines pull at its points r(q) with F. Of small motions dq the ends
of those lines go along by J dq, J = dr/dq, and the body itself answers with

    -d/dq (Q(q) + J(q)^T F),   F held,

Q its own force at rest: weight, buoyancy, bed, springs, thrust, the drag of a current. What F changes by
is in the stiffness of the lines. Lines that are clamped to the body turn it with the moments of their
directions c(q), and these moments and the forces on the lines' last two nodes change with each other.
"""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.attached import pull_of_lines, tied_to
from lumpedcable.model.bodies import AbstractBody
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net
from lumpedcable.model.turned import (
    Clamped,
    clamp_force,
    clamped_to,
    pulled_round,
    swing_of,
)

__all__ = [
    "Clamp",
    "Floating",
    "RigidMotion",
    "floating",
    "resting",
    "rigid_motions",
]

EPS = float(np.finfo(float).eps)


class Clamp(NamedTuple):
    """A line that is clamped to a body of m coordinates: its two nodes there (2,), as places of the net.

    cross (2, d, m): second derivatives of what bends at the clamp by places of nodes and by q, in N,
    N/m; they belong to both.
    """

    nodes: tuple[int, int]
    cross: Float[Array, "2 d m"]


class Floating(NamedTuple):
    """A rigid body of m coordinates q that moves about its place of rest.

    free (m,): 1 where a coordinate can change. mass, stiffness (m, m): its own, in kg and N/m, kg m2 and
    N m, and so on. ends (e, d, m): J of the ends that are tied to it, as in `Net.tied`. outline
    (p, d) and moves (p, d, m): points by which it is drawn (m), and J of those. doubt (m,): how well the
    moments that hold it in balance are known (N m), 0 for places. clamps: of lines on it. away (m,): a
    direction in which it is held, of size 1, 0 or None where there is none. turns (m - d, 3): roll,
    pitch and yaw of its angles, None where those are a rigid body's.
    """

    free: Float[Array, " m"]
    mass: Float[Array, "m m"]
    stiffness: Float[Array, "m m"]
    ends: Float[Array, "e d m"]
    outline: Float[Array, "p d"]
    moves: Float[Array, "p d m"]
    doubt: Float[Array, " m"]
    clamps: tuple[Clamp, ...] = ()
    away: Float[Array, " m"] | None = None
    turns: Float[Array, "a 3"] | None = None

    @property
    def scale(self) -> Float[np.ndarray, " m"]:
        """What q is measured in so that all of it has one mass: 1 for a mean place, rad/m for angles."""
        mass = np.diagonal(np.asarray(self.mass))
        return np.sqrt(np.mean(mass[: np.shape(self.ends)[1]]) / mass)

    @property
    def ways(self) -> Float[np.ndarray, "m r"]:
        """The motions dq that are open to it, each of the same mass where q does not couple."""
        ways = (np.eye(np.size(self.free)) * self.scale)[:, np.asarray(self.free) > 0.0]
        if self.away is None or not np.any(self.away):
            return ways
        _, _, rows = np.linalg.svd((self.away @ ways)[None])
        return ways @ rows[1:].T


class RigidMotion(NamedTuple):
    """How a body moves in k modes, in x, y and z.

    position: at rest (3,), in m. outline: points (p, 3) at rest, in m, and shapes: how far they move,
    (k, p, 3). moved: its centre and its roll, pitch and yaw, (k, 6), in m and rad where shapes are in m.
    share: of the kinetic energy, (k,). ways: shares of that by the same six, (k, 6).
    """

    position: Float[np.ndarray, " 3"]
    outline: Float[np.ndarray, "p 3"]
    shapes: Float[np.ndarray, "k p 3"]
    moved: Float[np.ndarray, "k 6"]
    share: Float[np.ndarray, " k"]
    ways: Float[np.ndarray, "k 6"]


def floating(
    model: Model, net: Net, forces: Float[Array, "places d"],
    outlines: Mapping[str, Float[Array, "p d"]],
) -> dict[str, Floating]:  # fmt: skip
    """The bodies of which `outlines` gives points along their own axes (m), at rest as they are.

    `forces` (N) are those on all nodes of the net, also on those that are held.
    """
    return {name: _floating(model, net, name, forces, x) for name, x in outlines.items()}


def _floating(model: Model, net: Net, name: str, forces, outline) -> Floating:
    body = model.bodies[name]
    still = jnp.zeros_like(body.reference)

    def force(q):
        own = body.force(q, still) + pull_of_lines(model, net, name, forces, q)
        moment = clamp_force(model, name, q)
        return own if moment is None else own + moment

    q = body.reference
    return resting(model, net, name, forces, outline, force(q))._replace(
        stiffness=-jax.jacfwd(force)(q),
        clamps=tuple(_clamp(model, net, body, each) for each in clamped_to(model, name)),
    )


def resting(
    model: Model, net: Net, name: str, forces: Float[Array, "places d"],
    outline: Float[Array, "p d"], left: Float[Array, " m"],
) -> Floating:  # fmt: skip
    """A body on which `left` (N, N m) is what does not balance, without a stiffness of its own."""
    body, d = model.bodies[name], outline.shape[1]
    q = body.reference
    ends, pulls = tied_to(model, net, name, forces, q)
    free = jnp.ones_like(q) if body.free is None else body.free
    moment = jnp.arange(q.size) >= d
    known = jnp.einsum("edm,ed->m", jnp.abs(ends), jnp.abs(pulls))
    return Floating(
        free=free,
        mass=body.mass(q),
        stiffness=jnp.zeros((q.size, q.size)),
        ends=ends,
        outline=jax.vmap(body.place, (None, 0))(q, outline),
        moves=jax.vmap(jax.jacfwd(body.place), (None, 0))(q, outline),
        doubt=jnp.where(moment, free * (jnp.abs(left) + 8.0 * EPS * known), 0.0),
    )


def _clamp(model: Model, net: Net, body: AbstractBody, clamped: Clamped) -> Clamp:
    line, node, end = clamped
    own = model.lines[line]
    pair = (0, 1) if node == 0 else (-2, -1)

    def pull(steps):
        moved = (
            jnp.zeros_like(own.reference).at[:, pair[0]].set(steps[0]).at[:, pair[1]].set(steps[1])
        )
        return pulled_round(model, (line, node), own.shape(moved))

    # the energy is k (1 - c . u), and k u what `pull` is
    change = jax.jacfwd(pull)(jnp.zeros((2, own.dimensions)))  # (d, 2, d)
    aim = swing_of(body, body.reference, end)  # (d, m)
    nodes = net.index[line][pair[0]], net.index[line][pair[1]]
    return Clamp((int(nodes[0]), int(nodes[1])), -jnp.einsum("cke,cm->kem", change, aim))


def rigid_motions(
    bodies: Mapping[str, Floating], turned: Mapping[str, np.ndarray], energy: np.ndarray,
    scale: np.ndarray, places: Mapping[str, np.ndarray], coordinates: Coordinates,
) -> dict[str, RigidMotion]:  # fmt: skip
    """Motions of bodies for people.

    Args:
        bodies: by name.
        turned: their coordinates in each mode, (k, m).
        energy: phi . M phi of each mode (kg), (k,).
        scale: what modes are divided by, (k,).
        places: where they are at rest, (m,).
        coordinates: of the model.
    """
    d, found = coordinates.dimensions, {}
    axes = coordinates.axes
    for name, body in bodies.items():
        q = turned[name]
        turns = np.asarray(coordinates.turns() if body.turns is None else body.turns)
        shapes = np.einsum("pdm,km->kpd", np.asarray(body.moves), q) @ axes.T
        mass = np.asarray(body.mass)
        single = np.diagonal(mass) * q**2
        ways = np.concatenate([single[:, :d] @ axes.T**2, single[:, d:] @ turns**2], axis=1)
        moved = np.concatenate([q[:, :d] @ axes.T, q[:, d:] @ turns], axis=1)
        found[name] = RigidMotion(
            position=coordinates.expand(places[name][:d], 0, place=True),
            outline=coordinates.expand(np.asarray(body.outline), 1, place=True),
            shapes=shapes / scale[:, None, None],
            moved=moved / scale[:, None],
            share=np.einsum("km,mn,kn->k", q, mass, q) / energy,
            ways=ways / np.maximum(np.sum(ways, axis=1, keepdims=True), 1e-300),
        )
    return found
