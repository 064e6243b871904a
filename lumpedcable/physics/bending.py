"""Bending stiffness of a line without torsion."""

from typing import ClassVar, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import AbstractLoad, Shape, between_nodes
from lumpedcable.physics.vectors import dot, size

__all__ = ["Bending", "Side", "bent", "moment_across", "softness", "upright"]


class Bending(AbstractLoad):
    """Shear forces from bending, as the gradient of a discrete bending energy.

    At an inner node i, between the tangents u_i and u_i+1 of its segments (unstretched lengths
    l_i, l_i+1, node length s_i = (l_i + l_i+1) / 2),

        E_i = (EI / s_i) (1 - u_i . u_i+1)  (J),  EI in N m2,

    the energy EI kappa^2 s / 2 of the curvature kappa = 2 sin(theta / 2) / s. The shear force of a
    segment of length L between nodes i and i+1 is Q = -(I - u u^T) (EI/s_i u_- + EI/s_i+1 u_+) / L
    with u_-, u_+ the neighbours' tangents: for small angles between segments this is -dM/ds x tau,
    M = EI tau x dtau/ds. Zhu, Yin & Shen (2018), eq. 3, call dM/ds x tau the shear and take its
    difference with a minus: the force on a node is the same.

    An end is free to turn where `start` or `end` is None. Else it is clamped to that tangent (d,),
    which stands for the neighbour's: E_0 = (EI / s_0) (1 - t . u_1), where s_0 = l_1 / 2 is the
    distance from the wall to the middle of the segment. The deflection of a cantilever under
    uniform load is then high by (l / L)^2.
    """

    energy_name: ClassVar[str] = "bending"
    EI: Float[Array, ""]
    start: Float[Array, " d"] | None = None
    end: Float[Array, " d"] | None = None

    def force(self, shape: Shape) -> Float[Array, "d nodes"]:
        """Force on each node (N), the difference of its neighbours' shears."""
        return between_nodes(self.shear(shape))[0]

    def shear(self, shape: Shape) -> Float[Array, "d segments"]:
        """Shear Q (N) of each segment: +Q acts on its start node, -Q on its end node."""
        tangent = shape.tangent
        pull = self.EI / shape.node_length
        none = jnp.zeros_like(tangent[:, :1])
        first = none if self.start is None else pull[0] * self.start[:, None]
        last = none if self.end is None else pull[-1] * self.end[:, None]
        from_left = jnp.concatenate([first, pull[1:-1] * tangent[:, :-1]], axis=1)
        from_right = jnp.concatenate([pull[1:-1] * tangent[:, 1:], last], axis=1)
        moment = from_left + from_right
        return _shear(tangent, moment, shape.length)

    def energy(self, shape: Shape) -> Float[Array, ""]:
        """Bending energy of the line (J)."""
        tangent, pull = shape.tangent, self.EI / shape.node_length
        total = jnp.sum(pull[1:-1] * _apart(tangent[:, 1:], tangent[:, :-1]))
        if self.start is not None:
            total = total + pull[0] * _apart(self.start, tangent[:, 0])
        if self.end is not None:
            total = total + pull[-1] * _apart(self.end, tangent[:, -1])
        return total

    def moment(self, shape: Shape) -> Float[Array, " nodes"]:
        """Size of the bending moment (N m) at each node, 0 at an end that is free to turn.

        M = dE/dtheta = EI sin(theta) / s, theta the angle between the directions that meet there: the
        couple that the two sides put on each other, at rest in balance with the loads on either.
        """
        tangent, pull = shape.tangent, self.EI / shape.node_length
        free = jnp.zeros_like(pull[:1])
        first = free if self.start is None else self._at_clamp(0, self.start, shape)
        last = free if self.end is None else self._at_clamp(-1, self.end, shape)
        inner = pull[1:-1] * _turn(tangent[:, :-1], tangent[:, 1:])
        return jnp.concatenate([first, inner, last])

    def _at_clamp(self, end: int, clamp: Float[Array, " d"], shape: Shape) -> Float[Array, " 1"]:
        turn = _turn(clamp, shape.tangent[:, end])
        return (self.EI / shape.node_length[end] * turn)[None]

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """16 EI / (m l^4) (1/s2): the zigzag mode of a beam of lumps; clamps stay below it."""
        return 16.0 * self.EI / (mass * segment_length**4)


