"""The dispersion correction of ends on which a known force acts, and of the parts of a broken line."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.line import Line
from lumpedcable.physics.linear import pick
from lumpedcable.physics.place import place_at_end

__all__ = ["corrected_ends", "end_correction"]


def end_correction(
    line: Line, e: Evaluation, node: int, dt: Float[Array, ""] | None
) -> Float[Array, ""] | None:
    """theta of the dispersion correction at an end node (-): see `corrected_ends`.

    None where the line has no such correction or the end's motion is known.
    """
    met = e.boundaries[line.ends.index(node)]
    if line.waves is None or not line.waves.corrected or met.loaded is False:
        return None
    nu2 = jnp.zeros((), line.reference.dtype)
    if dt is not None:
        segment = line.segment(node)
        stiff = jnp.maximum(pick(e.line.stiffness, segment), 0.0)
        length = pick(line.segment_length, segment)
        nu2 = jnp.clip(stiff * (dt / length) ** 2 / line.mass, 0.0, 1.0)
    theta = 0.25 * (1.0 - nu2)
    return theta if met.loaded is True else jnp.where(met.loaded, theta, 0.0)


def corrected_ends(
    line: Line, e: Evaluation, gain: Float[Array, "d nodes"], dt: Float[Array, ""] | None
) -> Float[Array, "d nodes"]:
    """Accelerations, or changes of velocity, with the dispersion correction of loaded ends.

    The end node stands for half a segment; a_N <- a_N + theta (a_N - a_N-1) along the line, with
    theta = (1 - nu^2) / 4 and nu the Courant number there, cancels the leading error of its motion.
    """
    for end in line.ends:
        theta = end_correction(line, e, end, dt)
        if theta is not None:
            node = line.node(end)
            u = pick(e.line.shape.tangent, line.segment(end))
            own = pick(gain, node)
            ahead = jnp.dot(own - pick(gain, line.node(end, 1)), u)
            gain = place_at_end(gain, node, own + theta * ahead * u)
    return gain
