"""What a results file does not hold but its scene tells: moved ships, cables between them, waves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.reader import ResultFile

if TYPE_CHECKING:
    from lumpedcable.study.moved import Waves

__all__ = ["StraightLine", "Unrecorded"]

Array = NDArray[Any]


class StraightLine:
    """An ideal cable, read as `LineData` is: straight from its start to the trolley and to its end."""

    nodes = 3

    def __init__(self, places: Mapping[int, Array], tensions: Mapping[int, float]) -> None:
        """Places (time, 3, 3) in m and the tension in N, by run."""
        self._places, self._tensions = places, tensions

    def node_count(self, run: int) -> int:
        """All are there in every run."""
        return self.nodes

    def has(self, name: str) -> bool:
        """Whether it has a field."""
        return name in ("position", "tension")

    def position(self, run: int) -> Array:
        """Places (m), (time, 3, 3)."""
        return self._places[run]

    def tension(self, run: int) -> Array:
        """Its tension on both sides of the trolley (N), (time, 2)."""
        return np.full((len(self._places[run]), 2), self._tensions[run])

    def velocity(self, run: int) -> Array:
        """None are known: `has` says so."""
        raise KeyError("velocity")

    def unstretched_position(self, run: int) -> Array:
        """Distances of start, trolley and end along it (m) when the run starts; it cannot stretch."""
        steps = np.linalg.norm(np.diff(self._places[run][0], axis=0), axis=-1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def unstretched_segment(self, run: int) -> Array:
        """The same, middles of its two parts."""
        places = self.unstretched_position(run)
        return 0.5 * (places[1:] + places[:-1])


class Unrecorded:
    """Ships, ideal cables and waves of the runs that are shown, worked out from the scene.

    Attributes:
        ships: by name, place (m) and attitude (rad), each (run, time, 3).
        lines: by name.
        waves: by run; none where the sea is at rest.
    """

    def __init__(self, result: ResultFile, runs: Array, scene: Mapping[str, Any]) -> None:
        """Read the scene again, where it has moved bodies, ideal lines or waves."""
        self.waves: dict[int, Waves] = {}
        self.ships: dict[str, tuple[Array, Array]] = {}
        self.lines: dict[str, StraightLine] = {}
        bodies, lines = scene.get("bodies") or {}, scene.get("lines") or {}
        moved = [name for name, body in bodies.items() if "motion" in body]
        ideal = [name for name, line in lines.items() if line.get("model") == "ideal"]
        if moved or ideal or "sea" in scene:
            self._work_out(result, runs)

    def _work_out(self, result: ResultFile, runs: Array) -> None:
        from lumpedcable.study.moved import (
            Moved,
            moved_ships,
            straight_lines,
            study_of_text,
            waves_of,
        )

        study = study_of_text(str(result.attributes.get("effective_scene", "")))
        if study is None or len(study.runs) != result.runs:
            return
        ways: dict[str, list[tuple[Array, Array]]] = {}
        places: dict[str, dict[int, Array]] = {}
        tensions: dict[str, dict[int, float]] = {}
        for run in map(int, runs):
            scene = study.runs[run]
            waves = waves_of(scene)
            if waves is not None:
                self.waves[run] = waves
            ships = moved_ships(scene, result.time)
            for name, way in ships.items():
                ways.setdefault(name, []).append((way.position, way.attitude))
            riders = {name: result.body(name, "position", run) for name in result.bodies}
            free = {n: Moved(p, result.body(n, "attitude", run)) for n, p in riders.items()}
            for name, line in straight_lines(scene, free | ships, riders, result.time).items():
                places.setdefault(name, {})[run] = line.position[result.frames]
                tensions.setdefault(name, {})[run] = line.tension
        for name, way in ways.items():
            position, attitude = (np.array(part) for part in zip(*way, strict=True))
            self.ships[name] = (position, attitude)
        self.lines = {name: StraightLine(places[name], tensions[name]) for name in places}
