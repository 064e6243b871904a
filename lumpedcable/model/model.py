"""The whole scene as one mechanical system: forces, masses and what happens at the ends."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.attached import attached_ends, body_gain, follow, follow_rate
from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.boundary import boundary
from lumpedcable.model.carried import Measured
from lumpedcable.model.correction import corrected_ends
from lumpedcable.model.couple import Coupled, Found, live_line, winch_of
from lumpedcable.model.ends import Driven, End, Joined, Junction, Loaded, Release, end_name
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.grip import held_back
from lumpedcable.model.hauled import steered, steered_gain
from lumpedcable.model.inertia import end_matrices
from lumpedcable.model.junctions import junction_gain
from lumpedcable.model.line import Line, Workspace, placed
from lumpedcable.model.passing import drifting
from lumpedcable.model.places import PlaceMeasured
from lumpedcable.model.splices import add_splices
from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import Shape
from lumpedcable.physics.motion import mean_velocity_of, velocity_of
from lumpedcable.physics.place import place_at_end

__all__ = ["Kick", "Model", "Vectors"]

Vectors = dict[str, Float[Array, "d nodes"]]


class Kick(NamedTuple):
    """What a kick of leapfrog leads to.

    Velocities (m/s) in its middle and half a step later, the reactions (N) of ends that can break, and
    the evaluation in its middle.
    """

    middle: Vectors
    after: Vectors
    reaction: dict[str, Float[Array, " d"]]
    found: Found


class Model(eqx.Module):
    """Lines, what holds their ends, the junctions between them, and bodies.

    `up` (d,) is the vertical unit vector in the scene's own coordinates and `base` the height of
    their origin (m): heights are base + up . x. They serve currents, None where there is none.
    `couplings` are bodies that run on cables, `measures` the numbers that the scene asks for. `cuts` are
    the ends before and after the seam of a line that has one.
    """

    lines: dict[str, Line]
    ends: dict[str, tuple[End, End]]
    junctions: tuple[Junction, ...]
    up: Float[Array, " d"] | None = None
    base: Float[Array, ""] | None = None
    bodies: dict[str, AbstractBody] = eqx.field(default_factory=dict)
    couplings: tuple[Coupled, ...] = ()
    measures: dict[str, Measured | PlaceMeasured] = eqx.field(default_factory=dict)
    cuts: dict[str, tuple[Joined, Joined]] = eqx.field(default_factory=dict)

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

    def evaluate(
        self,
        t: Float[Array, ""],
        displacement: Vectors,
        velocity: Vectors | None,
        reaction: dict[str, Float[Array, " d"]],
        dt: Float[Array, ""] | None = None,
        over: dict[str, Workspace] | None = None,
    ) -> Found:
        """Forces and inertia of every line at t (s), before ends and junctions constrain them.

        With velocity None: at rest, as statics asks. `dt` (s) is the fixed step, if any; `over` are
        workspaces of an earlier evaluation to write over.
        """
        result = Found()
        displacement = self.followed(t, displacement)
        for name in self.lines:
            line = live_line(self, name, displacement, velocity)
            if dt is not None:
                dt = dt.astype(line.reference.dtype)
            boundaries = tuple(boundary(self, name, node, t, reaction) for node in line.ends)
            ends = tuple(met.force for met in boundaries)
            u = displacement[name]
            v = None if velocity is None else velocity[name]
            workspace = None if over is None else over[name]
            forces = line.forces(u, v, boundaries, dt, ends, workspace)
            nodes = self.frame(line, forces.shape)
            winch = winch_of(self, name)
            if winch is not None and line.drag is not None and line.growth is not None:
                nodes = drifting(nodes, forces.shape, line.growth, winch.node)
            result[name] = Evaluation(forces, nodes, ends, boundaries)
        add_splices(self, t, result, dt)
        result.add_couplings(self, t, displacement, velocity, dt)
        return result

    def frame(self, line: Line, shape: Shape) -> inertia.Frame:
        """Inertia and resistance of a line's nodes, in the current at their heights."""
        height = None
        if self.up is not None and self.base is not None and line.current is not None:
            height = self.base + self.up @ shape.position
        return inertia.frame(line, shape, height)

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

    def followed(self, t: Float[Array, ""], displacement: Vectors) -> Vectors:
        """The same displacements (m), with the ends that are tied to bodies where those are."""
        return follow(self, t, displacement) if self.bodies else displacement

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

    # --- motion -----------------------------------------------------------------------------

    def kick(
        self,
        t: Float[Array, ""],
        displacement: Vectors,
        before: Vectors,
        reaction: dict[str, Float[Array, " d"]],
        dt: Float[Array, ""],
        over: dict[str, Workspace] | None = None,
    ) -> Kick:
        """One kick of leapfrog, centred on t (s) with length dt (s).

        It starts from the velocities `before` (m/s) half a step earlier.
        """
        found = self.evaluate(t, displacement, before, reaction, dt, over)
        middle, after = {}, {}
        for name, e in found.items():
            _, w = inertia.kick(e.nodes, e.force, before[name], dt)
            change = corrected_ends(self.lines[name], e, w - before[name], dt, dt)
            middle[name], after[name] = before[name] + 0.5 * change, before[name] + change
            if self.lines[name].grip is not None:
                after[name], found[name] = held_back(self, name, t, e, before[name], change, dt)
                middle[name] = 0.5 * (before[name] + after[name])
        reaction = dict(reaction)
        for name, node, end in self._driven():
            now = velocity_of(end.motion, t)
            half = mean_velocity_of(end.motion, t, dt)
            now, half = now.astype(middle[name].dtype), half.astype(middle[name].dtype)
            if end.release is not None:
                begun = end.release.begun(t)
                key = end_name(name, node)
                push = self._reaction(found[name], node, now, (half - before[name][:, node]) / dt)
                reaction[key] = end.release.carried(t, dt, reaction[key], push)
                now = jnp.where(begun, middle[name][:, node], now)
                half = jnp.where(begun, after[name][:, node], half)
            middle[name] = place_at_end(middle[name], node, now)
            after[name] = place_at_end(after[name], node, half)
        for index in range(len(self.junctions)):
            gains, pushes = junction_gain(self, index, t, found, before, dt)
            reaction.update(_carried(t, dt, reaction, pushes))
            for (name, side), (active, gain) in gains.items():
                node = self.lines[name].node(side)
                start = pick(before[name], node)
                mid, end_ = start + 0.5 * dt * gain, start + dt * gain
                mid = jnp.where(active, mid, pick(middle[name], node))
                end_ = jnp.where(active, end_, pick(after[name], node))
                middle[name] = place_at_end(middle[name], node, mid)
                after[name] = place_at_end(after[name], node, end_)
        found.add_passing(self, before, middle)
        for name in self.bodies:
            key = body_key(name)
            found_gain = body_gain(self, name, t, found, displacement, before, dt)
            middle[key] = before[key] + 0.5 * dt * found_gain.gain
            after[key] = before[key] + dt * found_gain.gain
            reaction.update(_carried(t, dt, reaction, self._pulls(name, found_gain.pulls)))
        if self.bodies:
            middle = follow_rate(self, t, displacement, steered(self, t, None, middle))
            after = follow_rate(self, t, displacement, steered(self, t, dt, after), dt)
        return Kick(middle, after, reaction, found)

    def _pulls(self, body: str, pulls) -> dict[str, tuple[Release, Float[Array, " d"]]]:
        """What a body pulls the ends with that can still break away from it (N), and their releases."""
        return {
            end_name(name, node): (end.release, pulls[name, node])
            for name, node, end in attached_ends(self, body)
            if end.release is not None
        }

    def carried(
        self, t: Float[Array, ""], dt: Float[Array, ""], displacement: Vectors, velocity: Vectors
    ) -> Vectors:
        """The same velocities (m/s), but for ends whose motion is given: theirs land on their paths, or
        on the bodies that they are tied to, at t + dt (s)."""
        velocity = steered(self, t, dt, velocity)
        velocity = follow_rate(self, t, displacement, velocity, dt) if self.bodies else velocity
        velocity = dict(velocity)
        for name, node, end in self._driven():
            own = velocity[name]
            given = mean_velocity_of(end.motion, t, dt).astype(own.dtype)
            if end.release is not None:
                given = jnp.where(end.release.begun(t), own[:, node], given)
            velocity[name] = place_at_end(own, node, given)
        return velocity

    def acceleration(
        self,
        t: Float[Array, ""],
        displacement: Vectors,
        velocity: Vectors,
        reaction: dict[str, Float[Array, " d"]],
        dt: Float[Array, ""] | None = None,
    ) -> tuple[Vectors, Found]:
        """Accelerations of all nodes (m/s2) at t (s), constrained at the ends, for any integrator.

        `dt` is the step (s) that starts here, if steps are fixed: what corrects a step knows it then.
        """
        gain, _, found = self._moved(t, displacement, velocity, reaction, dt)
        return gain, found

    def carries(
        self, t: Float[Array, ""], displacement: Vectors, velocity: Vectors, reaction: Vectors,
        dt: Float[Array, ""] | None,
    ) -> Vectors:  # fmt: skip
        """What ends that can break carry (N) at t (s), after `reaction` a step of dt (s) ago."""
        return self._moved(t, displacement, velocity, reaction, dt)[1]

    def _moved(self, t, displacement, velocity, reaction, dt) -> tuple[Vectors, Vectors, Found]:
        """What `acceleration` and `carries` tell: accelerations, reactions, and the evaluation."""
        found = self.evaluate(t, displacement, velocity, reaction, dt)
        result, reaction = {}, dict(reaction)
        for name, e in found.items():
            gain = inertia.acceleration(e.nodes, e.force, velocity[name])
            result[name] = corrected_ends(self.lines[name], e, gain, dt)
        for name, node, end in self._driven():
            given = jax.jvp(lambda s, m=end.motion: velocity_of(m, s), (t,), (jnp.ones_like(t),))[1]
            given = given.astype(result[name].dtype)
            if end.release is not None:
                begun, key = end.release.begun(t), end_name(name, node)
                push = self._reaction(found[name], node, velocity[name][:, node], given)
                reaction[key] = end.release.carried(t, dt, reaction[key], push)
                given = jnp.where(begun, result[name][:, node], given)
            result[name] = place_at_end(result[name], node, given)
        for index in range(len(self.junctions)):
            gains, pushes = junction_gain(self, index, t, found, velocity, None)
            reaction.update(_carried(t, dt, reaction, pushes))
            for (name, side), (active, gain) in gains.items():
                node = self.lines[name].node(side)
                gain = jnp.where(active, gain, pick(result[name], node))
                result[name] = place_at_end(result[name], node, gain)
        found.add_passing(self, velocity, velocity)
        for name, body in self.bodies.items():
            key = body_key(name)
            found_gain = body_gain(self, name, t, found, displacement, velocity, None)
            result[key] = found_gain.gain
            reaction.update(_carried(t, dt, reaction, self._pulls(name, found_gain.pulls)))
            for line, node, end in attached_ends(self, name):
                q, v = body.reference + displacement[key], velocity[key]
                turn, _, bias = body.rate(q, v, end.point)
                gain = turn @ result[key] + bias
                if end.release is not None:
                    gain = jnp.where(end.release.begun(t), result[line][:, node], gain)
                result[line] = place_at_end(result[line], node, gain)
        return steered_gain(self, t, result), reaction, found

    def _driven(self) -> Iterator[tuple[str, int, Driven]]:
        for name, node, end in self.outer_ends():
            if isinstance(end, Driven):
                yield name, node, end

    def _reaction(self, e: Evaluation, node: int, velocity, gain) -> Float[Array, " d"]:
        """Force (N) that whatever drives an end node exerts on it: M a - F - drag."""
        mass, drag, flow = end_matrices(e.nodes, node, velocity)
        return mass @ gain - e.force[:, node] + drag @ (velocity - flow)


def _carried(
    t, dt, reaction: Vectors, pushes: dict[str, tuple[Release, Float[Array, " d"]]]
) -> dict[str, Float[Array, " d"]]:
    """What ends that can break carry (N) at t (s), after `reaction` a step of dt (s) ago.

    `pushes` are, by end, its release and what it carries while it holds (N).
    """
    return {
        key: release.carried(t, dt, reaction[key], push) for key, (release, push) in pushes.items()
    }
