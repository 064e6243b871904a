"""Numbers of a place along a line: its tension, its bending moment, its speed, its motion."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import live_line, reel_of
from lumpedcable.model.layout import Layout
from lumpedcable.model.line import Line
from lumpedcable.model.model import AbstractMeasured, Model
from lumpedcable.model.numbers import number
from lumpedcable.model.state import Seen
from lumpedcable.physics.linear import pick
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.seam import Seam
from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.physics.vectors import dot, size
from lumpedcable.scene.measures import LineMeasure, MotionMeasure, PlaceKind

__all__ = [
    "Later",
    "PlaceMeasured",
    "along_axis",
    "asks_for_moments",
    "place_measured",
    "segment_sizes",
]


class PlaceMeasured(AbstractMeasured):
    """Tension (N), bending moment (N m) or motion (m/s, m) at a place of a line.

    `place` (m) is the unstretched distance from its start, None at an end.
    The line is as long as it has been paid out. `pieces` are the parts of the line, from its
    start on; `side` 0 or -1 stands for an end of it. A vector v is told by its size or, with `along`,
    by along . v; of a position x = `origin` + along . q (m), from the coordinates q.
    """

    kind: PlaceKind = eqx.field(static=True)
    pieces: tuple[str, ...] = eqx.field(static=True)
    side: int | None = eqx.field(static=True)
    place: Float[Array, ""] | None
    along: Float[Array, " d"] | None = None
    origin: Float[Array, ""] | None = None

    def value(self, model: Model, t, seen: Seen) -> Float[Array, ""]:
        """The number at t (s)."""
        if self.side is not None:
            piece = self.pieces[self.side]
            if self.kind == "tension":
                return seen.ends[piece][self.side]
            if self.kind == "bending_moment":
                return _moment(model, seen, piece)[self.side]
            return self._told(self._vectors(model, seen)[self.side][:, self.side])
        lines = [live_line(model, piece, seen.displacement, None) for piece in self.pieces]
        if self.kind == "tension":
            return self._at(lines, [seen.tension[piece] for piece in self.pieces])
        if self.kind == "bending_moment":
            along = [_moment(model, seen, piece)[None] for piece in self.pieces]
            return self._at(lines, along)[0]
        moved = self._at(lines, self._vectors(model, seen))
        if self.kind == "displacement" and any(reel_of(model, piece) for piece in self.pieces):
            # the nodes pass along the line; where its start is the place stays
            before = [model.lines[piece] for piece in self.pieces]
            moved = moved + self._at(lines, [line.reference for line in before])
            moved = moved - self._at(before, [line.reference for line in before])
        if self.kind in ("speed", "velocity") and reel_of(model, self.pieces[0]) is not None:
            moved = moved - self._passing(model, seen)
        return self._told(moved)

    def _passing(self, model: Model, seen: Seen) -> Float[Array, " d"]:
        """s r' L' / L (m/s): how fast nodes pass the place s (m) on a line that is paid out."""
        (piece,) = self.pieces  # a line on a winch or drum is in one
        line = live_line(model, piece, seen.displacement, seen.velocity)
        assert line.growth is not None
        nodes, sizes = seen.displacement[piece] + line.reference, segment_sizes(line)
        place, starts, ends = self._within([sizes])
        slopes = (nodes[:, 1:] - nodes[:, :-1]) / sizes
        here = (starts[0] <= place) & (place < ends[0])
        return place * line.growth * jnp.sum(jnp.where(here, slopes, 0.0), axis=1)

    def _vectors(self, model: Model, seen: Seen) -> list[Float[Array, "d nodes"]]:
        """Of the nodes of each piece what is told of the place: place, way (m) or velocity (m/s)."""
        if self.kind in ("speed", "velocity"):
            return [seen.velocity[piece] for piece in self.pieces]
        moved = [seen.displacement[piece] for piece in self.pieces]
        if self.kind == "displacement":
            return moved
        return [u + model.lines[p].reference for u, p in zip(moved, self.pieces, strict=True)]

    def _told(self, vector: Float[Array, " d"]) -> Float[Array, ""]:
        """Its size, or a component of it."""
        if self.along is None:
            return size(vector)
        value = dot(self.along.astype(vector.dtype), vector)
        return value if self.origin is None else value + self.origin.astype(vector.dtype)

    def _at(self, lines: list[Line], values: list[Array]) -> Float[Array, "*d"]:
        """Values of segments or vectors of nodes, linear between them, at the place on the lines."""
        sizes, found = [segment_sizes(line) for line in lines], []
        place, begins, finishes = self._within(sizes)
        each = zip(lines, sizes, values, begins, finishes, strict=True)
        for line, lengths, own, starts, ends in each:
            here = (starts <= place) & (place < ends)
            if self.kind == "tension":
                own = _between(line.seam, own, 0.5 * (starts + ends), place)
                found.append(jnp.sum(jnp.where(here, own, 0.0)))
            else:
                share = (place - starts) / jnp.where(lengths > 0.0, lengths, 1.0)
                own = own[:, :-1] + share * (own[:, 1:] - own[:, :-1])
                found.append(jnp.sum(jnp.where(here, own, 0.0), axis=1))
        return sum(found[1:], found[0])

    def _within(
        self, sizes: list[Float[Array, " n"]]
    ) -> tuple[Float[Array, ""], list[Array], list[Array]]:
        """The place (m), and where segments of such lengths (m) start and end, of pieces in a row."""
        assert self.place is not None
        # a place at the very end belongs to the last segment
        place = self.place.astype(sizes[0].dtype)
        whole = sum(jnp.sum(lengths) for lengths in sizes)
        place = jnp.minimum(place, whole * (1.0 - 4.0 * jnp.finfo(place.dtype).eps))
        begin, starts, ends = jnp.zeros_like(place), [], []
        for lengths in sizes:
            ends.append(begin + jnp.cumsum(lengths))
            starts.append(jnp.concatenate([begin[None], ends[-1][:-1]]))
            begin = ends[-1][-1]
        return place, starts, ends


class Later(AbstractMeasured):
    """Another measure from the time `start` (s) on, NaN before."""

    whole: AbstractMeasured
    start: Float[Array, ""]

    def value(self, model: Model, t, seen: Seen) -> Float[Array, ""]:
        """The number at t (s)."""
        return jnp.where(t >= self.start, self.whole.value(model, t, seen), jnp.nan)


def asks_for_moments(measure: AbstractMeasured) -> bool:
    """Whether a measure needs the bending moments of lines."""
    if isinstance(measure, Later):
        return asks_for_moments(measure.whole)
    return isinstance(measure, PlaceMeasured) and measure.kind == "bending_moment"


def _moment(model: Model, seen: Seen, piece: str) -> Float[Array, " nodes"]:
    """Bending moments (N m) at the nodes of a piece, none along a straight line."""
    if piece in seen.moment:
        return seen.moment[piece]
    return jnp.zeros_like(model.lines[piece].node_length)


def segment_sizes(line: Line) -> Float[Array, " n"]:
    """Unstretched lengths (m) of all segments, 0 of what is none."""
    sizes = jnp.broadcast_to(line.segment_length, line.segments)
    return sizes if line.seam is None else jnp.where(line.seam.gap(line.segments), 0.0, sizes)


def _between(
    seam: Seam | None, values: Float[Array, " n"], middles: Float[Array, " n"], place
) -> Float[Array, " n"]:
    """Each segment's value carried on to `place` on the line to its neighbour's on that side, or
    to its only neighbour's."""
    if values.shape[0] == 1:
        return values
    apart = jnp.diff(middles)
    slope = jnp.diff(values) / jnp.where(apart > 0.0, apart, 1.0)
    if seam is not None:
        # beyond a cut is no neighbour
        for out, within in ((BEFORE, 1), (AFTER, -1)):
            there = seam.segment(out) - (out == AFTER)
            slope = place_at_end(slope, there, pick(slope, there - within))
    after, before = (jnp.concatenate([slope, slope[-1:]]), jnp.concatenate([slope[:1], slope]))
    return values + (place - middles) * jnp.where(place > middles, after, before)


def place_measured(layout: Layout, coordinates: Coordinates, part: LineMeasure) -> PlaceMeasured:
    """The measure of a place as the scene gives it."""
    line, side, place = part.target()
    pieces = tuple(piece.name for piece in layout.of_line(line))
    which = None if side is None else 0 if side == "start" else -1
    found = None if side is not None else number(place)
    component = part.component if isinstance(part, MotionMeasure) else None
    axis = None if component is None else "xyz".index(component)
    return PlaceMeasured(part.KIND, pieces, which, found, *along_axis(coordinates, part.KIND, axis))


def along_axis(
    coordinates: Coordinates, kind: PlaceKind, axis: int | None
) -> tuple[Float[Array, " d"] | None, Float[Array, ""] | None]:
    """`along` and, of a position, `origin` (m) of `PlaceMeasured` for one of x, y, z; None: its size."""
    if axis is None:
        return None, None
    along = jnp.asarray(coordinates.axes, float)[axis]
    return along, number(coordinates.origin[axis]) if kind == "position" else None
