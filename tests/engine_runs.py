"""Scenes run by the engine through its own front door: TOML in, results file out, read back."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.results import open_result
from lumpedcable.scene import Scene, Study, load_study
from lumpedcable.solve import reverse
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE, Structure
from lumpedcable.study.outcome import Outcome
from lumpedcable.study.run import run_study

# Zhu, Yin & Shen 2018, eq. 5 and table 1; without weight and water the line of exact waves
NYLON = """
[materials.nylon]
law = "tanh"
p1 = "270.3 kN"
p2 = 10.2
p3 = -2.128
p4 = "262.7 kN"
p5 = "135.5 N"
tension_only = false
"""


def nylon_rope(segments, duration, every="1 ms"):
    """The paper's rope of so many segments, which parts at its end."""
    return f"""{NYLON}
[lines.rope]
material = "nylon"
length = "60 m"
segments = {segments}
mass = "2.238 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ held = {{ pretension = "45 kN", direction = [1, 0, 0] }} }}

[events.break]
breaks = "rope.end"
time = "5 ms"

[output]
duration = "{duration}"
every = "{every}"
"""


ROPE = nylon_rope(100, "20 ms")
# a line of Hooke's law with round numbers: 1000 m/s, 50 m/s when it is let go
HOOKE = """
[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "hooke"
length = "100 m"
segments = 50
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "50 kN", direction = [1, 0, 0] } }

[events.break]
breaks = "rope.end"
time = 0

[output]
duration = "100 ms"
every = "1 ms"
"""


# lines that bend and hardly stretch, what else there is before them
STEEL = """
{more}
[materials.steel]
law = "linear"
EA = 1e5
[solver]
waves = "plain"
[output]
duration = 0.05
every = 0.0025
quantities = ["position", "velocity", "energy"]
"""


def fixed(*place):
    """An end that is fixed at a place (m)."""
    return f"{{ fixed = {list(map(float, place))} }}"


def line_text(name, material, length, segments, mass, start, end, more=""):
    """The table of a line of `length` (m) and `mass` (kg/m) between two ends as a scene writes them."""
    return f"""
[lines.{name}]
material = "{material}"
length = {length}
segments = {segments}
mass = {mass}
start = {start}
end = {end}
{more}
"""


def sliding_block(
    *, speed, end='"free"', line=1e-3, face=0.5, volume=None, step, duration, every, more=""
):
    """A block (1 t) that slides along x with friction 0.4, a rod of `line` (kg) at its face.

    Speed in m/s, the face's distance in m, a volume in m^3 where the block is in water.
    """
    water = "" if volume is None else "[water]\ndensity = 1000\n"
    wet = "" if volume is None else f"volume = {volume}"
    return f"""
gravity = 9.81
{water}[seabed]
height = -5                                     # the line hangs above it
stiffness = "100 kPa"
[materials.stiff]
law = "inextensible"
[lines.tow]
material = "stiff"
length = "1 m"
segments = 1
mass = "{line} kg/m"
diameter = "1 mm"
start = "block.face"
end = {end}
[bodies.block]
mass = "1 t"
position = [0, 0, {face}]
velocity = [{speed}, 0, 0]
points = {{ face = [{face}, 0, 0] }}
free = ["x"]
friction = 0.4
{wet}
[solver]
step = "{step}"
[output]
duration = "{duration}"
every = "{every}"
{more}"""


@dataclass(frozen=True)
class Ran:
    """A finished study: outcomes, and histories with the run first (run, time, ...)."""

    outcomes: list[Outcome]
    time: np.ndarray
    lines: dict[str, dict[str, np.ndarray]]
    energy: dict[str, np.ndarray]
    attributes: dict[str, Any]
    places: dict[str, np.ndarray] = field(default_factory=dict)
    bodies: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        """A field of the only line, or of a named one: "velocity", "rope-1.velocity"."""
        line, _, quantity = name.rpartition(".")
        return self.lines[line or next(iter(self.lines))][quantity]

    @property
    def statuses(self) -> list[str]:
        return [outcome.status.name for outcome in self.outcomes]


def study_of(folder: Path, text: str, *overrides: str) -> Study:
    """The study of a scene text; overrides as on the command line, "key=value"."""
    path = folder / "scene.toml"
    path.write_text(text, encoding="utf-8")
    return load_study(path, list(overrides))


def run_text(folder: Path, text: str, *overrides: str) -> Ran:
    """Run a scene text and read everything back."""
    return run_scenes(folder, study_of(folder, text, *overrides))


def run_scenes(folder: Path, study: Study) -> Ran:
    """Run a study and read everything back."""
    target = folder / "result.h5"
    outcomes = run_study(study, target)
    with open_result(target) as found:
        lines, places = {}, {}
        for name in found.lines:
            line = found.line(name)
            lines[name] = {key: line.field(key) for key in line.fields}
            places[name] = line.unstretched_position()
        energy = {term: found.energy(term) for term in found.energy_terms}
        kinds = ("position", "velocity", "attitude", "turning")
        bodies = {name: {kind: found.body(name, kind) for kind in kinds} for name in found.bodies}
        return Ran(outcomes, found.time, lines, energy, dict(found.attributes), places, bodies)


def scene_of(folder: Path, text: str, *overrides: str) -> Scene:
    """The one scene of a text without a sweep."""
    return study_of(folder, text, *overrides).runs[0]


def equilibrium_of(scene: Scene):
    """The engine's equilibrium of a scene, and the coordinates that it is computed in."""
    coordinates = coordinates_of([scene])
    structure = Structure(scene.skeleton(), make_layout(scene), scene)
    return _equilibrium(structure, *coordinates, scene.numbers()), coordinates


@partial(jax.jit, static_argnames=("structure",), compiler_options=RUN_ONCE)
def _equilibrium(structure, axes, origin, numbers):
    scene = structure.scene.with_numbers(numbers)
    return start_of(scene, structure.layout, Coordinates(axes, origin))


def nodes_in_space(found, coordinates, name: str = "rope") -> np.ndarray:
    """Positions (3, nodes) in m of a line at the engine's equilibrium."""
    reference = np.asarray(found.model.lines[name].reference)
    return coordinates.expand(reference, 0, place=True)


def length_of(function, *arguments) -> int:
    """How many operations a function has when it is traced, those in its loops with them."""

    def count(jaxpr):
        inside = [
            count(p.jaxpr) for e in jaxpr.eqns for p in e.params.values() if hasattr(p, "jaxpr")
        ]
        return len(jaxpr.eqns) + sum(inside)

    return count(jax.make_jaxpr(function)(*arguments).jaxpr)


def order_of(errors, factors) -> np.ndarray:
    """Observed orders between successive errors of meshes or steps finer by `factors`."""
    errors = np.asarray(errors, float)
    return np.log(errors[:-1] / errors[1:]) / np.log(factors)


def keep_blocks_alone(monkeypatch):
    """Reverse mode in blocks of the root of the turns, however little all of them would take."""
    monkeypatch.setattr(reverse, "KEPT", 0)
    monkeypatch.setattr(reverse, "BLOCK", 0)
