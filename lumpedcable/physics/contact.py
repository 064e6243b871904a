"""A sheave that runs on a lumped line: smooth as it crosses nodes, exact in the kink under it.

The line is read as a cubic B-spline of its nodes, C(s) = sum_a w_a(s) r_a over four of them, s counted
in segments from the line's start. A taut line that is loaded through such weights sags too little by
F h d / (2 T), d = sum_ab w_a w_b |a - b|, with F the force, h the length of a segment and T the tension.
A spring of stiffness 2 T / (h d) between the sheave and C gives back just that: it is no penalty,
and there is no constant to choose.

A line with bending stiffness EI has no kink but a bend of the reach r = sqrt(EI / T): the sag of a
pinned tie rod at x from a load F is lower than under it by F/(2 T) (x - r (1 - exp(-x / r))). Then
|a - b| is |a - b| - (1 - exp(-|a - b| h / r)) r / h (S. Timoshenko, Strength of Materials II, 1956).
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

__all__ = ["Contact", "Hertz", "Reading", "contact", "extended", "folded", "read", "shortfalls"]

NEWTON = 2  # steps to the foot; from the nearest node they end in rounding
LEAST = 1e-12  # m, below which a gap is none
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
    is that of the rest, the kink.
    """

    foot: Float[Array, ""]
    reading: Reading
    tangent: Float[Array, " d"]
    spacing: Float[Array, ""]
    gap: Float[Array, " d"]
    stiffness: Float[Array, ""]
    push: Float[Array, " d"]
    depth: Float[Array, ""]

    @property
    def kink_energy(self) -> Float[Array, ""]:
        """Energy (J) of the spring that stands for the kink."""
        return 0.5 * jnp.dot(self.push, self.push) / self.stiffness


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


def _imbalance(s, nodes: Float[Array, "d nodes+2"], place: Float[Array, " d"], bent, bend=None):
    """G . C' + (d'/d) bent |G|^2 / 2: what vanishes where the energy does not change with s.

    `bent` is the share of |G| that is the kink's, 1 without a Hertz contact.
    """
    reading = read(s, nodes.shape[1] - 3, bend)
    gap = place - _at(nodes, reading, reading.weights)
    along = _at(nodes, reading, reading.slopes)
    spread = reading.shortfall_slope / reading.shortfall
    return jnp.sum(gap * along) + 0.5 * spread * bent * jnp.sum(gap * gap)


def contact(
    nodes: Float[Array, "d nodes"],
    place: Float[Array, " d"],
    tension: Float[Array, ""],
    segment_length: Float[Array, ""],
    hertz: Hertz | None = None,
    EI: Float[Array, ""] | None = None,
) -> Contact:
    """The contact of a sheave at `place` (m) with a line of equal segments, stiff by `EI` (N m2).

    With a `hertz` contact the wheel sinks into the line as well, in series with the kink. The foot is
    where the energy T |G|^2 / (h d) is stationary along the line, so that a frictionless sheave feels
    no force along it but that of the kink. It is found from the nearest node by Newton steps, all but
    the last of at most half a segment.
    """
    all_nodes = extended(nodes)
    segments = nodes.shape[1] - 1
    away = jnp.sum((all_nodes[:, 1:-1] - place[:, None]) ** 2, axis=0)
    s = jnp.argmin(away).astype(place.dtype)

    bend = None if EI is None else segment_length * jnp.sqrt(tension / EI)

    def spring(reading: Reading):
        return 2.0 * tension / (segment_length * reading.shortfall)

    def kinked(s):
        """The share of the gap that is the kink's."""
        if hertz is None:
            return jnp.ones_like(s)
        reading = read(s, segments, bend)
        gap = place - _at(all_nodes, reading, reading.weights)
        size = jnp.sqrt(jnp.maximum(jnp.sum(gap * gap), LEAST**2))
        return 1.0 - hertz.depth_of(size, spring(reading)) / size

    def change(s):
        """The Newton step."""
        bent = kinked(s)
        value, slope = jax.jvp(
            lambda at: _imbalance(at, all_nodes, place, bent, bend), (s,), (jnp.ones_like(s),)
        )
        return value / slope

    # nothing here is frozen: two steps from a node leave an error that derivatives would show
    for _ in range(NEWTON):
        s = jnp.clip(s - jnp.clip(change(s), -0.5, 0.5), 0.0, float(segments))
    s = s - change(s)
    reading = read(s, segments, bend)
    gap = place - _at(all_nodes, reading, reading.weights)
    along = _at(all_nodes, reading, reading.slopes)
    stiffness = spring(reading)
    spacing = jnp.sqrt(jnp.sum(along**2))
    tangent = along / spacing
    if hertz is None:
        none = jnp.zeros_like(stiffness)
        return Contact(s, reading, tangent, spacing, gap, stiffness, stiffness * gap, none)
    size = jnp.sqrt(jnp.maximum(jnp.sum(gap * gap), LEAST**2))
    depth = hertz.depth_of(size, stiffness)
    push = stiffness * (1.0 - depth / size) * gap
    return Contact(s, reading, tangent, spacing, gap, stiffness, push, depth)


def spread(contact: Contact, force: Float[Array, " d"], nodes: int) -> Float[Array, "d nodes"]:
    """A force (N) at the contact shared out over the line's nodes."""
    table = jnp.zeros((force.shape[0], nodes + 2), force.dtype)
    part = force[:, None] * contact.reading.weights
    return folded(jax.lax.dynamic_update_slice(table, part, (0, contact.reading.first)))


def velocity_at(contact: Contact, velocity: Float[Array, "d nodes"]) -> Float[Array, " d"]:
    """The velocity (m/s) of the line's spline at the contact, at a fixed s."""
    return _at(extended(velocity), contact.reading, contact.reading.weights)
