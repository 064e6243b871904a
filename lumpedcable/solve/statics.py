"""Static equilibrium: the root of the same residual that dynamics integrates.

Two stages. A shape is found for each line by itself (`solve.hanging`). Where a scene has more than a
weight between its ends (joints, bending, current), Newton's method on the residual of the whole scene
follows, with the Jacobian by blocks. The residual judges the result in either case.
"""

from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.model import inertia
from lumpedcable.model.ends import Attached, Driven, End, Loaded
from lumpedcable.model.forces import node_frame
from lumpedcable.model.line import Line, LineForces, alike, done_alike
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.net import Net, junction_forces, make_net
from lumpedcable.model.rods import line_drag
from lumpedcable.model.splices import spliced, splices
from lumpedcable.physics.load import Shape
from lumpedcable.physics.tension import Rigid
from lumpedcable.physics.weight import Weight
from lumpedcable.solve.blocks import BlockTridiagonal, block_jacobian, solve_blocks
from lumpedcable.solve.hanging import nodal_weight
from lumpedcable.solve.softening import Stage, Stages

__all__ = [
    "Equilibrium",
    "eased",
    "equilibrium",
    "force_scale",
    "forces_at_rest",
    "held_position",
    "laid_out_exactly",
    "norm",
    "rounding_force",
    "static_residual",
    "worst",
]

AGAIN = 1e-4
"""Least mu after a step from a softer line's shape that made what is left much larger, or no numbers."""

WORST = 100.0
"""Growth of the forces that are left from which on a step from a softer line's shape is taken back."""


class Equilibrium(NamedTuple):
    """A model placed at its equilibrium, and how well it got there.

    `imbalance` is the largest nodal force left (N) over the largest force in the scene (N);
    `converged` whether that is below the tolerance; `iterations` the Newton steps taken.
    """

    model: Model
    imbalance: Float[Array, ""]
    converged: Bool[Array, ""]
    iterations: Int[Array, ""]


def static_residual(
    model: Model, moved: Float[Array, "places d"], net: Net
) -> Float[Array, "places d"]:
    """Net force (N) on every node of the net at rest, all breaks still ahead; 0 where held.

    `moved` is how far each node is from its reference (m).
    """
    return jnp.where(net.fixed[:, None], 0.0, forces_at_rest(model, moved, net))


def forces_at_rest(
    model: Model, moved: Float[Array, "places d"], net: Net
) -> Float[Array, "places d"]:
    """Net force (N) on every node of the net at rest, without what holds it; `moved` in m.

    Lines that are alike are gone through as one.
    """
    bent = {name for each in spliced(model) for name, _ in each.ends}
    total, shapes = jnp.zeros_like(moved), {}
    for names in alike(model.lines):
        index = np.stack([net.index[name] for name in names])
        lines = [model.lines[name] for name in names]
        forces = done_alike(partial(_at_rest, model), lines, jnp.swapaxes(moved[index], 1, 2))
        total = total.at[index].add(jnp.swapaxes(forces.force, 1, 2))
        for k, name in enumerate(names):
            if name in bent:
                shapes[name] = jax.tree.map(itemgetter(k), forces.shape)
    t = jnp.full((), -jnp.inf)
    for name, node, end in model.outer_ends():
        if isinstance(end, Loaded) and end.force is not None:
            total = total.at[int(net.index[name][node])].add(end.external(t))
    for splice in splices(model, t, shapes):
        for name, force in splice.forces.items():
            total = total.at[net.index[name]].add(force.T)
    extra = junction_forces(model, net, moved)
    return total if extra is None else total + extra


def _at_rest(model: Model, line: Line, displacement: Float[Array, "d nodes"]) -> LineForces:
    """The forces along a line at rest, drag of a current in them."""
    forces = line.forces(displacement, None)
    if line.drag is None or line.current is None:
        return forces
    return forces._replace(force=forces.force + _drag_at_rest(model, line, forces.shape))


def _drag_at_rest(model: Model, line: Line, shape: Shape) -> Float[Array, "d nodes"]:
    """Drag (N) of a current on a line that does not move, as dynamics takes it at its nodes or rods."""
    nodes = node_frame(model, line, shape)
    still = jnp.zeros_like(shape.position)
    if line.inextensible:
        return line_drag(line, shape.tangent, still, nodes.flow)
    drag = inertia.drag_force(nodes, still)
    assert drag is not None
    return drag


