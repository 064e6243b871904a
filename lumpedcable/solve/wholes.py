"""Lines as they are laid out at first: each by itself, those that are joined rigidly as one."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.assemble import make_line, segment_lengths
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.ends import Joined
from lumpedcable.model.layout import Layout, Piece
from lumpedcable.model.line import Line
from lumpedcable.model.model import LineEnd, Model
from lumpedcable.physics.bending import Bending
from lumpedcable.physics.load import AbstractLoad
from lumpedcable.physics.weight import Weight
from lumpedcable.scene import Scene

__all__ = ["Whole", "wholes_of"]


@dataclass(frozen=True)
class Whole:
    """Lines of a scene that are laid out as one, from one end to the other.

    `lines` are the pieces of each, from its start to its end, and `forward` says whether it leads on in
    that direction; `outer` are the two ends of the whole.
    """

    lines: tuple[tuple[Piece, ...], ...]
    forward: tuple[bool, ...]
    outer: tuple[LineEnd, LineEnd]

    def shared(self, path: Float[Array, "d nodes"]) -> Iterator[tuple[str, Float[Array, "d n"]]]:
        """What each piece has of the nodes (m) of the whole."""
        done = 0
        for pieces, forward in zip(self.lines, self.forward, strict=True):
            count = pieces[-1].first + pieces[-1].segments
            own = path[:, done : done + count + 1]
            own, done = own if forward else own[:, ::-1], done + count
            for piece in pieces:
                yield piece.name, own[:, piece.first : piece.first + piece.segments + 1]

    def line(self, scene: Scene, coordinates: Coordinates) -> Line:
        """One line for all: of the weight and the softness in bending that they have on average."""
        parts = [_line(scene, coordinates, pieces) for pieces in self.lines]
        if len(parts) == 1:
            return parts[0]
        each = [
            part.segment_length if forward else part.segment_length[::-1]
            for part, forward in zip(parts, self.forward, strict=True)
        ]
        length = jnp.concatenate(each)
        whole = make_line(scene, self.lines[0][0].line, length, length.shape[0], coordinates)
        shares = jnp.stack([jnp.sum(own) for own in each]) / jnp.sum(length)
        clamps = [
            None if (clamp := part.clamp(node)) is None else clamp if forward else -clamp
            for part, forward, node in (
                (parts[0], self.forward[0], 0 if self.forward[0] else -1),
                (parts[-1], self.forward[-1], -1 if self.forward[-1] else 0),
            )
        ]
        loads = tuple(_averaged(load, parts, shares, clamps) for load in whole.loads)
        return replace(whole, loads=loads)


def _averaged(
    load: AbstractLoad, parts: list[Line], shares: Float[Array, " n"], clamps: list
) -> AbstractLoad:
    """A load of the whole from those of the lines that have shares (-) in its length."""
    if isinstance(load, Bending):
        softness = jnp.stack(
            [1.0 / bending.EI for p in parts if (bending := p.bending) is not None]
        )
        return Bending(1.0 / jnp.dot(shares, softness), *clamps)
    if isinstance(load, Weight):
        own = [x.per_length for part in parts for x in part.loads if isinstance(x, Weight)]
        return Weight(shares @ jnp.stack(own))
    return load


def wholes_of(
    scene: Scene, layout: Layout, model: Model, given: Collection[int]
) -> dict[str, Whole]:
    """What is laid out as one, by the name of its first line.

    Lines go on into each other at rigid joints at which nothing else is: no third line, no mass, no
    force, and, `given` being the junctions that have one, no place.
    """
    beside: dict[LineEnd, LineEnd] = {}
    for one, other in model.rigid_joints:
        end = model.end(*one)
        if isinstance(end, Joined) and end.junction not in given:
            junction = model.junctions[end.junction]
            if junction.mass is None and junction.load is None and len(junction.members) == 2:
                beside |= {one: other, other: one}
    line_of = {piece.name: piece.line for piece in layout.pieces}

    def beyond(name: str, node: int) -> Iterator[tuple[str, int]]:
        """The lines that follow out of an end, and the ends by which each is entered."""
        while (end := beside.get(layout.ends_of(name)[node])) is not None:
            name, node = line_of[end[0]], -1 - end[1]
            if name in taken:
                return
            taken.add(name)
            yield name, end[1]

    found, taken = {}, set()
    for name in scene.lines:
        if name in taken or not layout.of_line(name):
            continue
        taken.add(name)
        before = [(other, node == -1) for other, node in beyond(name, 0)]
        after = [(other, node == 0) for other, node in beyond(name, -1)]
        names, forward = zip(*before[::-1], (name, True), *after, strict=True)
        first, last = layout.ends_of(names[0]), layout.ends_of(names[-1])
        outer = first[0 if forward[0] else 1], last[1 if forward[-1] else 0]
        found[names[0]] = Whole(tuple(layout.of_line(n) for n in names), forward, outer)
    return found


def _line(scene: Scene, coordinates: Coordinates, pieces: tuple[Piece, ...]) -> Line:
    """One of the scene's lines without its cuts."""
    lengths = [jnp.broadcast_to(segment_lengths(scene, p), (p.segments,)) for p in pieces]
    count = sum(piece.segments for piece in pieces)
    return make_line(scene, pieces[0].line, jnp.concatenate(lengths), count, coordinates)
