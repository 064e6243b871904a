"""Segments as rigid rods: mass that is spread along them, and drag with its own tangent.

A rod of length l moves as its two ends do, v(s) = (1 - s) v_1 + s v_2. Kinetic energy and the work of
drag along it are integrals of products of these two shapes, so that masses of 1/3 and 1/6 of the rod's
go to its ends and between them. Half a mass at each end would be a dumb-bell: where rods are long, it
rings at the joints.
"""

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.physics.vectors import dot, size

__all__ = ["ROD_SHARES", "rod_drag", "rod_energy", "rod_mass"]

ROD_SHARES = (1.0 / 3.0, 1.0 / 6.0)  # of a rod's mass: at an end, and between the two ends
# Gauss-Legendre on [0, 1]: exact for the cubics that drag times a shape is while it keeps its sign
_PLACES = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


def rod_mass(
    along: Float[Array, " n"], across: Float[Array, " n"], tangent: Float[Array, "d n"]
) -> Float[Array, "n d d"]:
    """m_t t t^T + m_n (I - t t^T) of whole rods (kg), from masses along and across them (n,)."""
    t = tangent.T
    outer = t[:, :, None] * t[:, None, :]
    eye = jnp.eye(t.shape[1], dtype=t.dtype)
    return across[:, None, None] * eye + (along - across)[:, None, None] * outer


def rod_energy(
    along: Float[Array, " n"], across: Float[Array, " n"], tangent: Float[Array, "d n"],
    first: Float[Array, "d n"], last: Float[Array, "d n"],
) -> Float[Array, ""]:  # fmt: skip
    """Kinetic energy (J) of rods whose ends have the velocities `first` and `last` (m/s)."""
    total = jnp.zeros((), tangent.dtype)
    for a, b, share in ((first, first, 1.0), (last, last, 1.0), (first, last, 1.0)):
        s, r = dot(a, tangent), dot(b, tangent)
        total = total + share * jnp.sum(across * dot(a, b) + (along - across) * s * r)
    return 0.5 * ROD_SHARES[0] * total


def rod_drag(
    normal: Float[Array, " n"], tangential: Float[Array, " n"], tangent: Float[Array, "d n"],
    first: Float[Array, "d n"], last: Float[Array, "d n"],
) -> tuple[Float[Array, "d n"], Float[Array, "d n"]]:  # fmt: skip
    """Drag (N) on the two ends of rods, -k |v| v along and across them integrated over their length.

    `normal` and `tangential` are k times the rod's length (N s2/m2), `first` and `last` the ends'
    velocities relative to the fluid (m/s), each (d, n).
    """
    forces = [jnp.zeros_like(first), jnp.zeros_like(last)]
    for place in _PLACES:
        v = (1.0 - place) * first + place * last
        s = dot(v, tangent)
        across = v - s * tangent
        f = -0.5 * (tangential * jnp.abs(s) * s * tangent + normal * size(across) * across)
        forces = [forces[0] + (1.0 - place) * f, forces[1] + place * f]
    return forces[0], forces[1]
