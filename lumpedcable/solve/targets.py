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

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.balance import balanced
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.seams import opened
from lumpedcable.scene import Scene, Target
from lumpedcable.scene.lines import MovingEnd, held_place
from lumpedcable.solve.near import finished, frozen, nodes_of, rest_near
from lumpedcable.solve.observe import tension_at
from lumpedcable.solve.settling import settled
from lumpedcable.solve.start import start_of
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

    def at(mine: Scene, lengths: Float[Array, " n"], nodes: Vectors):
        """Misses over their sizes (-), and the same with the state of rest, for lengths (m)."""
        changed = _with_lengths(mine, lengths)
        if scene.settling:
            found = settled(changed, layout, coordinates)
        else:
            found = rest_near(changed, layout, coordinates, nodes)
        miss = jnp.stack(
            [
                _miss(changed, layout, coordinates, found.model, target)
                for target in mine.targets.values()
            ]
        )
        return miss, (miss, found)

    still = frozen(scene)

    def unfinished(carry):
        *_, worst, change, _, count = carry
        return (worst > still.statics.tolerance) & (change > SMALLEST) & (count < ITERATIONS)

    def step(carry):
        lengths, before, nodes, _, last, _, reach, count = carry
        slope, (miss, found) = jax.jacfwd(lambda x: at(still, x, nodes), has_aux=True)(lengths)
        change = jnp.linalg.solve(slope, -miss)
        far = alone & (jnp.diag(slope) > 0.0) & (change > 0.5 * lengths)
        change = jnp.where(far, -0.5 * lengths, change)
        change = change * jnp.minimum(1.0, 0.5 / jnp.max(jnp.abs(change / lengths)))
        usable = jnp.all(jnp.isfinite(change))
        worst = jnp.where(usable, jnp.max(jnp.abs(miss)), jnp.inf)
        # without a state of rest there, part of the way back to where there was one
        astray = ~found.converged & (worst > still.statics.tolerance)
        lost = ~usable | (astray & jnp.any(lengths != before))
        change = jnp.where(lost, 0.75 * (before - lengths), change)
        moved = jnp.max(jnp.abs(change / lengths))
        reach = jnp.where(lost, reach, moved)
        stalled = (worst > STALLED * last) & (worst <= jnp.min(_goals(still, found.model)))
        moved = jnp.where(stalled | (lost & (moved < NO_WAY * reach)), 0.0, moved)
        nodes = {name: jnp.where(lost, nodes[name], nodes_of(found.model)[name]) for name in nodes}
        before = jnp.where(lost, before, lengths)
        return lengths + change, before, nodes, slope, worst, moved, reach, count + 1

    guess = jnp.stack([jnp.asarray(still.lines[t.line].length) for t in still.targets.values()])
    # lines without joints are laid out anew each time, and need no shape to begin from
    near = layout.joints and not scene.settling
    first = nodes_of(start_of(still, layout, coordinates).model) if near else {}
    alone = jnp.array([_between_places(still, target) for target in still.targets.values()])
    far = jnp.full((), jnp.inf)
    carry = (guess, guess, first, jnp.eye(guess.size), far, far, far, jnp.zeros((), int))
    lengths, _, nodes, slope, *_ = jax.lax.stop_gradient(
        jax.lax.while_loop(unfinished, step, carry)
    )

    miss, found = finished(lambda x: at(scene, x, nodes)[1], lengths, slope, lengths)
    met = jnp.all(jnp.abs(miss) <= _goals(scene, found.model))
    met &= jnp.all(lengths > SHRUNK * guess)  # false of no number
    return found._replace(
        imbalance=jnp.maximum(found.imbalance, jnp.max(jnp.abs(miss))),
        converged=found.converged & met,
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
        line, node = _end(layout, target.of)
        return (tension_at(model.lines[line], node, model) - wanted) / wanted
    place = _place(layout, model, target.of)
    axis = "xyz".index(target.measure)
    found = coordinates.origin[axis] + jnp.asarray(coordinates.axes)[axis] @ place
    return (found - wanted) / sum(line.unstretched for line in scene.lines.values())


def _place(layout: Layout, model: Model, name: str) -> Float[Array, " d"]:
    """Where a body or the end of a line is (m, the scene's own coordinates)."""
    if "." in name:
        line, node = _end(layout, name)
        return model.lines[line].reference[:, node]
    if name in model.bodies:
        return model.bodies[name].reference[: model.lines[next(iter(model.lines))].dimensions]
    members = next(joint.members for joint in layout.joints if joint.body == name)
    line, node = members[0]
    return model.lines[line].reference[:, node]


def _end(layout: Layout, name: str) -> tuple[str, int]:
    """The line of the model at an end of the scene's, "LINE.start", which may part along itself."""
    line, _, side = name.rpartition(".")
    return layout.of_line(line)[NODES[side]].name, NODES[side]


def sag_of(nodes: Float[Array, "d nodes"], up: Float[Array, " d"]) -> Float[Array, ""]:
    """Depth (m) of a line's nodes (m) under the middle of its chord, a parabola between nodes.

    A line of one segment is its chord.
    """
    if nodes.shape[1] == 2:
        return jnp.zeros((), nodes.dtype)
    chord = nodes[:, -1] - nodes[:, 0]
    across = chord - jnp.dot(chord, up) * up
    along = across @ (nodes - nodes[:, :1]) / jnp.dot(across, across)
    k = jnp.clip(jnp.searchsorted(along, 0.5), 1, nodes.shape[1] - 2)
    s, z = (jax.lax.dynamic_slice(v, (k - 1,), (3,)) for v in (along, up @ nodes))
    shares = [
        jnp.prod((0.5 - s[jnp.array(others)]) / (s[i] - s[jnp.array(others)]))
        for i, others in enumerate(((1, 2), (0, 2), (0, 1)))
    ]
    middle = 0.5 * jnp.dot(up, nodes[:, 0] + nodes[:, -1])
    return middle - jnp.dot(jnp.stack(shares), z)
