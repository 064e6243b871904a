"""A mooring as the text of a scene, with remarks on what has no counterpart in it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import sqrt

from lumpedcable.adopt.moordyn import Mooring, MooringLine
from lumpedcable.scene.writer import value_text

__all__ = ["mooring_scene"]

GRAVITY, DENSITY, STIFFNESS, DAMPING = 9.81, 1025.0, 3e6, 3e5  # MoorDyn's, where a file has none
ITERATIONS = 4000
NOTHING = 1e-3  # kg, of a point without mass that three lines or more meet at


def mooring_scene(mooring: Mooring, title: str) -> tuple[str, list[str]]:
    """Return the TOML text of the scene at rest, and remarks on what it leaves out or puts otherwise.

    Internal damping that is given as a share z of critical becomes z l sqrt(EA m) for segments of
    length l (m). A bed that resists by k (Pa/m) on the width d (m) of a line resists by k d per metre.
    """
    writer = _Writer(mooring)
    parts = [*writer.bed(), *writer.materials(), *writer.bodies(), *writer.lines()]
    remarks = [f"not taken over: {left}" for left in mooring.left]
    remarks += [*mooring.remarks, *writer.remarks]
    free = any(point.kind == "free" for point in mooring.points.values())
    density = mooring.option(DENSITY, "rho", "rhow", "wtrdnsty", "wtrdens")
    # what stays under water need not ask how much of it is
    leaves = any(
        point.place[2] > 0.0 or (point.kind == "free" and density * point.volume > point.mass)
        for point in mooring.points.values()
    )
    blocks = [
        "\n".join(f"# {_printable(remark)}" for remark in remarks),
        f"title = {value_text(title)}\ngravity = {value_text(mooring.option(GRAVITY, 'g', 'gravity'))}",
        _table("water", density=density, surface=0.0 if leaves else None),
        *parts,
        # what floats between lines that hardly stretch is slow to be found
        _table("statics", max_iterations=ITERATIONS) if free else "",
        '[output]  # at rest; with a duration it moves, such as duration = "60 s" with every = "0.1 s"',
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
        for name, point in mooring.points.items():
            weighs = point.kind == "free" and (point.mass or point.volume)
            if weighs and not self.ends[name]:
                self.remarks.append(f"not taken over: point {name}, which no line holds")
            if point.kind == "free" and (point.CdA or (point.Ca and point.volume)):
                self.remarks.append(
                    f"not taken over: CdA and Ca of point {name}; a rigid body has drag and added mass"
                )

    def bed(self) -> Iterator[str]:
        """The bed, as stiff as the line type that most metres are of asks for."""
        depth = self.mooring.option(0.0, "wtrdpth")
        if depth <= 0.0:
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
            EA = self.mooring.types[kind].EA
            # a cable of MoorDyn does not push either
            keys = {"law": "linear", "EA": EA, "tension_only": True, "damping": damping or None}
            yield _table(f"materials.{name}", **keys)

    def bodies(self) -> Iterator[str]:
        """Points that are free and that something weighs, or that more than two lines meet at."""
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
        if point.kind == "fixed":
            return f"{{ fixed = {value_text(list(point.place))} }}"
        if point.kind == "coupled":
            place = value_text(list(point.place))
            return f"{{ fixed = {place} }}  # point {name} goes with a vessel: give it a motion"
        if name not in self.joined:
            return value_text(f"point{name}" if self._meets(name) else "free")
        first, second = self.joined[name]
        other, at = second if (line, side) == first else first
        return value_text(f"line{other}.{at}")

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


def _pair(normal: float, tangential: float) -> dict[str, float] | None:
    return {"normal": normal, "tangential": tangential} if normal or tangential else None


def _table(name: str, **keys) -> str:
    lines = [f"{key} = {value_text(value)}" for key, value in keys.items() if value is not None]
    return "\n".join([f"[{name}]", *lines])
