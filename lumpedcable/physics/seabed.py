"""A bed that lines rest on: an elastic foundation that pushes and does not pull, and its friction."""

import abc
from typing import ClassVar, Protocol

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.curve import MonotoneCubic
from lumpedcable.physics.load import AbstractLoad, AbstractResistance, Shape
from lumpedcable.physics.vectors import dot

__all__ = ["AbstractSeabed", "BedGrip", "Lying", "Seabed", "SeabedDamping", "SlopingSeabed"]


class Lying(Protocol):
    """What may lie on a bed: positions (d, nodes) m, and the length of line (m) that each stands for."""

    @property
    def position(self) -> Float[Array, "d nodes"]:
        """Where each node is (m)."""
        ...

    @property
    def node_length(self) -> Float[Array, " nodes"]:
        """How much of a line each node stands for (m)."""
        ...


class AbstractSeabed(AbstractLoad):
    """A force k s(p) per metre of unstretched length at the penetration p (m) of a node.

    p is how deep the node is under the bed, measured upright, k the stiffness of the bed (N/m per m
    of line, Pa). The sink

        s(p) = 0 for p <= 0,   p^2 / (2 b) for 0 < p < b,   p - b/2 beyond (m)

    has a continuous slope, the contact s'(p) from 0 to 1 (-): contact takes hold over the depth b
    (m), so that statics by Newton's method, damping and derivatives meet no jump. E = sum k l S(p)
    with S' = s and l the nodes' lengths; the force is -dE/dx. A Winkler foundation; the blend is a
    choice of ours.
    """

    energy_name: ClassVar[str] = "seabed"
    up: eqx.AbstractVar[Float[Array, " d"]]
    stiffness: eqx.AbstractVar[Float[Array, ""]]
    blend: eqx.AbstractVar[Float[Array, ""]]

    @abc.abstractmethod
    def level(self, position: Float[Array, "d *nodes"]) -> Float[Array, "*#nodes"]:
        """Height of the bed (m) under positions, over the origin of the scene's own coordinates."""

    def penetration(self, shape: Lying) -> Float[Array, " nodes"]:
        """p of each node (m), negative above the bed."""
        return self.level(shape.position) - self.up @ shape.position

    @abc.abstractmethod
    def normal(self, shape: Lying) -> Float[Array, "d nodes"]:
        """Unit normals of the bed under each node, (d, 1) where they are all the same."""

    def contact(self, shape: Lying) -> Float[Array, " nodes"]:
        """s'(p) of each node (-): 0 above the bed, 1 where it carries fully."""
        return jnp.clip(self.penetration(shape) / self.blend, 0.0, 1.0)

    def lift(self, shape: Lying) -> Float[Array, " nodes"]:
        """Upward force k l s(p) on each node (N)."""
        p = self.penetration(shape)
        q = jnp.clip(p, 0.0, self.blend)
        return self.stiffness * shape.node_length * q * (p - 0.5 * q) / self.blend

    @abc.abstractmethod
    def push(self, shape: Lying) -> Float[Array, " nodes"]:
        """Force on each node (N) along the normal, whose upward part is `lift`."""

    def force(self, shape: Lying) -> Float[Array, "d nodes"]:
        """Force on each node (N)."""
        return self.normal(shape) * self.push(shape)

    def energy(self, shape: Lying) -> Float[Array, ""]:
        """k l S(p) summed over the nodes (J)."""
        p = self.penetration(shape)
        q = jnp.clip(p, 0.0, self.blend)
        stored = q**3 / (6.0 * self.blend) + 0.5 * jnp.maximum(p - q, 0.0) * p
        return jnp.sum(self.stiffness * shape.node_length * stored)


class Seabed(AbstractSeabed):
    """A flat bed: p = h - up . x, h its height over the origin of the scene's own coordinates (m).

    `up` is the vertical unit vector.
    """

    up: Float[Array, " d"]
    height: Float[Array, ""]
    stiffness: Float[Array, ""]
    blend: Float[Array, ""]

    def level(self, position: Float[Array, "d *nodes"]) -> Float[Array, "*#nodes"]:
        """Its height (m), the same everywhere."""
        return self.height

    def normal(self, shape: Lying) -> Float[Array, "d nodes"]:
        """The vertical."""
        return self.up[:, None]

    def push(self, shape: Lying) -> Float[Array, " nodes"]:
        """Upward force on each node (N)."""
        return self.lift(shape)

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """k / m (1/s2): a node that bounces on the bed."""
        return jnp.broadcast_to(self.stiffness / mass, jnp.shape(segment_length))


