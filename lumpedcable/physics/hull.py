"""A hull in water at rest or in a current: what holds it up and what slows it down."""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.afloat import BodyLift
from lumpedcable.physics.body import AbstractBodyLoad, AbstractBodyResistance
from lumpedcable.physics.fluid import AbstractCurrent
from lumpedcable.physics.rigid import rotation, turning_force
from lumpedcable.physics.sea import SeaFlow

__all__ = [
    "BoxDrag",
    "HullResistance",
    "Hydrostatics",
    "SeaPush",
    "StreamTurning",
    "WetAddedMass",
]


class Hydrostatics(AbstractBodyLoad):
    """Weight and buoyancy of a hull that floats, for small motions about where it floats freely.

    E = (rho g A z^2 + D GM_T roll^2 + D GM_L pitch^2) / 2 with z the height (m) of the centre of
    gravity over `floating`, its place at rest over the origin of the scene's coordinates; A the
    waterplane (m2), D the weight (N), GM the metacentric heights (m). `heave` is rho g A (N/m),
    `tilt` D GM about each angle that there is (N m). Heave and pitch do not couple for a hull whose
    waterplane is centred over its centre of gravity (Liu et al. 2018, eq. 53-58, where eq. 58 lacks
    two signs and the displaced volume).
    """

    energy_name: ClassVar[str] = "hydrostatic"
    up: Float[Array, " d"]
    floating: Float[Array, ""]
    heave: Float[Array, ""]
    tilt: Float[Array, " a"]

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Energy (J) over that of the hull that floats freely."""
        d = self.up.shape[0]
        rise = self.up @ q[:d] - self.floating
        return 0.5 * (self.heave * rise**2 + jnp.sum(self.tilt * q[d:] ** 2))


class HullResistance(AbstractBodyResistance):
    """Friction of a hull's wetted skin against the water, along its length.

    R = f rho S (C_F + C_A) v |v| (N) with C_F = 0.075 / (log10 Re - 2)^2, Re = |v| L / nu, the line of
    the International Towing Tank Conference of 1957, and C_A = (105 (k / L)^(1/3) - 0.64) / 1000 for
    the roughness k (m); v along the hull relative to the water (m/s), S the wetted area (m2), L the
    length (m), nu the kinematic viscosity (m2/s) (Liu et al. 2018, eq. 59-62; textbooks have f = 1/2).
    `factor` is f rho S (kg/m). Below Re = 1e4, where the line has no meaning, C_F is as there.
    """

    work_name: ClassVar[str] = "hull"
    factor: Float[Array, ""]
    length: Float[Array, ""]
    viscosity: Float[Array, ""]
    roughness: Float[Array, ""]
    height: Float[Array, ""]
    current: AbstractCurrent | None = None

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Force (N) along the hull, at its centre of gravity."""
        d = _places(q.shape[0])
        u = v[:d]
        if self.current is not None:
            u = u - self.current.velocity(self.height[None])[:, 0]
        ahead = rotation(q[d:])[:, 0]
        speed = jnp.dot(u, ahead)
        reynolds = jnp.maximum(jnp.abs(speed) * self.length / self.viscosity, 1e4)
        skin = 0.075 / (jnp.log10(reynolds) - 2.0) ** 2
        rough = (105.0 * jnp.cbrt(self.roughness / self.length) - 0.64) * 1e-3
        resistance = self.factor * (skin + rough) * jnp.abs(speed) * speed
        return jnp.zeros_like(q).at[:d].set(-resistance * ahead)


