"""What steers a ship: thrust and moments of its own, and a pull back to where it started."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.body import AbstractBodyLoad, AbstractBodyResistance
from lumpedcable.physics.rigid import rotation, spin

__all__ = ["Station", "Steering"]


class Station(AbstractBodyLoad):
    """A control law's pull back to the start: E = sum k (q - q0)^2 / 2.

    `stiffness` (m,) in N/m along the scene's axes and N m/rad of the angles, `start` (m,) q0 (m, rad).
    """

    energy_name: ClassVar[str] = "control"
    stiffness: Float[Array, " m"]
    start: Float[Array, " m"]

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Energy (J)."""
        return 0.5 * jnp.sum(self.stiffness * (q - self.start) ** 2)


class Steering(AbstractBodyResistance):
    """Thrust F and moment M along and about a body's own axes, and damping -c q'.

    The control forces of Gao et al. 2022, eq. 12-14 (propeller, side thruster, turning moment). Their
    generalised force is (R F, S^T M), with the rotation R and S (roll', pitch', yaw') the angular
    velocity in the body's axes. `thrust` (d,) in N, `moment` (angles,) in N m, `damping` (m,) in
    N s/m and N m s/rad; None where there is none.
    """

    work_name: ClassVar[str] = "control"
    thrust: Float[Array, " d"] | None = None
    moment: Float[Array, " a"] | None = None
    damping: Float[Array, " m"] | None = None

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Generalised force (N, N m)."""
        total = jnp.zeros_like(q)
        if self.thrust is not None:
            d = self.thrust.shape[0]
            total = total.at[:d].add(rotation(q[d:]) @ self.thrust)
        if self.moment is not None and self.moment.shape[0] > 0:
            a = self.moment.shape[0]
            turned = spin(q[-3:]).T @ self.moment if a == 3 else self.moment
            total = total.at[-a:].add(turned)
        if self.damping is not None:
            total = total - self.damping * v
        return total
