"""One line: its segments, its nodes and every force along it."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from lumpedcable.physics.bending import Bending
from lumpedcable.physics.fluid import AbstractCurrent
from lumpedcable.physics.linear import differences, settled_back
from lumpedcable.physics.load import AbstractLoad, AbstractResistance, Shape, between_nodes
from lumpedcable.physics.morison import AddedMass, Drag
from lumpedcable.physics.relaxation import Memory, Relaxation, Relaxed
from lumpedcable.physics.sea import SeaFlow
from lumpedcable.physics.seabed import BedGrip
from lumpedcable.physics.seam import Seam
from lumpedcable.physics.tension import AbstractTensionLaw, TensionOnly, tension_and_stiffness
from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.physics.vectors import dot
from lumpedcable.physics.waterline import Lift, Waterline
from lumpedcable.physics.waves import Boundary, Cut, Ghosted, ReleaseWaves, WaveTensions

__all__ = [
    "Line",
    "LineForces",
    "Workspace",
    "alike",
    "done_alike",
    "last_segments",
    "node_lengths",
    "node_tangent",
    "placed",
    "strain_rate",
]


class Workspace(NamedTuple):
    """What a step writes along the line, kept so that the next one writes over it.

    `ghosted` has what the wave terms work on, `carried` (d, n + 2) what segments and ends carry (N).
    """

    ghosted: Ghosted | None
    carried: Float[Array, "d n+2"]


class LineForces(NamedTuple):
    """What acts along a line at one instant; n segments, n + 1 nodes, d dimensions.

    `force` is the net force on each node (N) without drag, with the end forces that were given. The
    tensions are the law's, the damping's and those for waves (N), None where the line has no such
    thing; what its branches carry is in that of the law, and `relaxed` tells how they stand.
    `resistances` are the nodal forces (N), each (d, n+1), of the line's resistances; empty at rest.
    """

    shape: Shape
    force: Float[Array, "d nodes"]
    tension: Float[Array, " n"]
    stiffness: Float[Array, " n"]
    damping: Float[Array, " n"] | None
    waves: WaveTensions | None
    resistances: tuple[Float[Array, "d nodes"], ...] = ()
    workspace: Workspace | None = None
    relaxed: Relaxed | None = None

    @property
    def pull(self) -> Float[Array, " n"]:
        """Tension (N) of the law and the damping, without what is added for waves."""
        return self.tension if self.damping is None else self.tension + self.damping

    def total_tension(self) -> Float[Array, " n"]:
        """All that the segment carries (N): what its two nodes feel."""
        parts = (self.damping, None if self.waves is None else self.waves.total)
        return sum((p for p in parts if p is not None), self.tension)


class Line(eqx.Module):
    """A line of n segments between n + 1 nodes in d dimensions, from its start to its end.

    Motion is a displacement u (d, n+1) from the `reference` position (d, n+1), both in m. Strains
    come from displacement differences, so that float32 loses nothing on stiff lines:
    (1 + e)^2 = (1 + e0)^2 + (2 X' . u' + u' . u') / l^2 with X', u' the differences over a segment
    of unstretched length l, and e0 the strain of the reference.

    `waterline` is where the water ends, `sea` how it moves in waves, `displaced` (kg/m) the mass of the
    water that a metre of line takes the place of. `growth` (1/s) is the rate at which a winch lengthens
    it, dL/dt over L. `low` (d, n+1) is what rounding has left out of the displacements (m) that it is
    asked about, where a method keeps that. `memory` is how the branches of its `relaxation` stand, None
    at rest, where they carry nothing. `segment_length` has shape (n,), or (1,) where all are equal.
    `mass` is per metre of unstretched length (kg/m). What the line does not have is None and is not in
    the compiled program.

    An `inextensible` line has a `law` at rest by which it keeps its length, or with `give` (1/N, 1/EA)
    that of EA; once it moves, each segment keeps the length that it has in the reference, and is a rod
    (`model.rods`), or with `give` the length l (1 + T give).
    """

    law: AbstractTensionLaw
    mass: Float[Array, ""]
    segment_length: Float[Array, "..."]
    node_length: Float[Array, " nodes"]
    reference: Float[Array, "d nodes"]
    reference_step: Float[Array, "d n"]
    reference_strain: Float[Array, " n"]
    max_strain: Float[Array, ""]
    loads: tuple[AbstractLoad, ...] = ()
    resistances: tuple[AbstractResistance, ...] = ()
    damping: Float[Array, ""] | None = None
    relaxation: Relaxation | None = None
    memory: Memory | None = None
    drag: Drag | None = None
    added_mass: AddedMass | None = None
    current: AbstractCurrent | None = None
    waterline: Waterline | None = None
    sea: SeaFlow | None = None
    displaced: Float[Array, ""] | None = None
    waves: ReleaseWaves | None = None
    growth: Float[Array, ""] | None = None
    low: Float[Array, "d nodes"] | None = None
    give: Float[Array, ""] | None = None
    grip: BedGrip | None = None
    seam: Seam | None = None
    inextensible: bool = eqx.field(static=True, default=False)

    @property
    def dimensions(self) -> int:
        """Number of coordinates, 1 to 3."""
        return self.reference.shape[0]

    @property
    def mass_along(self) -> Float[Array, ""]:
        """What waves of tension move (kg per m of unstretched length): mass, and fluid along it."""
        added = None if self.added_mass is None else self.added_mass.tangential
        return self.mass if added is None else self.mass + added

    @property
    def segments(self) -> int:
        """Number of segments n."""
        return self.reference.shape[1] - 1

    @property
    def ends(self) -> tuple[int, ...]:
        """Its ends: 0 and -1, and where it is cut those at the cut."""
        return (0, -1) if self.seam is None else (0, -1, BEFORE, AFTER)

    def node(self, end: int, inner: int = 0) -> int | Int[Array, ""]:
        """Index of an end's node, or of the one so many further in."""
        if end in (0, -1):
            return inner if end == 0 else -1 - inner
        assert self.seam is not None
        return self.seam.node(end, inner)

    def segment(self, end: int, inner: int = 0) -> int | Int[Array, ""]:
        """Index of an end's segment, or of the one so many further in."""
        if end in (0, -1):
            return inner if end == 0 else -1 - inner
        assert self.seam is not None
        return self.seam.segment(end, inner)

    @property
    def kept(self) -> Float[Array, " n"]:
        """The lengths (m) of an inextensible line's segments when they carry nothing."""
        length = self.segment_length * (1.0 + self.reference_strain)
        if self.give is None:
            return length
        return length / (1.0 + self.give * self.law.tension(self.reference_strain))

    @property
    def bending(self) -> Bending | None:
        """How it bends, None where it does not."""
        return next((load for load in self.loads if isinstance(load, Bending)), None)

    def clamp(self, end: int) -> Float[Array, " d"] | None:
        """The direction out of which it bends at an end, None where it is free to turn."""
        if self.bending is None:
            return None
        return {0: self.bending.start, -1: self.bending.end}.get(end)

    @property
    def clamps(self) -> dict[int, Float[Array, " d"]]:
        """The directions out of which it bends, by the ends that have one."""
        return {end: x for end in (0, -1) if (x := self.clamp(end)) is not None}

    @property
    def tension_only(self) -> bool:
        """Whether the law is cut at zero tension."""
        return isinstance(self.law, TensionOnly)

    def shape(self, displacement: Float[Array, "d nodes"] | None = None) -> Shape:
        """Tangents, strains and lengths of a displacement (m), in the reference if None."""
        if displacement is None:
            displacement = jnp.zeros_like(self.reference)
        length = self.segment_length
        step = differences(displacement)
        if self.low is not None:
            step = step + differences(self.low)
        if self.seam is not None:
            step = jnp.where(self.seam.gap(self.segments), 0.0, step)
        if self.dimensions == 1:
            # along a straight line strain has a sign: below -1 a segment points backwards
            tangent = jnp.sign(self.reference_step)
            strain = self.reference_strain + (tangent * step)[0] * (1.0 / length)
            stretched = length * jnp.abs(1.0 + strain)
        else:
            e0 = self.reference_strain
            change = dot(2.0 * self.reference_step + step, step) * (1.0 / length**2)
            square = e0 * (2.0 + e0) + change
            stretch = jnp.sqrt(jnp.maximum(1.0 + square, 1e-12))
            strain = square / (1.0 + stretch)
            stretched = length * stretch
            tangent = (self.reference_step + step) / stretched
        return Shape(
            self.reference + displacement, tangent, strain, stretched, length, self.node_length
        )

    def wet(self, shape: Shape, t: Float[Array, ""] | None = None) -> Float[Array, " nodes"]:
        """Length (m) under water that each node stands for, at t (s) in waves, None for none."""
        if self.waterline is None:
            return shape.node_length
        height = self.waterline.heights(shape.position)
        if self.sea is not None and t is not None:
            height = height - self.sea.risen(t, shape.position)
        return self.waterline.wet(height, shape.segment_length)

    @property
    def lift(self) -> Lift | None:
        """What lifts its wet part, None where water is everywhere or nothing weighs."""
        return next((load for load in self.loads if isinstance(load, Lift)), None)

    def forces(
        self,
        displacement: Float[Array, "d nodes"],
        velocity: Float[Array, "d nodes"] | None,
        boundaries: tuple[Boundary, ...] | None = None,
        dt: Float[Array, ""] | None = None,
        end_forces: tuple[Float[Array, " d"] | None, ...] = (None, None),
        over: Workspace | None = None,
    ) -> LineForces:
        """Everything along the line at a displacement (m) and velocity (m/s, None at rest).

        `boundaries` and `dt` (s) are what the wave terms need: those of its ends, and the fixed step if
        any; `end_forces` act on the nodes of its ends (N); `over` is a workspace to write over.
        """
        shape = self.shape(displacement)
        tension, stiffness, relaxed = self.carried(shape.strain)
        tension, stiffness = map(settled_back, (tension, stiffness))
        if self.inextensible and velocity is not None:
            # its tensions keep its length and are found with its motion
            tension = stiffness = jnp.zeros_like(tension)
        damping = waves = ghosted = None
        if velocity is not None and (self.damping is not None or self.waves is not None):
            rate = strain_rate(self, shape, velocity)
            if self.damping is not None:
                damping = self.damping * rate
                if self.tension_only:  # what is slack neither pushes nor pulls
                    damping = jnp.where(tension > 0.0, jnp.maximum(damping, -tension), 0.0)
            if self.waves is not None and boundaries is not None:
                start, end, *more = boundaries
                waves, ghosted = self.waves.terms(
                    tension, stiffness, rate, shape.tangent, self.segment_length, self.mass,
                    (start, end), dt, self.tension_only, None if over is None else over.ghosted,
                    self.damping, None if self.seam is None else Cut(self.seam, *more),
                )  # fmt: skip
                # a step reads them where it has written them; who keeps nothing need not write them
                if over is not None and ghosted.tension is not None:
                    tension = ghosted.tension[1:-1]
        result = LineForces(
            shape, jnp.zeros(()), tension, stiffness, damping, waves, relaxed=relaxed
        )
        outer = end_forces[0], end_forces[1]
        force, carried = between_nodes(
            settled_back(result.total_tension()) * shape.tangent,
            outer,
            None if over is None else over.carried,
            () if self.seam is None else self._at_cut(end_forces[2:]),
        )
        result = result._replace(workspace=Workspace(ghosted, carried))
        for load in self.loads:
            force = force + load.force(shape)
        if velocity is None:
            return result._replace(force=force)
        resistances = tuple(r.force(shape, velocity) for r in self.resistances)
        return result._replace(force=sum(resistances, force), resistances=resistances)

    def _at_cut(self, forces: tuple[Float[Array, " d"] | None, ...]):
        """Where a cut line carries the forces on its nodes at the cut, and what it carries there (N)."""
        assert self.seam is not None
        for side, force in zip((BEFORE, AFTER), forces, strict=True):
            if force is not None:
                # a tension pulls the end before the cut forwards, and the one after it back
                yield self.seam.slot(side), force if side == BEFORE else -force

    def carried(
        self, strain: Float[Array, " n"]
    ) -> tuple[Float[Array, " n"], Float[Array, " n"], Relaxed | None]:
        """Tension (N) of its law and its branches at each strain (-), and its slope (N); no damping."""
        if self.relaxation is None or self.memory is None:
            return *tension_and_stiffness(self.law, strain), None
        found = self.relaxation.relaxed(self.law, strain, self.memory)
        return found.tension, found.stiffness, found

    def stored_energy(self, shape: Shape) -> Float[Array, ""]:
        """Strain energy of the line (J)."""
        if self.inextensible:
            if self.give is None:
                return jnp.zeros((), shape.strain.dtype)
            return 0.5 * jnp.sum((shape.length - self.kept) ** 2 / self.kept) / self.give
        _, _, relaxed = self.carried(shape.strain)
        return jnp.sum(self.stored_per_metre(shape, relaxed) * self.segment_length)

    def stored_per_metre(self, shape: Shape, relaxed: Relaxed | None) -> Float[Array, " n"]:
        """Strain energy of an elastic line (J per metre of unstretched length) and its branches."""
        if self.relaxation is None or relaxed is None:
            return self.law.energy(shape.strain)
        return self.law.energy(relaxed.strain) + self.relaxation.energy(relaxed)


