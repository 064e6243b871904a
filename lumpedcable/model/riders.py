"""Bodies that run along cables: their coordinates, inertia and weight."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody
from lumpedcable.physics.body import AbstractBedFriction
from lumpedcable.physics.coupling import AbstractCoupling
from lumpedcable.physics.motion import AbstractMotion

__all__ = ["Coupled", "Rider"]


class Rider(AbstractBody):
    """Cargo on a trolley: q = (place of the trolley, angles of its swing).

    A point mass m (kg) has no angles. Hung, its centre of gravity is at x + h n, with the depth h (m)
    and n the direction of its hanger, down where the angles are 0: (sin a, -cos a) in a plane,
    (sin a cos b, sin b, -cos a cos b) in space. It turns with the moment of inertia J (kg m2):
    T = m |c'|^2 / 2 + J |n'|^2 / 2 (Gao et al. 2022, eq. 17). Where it is hauled along, `path` has the
    coordinates that `free` marks with 0. It `settles` where statics finds its height.
    """

    reference: Float[Array, " m"]
    kilograms: Float[Array, ""]
    depth: Float[Array, ""] | None = None
    inertia: Float[Array, ""] | None = None
    weight: Float[Array, " d"] | None = None
    start_velocity: Float[Array, " m"] | None = None
    free: Float[Array, " m"] | None = None
    friction: AbstractBedFriction | None = None
    path: AbstractMotion | None = None
    dimensions: int = eqx.field(static=True, default=2)
    settles: bool = eqx.field(static=True, default=True)

    def hanger(self, q: Float[Array, " m"]) -> Float[Array, " d"]:
        """The direction n of the hanger."""
        d = self.dimensions
        a = q[d]
        if d == 2:
            return jnp.stack([jnp.sin(a), -jnp.cos(a)])
        b = q[d + 1]
        return jnp.stack([jnp.sin(a) * jnp.cos(b), jnp.sin(b), -jnp.cos(a) * jnp.cos(b)])

    def centre(self, q: Float[Array, " m"]) -> Float[Array, " d"]:
        """The centre of gravity (m)."""
        d = self.dimensions
        return q[:d] if self.depth is None else q[:d] + self.depth * self.hanger(q)

    def mass(self, q: Float[Array, " m"], t: Float[Array, ""] | None = None) -> Float[Array, "m m"]:
        """M(q) (kg, kg m, kg m2)."""
        if self.depth is None:
            return self.kilograms * jnp.eye(q.shape[0], dtype=q.dtype)
        place, turn = jax.jacfwd(self.centre)(q), jax.jacfwd(self.hanger)(q)
        return self.kilograms * place.T @ place + self.inertia * turn.T @ turn

    def kinetic(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """v . M(q) v / 2 (J)."""
        return 0.5 * v @ self.mass(q) @ v

    def place(self, q: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """The trolley (m); `point` counts from it and does not turn."""
        return q[: self.dimensions] + point

    def shift(self, u: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """The move of the trolley (m)."""
        return u[: self.dimensions]

    def stored(self, q: Float[Array, " m"]) -> dict[str, Float[Array, ""]]:
        """-w . c (J), where there is gravity."""
        if self.weight is None:
            return {}
        return {"gravitational": -jnp.dot(self.weight, self.centre(q))}

    def resisting(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> dict[str, Float[Array, " m"]]:
        """None."""
        return {}

    def works(self) -> tuple[str, ...]:
        """None of its own."""
        return ()


class Coupled(eqx.Module):
    """A body that runs on a cable by a law; `line` is None where the cable has no nodes."""

    body: str = eqx.field(static=True)
    line: str | None = eqx.field(static=True)
    law: AbstractCoupling
