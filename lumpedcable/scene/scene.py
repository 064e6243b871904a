"""The scene: everything that one run needs to know, in SI units."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import clamp_of, tie_of
from lumpedcable.scene.environment import Fluid, Sea, Seabed
from lumpedcable.scene.events import Event
from lumpedcable.scene.lines import Line
from lumpedcable.scene.materials import Material
from lumpedcable.scene.measures import Measure
from lumpedcable.scene.moved import AnyBody, MovedBody
from lumpedcable.scene.part import Name, Part, Text, children
from lumpedcable.scene.quantities import Acceleration, Count
from lumpedcable.scene.run import Output, Reference, Solver, Statics
from lumpedcable.scene.surfaces import surfaces
from lumpedcable.scene.targets import Target

_NOT_STRUCTURE = frozenset({"title", "references"})


class Scene(Part):
    """One run: lines and bodies, what surrounds them, what happens, how it is computed."""

    title: Text = ""
    """A line of text for people."""
    dimensions: Annotated[int, Count(1, 3)] | None = None
    """Least number of dimensions to compute in. Absent: as many as the scene needs."""
    gravity: Acceleration | None = None
    """Acceleration of gravity in m/s2, along -z. Absent: none."""
    water: Fluid | None = None
    """Water around everything. Absent: none."""
    air: Fluid | None = None
    """Air around everything, instead of water. Absent: none."""
    sea: Sea | None = None
    """Waves that move ships and the water around lines. Absent: none."""
    seabed: Seabed | None = None
    """The bed that lines can rest on. Absent: none."""
    materials: dict[Name, Material] = Field(default_factory=dict)
    """Tension laws by name."""
    # not a required key, so that a file without is told in words
    lines: dict[Name, Line] = Field(default_factory=dict, json_schema_extra={"minProperties": 1})
    """Lines by name."""
    bodies: dict[Name, AnyBody] = Field(default_factory=dict)
    """Bodies by name."""
    measures: dict[Name, Measure] = Field(default_factory=dict)
    """Numbers that are asked for, by name."""
    events: dict[Name, Event] = Field(default_factory=dict)
    """Events by name."""
    targets: dict[Name, Target] = Field(default_factory=dict)
    """What statics must reach by choosing lengths of lines, by name."""
    solver: Solver = Solver()
    """How time is stepped."""
    statics: Statics = Statics()
    """How the start state is found."""
    output: Output
    """What is kept."""
    references: dict[Name, Reference] = Field(default_factory=dict)
    """Numbers from elsewhere."""

    @property
    def fluid(self) -> Fluid | None:
        """The water or the air, or None."""
        return self.water if self.water is not None else self.air

    def displaced(self, line: str) -> float:
        """Return the mass of the fluid that a line displaces, in kg/m."""
        return 0.0 if self.fluid is None else self.fluid.density * self.lines[line].section

    @property
    def surface(self) -> float | None:
        """Height z in m of the surface at which the water ends, None where the fluid is everywhere."""
        return None if self.water is None else self.water.surface

    @property
    def sea_level(self) -> float:
        """Height z in m of the water's surface at rest; 0 where nothing tells of it."""
        return next((z for _, z in surfaces(self.bodies, self.water, self.sea)), 0.0)

    def point_of(self, end: Any) -> tuple[MovedBody, tuple[float, float, float]] | None:
        """Return the moved body that an end names a point of, "ship.post", and that point in m."""
        name, _, point = (tie_of(end) or "").partition(".")
        body = self.bodies.get(name)
        if not isinstance(body, MovedBody) or point not in body.points:
            return None
        return body, body.points[point]

    def body_point(self, end: Any) -> tuple[str, str | None] | None:
        """Return the rigid body, and the point of it or None for its centre, that an end names.

        None where the end is anything else.
        """
        name, dot, point = (tie_of(end) or "").partition(".")
        body = self.bodies.get(name)
        if name in self.lines or not isinstance(body, Body) or not body.rigid:
            return None
        return name, (point if dot else None)

    def on_body(self, end: Any) -> bool:
        """Return whether an end goes where a rigid body or a moved one does."""
        return self.point_of(end) is not None or self.body_point(end) is not None

    def clamp(self, end: Any) -> NDArray[np.float64] | None:
        """Return the direction (3,) that a line with bending keeps at an end at the start, or None."""
        clamp = clamp_of(end)
        tied = self.body_point(end)
        if clamp is None or tied is None:
            return None if clamp is None else np.asarray(clamp)
        body = self.bodies[tied[0]]
        assert isinstance(body, Body)
        return body.turned @ np.asarray(clamp)

    @property
    def nodes(self) -> int:
        """Number of nodes of all lines, each line's counted by itself."""
        return sum(1 + line.count for line in self.lines.values())

    @property
    def settling(self) -> list[str]:
        """The rigid bodies that statics brings to rest."""
        return [n for n, body in self.bodies.items() if isinstance(body, Body) and body.settle]

    @property
    def steep(self) -> list[str]:
        """The bodies that start with a pitch that is none in space."""
        return [n for n, body in self.bodies.items() if isinstance(body, Body) and body.steep]

    @property
    def top_heavy(self) -> dict[str, dict[str, float]]:
        """The hulls that do not right themselves: their metacentric heights in m by roll and pitch."""
        found = {}
        for name, body in self.bodies.items():
            if isinstance(body, Body) and self.fluid is not None and self.gravity is not None:
                ways = body.righting(self.fluid.density, self.gravity)
                over = {way: height for way, (height, moment) in ways.items() if moment < 0.0}
                found |= {name: over} if over else {}
        return found

    def numbers(self) -> dict[str, float]:
        """Return every float of the scene by dotted path, vectors and lists by index.

        Left out are counts, texts, references, what pictures alone read, what results are compared
        with, and data read from files (see :meth:`skeleton`).
        """
        return dict(_floats(self, ""))

    def with_numbers(self, numbers: Mapping[str, Any]) -> Scene:
        """Return a copy with the values at those paths replaced.

        Nothing is converted or checked, so that the values may be traced arrays.

        Args:
            numbers: dotted paths, as in :meth:`numbers`, to values.

        Raises:
            KeyError: a path that the scene does not have.
        """
        tree: dict[str, Any] = {}
        for path, value in numbers.items():
            *parents, leaf = path.split(".")
            branch = tree
            for key in parents:
                branch = branch.setdefault(key, {})
            branch[leaf] = value
        return _replaced(self, tree, "")

    def skeleton(self) -> str:
        """Return a JSON text of all structure, with the values of :meth:`numbers` as null.

        Two scenes with equal skeletons have the same structure: one compiled program does for
        both. Data read from a file stand as a digest of their values.
        """
        return json.dumps(_bones(self), separators=(",", ":"))


