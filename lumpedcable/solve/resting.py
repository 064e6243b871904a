"""First shapes of lines that rest on a seabed, found like those of lines that hang free.

Where a line lies on a frictionless bed, the bed carries its weight and its tension is horizontal.
Seen from an end that holds up the weight a (N), the vertical tension in a segment is what is left of
a beyond the nodes between, and nothing from there on: max(a - C_j, 0). With the same from the other
end and the horizontal tension H the whole line follows from (H, a, b), and what is reached with them
is the gradient of a convex function, the complementary energy of the line. The exact answer for a
chain of lumps on a rigid bed; Newton's method on the whole scene adds the bed's own give.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.line import Line
from lumpedcable.physics.seabed import Seabed, SlopingSeabed
from lumpedcable.physics.tension import strain_at
from lumpedcable.physics.vectors import root, size
from lumpedcable.physics.weight import Weight

__all__ = [
    "draped_line",
    "laid_on_slope",
    "lifted",
    "rest_level",
    "resting_line",
    "seabed_of",
    "slope_under",
]

LEAST = 1e-6  # share of the line's weight below which a horizontal tension counts as none


def seabed_of(line: Line) -> Seabed | None:
    """The flat seabed under a line, None where the scene has none."""
    return next((load for load in line.loads if isinstance(load, Seabed)), None)


class _Chain(NamedTuple):
    """A line between two ends over a bed: weights (N) of the inner nodes before and after each
    segment, (n,); the horizontal distance and the two heights to be bridged (m), (3,)."""

    line: Line
    before: Float[Array, " n"]
    after: Float[Array, " n"]
    target: Float[Array, " 3"]

    def pulls(self, force: Float[Array, " 3"]):
        """Horizontal tension and weights held up on either side (N), (3, n), and their size (N)."""
        H, a, b = force
        left, right = jnp.maximum(a - self.before, 0.0), jnp.maximum(b - self.after, 0.0)
        parts = jnp.stack([jnp.full_like(left, H), left, right])
        return parts, jnp.sqrt(jnp.sum(parts**2, axis=0))

    def steps(self, force: Float[Array, " 3"]) -> Float[Array, "3 n"]:
        """How far each segment leads along, down on the left and up on the right (m)."""
        parts, size = self.pulls(force)
        strain = strain_at(self.line.law, size, self.line.max_strain)
        return parts / size * self.line.segment_length * (1.0 + strain)

    def miss(self, force: Float[Array, " 3"]) -> Float[Array, " 3"]:
        """What is reached less what is wanted (m)."""
        return jnp.sum(self.steps(force), axis=1) - self.target

    def energy(self, force: Float[Array, " 3"]) -> Float[Array, ""]:
        """The function (J) whose gradient is `miss`: sum l (T (1 + e) - U(e)) less force times way."""
        _, size = self.pulls(force)
        law = self.line.law
        strain = strain_at(law, size, self.line.max_strain)
        beyond = jnp.maximum(size - law.tension(strain), 0.0)  # out of the law's reach
        density = size * (1.0 + strain) - law.energy(strain) + beyond * 1e3
        return jnp.sum(density * self.line.segment_length) - jnp.dot(force, self.target)


def resting_line(
    line: Line,
    bed: Seabed,
    start: Float[Array, " d"],
    end: Float[Array, " d"],
    free: Float[Array, "d nodes"],
) -> Float[Array, "d nodes"]:
    """Positions (m) of a line between two points (m) that rests on the bed between them.

    `free` is its shape without a bed, which is returned where it stays above the bed. Length that
    is left over once the line hangs straight down is pushed together on the bed.
    """
    if line.dimensions == 1:
        return free
    per_length, level = rest_level(line, bed)
    nodal = per_length * line.node_length
    inner = jnp.cumsum(nodal[1:-1])
    before = jnp.concatenate([jnp.zeros(1), inner])
    after = before[-1] - before
    up = bed.up
    rise = jnp.dot(end - start, up)
    across = end - start - rise * up
    span = size(across)
    away = jnp.where(span > 0.0, across / jnp.where(span > 0.0, span, 1.0), _sideways(up))
    heights = jnp.stack([jnp.dot(start, up), jnp.dot(end, up)]) - level
    chain = _Chain(line, before, after, jnp.concatenate([span[None], jnp.maximum(heights, 0.0)]))
    force = jax.lax.stop_gradient(_solve(chain, before[-1] + nodal[0]))
    along, down, rising = chain.steps(force)
    steps = away[:, None] * along + up[:, None] * (rising - down)
    # what the ends are missed by is made up on the bed, where the line has no shape to lose
    lying = ((down == 0.0) & (rising == 0.0)) * line.segment_length
    share = jnp.where(
        jnp.sum(lying) > 0.0, lying, jnp.broadcast_to(line.segment_length, lying.shape)
    )
    gap = end - start - jnp.sum(steps, axis=1)
    steps = steps + gap[:, None] * share / jnp.sum(share)
    path = jnp.concatenate([jnp.zeros_like(steps[:, :1]), jnp.cumsum(steps, axis=1)], axis=1)
    sinks = jnp.min(up @ free) < level
    usable = jnp.all(jnp.isfinite(path)) & jnp.all(heights >= 0.0)
    return jnp.where(sinks & usable, start[:, None] + path, free)


def draped_line(
    line: Line, bed: Seabed, free: Float[Array, "d nodes"], from_start: bool
) -> Float[Array, "d nodes"]:
    """Positions (m) of a line that hangs from one end, the rest of it laid along the bed.

    `free` is its shape without a bed. What would hang below the bed goes on along it, in the
    direction in which the line was led before, or just sideways.
    """
    if line.dimensions == 1:
        return free
    _, level = rest_level(line, bed)
    path = free if from_start else free[:, ::-1]
    steps = path[:, 1:] - path[:, :-1]
    height = jnp.maximum(bed.up @ path, jnp.minimum(level, bed.up @ path[:, 0]))
    change = height[1:] - height[:-1]
    across = steps - bed.up[:, None] * (bed.up @ steps)
    wide = size(across)
    led = wide > 1e-9 * jnp.max(line.segment_length)
    away = jnp.where(led, across / jnp.where(led, wide, 1.0), _sideways(bed.up)[:, None])
    way = root(jnp.sum(steps**2, axis=0) - change**2)
    steps = away * way + bed.up[:, None] * change
    laid = jnp.concatenate([path[:, :1], path[:, :1] + jnp.cumsum(steps, axis=1)], axis=1)
    return laid if from_start else laid[:, ::-1]


def slope_under(line: Line) -> SlopingSeabed | None:
    """The seabed under a line if it has a profile, None where it is flat or there is none."""
    return next((load for load in line.loads if isinstance(load, SlopingSeabed)), None)


def laid_on_slope(
    bed: SlopingSeabed, free: Float[Array, "d nodes"], from_start: bool
) -> Float[Array, "d nodes"]:
    """Positions (m) of a line that hangs from one end, the rest of it laid along a bed with a profile.

    What would lie below the bed goes on along it, the way that the line was led, or downhill. A first
    shape: the bed's slope is taken where a segment begins.
    """
    path = free if from_start else free[:, ::-1]

    def go(at, step):
        slope = bed.depth.slope(bed.x_of(at))
        led, size = jnp.dot(step, bed.across), jnp.sqrt(jnp.sum(step**2))
        hangs = jnp.abs(led) < 1e-6 * size
        way = jnp.where(hangs, jnp.where(slope < 0.0, -1.0, 1.0), jnp.sign(led))
        along = (bed.across - bed.up * slope) / jnp.sqrt(1.0 + slope**2)
        lain = at + way * along * size
        ahead = jnp.where(bed.level(at + step) > jnp.dot(bed.up, at + step), lain, at + step)
        return ahead, ahead

    _, after = jax.lax.scan(go, path[:, 0], (path[:, 1:] - path[:, :-1]).T)
    laid = jnp.concatenate([path[:, :1], after.T], axis=1)
    return laid if from_start else laid[:, ::-1]


def lifted(
    line: Line, bed: SlopingSeabed, path: Float[Array, "d nodes"]
) -> Float[Array, "d nodes"]:
    """The same path (m), with what lies below a bed with a profile put upon it.

    Nodes that come to lie on top of each other there are shared out along it, as their line is long.
    """
    under = bed.level(path) - bed.up @ path
    put = path + bed.up[:, None] * jnp.maximum(under, 0.0)
    steps = put[:, 1:] - put[:, :-1]
    way = jnp.concatenate([jnp.zeros(1), jnp.cumsum(jnp.sqrt(jnp.sum(steps**2, axis=0)))])
    along = jnp.cumsum(jnp.broadcast_to(line.segment_length, (line.segments,)))
    even = [jnp.interp(way[-1] / along[-1] * along[:-1], way, x) for x in put]
    inner = jnp.where(jnp.any(under > 0.0), jnp.stack(even), put[:, 1:-1])
    return jnp.concatenate([path[:, :1], inner, path[:, -1:]], axis=1)


def rest_level(line: Line, bed: Seabed) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Weight per length (N/m, at least next to nothing) and height (m) of a line on the bed."""
    weight = jnp.full((), 1e-300)
    for load in line.loads:
        if isinstance(load, Weight):
            weight = jnp.maximum(-jnp.dot(load.per_length, bed.up), weight)
    # the inverse of the bed's s(p)
    sink, half = weight / bed.stiffness, 0.5 * bed.blend
    return weight, bed.height - jnp.where(sink > half, sink + half, jnp.sqrt(4.0 * half * sink))


