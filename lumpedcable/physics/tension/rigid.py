"""The law by which a line that keeps its length finds its shape at rest."""

from jaxtyping import Array, Float

from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Rigid"]


class Rigid(AbstractTensionLaw):
    """T(e) = T0 + EA e, U(e) = T0 e + EA e^2 / 2, with T0 (N) the tension at no strain, EA in N.

    Where T0 is what a segment carries, its strain is 0 at any EA: Hestenes' and Powell's method of
    multipliers takes T0 from one state of rest to the next (Nocedal & Wright, Numerical
    Optimization, 2nd ed., section 17.3).
    """

    T0: Float[Array, "..."]
    EA: Float[Array, ""]

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """T0 + EA e (N)."""
        return self.T0 + self.EA * strain

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """T0 e + EA e^2 / 2 (J/m)."""
        return (self.T0 + 0.5 * self.EA * strain) * strain
