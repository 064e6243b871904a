"""The interface of a tension law, and what can be derived from any law without knowing it."""

import abc
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.bisection import bisected

__all__ = [
    "AbstractTensionLaw",
    "stiffness",
    "stiffness_bound",
    "strain_at",
    "tension_and_stiffness",
]


class AbstractTensionLaw(eqx.Module):
    """Tension T (N) and stored energy U (J per metre of unstretched length) of a strain e (-).

    The strain is e = (l - l0) / l0 with l the length and l0 the unstretched length of a segment (m).
    A law is written for one strain and used on arrays of them; its derivative is taken by automatic
    differentiation. A new law is one such class and one line in `lumpedcable.model.materials`.

    `stays_slack` says that below the strain at which T = 0 there is none with T > 0: then the sign
    of T alone tells where a line that cannot push is slack.
    """

    stays_slack: ClassVar[bool] = False

    @abc.abstractmethod
    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """Tension (N) at each strain (-)."""

    @abc.abstractmethod
    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """Energy U(e) = integral of T from 0 to e (J/m), per metre of unstretched length."""


def tension_and_stiffness(
    law: AbstractTensionLaw, strain: Float[Array, "..."]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Tension T (N) and tangent stiffness dT/de (N) at each strain (-), in one evaluation."""
    return jax.jvp(law.tension, (strain,), (jnp.ones_like(strain),))


def stiffness(law: AbstractTensionLaw, strain: Float[Array, "..."]) -> Float[Array, "..."]:
    """Tangent stiffness dT/de (N) at each strain (-); the wave speed is c = sqrt(dT/de / m)."""
    return tension_and_stiffness(law, strain)[1]


def strain_at(
    law: AbstractTensionLaw, tension: Float[Array, "..."], max_strain: Float[Array, ""]
) -> Float[Array, "..."]:
    """The strain (-) at which the law carries a tension (N), by bisection.

    Looked for is the one up to max_strain, down to 0 or, for a tension below the law's at 0, down
    to -1; between these the law must not decrease with strain. A last Newton step, in which only
    the law and the tension are differentiated, gives the result its exact first derivative
    (implicit function theorem).
    Beyond the law's reach the result is an end of the interval: check the tension it gives.
    """
    tension = jnp.asarray(tension)
    low = jnp.where(law.tension(jnp.zeros_like(tension)) <= tension, 0.0, -1.0)
    high = jnp.broadcast_to(max_strain, tension.shape).astype(tension.dtype)
    low, high = bisected(lambda strain: law.tension(strain) < tension, low, high, 60)
    strain = 0.5 * (low + high)
    value, slope = tension_and_stiffness(law, strain)
    slope = jax.lax.stop_gradient(slope)
    flat = slope <= 0.0
    return strain - jnp.where(flat, 0.0, (value - tension) / jnp.where(flat, 1.0, slope))


def stiffness_bound(
    law: AbstractTensionLaw, max_strain: Float[Array, ""], samples: int = 2049
) -> Float[Array, ""]:
    """Largest stiffness (N) that waves can meet on [-max_strain, max_strain], by sampling.

    Both the axial stiffness dT/de and the geometric stiffness T / (1 + e) of a taut segment count:
    along the line and across it a segment is a spring of these stiffnesses over its length.
    """
    strain = jnp.linspace(-1.0, 1.0, samples) * jnp.minimum(max_strain, 0.95)
    strain = jnp.where(strain > 0.0, jnp.linspace(-1.0, 1.0, samples) * max_strain, strain)
    tension, slope = tension_and_stiffness(law, strain)
    return jnp.maximum(jnp.max(slope), jnp.max(tension / (1.0 + strain)))
