"""Any static scene on the live page: its numbers as sliders through the engine's own statics."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

from lumpedcable.page.bodies import quaternion
from lumpedcable.page.controls import Control, FaultError, Model
from lumpedcable.page.curves import length, sag
from lumpedcable.page.drawn import drawn_line, shown_number
from lumpedcable.page.surroundings import surroundings
from lumpedcable.results.ground import tables
from lumpedcable.scene import Scene, Study
from lumpedcable.scene.bodies import ANGLES
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.quantities import Quantity
from lumpedcable.scene.run import Reference
from lumpedcable.scene.surfaces import surfaces
from lumpedcable.scene.tree import Spot, numeric, spot_at
from lumpedcable.scene.validate import SECTIONS, read_scene
from lumpedcable.scene.writer import to_toml
from lumpedcable.study.moved import Moved, moved_ships, straight_lines
from lumpedcable.study.resting import Resting, RestingBody, RestingLine, UnrestError

__all__ = ["elastic_model"]

# what a shape at rest does not depend on, by the keys of the schema: names may be any word
_MOVING = re.compile(
    r"^(events|solver|statics|output|measures|sea)\.|\.(max_strain|damping|turn_damping|added_mass"
    r"|amplitude|period|phase|ramp|grading|speed|stop|ease|friction|inertia|response|omega)(\.|$)"
    r"|(?<!current)\.velocity(\.|$)"
)
# but where what is moved is at the start
_BEGINS = re.compile(r"(.*\.(?:motion|moved)\b.*)\.(?:amplitude|phase)(?:\.\d)?$")
# tables of many numbers
_LONG = re.compile(
    r"\.(segment_lengths|strain|tension|time|surge|sway|heave|roll|pitch|yaw)\.\d+$"
    r"|\.position\.\d+\.\d$"
)
_LISTS = ("profile.x", "profile.depth", "current.z", "coefficients")
_ANGULAR = ("attitude", "inertia", "moment", "turn_stiffness", "turn_damping")


def elastic_model(study: Study, run: int = 0) -> Model:
    """Run number `run` of a study as a model for the page.

    Raises:
        SceneError: the scene cannot be laid out.
    """
    resting = Resting(study, run)
    kinds = _kinds(study, resting.scene)
    own = resting.scene.model_copy(update={"references": _references(resting.scene, run)})
    controls = _controls(resting.scene, kinds)

    def changed(values: dict[str, float]) -> Scene:
        numbers = resting.scene.numbers()
        asked = {k: _checked(k, v, kinds[k]) for k, v in values.items() if v != numbers[k]}
        if not asked:
            return own
        first, *others = _surfaces(resting.scene) or [""]
        asked |= {key: asked[first] for key in others if first in asked}
        scene = resting.scene.with_numbers(asked).model_copy(update={"references": {}})
        # read again, as any scene is: what a number makes of others (a unit vector), and what may not be
        read, wrong = read_scene(tables(to_toml(scene)))
        if read is None:
            raise FaultError(f"{'.'.join(map(str, wrong[0].path))}: {wrong[0].message}")
        return read

    def solve(values: dict[str, float]) -> dict[str, Any]:
        scene = changed(values)
        try:
            lines, bodies = resting.solve(scene.numbers())
        except UnrestError as error:
            raise FaultError(str(error)) from error
        begins = np.zeros(1)
        ships = moved_ships(scene, begins)
        riders = {name: body.position[None] for name, body in bodies.items()}
        free = {name: Moved(riders[name], body.attitude[None]) for name, body in bodies.items()}
        for name, cable in straight_lines(scene, free | ships, riders, begins).items():
            nodes, tension = cable.position[0], np.full(2, cable.tension)
            pull = cable.tension * (nodes[1] - nodes[0]) / np.linalg.norm(nodes[1] - nodes[0])
            lines[name] = RestingLine(nodes, tension, 0.0 * tension, tension, pull)
        order = [_line_of(scene, name) for name in lines]
        lines = {name: lines[name] for _, name in sorted(zip(order, lines, strict=True))}
        return {
            "lines": [_drawn(scene, name, line) for name, line in lines.items()],
            "points": _bodies(scene, lines, bodies) + _ships(scene, ships),
            "numbers": [row for name, line in lines.items() for row in _numbers(scene, name, line)],
            "equations": [],
            "surroundings": surroundings(tables(to_toml(scene))),
        }

    def toml(values: dict[str, float]) -> str:
        return to_toml(changed(values))

    return Model("scene", "This scene, elastic", controls, solve, toml)


def _references(scene: Scene, run: int) -> dict[str, Reference]:
    """The references of one run of a sweep."""
    return {
        name: part.model_copy(
            update={"values": {key: (column[run],) for key, column in part.values.items()}}
        )
        for name, part in scene.references.items()
    }


def _surfaces(scene: Scene) -> list[str]:
    """The keys that tell of the water's surface, which has one height: the first has a slider."""
    told = surfaces(scene.bodies, scene.water, scene.sea)
    keys = (".".join(map(str, path)) for path, _ in told)
    return sorted(keys, key=lambda key: bool(_MOVING.search(_schema(key))))


