"""What lifts a body that the water's surface may cross: a ball or a box, at any height and attitude."""

import abc
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.physics.body import AbstractBodyLoad
from lumpedcable.physics.rigid import rotation

__all__ = ["AbstractForm", "Ball", "BodyLift", "Box"]

# Gauss's points over -1/2 ... 1/2 and their weights, which are exact for polynomials to the order 7
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)
POINTS, WEIGHTS = 0.5 * POINTS, 0.5 * WEIGHTS


class AbstractForm(eqx.Module):
    """The form of a body that floats: how deep it is under water on the mean."""

    @abc.abstractmethod
    def depth(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Depth (m), the mean over its volume with 0 for what is dry.

        With its centre at a `height` (m) over the water, turned by `angles` (rad); `up` is the vertical.
        The share of it that is wet is minus the slope of that to the height.
        """

    @abc.abstractmethod
    def stiffest(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Bounds of the second derivatives of the depth, to the height (1/m) and to angles (m)."""


class Ball(AbstractForm):
    """A ball of a `radius` R (m).

    With x = height / R, between -1 and 1, the share (2 - 3 x + x^3) / 4 of it is wet, and the depth is
    R (3 - 8 x + 6 x^2 - x^4) / 16, the integral of the share from x to 1.
    """

    radius: Float[Array, ""]

    @classmethod
    def of(cls, volume: Float[Array, ""]) -> "Ball":
        """The ball of a volume (m3)."""
        return cls(jnp.cbrt(0.75 / jnp.pi * volume))

    def depth(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Depth (m) of the ball, however it is turned."""
        x = height / self.radius
        inside = jnp.clip(x, -1.0, 1.0)
        partly = (3.0 - 8.0 * inside + 6.0 * inside**2 - inside**4) / 16.0
        return self.radius * (partly + inside - jnp.minimum(x, inside))

    def stiffest(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """3 / (4 R) at half depth; none to angles."""
        return 0.75 / self.radius, jnp.zeros_like(self.radius)


class Box(AbstractForm):
    """A box of a `size` (d,) in m along its own axes, those that the scene has.

    Its places are spread along the vertical by a_i = |e_i . up| L_i of each axis. The depth is that of a
    line of the largest of them, (a/2 - h)^2 / (2 a) where the surface crosses it, at `POINTS` of the
    other two: exact as long as the surface crosses all of these lines or none, for any tilt.
    """

    size: Float[Array, " d"]

    def depth(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Depth (m) of the box."""
        spread = jnp.sort(jnp.abs(rotation(angles).T @ up) * self.size)
        heights, weights = height, jnp.ones(())
        for k in range(self.size.shape[0] - 1):
            heights = heights[..., None] + spread[k] * jnp.asarray(POINTS, height.dtype)
            weights = weights[..., None] * jnp.asarray(WEIGHTS, height.dtype)
        # what has no extent along the vertical has nothing to be crossed
        width = jnp.where(spread[-1] > 0.0, spread[-1], 1.0)
        share = jnp.clip(0.5 - heights / width, 0.0, 1.0)
        depth = jnp.where(share < 1.0, 0.5 * width * share**2, -heights)
        return jnp.sum(weights.astype(height.dtype) * depth)

    def stiffest(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """1 / its least extent, and what a tilt of its longest side does beside its own height."""
        least, most = jnp.min(self.size), jnp.max(self.size)
        return 1.0 / least, most**2 / (12.0 * least) + most


class BodyLift(AbstractBodyLoad):
    """Buoyancy of that part of a body which is under water: E = w times the depth of its form.

    `weight` w = rho g V (N). The centre of gravity x (d,) is at the height `up` . x + `above` (m) over
    the water at rest, and in the middle of the form. Its force is up, its moment rights or upsets it.
    """

    energy_name: ClassVar[str] = "gravitational"
    weight: Float[Array, ""]
    form: AbstractForm
    up: Float[Array, " d"]
    above: Float[Array, ""]

    def height(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Height of the centre over the water at rest (m)."""
        return self.up @ q[: self.up.shape[0]] + self.above

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """w times the depth (J)."""
        return self.risen_energy(q, jnp.zeros((), q.dtype))

    def risen_energy(self, q: Float[Array, " m"], risen: Float[Array, ""]) -> Float[Array, ""]:
        """The same (J) where waves have lifted the surface by `risen` (m)."""
        angles = q[self.up.shape[0] :]
        return self.weight * self.form.depth(self.height(q) - risen, angles, self.up)

    def wet(self, q: Float[Array, " m"], risen: Float[Array, ""] | float = 0.0) -> Float[Array, ""]:
        """The share (-) of its volume that is under water, which waves have lifted by `risen` (m)."""
        angles = q[self.up.shape[0] :]
        height = self.height(q) - risen
        return -jax.grad(self.form.depth)(height, angles, self.up)

    def by_waves(self, q: Float[Array, " m"], risen: Float[Array, ""]) -> Float[Array, " m"]:
        """The force (N, N m) that it has besides where waves have lifted the surface by `risen` (m)."""
        return -jax.grad(self.risen_energy)(q, risen) - self.force(q)

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """w times the bounds of its form."""
        d = self.up.shape[0]
        heave, tilt = self.form.stiffest()
        along = jnp.pad(jnp.outer(self.up, self.up) * heave, (0, q.shape[0] - d))
        about = jnp.zeros_like(q).at[d:].set(tilt)
        return self.weight * (along + jnp.diag(about))
