"""As many dimensions as a scene has: the line, plane or space that everything in it lies in."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.needs import TOLERANCE, Needs, fits, plane_normal
from lumpedcable.model.numbers import number, vector
from lumpedcable.scene import Scene

__all__ = ["Coordinates", "coordinates_of", "plane_normal"]


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
    needs = [Needs.of(scene, slack=True) for scene in scenes]
    needs += [Needs.of(scene, slack=False) for scene in changed]
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
    if not all(fits(body, axes) for each in needs for body in each.rigid):
        needed = 3
    if min(asked, default=needed) < needed:
        raise ValueError(
            f"expected at least {needed}, which the places, directions and motions of the scene "
            f"need, found {min(asked)}"
        )
    while axes.shape[1] < max([needed, *asked]):
        axes = _widened(axes)
    return Coordinates(axes, np.asarray(origin, float))


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
