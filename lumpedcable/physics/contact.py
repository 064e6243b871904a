"""A sheave that runs on a lumped line: smooth as it crosses nodes, exact in the kink under it.

The line is read as a cubic B-spline of its nodes, C(s) = sum_a w_a(s) r_a over four of them, s counted
in segments from the line's start. A line of the tension T that bends by the angle a to either side of a
sheave is loaded with F = 2 T sin a. Loaded through such weights it is a funicular polygon, of which
segment i lies at b_i, tan b_i = (2 W_i - 1) tan a with W_i the sum of the weights before it. With h the
length of a segment, the polygon's straight sides meet |G| = h tan a sum_i 2 W_i (1 - W_i) cos b_i below
C, and are longer than the polygon by h sum_i (cos b_i / cos a - 1). So the sheave lies where they meet
if a spring between it and C has the energy

    E = T h sum_i (cos b_i / cos a - 1),

which has the force dE/d|G| = F: by the sides' virtual work, T d(length) = F d|G|. It is no penalty, and
there is no constant to choose; a sheave that crosses nodes feels nothing of them, at any angle. Where
the angle is small that is a stiffness 2 T / (h d), d = sum_ab w_a w_b |a - b|.

A line with bending stiffness EI has no kink but a bend of the reach r = sqrt(EI / T): the sag of a
pinned tie rod at x from a load F is lower than under it by F/(2 T) (x - r (1 - exp(-x / r))). Then
|a - b| is |a - b| - (1 - exp(-|a - b| h / r)) r / h (S. Timoshenko, Strength of Materials II, 1956),
and the spring that of small angles.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

__all__ = [
    "Contact",
    "Hertz",
    "Reading",
    "contact",
    "extended",
    "folded",
    "read",
    "shortfalls",
]

NEWTON = 4  # steps to foot and angle; from the nearest node they end in rounding
FLATTEST = 0.2  # least slope, over that of a straight line, by which the minimum is looked for
LEAST = 1e-12  # m, below which a gap is none
STEEPEST = 4.0  # tangent of the largest angle
DEPTHS = 6  # steps to the depth of a Hertz contact, from above, of a convex function


class Reading(NamedTuple):
    """The spline at a place: first of its four nodes, weights, their slopes, and the shortfall d, d'.

    `growth` is d ln d / d ln h of a line with bending, 0 without.
    """

    first: Int[Array, ""]
    weights: Float[Array, " 4"]
    slopes: Float[Array, " 4"]
    shortfall: Float[Array, ""]
    shortfall_slope: Float[Array, ""]
    growth: Float[Array, ""]


class Kink(NamedTuple):
    """The line under a sheave at p = tan a: |G| / h of its kink, F / (2 T), their slopes, E / (T h).

    `along` is the slope of E / (T h) with s at a fixed gap, over F / (2 T). Beyond `STEEPEST` the force
    stays what it is there: a foot that is still looked for may seem to ask for more.
    """

    reach: Float[Array, ""]
    reach_slope: Float[Array, ""]
    pull: Float[Array, ""]
    pull_slope: Float[Array, ""]
    energy: Float[Array, ""]
    along: Float[Array, ""]

    @classmethod
    def of(cls, reading: Reading, p: Float[Array, ""], bends: bool) -> "Kink":
        """That of an angle; where the line `bends` it is taken for small."""
        d = reading.shortfall
        if bends:
            return cls(d * p, d, p, jnp.ones_like(p), d * p**2, -p * reading.shortfall_slope)
        v = 2.0 * jnp.cumsum(reading.weights)[:3] - 1.0
        change = 2.0 * jnp.cumsum(reading.slopes)[:3] * v
        c, whole = 1.0 / jnp.sqrt(1.0 + (v * p) ** 2), jnp.sqrt(1.0 + p**2)
        open_ = 1.0 - v**2
        reach = 0.5 * p * jnp.sum(open_ * c)
        # cos b / cos a - 1, of small angles without what cancels
        energy = p**2 * jnp.sum(open_ * c**2 / (whole * c + 1.0))
        slope = 0.5 * jnp.sum(open_ * c**3)
        return cls(reach, slope, p / whole, 1.0 / whole**3, energy, p * jnp.sum(change * c))


class Hertz(eqx.Module):
    """Contact of a wheel with a line, f = k x^m + c step(x / d) dx/dt (N) at the depth x (m).

    Gao et al. 2022, eq. 10, with step(y) = y^2 (3 - 2 y) between 0 and 1. `stiffness` k (N/m^m),
    `exponent` m (-), 3/2 for spheres (H. Hertz 1881), `damping` c (N s/m) and `depth` d (m), None
    without damping.
    """

    stiffness: Float[Array, ""]
    exponent: Float[Array, ""]
    damping: Float[Array, ""] | None = None
    depth: Float[Array, ""] | None = None

    def depth_of(self, gap: Float[Array, ""], spring: Float[Array, ""]) -> Float[Array, ""]:
        """x (m) where the contact is in series with a spring (N/m): k x^m = spring (gap - x)."""
        m, ratio = self.exponent, self.stiffness / spring
        gap = jnp.maximum(gap, LEAST)
        x = jnp.minimum(gap, (gap / ratio) ** (1.0 / m))
        for _ in range(DEPTHS):
            power = ratio * x ** (m - 1.0)
            x = x - (power * x + x - gap) / (m * power + 1.0)
        return x

    def energy(self, x: Float[Array, ""]) -> Float[Array, ""]:
        """k x^(m+1) / (m + 1) (J)."""
        return self.stiffness * x ** (self.exponent + 1.0) / (self.exponent + 1.0)

    def drag(self, x, spring: Float[Array, ""]) -> Float[Array, ""]:
        """Damping (N s/m) of the gap: c step(x / d) (dx/dgap)^2, which takes c step (dx/dt)^2."""
        if self.damping is None or self.depth is None:
            return jnp.zeros_like(x)
        y = jnp.clip(x / self.depth, 0.0, 1.0)
        stiff = self.exponent * self.stiffness * x ** (self.exponent - 1.0)
        return self.damping * y**2 * (3.0 - 2.0 * y) * (spring / (spring + stiff)) ** 2


class Contact(NamedTuple):
    """Where a sheave touches: foot s (segments), tangent (d,), stiffness (N/m), push on the line (N).

    `spacing` is |C'| (m), how far the line runs there from one s to the next. `gap` (d,) leads from the
    line to the sheave (m), of which `depth` (m) is that of a Hertz contact, 0 without one; `stiffness`
    is that of the rest, the kink, force over gap. `kink_energy` (J) is that of the spring that stands
    for the kink, and `fall` (J) what it falls by where segments grow by their own length.
    """

    foot: Float[Array, ""]
    reading: Reading
    tangent: Float[Array, " d"]
    spacing: Float[Array, ""]
    gap: Float[Array, " d"]
    stiffness: Float[Array, ""]
    push: Float[Array, " d"]
    depth: Float[Array, ""]
    kink_energy: Float[Array, ""]
    fall: Float[Array, ""]


def extended(nodes: Float[Array, "d nodes"]) -> Float[Array, "d nodes+2"]:
    """The nodes with one mirrored beyond either end, so that the spline ends in the end nodes."""
    before = 2.0 * nodes[:, :1] - nodes[:, 1:2]
    after = 2.0 * nodes[:, -1:] - nodes[:, -2:-1]
    return jnp.concatenate([before, nodes, after], axis=1)


def folded(values: Float[Array, "d nodes+2"]) -> Float[Array, "d nodes"]:
    """The transpose of `extended`: forces on the mirrored nodes go to those they are made of."""
    inner = values[:, 1:-1]
    first, last = values[:, 0], values[:, -1]
    inner = inner.at[:, 0].add(2.0 * first).at[:, 1].add(-first)
    return inner.at[:, -1].add(2.0 * last).at[:, -2].add(-last)


def shortfalls(bend: Float[Array, ""] | None, dtype) -> Float[Array, "4 4"]:
    """|a - b| of four nodes (-), or what a line with bending has for it; `bend` is h / r (-)."""
    apart = jnp.abs(jnp.arange(4.0)[:, None] - jnp.arange(4.0)).astype(dtype)
    return apart if bend is None else apart + jnp.expm1(-apart * bend) / bend


def read(s: Float[Array, ""], segments: int, bend: Float[Array, ""] | None = None) -> Reading:
    """The spline's weights at s, from 0 to `segments`, of a line whose `bend` is h / r (-)."""
    cell = jnp.clip(jnp.floor(jax.lax.stop_gradient(s)), 0, segments - 1)
    x = s - cell
    y = 1.0 - x
    weights = jnp.stack([y**3, 4.0 - 3.0 * x**2 * (1.0 + y), 4.0 - 3.0 * y**2 * (1.0 + x), x**3])
    slopes = jnp.stack([-3.0 * y**2, 9.0 * x**2 - 12.0 * x, 12.0 * y - 9.0 * y**2, 3.0 * x**2])
    weights, slopes = weights / 6.0, slopes / 6.0
    apart = shortfalls(bend, s.dtype)
    far = jnp.sum(apart * weights, axis=1)
    spread, change = jnp.sum(weights * far), 2.0 * jnp.sum(slopes * far)
    growth = jnp.zeros_like(spread)
    if bend is not None:
        ahead = jax.jvp(lambda b: shortfalls(b, s.dtype), (bend,), (bend,))[1]
        growth = weights @ ahead @ weights / spread
    return Reading(cell.astype(int), weights, slopes, spread, change, growth)


