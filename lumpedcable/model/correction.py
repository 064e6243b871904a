"""The dispersion correction of ends on which a known force acts, and of the parts of a broken line."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.line import Line
from lumpedcable.physics.linear import pick
from lumpedcable.physics.place import place_at_end

__all__ = ["corrected_ends", "end_gain"]


def end_gain(
    line: Line, e: Evaluation, end: int, dt: Float[Array, ""] | None
) -> Float[Array, " d"] | None:
    """What the dispersion correction adds to the acceleration of an end node (m/s2), (d,).

    It stands for half a segment. With a (m/s2) what all forces but drag do to it and its neighbour,
    theta (a_N - a_N-1) along the line, theta = (1 - nu^2) / 4 with the Courant number nu there, cancels
    the leading error. Drag is a node's own. None without correction or where the end's motion is known.
    """
    met = e.boundaries[line.ends.index(end)]
    if line.waves is None or not line.waves.corrected or met.loaded is False:
        return None
    nu2, segment = jnp.zeros((), line.reference.dtype), line.segment(end)
    if dt is not None:
        stiff, length = (pick(x, segment) for x in (e.line.stiffness, line.segment_length))
        nu2 = jnp.clip(stiff * (dt / length) ** 2 / line.mass, 0.0, 1.0)
    theta = 0.25 * (1.0 - nu2)
    theta = theta if met.loaded is True else jnp.where(met.loaded, theta, 0.0)
    u, nodes = pick(e.line.shape.tangent, segment), (line.node(end), line.node(end, 1))
    own, inner = (jnp.dot(pick(e.force, k), u) / pick(e.nodes.mass_t, k) for k in nodes)
    return theta * (own - inner) * u


def corrected_ends(
    line: Line,
    e: Evaluation,
    gain: Float[Array, "d nodes"],
    dt: Float[Array, ""] | None,
    during: Float[Array, ""] | float = 1.0,
) -> Float[Array, "d nodes"]:
    """Accelerations, or changes of velocity `during` so long (s), with `end_gain` at loaded ends."""
    for end in line.ends:
        more = end_gain(line, e, end, dt)
        if more is not None:
            node = line.node(end)
            gain = place_at_end(gain, node, pick(gain, node) + during * more)
    return gain
