"""What the coordinates of a scene must hold: its places, the directions in it, its bodies."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import ANGLES, WAYS, Body
from lumpedcable.scene.carried import CarriedBody, post_of
from lumpedcable.scene.ends import (
    HarmonicMotion,
    JoinedEnd,
    MovingEnd,
    RecordedMotion,
    TiedEnd,
    clamp_of,
    held_force,
    held_place,
)
from lumpedcable.scene.joints import rigid_joints
from lumpedcable.scene.motions import FREEDOMS, SHIFTS, TURNS, PressureWaves
from lumpedcable.scene.moved import MovedBody

__all__ = ["TOLERANCE", "Needs", "fits", "plane_normal"]

TOLERANCE = 1e-9  # relative: a component smaller than this is rounding


def plane_normal(axes):
    """The axis (3,) about which a body turns in the plane of `axes` (3, 2), of numpy or of jax.

    The cross product of the second axis and the first: positive angles turn the second to the first.
    """
    one, two = np.array([1, 2, 0]), np.array([2, 0, 1])
    first, second = axes[:, 0], axes[:, 1]
    return second[one] * first[two] - second[two] * first[one]


@dataclass
class Needs:
    """What the coordinates of a scene must hold.

    `folds` asks for a plane at least, in which a line sags or a body goes up and down; `rigid` are
    bodies that a plane may cut askew.
    """

    places: list[np.ndarray] = field(default_factory=list)
    directions: list[np.ndarray] = field(default_factory=list)
    rigid: list[Body] = field(default_factory=list)
    folds: bool = False

    @classmethod
    def of(cls, scene: Scene, slack: bool) -> "Needs":
        """Those of a scene; with `slack`, a line that is slack at the start asks for a plane."""
        found = cls()
        found._surroundings(scene)
        for name in scene.lines:
            found._line(scene, name, slack)
        found.folds |= any(rigid_joints(scene.lines))  # what goes on straight may lead back
        for body in scene.bodies.values():
            found._body(scene, body)
        return found

    def _surroundings(self, scene: Scene) -> None:
        if scene.gravity is not None or scene.seabed is not None:
            self.directions.append(np.array([0.0, 0.0, 1.0]))
        fluid = scene.fluid
        if fluid is not None and fluid.current is not None:
            self.directions += list(np.reshape(fluid.current.velocity, (-1, 3)))
        if scene.sea is not None and scene.sea.flow is not None:
            way = scene.sea.direction
            self.directions += [
                np.array([np.cos(way), np.sin(way), 0.0]),
                np.array([0.0, 0.0, 1.0]),
            ]
        self.folds |= scene.seabed is not None
        if scene.seabed is not None and scene.seabed.profile is not None:
            self.directions.append(np.array([1.0, 0.0, 0.0]))

    def _line(self, scene: Scene, name: str, slack: bool) -> None:
        line = scene.lines[name]
        ends = [line.start, line.end]
        found = [_places_of(end) or _on_body(scene, end) for end in ends]
        for end, mine in zip(ends, found, strict=True):
            self.places += mine
            self.directions += _directions_of(scene, end)
        chord = found[1][0] - found[0][0] if found[0] and found[1] else None
        if slack and chord is not None and (scene.gravity is not None or line.bending is not None):
            self.folds |= bool(np.linalg.norm(chord) < line.unstretched)
        if line.bending is not None:
            self.folds |= not _leaves_along(scene, name, chord)

    def _body(self, scene: Scene, body: Body | CarriedBody | MovedBody) -> None:
        if isinstance(body, MovedBody):
            self.places += [np.asarray(body.position) + p for p in body.points.values()]
            self.directions += _reaches(body)
        elif isinstance(body, CarriedBody):
            self.folds = True  # it goes up and down
        else:
            self.places += _places_of_body(body)
            if body.hull is not None:
                self.folds = True  # it pitches
            if body.velocity is not None:
                self.directions.append(np.asarray(body.velocity))
            self.directions += _pushes(scene, body) + _steered(body)
            if body.rigid:
                self.rigid.append(body)


def _leaves_along(scene: Scene, name: str, chord: np.ndarray | None) -> bool:
    """Whether a line that bends leaves its clamps the way that it goes, along its chord or its loads."""
    line = scene.lines[name]
    loads = []
    for end in (line.start, line.end):
        if (force := held_force(end)) is not None:
            loads.append(np.asarray(force.direction))
    if scene.gravity is not None:
        lifts = scene.displaced(name) > line.mass
        loads.append(np.array([0.0, 0.0, 1.0 if lifts else -1.0]))
    for end, out in ((line.start, 1.0), (line.end, -1.0)):
        if (clamp := scene.clamp(end)) is not None:
            ways = loads if chord is None else [out * chord]
            if any(out * np.dot(clamp, way) < 0.0 for way in ways):
                return False
    return True


def _places_of_body(body: Body) -> list[np.ndarray]:
    """Its position and its points as it is turned at the start (m)."""
    if body.position is None:
        return []
    turn, place = body.turned, np.asarray(body.position)
    return [place, *(place + turn @ np.asarray(point) for point in body.points.values())]


def _steered(body: Body) -> list[np.ndarray]:
    """Directions of a ship's thrust, and across those about which its moments turn it."""
    if body.control is None:
        return []
    turn, found = body.turned, []
    if body.control.force is not None:
        free = [body.free is None or way in body.free for way in "xyz"]
        found.append(np.where(free, turn @ np.asarray(body.control.force), 0.0))
    for k, moment in enumerate(body.control.moment or ()):
        if moment != 0.0 and (body.free is None or ANGLES[k] in body.free):
            found += [turn[:, j] for j in range(3) if j != k]
    return found


