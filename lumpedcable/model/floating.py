"""From a body of the scene to one of the model."""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.beds import bearing_damping, bearing_of, bed_friction
from lumpedcable.model.bodies import RigidBody
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.numbers import if_given, moving, number, vector
from lumpedcable.model.sea import sea_flow
from lumpedcable.model.ships import waves_of
from lumpedcable.physics.afloat import Ball, BodyLift, Box
from lumpedcable.physics.body import (
    AbstractBodyLoad,
    AbstractBodyResistance,
    BodyWeight,
)
from lumpedcable.physics.fluid import AbstractCurrent
from lumpedcable.physics.hull import (
    BoxDrag,
    HullResistance,
    Hydrostatics,
    SeaPush,
    StreamTurning,
    WetAddedMass,
)
from lumpedcable.physics.steering import Station, Steering
from lumpedcable.physics.wave_force import WaveForce
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import ANGLES, Body

__all__ = ["lift_of", "make_body", "reference_of"]


def make_body(
    scene: Scene, name: str, coordinates: Coordinates, current: AbstractCurrent | None
) -> RigidBody:
    """A rigid body of the model, at its place and attitude of the start."""
    body = scene.bodies[name]
    assert isinstance(body, Body)
    assert body.position is not None
    d = coordinates.dimensions
    mass, bearing = number(body.mass), bearing_of(scene, body, coordinates)
    damping = bearing_damping(scene, bearing)
    reference = reference_of(body, coordinates)
    angles = reference[d:]
    start = None
    if body.velocity is not None:
        velocity = moving(scene) * coordinates.vector(body.velocity)
        start = jnp.concatenate([velocity, jnp.zeros_like(angles)])
    added = _wet_added(scene, body, coordinates)
    whole = _with_added(scene, body, coordinates, mass)
    return RigidBody(
        reference=reference,
        translation=whole if added is None else jnp.full_like(whole, mass),
        inertia=_inertia(coordinates, body) if body.turns else jnp.full(angles.shape, mass),
        start_velocity=start,
        free=_free(coordinates, body),
        friction=bed_friction(body, coordinates, bearing, damping),
        loads=_given(bearing) + _loads(scene, body, coordinates, reference),
        resistances=_given(damping) + _resistances(scene, body, coordinates, current),
        waves=_waves(scene, body, coordinates),
        added=added,
    )


def _waves(scene: Scene, body: Body, coordinates: Coordinates) -> WaveForce | SeaPush | None:
    """What the scene says that waves push it with, or how the water in them does; None for neither."""
    if body.waves is not None:
        return waves_of(scene, body, coordinates)
    flow = sea_flow(scene, coordinates)
    if flow is None or body.volume is None or scene.fluid is None:
        return None
    carried = number(scene.fluid.density) * number(body.volume)
    lift = lift_of(scene, body, coordinates)
    return SeaPush(flow, _with_added(scene, body, coordinates, carried), lift)


def _with_added(
    scene: Scene, body: Body, coordinates: Coordinates, mass: Float[Array, ""]
) -> Float[Array, " d"]:
    """A mass (kg) along each of its axes, and what of the fluid it takes along there."""
    masses = jnp.full((coordinates.dimensions,), mass)
    added = _added(scene, body, coordinates)
    return masses if added is None else masses + added


def _added(scene: Scene, body: Body, coordinates: Coordinates) -> Float[Array, " d"] | None:
    """What of the fluid it takes along (kg) along each of its axes, as a whole; None for nothing."""
    if body.added_mass is None or body.volume is None or scene.fluid is None:
        return None
    shares = jnp.asarray(coordinates.axes).T ** 2 @ vector(body.added_mass)
    return number(scene.fluid.density) * number(body.volume) * shares


def _wet_added(scene: Scene, body: Body, coordinates: Coordinates) -> WetAddedMass | None:
    """The same of a body that may leave the water, by its share that is wet; None where it cannot."""
    lift, masses = lift_of(scene, body, coordinates), _added(scene, body, coordinates)
    if lift is None or masses is None:
        return None
    return WetAddedMass(masses, lift, sea_flow(scene, coordinates))


def _given(one: Any) -> tuple[Any, ...]:
    return () if one is None else (one,)


def reference_of(body: Body, coordinates: Coordinates) -> Float[Array, " m"]:
    """Its coordinates at the start: place (m) and angles (rad)."""
    assert body.position is not None
    angles = _angles(coordinates, (0.0, 0.0, 0.0) if body.attitude is None else body.attitude)
    return jnp.concatenate([coordinates.point(body.position), angles])


def _angles(coordinates: Coordinates, attitude) -> Float[Array, " a"]:
    """Roll, pitch and yaw (rad), the angle in the plane, or nothing."""
    return coordinates.turns() @ vector(attitude)


def _inertia(coordinates: Coordinates, body: Body) -> Float[Array, " a"]:
    """Moments of inertia (kg m2) about the axes that there are; of a uniform box where none is given."""
    if body.inertia is not None:
        whole = vector(body.inertia)
    else:
        assert body.size is not None
        square = vector(body.size) ** 2
        whole = number(body.mass) / 12.0 * (jnp.sum(square) - square)
    return coordinates.turns() ** 2 @ whole


def _free(coordinates: Coordinates, body: Body) -> Float[Array, " m"] | None:
    """1 for coordinates that can change, 0 for those that are held; None where all can."""
    if body.free is None:
        return None
    places = jnp.asarray([float(way in body.free) for way in ("x", "y", "z")])
    angles = coordinates.turns() ** 2 @ jnp.asarray([float(way in body.free) for way in ANGLES])
    along = jnp.asarray(coordinates.axes).T ** 2 @ places
    # an axis between two of the scene's counts with the one that it is nearer to
    return jnp.round(jnp.concatenate([along, angles]))


