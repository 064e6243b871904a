"""A law given by a table of strains and tensions, as a test bench measures it."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.tension.base import AbstractTensionLaw

__all__ = ["Table"]


class Table(AbstractTensionLaw):
    """Monotone cubic interpolation of a table of strains e_k (-) and tensions T_k (N).

    Between e_k and e_k+1 the law is the cubic Hermite polynomial with the knot slopes of Fritsch
    and Butland (SIAM J. Sci. Stat. Comput. 5, 1984, eq. 5): the three-point harmonic mean of the
    neighbouring secants, so that a table that never falls gives a law that never falls, with a
    continuous derivative (a wave speed without jumps). At the ends the slope is the secant's, and
    beyond the table the law goes on straight.
    """

    strain: Float[Array, " K"]
    values: Float[Array, " K"]
    slopes: Float[Array, " K"]

    def __init__(self, strain: Float[Array, " K"], tension: Float[Array, " K"]):
        self.strain = jnp.asarray(strain)
        self.values = jnp.asarray(tension)
        step = jnp.diff(self.strain)
        secant = jnp.diff(self.values) / step
        left, right = secant[:-1], secant[1:]
        weight = (step[:-1] + 2.0 * step[1:]) / (3.0 * (step[:-1] + step[1:]))
        mean = weight * right + (1.0 - weight) * left
        product = left * right
        rising = product > 0.0
        inner = jnp.where(rising, product / jnp.where(rising, mean, 1.0), 0.0)
        self.slopes = jnp.concatenate([secant[:1], inner, secant[-1:]])

    def tension(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The interpolated tension (N)."""
        k, s, h = self._locate(strain)
        a, b, c, d = self._coefficients(k, h)
        inside = a + s * (b + s * (c + s * d))
        return inside + self._beyond(strain)[0]

    def energy(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        """The exact integral of the interpolated tension from strain 0 (J/m)."""
        zero = jnp.zeros((), self.strain.dtype)
        return self._integral(strain) - self._integral(zero)

    def _integral(self, strain: Float[Array, "..."]) -> Float[Array, "..."]:
        h = jnp.diff(self.strain)
        knots = jnp.arange(self.strain.shape[0] - 1)
        a, b, c, d = self._coefficients(knots, h)
        whole = h * (a + b / 2.0 + c / 3.0 + d / 4.0)
        before = jnp.concatenate([jnp.zeros_like(whole[:1]), jnp.cumsum(whole)])
        k, s, h = self._locate(strain)
        a, b, c, d = self._coefficients(k, h)
        part = h * s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
        return before[k] + part + self._beyond(strain)[1]

    def _locate(self, strain: Float[Array, "..."]):
        """Interval index, coordinate in it (0 to 1) and its width; beyond the table, its ends."""
        last = self.strain.shape[0] - 2
        k = jnp.clip(jnp.searchsorted(self.strain, strain, side="right") - 1, 0, last)
        h = self.strain[k + 1] - self.strain[k]
        inside = jnp.clip(strain, self.strain[0], self.strain[-1])
        return k, (inside - self.strain[k]) / h, h

    def _coefficients(self, k, h):
        rise = self.values[k + 1] - self.values[k]
        b, end = h * self.slopes[k], h * self.slopes[k + 1]
        return self.values[k], b, 3.0 * rise - 2.0 * b - end, b + end - 2.0 * rise

    def _beyond(self, strain: Float[Array, "..."]):
        """What the straight continuation adds to tension (N) and to its integral (J/m)."""
        over = jnp.maximum(strain - self.strain[-1], 0.0)
        under = jnp.minimum(strain - self.strain[0], 0.0)
        tension = self.slopes[-1] * over + self.slopes[0] * under
        area = self.values[-1] * over + 0.5 * self.slopes[-1] * over**2
        area += self.values[0] * under + 0.5 * self.slopes[0] * under**2
        return tension, area