def _at(nodes: Float[Array, "d nodes+2"], reading: Reading, weights) -> Float[Array, " d"]:
    d = nodes.shape[0]
    return jnp.sum(jax.lax.dynamic_slice(nodes, (0, reading.first), (d, 4)) * weights, axis=1)


def contact(
    nodes: Float[Array, "d nodes"],
    place: Float[Array, " d"],
    tension: Float[Array, ""],
    segment_length: Float[Array, ""],
    hertz: Hertz | None = None,
    EI: Float[Array, ""] | None = None,
) -> Contact:
    """The contact of a sheave at `place` (m) with a line of equal segments, stiff by `EI` (N m2).

    `segment_length` (m) is that under the tension (N). With a `hertz` contact the wheel sinks into the
    line as well, in series with the kink. The foot is where the energy is stationary along the line, so
    that a frictionless sheave feels no force along it but that of the kink. It is found from the nearest
    node by Newton steps of at most half a segment, with one to the angle of the kink after each.
    """
    all_nodes, h, bends = extended(nodes), segment_length, EI is not None
    segments = nodes.shape[1] - 1
    away = jnp.sum((all_nodes[:, 1:-1] - place[:, None]) ** 2, axis=0)
    s = jnp.argmin(away).astype(place.dtype)
    bend = None if EI is None else h * jnp.sqrt(tension / EI)

    def met(s):
        """The spline at s, the gap to the sheave and its size (m)."""
        reading = read(s, segments, bend)
        gap = place - _at(all_nodes, reading, reading.weights)
        return reading, gap, jnp.sqrt(jnp.maximum(jnp.sum(gap * gap), LEAST**2))

    def sunk(kink: Kink):
        """Depth (m) of the wheel under the force of a kink, and its slope."""
        if hertz is None:
            return 0.0, 0.0
        depth = (2.0 * tension * kink.pull / hertz.stiffness) ** (1.0 / hertz.exponent)
        return depth, depth / hertz.exponent * kink.pull_slope / kink.pull

    def turned(p, reading: Reading, size):
        """The angle, nearer to what the gap asks for."""
        kink = Kink.of(reading, p, bends)
        depth, slope = sunk(kink)
        ahead = (size - depth - h * kink.reach) / (slope + h * kink.reach_slope)
        return jnp.clip(p + ahead, LEAST, STEEPEST)

    def moved(s, p):
        """The foot, nearer to where the energy does not change with it: G . C' = (dE/ds) |G| / F."""

        def imbalance(s):
            reading, gap, size = met(s)
            along = jnp.sum(gap * _at(all_nodes, reading, reading.slopes))
            return along - 0.5 * h * size * Kink.of(reading, p, bends).along

        value, slope = jax.jvp(imbalance, (s,), (jnp.ones_like(s),))
        # of a straight line it is -h^2; from where the energy bends down a step would lead away
        step = jnp.clip(value / jnp.minimum(slope, -FLATTEST * h**2), -0.5, 0.5)
        return jnp.clip(s - step, 0.0, float(segments))

    # nothing here is frozen: few steps from a node leave an error that derivatives would show
    reading, gap, size = met(s)
    unit, free = h * reading.shortfall, size
    if hertz is not None:
        free = size - hertz.depth_of(size, 2.0 * tension / unit)
    p = jnp.clip(free / unit, LEAST, STEEPEST)
    for _ in range(NEWTON):
        s = moved(s, p)
        reading, gap, size = met(s)
        p = turned(p, reading, size)
    kink = Kink.of(reading, p, bends)
    depth = jnp.zeros_like(s) + sunk(kink)[0]
    # no more than p asks for, but beyond the steepest
    over = jnp.where(p < STEEPEST, 0.0, (size - depth) / h - kink.reach)
    reach = kink.reach + over
    energy = kink.energy + 2.0 * kink.pull * over
    along = _at(all_nodes, reading, reading.slopes)
    spacing = jnp.sqrt(jnp.sum(along**2))
    force = 2.0 * tension * kink.pull
    fall = energy * (1.0 + reading.growth) if bends else 2.0 * kink.pull * reach - energy
    return Contact(
        s, reading, along / spacing, spacing, gap, force / (h * reach), force / size * gap, depth,
        tension * h * energy, tension * h * fall,
    )  # fmt: skip


def spread(contact: Contact, force: Float[Array, " d"], nodes: int) -> Float[Array, "d nodes"]:
    """A force (N) at the contact shared out over the line's nodes."""
    table = jnp.zeros((force.shape[0], nodes + 2), force.dtype)
    part = force[:, None] * contact.reading.weights
    return folded(jax.lax.dynamic_update_slice(table, part, (0, contact.reading.first)))


def velocity_at(contact: Contact, velocity: Float[Array, "d nodes"]) -> Float[Array, " d"]:
    """The velocity (m/s) of the line's spline at the contact, at a fixed s."""
    return _at(extended(velocity), contact.reading, contact.reading.weights)
