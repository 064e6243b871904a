"""The whole scene as one mechanical system: its lines, their ends, junctions, bodies and measures."""

import abc
from collections.abc import Iterator
from dataclasses import replace

import equinox as eqx
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, RigidBody
from lumpedcable.model.ends import Driven, End, Joined, Junction, Loaded, Release
from lumpedcable.model.line import Line, placed
from lumpedcable.model.riders import Coupled
from lumpedcable.model.state import Seen
from lumpedcable.physics.relaxation import Memory

__all__ = ["AbstractMeasured", "LineEnd", "Model", "Vectors"]

Vectors = dict[str, Float[Array, "d nodes"]]
LineEnd = tuple[str, int]
"""An end of a line: its name, and 0 for its start or -1 for its end."""


class AbstractMeasured(eqx.Module):
    """A number that a scene asks for."""

    @abc.abstractmethod
    def value(self, model: "Model", t: Float[Array, ""], seen: Seen) -> Float[Array, ""]:
        """The number at t (s), in SI units."""


class Model(eqx.Module):
    """Lines, what holds their ends, the junctions between them, and bodies.

    `up` (d,) is the vertical unit vector in the scene's own coordinates and `base` the height of
    their origin (m): heights are base + up . x. They serve currents, None where there is none.
    `couplings` are bodies that run on cables, `measures` the numbers that the scene asks for. `cuts` are
    the ends before and after the seam of a line that has one. At `rigid_joints` two lines bend as one.
    """

    lines: dict[str, Line]
    ends: dict[str, tuple[End, End]]
    junctions: tuple[Junction, ...]
    up: Float[Array, " d"] | None = None
    base: Float[Array, ""] | None = None
    bodies: dict[str, AbstractBody] = eqx.field(default_factory=dict)
    couplings: tuple[Coupled, ...] = ()
    measures: dict[str, AbstractMeasured] = eqx.field(default_factory=dict)
    cuts: dict[str, tuple[Joined, Joined]] = eqx.field(default_factory=dict)
    rigid_joints: tuple[tuple[LineEnd, LineEnd], ...] = eqx.field(static=True, default=())

    @property
    def rigid(self) -> bool:
        """Whether it has rigid bodies: a step then has thousands of operations."""
        return any(isinstance(body, RigidBody) for body in self.bodies.values())

    def end(self, name: str, node: int) -> End:
        """What is at an end of a line."""
        return (self.ends[name] + self.cuts.get(name, ()))[self.lines[name].ends.index(node)]

    def outer_ends(self) -> Iterator[tuple[str, int, End]]:
        """Starts (0) and ends (-1) of lines, without those at cuts: (line, its end, what is there)."""
        for name, pair in self.ends.items():
            for node, end in zip((0, -1), pair, strict=True):
                yield name, node, end

    def breakable(self) -> list[tuple[str, int, End]]:
        """Driven, joined or attached ends that can break: (line, its end, what is there)."""
        return [
            (name, node, end)
            for name, line in self.lines.items()
            for node in line.ends
            if (end := self.end(name, node)).release is not None and not isinstance(end, Loaded)
        ]

    def placed(self, places: Vectors) -> "Model":
        """The model with the references of its lines at other places (m)."""
        lines = {name: placed(self.lines[name], places[name]) for name in self.lines}
        return eqx.tree_at(lambda m: m.lines, self, lines)

    def with_low(self, low: Vectors) -> "Model":
        """The model for displacements of which rounding has left out `low` (m); {}: of nothing."""
        if not low:
            return self
        lines = {name: replace(line, low=low[name]) for name, line in self.lines.items()}
        return replace(self, lines=lines)

    def remembering(self, memory: dict[str, Float[Array, "k n"]] | dict[str, Memory]) -> "Model":
        """The model whose branches' dashpots are stretched so (-), or stood so half a step ago.

        {}: no line has branches.
        """
        if not memory:
            return self
        kept = {n: x if isinstance(x, Memory) else Memory(x) for n, x in memory.items()}
        lines = {
            name: replace(line, memory=kept[name]) if name in kept else line
            for name, line in self.lines.items()
        }
        return replace(self, lines=lines)

    def leavers(self, junction: int):
        """The ends at a junction that can break away from it, and their releases."""
        for name, node in self.junctions[junction].members:
            end = self.end(name, node)
            if end.release is not None:
                yield (name, node), end.release

    def carrier(self, index: int) -> tuple[str, int]:
        """The end at a junction that stays for good: it keeps its mass and its loads (the first such).

        A layout leaves one everywhere.
        """
        leaving = {member for member, _ in self.leavers(index)}
        return next(m for m in self.junctions[index].members if m not in leaving)

    def parting(self, index: int) -> Release | None:
        """The break that leaves one end and nothing else at a junction, None where none does."""
        junction = self.junctions[index]
        releases = [release for _, release in self.leavers(index)]
        bare = junction.mass is None and junction.load is None and len(junction.members) == 2
        return releases[0] if bare and len(releases) == 1 else None

    def driven(self) -> Iterator[tuple[str, int, Driven]]:
        """The ends that are held at a place or moved: (line, its end, what is there)."""
        for name, node, end in self.outer_ends():
            if isinstance(end, Driven):
                yield name, node, end
