"""A sheave that runs on a lumped line: smooth as it crosses nodes, exact in the kink under it.

The line is read as a cubic B-spline of its nodes, C(s) = sum_a w_a(s) r_a over four of them, s counted
in segments from the line's start. A taut line that is loaded through such weights sags too little by
F h d / (2 T), d = sum_ab w_a w_b |a - b|, with F the force, h the length of a segment and T the tension.
A spring of stiffness 2 T / (h d) between the sheave and C gives back just that: it is no penalty,
and there is no constant to choose.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

__all__ = ["Contact", "Reading", "contact", "extended", "folded", "read"]

NEWTON = 2  # steps to the foot; from the nearest node they end in rounding


class Reading(NamedTuple):
    """The spline at a place: first of its four nodes, weights, their slopes, and the shortfall d, d'."""

    first: Int[Array, ""]
    weights: Float[Array, " 4"]
    slopes: Float[Array, " 4"]
    shortfall: Float[Array, ""]
    shortfall_slope: Float[Array, ""]


class Contact(NamedTuple):
    """Where a sheave touches: foot s (segments), tangent (d,), stiffness (N/m), push on the line (N).

    `gap` (d,) leads from the line to the sheave (m); `share` are the weights of the extended nodes.
    """

    foot: Float[Array, ""]
    reading: Reading
    tangent: Float[Array, " d"]
    gap: Float[Array, " d"]
    stiffness: Float[Array, ""]
    push: Float[Array, " d"]


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


def read(s: Float[Array, ""], segments: int) -> Reading:
    """The spline's weights at s, from 0 to `segments`."""
    cell = jnp.clip(jnp.floor(jax.lax.stop_gradient(s)), 0, segments - 1)
    x = s - cell
    y = 1.0 - x
    weights = jnp.stack([y**3, 4.0 - 3.0 * x**2 * (1.0 + y), 4.0 - 3.0 * y**2 * (1.0 + x), x**3])
    slopes = jnp.stack([-3.0 * y**2, 9.0 * x**2 - 12.0 * x, 12.0 * y - 9.0 * y**2, 3.0 * x**2])
    weights, slopes = weights / 6.0, slopes / 6.0
    apart = jnp.abs(jnp.arange(4.0)[:, None] - jnp.arange(4.0)).astype(s.dtype)
    far = jnp.sum(apart * weights, axis=1)
    spread, change = jnp.sum(weights * far), 2.0 * jnp.sum(slopes * far)
    return Reading(cell.astype(int), weights, slopes, spread, change)


def _at(nodes: Float[Array, "d nodes+2"], reading: Reading, weights) -> Float[Array, " d"]:
    d = nodes.shape[0]
    return jnp.sum(jax.lax.dynamic_slice(nodes, (0, reading.first), (d, 4)) * weights, axis=1)


def _imbalance(s, nodes: Float[Array, "d nodes+2"], place: Float[Array, " d"]):
    """G . C' + (d'/d) |G|^2 / 2: what vanishes where the energy |G|^2 / d does not change with s."""
    reading = read(s, nodes.shape[1] - 3)
    gap = place - _at(nodes, reading, reading.weights)
    along = _at(nodes, reading, reading.slopes)
    spread = reading.shortfall_slope / reading.shortfall
    return jnp.sum(gap * along) + 0.5 * spread * jnp.sum(gap * gap)


def contact(
    nodes: Float[Array, "d nodes"],
    place: Float[Array, " d"],
    tension: Float[Array, ""],
    segment_length: Float[Array, ""],
) -> Contact:
    """The contact of a sheave at `place` (m) with a line of equal segments.

    The foot is where the energy T |G|^2 / (h d) is stationary along the line, so that a frictionless
    sheave feels no force along it but that of the kink. It is found from the nearest node by Newton
    steps of at most half a segment; the last one carries the derivative.
    """
    all_nodes = extended(nodes)
    segments = nodes.shape[1] - 1
    frozen, here = jax.lax.stop_gradient((all_nodes, place))
    away = jnp.sum((frozen[:, 1:-1] - here[:, None]) ** 2, axis=0)
    s = jnp.argmin(away).astype(place.dtype)

    def both(s):
        return jax.jvp(lambda at: _imbalance(at, frozen, here), (s,), (jnp.ones_like(s),))

    for _ in range(NEWTON):
        value, slope = both(s)
        s = jnp.clip(s - jnp.clip(value / slope, -0.5, 0.5), 0.0, float(segments))
    s, (_, slope) = jax.lax.stop_gradient((s, both(s)))
    s = s - _imbalance(s, all_nodes, place) / slope
    reading = read(s, segments)
    gap = place - _at(all_nodes, reading, reading.weights)
    along = _at(all_nodes, reading, reading.slopes)
    stiffness = 2.0 * tension / (segment_length * reading.shortfall)
    tangent = along / jnp.sqrt(jnp.sum(along**2))
    return Contact(s, reading, tangent, gap, stiffness, stiffness * gap)


def spread(contact: Contact, force: Float[Array, " d"], nodes: int) -> Float[Array, "d nodes"]:
    """A force (N) at the contact shared out over the line's nodes."""
    table = jnp.zeros((force.shape[0], nodes + 2), force.dtype)
    part = force[:, None] * contact.reading.weights
    return folded(jax.lax.dynamic_update_slice(table, part, (0, contact.reading.first)))


def velocity_at(contact: Contact, velocity: Float[Array, "d nodes"]) -> Float[Array, " d"]:
    """The velocity (m/s) of the line's spline at the contact, at a fixed s."""
    return _at(extended(velocity), contact.reading, contact.reading.weights)
