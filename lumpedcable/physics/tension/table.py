"""A law given by a table of strains and tensions, as a test bench measures it."""

from typing import ClassVar

from jaxtyping import Array, Float

from lumpedcable.physics.curve import MonotoneCubic
from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Table"]


class Table(AbstractTensionLaw):
    """Monotone cubic interpolation of a table of strains e_k (-) and tensions T_k (N).

    See `physics.curve`: a table that never falls gives a law that never falls, with a continuous
    derivative (a wave speed without jumps); beyond the table it goes on straight.
    """

    stays_slack: ClassVar[bool] = True

    curve: MonotoneCubic

    def __init__(self, strain: Float[Array, " K"], tension: Float[Array, " K"]):
        self.curve = MonotoneCubic(strain, tension)

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The interpolated tension (N)."""
        return self.curve.value(strain)

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The exact integral of the interpolated tension from strain 0 (J/m)."""
        return self.curve.integral(strain)
