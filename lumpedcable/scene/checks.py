"""What must hold between the parts of a scene.

The parts check themselves (``Part.problems``); here is what needs two of them. The checks work on a
``Draft``, in which a part that could not be read is None: what refers to it is then left alone,
so that one mistake is told once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody
from lumpedcable.scene.carried_checks import carried_problems
from lumpedcable.scene.effect_checks import effect_problems
from lumpedcable.scene.ends import HeldForce, JoinedEnd, TiedEnd, clamp_of, held_force
from lumpedcable.scene.environment import Fluid, Seabed
from lumpedcable.scene.event_checks import event_problems
from lumpedcable.scene.events import Event
from lumpedcable.scene.joints import rigid_joint_problems
from lumpedcable.scene.lines import Line
from lumpedcable.scene.materials import Material
from lumpedcable.scene.measure_checks import measure_problems
from lumpedcable.scene.motions import PressureWaves, SeaBody, SeaWaves
from lumpedcable.scene.moved import MovedBody
from lumpedcable.scene.outcomes import STATISTICS
from lumpedcable.scene.part import (
    SIDES,
    Part,
    Path,
    Problem,
    children,
    did_you_mean,
    dotted,
    unknown,
)
from lumpedcable.scene.placing_checks import (
    bearing_problems,
    below_problems,
    joined_problems,
    lying_problems,
    settling_problems,
)
from lumpedcable.scene.quantities import found
from lumpedcable.scene.reach import reach_problems
from lumpedcable.scene.record_checks import record_problems
from lumpedcable.scene.rod_checks import hull_problems, rod_problems
from lumpedcable.scene.run import Output
from lumpedcable.scene.scene import Scene
from lumpedcable.scene.stepping_checks import stepping_problems
from lumpedcable.scene.surfaces import depth_problems, leaving_problems, surface_problems
from lumpedcable.scene.targets import Target, target_problems
from lumpedcable.scene.units import format_quantity


@dataclass(frozen=True)
class Draft:
    """A scene as far as it could be read; None stands for an entry that could not."""

    materials: Mapping[str, Material | None]
    lines: Mapping[str, Line | None]
    bodies: Mapping[str, Body | CarriedBody | MovedBody | None]
    measures: Mapping[str, Any]
    events: Mapping[str, Event | None]
    targets: Mapping[str, Target | None]
    others: Mapping[str, Any]
    """The single parts that could be read, by key: gravity, water, solver, ..."""
    named: frozenset[str]
    """The single parts that the scene names, readable or not."""
    sound: frozenset[int] = frozenset()
    """Parts, by id, that are known to have nothing to say about themselves."""

    @classmethod
    def of(cls, scene: Scene, sound: frozenset[int] = frozenset()) -> Draft:
        """Return the draft of a scene that could be read as a whole."""
        singles = {key: value for key, value in children(scene) if not isinstance(value, dict)}
        return cls(
            scene.materials,
            scene.lines,
            scene.bodies,
            scene.measures,
            scene.events,
            scene.targets,
            {str(key): value for key, value in singles.items()},
            frozenset(map(str, singles)),
            sound,
        )

    @property
    def fluid(self) -> str | None:
        """The key of the fluid, "water" or "air", or None."""
        return next((key for key in ("water", "air") if key in self.named), None)


def problems(draft: Draft) -> Iterator[Problem]:
    """Yield everything that is wrong in a draft."""
    for section in ("materials", "lines", "bodies", "measures", "events", "targets"):
        yield from inside(getattr(draft, section), (section,), draft.sound)
    for key, part in draft.others.items():
        yield from inside(part, (key,), draft.sound)
    if "water" in draft.named and "air" in draft.named:
        yield Problem(("air",), "expected water or air, found both")
    if not draft.lines:
        yield Problem(("lines",), "expected at least one line, [lines.NAME], found none")
    for name in draft.bodies:
        if name == "free":
            yield Problem(("bodies", name), 'expected another name, found "free", which is no body')
    for name, body in draft.bodies.items():
        if isinstance(body, MovedBody):
            yield from _moved(draft, ("bodies", name, "motion"), body)
        elif isinstance(body, Body) and body.volume is not None and draft.fluid is None:
            yield Problem(
                ("bodies", name, "volume"),
                "expected [water] or [air] where a body has a volume, found neither",
            )
        if isinstance(body, Body) and body.drag is not None and draft.fluid is None:
            yield Problem(
                ("bodies", name, "drag"), "expected [water] or [air] for drag, found neither"
            )
        if isinstance(body, Body) and body.bearing is not None and "seabed" not in draft.named:
            yield Problem(
                ("bodies", name, "bearing"),
                "expected [seabed] where a bed bears a body, found none",
            )
        if isinstance(body, Body) and body.hull is not None:
            for key in ("water", "gravity"):
                if key not in draft.named:
                    yield Problem(
                        ("bodies", name, "hull"), f"expected {key} where a hull floats, found none"
                    )
        if isinstance(body, Body) and "sea" not in draft.named:
            key = {SeaWaves: "rao", PressureWaves: "law"}.get(type(body.waves))
            if key is not None:
                yield Problem(
                    ("bodies", name, "waves", key), "expected [sea] for forces of waves, found none"
                )
        if isinstance(body, Body) and body.rigid and name in draft.lines:
            yield Problem(
                ("bodies", name), f'expected another name, found "{name}", which is a line as well'
            )
    for name, line in draft.lines.items():
        if line is not None:
            yield from _line(draft, name, line)
    gravity = draft.others.get("gravity")
    output = draft.others.get("output")
    duration = output.duration if output else None
    yield from effect_problems(draft.lines, draft.bodies, draft.measures, draft.others, draft.named)
    yield from carried_problems(draft.lines, draft.bodies, draft.events, gravity, duration)
    yield from measure_problems(draft.lines, draft.bodies, draft.measures, draft.named, duration)
    yield from stepping_problems(
        draft.lines, draft.bodies, draft.materials, draft.events, draft.others
    )
    fluid = draft.others.get(draft.fluid) if draft.fluid is not None else None
    sea = draft.others.get("sea")
    yield from hull_problems(draft.bodies, draft.others.get("water"), sea.depth if sea else None)
    yield from surface_problems(draft.bodies, draft.others.get("water"), sea)
    yield from leaving_problems(
        draft.lines, draft.bodies, draft.materials, draft.others, draft.named
    )
    yield from rod_problems(draft.lines, draft.bodies, draft.materials, fluid)
    yield from record_problems(draft.lines, draft.bodies, duration)
    yield from joined_problems(draft.lines)
    yield from rigid_joint_problems(draft.lines)
    yield from settling_problems(draft.bodies, draft.lines, draft.materials)
    seabed = draft.others.get("seabed")
    if isinstance(seabed, Seabed) and next(inside(seabed, (), draft.sound), None) is None:
        yield from below_problems(draft.lines, draft.bodies, seabed)
        yield from lying_problems(draft.bodies, seabed)
        yield from bearing_problems(draft.bodies, seabed, gravity)
        yield from depth_problems(draft.bodies, draft.others.get("water"), sea, seabed)
    yield from event_problems(draft.events, draft.lines, draft.others)
    yield from target_problems(draft.targets, draft.lines, draft.bodies, draft.events)
    yield from reach_problems(
        draft.targets, draft.lines, draft.bodies, draft.materials, draft.others
    )
    yield from _at_rest(draft)


def inside(value: Any, path: Path, sound: frozenset[int] = frozenset()) -> Iterator[Problem]:
    """Yield what the parts at and below a value say about themselves, but for `sound` ones (by id)."""
    if id(value) in sound:
        return
    if isinstance(value, Part):
        for problem in value.problems():
            yield Problem((*path, *problem.path), problem.message)
    for key, child in children(value):
        if isinstance(child, Part | dict):
            yield from inside(child, (*path, key), sound)


def parts_of(value: Any) -> Iterator[Any]:
    """Yield a value that has something below it, and all such values below it."""
    if isinstance(value, Part | dict):
        yield value
        for _, child in children(value):
            yield from parts_of(child)


def _at_rest(draft: Draft) -> Iterator[Problem]:
    """Yield what a scene without duration cannot have, and what needs one."""
    output = draft.others.get("output")
    if not isinstance(output, Output):
        return
    if output.statistics:
        yield from _statistics(draft, output)
    if output.static and draft.events:
        yield Problem(("output",), "expected a duration where there are events, found none")


def _statistics(draft: Draft, output: Output) -> Iterator[Problem]:
    """Yield what means and deviations of measures have nothing to be taken over."""
    path: Path = ("output", "statistics")
    if not draft.measures:
        yield Problem(path, "expected measures where there are statistics of them, found none")
    if output.static:
        yield Problem(path, "expected a duration where there are statistics, found none")
    if output.stop is not None:
        yield Problem(
            path, f'expected no stop where there are statistics of all times, found "{output.stop}"'
        )
    for name in draft.measures:
        for word in STATISTICS:
            if f"{name}_{word}" in draft.measures:
                yield Problem(
                    ("measures", f"{name}_{word}"),
                    f'expected another name, found "{name}_{word}", which is the {word} of "{name}"',
                )


def _line(draft: Draft, name: str, line: Line) -> Iterator[Problem]:
    path: Path = ("lines", name)
    if line.material not in draft.materials:
        yield Problem(
            (*path, "material"),
            f"expected the name of a material, found {unknown(line.material, draft.materials)}",
        )
    yield from _water(draft, path, line)
    for side in SIDES:
        end = getattr(line, side)
        if isinstance(end, str):
            yield from _named_end(draft, (*path, side), end)
        elif isinstance(end, JoinedEnd):
            yield from _joined_end(draft, (*path, side, "joined"), end.joined)
        elif isinstance(end, TiedEnd):
            yield from _tied_end(draft, (*path, side, "tied"), end.tied)
        elif (held := held_force(end)) is not None:
            yield from _pretension(draft, (*path, side, "held", "pretension"), line, held)
        if clamp_of(end) is not None and line.bending is None:
            yield Problem(
                (*path, side, "direction"),
                "expected bending on a line whose end keeps a direction, found none",
            )


def _moved(draft: Draft, path: Path, body: MovedBody) -> Iterator[Problem]:
    if isinstance(body.motion, SeaBody) and "sea" not in draft.named:
        yield Problem((*path, "rao"), "expected [sea] for a motion in waves, found none")


def _points(draft: Draft) -> list[str]:
    """Return the points of all bodies, as an end names them."""
    bodies = ((name, getattr(body, "points", {})) for name, body in draft.bodies.items())
    return [f"{name}.{point}" for name, points in bodies for point in points]


def _water(draft: Draft, path: Path, line: Line) -> Iterator[Problem]:
    """Yield what the fluid's effects on a line lack: a fluid, a diameter."""
    effects = [key for key in ("drag", "added_mass") if getattr(line, key) is not None]
    if draft.fluid is None:
        for key in effects:
            yield Problem((*path, key), f"expected [water] or [air] for {key}, found neither")
        return
    if "gravity" in draft.named:
        effects.append(f"buoyancy in {draft.fluid}")
    if effects and line.diameter is None:
        yield Problem(
            (*path, "diameter"),
            f"expected a positive length (m) for {' and '.join(effects)}, found nothing",
        )
    fluid = draft.others.get(draft.fluid)
    if (
        effects
        and isinstance(fluid, Fluid)
        and line.diameter is not None
        and not fluid.density * line.diameter * line.diameter < inf
    ):
        yield Problem(
            (*path, "diameter"),
            f"expected a diameter with which a line displaces a finite mass of {draft.fluid}, "
            f"found {format_quantity(line.diameter, 'm')}",
        )


