"""Lengths of lines that bring statics to given tensions, places or sags.

The state of rest is a function of the lengths of the lines; with n lengths to be found and as many
conditions r = 0 on that state, Newton's method finds them: J dL = -r, J the derivative of the state
of rest (implicit function theorem). A tension falls and is convex in the length of a taut line, so
that from a line that is too short no step goes too far; a step is cut to where no length changes by
more than a half, all by one share, so that conditions that are linear stay met. A line between two
places has a tension twice, taut and slack; where the slack one is far from the first guess, the taut
one is meant. The square of a sag is about linear in the slack of a line, and convex: no step from a
line that is too long goes too far, where one in the sag itself makes a line taut, whose sag hardly
tells how much. Each miss is judged by the size of what is wanted, never by the forces alone: a line that
shrinks to nothing between places raises forces beside which every miss is small.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.assemble import assemble
from lumpedcable.model.balance import balanced
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.seams import opened
from lumpedcable.scene import Scene, Target
from lumpedcable.scene.ends import MovingEnd, held_place
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.near import finished, frozen, nodes_of, rest_near
from lumpedcable.solve.settling import (
    FARTHEST,
    Measures,
    coordinates_of_bodies,
    ended,
    places_of_bodies,
    searched,
    settled,
)
from lumpedcable.solve.start import Places, start_of
from lumpedcable.solve.statics import Equilibrium, force_scale, rounding_force

__all__ = ["rest_of", "sag_of"]

ITERATIONS = 60
SMALLEST = 1e-14  # relative change of a length that is rounding
NO_WAY = (
    1e-3  # of the step ahead: one back that leaves so little of it finds no state of rest either
)
STALLED = 0.5  # of the worst miss before: what falls no further, within what rounding leaves
MOST_ROUNDING = 1e-6  # relative miss that rounding of forces may explain at most
SHRUNK = 1e-6  # of its first guess: a length that has gone to nothing
NODES = {"start": 0, "end": -1}


def rest_of(scene: Scene, layout: Layout, coordinates: Coordinates) -> Equilibrium:
    """The scene's model at static equilibrium, its targets met.

    Without targets this is `start_of`. Its result has derivatives with respect to every number of
    the scene, what a target asks for included.
    """
    if layout.seams:
        found = _rest_of(scene, layout.whole, coordinates)
        found = found._replace(model=opened(found.model, scene, layout))
    else:
        found = _rest_of(scene, layout, coordinates)
    return found._replace(model=balanced(found.model))


def _rest_of(scene: Scene, layout: Layout, coordinates: Coordinates) -> Equilibrium:
    if not scene.targets:
        return (settled if scene.settling else start_of)(scene, layout, coordinates)
    still = frozen(scene)
    kind: Any = _Afloat if scene.settling else _Held  # what is remembered is their own
    way = kind(scene, layout, coordinates)

    def unfinished(carry):
        *_, worst, change, _, count = carry
        return (worst > still.statics.tolerance) & (change > SMALLEST) & (count < ITERATIONS)

    def step(carry):
        lengths, before, memory, _, last, _, reach, count = carry
        look = way.look(still, lengths, memory)
        change = jnp.linalg.solve(look.slope, -look.ahead)
        far = alone & (jnp.diag(look.slope) > 0.0) & (change > 0.5 * lengths)
        change = jnp.where(far, -0.5 * lengths, change)
        change = change * jnp.minimum(1.0, 0.5 / jnp.max(jnp.abs(change / lengths)))
        usable = jnp.all(jnp.isfinite(change))
        worst = jnp.where(usable, jnp.max(jnp.abs(look.miss)), jnp.inf)
        # without a state of rest there, part of the way back to where there was one
        astray = ~look.converged & (worst > still.statics.tolerance)
        lost = ~usable | (astray & jnp.any(lengths != before))
        change = jnp.where(lost, 0.75 * (before - lengths), change)
        moved = jnp.max(jnp.abs(change / lengths))
        reach = jnp.where(lost, reach, moved)
        stalled = (worst > STALLED * last) & (worst <= jnp.min(look.goals))
        moved = jnp.where(stalled | (lost & (moved < NO_WAY * reach)), 0.0, moved)
        kept = way.followed(look.memory, change)
        memory = jax.tree.map(lambda old, new: jnp.where(lost, old, new), memory, kept)
        before = jnp.where(lost, before, lengths)
        return lengths + change, before, memory, look.slope, worst, moved, reach, count + 1

    guess = jnp.stack([jnp.asarray(still.lines[t.line].length) for t in still.targets.values()])
    alone = jnp.array([_between_places(still, target) for target in still.targets.values()])
    far = jnp.full((), jnp.inf)
    first = way.memory(still)
    carry = (guess, guess, first, jnp.eye(guess.size), far, far, far, jnp.zeros((), int))
    lengths, _, memory, slope, *_ = jax.lax.stop_gradient(
        jax.lax.while_loop(unfinished, step, carry)
    )
    miss, found = way.finished(lengths, memory, slope)
    met = jnp.all(jnp.abs(miss) <= _goals(scene, found.model))
    met &= jnp.all(lengths > SHRUNK * guess)  # false of no number
    return found._replace(
        imbalance=jnp.maximum(found.imbalance, jnp.max(jnp.abs(miss))),
        converged=found.converged & met,
    )


class _Look(NamedTuple):
    """What targets are missed by (-) with some lengths, how much is met, and whether lines rest.

    A step of Newton's method goes by `ahead` (-), what is missed once bodies have come to rest, and its
    `slope` (1/m); `memory` is what the next one begins with.
    """

    slope: Float[Array, "n n"]
    ahead: Float[Array, " n"]
    miss: Float[Array, " n"]
    goals: Float[Array, " n"]
    converged: Bool[Array, ""]
    memory: Any


@dataclass(frozen=True)
class _Held:
    """Targets where no body settles: the nodes (m) of the lines are remembered."""

    scene: Scene
    layout: Layout
    coordinates: Coordinates

    def memory(self, still: Scene) -> Vectors:
        """What the first look begins with."""
        # lines without joints are laid out anew each time, and need no shape to begin from
        if not self.layout.joints:
            return {}
        return nodes_of(start_of(still, self.layout, self.coordinates).model)

    def _at(self, mine: Scene, lengths: Float[Array, " n"], nodes: Vectors):
        changed = _with_lengths(mine, lengths)
        found = rest_near(changed, self.layout, self.coordinates, nodes)
        return _misses(changed, self.layout, self.coordinates, found.model), found

    def look(self, still: Scene, lengths: Float[Array, " n"], memory: Vectors) -> _Look:
        """What lengths (m) come to."""

        def both(lengths):
            miss, found = self._at(still, lengths, memory)
            return miss, (miss, found)

        slope, (miss, found) = jax.jacfwd(both, has_aux=True)(lengths)
        nodes = nodes_of(found.model)
        kept = {name: nodes[name] for name in memory}
        return _Look(slope, miss, miss, _goals(still, found.model), found.converged, kept)

    def followed(self, memory: Vectors, _: Float[Array, " n"]) -> Vectors:
        """The memory once lengths have changed (m)."""
        return memory

    def finished(self, lengths: Float[Array, " n"], memory: Vectors, slope: Float[Array, "n n"]):
        """What is left of the misses (-), and the state of rest, with their derivatives."""
        return finished(lambda x: self._at(self.scene, x, memory), lengths, slope, lengths)


class _Moored(NamedTuple):
    """Bodies at rest with some lengths: their coordinates (m, rad), the nodes of lines (m), what they
    are measured by; dx/dL (1/m), and how far they were from rest (-); the slope of forces and misses (-)
    by both, places before lengths."""

    q: Float[Array, " q"]
    nodes: Vectors
    by: Measures
    follows: Float[Array, "q n"]
    left: Float[Array, " q"]
    slope: Float[Array, "both both"]


@dataclass(frozen=True)
class _Afloat:
    """Targets where bodies settle: for each choice of lengths these come to rest, from where they were.

    With F the forces on them and r what is missed, dx = -(dF/dx)^-1 (F + dF/dL dL) is how they follow,
    and r + dr/dL dL + dr/dx dx = 0 gives the lengths' step: Newton's method in both.
    """

    scene: Scene
    layout: Layout
    coordinates: Coordinates

    @cached_property
    def model(self) -> Model:
        """The scene as it is written, which tells where bodies are and how large everything is."""
        return jax.lax.stop_gradient(assemble(self.scene, self.layout, self.coordinates))

    def memory(self, still: Scene) -> _Moored:
        """What the first look begins with: the bodies as the scene has them, the rest of it unknown."""
        q = coordinates_of_bodies(self.model, still.settling)
        count, n = q.size, len(still.targets)
        nodes = {name: jnp.zeros(x.reference.shape) for name, x in self.model.lines.items()}
        one = jnp.ones(count)
        by = Measures(one, one, one, one, jnp.zeros(()))
        return _Moored(q, nodes, by, jnp.zeros((count, n)), jnp.zeros(count), jnp.eye(count + n))

    def _at(self, mine: Scene, places: Places, lengths, nodes: Vectors, by: Measures):
        """Forces and misses (-), one after the other, and the state of rest of the lines."""
        changed = _with_lengths(mine, lengths)
        found = rest_near(changed, self.layout, self.coordinates, nodes, places)
        forces = by.forces(found.model, mine.settling)
        misses = _misses(changed, self.layout, self.coordinates, found.model)
        return jnp.concatenate([forces, misses]), found

    def look(self, still: Scene, lengths: Float[Array, " n"], memory: _Moored) -> _Look:
        """What lengths (m) come to, the bodies at rest."""
        changed, names, count = _with_lengths(still, lengths), still.settling, memory.q.size
        begins = places_of_bodies(self.model, names, memory.q)
        first = start_of(changed, self.layout, self.coordinates, begins)
        by = Measures.of(changed, first.model)

        def look(x, nodes):
            def both(z):
                places = places_of_bodies(self.model, names, z[:count] * by.reach)
                every, found = self._at(still, places, z[count:], nodes, by)
                return every, (every, found)

            slope, (every, found) = jax.jacfwd(both, has_aux=True)(jnp.concatenate([x, lengths]))
            beside = slope, every[count:], _goals(changed, found.model), found.converged
            own = by.sloped(slope[:count, :count])
            return own, every[:count], nodes_of(found.model), found.converged, beside

        n = lengths.size
        far = jnp.full(n, jnp.inf)
        beside = jnp.eye(count + n), far, far, jnp.zeros((), bool)
        found = searched(by, look, memory.q / by.reach, nodes_of(first.model), beside)
        slope, miss, goals, good = found.beside
        own = found.slope - found.lie.neutral
        follows = -jnp.linalg.solve(own, slope[:count, count:])
        left = -jnp.linalg.solve(own, found.miss)
        by_places = slope[count:, :count] * by.free
        ahead = miss + by_places @ left
        moored = _Moored(
            found.x * by.reach, found.nodes, by, follows, left,
            jnp.block([[own, slope[:count, count:]], [by_places, slope[count:, count:]]]),
        )  # fmt: skip
        good = good & (jnp.max(jnp.abs(found.miss)) <= by.goal)
        return _Look(slope[count:, count:] + by_places @ follows, ahead, miss, goals, good, moored)

    def followed(self, memory: _Moored, change: Float[Array, " n"]) -> _Moored:
        """The memory once lengths have changed (m): bodies follow, but not far at once."""
        step = memory.left + memory.follows @ change
        share = jnp.minimum(1.0, FARTHEST / jnp.maximum(jnp.max(jnp.abs(step)), 1e-300))
        moved = (
            memory.q + jnp.where(jnp.all(jnp.isfinite(step)), share * step, 0.0) * memory.by.reach
        )
        return memory._replace(q=moved)

    def finished(self, lengths: Float[Array, " n"], memory: _Moored, _: Float[Array, "n n"]):
        """What is left of the misses (-), and the state of rest, with their derivatives."""
        by, count, names = memory.by, memory.q.size, self.scene.settling

        def at(z):
            places = places_of_bodies(self.model, names, z[:count] * by.reach)
            return self._at(self.scene, places, z[count:], memory.nodes, by)

        z = jnp.concatenate([memory.q / by.reach, lengths])
        size = jnp.concatenate([jnp.ones(count), lengths])
        every, found = finished(at, z, memory.slope, size)
        return every[count:], ended(self.scene, self.coordinates, found, by, every[:count])


def _misses(
    scene: Scene, layout: Layout, coordinates: Coordinates, model: Model
) -> Float[Array, " n"]:
    """What all targets of a scene are missed by, over their sizes (-)."""
    return jnp.stack(
        [_miss(scene, layout, coordinates, model, target) for target in scene.targets.values()]
    )


def _goals(scene: Scene, model: Model) -> Float[Array, " n"]:
    """The misses (-) up to which targets are met: the tolerance, and what rounding leaves."""
    rounding, scale = rounding_force(model), force_scale(model)
    sizes = []
    for target in scene.targets.values():
        if target.measure == "length":  # a sum, of which forces know nothing
            sizes.append(jnp.full((), 16.0 * jnp.finfo(jnp.float64).eps))
        else:
            size = target.wanted if target.measure == "tension" else scale
            sizes.append(jnp.minimum(rounding / size, MOST_ROUNDING))
    return scene.statics.tolerance + jnp.stack(sizes)


def _between_places(scene: Scene, target: Target) -> bool:
    """Whether a target asks for a tension of the very line that it changes, which two places hold."""
    line = scene.lines[target.line]
    own = target.measure == "tension" and target.of.rpartition(".")[0] == target.line
    return own and all(
        held_place(end) is not None or isinstance(end, MovingEnd) for end in (line.start, line.end)
    )


def _with_lengths(scene: Scene, lengths: Float[Array, " n"]) -> Scene:
    """The scene with the lengths (m) that its targets choose."""
    keys = [target.change for target in scene.targets.values()]
    return scene.with_numbers(dict(zip(keys, lengths, strict=True)))


def _miss(
    scene: Scene, layout: Layout, coordinates: Coordinates, model: Model, target: Target
) -> Float[Array, ""]:
    """What a target measures less what it wants, over the size of such numbers (-).

    Of a sag f by its square, (f^2 / f_wanted^2 - 1) / 2: near the goal f / f_wanted - 1.
    """
    wanted = jnp.asarray(target.wanted, float)
    if target.measure == "length":
        return sum((scene.lines[name].unstretched for name in target.parts), -wanted) / wanted
    if target.measure == "sag":
        up = coordinates.vector((0.0, 0.0, 1.0))
        share = sag_of(model.lines[target.of].reference, up) / wanted
        return 0.5 * (share * jnp.abs(share) - 1.0)  # what is bent up is not what hangs down
    if target.measure == "tension":
        line, node = layout.end_of(*target.of.rsplit(".", 1))
        return (tension_at(model.lines[line], node, model, line) - wanted) / wanted
    place = _place(layout, model, target.of)
    axis = "xyz".index(target.measure)
    found = coordinates.origin[axis] + jnp.asarray(coordinates.axes)[axis] @ place
    return (found - wanted) / sum(line.unstretched for line in scene.lines.values())


def _place(layout: Layout, model: Model, name: str) -> Float[Array, " d"]:
    """Where a body or the end of a line is (m, the scene's own coordinates)."""
    if "." in name:
        line, node = layout.end_of(*name.rsplit(".", 1))
        return model.lines[line].reference[:, node]
    if name in model.bodies:
        return model.bodies[name].reference[: model.lines[next(iter(model.lines))].dimensions]
    members = next(joint.members for joint in layout.joints if joint.body == name)
    line, node = members[0]
    return model.lines[line].reference[:, node]


def sag_of(nodes: Float[Array, "d nodes"], up: Float[Array, " d"]) -> Float[Array, ""]:
    """Depth (m) of a line's nodes (m) under the middle of its chord.

    Between two nodes it is on the parabolas through either and its neighbours, the more on one the
    nearer its node: smooth as nodes go past the middle, and the same whichever end is the first. A line
    of one segment is its chord.
    """
    if nodes.shape[1] == 2:
        return jnp.zeros((), nodes.dtype)
    chord = nodes[:, -1] - nodes[:, 0]
    across = chord - jnp.dot(chord, up) * up
    along = across @ (nodes - nodes[:, :1]) / jnp.dot(across, across)
    last, height = nodes.shape[1] - 1, up @ nodes
    k = jnp.clip(jnp.searchsorted(along, 0.5), 1, last)
    before, after = (_parabola(along, height, jnp.clip(n, 1, last - 1)) for n in (k - 1, k))
    share = (0.5 - along[k - 1]) / (along[k] - along[k - 1])
    middle = 0.5 * jnp.dot(up, nodes[:, 0] + nodes[:, -1])
    return middle - (before + share * (after - before))


def _parabola(along: Float[Array, " nodes"], height: Float[Array, " nodes"], k) -> Float[Array, ""]:
    """Height (m) in the middle, 0.5 of the way along, on the parabola through the nodes about k."""
    s, z = (jax.lax.dynamic_slice(v, (k - 1,), (3,)) for v in (along, height))
    shares = [
        jnp.prod((0.5 - s[jnp.array(others)]) / (s[i] - s[jnp.array(others)]))
        for i, others in enumerate(((1, 2), (0, 2), (0, 1)))
    ]
    return jnp.dot(jnp.stack(shares), z)