def _kinds(study: Study, scene: Scene) -> dict[str, Quantity]:
    """What kind of number each key of the scene holds."""
    root = Spot(Scene, tomllib.loads(study.effective_text))
    found = {}
    for key in scene.numbers():
        spot = spot_at(root, tuple(key.split(".")))
        kind = numeric(spot) if spot is not None else None
        if isinstance(kind, Quantity):
            found[key] = kind
    return found


def _controls(scene: Scene, kinds: dict[str, Quantity]) -> list[Control]:
    """The numbers that a shape at rest depends on."""
    flows = scene.fluid is not None and scene.fluid.current is not None
    size = max((line.length for line in scene.lines.values()), default=1.0)
    found, chosen = [], {target.change for target in scene.targets.values()}
    chosen |= set(_surfaces(scene)[1:])
    numbers = scene.numbers()
    for key, value in numbers.items():
        if key in chosen or key not in kinds or _LONG.search(key) or _only_moves(key, numbers):
            continue
        *above, last = key.split(".")
        if (".drag." in key and not flows) or (last == "mass" and scene.gravity is None):
            continue
        group = ".".join(above[:2])
        words = key.removeprefix(group).lstrip(".") or last
        low, high = _range(value, kinds[key], size)
        found.append(Control(key, group, _words(key, words), kinds[key].unit, value, low, high))
    return found


def _schema(key: str) -> str:
    """A key without the names in it: those of lines, materials, bodies, targets and points."""
    first, *rest = key.split(".")
    rest = rest[1:] if first in SECTIONS else rest
    if "points" in rest:
        del rest[rest.index("points") + 1]
    return ".".join([first, *rest])


def _only_moves(key: str, numbers: Mapping[str, float]) -> bool:
    """Whether a shape at rest does not depend on a number."""
    schema = _schema(key)
    if not _MOVING.search(schema):
        return False
    begins = _BEGINS.match(key)
    if begins is None or not _BEGINS.match(schema):
        return True
    if not any(f"{begins[1]}.amplitude{k}" in numbers for k in ("", ".0")):
        return True  # it does not swing
    # what grows from rest is at its mean place at the start
    above = begins[1].split(".")
    return any(".".join([*above[:k], "ramp"]) in numbers for k in range(1, len(above) + 1))


def _words(key: str, tail: str) -> str:
    """A key below its group in words: "end fixed x" for end.fixed.0, "coefficients 1" for the first."""
    path, shown = _schema(key).split("."), tail.split(".")
    for back in range(1, len(shown) + 1):
        if not shown[-back].isdigit() or not path[-back].isdigit():
            continue
        place, above = int(shown[-back]), path[: len(path) - back]
        rows = back == 2  # velocities of a current, one at each height
        if rows or ".".join(above).endswith(_LISTS):
            shown[-back] = str(place + 1)
        else:
            shown[-back] = (ANGLES if above[-1] in _ANGULAR else "xyz")[place]
    return " ".join(shown).replace("_", " ")


