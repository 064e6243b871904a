"""What waves push a free body with."""

from typing import ClassVar

import equinox as eqx
from jaxtyping import Array, Float

from lumpedcable.physics.rigid import spin
from lumpedcable.physics.ships import AbstractBodyMotion, grown

__all__ = ["WaveForce"]


class WaveForce(eqx.Module):
    """Exciting forces of waves on a body about its place of the start, known over time.

    `law` gives three forces (N) and three moments (N m), which `spread` (m, 6) takes to the body's
    coordinates: forces along its length, breadth and up as it heads at the start, moments about its
    own axes, so that the generalised force is (F, S^T M) with S (roll', pitch', yaw') the angular
    velocity. They grow over `ramp` (s), None for at once. The disturbance of Gao et al. 2022, eq. 13-14;
    linear in the waves, so that it does not drift the ship.
    """

    work_name: ClassVar[str] = "waves"
    law: AbstractBodyMotion
    spread: Float[Array, "m 6"]
    ramp: Float[Array, ""] | None = None

    def force(self, q: Float[Array, " m"], t: Float[Array, ""]) -> Float[Array, " m"]:
        """Generalised force (N, N m) at t (s)."""
        total = (self.spread @ grown(self.law.freedoms(t), t, self.ramp)).astype(q.dtype)
        if q.shape[0] < 6:
            return total
        return total.at[3:].set(spin(q[3:]).T @ total[3:])
