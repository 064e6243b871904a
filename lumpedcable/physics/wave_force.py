"""What waves push a free body with."""

from typing import ClassVar

import equinox as eqx
from jaxtyping import Array, Float

from lumpedcable.physics.ships import AbstractBodyMotion, grown

__all__ = ["WaveForce"]


class WaveForce(eqx.Module):
    """Exciting forces of waves on a body about its place of the start, known over time.

    `law` gives three forces (N) and three moments (N m), which `spread` (m, 6) takes to the body's
    coordinates: forces along its length, breadth and up as it heads at the start, moments that act on
    roll, pitch and yaw, so about level axes that turn with its yaw, as linear theory has them and as a
    hull is righted. (About its own axes the moments of a roll and of a pitch at once would leave one
    about the vertical, which no water gives: it turns a ship out of its course.) They grow over `ramp`
    (s), None for at once. The disturbance of Gao et al. 2022, eq. 13-14; linear in the waves, so that it
    does not drift the ship.
    """

    work_name: ClassVar[str] = "waves"
    law: AbstractBodyMotion
    spread: Float[Array, "m 6"]
    ramp: Float[Array, ""] | None = None

    def force(self, q: Float[Array, " m"], t: Float[Array, ""]) -> Float[Array, " m"]:
        """Generalised force (N, N m) at t (s)."""
        return (self.spread @ grown(self.law.freedoms(t), t, self.ramp)).astype(q.dtype)
