"""Morison's equation for a slender line: drag and added mass, across and along it."""

import math

import equinox as eqx
from jaxtyping import Array, Float

__all__ = ["TANGENTIAL_AREA", "AddedMass", "Drag"]

# Area per length and diameter on which the tangential coefficient acts. The textbook takes the
# wetted skin; "half" is the reading that reproduces the displacements of Zhu, Yin & Shen (2018);
# "projected" uses the frontal area as for the normal coefficient.
TANGENTIAL_AREA = {"textbook": math.pi, "half": 0.5 * math.pi, "projected": 1.0}


class Drag(eqx.Module):
    """Quadratic drag per metre of unstretched length, normal and tangential parts apart.

    f_n = -1/2 rho d C_n |v_n| v_n and f_t = -1/2 rho a d C_t |v_t| v_t (N/m), with v the velocity
    relative to the fluid (m/s) split along the node's tangent, rho the fluid's density (kg/m3), d
    the diameter (m) and a the convention of `TANGENTIAL_AREA` (Zhu, Yin & Shen 2018, after Ablow &
    Schechter 1983). Kept are the factors of |v| v, `normal` and `tangential` (N s2/m3).
    """

    tangential: Float[Array, ""]
    normal: Float[Array, ""]

    def __init__(
        self,
        density: Float[Array, ""],
        diameter: Float[Array, ""],
        normal: Float[Array, ""],
        tangential: Float[Array, ""],
        convention: str,
    ):
        dynamic = 0.5 * density * diameter
        self.normal = dynamic * normal
        self.tangential = dynamic * TANGENTIAL_AREA[convention] * tangential


class AddedMass(eqx.Module):
    """Mass of fluid (kg per metre of unstretched length) that a line takes along.

    m_n = C_n rho pi d^2 / 4 across the line, and likewise m_t along it where C_t is given.
    """

    normal: Float[Array, ""]
    tangential: Float[Array, ""] | None

    def __init__(
        self,
        density: Float[Array, ""],
        diameter: Float[Array, ""],
        normal: Float[Array, ""],
        tangential: Float[Array, ""] | None,
    ):
        displaced = density * 0.25 * math.pi * diameter**2
        self.normal = normal * displaced
        self.tangential = None if tangential is None else tangential * displaced
