"""From the moved bodies of a scene, and the waves on free ones, to laws of time of the engine."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.numbers import if_given, moving, number, vector
from lumpedcable.model.sea import sea_state
from lumpedcable.physics import ships
from lumpedcable.physics.motion import Recorded
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.ships import AbstractBodyMotion, DirectionOfBody, PointOfBody, Swing
from lumpedcable.physics.wave_force import WaveForce
from lumpedcable.physics.wave_pressure import PressedBox
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.motions import (
    FREEDOMS,
    HarmonicBody,
    HarmonicWaves,
    PressureWaves,
    RecordedBody,
    SeaBody,
)
from lumpedcable.scene.moved import MovedBody

__all__ = ["direction_of_body", "motion_of", "point_of_body", "waves_of"]


def motion_of(scene: Scene, body: MovedBody) -> AbstractBodyMotion:
    """The motion of a moved body of the scene, whose numbers may be traced.

    In a scene at rest it is none: the body is at its mean place.
    """
    return _law(scene, body.motion, vector(body.position))


def waves_of(
    scene: Scene, body: Body, coordinates: Coordinates, settled: Float[Array, " m"] | None = None
) -> WaveForce | None:
    """What waves push a free body of the scene with; None where nothing does.

    They pass where it starts, which is where it has `settled`, its coordinates (m, rad), if it has.
    """
    part = body.waves
    if part is None:
        return None
    assert body.position is not None  # the scene was checked
    place, yaw = vector(body.position), number(0.0 if body.attitude is None else body.attitude[2])
    if settled is not None:
        d = coordinates.dimensions
        place = jnp.asarray(coordinates.origin) + jnp.asarray(coordinates.axes) @ settled[:d]
        if d == 3 and settled.size == 6:
            yaw = settled[5]
        elif d == 2 and settled.size == 3:
            about = coordinates.normal[2]  # 0 of an upright plane, in which it keeps its heading
            yaw = jnp.where(jnp.abs(about) > 0.5, about * settled[2], yaw)
    if isinstance(part, PressureWaves):
        law = _pressed(scene, body, place, yaw)
    else:
        law = _law(scene, part.model_copy(update={"ramp": None}), place)
    ramp = if_given(part.ramp)
    heading = rotation(jnp.stack([jnp.zeros(()), jnp.zeros(()), yaw]))
    along = jnp.asarray(coordinates.axes, float).T @ heading
    about = coordinates.turns()
    spread = jnp.concatenate(
        [jnp.pad(along, ((0, 0), (0, 3))), jnp.pad(about, ((0, 0), (3, 0)))], axis=0
    )
    return WaveForce(law, spread, ramp)


def _pressed(
    scene: Scene, body: Body, place: Float[Array, " 3"], yaw: Float[Array, ""]
) -> AbstractBodyMotion:
    """Forces of the pressure in the scene's waves on the box of a hull at a place (m), headed `yaw`."""
    assert scene.sea is not None
    assert scene.fluid is not None
    assert scene.gravity is not None
    assert body.size is not None
    density, (length, breadth, _) = scene.fluid.density, body.size
    draught, sea = number(body.draught(density)), sea_state(scene)
    heading = number(scene.sea.direction) - yaw
    box = PressedBox(
        number(length), number(breadth), draught, number(body.above_keel(density)) - draught,
        number(density) * number(scene.gravity), heading,
    )  # fmt: skip
    phase = sea.phase - sea.number * _way(scene, place)
    return ships.SeaBody(sea.omega, sea.amplitude, phase, *box.response(sea))


def _way(scene: Scene, place: Float[Array, " 3"]) -> Float[Array, ""]:
    """How far a place (m) is along the waves' direction (m)."""
    assert scene.sea is not None  # the scene was checked
    direction = number(scene.sea.direction)
    return place[0] * jnp.cos(direction) + place[1] * jnp.sin(direction)


def _law(
    scene: Scene, motion: HarmonicBody | HarmonicWaves | RecordedBody | SeaBody,
    place: Float[Array, " 3"],
) -> AbstractBodyMotion:  # fmt: skip
    """Six numbers over time: motions of a body at a place (m), or forces on it."""
    share = moving(scene)
    if isinstance(motion, HarmonicBody | HarmonicWaves):
        swings = []
        for name in motion.names():
            part = getattr(motion, name)
            amplitude = share * number(part.amplitude)
            numbers = (amplitude, number(part.period), number(part.phase))
            swings.append(Swing(FREEDOMS.index(name), *numbers))
        return ships.HarmonicBody(tuple(swings), if_given(motion.ramp))
    if isinstance(motion, RecordedBody):
        time = vector(motion.time)
        columns = [getattr(motion, name) for name in FREEDOMS]
        table = [jnp.zeros_like(time) if c is None else vector(c) for c in columns]
        return ships.RecordedBody(Recorded(time, share * jnp.stack(table, axis=1)))
    response = {
        FREEDOMS.index(name): jnp.stack([vector(pair) for pair in motion.response[name]])
        for name in motion.names()
    }
    return ships.SeaBody.of(
        sea_state(scene), _way(scene, place), vector(motion.omega), response,
        if_given(motion.ramp),
    )  # fmt: skip


def point_of_body(
    scene: Scene, body: MovedBody, point: tuple[float, float, float], coordinates: Coordinates
) -> PointOfBody:
    """The path of a point (m, in the body's axes) of a moved body."""
    return PointOfBody(
        motion_of(scene, body), vector(body.position), vector(point),
        jnp.asarray(coordinates.axes, float), jnp.asarray(coordinates.origin, float),
    )  # fmt: skip


def direction_of_body(
    scene: Scene, body: MovedBody, direction: tuple[float, float, float], coordinates: Coordinates
) -> DirectionOfBody:
    """The way of a direction (in the body's axes) of a moved body."""
    axes = jnp.asarray(coordinates.axes, float)
    return DirectionOfBody(motion_of(scene, body), vector(direction), axes)