def _joined_end(draft: Draft, path: Path, end: str) -> Iterator[Problem]:
    """Yield what is wrong with the other line's end that an end is joined to."""
    others = [f"{line}.{side}" for line in draft.lines if line != path[1] for side in SIDES]
    if end not in others:
        yield Problem(
            path, f"expected the end of another line, found {found(end)}{did_you_mean(end, others)}"
        )


def _named_end(draft: Draft, path: Path, end: str) -> Iterator[Problem]:
    """Yield what is wrong with an end given as text."""
    body = draft.bodies.get(end)
    if isinstance(body, CarriedBody):
        yield Problem(
            path, f"expected a body that lines are tied to, found {found(end)}, on a line"
        )
        return
    if isinstance(body, MovedBody):
        yield from _point_of(path, end, "", body)
        return
    if end == "free" or end in draft.bodies:
        return
    name, dot, point = end.partition(".")
    if dot and name in draft.bodies and name not in draft.lines:
        body = draft.bodies[name]
        if isinstance(body, MovedBody):
            yield from _point_of(path, name, point, body)
        elif isinstance(body, CarriedBody) or (body is not None and point not in body.points):
            known = body.points if isinstance(body, Body) else {}
            yield Problem(
                path, f'expected a point of the body "{name}", found {unknown(point, known)}'
            )
        return
    ends = [f"{line}.{side}" for line in draft.lines for side in SIDES]
    own = dotted(path[1:])
    if end not in ends:
        others = [other for other in ends if other.split(".")[0] != path[1]]
        hint = did_you_mean(end, ["free", *draft.bodies, *_points(draft), *others])
        if dot and not hint and name not in draft.lines:
            hint = f'; there is no {"line" if point in SIDES else "body"} "{name}"'
        yield Problem(
            path,
            f'expected "free", a body or the end of another line, found {found(end)}{hint}',
        )
    elif end.split(".")[0] == path[1]:
        itself = "itself" if end == own else "the same line"
        yield Problem(path, f'expected the end of another line, found "{end}" on {itself}')


