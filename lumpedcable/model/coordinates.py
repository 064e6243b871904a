"""As many dimensions as a scene has: the line, plane or space that everything in it lies in."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.numbers import number, vector
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import ANGLES, WAYS, Body
from lumpedcable.scene.carried import CarriedBody, post_of
from lumpedcable.scene.joints import rigid_joints
from lumpedcable.scene.lines import (
    HarmonicMotion,
    JoinedEnd,
    MovingEnd,
    RecordedMotion,
    clamp_of,
    held_force,
    held_place,
)
from lumpedcable.scene.motions import FREEDOMS, SHIFTS, TURNS, PressureWaves
from lumpedcable.scene.moved import MovedBody

__all__ = ["Coordinates", "coordinates_of", "plane_normal"]

TOLERANCE = 1e-9  # relative: a component smaller than this is rounding


class Coordinates(NamedTuple):
    """Positions x = origin + axes q (m) with q of shape (d,) and orthonormal `axes` (3, d)."""

    axes: np.ndarray
    origin: np.ndarray

    @property
    def dimensions(self) -> int:
        """Number of coordinates d, 1 to 3."""
        return self.axes.shape[1]

    @property
    def normal(self) -> np.ndarray:
        """The axis (3,) in x, y, z about which a body turns in a plane."""
        return plane_normal(self.axes)

    def turns(self) -> Float[Array, "a 3"]:
        """What takes roll, pitch and yaw to the angles that a body has here."""
        if self.dimensions == 3:
            return jnp.eye(3)
        return jnp.asarray(self.normal)[None] if self.dimensions == 2 else jnp.zeros((0, 3))

    def vector(self, given: Sequence[Any]) -> Float[Array, " d"]:
        """A direction, velocity or force given in x, y, z, in the scene's own coordinates."""
        return jnp.asarray(self.axes).T @ vector(given)

    def point(self, point: Sequence[Any]) -> Float[Array, " d"]:
        """A place given in x, y, z (m), in the scene's own coordinates (m)."""
        return jnp.asarray(self.axes).T @ (vector(point) - jnp.asarray(self.origin))

    def points(self, places: Sequence[Sequence[Any]]) -> Float[Array, "n d"]:
        """Several places, as `point` has one."""
        table = vector([x for place in places for x in place]).reshape(-1, 3)
        return (table - jnp.asarray(self.origin)) @ jnp.asarray(self.axes)

    def over(self, z: Any) -> tuple[Float[Array, " d"], Float[Array, ""]]:
        """The upward direction (d,) and by how much (m) the origin is higher than z (m)."""
        return self.vector((0.0, 0.0, 1.0)), number(self.origin[2]) - number(z)

    def expand(self, q: np.ndarray, axis: int, place: bool = False) -> np.ndarray:
        """Arrays with d components along `axis`, with x, y, z there instead; places if `place`."""
        with np.errstate(invalid="ignore", over="ignore"):  # of a run that has blown up
            full = np.moveaxis(np.tensordot(self.axes, q, axes=(1, axis)), 0, axis)
        if not place:
            return full
        shape = [1] * full.ndim
        shape[axis] = 3
        return full + self.origin.reshape(shape)


def plane_normal(axes):
    """The axis (3,) about which a body turns in the plane of `axes` (3, 2), of numpy or of jax.

    The cross product of the second axis and the first: positive angles turn the second to the first.
    """
    one, two = np.array([1, 2, 0]), np.array([2, 0, 1])
    first, second = axes[:, 0], axes[:, 1]
    return second[one] * first[two] - second[two] * first[one]


@np.errstate(over="ignore")  # what is too far apart is told by `_basis`
def coordinates_of(scenes: Iterable[Scene], changed: Iterable[Scene] = ()) -> Coordinates:
    """The fewest coordinates that hold every place, direction and motion of all the scenes.

    Axis-aligned scenes keep their axes (x; x and z; ...); others get an orthonormal basis whose last
    axis is vertical where there is gravity or a seabed. A line that hangs slack straight above
    itself or may come to lie on a seabed is planar: it needs a direction to fold into. A scene that
    asks for more `dimensions` gets them. One with a rigid body that a plane would cut askew, turned out
    of it or not alike on both sides, is in space, whose axes are always x, y and z.

    Args:
        scenes: what is computed.
        changed: the same scenes with other numbers, which tell where those lead. That a line is slack
            in one of them alone says nothing: how far its numbers go is not known.

    Raises:
        ValueError: a scene asks for fewer dimensions than it needs, or its places are too far apart.
    """
    scenes, changed = list(scenes), list(changed)
    needs = [_Needs.of(scene, slack=True) for scene in scenes]
    needs += [_Needs.of(scene, slack=False) for scene in changed]
    places = [place for each in needs for place in each.places]
    directions = [direction for each in needs for direction in each.directions]
    folds = any(each.folds for each in needs)
    asked = [s.dimensions for s in [*scenes, *changed] if s.dimensions is not None]
    origin = places[0] if places else np.zeros(3)
    directions += [place - origin for place in places[1:]]
    axes = _basis(directions)
    needed = max(axes.shape[1], 2 if folds else 1)
    while axes.shape[1] < needed:
        axes = _widened(axes)
    if not all(_fits(body, axes) for each in needs for body in each.rigid):
        needed = 3
    if min(asked, default=needed) < needed:
        raise ValueError(
            f"expected at least {needed}, which the places, directions and motions of the scene "
            f"need, found {min(asked)}"
        )
    while axes.shape[1] < max([needed, *asked]):
        axes = _widened(axes)
    return Coordinates(axes, np.asarray(origin, float))


