"""The shape of one line under its weight, from one end or between two points.

From the dual problem, which is convex and needs no guess: the tensions of a hanging chain of lumps
follow from the force at its end by adding up loads, so only that force is unknown.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.line import Line
from lumpedcable.physics.tension import strain_at
from lumpedcable.physics.waterline import Lift
from lumpedcable.physics.weight import Weight

__all__ = ["hanging_line", "nodal_weight", "spanning_force", "spanning_line"]

SETTLED = 1e-13  # of a force: a change that is rounding


def hanging_line(
    line: Line, anchor: Float[Array, " d"], pull: Float[Array, " d"], from_start: bool,
    load: Float[Array, "d nodes"] | None = None,
) -> Float[Array, "d nodes"]:  # fmt: skip
    """Positions (m) of a line from its anchor (m), with a known force `pull` (N) on the far end.

    Tensions are sums: T_j = pull + the loads of all nodes beyond segment j; segment j is then
    l (1 + e(|T_j|)) long and points along T_j. `load` (N) acts on the nodes, their weight if absent.
    """
    load = nodal_weight(line, (anchor, anchor)) if load is None else load
    if not from_start:
        load = load[:, ::-1]
    beyond = jnp.cumsum(load[:, :0:-1], axis=1)[:, ::-1]
    steps = _steps(line, pull[:, None] + beyond, reverse=not from_start)
    path = jnp.concatenate([anchor[:, None], anchor[:, None] + jnp.cumsum(steps, axis=1)], axis=1)
    return path if from_start else path[:, ::-1]


def _beyond(weight: Float[Array, "d nodes"]) -> Float[Array, "d n"]:
    """Loads (N) of the inner nodes beyond each segment, as seen from the start."""
    beyond = jnp.cumsum(weight[:, -2:0:-1], axis=1)[:, ::-1]
    return jnp.concatenate([beyond, jnp.zeros_like(weight[:, :1])], axis=1)


def spanning_force(
    line: Line, start: Float[Array, " d"], end: Float[Array, " d"], iterations: int = 60
) -> Float[Array, " d"]:
    """Tension vector (N) in the last segment of a line hanging between two known points (m).

    Newton's method: the far end reached, x(F), is the gradient of a convex function of F, the
    complementary energy, so steps that lower that function converge from any start. The tension in
    segment j is F plus the loads of the inner nodes beyond it.
    """
    weight, span = nodal_weight(line, (start, end)), end - start
    beyond, total = _beyond(weight), jnp.sum(weight, axis=1)
    force = _searched(*jax.lax.stop_gradient((line, beyond, total, span)), iterations)

    def reached(force):
        return jnp.sum(_steps(line, force[:, None] + beyond), axis=1)

    # one more step, its slope frozen, carries the derivative (implicit function theorem)
    slope = jax.lax.stop_gradient(jax.jacfwd(reached)(force))
    usable = jnp.all(jnp.isfinite(jnp.linalg.solve(slope, span)))
    # where it has none, reverse mode must not meet the singular matrix either
    slope = jnp.where(usable, slope, jnp.eye(force.shape[0]))
    last = jnp.linalg.solve(slope, span - reached(force))
    return force + jnp.where(usable, last, 0.0)


def _searched(
    line: Line, beyond: Float[Array, "d n"], weight: Float[Array, " d"], span: Float[Array, " d"],
    iterations: int,
) -> Float[Array, " d"]:  # fmt: skip
    """The force (N) of `spanning_force` across a span (m), without derivatives; `weight` is the line's.

    The search ends where a step no longer moves the force: the next one would be the same.
    """
    size = jnp.sqrt(jnp.sum(span**2))
    total = jnp.sum(jnp.broadcast_to(line.segment_length, (line.segments,)))
    heavy = jnp.sqrt(jnp.sum(weight**2))
    away = jnp.where(size > 0.0, span / jnp.where(size > 0.0, size, 1.0), 0.0)
    taut = line.law.tension(jnp.asarray(size / total - 1.0))
    # a third of the weight across keeps the first shape from folding
    guess = away * jnp.maximum(taut, 0.3 * heavy) - 0.5 * weight

    def reached(force):
        return jnp.sum(_steps(line, force[:, None] + beyond), axis=1)

    def dual(force):
        t = _lengths(force[:, None] + beyond)
        strain = strain_at(line.law, t, line.max_strain)
        over = jnp.maximum(t - line.law.tension(strain), 0.0)  # beyond the law's reach
        value = t * (1.0 + strain) - line.law.energy(strain) + over * 1e3
        return jnp.sum(value * line.segment_length) - jnp.dot(force, span)

    scales = 0.5 ** jnp.arange(24)

    def moves(carry):
        _, moved, count = carry
        return (moved > 0.0) & (count < iterations)

    def step(carry):
        force, _, count = carry
        gap = span - reached(force)
        slope = jax.jacfwd(reached)(force)
        eye = jnp.eye(force.shape[0])
        change = jnp.linalg.solve(slope + 1e-14 * jnp.trace(slope) * eye, gap)
        trials = force + scales[:, None] * change
        values = jax.vmap(dual)(trials)
        best = jnp.argmin(jnp.where(jnp.isfinite(values), values, jnp.inf))
        better = values[best] < dual(force)
        # at the minimum the function is flat to rounding: the full Newton step is then the best
        close = jnp.sum(gap**2) < (1e-6 * total) ** 2
        good = jnp.all(jnp.isfinite(change))
        trial = jnp.where(close, trials[0], jnp.where(better, trials[best], force))
        after = jnp.where(good, trial, force)
        moved = jnp.max(jnp.abs(after - force)) - SETTLED * jnp.max(jnp.abs(force))
        return after, moved, count + 1

    carry = guess, jnp.asarray(jnp.inf), jnp.zeros((), int)
    return jax.lax.while_loop(moves, step, carry)[0]


def spanning_line(
    line: Line, start: Float[Array, " d"], end: Float[Array, " d"]
) -> Float[Array, "d nodes"]:
    """Positions (m) of a line hanging between two known points (m) under its weight.

    Where `spanning_force` finds no force (ends straight above each other and slack between them:
    the fold has no tension to point it anywhere), the line is laid out in a parabola of its length.
    """
    weight = nodal_weight(line, (start, end))
    tension = spanning_force(line, start, end)[:, None] + _beyond(weight)
    path = jnp.cumsum(_steps(line, tension), axis=1)
    gap = (end - start) - path[:, -1]
    total = jnp.sum(jnp.broadcast_to(line.segment_length, (line.segments,)))
    # what rounding leaves of the gap is shared out, so that the ends are met exactly
    share = jnp.arange(1, line.segments + 1) / line.segments
    path = jnp.concatenate([jnp.zeros_like(path[:, :1]), path + gap[:, None] * share], axis=1)
    met = jnp.all(jnp.isfinite(path)) & (jnp.sum(gap**2) < (1e-6 * total) ** 2)
    # a guess whose sag has no derivatives (infinite where nothing is slack), but whose ends have
    span = end - start
    guess = jax.lax.stop_gradient(_parabola(line, jnp.sum(weight, axis=1), span, total))
    guess = guess + (span - jax.lax.stop_gradient(span))[:, None] * jnp.linspace(
        0.0, 1.0, line.segments + 1
    )
    return start[:, None] + jnp.where(met, path, guess)


def _parabola(
    line: Line, weight: Float[Array, " d"], span: Float[Array, " d"], total: Float[Array, ""]
) -> Float[Array, "d nodes"]:
    """A parabola across a span (m), about as long as the line, sagging along its weight (N)."""
    d = span.shape[0]
    along = jnp.linspace(0.0, 1.0, line.segments + 1)
    straight = span[:, None] * along
    if d == 1:
        return straight
    down = weight / jnp.maximum(jnp.sqrt(jnp.sum(weight**2)), 1e-300)
    size = jnp.sqrt(jnp.sum(span**2))
    chord = span / jnp.maximum(size, 1e-300)
    across = down - jnp.dot(down, chord) * chord
    aside = jnp.zeros(d).at[0].set(1.0)
    aside = aside - jnp.dot(aside, chord) * chord
    across = jnp.where(jnp.sum(across**2) > 1e-6, across, aside)
    across = across / jnp.maximum(jnp.sqrt(jnp.sum(across**2)), 1e-300)
    slack = jnp.maximum(total - size, 0.0)
    sag = jnp.minimum(jnp.sqrt(0.375 * jnp.maximum(size, 0.1 * total) * slack), 0.5 * total)
    return straight + across[:, None] * sag * 4.0 * along * (1.0 - along)


def nodal_weight(
    line: Line, ends: tuple[Float[Array, " d"], Float[Array, " d"]] | None = None
) -> Float[Array, "d nodes"]:
    """Weight of a line's nodes less buoyancy (N).

    Of a line that may leave the water, as much is wet as of a straight line between its `ends` (m); all
    of it where these are not given.
    """
    weight = jnp.zeros_like(line.reference)
    for load in line.loads:
        if isinstance(load, Weight):
            weight = weight + load.per_length[:, None] * line.node_length
        elif isinstance(load, Lift):
            share = jnp.ones(())
            if ends is not None:
                heights = load.waterline.heights(jnp.stack(ends, axis=1))
                length = jnp.sum(line.node_length)
                share = jnp.sum(load.waterline.wet(heights, length)) / length
            weight = weight + load.of(share * line.node_length)
    return weight


def _lengths(tension: Float[Array, "d n"]) -> Float[Array, " n"]:
    square = jnp.sum(tension**2, axis=0)
    return jnp.sqrt(jnp.where(square > 0.0, square, 1e-300))


def _steps(line: Line, tension: Float[Array, "d n"], reverse: bool = False):
    """Segment vectors (m) that carry given tension vectors (N)."""
    size = _lengths(tension)
    stretch = line.segment_length * (1.0 + strain_at(line.law, size, line.max_strain))
    if reverse:
        full = jnp.broadcast_to(line.segment_length, (line.segments,))[::-1]
        stretch = full * (1.0 + strain_at(line.law, size, line.max_strain))
    first = jnp.zeros_like(tension).at[0].set(1.0)
    return stretch * jnp.where(size > 1e-140, tension / size, first)
