"""What lifts a body that the water's surface may cross: a ball or a box, at any height and attitude."""

import abc
from typing import ClassVar, NamedTuple

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
    """The form of a body that floats: how deep it is under water on the mean.

    Its centre is at a `height` (m) over the water, it is turned by `angles` (rad); `up` is the vertical.
    """

    @abc.abstractmethod
    def depth(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """Depth (m), the mean over its volume with 0 for what is dry."""

    @abc.abstractmethod
    def wet(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """The share (-) of it that is wet: minus the slope of the depth to the height."""

    @abc.abstractmethod
    def reach(self) -> Float[Array, ""]:
        """How far it reaches from its centre (m)."""

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

    def wet(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """The share (-) of the ball."""
        x = jnp.clip(height / self.radius, -1.0, 1.0)
        return (2.0 - 3.0 * x + x**3) / 4.0

    def reach(self) -> Float[Array, ""]:
        """Its radius."""
        return self.radius

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
        return _depth(height, self._widths(angles, up))

    def wet(
        self, height: Float[Array, ""], angles: Float[Array, " a"], up: Float[Array, " d"]
    ) -> Float[Array, ""]:
        """The share (-) of the box."""
        return _under(height, self._widths(angles, up)).share

    def _widths(self, angles: Float[Array, " a"], up: Float[Array, " d"]) -> Float[Array, " d"]:
        """How far it spreads along the vertical by each axis (m), the largest first."""
        squares = (rotation(angles).T @ up * self.size) ** 2
        # what has next to no extent along the vertical is as thick as rounding asks for; all alike, so
        # that nothing jumps where two change places
        thin = jnp.cbrt(jnp.finfo(squares.dtype).eps) ** 2 * jnp.sum(squares)
        return jnp.stack(_ordered(list(jnp.sqrt(squares + thin))))

    def reach(self) -> Float[Array, ""]:
        """To its corners."""
        return 0.5 * jnp.sqrt(jnp.sum(self.size**2))

    def stiffest(self) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """1 / its least extent, and what a tilt of its longest side does beside its own height."""
        least, most = jnp.min(self.size), jnp.max(self.size)
        return 1.0 / least, most**2 / (12.0 * least) + most


def _ordered(values: list[Float[Array, ""]]) -> list[Float[Array, ""]]:
    """Numbers, the largest first.

    By comparisons: a step with a sorting in it is no longer one function (`WHOLE_LOOPS` of
    `study/compiled.py`). Of equal ones each has the derivatives of one, where a mean of both, as of
    jax's maximum, would spoil second derivatives.
    """
    if len(values) == 1:
        return values
    first, *others = values
    found = []
    for other in _ordered(others):
        more = first >= other
        found.append(jnp.where(more, first, other))
        first = jnp.where(more, other, first)
    return [*found, first]


class _Under(NamedTuple):
    """What is under water of a box: depth (m), share (-), slopes of the depth to its widths (d,)."""

    depth: Float[Array, ""]
    share: Float[Array, ""]
    slopes: Float[Array, " d"]


@jax.custom_jvp
def _depth(height: Float[Array, ""], widths: Float[Array, " d"]) -> Float[Array, ""]:
    """The mean depth (m) of a box at a height (m) that spreads over widths (m).

    Its slopes are written down: what jax makes of the mean's is ten times as long a program.
    """
    return _under(height, widths).depth


@_depth.defjvp
def _depth_changes(values, changes):
    found = _under(*values)
    return found.depth, jnp.dot(found.slopes, changes[1]) - found.share * changes[0]


def _under(height: Float[Array, ""], widths: Float[Array, " d"]) -> _Under:
    """Means over the box, by Gauss's rule at places between which what is averaged is a cubic."""
    heights, weights, shares = height[None], jnp.ones_like(height)[None], []
    half = 0.5 * widths
    for k in reversed(range(1, half.size)):
        # where edges and corners of what the axes before span meet the water, the nearest first
        ends = half[:1] if k == 1 else jnp.stack([half[0] - half[1], half[0] + half[1]])
        share, weight = _places(heights, widths[k], ends)
        shares = [jnp.repeat(one, share.shape[1]) for one in shares] + [share.ravel()]
        heights = (heights[:, None] + widths[k] * share).ravel()
        weights = (weights[:, None] * weight).ravel()
    share, depth = crossed(heights, widths[0])
    slopes = [0.5 * share * (1.0 - share), *(-one * share for one in reversed(shares))]
    means = jnp.stack([depth, share, *slopes]) @ weights
    return _Under(means[0], means[1], means[2:])


def _places(
    heights: Float[Array, " P"], width: Float[Array, ""], ends: Float[Array, " n"]
) -> tuple[Float[Array, "P n"], Float[Array, "P n"]]:
    """Where to take a mean over a width (m) about heights (m), as shares of it, and with what weights.

    The ends between which it is of polynomials lie on either side of 0 alike; those above it are given.
    """
    every = jnp.concatenate([-ends[::-1], ends])
    between = jnp.clip((every - heights[:, None]) / width, -0.5, 0.5)
    half = jnp.full_like(heights[:, None], 0.5)
    edges = jnp.concatenate([-half, between, half], axis=1)
    size, middle = edges[:, 1:] - edges[:, :-1], 0.5 * (edges[:, 1:] + edges[:, :-1])
    points = middle[..., None] + size[..., None] * jnp.asarray(POINTS, heights.dtype)
    weights = jnp.broadcast_to(0.5 * size[..., None], points.shape)
    return points.reshape(heights.size, -1), weights.reshape(heights.size, -1)


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
        return self.form.wet(self.height(q) - risen, angles, self.up)

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
