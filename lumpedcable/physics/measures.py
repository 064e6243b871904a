"""Numbers that a scene asks for of a body: its height over water or a deck, its vertical speed."""

import abc
from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.motion import AbstractMotion
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.sea import SeaSurface
from lumpedcable.physics.ships import AbstractBodyMotion

__all__ = ["AbstractMeasure", "ClearanceMeasure", "ClimbMeasure", "HeightMeasure", "Near"]


class Near(eqx.Module):
    """Counts only where the horizontal distance (m) to a moving point lies in given bounds.

    `post` is the point's path (3,); `within` and `beyond` (m) are None where they bound nothing.
    """

    post: AbstractMotion
    within: Float[Array, ""] | None = None
    beyond: Float[Array, ""] | None = None

    def counts(self, t: Float[Array, ""], place: Float[Array, " 3"]):
        """Whether a place (m) counts at t (s)."""
        away = jnp.sqrt(jnp.sum((place - self.post.position(t))[:2] ** 2))
        inside = True if self.within is None else away <= self.within
        return inside & (True if self.beyond is None else away >= self.beyond)


class AbstractMeasure(eqx.Module):
    """A number over time of a body's trolley, NaN while it does not count."""

    least: ClassVar[bool]  # whether a run comes down to the least value, else to the largest
    unit: ClassVar[str]
    near: eqx.AbstractVar[Near | None]

    @abc.abstractmethod
    def always(
        self, t: Float[Array, ""], place: Float[Array, " 3"], velocity: Float[Array, " 3"]
    ) -> Float[Array, ""]:
        """The number at t (s) of a place (m) and velocity (m/s) in x, y, z."""

    def value(
        self, t: Float[Array, ""], place: Float[Array, " 3"], velocity: Float[Array, " 3"]
    ) -> Float[Array, ""]:
        """The number, NaN where it does not count."""
        found = self.always(t, place, velocity)
        return found if self.near is None else jnp.where(self.near.counts(t, place), found, jnp.nan)


class HeightMeasure(AbstractMeasure):
    """Height (m) over z = level, or over the plane z = level in the axes of a moved body.

    With x0 (m) the body's mean place, h = e . (x - x0 - shift(t)) - level, e = R(t) e_z.
    """

    least: ClassVar[bool] = True
    unit: ClassVar[str] = "m"
    level: Float[Array, ""]
    motion: AbstractBodyMotion | None = None
    mean: Float[Array, " 3"] | None = None
    near: Near | None = None

    def always(self, t, place, velocity) -> Float[Array, ""]:
        """h (m)."""
        if self.motion is None or self.mean is None:
            return place[2] - self.level
        q = self.motion.freedoms(t)
        return jnp.dot(rotation(q[3:])[:, 2], place - self.mean - q[:3]) - self.level


class ClearanceMeasure(AbstractMeasure):
    """Height (m) over the waves: h = z - Z(x, y, t) - level, Z the height of the surface."""

    least: ClassVar[bool] = True
    unit: ClassVar[str] = "m"
    level: Float[Array, ""]
    surface: SeaSurface
    near: Near | None = None

    def always(self, t, place, velocity) -> Float[Array, ""]:
        """h (m)."""
        return place[2] - self.surface.height(t, place) - self.level


class ClimbMeasure(AbstractMeasure):
    """Size of the vertical velocity (m/s)."""

    least: ClassVar[bool] = False
    unit: ClassVar[str] = "m/s"
    near: Near | None = None

    def always(self, t, place, velocity) -> Float[Array, ""]:
        """|dz/dt| (m/s)."""
        return jnp.abs(velocity[2])
