"""Rigid bodies that a bed bears: each corner stands on it as so many metres of a line do."""

from typing import ClassVar, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.body import (
    AbstractBedFriction,
    AbstractBodyLoad,
    AbstractBodyResistance,
)
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.seabed import AbstractSeabed, SeabedDamping

__all__ = ["BearingDamping", "BearingFriction", "BedBearing", "Corners"]


class Corners(NamedTuple):
    """Where a body touches a bed: position (d, n) m, and lengths of line (n,) m that bear as much."""

    position: Float[Array, "d n"]
    node_length: Float[Array, " n"]


class BedBearing(AbstractBodyLoad):
    """The push of a bed on the corners of a body: k s(p) upwards at the penetration p of each (N).

    s(p) is that of `AbstractSeabed`, k (N/m) the stiffness of the bed times `length` (n,) in m; `points`
    (d, n) are the corners from the centre of gravity in the body's axes (m).
    """

    energy_name: ClassVar[str] = "seabed"
    bed: AbstractSeabed
    points: Float[Array, "d n"]
    length: Float[Array, " n"]

    def corners(self, q: Float[Array, " m"]) -> Corners:
        """The corners where they are."""
        d = self.points.shape[0]
        return Corners(q[:d, None] + rotation(q[d:]) @ self.points, self.length)

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """sum k S(p) (J), S' = s."""
        return self.bed.energy(self.corners(q))

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """k along every way that a place can change and k r^2 about every angle, of all corners.

        On a slope d' a bed with the stiffness k upwards has k (1 + d'^2) along its normal.
        """
        d, one = self.points.shape[0], jnp.ones_like(self.length)
        stiffness = self.bed.rate_squared(jnp.ones(()), one) * self.length
        places = jnp.full((d,), jnp.sum(stiffness))
        turns = jnp.full((q.shape[0] - d,), jnp.sum(stiffness * jnp.sum(self.points**2, axis=0)))
        return jnp.diag(jnp.concatenate([places, turns]))


class BearingDamping(AbstractBodyResistance):
    """What the bed's damping does at the corners, along its normal; with the push it never pulls."""

    work_name: ClassVar[str] = "contact"
    bearing: BedBearing
    damping: SeabedDamping

    def push(self, q: Float[Array, " m"], v: Float[Array, " m"]) -> Float[Array, " n"]:
        """Force on each corner (N) along the bed's normal."""
        position, velocity = jax.jvp(lambda at: self.bearing.corners(at).position, (q,), (v,))
        return self.damping.push(Corners(position, self.bearing.length), velocity)

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Generalised force (N, N m)."""
        corners, back = jax.vjp(lambda at: self.bearing.corners(at).position, q)
        normal = self.bearing.bed.normal(Corners(corners, self.bearing.length))
        return back(jnp.broadcast_to(normal * self.push(q, v), corners.shape))[0]

    def stiffest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """The most damping there can be: that of all corners in the bed."""
        return self.bearing.stiffest(q) * (self.damping.damping / self.bearing.bed.stiffness)


class BearingFriction(AbstractBedFriction):
    """Coulomb friction of a body that a bed bears: N is all that the bed pushes its corners with."""

    coefficient: Float[Array, ""]
    up: Float[Array, " d"]
    bearing: BedBearing
    damping: BearingDamping | None

    def limit(
        self, force: Float[Array, " m"], q: Float[Array, " m"], v: Float[Array, " m"]
    ) -> Float[Array, ""]:
        """mu N (N)."""
        push = self.bearing.bed.push(self.bearing.corners(q))
        if self.damping is not None:
            push = push + self.damping.push(q, v)
        return self.coefficient * jnp.sum(push)
