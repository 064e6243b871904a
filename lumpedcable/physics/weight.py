"""Weight in vacuum or, where a fluid carries part of it, in the fluid."""

import math
from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.load import AbstractLoad, Shape

__all__ = ["Weight", "buoyancy_per_length"]


def buoyancy_per_length(
    density: Float[Array, ""], gravity: Float[Array, ""], diameter: Float[Array, ""]
) -> Float[Array, ""]:
    """rho g pi d^2 / 4 (N/m), rho the fluid's density (kg/m3), d the line's diameter (m).

    Archimedes per metre of unstretched length: the line keeps its volume when it stretches.
    """
    return density * gravity * 0.25 * math.pi * diameter**2


class Weight(AbstractLoad):
    """A constant load on a line, `per_length` (N per metre of unstretched length), shape (d,).

    w = m g - rho g pi d^2 / 4 along gravity; each node carries w times its length. E = -sum w . x.
    """

    energy_name: ClassVar[str] = "gravitational"
    per_length: Float[Array, " d"]

    def force(self, shape: Shape) -> Float[Array, "d nodes"]:
        """Load on each node (N)."""
        return self.per_length[:, None] * shape.node_length

    def energy(self, shape: Shape) -> Float[Array, ""]:
        """-sum over nodes of w l . x (J)."""
        return -jnp.sum(self.force(shape) * shape.position)

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """Zero: a constant force has no stiffness."""
        return jnp.zeros_like(segment_length)
