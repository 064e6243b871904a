"""What pays lines out and hauls them in: winches that keep a tension, and drums as they are told."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody
from lumpedcable.physics.body import AbstractBedFriction
from lumpedcable.physics.motion import Spooled

__all__ = ["AbstractReel", "Drum"]


class AbstractReel(AbstractBody):
    """Something at an end of a line whose first coordinate is the length L (m) that is paid out.

    All segments of the line are L / n long, so that what is paid out is spread over the line at once.
    `line` is its name, `node` 0 or -1 the end at which it stands.
    """

    line: eqx.AbstractVar[str]
    node: eqx.AbstractVar[int]

    def place(self, q: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """The point itself: it is no place."""
        return point

    def shift(self, u: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """Nothing."""
        return jnp.zeros_like(point)


class Drum(AbstractReel):
    """A drum at an end of a line: q = (L), the length (m) that is paid out, as `path` says.

    It asks for no force and has no inertia: its drive does what the line asks for. `least` (m) is the
    least length within the run, when segments are shortest. `free` is 0: nothing but its path moves it.
    """

    reference: Float[Array, " 1"]
    path: Spooled
    least: Float[Array, ""]
    line: str = eqx.field(static=True, default="")
    node: int = eqx.field(static=True, default=-1)
    start_velocity: Float[Array, " 1"] | None = None
    free: Float[Array, " 1"] | None = None
    friction: AbstractBedFriction | None = None

    def mass(self, q: Float[Array, " 1"], t: Float[Array, ""] | None = None) -> Float[Array, "1 1"]:
        """1, which nothing asks for."""
        return jnp.ones((1, 1), q.dtype)

    def kinetic(
        self, q: Float[Array, " 1"], v: Float[Array, " 1"], t: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """0."""
        return jnp.zeros((), q.dtype)

    def stored(self, q: Float[Array, " 1"]) -> dict[str, Float[Array, ""]]:
        """None."""
        return {}

    def resisting(
        self, q: Float[Array, " 1"], v: Float[Array, " 1"], t: Float[Array, ""] | None = None
    ) -> dict[str, Float[Array, " 1"]]:
        """None."""
        return {}

    def works(self) -> tuple[str, ...]:
        """That of its drive."""
        return ("control",)