class Side(NamedTuple):
    """A line that bends over the node at its start (`node` 0) or end (-1): its EI (N m2), its shape."""

    EI: Float[Array, ""]
    shape: Shape
    node: int

    @property
    def out(self) -> Float[Array, " d"]:
        """The direction in which the line leaves the node (-)."""
        tangent = pick(self.shape.tangent, self.node)
        return tangent if self.node == 0 else -tangent


def bent(one: Side, other: Side) -> tuple[Float[Array, ""], tuple[Float[Array, "d 2"], ...]]:
    """Bending at a node where two lines meet, as at an inner node of a line.

    With EI constant along either half of the node's length, s_1 and s_2, the moment turns the one by
    M s_1 / EI_1 and the other by M s_2 / EI_2, so that

        E = k (1 - u . w)  (J),  1 / k = s_1 / EI_1 + s_2 / EI_2  (1/(N m)),

    u the direction into the node along the one and w that out of it along the other.

    Returns:
        The energy (J), and the forces (N) on the node and on the next one, of either line in the order
        of its nodes: a couple.
    """
    pull, u, w = _meeting(one, other)
    couples = []
    # each is turned so that it goes on straight from where the other comes
    for side, way, towards in ((one, -u, -w), (other, w, u)):
        shear = _shear(way, pull * towards, pick(side.shape.length, side.node))
        order = (shear, -shear) if side.node == 0 else (-shear, shear)
        couples.append(jnp.stack(order, axis=1))
    return pull * _apart(u, w), tuple(couples)


def moment_across(one: Side, other: Side) -> Float[Array, ""]:
    """Size of the bending moment (N m) at the node of `bent`."""
    pull, u, w = _meeting(one, other)
    return pull * _turn(u, w)


def upright(one: Side, other: Side) -> Float[Array, ""]:
    """k u . w (N m) of `bent`: what resists a small turn, below 0 where that goes on by itself."""
    pull, u, w = _meeting(one, other)
    return pull * dot(u, w)


def softness(one: Side, other: Side) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """The shares (-) of 1/k of `bent` that are s_1 / EI_1 and s_2 / EI_2.

    Of a line whose segments grow with its length L, d(ln k)/d(ln L) is minus its share.
    """
    first, second = _soft(one), _soft(other)
    return first / (first + second), second / (first + second)


def _soft(side: Side) -> Float[Array, ""]:
    """s / EI (1/(N m))."""
    return pick(side.shape.node_length, side.node) / side.EI


def _meeting(one: Side, other: Side):
    """k (N m) of `bent`, the direction into the node along the one, and out of it along the other."""
    return 1.0 / (_soft(one) + _soft(other)), -one.out, other.out


def _turn(u: Float[Array, "d *n"], w: Float[Array, "d *n"]) -> Float[Array, "*n"]:
    """sin(theta) = |w - u| |w + u| / 2 between unit vectors, whose digits a small angle keeps."""
    return 0.5 * size(w - u) * size(w + u)


def _apart(u: Float[Array, "d *n"], w: Float[Array, "d *n"]) -> Float[Array, "*n"]:
    """1 - u . w = |w - u|^2 / 2 of unit vectors, whose digits a small angle keeps."""
    return 0.5 * dot(w - u, w - u)


def _shear(tangent, moment, length):
    """Q (N) of segments whose neighbours pull with EI/s times their tangents, summed up to `moment`."""
    across = moment - tangent * dot(tangent, moment)
    # turning a segment towards its neighbours' directions lowers the energy
    return -across / length
