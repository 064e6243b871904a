"""The linear law: a line that obeys Hooke."""

from typing import ClassVar

from jaxtyping import Array, Float

from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Linear"]


class Linear(AbstractTensionLaw):
    """T(e) = EA e, U(e) = EA e^2 / 2, with EA the axial stiffness (N)."""

    stays_slack: ClassVar[bool] = True

    EA: Float[Array, ""]

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """EA e (N)."""
        return self.EA * strain

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """EA e^2 / 2 (J/m)."""
        return 0.5 * self.EA * strain**2
