"""A model linearised about its reference: stiffness and masses, from the residual that statics has."""

from collections.abc import Mapping
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.line import node_tangent
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net, make_net
from lumpedcable.physics.rod import ROD_SHARES
from lumpedcable.physics.tension import tension_and_stiffness
from lumpedcable.solve.blocks import BlockTridiagonal, block_jacobian
from lumpedcable.solve.carried import dimensions_of, is_carried
from lumpedcable.solve.modal_bodies import Floating, floating
from lumpedcable.solve.modal_carried import carried_motion
from lumpedcable.solve.modal_rods import Rods, rods_of, with_known_tensions
from lumpedcable.solve.statics import forces_at_rest

__all__ = ["Linear", "Stiffness", "linearised", "stiffness_of"]

Stiffness = BlockTridiagonal | Float[Array, "n n"]

EPS = float(np.finfo(float).eps)


class Linear(NamedTuple):
    """A model linearised about its reference, in the order of `make_net(model)`.

    stiffness: K (N/m) by blocks of the net, held nodes included; with trolleys or winches the whole
    (n, n) of places and bodies, as in `Carried`. mass: of every place (places, d, d), in
    kg. points: the part of it that is point masses (places,), in kg. frames: tangents and masses of the
    lines' own nodes, or of their rods. reference: their places (d, nodes) in m, in the model's
    coordinates. doubt: what rounding of the places leaves uncertain of each segment's tension over
    its length (n,), in N/m. bodies: rigid bodies and trolleys that move, by name; places: their
    coordinates at rest. winches: what they have paid out moves. rolling: as in `Carried`.
    """

    stiffness: Stiffness
    mass: Float[Array, "places d d"]
    points: Float[Array, " places"]
    frames: dict[str, inertia.Frame | Rods]
    reference: dict[str, Float[Array, "d nodes"]]
    doubt: dict[str, Float[Array, " n"]]
    bodies: dict[str, Floating]
    places: dict[str, Float[Array, " m"]]
    winches: dict[str, Floating]
    rolling: dict[str, Float[Array, ""]]

    @property
    def movers(self) -> dict[str, Floating]:
        """Everything beside nodes that moves, in the order of the coordinates."""
        return self.bodies | self.winches


def linearised(model: Model, outlines: Mapping[str, Float[Array, "p d"]] | None = None) -> Linear:
    """K = -dF/dx and M of a model at its reference, with 3 b directional derivatives of F.

    `outlines` are points (m) of the rigid bodies that move, along their own axes, by which they are
    drawn; others are held.
    """
    net = make_net(model)
    d = dimensions_of(model)
    known = with_known_tensions(model)
    outlines = outlines or {}
    if is_carried(model):
        stiffness, bodies, winches, rolling = carried_motion(known, net, outlines)
    else:
        still, stiffness = _resistance(known, net)
        bodies = floating(model, net, still, outlines)
        winches, rolling = {}, {}
    points = jnp.zeros(net.size)
    for junction in model.junctions:
        if junction.mass is not None:
            name, node = junction.members[0]
            points = points.at[int(net.index[name][node])].add(junction.mass)
    mass = points[:, None, None] * jnp.eye(d)
    frames, doubt = {}, {}
    for name, line in model.lines.items():
        shape = line.shape()
        if line.inextensible:
            frames[name] = rods = rods_of(line, shape)
            for end in (net.index[name][:-1], net.index[name][1:]):
                mass = mass.at[end].add(ROD_SHARES[0] * rods.whole)
        else:
            nodes = inertia.frame(line, shape, None)
            mass_n = nodes.mass_t if nodes.tangent is None else nodes.mass_n
            nodes = nodes._replace(tangent=node_tangent(shape.tangent), mass_n=mass_n)
            mass = mass.at[net.index[name]].add(_nodal_masses(nodes, d))
            frames[name] = nodes
        _, stiff = tension_and_stiffness(line.law, shape.strain)
        far = jnp.max(jnp.abs(line.reference))
        doubt[name] = 8.0 * EPS * jnp.abs(stiff) * (1.0 + far / shape.length) / shape.length
    return Linear(
        stiffness=stiffness,
        mass=mass,
        points=points,
        frames=frames,
        reference={name: line.reference for name, line in model.lines.items()},
        doubt=doubt,
        bodies=bodies,
        places={name: model.bodies[name].reference for name in bodies},
        winches=winches,
        rolling=rolling,
    )


def stiffness_of(model: Model, outlines: Mapping[str, Float[Array, "p d"]]) -> Stiffness:
    """K of a model at its reference alone, as in `Linear`."""
    net, known = make_net(model), with_known_tensions(model)
    if is_carried(model):
        return carried_motion(known, net, outlines).stiffness
    return _resistance(known, net)[1]


def _resistance(model: Model, net: Net) -> tuple[Float[Array, "places d"], BlockTridiagonal]:
    """Net force (N) on every place at rest, without what holds it, and K (N/m) by blocks of the net."""
    d = dimensions_of(model)
    blocks = (net.size // net.width, net.width * d)

    def force(x):
        return forces_at_rest(model, x.reshape(net.size, d), net).reshape(blocks)

    still, (lower, diagonal, upper) = block_jacobian(force, jnp.zeros(blocks))
    return still.reshape(net.size, d), (-lower, -diagonal, -upper)


def _nodal_masses(nodes: inertia.Frame, d: int) -> Float[Array, "nodes d d"]:
    """m_t t t^T + m_n (I - t t^T) of each node (kg)."""
    assert nodes.tangent is not None
    along = nodes.tangent.T[:, :, None] * nodes.tangent.T[:, None, :]
    extra = (nodes.mass_t - nodes.mass_n)[:, None, None]
    return nodes.mass_n[:, None, None] * jnp.eye(d) + extra * along
