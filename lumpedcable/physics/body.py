"""Forces on a body in its generalised coordinates: those that store energy and those that resist."""

import abc
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["AbstractBodyLoad", "AbstractBodyResistance", "BedFriction", "BodyWeight"]


class AbstractBodyLoad(eqx.Module):
    """A conservative load on a body: its energy, from which its force follows."""

    energy_name: ClassVar[str]  # the name of the dataset that this load's energy is added to

    @abc.abstractmethod
    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Potential energy (J) at the coordinates q (m, rad), up to a constant."""

    def force(self, q: Float[Array, " m"]) -> Float[Array, " m"]:
        """Generalised force -dE/dq (N, N m)."""
        return -jax.grad(self.energy)(q)


class AbstractBodyResistance(eqx.Module):
    """A force against the motion of a body.

    The power -f . v that it takes is booked as the work `work_name`, a key of `model.energy.WORKS`.
    """

    work_name: ClassVar[str]

    @abc.abstractmethod
    def force(self, q: Float[Array, " m"], v: Float[Array, " m"]) -> Float[Array, " m"]:
        """Generalised force (N, N m) at the coordinates q (m, rad) and their rates v."""


class BodyWeight(AbstractBodyLoad):
    """A constant force (N), shape (d,), at the centre of gravity: weight less buoyancy."""

    energy_name: ClassVar[str] = "gravitational"
    weight: Float[Array, " d"]

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """-w . x (J)."""
        return -jnp.dot(self.weight, q[: self.weight.shape[0]])


class BedFriction(eqx.Module):
    """Coulomb friction of a body on a bed: |f| <= mu N, and mu N against the motion if it slides.

    N is what the bed pushes up with (N): all that holds the body's height, so that a line that pulls
    up takes from it (Liu et al. 2018, eq. 36-37). `coefficient` is mu (-), `up` the vertical.
    """

    coefficient: Float[Array, ""]
    up: Float[Array, " d"]

    def level(self, like: Float[Array, " m"]) -> Float[Array, " m"]:
        """1 for the coordinates in which the body slides, of as many as `like` has."""
        level = (jnp.abs(self.up) < 0.5).astype(like.dtype)
        return jnp.pad(level, (0, like.shape[0] - level.shape[0]))

    def limit(self, force: Float[Array, " m"]) -> Float[Array, ""]:
        """mu N (N) from the force (N) that holds the body up, by coordinates."""
        up = jnp.pad(self.up, (0, force.shape[0] - self.up.shape[0]))
        return self.coefficient * jnp.maximum(jnp.dot(up, force), 0.0)
