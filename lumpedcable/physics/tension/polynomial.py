"""A polynomial law through the origin."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Polynomial"]


class Polynomial(AbstractTensionLaw):
    """T(e) = sum over k of c_k e^k, k = 1 ... K, with coefficients c_k (N), shape (K,)."""

    coefficients: Float[Array, " K"]

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """sum c_k e^k (N), by Horner's rule."""
        result = jnp.zeros_like(strain)
        for k in reversed(range(self.coefficients.shape[0])):
            result = (result + self.coefficients[k]) * strain
        return result

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """sum c_k e^(k+1) / (k+1) (J/m), by Horner's rule."""
        result = jnp.zeros_like(strain)
        for k in reversed(range(self.coefficients.shape[0])):
            result = (result + self.coefficients[k] / (k + 2.0)) * strain
        return result * strain
