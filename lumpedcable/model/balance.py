"""A model at rest: what its ends that can break carry there, and how its lines stay there."""

from dataclasses import replace

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.boundary import boundary
from lumpedcable.model.ends import end_name
from lumpedcable.model.forces import evaluate
from lumpedcable.model.line import Line
from lumpedcable.model.model import Model, Vectors
from lumpedcable.physics.linear import pick
from lumpedcable.physics.waves import Cut

__all__ = ["balanced", "nothing_at_ends", "reactions_at_rest"]

BEFORE_ANYTHING = -jnp.inf  # s


def reactions_at_rest(model: Model, displacement: Vectors) -> dict[str, Float[Array, " d"]]:
    """The forces (N) that keep the nodes of breakable ends where they are, at a displacement (m)."""
    zero = nothing_at_ends(model)
    if not zero:
        return {}
    found = evaluate(model, jnp.full((), BEFORE_ANYTHING), displacement, None, zero)
    return {
        end_name(name, node): -pick(found[name].force, model.lines[name].node(node))
        for name, node, _ in model.breakable()
    }


def balanced(model: Model) -> Model:
    """The model, whose references are at rest, with wave terms that leave its lines there.

    The dispersion correction takes every bend of the tension along a line for a wave. Weight and drag
    bend it as well, most of all at an end that is held: a wave has no slope there, but the tension of a
    hanging line falls by its weight. See `ReleaseWaves`.
    """
    lines, nothing = dict(model.lines), nothing_at_ends(model)
    for name, line in model.lines.items():
        waves = line.waves
        if waves is None or not waves.corrected or not _is_loaded(line):
            continue
        t = jnp.full((), BEFORE_ANYTHING)
        start, end, *more = (boundary(model, name, node, t, nothing) for node in line.ends)
        shape = line.shape()
        cut = None if line.seam is None else Cut(line.seam, *more)
        tension = line.law.tension(shape.strain)
        waves = waves.resting(tension, shape.tangent, (start, end), cut)
        lines[name] = replace(line, waves=waves)
    return replace(model, lines=lines)


def _is_loaded(line: Line) -> bool:
    """Whether anything along the line can bend its tension at rest."""
    return bool(line.loads) or (line.drag is not None and line.current is not None)


def nothing_at_ends(model: Model) -> dict[str, Float[Array, " d"]]:
    """No force (N) at the breakable ends."""
    return {
        end_name(name, node): jnp.zeros_like(model.lines[name].reference[:, 0])
        for name, node, _ in model.breakable()
    }
