"""Bodies: point masses that lines are tied to, and rigid bodies with points of their own."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from lumpedcable.scene.angles import turn_problems
from lumpedcable.scene.motions import HarmonicWaves, PressureWaves, Waves
from lumpedcable.scene.part import Name, Part, Problem
from lumpedcable.scene.quantities import (
    Angle,
    Damper,
    Force,
    KinematicViscosity,
    Length,
    MomentOfInertia,
    NonNegativeNumber,
    Position,
    PositiveLength,
    PositiveMass,
    PositiveSpring,
    Spring,
    Torque,
    TurnDamper,
    TurnSpring,
    Velocity,
    Volume,
)
from lumpedcable.scene.units import format_quantity

if TYPE_CHECKING:
    from numpy.typing import NDArray

Freedom = Literal["x", "y", "z", "roll", "pitch", "yaw"]
SHIFTS: tuple[Freedom, ...] = ("x", "y", "z")
ANGLES: tuple[Freedom, ...] = ("roll", "pitch", "yaw")
WAYS: dict[str, str] = {
    "surge": "x", "sway": "y", "heave": "z", "roll": "roll", "pitch": "pitch", "yaw": "yaw"
}  # fmt: skip
"""The way in `free` of each freedom that waves push."""

STEEP = 0.1
"""|cos(pitch)| below which a body's roll and yaw in space can no longer be told apart: 6 degrees."""

# any of these makes a body a rigid one
_RIGID = ("points", "size", "inertia", "attitude", "velocity", "free", "hull", "bearing", "friction",
          "added_mass",
          "drag", "control", "waves")  # fmt: skip


class Resistance(Part):
    """Friction of the wetted skin by the line of ITTC 1957, with an allowance for roughness.

    R = f rho S (C_F + C_A) v |v| with C_F = 0.075 / (log10 Re - 2)^2 and
    C_A = (105 (k / L)^(1/3) - 0.64) / 1000.
    """

    viscosity: KinematicViscosity
    """Kinematic viscosity of the water in m2/s."""
    roughness: PositiveLength = 150e-6
    """Height k of the roughness in m."""
    convention: Literal["textbook", "doubled"] = "textbook"
    """f = 1/2, or 1 as printed by Liu et al. (2018), eq. 62."""


class Hull(Part):
    """A box that floats upright: its weight is carried by the water that it displaces."""

    above_keel: PositiveLength | None = None
    """Height of the centre of gravity over the keel in m. Absent: half the height of the box."""
    above_water: Length | None = None
    """Height of the centre of gravity over the water's surface in m, instead of above_keel."""
    resistance: Resistance | None = None
    """Resistance of the skin to motion along the length. Absent: none."""
    surface: Length | None = None
    """Height z of the water's surface in m. Absent: as the scene tells it elsewhere, or 0."""


class BodyControl(Part):
    """What steers a ship: steady thrust, and a pull back to its place and attitude of the start."""

    force: tuple[Force, Force, Force] | None = None
    """Thrust in N along its own axes: propellers, side thrusters. Absent: none."""
    moment: tuple[Torque, Torque, Torque] | None = None
    """Moment in N m about its own axes. Absent: none."""
    stiffness: tuple[Spring, Spring, Spring] | None = None
    """Force in N per m off its place, along x, y and z. Absent: none."""
    damping: tuple[Damper, Damper, Damper] | None = None
    """Force in N per m/s, along x, y and z. Absent: none."""
    turn_stiffness: tuple[TurnSpring, TurnSpring, TurnSpring] | None = None
    """Moment in N m per rad of roll, pitch and yaw off its attitude. Absent: none."""
    turn_damping: tuple[TurnDamper, TurnDamper, TurnDamper] | None = None
    """Moment in N m per rad/s of roll, pitch and yaw. Absent: none."""


