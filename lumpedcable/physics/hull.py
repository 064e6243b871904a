"""A hull in water at rest or in a current: what holds it up and what slows it down."""

from typing import ClassVar

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.body import AbstractBodyLoad

__all__ = ["Hydrostatics", "box_draught", "box_metacentre"]


class Hydrostatics(AbstractBodyLoad):
    """Weight and buoyancy of a hull that floats, for small motions about where it floats freely.

    E = (rho g A z^2 + D GM_T roll^2 + D GM_L pitch^2) / 2 with z the height (m) of the centre of
    gravity over `floating`, its place at rest over the origin of the scene's coordinates; A the
    waterplane (m2), D the weight (N), GM the metacentric heights (m). `heave` is rho g A (N/m),
    `tilt` D GM about each angle that there is (N m). Heave and pitch do not couple for a hull whose
    waterplane is centred over its centre of gravity (Liu et al. 2018, eq. 53-58, where eq. 58 lacks
    two signs and the displaced volume).
    """

    energy_name: ClassVar[str] = "hydrostatic"
    up: Float[Array, " d"]
    floating: Float[Array, ""]
    heave: Float[Array, ""]
    tilt: Float[Array, " a"]

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """Energy (J) over that of the hull that floats freely."""
        d = self.up.shape[0]
        rise = self.up @ q[:d] - self.floating
        return 0.5 * (self.heave * rise**2 + jnp.sum(self.tilt * q[d:] ** 2))


def box_metacentre(
    length: Float[Array, ""], draught: Float[Array, ""], above_keel: Float[Array, ""]
) -> Float[Array, ""]:
    """Metacentric height GM (m) of a floating box about the axis across its side `length` (m).

    GM = KB + BM - KG = T/2 + l^2 / (12 T) - KG (Liu et al. 2018, eq. 57: I/V = l^3 b / (12 l b T)).
    """
    return 0.5 * draught + length**2 / (12.0 * draught) - above_keel


def box_draught(
    mass: Float[Array, ""], density: Float[Array, ""], size: tuple[Float[Array, ""], ...]
) -> Float[Array, ""]:
    """Draught T = m / (rho l b) (m) of a floating box."""
    return mass / (density * size[0] * size[1])