def fits(body: Body, axes: np.ndarray) -> bool:
    """Whether a rigid body does in a plane, or on a line, what it would do in space.

    It does where it is turned about the normal alone, and alike on both sides of the plane: its own
    axes must lie in it or across, and the resistance of a hull is along its length alone. What holds,
    pulls or damps it along x, y and z must do so alike along those that an axis is between.
    """
    if axes.shape[1] == 3:
        return True
    aligned = np.max(np.abs(axes), axis=0).min() > 1.0 - TOLERANCE
    attitude = np.asarray(body.attitude or (0.0, 0.0, 0.0), float)
    if axes.shape[1] == 2:
        normal = plane_normal(axes)
        attitude = attitude - (attitude @ normal) * normal
    skin = body.hull is not None and body.hull.resistance is not None
    ahead = np.linalg.norm(axes.T @ np.eye(3)[0]) > 1.0 - TOLERANCE
    askew = body.drag is not None or (axes.shape[1] == 2 and body.turns)
    askew |= body.added_mass is not None and len(set(body.added_mass)) > 1
    return not (
        np.any(np.abs(attitude) > TOLERANCE)
        or (askew and not aligned)
        or (skin and not ahead)
        or not all(_keeps(each, axes) for each in _along(body))
    )


def _along(body: Body) -> list[np.ndarray]:
    """Numbers along x, y and z that a body has: whether it is free, its springs and dampers."""
    found = [] if body.free is None else [np.array([float(way in body.free) for way in "xyz"])]
    if body.control is not None:
        given = (body.control.stiffness, body.control.damping)
        found += [np.asarray(each, float) for each in given if each is not None]
    return found


def _keeps(each: np.ndarray, axes: np.ndarray) -> bool:
    """Whether numbers D along x, y and z leave each axis a its direction: D a = (a . D a) a."""
    moved = each[:, None] * axes
    aside = moved - np.sum(axes * moved, axis=0) * axes
    return bool(np.all(np.abs(aside) <= TOLERANCE * np.max(np.abs(each))))


def _places_of(end) -> list[np.ndarray]:
    if (place := held_place(end)) is not None:
        return [np.asarray(place)]
    if isinstance(post := post_of(end), tuple):
        return [np.asarray(post)]
    if isinstance(end, JoinedEnd) and end.at is not None:
        return [np.asarray(end.at)]
    if isinstance(end, MovingEnd):
        if isinstance(end.motion, RecordedMotion):
            return [np.asarray(p) for p in end.motion.position]
        return [np.asarray(end.motion.position)]
    return []


def _on_body(scene: Scene, end) -> list[np.ndarray]:
    carried = scene.point_of(end)
    return [] if carried is None else [np.asarray(carried[0].position) + np.asarray(carried[1])]


def _directions_of(scene: Scene, end) -> list[np.ndarray]:
    if (force := held_force(end)) is not None:
        return [np.asarray(force.direction)]
    ways = [scene.clamp(end), clamp_of(end)]  # at a body as that is turned at the start, and is not
    carried = scene.point_of(end)
    if carried is not None and isinstance(end, TiedEnd):
        ways += _swings(carried[0], end.direction)
    if isinstance(end, MovingEnd) and isinstance(end.motion, HarmonicMotion):
        ways += [end.motion.velocity, end.motion.amplitude]
    return [np.asarray(v) for v in ways if v is not None]


def _reaches(body: MovedBody) -> list[np.ndarray]:
    """Directions in which the points of a moved body can go."""
    names, axes = body.motion.names(), np.eye(3)
    found = [axes[FREEDOMS.index(name)] for name in names if name in FREEDOMS[:3]]
    for point in body.points.values():
        found += _swings(body, point)
    return found


def _swings(body: MovedBody, arm: Iterable[float]) -> list[np.ndarray]:
    """Directions in which an arm in a moved body's axes can turn."""
    names, axes = body.motion.names(), np.eye(3)
    turns = [axes[FREEDOMS.index(name) - 3] for name in names if name in FREEDOMS[3:]]
    if len(turns) > 1:
        return list(axes)  # two turns lead out of any plane
    found, arm = [], np.asarray(arm)
    for axis in turns:
        across = arm - np.dot(axis, arm) * axis
        if np.any(across != 0.0):
            found += [across, np.cross(axis, across)]
    return found


def _pushes(scene: Scene, body: Body) -> list[np.ndarray]:
    """Directions in which waves can move a free body: along, or across the axes that it turns about."""
    if body.waves is None:
        return []
    yaw = 0.0 if body.attitude is None else body.attitude[2]
    axes = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    axes[np.abs(axes) < TOLERANCE] = 0.0
    waves = body.waves
    names = _pressed(scene, axes) if isinstance(waves, PressureWaves) else waves.names()
    free = np.array([body.free is None or way in body.free for way in "xyz"])
    found = [free * axes[FREEDOMS.index(name)] for name in names if name in SHIFTS]
    for name in names:
        if name in TURNS and (body.free is None or WAYS[name] in body.free):
            found += [axes[k] for k in range(3) if k != TURNS.index(name)]
    return found


def _pressed(scene: Scene, axes: np.ndarray) -> list[str]:
    """The freedoms in which the pressure of waves acts on a box: those of the way that they go."""
    assert scene.sea is not None  # the scene was checked
    way = scene.sea.direction
    along, across = np.abs(axes[:2, :2] @ [np.cos(way), np.sin(way)]) > TOLERANCE
    sees = {"surge": along, "sway": across, "heave": True, "roll": across, "pitch": along,
            "yaw": along and across}  # fmt: skip
    return [name for name, sees_it in sees.items() if sees_it]
