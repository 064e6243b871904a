"""Where the water's surface crosses a line: how much of it is wet, and what that is lifted with."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.load import AbstractLoad, Shape
from lumpedcable.physics.vectors import dot

__all__ = ["Lift", "Waterline", "crossed"]


def crossed(
    height: Float[Array, "..."], width: Float[Array, "..."]
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Share under water, and mean depth (m) with 0 for what is dry, of what spreads evenly in height.

    Over a `width` W (m) about a height z (m): s = clip(1/2 - z / W, 0, 1), and W s^2 / 2 where it
    crosses the surface, -z below it.
    """
    share = jnp.clip(0.5 - height / width, 0.0, 1.0)
    return share, jnp.where(share < 1.0, 0.5 * width * share**2, -height)


class Waterline(eqx.Module):
    """The surface of water at rest beside a line of a `diameter` (m).

    Scene coordinates x (d,) are at the height `up` . x + `above` (m) over it. A segment of the length l
    between nodes at the heights z1 and z2 is straight, and wet to the share

        s = clip(1/2 - z / W, 0, 1),  z = (z1 + z2) / 2,
        W = sqrt(y^2 + d^2 (1 - y^2 / l^2)^2),  y = z2 - z1,

    the brackets not below 0: a level one goes under over its diameter, an upright one end first.
    """

    up: Float[Array, " d"]
    above: Float[Array, ""]
    diameter: Float[Array, ""]

    def heights(self, position: Float[Array, "d nodes"]) -> Float[Array, " nodes"]:
        """Heights of nodes over the water at rest (m)."""
        return self.up @ position + self.above

    def wet(
        self, height: Float[Array, " nodes"], length: Float[Array, "..."]
    ) -> Float[Array, " nodes"]:
        """Wet length (m) that each node stands for, of segments that are so long unstretched (m).

        Of the wet part l s of a segment its first node has l (s + s (1 - s) dW/dy) / 2 and the other one
        the rest: what lifts a thin bar there lifts its ends so.
        """
        share, _, slope = self._crossing(height, length)
        half = 0.5 * length * share
        nearer = half * (1.0 - share) * slope
        none = jnp.zeros_like(share[:1])
        return jnp.concatenate([half + nearer, none]) + jnp.concatenate([none, half - nearer])

    def depth(
        self, height: Float[Array, " nodes"], length: Float[Array, "..."]
    ) -> Float[Array, " n"]:
        """Depth of each segment (m), the mean over it with 0 for what is dry.

        Its slope to the height of a node is the share of `wet` that the node has, less than zero, so
        that what lifts the wet part has an energy.
        """
        return self._crossing(height, length)[1]

    def _crossing(self, height: Float[Array, " nodes"], length: Float[Array, "..."]):
        """s (-), the depth (m) and dW/dy (-) of each segment."""
        rise = height[1:] - height[:-1]
        middle = 0.5 * (height[1:] + height[:-1])
        square, fat = rise**2, (self.diameter / length) ** 2
        level = jnp.maximum(1.0 - square / length**2, 0.0)
        width = jnp.sqrt(square + (self.diameter * level) ** 2)
        slope = rise / width * (1.0 - 2.0 * fat * level)
        return *crossed(middle, width), slope


class Lift(AbstractLoad):
    """Buoyancy of that part of a line which is under water, `per_length` b (N per unstretched metre).

    b = rho g pi d^2 / 4 upwards, times the wet length that each node has (`Waterline.wet`). E = b times
    the depth of each segment (`Waterline.depth`) and its unstretched length.
    """

    energy_name: ClassVar[str] = "gravitational"
    per_length: Float[Array, ""]
    waterline: Waterline

    def force(self, shape: Shape) -> Float[Array, "d nodes"]:
        """Load on each node (N)."""
        height = self.waterline.heights(shape.position)
        return self.of(self.waterline.wet(height, shape.segment_length))

    def of(self, wet: Float[Array, " nodes"]) -> Float[Array, "d nodes"]:
        """Load (N) on nodes that stand for so much wet length (m)."""
        return self.waterline.up[:, None] * (self.per_length * wet)

    def energy(self, shape: Shape) -> Float[Array, ""]:
        """b sum l h (J), h the depths."""
        height = self.waterline.heights(shape.position)
        depth = self.waterline.depth(height, shape.segment_length)
        return self.per_length * jnp.sum(shape.segment_length * depth)

    def per_metre(self, place: Float[Array, " d"]) -> Float[Array, ""]:
        """Energy (J) of a metre of line that lies level at a place (m)."""
        height = self.waterline.heights(place[:, None])
        depth = self.waterline.depth(jnp.concatenate([height, height]), self.waterline.diameter)
        return self.per_length * depth[0]

    def rate_squared(
        self, mass: Float[Array, ""], segment_length: Float[Array, "..."]
    ) -> Float[Array, "..."]:
        """b / (m d) (1 + d^2 / l^2): a level line goes under over its diameter, and turns as it does."""
        square = dot(self.waterline.up, self.waterline.up)
        most = square * self.per_length / (mass * self.waterline.diameter)
        return most * (1.0 + (self.waterline.diameter / segment_length) ** 2)