class BoxDrag(AbstractBodyResistance):
    """Drag of a box, 1/2 rho C A |v| v along each of its axes (N), at its centre of gravity.

    `factor` are rho C A / 2 along its axes (kg/m), v the velocity relative to the fluid (m/s) at the
    body's height, `base` the height of the origin of the scene's coordinates (m) and `up` the vertical
    (Liu et al. 2018, eq. 39, for a body that moves along its length alone). `sea` is how the water moves
    in waves. Of a body that may leave the water, `lift` says what share of it is wet and dragged at.
    """

    work_name: ClassVar[str] = "drag"
    factor: Float[Array, " d"]
    up: Float[Array, " d"]
    base: Float[Array, ""]
    current: AbstractCurrent | None = None
    sea: SeaFlow | None = None
    lift: BodyLift | None = None

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Force (N) on the body."""
        d = self.up.shape[0]
        u = v[:d]
        if self.current is not None:
            u = u - _stream(self.current, self.up, self.base, q)
        if self.sea is not None and t is not None:
            u = u - self.sea.motion(t, q[:d, None])[0][:, 0]
        turn = rotation(q[d:])
        own = turn.T @ u
        factor = self.factor
        if self.lift is not None:
            factor = factor * _wet(self.lift, self.sea, q, t)
        return jnp.zeros_like(q).at[:d].set(-turn @ (factor * jnp.abs(own) * own))


class StreamTurning(AbstractBodyResistance):
    """What a current makes of the velocity terms of a body's added mass (N, N m), the moment of Munk.

    They go by its velocity relative to the water, w x p - A (w x u) and -p x u: A = R diag(`masses`) R^T
    (kg) is the water that it takes along, u = v - U at its height, p = A u and w its angular velocity
    (M. M. Munk, NACA Rep. 184, 1924). So a current turns a body that it meets askew across it, as it
    turns when it is towed. Those of v itself are among its inertia, and taken off here. `base` and `up`
    are as of `BoxDrag`; of a body that may leave the water `lift` says what share is wet.
    """

    work_name: ClassVar[str] = "added_mass"
    masses: Float[Array, " d"]
    up: Float[Array, " d"]
    base: Float[Array, ""]
    current: AbstractCurrent
    sea: SeaFlow | None = None
    lift: BodyLift | None = None

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Force (N, N m) on the body."""
        d = self.up.shape[0]
        masses, none = self.masses, jnp.zeros_like(q[d:])
        if self.lift is not None:
            masses = masses * _wet(self.lift, self.sea, q, t)
        relative = v.at[:d].add(-_stream(self.current, self.up, self.base, q))
        return turning_force(q, v, masses, none) - turning_force(q, relative, masses, none)


class SeaPush(eqx.Module):
    """What water pushes a submerged body with as it accelerates in waves, at its centre of gravity (N).

    (rho V + C rho V) a along each of its axes, `masses` (kg): the pressure of the undisturbed wave, and
    its added mass (Morison et al. 1950; DNV-RP-C205, section 6.2.2). A body that may leave the water has
    that of the share of it which is wet, and what its `lift` is more or less than in water at rest.
    """

    work_name: ClassVar[str] = "waves"
    sea: SeaFlow
    masses: Float[Array, " d"]
    lift: BodyLift | None = None

    def force(self, q: Float[Array, " m"], t: Float[Array, ""]) -> Float[Array, " m"]:
        """Generalised force (N, N m) at t (s)."""
        d = self.masses.shape[0]
        turn = rotation(q[d:])
        own = turn.T @ self.sea.motion(t, q[:d, None])[1][:, 0]
        push = jnp.zeros_like(q).at[:d].set(turn @ (self.masses * own))
        if self.lift is None:
            return push
        risen = _risen(self.sea, q[:d], t)
        return push * self.lift.wet(q, risen) + self.lift.by_waves(q, risen)


class WetAddedMass(eqx.Module):
    """What a body that may leave the water takes along of it: C rho V of its share that is wet.

    `masses` C rho V (kg) are along its own axes; `lift` tells the share, `sea` how far waves have lifted
    the surface. The force is the mass of the moment times the acceleration: that of the water which is
    parted or thrown up as the share changes, v dm/dt, is left out, as for lines.
    """

    masses: Float[Array, " d"]
    lift: BodyLift
    sea: SeaFlow | None = None

    def at(self, q: Float[Array, " m"], t: Float[Array, ""] | None) -> Float[Array, " d"]:
        """The masses (kg) along its axes at t (s), None at rest."""
        return self.masses * _wet(self.lift, self.sea, q, t)


def _stream(
    current: AbstractCurrent, up: Float[Array, " d"], base: Float[Array, ""], q: Float[Array, " m"]
) -> Float[Array, " d"]:
    """The velocity (m/s) of a current at the height of a body's centre of gravity."""
    height = base + up @ q[: up.shape[0]]
    return current.velocity(height[None])[:, 0]


def _wet(
    lift: BodyLift, sea: SeaFlow | None, q: Float[Array, " m"], t: Float[Array, ""] | None
) -> Float[Array, ""]:
    """The share (-) of a body that is under water, at rest or as waves have lifted it at t (s)."""
    return lift.wet(q, _risen(sea, q[: lift.up.shape[0]], t))


def _risen(
    sea: SeaFlow | None, place: Float[Array, " d"], t: Float[Array, ""] | None
) -> Float[Array, ""]:
    """How far waves have lifted the surface over a place (m), 0 at rest."""
    if sea is None or t is None:
        return jnp.zeros((), place.dtype)
    return sea.risen(t, place[:, None])[0]


def _places(coordinates: int) -> int:
    """Number of place coordinates among 1, 3 or 6."""
    return {1: 1, 3: 2, 6: 3}[coordinates]
