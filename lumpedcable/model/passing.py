"""What resists or pushes along a line that a winch pays out.

Payout moves the line's substance past the nodes. All segments grow alike, so that at fixed nodes the
substance at the unstretched distance s from the still end, the one without the winch, moves by
-s r' dL / L with r' = dr/ds. What drags or rubs on the nodes, or pushes them in waves, with the force f
acts on that substance, so by virtual work on the paid-out length as well:

    Q_L = -sum f_i . r'_i s_i / L

With the mean of the line's tensions, which pulls at the winch, this leaves the tension at the winch.

Where a drum's speed changes, the substance at a node is accelerated by -s r' (d2L/dt2) / L more than the
node, and holds back with its mass times that.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.line import Line
from lumpedcable.model.reels import Drum
from lumpedcable.physics.load import Shape
from lumpedcable.physics.motion import mean_acceleration_of
from lumpedcable.physics.place import place_at_end

__all__ = ["GIVEN", "drifting", "hastened", "on_payout", "passed", "passing_kinds"]

GIVEN = ("waves",)  # kinds of work that are put in, not lost


def passing_kinds(line: Line) -> tuple[str, ...]:
    """The kinds of work of what resists or pushes along a line."""
    present = {
        "drag": line.drag is not None,
        "friction": line.grip is not None,
        "waves": line.sea is not None,
    }
    return tuple(kind for kind in present if present[kind])


def passed(shape: Shape, node: int) -> Float[Array, "d nodes"]:
    """-s r' at the nodes (m) of a line whose winch or drum is at `node`, 0 or -1."""
    step = shape.tangent * shape.length
    size = jnp.broadcast_to(shape.segment_length, shape.strain.shape)
    inner = (step[:, 1:] + step[:, :-1]) / (size[1:] + size[:-1])
    slope = jnp.concatenate([step[:, :1] / size[0], inner, step[:, -1:] / size[-1]], axis=1)
    along = jnp.concatenate([jnp.zeros_like(size[:1]), jnp.cumsum(size)])
    return -slope * (along - along[-1] if node == 0 else along)


def drifting(nodes: inertia.Frame, past: Float[Array, "d nodes"]) -> inertia.Frame:
    """The frame with the fluid as it flows past the substance, which moves `past` the nodes (m/s)."""
    return nodes._replace(flow=-past if nodes.flow is None else nodes.flow - past)


def hastened(
    drum: Drum, shape: Shape, nodes: inertia.Frame, t: Float[Array, ""],
    dt: Float[Array, ""] | None,
) -> Float[Array, "d nodes"]:  # fmt: skip
    """Force of inertia (N) of the substance that a drum accelerates past the nodes at t (s).

    Without the terms in L', which a line has where it turns or curves as it runs. With dt (s) for a kick
    of that length.
    """
    gain = mean_acceleration_of(drum.path, t, dt)[0].astype(shape.strain.dtype)
    length = jnp.sum(shape.segment_length * jnp.ones_like(shape.strain))
    return -nodes.mass_t * passed(shape, drum.node) * (gain / length)


def on_payout(
    line: Line, e: Evaluation, velocity: Float[Array, "d nodes"] | None, node: int,
    held: Float[Array, " d"] | None = None,
) -> dict[str, Float[Array, ""]]:  # fmt: skip
    """Q_L (N) by kind of work, at the nodes' velocity (m/s), at rest if None.

    `e` has the line's forces, its frame and its friction; `held` is the velocity of the winch's end.
    """
    shape, found = e.line.shape, {}
    away = passed(shape, node) / jnp.sum(shape.segment_length * jnp.ones_like(shape.strain))
    if line.drag is not None and not (velocity is None and e.nodes.flow is None):
        v = jnp.zeros_like(shape.position) if velocity is None else velocity
        drag = inertia.drag_force(e.nodes, v if held is None else place_at_end(v, node, held))
        assert drag is not None
        found["drag"] = jnp.sum(drag * away)
    if line.grip is not None and e.grip is not None:
        found["friction"] = jnp.sum(e.grip * away)
    if e.push is not None:
        found["waves"] = jnp.sum(e.push * away)
    return found