def strain_rate(line: Line, shape: Shape, velocity: Float[Array, "d nodes"]) -> Float[Array, " n"]:
    """de/dt = (v_j+1 - v_j) . u_j / l of each segment (1/s), less (1 + e) times the line's growth."""
    step = differences(velocity)
    rate = dot(step, shape.tangent) * (1.0 / line.segment_length)
    return rate if line.growth is None else rate - (1.0 + shape.strain) * line.growth


def node_tangent(tangent: Float[Array, "d n"]) -> Float[Array, "d nodes"]:
    """Unit tangent at each node: the mean direction of its segments, an end's own at an end.

    Where two segments point exactly at each other the mean vanishes; the later one then decides.
    """
    total = tangent[:, 1:] + tangent[:, :-1]
    square = dot(total, total)
    folded = square < 1e-12
    inner = jnp.where(folded, tangent[:, 1:], total / jnp.sqrt(jnp.where(folded, 1.0, square)))
    return jnp.concatenate([tangent[:, :1], inner, tangent[:, -1:]], axis=1)


def node_lengths(segment_length: Float[Array, "..."], segments: int) -> Float[Array, " nodes"]:
    """Unstretched length (m) that each node stands for: half of each neighbouring segment."""
    half = 0.5 * jnp.broadcast_to(segment_length, (segments,))
    return jnp.concatenate([half[:1], half[1:] + half[:-1], half[-1:]])