def _range(value: float, kind: Quantity, size: float) -> tuple[float, float]:
    """A slider's range: from a third to three times a size, half a line's length about a place."""
    if kind.unit == "m" and kind.sign == "any":
        return value - 0.5 * size, value + 0.5 * size
    if kind.sign == "any":
        reach = abs(value) or 1.0
        return value - reach, value + reach
    high = 3.0 * value if value > 0.0 else 1.0
    high = min(high, kind.maximum) if kind.maximum is not None else high
    return (value / 3.0 if kind.sign == "positive" else 0.0), high


def _checked(key: str, value: float, kind: Quantity) -> float:
    try:
        return kind.read(value)
    except ValueError as error:
        raise FaultError(f"{key}: {error}") from None


def _line_of(scene: Scene, name: str) -> int:
    """Which line of the scene it is, or is a part of."""
    whole = name if name in scene.lines else name.rpartition("-")[0]
    return list(scene.lines).index(whole)


def _drawn(scene: Scene, name: str, line: RestingLine) -> dict[str, Any]:
    own = list(scene.lines.values())[_line_of(scene, name)]
    steps = np.linalg.norm(np.diff(line.position, axis=0), axis=1) / (1.0 + line.strain)
    ends = np.cumsum(steps)
    diameter = own.diameter or 0.0
    middles = ends - 0.5 * steps
    return drawn_line(
        name, line.position, line.tension, middles, line.ends, float(ends[-1]), diameter
    )


def _bodies(
    scene: Scene, lines: dict[str, RestingLine], resting: Mapping[str, RestingBody]
) -> list[dict[str, Any]]:
    """Point bodies at the end of a line that is tied to them, others where they are at rest."""
    found: dict[str, dict[str, Any]] = {}
    for name, line in scene.lines.items():
        for end, node in ((line.start, 0), (line.end, -1)):
            piece = name if name in lines else f"{name}-{1 if node == 0 else 2}"
            if isinstance(end, str) and end in scene.bodies and piece in lines:
                at = lines[piece].position[node]
                found.setdefault(end, {"name": end, "at": at.tolist()})
    for name, (at, turn) in resting.items():
        body = scene.bodies[name]
        size = None if body.size is None else list(body.size)
        depth = getattr(body, "depth", None)
        if depth is not None:  # what hangs under its trolley
            found[f"trolley of {name}"] = {"name": f"trolley of {name}", "at": at.tolist()}
            at = at - np.array([0.0, 0.0, depth])
        found[name] = {
            "name": name, "at": at.tolist(), "size": size, "turn": quaternion(turn).tolist()
        }  # fmt: skip
    return list(found.values())


def _ships(scene: Scene, ships: Mapping[str, Moved]) -> list[dict[str, Any]]:
    """The bodies that are moved, where they are at t = 0."""
    found = []
    for name, way in ships.items():
        body = scene.bodies[name]
        assert isinstance(body, MovedBody)
        size = None if body.size is None else list(body.size)
        found.append(
            {"name": name, "at": way.position[0].tolist(), "size": size,
             "turn": quaternion(way.attitude[0]).tolist(),
             "points": [list(point) for point in body.points.values()]}
        )  # fmt: skip
    return found


def _numbers(scene: Scene, name: str, line: RestingLine) -> list[dict[str, Any]]:
    """Read-outs of a line; that of its strain says where its material does not bear it."""
    rows = [
        ("start_tension", "tension at the start", float(line.ends[0]), "N"),
        ("end_tension", "tension at the end", float(line.ends[1]), "N"),
        ("horizontal", "horizontal tension at the start", float(np.hypot(*line.pull[:2])), "N"),
        ("length", "length as stretched", float(length(line.position[None])[0]), "m"),
    ]
    below = float(sag(line.position[None])[0])
    if np.isfinite(below):
        rows.append(("sag", "sag below the chord", below, "m"))
    strain, words = float(line.strain.max()), "largest strain"
    own = list(scene.lines.values())[_line_of(scene, name)]
    most = scene.materials[own.material].max_strain
    if strain > most:
        words = f"largest strain, beyond max_strain of its material, {100.0 * most:.3g} %"
    rows.append(("strain", words, 100.0 * strain, "%"))
    return [
        {**shown_number(f"{name}/{key}", words, value, unit), "group": name}
        for key, words, value, unit in rows
    ]
