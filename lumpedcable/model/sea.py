"""From the sea of a scene to its waves and to how the water moves in them."""

import jax.numpy as jnp

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.numbers import if_given, moving, number
from lumpedcable.physics.sea import SeaFlow, SeaState
from lumpedcable.scene import Scene

__all__ = ["sea_flow", "sea_state"]


def sea_state(scene: Scene) -> SeaState:
    """The waves of the scene's sea; none have come where it is at rest."""
    sea = scene.sea
    assert sea is not None  # the scene was checked
    return SeaState.of(
        moving(scene) * number(sea.height), number(sea.period), number(sea.gamma), sea.seed,
        sea.components, if_given(sea.depth),
    )  # fmt: skip


def sea_flow(scene: Scene, coordinates: Coordinates) -> SeaFlow | None:
    """How the water round lines moves in the scene's waves, None where it does not."""
    if scene.sea is None or scene.sea.flow is None:
        return None
    direction = number(scene.sea.direction)
    ahead = jnp.stack([jnp.cos(direction), jnp.sin(direction), jnp.zeros(())])
    axes, origin = jnp.asarray(coordinates.axes, float), jnp.asarray(coordinates.origin, float)
    up = coordinates.vector((0.0, 0.0, 1.0))
    flow = scene.sea.flow
    return SeaFlow(
        sea_state(scene), axes.T @ ahead, origin @ ahead, up, origin[2] - number(flow.surface),
        if_given(flow.ramp),
    )  # fmt: skip
