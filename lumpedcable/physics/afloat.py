"""What lifts a body that the water's surface may cross: a ball or a box, at any height and attitude."""

import abc
from collections.abc import Callable
from functools import partial
from typing import ClassVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.physics.body import AbstractBodyLoad
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.waterline import crossed

__all__ = ["AbstractForm", "Ball", "BodyLift", "Box"]

# Gauss's two points over -1/2 ... 1/2, each of half the weight: exact for cubic polynomials
POINTS = np.array([-0.5, 0.5]) / np.sqrt(3.0)


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

    Its places are spread along the vertical by a_i = |e_i . up| L_i of each axis. Of a line of the
    largest of them the depth is (a/2 - h)^2 / (2 a) where the surface crosses it; that is averaged over
    the other two, each between the heights at which an edge or a corner meets the water. There it is a
    polynomial, so that the mean is exact at any attitude.
    """

    size: Float[Array, " d"]

    def depth(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Depth (m) of the box."""
        square = jnp.sort((rotation(angles).T @ up * self.size) ** 2)[::-1]
        # what has no extent along the vertical has nothing to be crossed
        widest = jnp.sqrt(jnp.where(square[0] > 0.0, square[0], 1.0))
        # and what has next to none is as thick as rounding asks for, which its square changes little
        thin = jnp.cbrt(jnp.finfo(height.dtype).eps) * widest

        def line(heights):
            return crossed(heights, widest)[1]

        mean, ends = line, 0.5 * widest * jnp.asarray([-1.0, 1.0], height.dtype)
        for k in range(1, self.size.shape[0]):
            width = jnp.sqrt(square[k] + thin**2)
            mean = partial(_averaged, mean, width, ends)
            ends = jnp.concatenate([ends - 0.5 * width, ends + 0.5 * width])
        return mean(height)

    def stiffest(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """1 / its least extent, and what a tilt of its longest side does beside its own height."""
        least, most = jnp.min(self.size), jnp.max(self.size)
        return 1.0 / least, most**2 / (12.0 * least) + most


def _averaged(
    depth: Callable[..., Array], width: Float[Array, ""], ends: Float[Array, " n"],
    height: Float[Array, "*heights"],
) -> Float[Array, "*heights"]:  # fmt: skip
    """The mean of a depth (m), a polynomial between `ends`, over a width (m) about heights (m)."""
    places = jnp.clip((jnp.sort(ends) - height[..., None]) / width, -0.5, 0.5)
    half = jnp.full_like(height[..., None], 0.5)
    edges = jnp.concatenate([-half, places, half], axis=-1)
    size, middle = edges[..., 1:] - edges[..., :-1], 0.5 * (edges[..., 1:] + edges[..., :-1])
    points = middle[..., None] + size[..., None] * jnp.asarray(POINTS, height.dtype)
    values = depth(height[..., None, None] + width * points)
    return jnp.sum(size * jnp.mean(values, axis=-1), axis=-1)


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

    def energy(
        self, q: Float[Array, " m"], risen: Float[Array, ""] | float = 0.0
    ) -> Float[Array, ""]:
        """w times the depth (J), where waves have lifted the surface by `risen` (m)."""
        angles = q[self.up.shape[0] :]
        return self.weight * self.form.depth(self.height(q) - risen, angles, self.up)

    def wet(self, q: Float[Array, " m"], risen: Float[Array, ""] | float = 0.0) -> Float[Array, ""]:
        """The share (-) of its volume that is under water, which waves have lifted by `risen` (m)."""
        angles = q[self.up.shape[0] :]
        height = self.height(q) - risen
        return -jax.grad(self.form.depth)(height, angles, self.up)

    def by_waves(self, q: Float[Array, " m"], risen: Float[Array, ""]) -> Float[Array, " m"]:
        """The force (N, N m) that it has besides where waves have lifted the surface by `risen` (m)."""
        return -jax.grad(self.energy)(q, risen) - self.force(q)

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """w times the bounds of its form."""
        d = self.up.shape[0]
        heave, tilt = self.form.stiffest()
        along = jnp.pad(jnp.outer(self.up, self.up) * heave, (0, q.shape[0] - d))
        about = jnp.zeros_like(q).at[d:].set(tilt)
        return self.weight * (along + jnp.diag(about))
