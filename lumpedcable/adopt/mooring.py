"""A mooring as the text of a scene, with remarks on what has no counterpart in it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import ceil, sqrt

from lumpedcable.adopt.parts import Mooring, MooringLine, Place
from lumpedcable.adopt.viscoelastic import parallel
from lumpedcable.scene.writer import value_text

__all__ = ["mooring_scene"]

GRAVITY, DENSITY, STIFFNESS, DAMPING = 9.81, 1025.0, 3e6, 3e5  # MoorDyn's, where a file has none
ITERATIONS = 4000
AFTER = 60.0  # s that a run goes on after the last failure whose time is told
NOTHING = 1e-3  # kg, of a point without mass that three lines or more meet at


def mooring_scene(mooring: Mooring, title: str) -> tuple[str, list[str]]:
    """Return the TOML text of the scene at rest, and remarks on what it leaves out or puts otherwise.

    Internal damping that is given as a share z of critical becomes z l sqrt(EA m) for segments of
    length l (m), with the EA of loads that stay. A bed that resists by k (Pa/m) on the width d (m) of a
    line resists by k d per metre.
    """
    writer = _Writer(mooring)
    parts = [
        *writer.bed(),
        *writer.materials(),
        *writer.driven(),
        *writer.bodies(),
        *writer.lines(),
    ]
    parts += writer.breaks()
    remarks = [f"not taken over: {left}" for left in mooring.left]
    remarks += [*mooring.remarks, *writer.remarks]
    loose = [x for x in (*mooring.points.values(), *mooring.bodies.values()) if x.kind == "free"]
    density = mooring.option(DENSITY, "rho", "rhow", "wtrdnsty", "wtrdens")
    # what stays under water need not ask how much of it is
    leaves = any(mooring.place(name)[2] > 0.0 for name in mooring.points)
    leaves = leaves or any(density * x.volume > x.mass for x in loose)
    blocks = [
        "\n".join(f"# {_printable(remark)}" for remark in remarks),
        f"title = {value_text(title)}\ngravity = {value_text(mooring.option(GRAVITY, 'g', 'gravity'))}",
        _table("water", density=density, surface=0.0 if leaves else None),
        *parts,
        # what floats between lines that hardly stretch is slow to be found
        _table("statics", max_iterations=ITERATIONS) if loose else "",
        writer.output(),
    ]
    return "\n\n".join(filter(None, blocks)) + "\n", remarks


class _Writer:
    def __init__(self, mooring: Mooring):
        self.mooring, self.remarks = mooring, list[str]()
        # damping (N s) of every line, and the material with it
        self.damping = {name: _damping(mooring, line) for name, line in mooring.lines.items()}
        self.made = _materials(mooring, self.damping)
        # the ends of lines at each point, in the order of the file
        self.ends: dict[str, list[tuple[str, str]]] = {point: [] for point in mooring.points}
        for name, line in mooring.lines.items():
            self.ends[line.start].append((name, "start"))
            self.ends[line.end].append((name, "end"))
        self.joined = self._joined()
        # the last time (s) at which something fails, if anything does
        self.until: float | None = None
        for name, point in mooring.points.items():
            weighs = point.mass or point.volume
            if weighs and point.kind == "free" and not self.ends[name]:
                self.remarks.append(f"not taken over: point {name}, which no line holds")
            if point.kind == "free" and (point.CdA or (point.Ca and point.volume)):
                self.remarks.append(
                    f"not taken over: CdA and Ca of point {name}; a rigid body has drag and added mass"
                )

    def bed(self) -> Iterator[str]:
        """The bed, as stiff as the line type that most metres are of asks for."""
        depth = abs(self.mooring.option(0.0, "wtrdpth"))  # as MoorDyn has it
        if depth == 0.0:
            self.remarks.append("there is no bed, since the file has no WtrDpth above 0")
            return
        metres: dict[float, float] = {}
        for line in self.mooring.lines.values():
            width = self.mooring.types[line.kind].diameter
            metres[width] = metres.get(width, 0.0) + line.length
        width = max(metres, key=lambda d: metres[d])
        if len(metres) > 1:
            self.remarks.append(
                f"the bed is as stiff as under a line of {width:g} m diameter, also under others"
            )
        bed = {"height": -depth}
        bed["stiffness"] = width * self.mooring.option(STIFFNESS, "kbot", "kb")
        damping = width * self.mooring.option(DAMPING, "cbot", "cb")
        friction = self.mooring.option(0.0, "frictioncoefficient")
        yield _table("seabed", **bed, damping=damping or None, friction=friction or None)

    def materials(self) -> Iterator[str]:
        for (kind, damping), name in self.made.items():
            rope, branches = self.mooring.types[kind], None
            if rope.EA_d:
                damping, EA, time = parallel(rope.EA, rope.EA_d, damping, rope.BA_d)
                branches = {"fast": {"EA": EA, "time": time}} if EA else None
            # a cable of MoorDyn does not push either
            keys = {
                "law": "linear",
                "EA": rope.EA,
                "tension_only": True,
                "damping": damping or None,
                "relaxation": branches,
            }
            yield _table(f"materials.{name}", **keys)

    def driven(self) -> Iterator[str]:
        """What MoorDyn is told the motion of: a vessel with the coupled points, and coupled bodies."""
        places = {
            f"point{name}": point.place
            for name, point in self.mooring.points.items()
            if point.kind == "coupled" and self.ends[name]
        }
        if places:
            yield _moved("vessel", (0.0, 0.0, 0.0), places)
        for name, body in self.mooring.bodies.items():
            if body.kind == "coupled" and (held := self._on(name)):
                places = {f"point{p}": body.along(self.mooring.points[p].place) for p in held}
                yield _moved(f"body{name}", body.place, places)

    def bodies(self) -> Iterator[str]:
        """Free bodies, and free points that something weighs or that more than two lines meet at."""
        points = self.mooring.points
        for name, body in self.mooring.bodies.items():
            held = self._on(name)
            if body.kind != "free":
                continue
            if not held:
                self.remarks.append(f"not taken over: body {name}, which no line holds")
                continue
            if body.drags:
                self.remarks.append(
                    f"not taken over: CdA of body {name}; give it a size, and drag on its faces"
                )
            middle = zip(body.place, body.along(body.centre), strict=True)
            keys = {
                "mass": body.mass, "inertia": list(body.inertia), "volume": body.volume or None,
                "position": [place + off for place, off in middle],
                "attitude": list(body.attitude) if any(body.turned) else None,
                "added_mass": list(body.Ca) if body.volume and any(body.Ca) else None,
                "points": {
                    f"point{p}": [x - c for x, c in zip(points[p].place, body.centre, strict=True)]
                    for p in held
                },
                "settle": True,
            }  # fmt: skip
            yield _table(f"bodies.body{name}", **keys)
        for name, point in self.mooring.points.items():
            if point.kind != "free" or name in self.joined or not self._meets(name):
                continue
            mass = point.mass or NOTHING
            if not point.mass:
                self.remarks.append(f"point {name} has a mass of 1 g, since bodies have one")
            volume = point.volume or None
            yield _table(
                f"bodies.point{name}", mass=mass, position=list(point.place), volume=volume
            )

    def breaks(self) -> Iterator[str]:
        """Failures, each of one line, and at once as MoorDyn has them."""
        gone = set[str]()
        for name, failure in self.mooring.failures.items():
            if len(failure.lines) != 1:
                self.remarks.append(
                    f"not taken over: failure {name}, after which lines stay tied to each other"
                )
                continue
            (line,) = failure.lines
            # of two lines that hold each other one lets go of both
            place = failure.point if failure.point in self.joined else f"{failure.point} {line}"
            if place in gone:
                self.remarks.append(f"not taken over: failure {name}, after another one there")
                continue
            gone.add(place)
            side = "start" if self.mooring.lines[line].start == failure.point else "end"
            if failure.time and failure.tension:
                self.remarks.append(
                    f"failure {name} begins at its tension alone, not at {failure.time:g} s"
                )
            when = {"tension": failure.tension} if failure.tension else {"start": failure.time}
            yield _table(f"events.failure{name}", breaks=f"line{line}.{side}", time=0.0, **when)
            self.until = max(self.until or 0.0, failure.time)

    def output(self) -> str:
        """A scene at rest, or one that moves for as long as what fails takes, and a minute."""
        if self.until is None:
            return (
                "[output]  # at rest; with a duration it moves, such as duration = "
                '"60 s" with every = "0.1 s"'
            )
        return _table("output", duration=ceil(self.until) + AFTER, every=0.1)

    def lines(self) -> Iterator[str]:
        for name, line in self.mooring.lines.items():
            kind = self.mooring.types[line.kind]
            keys = {
                "material": self.made[line.kind, self.damping[name]],
                "length": line.length, "segments": line.segments, "mass": kind.mass,
                "diameter": kind.diameter or None,
                "drag": _pair(kind.Cd, kind.CdAx), "added_mass": _pair(kind.Ca, kind.CaAx),
                "bending": {"EI": kind.EI} if kind.EI else None,
            }  # fmt: skip
            text = _table(f"lines.line{name}", **keys)
            for side, point in (("start", line.start), ("end", line.end)):
                text += f"\n{side} = {self._end(name, side, point)}"
            yield text

    def _end(self, line: str, side: str, name: str) -> str:
        point = self.mooring.points[name]
        body = self.mooring.bodies.get(point.body)
        if "fixed" in (point.kind, body and body.kind):
            place = value_text(list(self.mooring.place(name)))
            clamp = self._clamp(line, side, name)
            return f"{{ fixed = {place}{clamp} }}"
        if point.kind != "free":
            tied = value_text(f"{f'body{point.body}' if body else 'vessel'}.point{name}")
            # what is moved has the axes of space, what is free its own
            clamp = self._clamp(line, side, name, own=body is not None and body.kind == "free")
            return f"{{ tied = {tied}{clamp} }}" if clamp else tied
        if name not in self.joined:
            return value_text(f"point{name}" if self._meets(name) else "free")
        first, second = self.joined[name]
        other, at = second if (line, side) == first else first
        return value_text(f"line{other}.{at}")

    def _clamp(self, line: str, side: str, name: str, own: bool = False) -> str:
        """The direction that a rod gives a line that bends: away from its end B, towards its end A.

        In space, or in the `own` axes of its body.
        """
        axis = self.mooring.direction(name, own)
        if axis is None or not self.mooring.types[self.mooring.lines[line].kind].EI:
            return ""
        sign = 1.0 if (side == "start") == name.endswith("B") else -1.0
        return f", direction = {value_text([sign * x for x in axis])}"

    def _on(self, body: str) -> list[str]:
        """The points of a body that hold lines."""
        points = self.mooring.points.items()
        return [name for name, point in points if point.body == body and self.ends[name]]

    def _meets(self, name: str) -> bool:
        """Whether lines meet at a point, or something has its mass there."""
        point, ends = self.mooring.points[name], len(self.ends[name])
        return ends > 1 or (ends == 1 and bool(point.mass or point.volume))

    def _joined(self) -> dict[str, tuple[tuple[str, str], tuple[str, str]]]:
        """Free points without mass or volume at which two lines meet: the two ends."""
        found = {}
        for name, point in self.mooring.points.items():
            ends = self.ends[name]
            if point.kind == "free" and not point.mass and not point.volume and len(ends) == 2:
                found[name] = (ends[0], ends[1])
        return found


def _damping(mooring: Mooring, line: MooringLine) -> float:
    kind = mooring.types[line.kind]
    if kind.BA >= 0.0:
        return kind.BA
    return -kind.BA * line.length / line.segments * sqrt(kind.EA * kind.mass)


def _materials(mooring: Mooring, damping: dict[str, float]) -> dict[tuple[str, float], str]:
    """Names of materials by line type and damping (N s); one type has several where that differs."""
    found: dict[tuple[str, float], str] = {}
    for name, line in mooring.lines.items():
        key = (line.kind, damping[name])
        if key in found:
            continue
        bare = re.sub(r"^(?![A-Za-z])", "m", re.sub(r"[^A-Za-z0-9_-]", "_", line.kind))
        taken, count = set(found.values()), 1
        text = bare
        while text in taken:
            count += 1
            text = f"{bare}_{count}"
        found[key] = text
    return found


def _printable(text: str) -> str:
    """A remark as a comment can hold it."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)


def _moved(name: str, position: Place, points: dict[str, Place]) -> str:
    """A body that is moved, which rests until its motion is told."""
    rest = {"surge": {"amplitude": 0.0, "period": 10.0}}
    points_ = {key: list(place) for key, place in points.items()}
    text = _table(f"bodies.{name}", position=list(position), motion=rest, points=points_)
    return text.replace("\npoints", "  # at rest: give its motion here\npoints", 1)


def _pair(normal: float, tangential: float) -> dict[str, float] | None:
    return {"normal": normal, "tangential": tangential} if normal or tangential else None


def _table(name: str, **keys) -> str:
    lines = [f"{key} = {value_text(value)}" for key, value in keys.items() if value is not None]
    return "\n".join([f"[{name}]", *lines])