def _loads(
    scene: Scene, body: Body, coordinates: Coordinates, start: Float[Array, " m"]
) -> tuple[AbstractBodyLoad, ...]:
    keeping = _station(body, coordinates, start)
    if scene.gravity is None:
        return keeping
    if body.hull is not None:
        return (_hydrostatics(scene, body, coordinates), *keeping)
    weight, lift = number(body.mass), lift_of(scene, body, coordinates)
    if lift is None and body.volume is not None and scene.fluid is not None:
        weight = weight - number(scene.fluid.density) * body.volume
    down = coordinates.vector((0.0, 0.0, -1.0))
    return (BodyWeight(weight * scene.gravity * down), *_given(lift), *keeping)


def lift_of(scene: Scene, body: Body, coordinates: Coordinates) -> BodyLift | None:
    """What lifts a body as far as it is under water, None where water is everywhere or lifts nothing."""
    if scene.surface is None or body.volume is None or body.hull is not None:
        return None
    assert scene.water is not None
    assert scene.gravity is not None  # the scene was checked
    volume = number(body.volume)
    form = Ball.of(volume)
    if body.size is not None:
        form = Box(jnp.asarray(coordinates.axes).T ** 2 @ vector(body.size))
    weight = number(scene.water.density) * number(scene.gravity) * volume
    return BodyLift(weight, form, *coordinates.over(scene.surface))


def _each(coordinates: Coordinates, along, about) -> Float[Array, " m"]:
    """Numbers along x, y, z and about them as numbers of a body's coordinates; 0 where None."""
    whole = [jnp.zeros(3) if v is None else vector(v) for v in (along, about)]
    places = jnp.asarray(coordinates.axes).T ** 2 @ whole[0]
    return jnp.concatenate([places, coordinates.turns() ** 2 @ whole[1]])


def _station(
    body: Body, coordinates: Coordinates, start: Float[Array, " m"]
) -> tuple[AbstractBodyLoad, ...]:
    part = body.control
    if part is None or (part.stiffness is None and part.turn_stiffness is None):
        return ()
    return (Station(_each(coordinates, part.stiffness, part.turn_stiffness), start),)


def _steering(body: Body, coordinates: Coordinates) -> tuple[AbstractBodyResistance, ...]:
    part = body.control
    if part is None:
        return ()
    given = (part.force, part.moment, part.damping, part.turn_damping)
    if all(each is None for each in given):
        return ()
    damping = None
    if part.damping is not None or part.turn_damping is not None:
        damping = _each(coordinates, part.damping, part.turn_damping)
    return (
        Steering(
            if_given(part.force, coordinates.vector),
            None if part.moment is None else _angles(coordinates, part.moment),
            damping,
        ),
    )


def _hydrostatics(scene: Scene, body: Body, coordinates: Coordinates) -> Hydrostatics:
    """What holds up a floating box: the stiffness of its heave, roll and pitch."""
    assert body.hull is not None
    assert body.size is not None
    assert scene.fluid is not None
    assert scene.gravity is not None
    density = scene.fluid.density
    draught, above = number(body.draught(density)), number(body.above_keel(density))
    weight = number(body.mass) * scene.gravity
    # it rolls about its length, across its breadth, and pitches across its length
    heights = [number(height) for height in body.metacentres(density)]
    tilt = coordinates.turns() ** 2 @ (weight * jnp.stack([*heights, jnp.zeros(())]))
    return Hydrostatics(
        coordinates.vector((0.0, 0.0, 1.0)),
        scene.sea_level + above - draught - coordinates.origin[2],
        weight / draught,
        tilt,
    )


def _resistances(
    scene: Scene, body: Body, coordinates: Coordinates, current: AbstractCurrent | None
) -> tuple[AbstractBodyResistance, ...]:
    found: list[AbstractBodyResistance] = [*_steering(body, coordinates)]
    taken = _added(scene, body, coordinates) if body.turns else None
    if taken is not None and current is not None:
        up, base = coordinates.vector((0.0, 0.0, 1.0)), number(coordinates.origin[2])
        sea, lift = sea_flow(scene, coordinates), lift_of(scene, body, coordinates)
        found.append(StreamTurning(taken, up, base, current, sea, lift))
    if scene.fluid is None or body.size is None:
        return tuple(found)
    density = number(scene.fluid.density)
    length, breadth, height = (number(s) for s in body.size)
    if body.drag is not None:
        faces = jnp.stack([breadth * height, length * height, length * breadth])
        factor = 0.5 * density * faces * vector(body.drag)
        up = coordinates.vector((0.0, 0.0, 1.0))
        base = number(coordinates.origin[2])
        own = jnp.asarray(coordinates.axes).T ** 2 @ factor
        lift = lift_of(scene, body, coordinates)
        found.append(BoxDrag(own, up, base, current, sea_flow(scene, coordinates), lift))
    if body.hull is not None and body.hull.resistance is not None:
        part = body.hull.resistance
        draught = number(body.draught(scene.fluid.density))
        wetted = length * breadth + 2.0 * draught * (length + breadth)
        share = {"textbook": 0.5, "doubled": 1.0}[part.convention]
        found.append(
            HullResistance(
                share * density * wetted,
                length,
                number(part.viscosity),
                number(part.roughness),
                number(scene.sea_level),
                current,
            )
        )
    return tuple(found)
