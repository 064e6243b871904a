"""What the pressure in waves does to a floating box that they pass as if it were not there."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.sea import SeaState

__all__ = ["PressedBox"]

FLAT = 3e-2  # angle below which three terms of a series are good to 1e-12, and the formula is not


class PressedBox(eqx.Module):
    """Forces and moments of Froude and Krylov on a box: the pressure of the waves on its wetted faces.

    p = rho g a P(z) cos(w t - k X + e) with P = cosh k(h + z) / cosh k h, exp(k z) on deep water, is
    summed over the faces of a box of `length` l and `breadth` b (m) that floats upright with its keel
    at z = -`draught` (m); moments are about its centre, `above` (m) over the water. With c = k cos m and
    s = k sin m, m = `heading` (rad) the way of the waves from its length, S(q, a) = 2 sin(q a/2) / q,
    D(q, a) = 2 (sin(q a/2) - (q a/2) cos(q a/2)) / q^2 and the integrals V0, V1 (m, m2) of P and of
    (z - above) P over the draught, per metre of a and per `weight` = rho g (N/m3) they are

    surge i V0 S(s, b) 2 sin(c l/2), sway i V0 S(c, l) 2 sin(s b/2), heave P(-T) S(c, l) S(s, b),
    roll -i S(c, l) (P(-T) D(s, b) + V1 2 sin(s b/2)),
    pitch i S(s, b) (P(-T) D(c, l) + V1 2 sin(c l/2)),
    yaw V0 (D(c, l) 2 sin(s b/2) - D(s, b) 2 sin(c l/2)),

    complex amplitudes ahead of the crest at its middle (Faltinsen, Sea Loads on Ships and Offshore
    Structures, 1990, chapter 3: the part of the exciting force that the hull does not disturb).
    """

    length: Float[Array, ""]
    breadth: Float[Array, ""]
    draught: Float[Array, ""]
    above: Float[Array, ""]
    weight: Float[Array, ""]
    heading: Float[Array, ""]

    def response(self, sea: SeaState) -> tuple[Float[Array, "6 N"], Float[Array, "6 N"]]:
        """Real and imaginary parts (N/m, N) of the six for each component of a sea."""
        k = sea.number
        c, s = k * jnp.cos(self.heading), k * jnp.sin(self.heading)
        along, across = _plain(c, self.length), _plain(s, self.breadth)
        lever_along, lever_across = _lever(c, self.length), _lever(s, self.breadth)
        ends, sides = 2.0 * jnp.sin(0.5 * c * self.length), 2.0 * jnp.sin(0.5 * s * self.breadth)
        keel, whole, moment = self._depths(k, sea.depth)
        none = jnp.zeros_like(k)
        real = [none, none, keel * along * across, none, none]
        real += [whole * (lever_along * sides - lever_across * ends)]
        turned = [whole * across * ends, whole * along * sides, none]
        turned += [-along * (keel * lever_across + moment * sides)]
        turned += [across * (keel * lever_along + moment * ends), none]
        return self.weight * jnp.stack(real), self.weight * jnp.stack(turned)

    def _depths(self, k: Float[Array, " N"], depth: Float[Array, ""] | None):
        """P(-T), V0 and V1 of waves with such numbers k (1/m)."""
        low = self.draught
        down = jnp.exp(-k * low)
        # what an endless depth has, and what the bed sends back of it
        keel, whole = down, -jnp.expm1(-k * low) / k
        moment = (-1.0 + down * (1.0 + k * low)) / k**2
        if depth is not None:
            bed = jnp.exp(-2.0 * k * depth)
            up, share = jnp.exp(-k * (2.0 * depth - low)), 1.0 / (1.0 + bed)
            keel = share * (keel + up)
            whole = share * (whole + (up - bed) / k)
            moment = share * (moment + (up * (1.0 - k * low) - bed) / k**2)
        return keel, whole, moment - self.above * whole


def _plain(q: Float[Array, " N"], side: Float[Array, ""]) -> Float[Array, " N"]:
    """The integral of cos(q x) over a side (m)."""
    x, small, safe = _apart(0.5 * q * side)
    return side * jnp.where(small, 1.0 - x**2 / 6.0 * (1.0 - x**2 / 20.0), jnp.sin(safe) / safe)


def _lever(q: Float[Array, " N"], side: Float[Array, ""]) -> Float[Array, " N"]:
    """The integral of x sin(q x) over a side (m2)."""
    x, small, safe = _apart(0.5 * q * side)
    full = (jnp.sin(safe) - safe * jnp.cos(safe)) / safe**2
    return (
        0.5 * side**2 * jnp.where(small, x / 3.0 * (1.0 - x**2 / 10.0 * (1.0 - x**2 / 28.0)), full)
    )


def _apart(x: Float[Array, " N"]):
    """Angles, which of them are small, and angles that are not: the small ones replaced."""
    small = jnp.abs(x) < FLAT
    return x, small, jnp.where(small, 1.0, x)