def last_segments(line: Line, node: int, count: int) -> tuple[Line, slice]:
    """The `count` segments next to an end (node 0 or -1) without what acts on them, and their nodes."""
    count = min(count, line.segments)
    nodes = slice(0, count + 1) if node == 0 else slice(line.segments - count, None)
    segments = slice(0, count) if node == 0 else slice(line.segments - count, None)
    length, memory = line.segment_length, line.memory
    return Line(
        law=line.law,
        mass=line.mass,
        segment_length=length if length.shape[0] == 1 else length[segments],
        node_length=line.node_length[nodes],
        reference=line.reference[:, nodes],
        reference_step=line.reference_step[:, segments],
        reference_strain=line.reference_strain[segments],
        max_strain=line.max_strain,
        relaxation=line.relaxation,
        memory=None if memory is None else memory._replace(stretch=memory.stretch[:, segments]),
    ), nodes


def placed(line: Line, position: Float[Array, "d nodes"]) -> Line:
    """The same line with its reference moved to `position` (m); displacements start there anew."""
    step = position[:, 1:] - position[:, :-1]
    if position.shape[0] == 1:
        sign = jnp.where(step[0] < 0.0, -1.0, 1.0)
        strain = sign * step[0] / line.segment_length - 1.0
    else:
        strain = jnp.sqrt(dot(step, step)) / line.segment_length - 1.0
    return eqx.tree_at(
        lambda x: (x.reference, x.reference_step, x.reference_strain),
        line,
        (position, step, strain),
    )


def alike(lines: Mapping[str, Line]) -> list[list[str]]:
    """The names of lines, those together that have the same structure and shapes."""
    kinds: dict[Hashable, list[str]] = {}
    for name, line in lines.items():
        leaves, form = jax.tree.flatten(line)
        kind = form, tuple((x.shape, str(x.dtype)) for x in leaves)
        kinds.setdefault(kind, []).append(name)
    return list(kinds.values())


def done_alike(function: Callable[..., Any], lines: Sequence[Line], *given: Any) -> Any:
    """`function(line, *row)` of lines that are alike, once for all: results have an axis of lines first.

    `given` are arrays with such an axis, of which each line has its row. What is done to four lines one
    after the other takes four times as long to compile.
    """
    if len(lines) == 1:
        return jax.tree.map(lambda x: x[None], function(lines[0], *(x[0] for x in given)))
    return jax.vmap(function)(jax.tree.map(lambda *x: jnp.stack(x), *lines), *given)