def _tied_end(draft: Draft, path: Path, end: str) -> Iterator[Problem]:
    """Yield what is wrong with the body that an end is clamped to."""
    name = end.partition(".")[0]
    body = draft.bodies.get(name)
    if name not in draft.bodies:
        known = [*draft.bodies, *_points(draft)]
        yield Problem(path, f"expected a body or a point of one, found {unknown(end, known)}")
    elif isinstance(body, Body) and not body.rigid:
        yield Problem(
            path,
            f'expected a rigid body, found "{name}", a point mass; give it a size or an inertia',
        )
    elif body is not None:
        yield from _named_end(draft, path, end)


def _point_of(path: Path, name: str, point: str, body: MovedBody) -> Iterator[Problem]:
    """Yield a fault where a moved body has no such point."""
    if point in body.points:
        return
    known = [f"{name}.{other}" for other in body.points]
    told = f"{name}.{point}" if point else name
    hint = did_you_mean(told, known) or (f"; known: {', '.join(known)}" if known else "")
    yield Problem(
        path,
        f'expected a point of the moved body "{name}", found "{told}"{hint or "; it has none"}',
    )


def _pretension(draft: Draft, path: Path, line: Line, held: HeldForce) -> Iterator[Problem]:
    material = draft.materials.get(line.material)
    if material is None or next(inside(material, (), draft.sound), None) is not None:
        return
    reach = material.reach()
    if held.pretension > reach * (1 + 1e-12):
        strain = format_quantity(material.top_strain(), "")
        yield Problem(
            path,
            f"expected at most {format_quantity(reach, 'N')}, the largest tension of "
            f'"{line.material}" up to its strain {strain}, '
            f"found {format_quantity(held.pretension, 'N')}",
        )