class Body(Part):
    """A point mass, or with any key after volume a rigid body."""

    mass: PositiveMass
    """Mass in kg."""
    position: Position | None = None
    """Place in m: of a point a guess for the start state (absent: found from the lines), of a rigid
    body where its centre of gravity starts."""
    volume: Volume | None = None
    """Displaced volume in m3, for buoyancy. Absent: none."""
    points: dict[Name, Position] = Field(default_factory=dict)
    """Points of a rigid body that lines can end at, in m from its centre of gravity along its own
    axes."""
    size: tuple[PositiveLength, PositiveLength, PositiveLength] | None = None
    """Length, breadth and height in m of a rigid body that is a box."""
    inertia: tuple[MomentOfInertia, MomentOfInertia, MomentOfInertia] | None = None
    """Moments of inertia in kg m2 about its own axes. Absent: those of a uniform box of its size."""
    attitude: tuple[Angle, Angle, Angle] | None = None
    """Roll, pitch and yaw in rad at the start; in space no pitch within 6 degrees of +-90 degrees.
    Absent: none."""
    velocity: Velocity | None = None
    """Velocity in m/s at the start, given to the body after the rest of the scene has come to rest.
    Absent: none."""
    free: tuple[Freedom, ...] | None = None
    """How a rigid body can move. Absent: in every way."""
    bearing: PositiveSpring | None = None
    """Stiffness in N/m with which the bed bears it, a quarter at each corner of its size; without a size
    its centre stands on the bed. Absent: a bed does not bear it."""
    friction: NonNegativeNumber | None = None
    """Coulomb's coefficient where it rests on the bed, for a body with bearing or whose height is not
    free; of the latter the bottom of its size, if it has one, within a tenth of its height of the bed.
    Absent: none."""
    drag: tuple[NonNegativeNumber, NonNegativeNumber, NonNegativeNumber] | None = None
    """Drag coefficients along its length, breadth and height, on the faces of its size, of a hull on all
    of them, dry part too. Absent: none."""
    added_mass: tuple[NonNegativeNumber, NonNegativeNumber, NonNegativeNumber] | None = None
    """Mass of water that a rigid body takes along its length, breadth and height, over that which its
    volume displaces; with water.surface that of its wet share. Absent: none."""
    control: BodyControl | None = None
    """What steers a rigid body. Absent: nothing."""
    waves: Waves | None = None
    """What waves push a free body with. Absent: nothing."""
    hull: Hull | None = None
    """It floats. Absent: it has its weight, less the buoyancy of volume."""
    settle: bool = False
    """Whether a rigid body starts at rest: where its lines, weight, water and thrust balance. Its
    position and attitude are a first guess then."""

    @property
    def rigid(self) -> bool:
        """Whether it is more than a point mass."""
        return self.settle or any(getattr(self, key) not in (None, {}) for key in _RIGID)

    @property
    def turns(self) -> bool:
        """Whether it is free to turn."""
        return self.rigid and (self.free is None or any(angle in self.free for angle in ANGLES))

    @property
    def steep(self) -> bool:
        """Whether it starts pitched to where roll and yaw, which it is free to change, are one."""
        if self.attitude is None or not (self.free is None or {"roll", "yaw"} <= set(self.free)):
            return False
        return abs(math.cos(self.attitude[1])) < STEEP

    @property
    def feels_flow(self) -> bool:
        """Whether water that moves in waves acts on it."""
        return self.drag is not None or (self.volume is not None and self.waves is None)

    @property
    def turned(self) -> NDArray[np.float64]:
        """The rotation (3, 3) of a rigid body at the start: roll, then pitch, then yaw."""
        turn = np.eye(3)
        for axis, angle in enumerate(self.attitude or ()):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            step = np.eye(3)
            step[[i, j], [i, j]] = np.cos(angle)
            step[i, j], step[j, i] = -np.sin(angle), np.sin(angle)
            turn = step @ turn
        return turn

    @property
    def corners(self) -> NDArray[np.float64]:
        """The corners of its size, about its position, where they are at the start in m, (8, 3)."""
        assert self.size is not None
        assert self.position is not None
        own = 0.5 * np.array(list(itertools.product(*((-side, side) for side in self.size))))
        return np.asarray(self.position) + own @ self.turned.T

    def draught(self, density: float) -> float:
        """Return the draught T = m / (rho l b) (m) of a box that floats; numbers may be traced."""
        assert self.size is not None
        return self.mass / (density * self.size[0] * self.size[1])

    def above_keel(self, density: float) -> float:
        """Return the height of a hull's centre of gravity over its keel (m)."""
        assert self.hull is not None
        assert self.size is not None
        if self.hull.above_water is not None:
            return self.draught(density) + self.hull.above_water
        return 0.5 * self.size[2] if self.hull.above_keel is None else self.hull.above_keel

    def metacentres(self, density: float) -> tuple[float, float]:
        """Return the metacentric heights GM (m) of a hull that rolls and that pitches.

        GM = KB + BM - KG = T/2 + b^2 / (12 T) - KG, b its breadth or its length (Liu et al. 2018,
        eq. 57: I/V = b^3 l / (12 b l T)).
        """
        assert self.size is not None
        draught, above = self.draught(density), self.above_keel(density)
        length, breadth, _ = self.size
        roll, pitch = (0.5 * draught + b**2 / (12.0 * draught) - above for b in (breadth, length))
        return roll, pitch

    def righting(self, density: float, gravity: float) -> dict[str, tuple[float, float]]:
        """Return how a hull rights itself in each way that it is free to, roll and pitch.

        By way its metacentric height (m), and the moment per angle with what holds it at its attitude
        (N m/rad).
        """
        if self.hull is None or self.size is None:
            return {}
        held = None if self.control is None else self.control.turn_stiffness
        ways = zip(ANGLES, self.metacentres(density), held or (0.0, 0.0), strict=False)
        return {
            angle: (height, self.mass * gravity * height + holds)
            for angle, height, holds in ways
            if self.free is None or angle in self.free
        }

    def problems(self) -> Iterator[Problem]:
        """Yield what a rigid body lacks, and what is said twice."""
        if not self.rigid:
            return
        for k, angle in enumerate(self.attitude or ()):
            yield from turn_problems(("attitude", k), angle)
        if self.position is None:
            yield Problem(
                ("position",),
                "expected the place [x, y, z] (m) of a rigid body, found nothing",
            )
        if self.turns and self.inertia is None and self.size is None:
            yield Problem(
                ("inertia",),
                "expected inertia or size of a body that can turn (free says how it can move), "
                "found neither",
            )
        if self.hull is not None and self.size is None:
            yield Problem(
                ("size",), "expected [length, breadth, height] (m) of a hull, found nothing"
            )
        if self.hull is not None and None not in (self.hull.above_keel, self.hull.above_water):
            yield Problem(("hull", "above_water"), "expected above_keel or above_water, found both")
        if self.drag is not None and self.size is None:
            yield Problem(
                ("size",),
                "expected [length, breadth, height] (m) of a body with drag, found nothing",
            )
        if self.added_mass is not None and self.volume is None:
            yield Problem(
                ("volume",), "expected the volume (m3) of a body with added_mass, found nothing"
            )
        rises = self.free is None or "z" in self.free
        if self.friction is not None and self.bearing is None and rises:
            yield Problem(
                ("friction",),
                'expected a body with bearing, or one on the bed whose free has no "z", found one that '
                "can rise and that no bed bears",
            )
        if self.bearing is not None and not rises:
            yield Problem(
                ("bearing",), 'expected a body that can rise, found one whose free has no "z"'
            )
        if self.hull is not None and self.volume is not None:
            yield Problem(("volume",), "expected volume or hull, found both")
        for axis, speed in enumerate(self.velocity or ()):
            if speed != 0.0 and self.free is not None and SHIFTS[axis] not in self.free:
                yield Problem(
                    ("velocity", axis),
                    "expected no velocity along a way that the body cannot move in, found "
                    f'{format_quantity(speed, "m/s")}, without "{SHIFTS[axis]}" in free',
                )
        yield from self._in_vain()
        if isinstance(self.waves, HarmonicWaves):
            for name in self.waves.names():
                if self.free is not None and WAYS[name] not in self.free:
                    yield Problem(
                        ("waves", name),
                        f"expected a way that the body can move in, found {name}, without "
                        f'"{WAYS[name]}" in free',
                    )
        if isinstance(self.waves, PressureWaves) and self.hull is None:
            yield Problem(
                ("waves", "law"), "expected a hull, on whose wetted box waves press, found none"
            )
        for name in self.points:
            if name in ("start", "end"):
                yield Problem(
                    ("points", name), f'expected another name, found "{name}", an end of a line'
                )
        for k, way in enumerate(self.free or ()):
            if self.free is not None and way in self.free[:k]:
                yield Problem(("free",), f'expected each way to move once, found "{way}" again')
                return

    def _in_vain(self) -> Iterator[Problem]:
        """Yield what steers the body along or about what it is not free to move."""
        if self.control is None or self.free is None:
            return
        ways = {
            "stiffness": SHIFTS,
            "damping": SHIFTS,
            "turn_stiffness": ANGLES,
            "turn_damping": ANGLES,
        }
        if not self.turns and self.attitude is None:
            ways["force"] = SHIFTS  # its own axes are the scene's
        for key, names in ways.items():
            for k, value in enumerate(getattr(self.control, key) or ()):
                if value != 0.0 and names[k] not in self.free:
                    yield Problem(
                        ("control", key, k),
                        f"expected 0 along a way that the body cannot move in, found {value:g}, "
                        f'without "{names[k]}" in free',
                    )
        if any(self.control.moment or ()) and not self.turns:
            yield Problem(
                ("control", "moment"),
                "expected a body that can turn, found one without roll, pitch and yaw in free",
            )
