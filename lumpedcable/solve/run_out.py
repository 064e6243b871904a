"""Whether the line under a trolley has come to its end: broken, it runs on through the trolley."""

import jax.numpy as jnp
from jaxtyping import Array, Bool

from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import Found
from lumpedcable.model.model import Model

__all__ = ["run_out"]


def run_out(model: Model, found: Found, moved: dict[str, Array]) -> dict[str, Bool[Array, ""]]:
    """Of each body that runs on a line with nodes, whether an end of it is the nearest of them.

    There the line does not run over the wheel any more; `moved` are displacements (m). What has become
    undefined is near nothing.
    """
    ended = {}
    for coupled in model.couplings:
        if coupled.line is None:
            continue
        nodes = found[coupled.line].line.shape.position
        place = model.bodies[coupled.body].reference + moved[body_key(coupled.body)]
        square = jnp.sum((nodes - place[: nodes.shape[0], None]) ** 2, axis=0)
        nearest = jnp.argmin(square)
        at_end = (nearest == 0) | (nearest == nodes.shape[1] - 1)
        ended[coupled.body] = at_end & jnp.all(jnp.isfinite(square))
    return ended