def _sideways(up: Float[Array, " d"]) -> Float[Array, " d"]:
    """Some horizontal unit vector."""
    first = jnp.zeros_like(up).at[jnp.argmin(jnp.abs(up))].set(1.0)
    return first - jnp.dot(first, up) * up


def _solve(chain: _Chain, weight: Float[Array, ""], iterations: int = 80) -> Float[Array, " 3"]:
    """(H, a, b) (N) that reach the target, by damped Newton steps that lower a convex function.

    H stays positive; at its least value, where a line hangs straight down and the rest of it lies
    slack, the steps in a and b alone go on.
    """
    # an end on the bed holds up next to nothing, less than would lift a line with so little tension
    least = weight * jnp.asarray([LEAST, LEAST**2, LEAST**2])
    H = 0.2 * weight
    heights = chain.target[1:]
    per_metre = weight / jnp.sum(jnp.broadcast_to(chain.line.segment_length, chain.before.shape))
    held = jnp.sqrt(per_metre * heights * (per_metre * heights + 2.0 * H))
    guess = jnp.maximum(jnp.concatenate([H[None], held]), least)
    scales = 0.5 ** jnp.arange(24)

    def unfinished(carry):
        _, done, count = carry
        return ~done & (count < iterations)

    def step(carry):
        force, _, count = carry
        miss = chain.miss(force)
        slope = jax.jacfwd(chain.miss)(force)
        slope = slope + 1e-14 * jnp.trace(slope) * jnp.eye(3)
        whole = jnp.linalg.solve(slope, -miss)
        ends = jnp.concatenate([jnp.zeros(1), -miss[1:] / jnp.diagonal(slope)[1:]])
        changes = jnp.concatenate([scales[:, None] * whole, scales[:, None] * ends])
        trials = jnp.maximum(force + changes, least)
        values = jax.vmap(chain.energy)(trials)
        best = jnp.argmin(jnp.where(jnp.isfinite(values), values, jnp.inf))
        better = values[best] < chain.energy(force)
        # near the minimum the function is flat to rounding: the full step is then the best
        far = jnp.sqrt(jnp.sum(miss**2)) / jnp.sum(chain.target)
        close, usable = far < 1e-6, jnp.all(jnp.isfinite(changes))
        after = jnp.where(close, trials[0], jnp.where(better, trials[best], force))
        done = (far < 1e-9) | ~(close | better) | ~usable
        return jnp.where(usable, after, force), done, count + 1

    start = (guess, jnp.zeros((), bool), jnp.zeros((), int))
    return jax.lax.while_loop(unfinished, step, start)[0]
