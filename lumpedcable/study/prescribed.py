"""A cable's numbers in closed form, from what its scene prescribes.

Prescribed are the lengths of its lines, or a tension, a sag or a place that a target asks for. What is
exact here is the catenary of a line that does not stretch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lumpedcable import exact
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.study.cables import Cable

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["MODELS", "Prescribed", "models_of"]

MODELS = {
    "exact": "inextensible catenaries",
    "straight": "straight segments without weight (Lun, Li & Hou 2018, section 4)",
}
PAPER = {"S": "length", "f": "sag", "F_TA": "start_tension", "F_TB": "end_tension",
         "F_H": "horizontal_tension"}  # fmt: skip
SWAPPED = {"start_tension": "end_tension", "end_tension": "start_tension"}

Curve = exact.Highline | exact.StraightHighline


def models_of(scene: Scene, cable: Cable) -> list[str]:
    """The models that hold for a cable: none where more than weight acts on it."""
    lines = [scene.lines[name] for name in cable.lines]
    current = scene.fluid is not None and scene.fluid.current is not None
    more = current or scene.seabed is not None or any(line.bending is not None for line in lines)
    more |= scene.surface is not None
    if not cable.spans or more or any(weight <= 0.0 for weight in _weights(scene, cable)):
        return []
    loaded = cable.body is not None and _load(scene, cable) > 0.0
    return ["exact", "straight"] if loaded and _same(scene, cable) else ["exact"]


def _weights(scene: Scene, cable: Cable) -> list[float]:
    """Weights less buoyancy of the lines (N/m)."""
    gravity = scene.gravity or 0.0
    return [gravity * (scene.lines[name].mass - scene.displaced(name)) for name in cable.lines]


def _load(scene: Scene, cable: Cable) -> float:
    """Weight less buoyancy of the body between the lines (N)."""
    if cable.body is None:
        return 0.0
    body, carried = scene.bodies[cable.body], 0.0
    assert isinstance(body, Body)  # that is where lines are joined
    if scene.fluid is not None and body.volume is not None:
        carried = scene.fluid.density * body.volume
    return (scene.gravity or 0.0) * (body.mass - carried)


def _same(scene: Scene, cable: Cable) -> bool:
    """Whether both lines of a cable are alike, so that it is one line with a load on it."""
    first, *others = _weights(scene, cable)
    return all(np.isclose(other, first, rtol=1e-12) for other in others)


@dataclass(frozen=True)
class Prescribed:
    """What runs of one structure prescribe of a cable.

    Attributes:
        scenes: the runs.
        cable: the cable.
        lengths: unstretched lengths of its lines, m, each (runs,).
        span, drop: of its end from its start, m, (runs,).
        found: its numbers as computed, from which the place of a joint is taken.
    """

    scenes: Sequence[Scene]
    cable: Cable
    lengths: Sequence[NDArray[np.float64]]
    span: NDArray[np.float64]
    drop: NDArray[np.float64]
    found: Mapping[str, NDArray[np.float64]]

    def numbers(self, model: str) -> dict[str, NDArray[np.float64]]:
        """The cable's numbers by a model of `MODELS`; NaN where there is no such line."""
        names = self.cable.numbers
        table = {key: np.full(len(self.scenes), np.nan) for key in names}
        for run in range(len(self.scenes)):
            try:
                told = self._exact(run) if model == "exact" else self._straight(run)
            except ValueError:
                continue  # no line for these numbers: what statics made of them says so
            for key in names:
                table[key][run] = told[key]
        return table

    def _wanted(self, run: int, of: str, measure: str) -> float | None:
        """What a target asks for, None where there is none."""
        for target in self.scenes[run].targets.values():
            if target.of == of and target.measure == measure:
                return target.wanted
        return None

    def _ends(self, run: int) -> tuple[float | None, float | None]:
        """Tensions that targets ask for at the start and at the end (N)."""
        lines = self.cable.lines
        return (
            self._wanted(run, f"{lines[0]}.start", "tension"),
            self._wanted(run, f"{lines[-1]}.end", "tension"),
        )

    def _placed(self, run: int) -> bool:
        """Whether a target asks for the place of the body."""
        body = self.cable.body
        return body is not None and any(self._wanted(run, body, axis) is not None for axis in "xy")

    def _exact(self, run: int) -> dict[str, float]:
        l, c = float(self.span[run]), float(self.drop[run])
        scene, (at_start, at_end) = self.scenes[run], self._ends(run)
        q, S = _weights(scene, self.cable), [float(length[run]) for length in self.lengths]
        if len(S) == 1:
            sag = self._wanted(run, self.cable.lines[0], "sag")
            if at_start is not None:
                return _told(exact.highline_from_tension(l, c, q[0], at_start))
            if at_end is not None:
                return _mirrored(exact.highline_from_tension(l, -c, q[0], at_end))
            if sag is not None:
                return _told(exact.highline_from_sag(l, c, q[0], sag))
            return _told(exact.highline_from_length(l, c, q[0], S[0]))
        G = _load(scene, self.cable)
        if self._placed(run) and _same(scene, self.cable):
            x = float(self.found["joint_x"][run])
            if at_start is not None:
                return _told(exact.loaded_from_tension(l, c, q[0], G, x, at_start))
            if at_end is not None:
                return _mirrored(exact.loaded_from_tension(l, -c, q[0], G, l - x, at_end))
            return _told(exact.loaded_from_length(l, c, q[0], G, x, sum(S)))
        if at_end is not None:
            return _told(exact.dragged_from_tension(l, c, q[0], S[0], q[1], at_end, G))
        return _told(exact.dragged_from_length(l, c, q[0], S[0], q[1], S[1], G))

    def _straight(self, run: int) -> dict[str, float]:
        l, c = float(self.span[run]), float(self.drop[run])
        at_start, at_end = self._ends(run)
        G, x = _load(self.scenes[run], self.cable), float(self.found["joint_x"][run])
        if at_start is not None:
            return _told(exact.straight_from_tension(l, c, G, x, at_start))
        if at_end is not None:
            return _mirrored(exact.straight_from_tension(l, -c, G, l - x, at_end))
        S = sum(float(length[run]) for length in self.lengths)
        return _told(exact.straight_from_length(l, c, G, x, S))


def _told(line: Curve) -> dict[str, float]:
    """The numbers of a curve by the names that results have for them."""
    x, z = line.middle
    numbers = {PAPER[key]: float(value) for key, value in line.numbers().items()}
    first = np.hypot(x, z) if isinstance(line, exact.StraightHighline) else line.parts[0].length
    return numbers | {"joint_x": float(x), "joint_z": float(z), "joint_length": float(first)}


def _mirrored(line: Curve) -> dict[str, float]:
    """The numbers of a curve that was worked out from its other end."""
    told = _told(line)
    x, z = float(line.span) - told["joint_x"], told["joint_z"] + float(line.drop)
    swapped = {SWAPPED.get(key, key): value for key, value in told.items()}
    rest = told["length"] - told["joint_length"]
    return swapped | {"joint_x": x, "joint_z": z, "joint_length": rest}
