"""A line that cannot push: any law, cut where it would turn to compression."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.tension.base import AbstractTensionLaw, strain_at

__all__ = ["TensionOnly"]


class TensionOnly(AbstractTensionLaw):
    """T(e) = law(e) above the slack strain e_s, and 0 at and below it, where law(e_s) = 0.

    Rope and chain buckle under the smallest compression; this law says so. U(e) = integral of T
    from e_s (J/m). The derivative at e_s is one-sided.
    """

    stays_slack: ClassVar[bool] = True

    law: AbstractTensionLaw
    slack_strain: Float[Array, ""]

    def __init__(self, law: AbstractTensionLaw, max_strain: Float[Array, ""]):
        self.law = law
        self.slack_strain = strain_at(law, jnp.zeros_like(jnp.asarray(max_strain)), max_strain)

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """max(law(e), 0) (N) for e > e_s, else 0."""
        pull = jnp.maximum(self.law.tension(strain), 0.0)
        if self.law.stays_slack:
            return pull
        # a law that turns back up in compression would pull on a slack line
        return jnp.where(strain > self.slack_strain, pull, 0.0)

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """U(max(e, e_s)) - U(e_s) of the law underneath (J/m)."""
        taut = jnp.maximum(strain, self.slack_strain)
        return self.law.energy(taut) - self.law.energy(self.slack_strain)