# targets and line laying ask for it several times with arrays of one shape: jax then follows it once
@eqx.filter_jit
def equilibrium(
    model: Model, tolerance: Float[Array, ""], max_iterations: int, near: bool = False
) -> Equilibrium:
    """The model placed at static equilibrium, starting from its reference; `near`: from near it.

    From near it is found at once or not at all: there is none.

    Lines between known points or under known forces that carry weight alone are at equilibrium
    already, by `spanning_line` and `hanging_line`; anything else goes through Newton's method.
    """
    if not laid_out_exactly(model):
        stages = Stages.of(model, max_iterations, at_once=near)
        return _newton(model, make_net(model), tolerance, stages)
    goal = tolerance * force_scale(model) + rounding_force(model)
    net = make_net(model, ordered=False)
    still = jnp.zeros((net.size, next(iter(model.lines.values())).dimensions))
    left = jnp.max(jnp.abs(static_residual(model, still, net)))
    return Equilibrium(model, left / force_scale(model), left <= goal, jnp.zeros((), int))


def laid_out_exactly(model: Model) -> bool:
    """Whether the first stage leaves nothing to do: weight only, every line hanging from one end.

    A line between two points is found by iteration and goes on to Newton's method, which costs it
    nothing where that iteration was good. Joints count as points, except where they only cut a line.
    Rods are laid out with a stretch that they do not keep.
    """
    only_weight = all(
        line.current is None
        and not isinstance(line.law, Rigid)
        and all(isinstance(load, Weight) for load in line.loads)
        for line in model.lines.values()
    )
    ends = [end for _, _, end in model.outer_ends()]
    loaded = any(isinstance(end, Loaded) for end in ends)
    cuts = all(junction.cut for junction in model.junctions)
    held = sum(isinstance(end, Driven | Attached) for end in ends)
    return only_weight and loaded and cuts and held <= 1


def rounding_force(model: Model) -> Float[Array, ""]:
    """Force (N) below which a residual is rounding: places are known to a few units in their last
    digit, strains to that over a segment's length, and tensions to that times the stiffness; other
    loads to that times their own. What is slack here may be taut at rest, and as stiff as that."""
    sizes = [jnp.zeros(())]
    for line in model.lines.values():
        e = jnp.maximum(line.reference_strain, 0.0)
        stiff = jnp.max(jnp.abs(line.law.tension(e + 1e-6) - line.law.tension(e))) / 1e-6
        far = jnp.max(jnp.abs(line.reference))
        sizes.append(stiff * (1.0 + far / jnp.min(line.segment_length)))
        for load in line.loads:
            square = load.rate_squared(line.mass, line.segment_length)
            sizes.append(jnp.max(square * line.mass * line.segment_length) * far)
    return 8.0 * jnp.finfo(jnp.float64).eps * jnp.max(jnp.stack(sizes))


def _newton(model: Model, net: Net, tolerance: Float[Array, ""], stages: Stages) -> Equilibrium:
    """Newton's method on the net force at every node: a search, and a step that has the derivative."""
    balance = _Balance(model, net)
    tolerance, rounding = jax.lax.stop_gradient((tolerance, rounding_force(model)))

    def goal(x: Float[Array, "n b"]) -> Float[Array, ""]:
        return tolerance * balance.scale_at(x) + rounding

    x, force, stiffness, count = _searched(model, balance, goal, stages)
    scale, left = balance.scale_at(x), worst(force)
    enough = tolerance * scale + rounding
    there = _polished(model, balance, x, force, stiffness, enough)
    return Equilibrium(there, left / scale, left <= enough, count)


