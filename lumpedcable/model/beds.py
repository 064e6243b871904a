"""The bed of a scene as lines and bodies find it."""

import itertools

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.materials import STANDARD_GRAVITY
from lumpedcable.model.numbers import number, vector
from lumpedcable.physics.bearing import BearingDamping, BearingFriction, BedBearing
from lumpedcable.physics.body import AbstractBedFriction, HeldFriction
from lumpedcable.physics.curve import MonotoneCubic
from lumpedcable.physics.seabed import AbstractSeabed, Seabed, SeabedDamping, SlopingSeabed
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body

__all__ = ["bearing_damping", "bearing_of", "bed_damping", "bed_friction", "bed_under"]

CONTACT_BLEND = 0.2  # contact takes hold over this share of the depth that the dry line would sink
FACE = 4  # corners of a box that stand on a bed together


def bed_under(
    scene: Scene, coordinates: Coordinates, mass: Float[Array, ""]
) -> AbstractSeabed | None:
    """The bed under what has a mass (kg) for each metre that it bears; None where there is none."""
    if scene.seabed is None:
        return None
    stiffness = number(scene.seabed.stiffness)
    height = number(scene.seabed.height) - number(coordinates.origin[2])
    blend = CONTACT_BLEND * mass * STANDARD_GRAVITY / stiffness
    up = coordinates.vector((0.0, 0.0, 1.0))
    if scene.seabed.profile is None:
        return Seabed(up, height, stiffness, blend)
    points = (scene.seabed.profile.x, scene.seabed.profile.depth)
    depth = MonotoneCubic(*(vector(values) for values in points))
    across = coordinates.vector((1.0, 0.0, 0.0))
    origin = number(coordinates.origin[0])
    return SlopingSeabed(up, height, stiffness, blend, across, origin, depth)


def bed_damping(scene: Scene, bed: AbstractSeabed | None) -> SeabedDamping | None:
    """What damps motion into a bed, None where nothing does."""
    if bed is None or scene.seabed is None or scene.seabed.damping is None:
        return None
    return SeabedDamping(bed, number(scene.seabed.damping))


def bearing_of(scene: Scene, body: Body, coordinates: Coordinates) -> BedBearing | None:
    """How the bed bears a body, None where it does not.

    Each corner of a box has a quarter of the stiffness, so that the four of a face have it; without a
    size the centre of gravity has it all. Above the keel a hull counts as high as it is.
    """
    if body.bearing is None or scene.seabed is None:
        return None
    # of a line that the bed would bear with as much
    length = number(body.bearing) / number(scene.seabed.stiffness)
    bed = bed_under(scene, coordinates, number(body.mass) / length)
    assert bed is not None
    corners, each = [(0.0, 0.0, 0.0)], length
    if body.size is not None:
        long, wide, high = (0.5 * number(side) for side in body.size)
        low = high
        if body.hull is not None and scene.fluid is not None:
            low = number(body.above_keel(scene.fluid.density))
        each = length / FACE
        corners = itertools.product((-long, long), (-wide, wide), (-low, 2.0 * high - low))
    points = jnp.stack([coordinates.vector(corner) for corner in corners], axis=1)
    return BedBearing(bed, points, jnp.full(points.shape[1:], each))


def bearing_damping(scene: Scene, bearing: BedBearing | None) -> BearingDamping | None:
    """What damps the motion of a body into its bed, None where nothing does."""
    if bearing is None:
        return None
    damping = bed_damping(scene, bearing.bed)
    return None if damping is None else BearingDamping(bearing, damping)


def bed_friction(
    body: Body, coordinates: Coordinates, bearing: BedBearing | None, damping: BearingDamping | None
) -> AbstractBedFriction | None:
    """Friction of a body on a bed: of one that the bed bears, or of one whose height is held."""
    if body.friction is None:
        return None
    coefficient, up = number(body.friction), coordinates.vector((0.0, 0.0, 1.0))
    if bearing is None:
        return HeldFriction(coefficient, up)
    return BearingFriction(coefficient, up, bearing, damping)
