"""What is around the lines: water or air with its current, and the seabed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Tag

from lumpedcable.scene.angles import turn_problems
from lumpedcable.scene.part import Part, Problem, choose, pick_word, tag
from lumpedcable.scene.quantities import (
    Angle,
    Count,
    Density,
    FoundationDamping,
    FoundationStiffness,
    Length,
    NonNegativeLength,
    NonNegativeNumber,
    PositiveLength,
    PositiveNumber,
    PositiveTime,
    Velocity,
)
from lumpedcable.scene.records import table_problems


class UniformCurrent(Part):
    """The same velocity everywhere."""

    profile: Literal["uniform"] = "uniform"
    """The shape over depth."""
    velocity: Velocity
    """Velocity of the fluid in m/s."""


class PowerCurrent(Part):
    """v(z) = V clip((z - surface + depth) / depth, 0, 1)^exponent."""

    profile: Literal["power"]
    """The shape over depth."""
    velocity: Velocity
    """Velocity V at the surface and above, in m/s."""
    exponent: NonNegativeNumber
    """Exponent of the profile, about 1/7 for a tidal current."""
    depth: PositiveLength
    """Depth in m below the surface at which the current has died out."""
    surface: Length | None = None
    """Height z of the surface in m. Absent: as the scene tells it elsewhere, or 0."""


class TableCurrent(Part):
    """Velocities at heights, which may turn with depth; straight between them, the last beyond."""

    profile: Literal["table"]
    """The shape over depth."""
    z: tuple[Length, ...]
    """Heights z in m, increasing: from the bed up."""
    velocity: tuple[Velocity, ...]
    """Velocities at those heights in m/s."""

    def problems(self) -> Iterator[Problem]:
        """Yield lists of unequal length and heights that do not increase."""
        yield from table_problems("z", self.z, "height", "m", self.velocity, "velocity")


CURRENTS: dict[str, type[Part]] = {
    "uniform": UniformCurrent,
    "power": PowerCurrent,
    "table": TableCurrent,
}
"""The one place where ``profile = "..."`` becomes a class."""


def _pick(value: Any) -> str:
    return pick_word(value, "profile", CURRENTS, default="uniform")


Current = Annotated[
    Annotated[UniformCurrent, Tag(tag("uniform"))]
    | Annotated[PowerCurrent, Tag(tag("power"))]
    | Annotated[TableCurrent, Tag(tag("table"))],
    *choose(_pick, "a table with velocity"),
]
"""A current; ``profile`` says which."""


class Fluid(Part):
    """Water or air: it carries part of the weight of lines, drags on them and moves with them."""

    density: Density
    """Mass per volume in kg/m3."""
    current: Current | None = None
    """Motion of the fluid. Absent: at rest."""
    surface: Length | None = None
    """Height z in m of the surface of water at rest; lines and bodies are dry above it. Absent: the
    fluid is everywhere."""


class SeaFlow(Part):
    """How the water moves in waves, by linear theory: it drags on lines and pushes them."""

    surface: Length | None = None
    """Height z in m of the mean surface; above it the water moves as in it. Absent: as the scene tells
    it elsewhere, or 0."""
    ramp: PositiveTime | None = None
    """Time in s over which the motion grows from rest. Absent: at once."""


class Sea(Part):
    """Long-crested waves of a JONSWAP spectrum, as a sum of sines with random phases.

    S(w) ~ w^-5 exp(-5/4 (wp/w)^4) gamma^exp(-((w - wp)/(s wp))^2/2), s = 0.07 up to wp and 0.09
    beyond, so scaled that the surface has the standard deviation height / 4.
    """

    height: NonNegativeLength
    """Significant wave height Hs in m."""
    period: PositiveTime
    """Period of the peak of the spectrum in s."""
    gamma: PositiveNumber = 3.3
    """Peak enhancement; 1 is the Pierson-Moskowitz spectrum of a fully developed sea."""
    seed: Annotated[int, Count(0)] = 1
    """Which phases are drawn."""
    components: Annotated[int, Count(1, 10_000)] = 100
    """Number of sines. One is a regular wave of that period; fewer than 36 have equal heights."""
    direction: Angle = 0.0
    """Direction in rad that the waves travel in, from the x axis towards y."""
    depth: PositiveLength | None = None
    """Depth in m of the water, which makes waves shorter; over a seabed that of it, to 10 %. Absent:
    deep."""
    flow: SeaFlow | None = None
    """Motion of the water in these waves, which lines with a diameter and submerged bodies feel.
    Absent: none."""

    def problems(self) -> Iterator[Problem]:
        """Yield a direction in degrees that stands without its unit."""
        yield from turn_problems(("direction",), self.direction)


class Profile(Part):
    """How deep the bed is along x: a smooth curve through points, straight beyond them.

    Monotone cubics between the points (`physics.curve`); the same for all y.
    """

    x: tuple[Length, ...]
    """Places along x in m, increasing."""
    depth: tuple[Length, ...]
    """Depths in m at those places, under the height of the bed."""

    def problems(self) -> Iterator[Problem]:
        """Yield lists of unequal length and places that do not increase."""
        yield from table_problems("x", self.x, "place", "m", self.depth, "depth")

    def at(self, x: float) -> float:
        """Return the depth in m at x on straight lines between the points: enough for checks."""
        return float(np.interp(x, self.x, self.depth))


class Seabed(Part):
    """A bed that lines rest on; a spring under every metre of them.

    A line that weighs w (N/m) sinks about w / stiffness into it. There is no stiffness that suits a
    rope and a chain alike, so it has no default: w over a hundredth of the diameter is a good one.
    """

    height: Length
    """Height z of the bed in m; the axis of a line rests on it."""
    stiffness: FoundationStiffness
    """Upward force in N per m of unstretched length and per m of penetration, so in Pa."""
    damping: FoundationDamping | None = None
    """Force in N per m of unstretched length and per m/s of speed along the bed's normal, in contact
    only, so in Pa s; with the spring it never pulls. Absent: none."""
    friction: NonNegativeNumber | None = None
    """Coulomb's coefficient of lines on the bed. Absent: none."""
    profile: Profile | None = None
    """How deep it lies under `height` along x. Absent: flat."""

    def height_at(self, x: float) -> float:
        """Return the height in m of the bed at x, roughly between the points of a profile."""
        return self.height - (0.0 if self.profile is None else self.profile.at(x))