@dataclass
class _Needs:
    """What the coordinates of a scene must hold.

    `folds` asks for a plane at least, in which a line sags or a body goes up and down; `rigid` are
    bodies that a plane may cut askew.
    """

    places: list[np.ndarray] = field(default_factory=list)
    directions: list[np.ndarray] = field(default_factory=list)
    rigid: list[Body] = field(default_factory=list)
    folds: bool = False

    @classmethod
    def of(cls, scene: Scene, slack: bool) -> "_Needs":
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
            self.directions += _directions_of(end)
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
        if (clamp := clamp_of(end)) is not None:
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


def _fits(body: Body, axes: np.ndarray) -> bool:
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


def _directions_of(end) -> list[np.ndarray]:
    if (force := held_force(end)) is not None:
        return [np.asarray(force.direction)]
    ways = [clamp_of(end)]
    if isinstance(end, MovingEnd) and isinstance(end.motion, HarmonicMotion):
        ways += [end.motion.velocity, end.motion.amplitude]
    return [np.asarray(v) for v in ways if v is not None]


def _reaches(body: MovedBody) -> list[np.ndarray]:
    """Directions in which the points of a moved body can go."""
    names, axes = body.motion.names(), np.eye(3)
    found = [axes[FREEDOMS.index(name)] for name in names if name in FREEDOMS[:3]]
    turns = [axes[FREEDOMS.index(name) - 3] for name in names if name in FREEDOMS[3:]]
    for point in map(np.asarray, body.points.values()):
        if len(turns) > 1:
            found += list(axes)  # two turns lead out of any plane
        for axis in turns:
            arm = point - np.dot(axis, point) * axis
            if np.any(arm != 0.0):
                found += [arm, np.cross(axis, arm)]
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


def _basis(directions: list[np.ndarray]) -> np.ndarray:
    """Orthonormal columns that span the directions; x alone where there is none."""
    if not np.all(np.isfinite(directions)):
        raise ValueError("expected places whose distances are finite, found some too far apart")
    # by powers of two, which change no digit: squares of 1e308 overflow
    directions = [np.ldexp(v, -np.frexp(np.max(np.abs(v)))[1]) for v in directions]
    sizes = [np.linalg.norm(v) for v in directions]
    units = [v / s for v, s in zip(directions, sizes, strict=True) if s > 0.0]
    if not units:
        return np.eye(3)[:, :1]
    matrix = np.array(units)
    singular = np.linalg.svd(matrix, compute_uv=False)
    rank = int(np.sum(singular > TOLERANCE * singular[0]))
    used = np.flatnonzero(np.max(np.abs(matrix), axis=0) > TOLERANCE)
    if used.size == rank:
        return np.eye(3)[:, used]
    columns: list[np.ndarray] = []
    vertical = np.array([0.0, 0.0, 1.0])
    upright = any(np.linalg.norm(u - vertical) < TOLERANCE for u in units)
    for unit in ([vertical] if upright else []) + units:
        rest = unit - sum((np.dot(c, unit) * c for c in columns), np.zeros(3))
        if np.linalg.norm(rest) > 1e-6 and len(columns) < rank:
            columns.append(rest / np.linalg.norm(rest))
    if upright:
        columns = [*columns[1:], columns[0]]
    return np.array(columns).T


def _widened(axes: np.ndarray) -> np.ndarray:
    """One more dimension, horizontal where that is possible, in front of the ones there are."""
    if axes.shape[1] == 2:
        return np.eye(3)
    for unit in np.eye(3):
        rest = unit - axes @ (axes.T @ unit)
        if np.linalg.norm(rest) > 0.5:
            wider = np.column_stack([rest / np.linalg.norm(rest), axes])
            aligned = np.flatnonzero(np.max(wider, axis=1) == 1.0)
            # axes of the frame itself keep their order: x before y before z
            return np.eye(3)[:, aligned] if aligned.size == wider.shape[1] else wider
    raise AssertionError("three axes span everything")
