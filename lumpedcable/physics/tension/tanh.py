"""The five-parameter tanh law of synthetic rope."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.linear import settled_back
from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Tanh"]


class Tanh(AbstractTensionLaw):
    """T(e) = p1 tanh(p2 e + p3) + p4 + p5 e (Zhu, Yin & Shen 2018, eq. 5).

    p1, p4, p5 in N; p2, p3 without unit. Fitted to break tests of nylon, it stiffens up to
    e = -p3 / p2 and softens beyond. T(0) = p1 tanh(p3) + p4 is small but not exactly zero.
    """

    # with p5 < 0 only down to strains of some -0.4, shorter than lines that are slack become
    stays_slack: ClassVar[bool] = True

    p1: Float[Array, ""]
    p2: Float[Array, ""]
    p3: Float[Array, ""]
    p4: Float[Array, ""]
    p5: Float[Array, ""]

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """p1 tanh(p2 e + p3) + p4 + p5 e (N)."""
        # what comes back to the argument goes to the strain, to p2 and to p3, and takes long to work out
        argument = settled_back(self.p2 * strain + self.p3)
        return self.p1 * jnp.tanh(argument) + self.p4 + self.p5 * strain

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """(p1 / p2) [ln cosh(p2 e + p3) - ln cosh(p3)] + p4 e + p5 e^2 / 2 (J/m)."""
        change = _log_cosh(self.p2 * strain + self.p3) - _log_cosh(self.p3)
        return self.p1 / self.p2 * change + self.p4 * strain + 0.5 * self.p5 * strain**2


def _log_cosh(x: Float[Array, "..."]) -> Float[Array, "..."]:
    # cosh overflows where its logarithm is harmless
    return jnp.logaddexp(x, -x) - jnp.log(2.0)
