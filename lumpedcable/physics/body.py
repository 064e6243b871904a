"""Forces on a body in its generalised coordinates: those that store energy and those that resist."""

import abc
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = [
    "AbstractBedFriction",
    "AbstractBodyLoad",
    "AbstractBodyResistance",
    "BodyWeight",
    "HeldFriction",
]


class AbstractBodyLoad(eqx.Module):
    """A conservative load on a body: its energy, from which its force follows."""

    energy_name: ClassVar[str]  # the name of the dataset that this load's energy is added to

    @abc.abstractmethod
    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Potential energy (J) at the coordinates q (m, rad), up to a constant."""

    def force(self, q: Float[Array, " m"]) -> Float[Array, " m"]:
        """Generalised force -dE/dq (N, N m)."""
        return -jax.grad(self.energy)(q)

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """The largest stiffness that it may have (N/m, N m/rad), for the step: as a rule that at q."""
        return jax.hessian(self.energy)(q)


class AbstractBodyResistance(eqx.Module):
    """A force against the motion of a body.

    The power -f . v that it takes is booked as the work `work_name`, a key of `model.energy.WORKS`.
    """

    work_name: ClassVar[str]

    @abc.abstractmethod
    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Generalised force (N, N m) at the coordinates q (m, rad) and their rates v.

        `t` (s) is the time, None at rest, where there are no waves.
        """

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"] | None:
        """The most that it damps with (N s/m, N m s/rad), for the step; None where that is little."""
        return None


class BodyWeight(AbstractBodyLoad):
    """A constant force (N), shape (d,), at the centre of gravity: weight less buoyancy."""

    energy_name: ClassVar[str] = "gravitational"
    weight: Float[Array, " d"]

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """-w . x (J)."""
        return -jnp.dot(self.weight, q[: self.weight.shape[0]])


class AbstractBedFriction(eqx.Module):
    """Coulomb friction of a body on a bed: |f| <= mu N, and mu N against the motion if it slides.

    `coefficient` is mu (-), `up` the vertical, N (N) what the bed pushes up with.
    """

    coefficient: eqx.AbstractVar[Float[Array, ""]]
    up: eqx.AbstractVar[Float[Array, " d"]]

    def level(self, like: Float[Array, " m"]) -> Float[Array, " m"]:
        """1 for the coordinates in which the body slides, of as many as `like` has."""
        level = (jnp.abs(self.up) < 0.5).astype(like.dtype)
        return jnp.pad(level, (0, like.shape[0] - level.shape[0]))

    @abc.abstractmethod
    def limit(
        self, force: Float[Array, " m"], q: Float[Array, " m"], v: Float[Array, " m"]
    ) -> Float[Array, ""]:
        """mu N (N) at q and v; `force` (N, N m) is what holds those coordinates that are held."""


class HeldFriction(AbstractBedFriction):
    """Friction of a body whose height is held.

    N is all that holds it, so that a line that pulls up takes from it (Liu et al. 2018, eq. 36-37).
    """

    coefficient: Float[Array, ""]
    up: Float[Array, " d"]

    def limit(
        self, force: Float[Array, " m"], q: Float[Array, " m"], v: Float[Array, " m"]
    ) -> Float[Array, ""]:
        """mu N (N)."""
        up = jnp.pad(self.up, (0, force.shape[0] - self.up.shape[0]))
        return self.coefficient * jnp.maximum(jnp.dot(up, force), 0.0)
