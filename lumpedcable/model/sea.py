"""From the sea of a scene to its waves, to their surface and to how the water moves in them."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.model import AbstractMeasured, Model
from lumpedcable.model.numbers import if_given, moving, number, vector
from lumpedcable.model.state import Seen
from lumpedcable.physics.sea import SeaFlow, SeaState, SeaSurface
from lumpedcable.scene import Scene
from lumpedcable.scene.measures import ElevationMeasure

__all__ = ["Gauge", "gauge", "sea_flow", "sea_state", "sea_surface"]


class Gauge(AbstractMeasured):
    """How far the surface of the sea is over the water at rest (m), at a place x, y (m)."""

    surface: SeaSurface
    place: Float[Array, " 3"]

    def value(self, model: Model, t, seen: Seen) -> Float[Array, ""]:
        """The number at t (s)."""
        return self.surface.height(t, self.place) - self.surface.level


def gauge(scene: Scene, part: ElevationMeasure) -> Gauge:
    """What a wave gauge shows."""
    return Gauge(sea_surface(scene), vector((*part.elevation, 0.0)))


def sea_state(scene: Scene) -> SeaState:
    """The waves of the scene's sea; none have come where it is at rest."""
    sea = scene.sea
    assert sea is not None  # the scene was checked
    return SeaState.of(
        moving(scene) * number(sea.height), number(sea.period), number(sea.gamma), sea.seed,
        sea.components, if_given(sea.depth),
    )  # fmt: skip


def sea_surface(scene: Scene) -> SeaSurface:
    """The surface of the scene's sea; it is level where statics looks for what is at rest."""
    sea = scene.sea
    assert sea is not None  # the scene was checked
    ramp = None if sea.flow is None else if_given(sea.flow.ramp)
    return SeaSurface(sea_state(scene), number(sea.direction), number(scene.sea_level), ramp)


def sea_flow(scene: Scene, coordinates: Coordinates) -> SeaFlow | None:
    """How the water round lines moves in the scene's waves, None where it does not."""
    if scene.sea is None or scene.sea.flow is None:
        return None
    direction = number(scene.sea.direction)
    ahead = jnp.stack([jnp.cos(direction), jnp.sin(direction), jnp.zeros(())])
    axes, origin = jnp.asarray(coordinates.axes, float), jnp.asarray(coordinates.origin, float)
    flow = scene.sea.flow
    return SeaFlow(
        sea_state(scene), axes.T @ ahead, origin @ ahead, *coordinates.over(scene.sea_level),
        if_given(flow.ramp),
    )  # fmt: skip
