"""First shapes of lines that rest on a seabed, found like those of lines that hang free.

Where a line lies on a frictionless bed, the bed carries its weight and its tension is horizontal.
Seen from an end that holds up the weight a (N), the vertical tension in a segment is what is left of
a beyond the nodes between, and nothing from there on: max(a - C_j, 0). With the same from the other
end and the horizontal tension H the whole line follows from (H, a, b): a and b grow with the heights to
be reached at a given H, and the way along the bed with H. The exact answer for a chain of lumps on a
rigid bed; Newton's method on the whole scene adds the bed's own give.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from lumpedcable.model.line import Line
from lumpedcable.physics.bisection import bisected
from lumpedcable.physics.seabed import AbstractSeabed, Seabed, SlopingSeabed
from lumpedcable.physics.tension import strain_at
from lumpedcable.physics.vectors import root, size
from lumpedcable.physics.weight import Weight

__all__ = [
    "any_bed_of",
    "bed_under",
    "draped",
    "laid_on_slope",
    "lifted",
    "rested",
    "seabed_of",
    "slope_under",
]

PULLS = 1e-3  # share of it above which a line is taut along what it lies on
LEAST = 1e-6  # share of the line's weight below which a horizontal tension counts as none


def any_bed_of(line: Line) -> AbstractSeabed | None:
    """The seabed under a line, flat or with a profile, None where the scene has none."""
    return next((load for load in line.loads if isinstance(load, AbstractSeabed)), None)


def seabed_of(line: Line) -> Seabed | None:
    """The flat seabed under a line, None where the scene has none."""
    return next((load for load in line.loads if isinstance(load, Seabed)), None)


class Ground(NamedTuple):
    """What a line lies on or floats on: its height (m) there along `up` (d,), and its weight (N/m)."""

    up: Float[Array, " d"]
    level: Float[Array, ""]
    weight: Float[Array, ""]


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


def resting_line(
    line: Line,
    ground: Ground,
    start: Float[Array, " d"],
    end: Float[Array, " d"],
    free: Float[Array, "d nodes"],
) -> tuple[Float[Array, "d nodes"], Bool[Array, ""]]:
    """Positions (m) of a line between two points (m) on the ground between them; whether it pulls there.

    `free` is its shape without it, which is returned where it stays above the ground. Length that is
    left over once the line hangs straight down is pushed together there.
    """
    if line.dimensions == 1:
        return free, jnp.asarray(True)
    up, level = ground.up, ground.level
    nodal = ground.weight * line.node_length
    inner = jnp.cumsum(nodal[1:-1])
    before = jnp.concatenate([jnp.zeros(1), inner])
    after = before[-1] - before
    rise = jnp.dot(end - start, up)
    across = end - start - rise * up
    span = size(across)
    away = jnp.where(span > 0.0, across / jnp.where(span > 0.0, span, 1.0), _sideways(up))
    heights = jnp.stack([jnp.dot(start, up), jnp.dot(end, up)]) - level
    chain = _Chain(line, before, after, jnp.concatenate([span[None], jnp.maximum(heights, 0.0)]))
    whole = before[-1] + nodal[0]
    force = _solve(*jax.lax.stop_gradient((chain, whole)))
    along, down, rising = chain.steps(force)
    steps = away[:, None] * along + up[:, None] * (rising - down)
    # what the ends are missed by is made up on the ground, where the line has no shape to lose
    lying = ((down == 0.0) & (rising == 0.0)) * line.segment_length
    share = jnp.where(
        jnp.sum(lying) > 0.0, lying, jnp.broadcast_to(line.segment_length, lying.shape)
    )
    gap = end - start - jnp.sum(steps, axis=1)
    steps = steps + gap[:, None] * share / jnp.sum(share)
    path = jnp.concatenate([jnp.zeros_like(steps[:, :1]), jnp.cumsum(steps, axis=1)], axis=1)
    sinks = jnp.min(up @ free) < level
    usable = jnp.all(jnp.isfinite(path)) & jnp.all(heights >= 0.0)
    pulls = force[0] > PULLS * whole
    return jnp.where(sinks & usable, start[:, None] + path, free), pulls


def draped_line(
    line: Line, ground: Ground, free: Float[Array, "d nodes"], from_start: bool
) -> Float[Array, "d nodes"]:
    """Positions (m) of a line that hangs from one end, the rest of it laid along the ground.

    `free` is its shape without it. What would hang below the ground goes on along it, in the direction
    in which the line was led before, or just sideways.
    """
    if line.dimensions == 1:
        return free
    up, level = ground.up, ground.level
    path = free if from_start else free[:, ::-1]
    steps = path[:, 1:] - path[:, :-1]
    height = jnp.maximum(up @ path, jnp.minimum(level, up @ path[:, 0]))
    change = height[1:] - height[:-1]
    across = steps - up[:, None] * (up @ steps)
    wide = size(across)
    led = wide > 1e-9 * jnp.max(line.segment_length)
    away = jnp.where(led, across / jnp.where(led, wide, 1.0), _sideways(up)[:, None])
    way = root(jnp.sum(steps**2, axis=0) - change**2)
    steps = away * way + up[:, None] * change
    laid = jnp.concatenate([path[:, :1], path[:, :1] + jnp.cumsum(steps, axis=1)], axis=1)
    return laid if from_start else laid[:, ::-1]


def rested(
    line: Line, start: Float[Array, " d"], end: Float[Array, " d"], free: Float[Array, "d nodes"]
) -> Float[Array, "d nodes"]:
    """`resting_line` on a flat bed and on the water, where the scene has them."""
    bed, path = seabed_of(line), free
    if bed is not None:
        path, _ = resting_line(line, bed_under(line, bed), start, end, path)
    if (water := water_under(line, 0.5 * (start + end))) is not None:
        floats, ground = water
        afloat, taut = resting_line(line, ground, start, end, path)
        # one that is longer than its way has no shape on the water, which no friction gives it
        path = jnp.where(floats & taut, afloat, path)
    return free if path is free else _guessed(path, start, end)


def draped(
    line: Line, anchor: Float[Array, " d"], free: Float[Array, "d nodes"], from_start: bool
) -> Float[Array, "d nodes"]:
    """`draped_line` on a flat bed and on the water, where the scene has them."""
    bed, path = seabed_of(line), free
    if bed is not None:
        path = draped_line(line, bed_under(line, bed), path, from_start)
    if (water := water_under(line, anchor)) is not None:
        floats, ground = water
        path = jnp.where(floats, draped_line(line, ground, path, from_start), path)
    if path is free:
        return free
    far = jax.lax.stop_gradient(path[:, -1 if from_start else 0])
    return _guessed(path, *((anchor, far) if from_start else (far, anchor)))


def _guessed(
    path: Float[Array, "d nodes"], start: Float[Array, " d"], end: Float[Array, " d"]
) -> Float[Array, "d nodes"]:
    """A first shape (m), which nothing depends on, between ends (m) that have their derivatives."""
    inner = jax.lax.stop_gradient(path[:, 1:-1])
    return jnp.concatenate([start[:, None], inner, end[:, None]], axis=1)


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


def bed_under(line: Line, bed: Seabed) -> Ground:
    """The bed as ground under a line, which weighs at least next to nothing there."""
    weight = _weight(line, bed.up)
    if line.lift is not None:
        weight = weight - line.lift.per_length
    weight = jnp.maximum(weight, 1e-300)
    # the inverse of the bed's s(p)
    sink, half = weight / bed.stiffness, 0.5 * bed.blend
    level = bed.height - jnp.where(sink > half, sink + half, jnp.sqrt(4.0 * half * sink))
    return Ground(bed.up, level, weight)


def water_under(line: Line, place: Float[Array, " d"]) -> tuple[Bool[Array, ""], Ground] | None:
    """The water's surface as ground of a line that floats, and whether it does; None without a surface.

    From a `place` (m) under water it rises to the surface, and that is ground from below.
    """
    lift = line.lift
    if lift is None:
        return None
    up, carries = lift.waterline.up, lift.per_length
    weight = _weight(line, up)
    afloat = lift.waterline.diameter * (0.5 - weight / carries) - lift.waterline.above
    side = jnp.where(jnp.dot(up, place) < afloat, -1.0, 1.0)
    bears = jnp.where(side > 0.0, weight, carries - weight)
    ground = Ground(side * up, side * afloat, jnp.maximum(bears, 1e-300))
    return (weight > 0.0) & (weight < carries), ground


def _weight(line: Line, up: Float[Array, " d"]) -> Float[Array, ""]:
    """Weight per length (N/m) of a line, without what a `lift` takes of it."""
    loads = (load for load in line.loads if isinstance(load, Weight))
    return sum((-jnp.dot(load.per_length, up) for load in loads), jnp.zeros(()))


def _sideways(up: Float[Array, " d"]) -> Float[Array, " d"]:
    """Some horizontal unit vector."""
    first = jnp.zeros_like(up).at[jnp.argmin(jnp.abs(up))].set(1.0)
    return first - jnp.dot(first, up) * up


def _solve(chain: _Chain, weight: Float[Array, ""], iterations: int = 80) -> Float[Array, " 3"]:
    """(H, a, b) (N) that reach the target.

    What the ends hold up is a function of the tension H along the bed, and with it the way that the line
    leads grows with H: steps of Newton's method in log H, or to the middle of where the answer still
    can be. H stays positive: where its least value leads far enough, a line hangs straight down and the
    rest of it lies slack.
    """
    least = jnp.log(LEAST * weight)

    def unfinished(carry):
        return ~carry[-2] & (carry[-1] < iterations)

    def step(carry):
        log, low, high, _, _, count = carry
        force = _held_up(chain, jnp.exp(log), weight)
        (over, *_), slope = chain.miss(force), jax.jacfwd(chain.miss)(force)
        low, high = jnp.where(over < 0.0, log, low), jnp.where(over < 0.0, high, log)
        grows = slope[0, 0] - slope[0, 1:] @ jnp.linalg.solve(slope[1:, 1:], slope[1:, 0])
        after = log - over / (force[0] * grows)
        done = jnp.abs(over) < 1e-9 * jnp.sum(chain.target)
        done |= (log == least) & (over >= 0.0)
        after = jnp.where((low < after) & (after < high), after, 0.5 * (low + high))
        after = jnp.where(count == 0, jnp.log(0.2 * weight), after)
        return after, low, high, force, done, count + 1

    start = (least, least, least + 40.0, jnp.zeros(3), jnp.zeros((), bool), jnp.zeros((), int))
    return jax.lax.while_loop(unfinished, step, start)[3]


def _held_up(chain: _Chain, H: Float[Array, ""], weight: Float[Array, ""]) -> Float[Array, " 3"]:
    """(H, a, b) (N) with the weights that the ends hold up where the tension along the bed is H."""

    def low(held):
        return chain.miss(jnp.concatenate([H[None], held]))[1:] < 0.0

    # an end on the bed holds up next to nothing, less than would lift a line with so little tension
    least, most = LEAST**2 * weight, 2.0 * (weight + 10.0 * H)
    held = bisected(low, jnp.full(2, least), jnp.full(2, most), 60)[1]
    return jnp.concatenate([H[None], held])