class _Balance:
    """The net forces F (N) on a model's nodes as a function of how far those have moved, x (m).

    Both are in blocks (n, b), as those of the Jacobian. `forces(model, x)` are those of any model on
    the net, so that they have its derivatives; `frozen(x)` are the given model's and have none but that
    with respect to x. Where a node is held, F is -x. Forces are judged by `scale` (N); `across` is the
    stiffness (N/m) of a taut segment across itself.
    """

    def __init__(self, model: Model, net: Net):
        d = next(iter(model.lines.values())).dimensions
        self.net, self.nodes = net, (net.size, d)
        self.blocks = net.size // net.width, net.width * d
        self.held = jnp.asarray(net.fixed)[:, None]

        def forces(mine: Model, x):
            everything = x.reshape(self.nodes)
            force = static_residual(mine, everything, net)
            return jnp.where(self.held, -everything, force).reshape(self.blocks)

        # asked for again and again with arrays of one shape: jax then follows it through the model once
        self.forces = jax.jit(forces)
        self.still = jax.lax.stop_gradient(model)
        self.frozen = partial(self.forces, self.still)
        shortest = jnp.min(
            jnp.stack([jnp.min(line.segment_length) for line in model.lines.values()])
        )
        self.scale = jax.lax.stop_gradient(force_scale(model))
        self.across = self.scale / jax.lax.stop_gradient(shortest)

    def lines(self, x: Float[Array, "n b"]) -> Vectors:
        """Blocks as vectors of nodes, by line."""
        return self.net.spread(x.reshape(self.nodes))

    def scale_at(self, x: Float[Array, "n b"]) -> Float[Array, ""]:
        """The largest forces (N) at x, or at first if those are smaller: a first shape may be stretched
        many times over, and beside its tensions those of the shape at rest would be nothing.
        """
        here = force_scale(self.still, self.lines(x))
        return jax.lax.stop_gradient(jnp.minimum(self.scale, here))

    def sloped(
        self, x: Float[Array, "n b"], stages: Stages, stage: Stage
    ) -> tuple[Float[Array, "n b"], BlockTridiagonal]:
        """F at x in a stage, and K = -dF/dx by blocks (lower, diagonal, upper), without derivatives."""
        force, slopes = block_jacobian(partial(self.forces, stages.model(self.still, stage)), x)
        return jax.lax.stop_gradient((force, jax.tree.map(jnp.negative, slopes)))


def worst(force: Float[Array, "..."]) -> Float[Array, ""]:
    """The largest component, infinite where one is no number."""
    return jnp.max(jnp.where(jnp.isfinite(force), jnp.abs(force), jnp.inf))


def norm(force: Float[Array, "..."]) -> Float[Array, ""]:
    """Euclidean norm, infinite where a component is no number."""
    return jnp.where(jnp.all(jnp.isfinite(force)), jnp.sqrt(jnp.sum(force**2)), jnp.inf)


def _turn(model: Model, change: Vectors) -> Float[Array, ""]:
    """The most that nodes which move so far (m) turn or stretch a segment, in its lengths (-)."""
    longest = [
        jnp.max(jnp.abs(u[:, 1:] - u[:, :-1]) / model.lines[name].segment_length)
        for name, u in change.items()
    ]
    return jnp.max(jnp.stack(longest))


def _searched(
    model: Model,
    balance: _Balance,
    goal: Callable[[Float[Array, "n b"]], Float[Array, ""]],
    stages: Stages,
) -> tuple[Float[Array, "n b"], Float[Array, "n b"], BlockTridiagonal, Int[Array, ""]]:
    """How far the nodes move to equilibrium (m), F (N) and K there, and the steps taken.

    (K + mu k I) dx = F with K = -dF/dx by blocks and k the stiffness of a taut segment across
    itself: implicit steps in a pseudo-time, long where mu is small (pseudo-transient continuation,
    Kelley & Keyes, SIAM J. Numer. Anal. 35, 1998). No step turns a segment by more than a third of
    its length; mu falls with the residual, so that the end is Newton's own. Slack and
    buckled shapes relax towards a stable equilibrium. Nothing of it has a derivative.

    What is not found at once (stage 0) is looked for again from the first shape of softer lines
    (stage 1 and on, `solve.softening`), where steps that make F so much larger are taken back.
    """
    raised = balance.across * jnp.eye(balance.blocks[1])

    def unfinished(carry):
        (_, force, _, enough), _, stage, _ = carry
        return stages.unfinished(stage, worst(force) <= enough)

    def step(carry):
        """Looks at a trial, and from the better place for the next: followed once, F and K together."""
        kept, (trial, share, mu), stage, count = carry
        after = (trial, *balance.sloped(trial, stages, stage), goal(trial))
        begins, left, before = stages.begins(stage), norm(after[1]), norm(kept[1])
        usable = jnp.isfinite(left) & ((stage.number == 0) | (left <= WORST * before))
        ratio = jnp.where(usable, left / jnp.maximum(before, 1e-300), 10.0)
        # a shape that is nearly right needs no pseudo-time
        first = jnp.where(left < 1e-6 * balance.scale, 0.0, 1.0)
        # K is next to singular between slack segments: the next to nothing for mu would be no better
        again = jnp.where((stage.number > 0) & (ratio > 4.0), AGAIN, 0.0)
        mu = jnp.where(begins, first, jnp.maximum(eased(mu, ratio, share), again))
        kept = jax.tree.map(partial(jnp.where, usable | begins), after, kept)
        x, force, (lower, diagonal, upper), enough = kept
        change = solve_blocks((lower, diagonal + mu * raised, upper), force)
        share = jnp.minimum(1.0, 0.33 / jnp.maximum(_turn(model, balance.lines(change)), 1e-300))
        stage, trial = stages.after(stage, worst(force) <= enough, x, x + share * change)
        return kept, (trial, share, mu), stage, count + 1

    x, one = jnp.zeros(balance.blocks), jnp.ones(())
    nothing = jnp.zeros((*balance.blocks, balance.blocks[1]))
    far = jnp.full(balance.blocks, jnp.inf)
    unknown = x, far, (nothing, nothing, nothing), jnp.zeros(())
    carry = unknown, (x, one, one), stages.first, jnp.zeros((), int)
    (x, force, stiffness, _), *_, looks = jax.lax.stop_gradient(
        jax.lax.while_loop(unfinished, step, carry)
    )
    return x, force, stiffness, looks - 1


