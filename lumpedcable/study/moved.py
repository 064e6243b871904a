"""What a run need not compute but a picture shows: moved ships, straight cables, waves."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.moved import path_of
from lumpedcable.model.sea import sea_surface
from lumpedcable.model.ships import motion_of
from lumpedcable.physics.sea import SeaSurface
from lumpedcable.scene import Scene, SceneError, Study, load_study
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody, WinchEnd, stands_at
from lumpedcable.scene.ends import joined_to
from lumpedcable.scene.moved import MovedBody
from lumpedcable.study import compiled  # noqa: F401 - for float64

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = [
    "Moved",
    "Straight",
    "Waves",
    "moved_ships",
    "straight_lines",
    "study_of_text",
    "waves_of",
]


class Moved(NamedTuple):
    """A moved body: position (time, 3) in m; attitude (time, 3), roll, pitch, yaw in rad."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]


class Straight(NamedTuple):
    """An ideal cable: position (time, 3, 3) in m of start, trolley and end; its tension in N."""

    position: NDArray[np.float64]
    tension: float


class Waves(NamedTuple):
    """The numbers of a `SeaSurface`.

    Attributes:
        amplitude, omega, number, phase: a (m), w (rad/s), k (1/m) and e (rad), each (N,).
        direction: b, rad.
        level: m.
        ramp: s, 0 where the waves are there from the start.
        surface: itself.
    """

    amplitude: NDArray[np.float64]
    omega: NDArray[np.float64]
    number: NDArray[np.float64]
    phase: NDArray[np.float64]
    direction: float
    level: float
    ramp: float
    surface: SeaSurface

    def height(self, t: float, places: NDArray[Any]) -> NDArray[np.float64]:
        """z (m) at t (s) over or under places (n, 3) in m."""
        return np.asarray(self.surface.height(jnp.asarray(t, float), jnp.asarray(places, float)))


def waves_of(scene: Scene) -> Waves | None:
    """The waves of a scene's sea, None where it has none."""
    if scene.sea is None:
        return None
    surface = sea_surface(scene)
    sea = surface.sea
    a, w, k, e = (np.asarray(p, float) for p in (sea.amplitude, sea.omega, sea.number, sea.phase))
    ramp = 0.0 if surface.ramp is None else float(surface.ramp)
    return Waves(a, w, k, e, float(surface.direction), float(surface.level), ramp, surface)


def study_of_text(text: str) -> Study | None:
    """The study whose text in SI numbers a results file keeps; None where it cannot be read."""
    with tempfile.TemporaryDirectory(prefix="lumpedcable-") as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(text, encoding="utf-8")
        try:
            return load_study(path)
        except SceneError:
            return None


def moved_ships(scene: Scene, times: NDArray[Any]) -> dict[str, Moved]:
    """Where the moved bodies of a scene are at some times (s), by name.

    x(t) = x0 + (surge, sway, heave), turned by roll, pitch and yaw, as in `PointOfBody`.
    """
    found = {}
    for name, body in scene.bodies.items():
        if isinstance(body, MovedBody):
            freedoms = jax.vmap(motion_of(scene, body).freedoms)
            six = np.asarray(freedoms(jnp.asarray(times, float)))
            found[name] = Moved(np.asarray(body.position, float) + six[:, :3], six[:, 3:])
    return found


def straight_lines(
    scene: Scene, ships: Mapping[str, Moved], riders: Mapping[str, NDArray[Any]],
    times: NDArray[Any],
) -> dict[str, Straight]:  # fmt: skip
    """The ideal cables of a scene, which have no nodes: straight from either post to the trolley.

    Args:
        scene: one run.
        ships: from `moved_ships`, and the same of bodies that move freely.
        riders: places (time, 3) of the bodies that run on lines (m).
        times: those times (s).
    """
    found = {}
    for name, line in scene.lines.items():
        rider = next((b for b, body in scene.bodies.items()
                      if isinstance(body, CarriedBody) and body.on.line == name), None)  # fmt: skip
        winch = next((e for e in (line.start, line.end) if isinstance(e, WinchEnd)), None)
        if line.model != "ideal" or rider is None or rider not in riders or winch is None:
            continue
        trolley = np.asarray(riders[rider], float)
        posts = [_post(scene, end, ships, times) for end in (line.start, line.end)]
        places = np.stack([posts[0], trolley, posts[1]], axis=1)
        found[name] = Straight(places, float(winch.winch.tension))
    return found


def _post(
    scene: Scene, end: Any, ships: Mapping[str, Moved], times: NDArray[Any]
) -> NDArray[np.float64]:
    """The way (time, 3) of an end of an ideal cable: with a ship, or as it is held or moved itself."""
    end = stands_at(joined_to(scene.lines, end))
    name, _, point = end.partition(".") if isinstance(end, str) else ("", "", "")
    body = scene.bodies.get(name)
    if name in ships and isinstance(body, MovedBody | Body):
        ship, place = ships[name], body.points.get(point, (0.0, 0.0, 0.0))
        return ship.position + Rotation.from_euler("xyz", ship.attitude).apply(place)
    path = path_of(scene, end, Coordinates(np.eye(3), np.zeros(3)))
    if path is None:
        return np.full((len(times), 3), np.nan)
    return np.asarray(jax.vmap(path.position)(jnp.asarray(times, float)))