class SlopingSeabed(AbstractSeabed):
    """A bed that is d(x) deep (m) under the height h: p = h - d(x) - up . r, the same across x.

    `across` is the unit vector of x and `origin` the x of the scene's own origin (m), so that
    x = origin + across . r. With d' the slope of the profile the force on a node is k l s(p) upwards
    and k l s(p) d' along x: along the bed's normal, of size k l s(p) sqrt(1 + d'^2).
    """

    up: Float[Array, " d"]
    height: Float[Array, ""]
    stiffness: Float[Array, ""]
    blend: Float[Array, ""]
    across: Float[Array, " d"]
    origin: Float[Array, ""]
    depth: MonotoneCubic

    def x_of(self, position: Float[Array, "d *nodes"]) -> Float[Array, "*nodes"]:
        """x of positions (m)."""
        return self.origin + self.across @ position

    def level(self, position: Float[Array, "d *nodes"]) -> Float[Array, "*nodes"]:
        """Height of the bed (m) under positions, over the origin of the scene's own coordinates."""
        return self.height - self.depth.value(self.x_of(position))

    def normal(self, shape: Lying) -> Float[Array, "d nodes"]:
        """Unit normals of the bed under each node."""
        slope = self.depth.slope(self.x_of(shape.position))
        whole = self.up[:, None] + self.across[:, None] * slope
        return whole / jnp.sqrt(1.0 + slope**2)

    def push(self, shape: Lying) -> Float[Array, " nodes"]:
        """Force on each node (N) along the bed's normal."""
        return self.lift(shape) * jnp.sqrt(1.0 + self.depth.slope(self.x_of(shape.position)) ** 2)

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """k (1 + d'^2) / m (1/s2); no slope of a cubic is over 1.5 times its secant."""
        steepest = 1.5 * jnp.max(jnp.abs(jnp.diff(self.depth.y) / jnp.diff(self.depth.x)))
        square = self.stiffness * (1.0 + steepest**2) / mass
        return jnp.broadcast_to(square, jnp.shape(segment_length))


class SeabedDamping(AbstractResistance):
    """A force -c s'(p) w per metre of unstretched length on a node in contact, along the bed's normal.

    w is its speed along the normal (m/s), c the damping of the bed (N s/m per m of line, Pa s) and
    s'(p) the contact of `bed` (-). Spring and damper together never pull: the bed lets go of a node
    that leaves faster than the ground springs back.
    """

    work_name: ClassVar[str] = "contact"
    bed: AbstractSeabed
    damping: Float[Array, ""]

    def push(self, shape: Lying, velocity: Float[Array, "d nodes"]) -> Float[Array, " nodes"]:
        """Force on each node (N) along the normal."""
        rising = dot(self.bed.normal(shape), velocity)
        plain = -self.damping * shape.node_length * self.bed.contact(shape) * rising
        return jnp.maximum(plain, -self.bed.push(shape))

    def force(self, shape: Shape, velocity: Float[Array, "d nodes"]) -> Float[Array, "d nodes"]:
        """Force on each node (N)."""
        return self.bed.normal(shape) * self.push(shape, velocity)

    def rate(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """c / m (1/s)."""
        return jnp.broadcast_to(self.damping / mass, jnp.shape(segment_length))


class BedGrip(eqx.Module):
    """Coulomb friction of a line on the bed: |f| <= mu N at a node that stands, mu N if it slides.

    N is all that the bed pushes the node with (N), its damping included; f lies in the plane of the
    bed. `coefficient` is mu (-).
    """

    coefficient: Float[Array, ""]
    bed: AbstractSeabed
    damping: SeabedDamping | None

    def limit(self, shape: Lying, velocity: Float[Array, "d nodes"]) -> Float[Array, " nodes"]:
        """mu N of each node (N)."""
        push = self.bed.push(shape)
        if self.damping is not None:
            push = push + self.damping.push(shape, velocity)
        return self.coefficient * push
