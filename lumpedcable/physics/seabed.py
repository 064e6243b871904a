"""A flat bed that lines rest on: an elastic foundation that pushes and does not pull."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.load import AbstractLoad, AbstractResistance, Shape

__all__ = ["Seabed", "SeabedDamping"]


class Seabed(AbstractLoad):
    """An upward force k s(p) per metre of unstretched length at the penetration p (m) of a node.

    p = h - up . x, with h the height of the bed over the origin of the scene's own coordinates (m)
    and `up` the vertical unit vector; k the stiffness of the bed (N/m per m of line, Pa). The sink

        s(p) = 0 for p <= 0,   p^2 / (2 b) for 0 < p < b,   p - b/2 beyond (m)

    has a continuous slope, the contact s'(p) from 0 to 1 (-): contact takes hold over the depth b
    (m), so that statics by Newton's method, damping and derivatives meet no jump. E = sum k l S(p)
    with S' = s and l the nodes' lengths. A Winkler foundation; the blend is a choice of ours.
    """

    energy_name: ClassVar[str] = "seabed"
    up: Float[Array, " d"]
    height: Float[Array, ""]
    stiffness: Float[Array, ""]
    blend: Float[Array, ""]

    def penetration(self, shape: Shape) -> Float[Array, " nodes"]:
        """p of each node (m), negative above the bed."""
        return self.height - self.up @ shape.position

    def contact(self, shape: Shape) -> Float[Array, " nodes"]:
        """s'(p) of each node (-): 0 above the bed, 1 where it carries fully."""
        return jnp.clip(self.penetration(shape) / self.blend, 0.0, 1.0)

    def push(self, shape: Shape) -> Float[Array, " nodes"]:
        """Upward force k l s(p) on each node (N)."""
        p = self.penetration(shape)
        q = jnp.clip(p, 0.0, self.blend)
        return self.stiffness * shape.node_length * q * (p - 0.5 * q) / self.blend

    def force(self, shape: Shape) -> Float[Array, "d nodes"]:
        """Force on each node (N), upwards."""
        return self.up[:, None] * self.push(shape)

    def energy(self, shape: Shape) -> Float[Array, ""]:
        """k l S(p) summed over the nodes (J)."""
        p = self.penetration(shape)
        q = jnp.clip(p, 0.0, self.blend)
        stored = q**3 / (6.0 * self.blend) + 0.5 * jnp.maximum(p - q, 0.0) * p
        return jnp.sum(self.stiffness * shape.node_length * stored)

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """k / m (1/s2): a node that bounces on the bed."""
        return jnp.broadcast_to(self.stiffness / mass, jnp.shape(segment_length))


class SeabedDamping(AbstractResistance):
    """A vertical force -c s'(p) w per metre of unstretched length on a node that is in contact.

    w is its upward speed (m/s), c the damping of the bed (N s/m per m of line, Pa s) and s'(p) the
    contact of `bed` (-). Spring and damper together never pull: the bed lets go of a node that
    leaves faster than the ground springs back.
    """

    work_name: ClassVar[str] = "contact"
    bed: Seabed
    damping: Float[Array, ""]

    def force(self, shape: Shape, velocity: Float[Array, "d nodes"]) -> Float[Array, "d nodes"]:
        """Force on each node (N)."""
        rising = self.bed.up @ velocity
        plain = -self.damping * shape.node_length * self.bed.contact(shape) * rising
        return self.bed.up[:, None] * jnp.maximum(plain, -self.bed.push(shape))

    def rate(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """c / m (1/s)."""
        return jnp.broadcast_to(self.damping / mass, jnp.shape(segment_length))
