"""The scene: everything that one run needs to know, in SI units."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.environment import Fluid, Seabed
from lumpedcable.scene.events import Event
from lumpedcable.scene.lines import Line, RecordedMotion, tie_of
from lumpedcable.scene.materials import Material, TableMaterial
from lumpedcable.scene.part import Name, Part, Text, children
from lumpedcable.scene.quantities import Acceleration, Count
from lumpedcable.scene.run import Output, Reference, Solver, Statics
from lumpedcable.scene.targets import Target

_NOT_STRUCTURE = frozenset({"title", "references"})
_FILE_DATA = frozenset({"file", "strain", "tension", "time", "position"})


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
    seabed: Seabed | None = None
    """The bed that lines can rest on. Absent: none."""
    materials: dict[Name, Material] = Field(default_factory=dict)
    """Tension laws by name."""
    lines: dict[Name, Line] = Field(default_factory=dict)
    """Lines by name."""
    bodies: dict[Name, Body] = Field(default_factory=dict)
    """Bodies by name."""
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

    def body_point(self, end: Any) -> tuple[str, str | None] | None:
        """Return the rigid body, and the point of it or None for its centre, that an end names.

        None where the end is anything else.
        """
        name, dot, point = (tie_of(end) or "").partition(".")
        if name in self.lines or name not in self.bodies or not self.bodies[name].rigid:
            return None
        return name, (point if dot else None)

    def numbers(self) -> dict[str, float]:
        """Return every float of the scene by dotted path, vectors and lists by index.

        Left out are counts, texts, references, and data read from files (see :meth:`skeleton`).
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
        """Return a JSON text of everything but the values of :meth:`numbers`, which become null.

        Two scenes with equal skeletons have the same structure: one compiled program does for
        both. Data read from a file stand as a digest of their values.
        """
        return json.dumps(_bones(self), separators=(",", ":"))


def _below(part: Any) -> Iterator[tuple[str, Any]]:
    """Yield the structural (key, value) pairs below a part, keys as text."""
    from_file = isinstance(part, TableMaterial | RecordedMotion) and part.file is not None
    data = _FILE_DATA if from_file else frozenset()
    for key, value in children(part):
        if key in data or (isinstance(part, Scene) and key in _NOT_STRUCTURE):
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
        if isinstance(value, TableMaterial) and value.file is not None:
            bones["data"] = _digest(value.strain, value.tension)
        if isinstance(value, RecordedMotion) and value.file is not None:
            bones["data"] = _digest(value.time, value.position)
        return bones
    return value


def _digest(*columns: tuple[Any, ...]) -> str:
    return hashlib.sha256(repr(columns).encode()).hexdigest()


def _replaced(value: Any, tree: dict[str, Any], path: str) -> Any:
    """Return ``value`` with the leaves of ``tree`` put in."""
    known = {str(key): key for key, _ in children(value)}
    changed = {}
    for text, branch in tree.items():
        here = f"{path}.{text}" if path else text
        if text not in known:
            raise KeyError(here)
        key = known[text]
        inside = dict(children(value))[key] if isinstance(branch, dict) else None
        changed[key] = _replaced(inside, branch, here) if isinstance(branch, dict) else branch
    if isinstance(value, Part):
        return value.model_copy(update=changed)
    if isinstance(value, dict):
        return {**value, **changed}
    return tuple(changed.get(i, child) for i, child in enumerate(value))
