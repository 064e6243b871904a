"""A smooth curve through given points: tension tables, profiles of the seabed."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

__all__ = ["MonotoneCubic", "monotone_slopes"]


def monotone_slopes(x: Float[Array, " K"], y: Float[Array, " K"]) -> Float[Array, " K"]:
    """Knot slopes of a cubic Hermite curve that never swings beyond its points.

    Fritsch & Butland (SIAM J. Sci. Stat. Comput. 5, 1984, eq. 5): the three-point harmonic mean of the
    neighbouring secants, 0 where these differ in sign; at the ends the secant's own.
    """
    step = jnp.diff(x)
    secant = jnp.diff(y) / step
    left, right = secant[:-1], secant[1:]
    weight = (step[:-1] + 2.0 * step[1:]) / (3.0 * (step[:-1] + step[1:]))
    mean = weight * right + (1.0 - weight) * left
    product = left * right
    rising = product > 0.0
    inner = jnp.where(rising, product / jnp.where(rising, mean, 1.0), 0.0)
    return jnp.concatenate([secant[:1], inner, secant[-1:]])


class MonotoneCubic(eqx.Module):
    """y(x) through points (x_k, y_k), x_k increasing: cubics between them, straight beyond them.

    The slopes of `monotone_slopes` make it continuous with its derivative; a table that never falls
    gives a curve that never falls.
    """

    x: Float[Array, " K"]
    y: Float[Array, " K"]
    slopes: Float[Array, " K"]

    def __init__(self, x: Float[Array, " K"], y: Float[Array, " K"]):
        self.x, self.y = jnp.asarray(x), jnp.asarray(y)
        self.slopes = monotone_slopes(self.x, self.y)

    def value(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        """y(x)."""
        k, s, h = self._locate(x)
        a, b, c, d = self._coefficients(k, h)
        return a + s * (b + s * (c + s * d)) + self._beyond(x)[0]

    def slope(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        """y'(x); beyond the points that of the nearest end."""
        k, s, h = self._locate(x)
        _, b, c, d = self._coefficients(k, h)
        return (b + s * (2.0 * c + 3.0 * s * d)) / h

    def integral(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        """The exact integral of y from 0 to x."""
        return self._integral(x) - self._integral(jnp.zeros((), self.x.dtype))

    def _integral(self, x: Float[Array, "..."]) -> Float[Array, "..."]:
        h = jnp.diff(self.x)
        knots = jnp.arange(self.x.shape[0] - 1)
        a, b, c, d = self._coefficients(knots, h)
        whole = h * (a + b / 2.0 + c / 3.0 + d / 4.0)
        before = jnp.concatenate([jnp.zeros_like(whole[:1]), jnp.cumsum(whole)])
        k, s, h = self._locate(x)
        a, b, c, d = self._coefficients(k, h)
        part = h * s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
        return before[k] + part + self._beyond(x)[1]

    def _locate(self, x: Float[Array, "..."]):
        """Interval index, coordinate in it (0 to 1) and its width; beyond the points, the ends."""
        last = self.x.shape[0] - 2
        k = jnp.clip(jnp.searchsorted(self.x, x, side="right") - 1, 0, last)
        h = self.x[k + 1] - self.x[k]
        inside = jnp.clip(x, self.x[0], self.x[-1])
        return k, (inside - self.x[k]) / h, h

    def _coefficients(self, k, h):
        rise = self.y[k + 1] - self.y[k]
        b, end = h * self.slopes[k], h * self.slopes[k + 1]
        return self.y[k], b, 3.0 * rise - 2.0 * b - end, b + end - 2.0 * rise

    def _beyond(self, x: Float[Array, "..."]):
        """What the straight continuation adds to y and to its integral."""
        over = jnp.maximum(x - self.x[-1], 0.0)
        under = jnp.minimum(x - self.x[0], 0.0)
        value = self.slopes[-1] * over + self.slopes[0] * under
        area = self.y[-1] * over + 0.5 * self.slopes[-1] * over**2
        area += self.y[0] * under + 0.5 * self.slopes[0] * under**2
        return value, area
