"""What an input file of MoorDyn holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import asin, atan2, cos, pi, sin, sqrt

__all__ = [
    "Failure",
    "LineType",
    "Mooring",
    "MooringBody",
    "MooringLine",
    "Place",
    "Point",
    "RodType",
    "triple",
]

Place = tuple[float, float, float]


def triple(values: Sequence[float]) -> Place:
    """The first three of some numbers, 0 where there are fewer."""
    x, y, z = (*values, 0.0, 0.0, 0.0)[:3]
    return x, y, z


@dataclass(frozen=True)
class LineType:
    """A row of the line types: diameter (m), mass (kg/m), EA (N), damping and coefficients (-).

    `BA` is in N s, or where negative the share of critical damping with its sign turned; EI in N m2.
    Of a viscoelastic type these EA and BA are of its static part, `EA_d` (N) and `BA_d` (N s) of its
    dynamic one; `EA_d` is 0 of others.
    """

    name: str
    diameter: float
    mass: float
    EA: float
    BA: float
    EI: float
    Cd: float
    Ca: float
    CdAx: float
    CaAx: float
    EA_d: float = 0.0
    BA_d: float = 0.0


@dataclass(frozen=True)
class RodType:
    """A row of the rod types: diameter (m), mass (kg/m), Ca across it (-)."""

    diameter: float
    mass: float
    Ca: float

    def inertia(self, along: Place) -> tuple[float, float, Place, Place]:
        """Mass (kg), volume (m3), inertia (kg m2) and Ca (-) of a rod that reaches `along` (m).

        A cylinder's, about its middle: m r^2 / 2 along itself, m (r^2 / 4 + L^2 / 12) across.
        """
        square = sum(x * x for x in along)
        length, radius = sqrt(square), 0.5 * self.diameter
        mass, across = self.mass * length, [1.0 - x * x / square for x in along]
        least, most = 0.5 * mass * radius**2, mass * (0.25 * radius**2 + square / 12.0)
        inertia = triple([least * (1.0 - share) + most * share for share in across])
        return mass, pi * radius**2 * length, inertia, triple([self.Ca * s for s in across])


@dataclass(frozen=True)
class MooringBody:
    """A body: "fixed", "coupled" or "free", where its origin is (m), and how it is turned (rad).

    It is turned about its own x, then its own y, then its own z, as MoorDyn has it. `centre` (m) is its
    centre of gravity in its own axes, `inertia` (kg m2) is about that, `Ca` along these axes; `drags`
    says whether it has CdA.
    """

    kind: str
    place: Place
    turned: Place
    mass: float
    centre: Place
    inertia: Place
    volume: float
    drags: bool
    Ca: Place

    def along(self, own: Place) -> Place:
        """A vector of its own axes along x, y and z: Rx Ry Rz times it."""
        x, y, z = own
        roll, pitch, yaw = self.turned
        x, y = x * cos(yaw) - y * sin(yaw), x * sin(yaw) + y * cos(yaw)
        z, x = z * cos(pitch) - x * sin(pitch), z * sin(pitch) + x * cos(pitch)
        y, z = y * cos(roll) - z * sin(roll), y * sin(roll) + z * cos(roll)
        return x, y, z

    def with_part(
        self, mass: float, volume: float, middle: Place, inertia: Place, Ca: Place
    ) -> MooringBody:
        """The body and something on it as one: `middle` (m) and `inertia` (kg m2) are the part's own.

        Moments of inertia are about the common centre of gravity (Steiner); their products are left out.
        Added mass is Ca V along each axis, of both together.
        """
        whole, displaced = self.mass + mass, self.volume + volume
        if whole <= 0.0:
            return self
        pairs = list(zip(self.centre, middle, strict=True))
        centre = [(self.mass * a + mass * b) / whole for a, b in pairs]
        shared = self.mass * mass / whole
        square = [shared * (a - b) ** 2 for a, b in pairs]
        turned = [
            a + b + sum(square) - own
            for a, b, own in zip(self.inertia, inertia, square, strict=True)
        ]
        added = [
            (self.volume * a + volume * b) / displaced if displaced else 0.0
            for a, b in zip(self.Ca, Ca, strict=True)
        ]
        return replace(
            self, mass=whole, volume=displaced, centre=triple(centre), inertia=triple(turned),
            Ca=triple(added),
        )  # fmt: skip

    @property
    def attitude(self) -> Place:
        """Roll, pitch and yaw (rad) of a scene, which turn about x, y and z at rest: Rz Ry Rx."""
        columns = [self.along(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        (a, b, c), (*_, d), (*_, e) = columns
        return atan2(d, e), -asin(max(-1.0, min(1.0, c))), atan2(b, a)


@dataclass(frozen=True)
class Point:
    """A point: "fixed", "coupled", "free" or on a "body", mass (kg), volume (m3), CdA (m2) and Ca.

    Its place (m) is one in space, or of a point on a body in the axes of that. The end of a rod has the
    `axis` of that, from its end A to its end B (m).
    """

    kind: str
    place: Place
    mass: float
    volume: float
    CdA: float
    Ca: float
    body: str = ""
    axis: tuple[Place, Place] | None = None


@dataclass(frozen=True)
class MooringLine:
    """A line of so many segments from point `start` to point `end`, `length` (m) unstretched."""

    kind: str
    start: str
    end: str
    length: float
    segments: int


@dataclass(frozen=True)
class Failure:
    """A point lets some of its lines go, at a time (s) or a tension (N); 0 stands for neither."""

    point: str
    lines: tuple[str, ...]
    time: float
    tension: float


@dataclass
class Mooring:
    """What an input file holds, in `left` what of it is not taken over, and remarks, in words."""

    types: dict[str, LineType] = field(default_factory=dict)
    bodies: dict[str, MooringBody] = field(default_factory=dict)
    points: dict[str, Point] = field(default_factory=dict)
    lines: dict[str, MooringLine] = field(default_factory=dict)
    failures: dict[str, Failure] = field(default_factory=dict)
    options: dict[str, float] = field(default_factory=dict)
    left: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def place(self, name: str) -> Place:
        """Where a point is in space (m)."""
        return self._in_space(self.points[name], self.points[name].place)

    def direction(self, name: str, own: bool = False) -> Place | None:
        """Of the end of a rod, the direction from its end A to its end B (m), not of length 1.

        In space, or in the `own` axes of the body that it is on.
        """
        point = self.points[name]
        if point.axis is None:
            return None
        ends = point.axis if own else [self._in_space(point, place) for place in point.axis]
        (x, y, z), (a, b, c) = ends
        return a - x, b - y, c - z

    def _in_space(self, point: Point, place: Place) -> Place:
        if point.kind != "body":
            return place
        body = self.bodies[point.body]
        x, y, z = body.along(place)
        return body.place[0] + x, body.place[1] + y, body.place[2] + z

    def option(self, default: float, *names: str) -> float:
        """The value of an option by any of its names."""
        return next((self.options[name] for name in names if name in self.options), default)