def eased(
    mu: Float[Array, ""], ratio: Float[Array, ""], share: Float[Array, ""]
) -> Float[Array, ""]:
    """mu after a step of pseudo-time that left a `ratio` of the residual, cut to a `share` of itself."""
    free = jnp.where(ratio <= 1.0, jnp.minimum(0.3, ratio), jnp.minimum(ratio, 4.0))
    factor = jnp.where(share < 1.0, jnp.clip(ratio, 0.5, 4.0), free)
    mu = jnp.clip(mu * factor, 0.0, 1e6)
    return jnp.where((mu < 1e-7) & (share == 1.0), 0.0, jnp.maximum(mu, 1e-9))


def _polished(
    model: Model, balance: _Balance, x: Float[Array, "n b"], force: Float[Array, "n b"],
    stiffness: BlockTridiagonal, goal: Float[Array, ""],
) -> Model:  # fmt: skip
    """The model with its nodes moved by x (m) and one step with K as it is at x.

    That gives the result its derivative with respect to every number of the scene (implicit function
    theorem); it also polishes, where K is regular.
    """
    # a first shape is not what the result depends on, and may have no derivative
    known = balance.net.spread(jnp.broadcast_to(balance.held, balance.nodes))
    laid = {
        name: jnp.where(known[name], line.reference, jax.lax.stop_gradient(line.reference))
        for name, line in model.lines.items()
    }
    # a singular K is replaced beforehand: what is infinite has no way back, whether chosen or not
    regular = jnp.all(jnp.isfinite(solve_blocks(stiffness, force)))
    b = balance.blocks[1]
    others = (jnp.zeros((b, b)), jnp.eye(b), jnp.zeros((b, b)))
    stiffness = jax.tree.map(partial(jnp.where, regular), stiffness, others)
    polished = x + solve_blocks(stiffness, balance.forces(model.placed(laid), x))
    regular &= worst(balance.frozen(polished)) <= 10.0 * goal
    where = {name: line.reference for name, line in model.lines.items()}
    x, where = jax.tree.map(partial(jnp.where, regular), (polished, laid), (x, where))
    moved = balance.lines(x)
    return model.placed({name: where[name] + moved[name] for name in where})


def force_scale(model: Model, moved: Vectors | None = None) -> Float[Array, ""]:
    """Largest of the tensions, weights and end forces of a scene (N), to judge a residual by.

    NaN where that is more than a number can be.

    The tensions are those of the reference, or of nodes that have `moved` from it (m), by line.
    """
    sizes = [jnp.full((), 1e-12)]
    for name, line in model.lines.items():
        strain = line.reference_strain if moved is None else line.shape(moved[name]).strain
        sizes.append(jnp.max(jnp.abs(line.law.tension(strain))))
        sizes.append(jnp.sqrt(jnp.sum(jnp.sum(nodal_weight(line), axis=1) ** 2)))
        for end in model.ends[name]:
            if isinstance(end, Loaded) and end.force is not None:
                sizes.append(jnp.sqrt(jnp.sum(end.force**2)))
    for junction in model.junctions:
        if junction.load is not None:
            sizes.append(jnp.sqrt(jnp.sum(junction.load**2)))
    largest = jnp.max(jnp.stack(sizes))
    # against what overflows nothing can be judged: no residual is below NaN
    return jnp.where(jnp.isfinite(largest), largest, jnp.nan)


def held_position(model: Model, end: End) -> Float[Array, " d"] | None:
    """Where an end is that is driven or tied to a rigid body, at the start (m); None for others."""
    if isinstance(end, Driven):
        return end.motion.position(jnp.zeros(()))
    if isinstance(end, Attached):
        body = model.bodies[end.body]
        return body.place(body.reference, end.point)
    return None
