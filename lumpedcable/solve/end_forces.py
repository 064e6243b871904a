"""What acts on the node at an end of a line beside its tension, of which the tension there is told."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.inertia import Frame, end_drag
from lumpedcable.model.line import Line
from lumpedcable.model.rods import spread_of
from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import Shape
from lumpedcable.physics.rod import ROD_SHARES
from lumpedcable.physics.seabed import AbstractSeabed
from lumpedcable.physics.vectors import dot, size

__all__ = ["end_node_drag", "own_loads", "resisted"]


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
