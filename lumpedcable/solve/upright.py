"""How near rigid bodies in space have come to where their roll and yaw are one and the same turn."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import RigidBody, body_key
from lumpedcable.model.model import Model
from lumpedcable.model.state import State
from lumpedcable.physics.rigid import PITCH, ROLL, YAW

__all__ = ["upright", "uprightest"]


def upright(model: Model, y: State) -> dict[str, Float[Array, ""]]:
    """|cos(pitch)| of the bodies that turn in space (-), 1 of those whose roll or yaw is held."""
    found = {}
    for name, body in model.bodies.items():
        if isinstance(body, RigidBody) and body.reference.shape[0] > YAW:
            moved = y.displacement[body_key(name)]
            cosine = jnp.abs(jnp.cos(body.reference[PITCH] + moved[PITCH]))
            if body.free is not None:
                both = body.free[ROLL] * body.free[YAW]
                cosine = jnp.where(both > 0.0, cosine, 1.0)
            found[name] = jax.lax.stop_gradient(cosine.astype(moved.dtype))
    return found


def uprightest(model: Model, y: State, before: dict[str, Float[Array, ""]]):
    """The least of `upright` so far, what it was before a number became undefined included."""
    now = upright(model, y) if before else {}
    return {name: jnp.fmin(least, now[name]) for name, least in before.items()}