def _below(part: Any) -> Iterator[tuple[str, Any]]:
    """Yield the structural (key, value) pairs below a part, keys as text."""
    left_out: tuple[str, ...] = ()
    if isinstance(part, Part):
        left_out = part.DRAWN + part.JUDGED + (part.FILE if part.from_file() else ())
    for key, value in children(part):
        if key in left_out or (isinstance(part, Scene) and key in _NOT_STRUCTURE):
            continue
        yield str(key), value


def _floats(value: Any, path: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, float):
        yield path, value
        return
    for key, child in _below(value):
        yield from _floats(child, f"{path}.{key}" if path else key)


def _bones(value: Any) -> Any:
    if isinstance(value, float):
        return None
    if isinstance(value, tuple):
        return [_bones(child) for child in value]
    if isinstance(value, Part | dict):
        bones = {key: _bones(child) for key, child in _below(value)}
        if isinstance(value, Part) and value.from_file():
            bones["data"] = _digest(*(getattr(value, key) for key in value.from_file()))
        return bones
    return value


def _digest(*columns: Any) -> str:
    return hashlib.sha256(repr(columns).encode()).hexdigest()


def _replaced(value: Any, tree: dict[str, Any], path: str) -> Any:
    """Return ``value`` with the leaves of ``tree`` put in."""
    known = {str(key): (key, child) for key, child in children(value)}
    changed = {}
    for text, branch in tree.items():
        here = f"{path}.{text}" if path else text
        if text not in known:
            raise KeyError(here)
        key, child = known[text]
        changed[key] = _replaced(child, branch, here) if isinstance(branch, dict) else branch
    if isinstance(value, Part):
        return value.model_copy(update=changed)
    if isinstance(value, dict):
        return {**value, **changed}
    return tuple(changed.get(i, child) for i, child in enumerate(value))
