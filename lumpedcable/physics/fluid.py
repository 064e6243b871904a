"""Currents: the velocity of the fluid at a height."""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["AbstractCurrent", "PowerLawCurrent", "TableCurrent", "UniformCurrent"]


class AbstractCurrent(eqx.Module):
    """A steady current: velocity (m/s), shape (d, nodes), at heights z (m), shape (nodes,)."""

    @abc.abstractmethod
    def velocity(self, height: Float[Array, " nodes"]) -> Float[Array, "d nodes"]:
        """Velocity of the fluid (m/s) at each height (m)."""


class UniformCurrent(AbstractCurrent):
    """The same velocity (m/s) everywhere."""

    everywhere: Float[Array, " d"]

    def velocity(self, height: Float[Array, " nodes"]) -> Float[Array, "d nodes"]:
        """The uniform velocity (m/s)."""
        return jnp.broadcast_to(self.everywhere[:, None], (self.everywhere.shape[0], *height.shape))


class PowerLawCurrent(AbstractCurrent):
    """V ((z - z_bed) / D)^n between the bed and the surface, V above it, 0 below the bed.

    V the surface velocity (m/s), D the depth (m), z_bed = surface - D (m), n the exponent
    (Liu et al. 2018, eq. 38).
    """

    at_surface: Float[Array, " d"]
    exponent: Float[Array, ""]
    depth: Float[Array, ""]
    surface: Float[Array, ""]

    def velocity(self, height: Float[Array, " nodes"]) -> Float[Array, "d nodes"]:
        """The velocity (m/s) at each height (m)."""
        share = (height - self.surface + self.depth) / self.depth
        wet = share > 0.0
        profile = jnp.where(wet, jnp.where(wet, jnp.minimum(share, 1.0), 1.0) ** self.exponent, 0.0)
        return self.at_surface[:, None] * profile


class TableCurrent(AbstractCurrent):
    """V_0 + sum_k (V_k+1 - V_k) clip((z - z_k) / (z_k+1 - z_k), 0, 1): straight between heights z_k (m).

    The velocities V_k (m/s) at the heights, which increase; beyond them those of the first and the last.
    """

    heights: Float[Array, " K"]
    velocities: Float[Array, "d K"]

    def velocity(self, height: Float[Array, " nodes"]) -> Float[Array, "d nodes"]:
        """The velocity (m/s) at each height (m)."""
        low, step = self.heights[:-1, None], jnp.diff(self.heights)[:, None]
        shares = jnp.clip((height - low) / step, 0.0, 1.0)
        return self.velocities[:, :1] + jnp.diff(self.velocities, axis=1) @ shares
