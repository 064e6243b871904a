"""Paths of places that are held or moved: what a scene's ends and posts follow."""

from dataclasses import replace
from typing import Any

import jax.numpy as jnp

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.numbers import if_given, moving, number, vector
from lumpedcable.model.ships import direction_of_body, point_of_body
from lumpedcable.physics.motion import AbstractMotion, Harmonic, Recorded, Still
from lumpedcable.scene import Scene
from lumpedcable.scene.carried import stands_at
from lumpedcable.scene.ends import MovingEnd, RecordedMotion, TiedEnd, held_place

__all__ = ["aim_of", "path_of"]


def path_of(scene: Scene, place: Any, coordinates: Coordinates) -> AbstractMotion | None:
    """The path of an end, or of a place [x, y, z] (m); None where nothing says where it is.

    An end on a winch or drum is where that stands. Nothing says it of free ends, of those that a force
    holds, and of those that are joined or tied to a body that moves freely.
    """
    place = stands_at(place)
    if isinstance(place, MovingEnd):
        return _moved(scene, place, coordinates)
    held = held_place(place)
    place = place if held is None else held
    if isinstance(place, tuple):
        return Still(coordinates.point(place))
    carried = scene.point_of(place)
    return None if carried is None else point_of_body(scene, *carried, coordinates)


def aim_of(scene: Scene, end: Any, coordinates: Coordinates) -> AbstractMotion | None:
    """The way of the direction that a line keeps at a point of a moved body; None of other ends."""
    carried = scene.point_of(end) if isinstance(end, TiedEnd) else None
    if carried is None:
        return None
    return direction_of_body(scene, carried[0], end.direction, coordinates)


def _moved(scene: Scene, end: MovingEnd, coordinates: Coordinates) -> AbstractMotion:
    motion, share = end.motion, moving(scene)
    if isinstance(motion, RecordedMotion):
        record = coordinates.points(motion.position)
        path = Recorded(vector(motion.time), record)
        # a record has no mean place: at rest the end is where it is at t = 0
        begins = path.position(jnp.zeros(()))
        return replace(path, record=jnp.where(share > 0.0, record, begins))
    absent = {
        "velocity": if_given(motion.velocity, lambda v: share * coordinates.vector(v)),
        "amplitude": if_given(motion.amplitude, lambda v: share * coordinates.vector(v)),
        "period": if_given(motion.period),
        "phase": None if motion.amplitude is None else number(motion.phase),
        "ramp": if_given(motion.ramp),
    }
    return Harmonic(coordinates.point(motion.position), **absent)
