"""The tension at an end of a line, and what acts on the node there beside it."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.forces import node_frame
from lumpedcable.model.inertia import Frame, end_drag
from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.model.rods import spread_of
from lumpedcable.model.splices import bent_over
from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import Shape
from lumpedcable.physics.rod import ROD_SHARES
from lumpedcable.physics.seabed import AbstractSeabed
from lumpedcable.physics.tips import AFTER
from lumpedcable.physics.vectors import dot, size
from lumpedcable.physics.waves import Boundary

__all__ = ["end_node_drag", "end_tension", "own_loads", "resisted", "tension_at"]


def end_tension(
    line: Line,
    tension: Float[Array, " n"],
    node: int,
    shape: Shape | None = None,
    drag: Float[Array, " d"] | None = None,
    met: Boundary | None = None,
    over: bool = False,
) -> Float[Array, ""]:
    """Tension at an end (N), taken there from the two segments next to it.

    The end segment's tension T_0 is that of its middle, at s_0 from the end (m), the next one's T_1 at
    s_1. At an end that does not accelerate the slope there is dT/ds = -f . t, with f the loads and the
    drag per metre (N/m) and t the tangent; the parabola of that slope through both gives
    T_0 + (T_0 - T_1) s_0^2/(s_1^2 - s_0^2) + f . t s_0 s_1/(s_1 + s_0) at the start. The bed's part in f
    is what bears the line, not what bears a clump at its end. `drag` is that of the end node (N).
    Without `shape` the loads are left out: the waves that are added to them have no slope there. Where
    bending is clamped, or goes on `over` a joint, shear times curvature adds to the slope, and the
    tension is carried on straight: T_0 + (T_0 - T_1) s_0/(s_1 - s_0). At an end under a known force F,
    as `met` says, the tension is F . u, u outwards, however it accelerates.
    """
    segment = line.segment(node)
    pull = jnp.zeros((), tension.dtype)

    def inwards(force: Float[Array, " d"], shape: Shape) -> Float[Array, ""]:
        along = jnp.dot(force, pick(shape.tangent, segment))
        return along if node in (0, AFTER) else -along

    if shape is not None and (line.loads or drag is not None):
        # on the end node: f l / 2
        pull = inwards(own_loads(line, shape, line.node(node), drag), shape)
    here = pick(tension, segment)
    if line.segments == 1:
        found = here + pull
    else:
        fall = here - pick(tension, line.segment(node, 1))
        near, far = _middles(line, node)
        if shape is not None and (over or line.clamp(node) is not None):
            found = here + near / (far - near) * fall
        else:
            found = here + near**2 / (far**2 - near**2) * fall + far / (far + near) * pull
    if line.tension_only:  # beside a slack segment the parabola goes below
        found = jnp.maximum(found, 0.0)
    if met is None or shape is None or met.loaded is False:
        return found
    known = jnp.zeros_like(here) if met.force is None else -inwards(met.force, shape)
    return known if met.loaded is True else jnp.where(met.loaded, known, found)


def tension_at(
    line: Line, node: int, model: Model | None = None, name: str = ""
) -> Float[Array, ""]:
    """Tension (N) at the start (0) or end (-1) of a line at rest, as results show it.

    `model` is the one that the line is part of under a `name`: without it no current drags at the line,
    and it bends over no joint.
    """
    shape, drag = line.shape(), None
    if model is not None and line.current is not None:  # in still water nothing drags at rest
        still = jnp.zeros_like(line.reference)
        drag = end_node_drag(line, node_frame(model, line, shape), node, still)
    over = model is not None and (name, node) in bent_over(model)
    return end_tension(line, line.law.tension(shape.strain), node, shape, drag, over=over)


def _middles(line: Line, node: int):
    """How far from an end (m) the middles of its two segments are; 1/2 and 3/2 where all are alike."""
    if line.segment_length.shape[0] == 1:
        return 0.5, 1.5
    first, second = (pick(line.segment_length, line.segment(node, k)) for k in (0, 1))
    return 0.5 * first, first + 0.5 * second


def own_loads(
    line: Line, shape: Shape, node, drag: Float[Array, " d"] | None
) -> Float[Array, " d"]:
    """The loads and the drag (N) on a node; the bed bears no more than what presses the line on it."""
    total = jnp.zeros_like(shape.position[:, 0]) if drag is None else drag
    borne = None
    for load in line.loads:
        force = pick(load.force(shape), node)
        if isinstance(load, AbstractSeabed):
            borne = force
        else:
            total = total + force
    if borne is None:
        return total
    most = size(borne)
    across = borne / jnp.where(most > 0.0, most, 1.0)
    return total + across * jnp.clip(-dot(total, across), 0.0, most)


def end_node_drag(line: Line, nodes: Frame, node: int, velocity: Float[Array, "d nodes"]):
    """Drag (N) on the node of an end, None without drag."""
    if nodes.drag_t is None:
        return None  # not even the velocity is picked
    return end_drag(nodes, line.node(node), pick(velocity, line.node(node)))


def resisted(
    line: Line, found: Evaluation, node: int, velocity: Float[Array, "d nodes"],
    gain: Float[Array, "d nodes"] | None = None,
) -> Float[Array, " d"] | None:  # fmt: skip
    """Drag, the push of water in waves and the inertia of substance that a drum accelerates (N).

    On the node of an end; None without any of them. Of rods whose nodes have the accelerations `gain`
    (m/s2) there is their own inertia, of the half of the last one, which carries its mean tension, or
    of one alone what it leaves to that end.
    """
    total = end_node_drag(line, found.nodes, node, velocity)
    for along in (found.push, found.hastened):
        if along is not None:
            own = pick(along, line.node(node))
            total = own if total is None else total + own
    if gain is None:
        return total
    inertia = -pick(spread_of(line).along, node) * _mean_gain(line, node, gain)
    return inertia if total is None else total + inertia


def _mean_gain(line: Line, node: int, gain: Float[Array, "d nodes"]) -> Float[Array, " d"]:
    """The accelerations (m/s2) at an end of rods times the shares of a rod's mass that they count."""
    here = pick(gain, node)
    if line.segments > 1:
        return 0.5 * here
    return ROD_SHARES[0] * here + ROD_SHARES[1] * pick(gain, -1 - node)
