"""From a scene to a model: strings become classes here, and numbers become arrays.

The scene's numbers may be traced: the same function serves one run, a batch under `vmap` and a
derivative with respect to any number of the scene file.
"""

from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.beds import bed_damping, bed_under
from lumpedcable.model.bodies import AbstractBody
from lumpedcable.model.carried import (
    body_place,
    make_couplings,
    make_drums,
    make_measures,
    make_riders,
    make_winches,
)
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.cuts import LEAST
from lumpedcable.model.ends import Attached, Driven, End, Joined, Junction, Loaded, Release
from lumpedcable.model.floating import lift_of, make_body
from lumpedcable.model.layout import Joint, Layout, Piece
from lumpedcable.model.line import Line, node_lengths
from lumpedcable.model.materials import law_of, relaxation_of, rod_law
from lumpedcable.model.model import Model
from lumpedcable.model.moved import aim_of, path_of
from lumpedcable.model.numbers import if_given, number, vector
from lumpedcable.model.sea import sea_flow
from lumpedcable.model.turned import turned
from lumpedcable.physics.bending import Bending
from lumpedcable.physics.fluid import (
    AbstractCurrent,
    PowerLawCurrent,
    TableCurrent,
    UniformCurrent,
)
from lumpedcable.physics.load import AbstractLoad
from lumpedcable.physics.morison import AddedMass, Drag
from lumpedcable.physics.seabed import AbstractSeabed, BedGrip, SeabedDamping
from lumpedcable.physics.waterline import Lift, Waterline
from lumpedcable.physics.waves import ReleaseWaves
from lumpedcable.physics.weight import Weight, buoyancy_per_length
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import post_of
from lumpedcable.scene.ends import HeldForce, MovingEnd, TiedEnd, clamp_of, held_force, held_place
from lumpedcable.scene.environment import PowerCurrent as PowerPart
from lumpedcable.scene.environment import TableCurrent as TablePart
from lumpedcable.scene.joints import rigid_joints
from lumpedcable.scene.lines import Line as LinePart

__all__ = ["assemble", "make_line", "release_of", "seam_of", "segment_lengths", "wave_scheme"]


def wave_scheme(scene: Scene) -> str:
    """The treatment of waves that a scene gets: its own choice, or the one that it needs.

    A break sends fronts along a line. Where the law is not a straight line, and where a line can go
    slack and snap taut, waves steepen into shocks, which without viscosity turn into noise that grows.
    """
    if scene.solver.waves is not None:
        return scene.solver.waves
    if scene.events:
        return "corrected"
    used = (scene.materials[line.material] for line in scene.lines.values())
    shocks = any(
        material.law not in ("linear", "inextensible") or material.tension_only for material in used
    )
    return "viscous" if shocks else "plain"


def segment_lengths(scene: Scene, piece: Piece, xp: Any = jnp) -> Float[Array, "..."]:
    """Unstretched segment lengths (m) of a piece, shape (n,), or (1,) where all are equal.

    With `xp` = numpy for a concrete scene, outside any compiled program.
    """
    line = scene.lines[piece.line]
    part = slice(piece.first, piece.first + piece.segments)
    if line.segment_lengths is not None:
        return xp.stack([xp.asarray(l, float) for l in line.segment_lengths])[part]
    if line.grading is not None and line.segments is not None and line.segments > 1:
        power = xp.arange(line.segments) / (line.segments - 1.0)
        weight = xp.asarray(line.grading, float) ** power
        return (line.unstretched * weight / xp.sum(weight))[part]
    if piece.seam is not None:
        before, sizes = seam_of(scene, piece, xp)
        return xp.where(xp.arange(piece.segments) < before, *sizes)
    first, last = (
        scene.events[event].place if event is not None else own
        for event, own in ((piece.starts_at, 0.0), (piece.ends_at, line.unstretched))
    )
    return ((xp.asarray(last, float) - xp.asarray(first, float)) / piece.segments)[None]


def seam_of(scene: Scene, piece: Piece, xp: Any = jnp) -> tuple[Any, tuple[Any, Any]]:
    """Segments before the seam of a piece, and the unstretched lengths (m) of those before and after it.

    The seam is at the node nearest to the place of the break, and that node at the place.
    """
    assert piece.seam is not None
    length = xp.asarray(scene.lines[piece.line].unstretched, float)
    place = xp.asarray(scene.events[piece.seam].place, float)
    nearest = xp.rint(piece.segments * place / length)
    before = xp.clip(nearest, LEAST, piece.segments - LEAST)
    return before.astype(int), (place / before, (length - place) / (piece.segments - before))


def make_line(scene: Scene, name: str, length: Float[Array, "..."], segments: int,
              coordinates: Coordinates, outer: tuple[bool, bool] = (True, True)) -> Line:  # fmt: skip
    """A line of the model with the properties of the scene's line `name`, its reference still open.

    `outer` says whether it has the start and the end of that line, or is cut off from them.
    """
    part = scene.lines[name]
    material = scene.materials[part.material]
    inextensible = material.law == "inextensible"
    d = coordinates.dimensions
    fluid, drag, added = scene.fluid, None, None
    if fluid is not None and part.drag is not None:
        drag = Drag(
            number(fluid.density), number(part.diameter), number(part.drag.normal),
            number(part.drag.tangential), part.drag.convention,
        )  # fmt: skip
    if fluid is not None and part.added_mass is not None:
        along = part.added_mass.tangential
        if d > 1 or along is not None:
            added = AddedMass(
                number(fluid.density), number(part.diameter), number(part.added_mass.normal),
                if_given(along),
            )  # fmt: skip
    flow = None if part.diameter is None else sea_flow(scene, coordinates)
    waterline = _waterline(scene, part, coordinates)
    scheme = wave_scheme(scene)
    bed = _seabed(scene, name, coordinates)
    resistances = _resistances(scene, bed)
    return Line(
        law=rod_law(scene, name) if inextensible else law_of(material),
        mass=number(part.mass),
        segment_length=length,
        node_length=node_lengths(length, segments),
        reference=jnp.zeros((d, segments + 1)),
        reference_step=jnp.zeros((d, segments)),
        reference_strain=jnp.zeros(segments),
        max_strain=number(material.max_strain),
        loads=_loads(scene, name, coordinates, segments, outer, bed, waterline),
        resistances=resistances,
        grip=_grip(scene, bed, resistances),
        damping=if_given(material.damping),
        relaxation=relaxation_of(material),
        drag=drag,
        added_mass=added,
        current=_current(scene, coordinates) if drag is not None else None,
        waterline=waterline,
        sea=flow,
        displaced=None if flow is None else number(scene.displaced(name)),
        waves=None if scheme == "plain" or inextensible else ReleaseWaves(scheme == "corrected"),
        give=1.0 / number(material.EA) if inextensible and material.EA is not None else None,
        inextensible=inextensible,
    )


def _loads(
    scene: Scene, name: str, coordinates: Coordinates, segments: int, outer: tuple[bool, bool],
    bed: AbstractSeabed | None, waterline: Waterline | None,
) -> tuple[AbstractLoad, ...]:  # fmt: skip
    part = scene.lines[name]
    loads: list[AbstractLoad] = []
    if scene.gravity is not None:
        gravity = number(scene.gravity)
        weight = number(part.mass) * gravity
        if scene.fluid is not None and part.diameter is not None:
            lift = buoyancy_per_length(number(scene.fluid.density), gravity, number(part.diameter))
            if waterline is None:
                weight = weight - lift
            else:
                loads.append(Lift(lift, waterline))
        loads.append(Weight(weight * coordinates.vector((0.0, 0.0, -1.0))))
    if part.bending is not None and coordinates.dimensions > 1:
        clamps = [
            coordinates.vector(clamp) if mine and (clamp := clamp_of(end)) is not None else None
            for end, mine in zip((part.start, part.end), outer, strict=True)
        ]
        goes_on = not all(outer) or name in {
            n for pair in rigid_joints(scene.lines) for n, _ in pair
        }
        if segments > 1 or goes_on or any(clamp is not None for clamp in clamps):
            loads.append(Bending(number(part.bending.EI), *clamps))
    if bed is not None:
        loads.append(bed)
    return tuple(loads)


def _waterline(scene: Scene, part: LinePart, coordinates: Coordinates) -> Waterline | None:
    """Where the water ends beside a line, None where that does not matter to it."""
    if scene.surface is None or part.diameter is None:
        return None
    return Waterline(*coordinates.over(scene.surface), number(part.diameter))


def _seabed(scene: Scene, name: str, coordinates: Coordinates) -> AbstractSeabed | None:
    return bed_under(scene, coordinates, number(scene.lines[name].mass))


def _resistances(scene: Scene, bed: AbstractSeabed | None) -> tuple[SeabedDamping, ...]:
    damping = bed_damping(scene, bed)
    return () if damping is None else (damping,)


def _grip(
    scene: Scene, bed: AbstractSeabed | None, resistances: tuple[SeabedDamping, ...]
) -> BedGrip | None:
    if bed is None or scene.seabed is None or scene.seabed.friction is None:
        return None
    damping = resistances[0] if resistances else None
    return BedGrip(number(scene.seabed.friction), bed, damping)


def _current(scene: Scene, coordinates: Coordinates) -> AbstractCurrent | None:
    fluid = scene.fluid
    if fluid is None or fluid.current is None:
        return None
    profile = fluid.current
    if isinstance(profile, TablePart):
        along = [coordinates.vector(velocity) for velocity in profile.velocity]
        return TableCurrent(vector(profile.z), jnp.stack(along, axis=1))
    velocity = coordinates.vector(profile.velocity)
    if isinstance(profile, PowerPart):
        own = None if fluid is scene.water else profile.surface  # air knows nothing of the sea's
        level = scene.sea_level if own is None else own
        return PowerLawCurrent(
            velocity, number(profile.exponent), number(profile.depth), number(level)
        )
    return UniformCurrent(velocity)


def assemble(scene: Scene, layout: Layout, coordinates: Coordinates) -> Model:
    """The model of a scene, its lines not yet placed: their references are zero.

    `layout` and `coordinates` come from the concrete scene; the scene's numbers may be traced.
    """
    lines, ends = {}, {}
    for piece in layout.pieces:
        length = segment_lengths(scene, piece)
        outer = (piece.starts_at is None, piece.ends_at is None)
        lines[piece.name] = make_line(scene, piece.line, length, piece.segments, coordinates, outer)
        ends[piece.name] = (
            _end(scene, layout, piece, 0, coordinates),
            _end(scene, layout, piece, -1, coordinates),
        )
    junctions, nth = [], {}
    for index, joint in enumerate(layout.joints):
        if _holder(scene, layout, joint) is None:
            nth[index] = len(junctions)
            junctions.append(_junction(scene, layout, joint, coordinates))
    ends = {name: (_numbered(a, nth), _numbered(b, nth)) for name, (a, b) in ends.items()}
    up = base = None
    if any(line.current is not None for line in lines.values()):
        up, base = coordinates.vector((0.0, 0.0, 1.0)), number(coordinates.origin[2])
    bodies: dict[str, AbstractBody] = {
        name: make_body(scene, name, coordinates, _current(scene, coordinates))
        for name, body in scene.bodies.items()
        if isinstance(body, Body) and body.rigid
    }
    bodies |= make_riders(scene, coordinates) | make_winches(scene, lines)
    bodies |= make_drums(scene, lines)
    couplings, measures = (
        make_couplings(scene, lines, coordinates),
        make_measures(scene, layout, coordinates),
    )
    rigid = tuple(
        (layout.end_of(*one), layout.end_of(*other)) for one, other in rigid_joints(scene.lines)
    )
    model = Model(
        lines, ends, tuple(junctions), up, base, bodies, couplings, measures, rigid_joints=rigid
    )
    return turned(model)


def _numbered(end: End, nth: dict[int, int]) -> End:
    """An end with its joint's number among all joints changed to that among the junctions."""
    return Joined(nth[end.junction], end.release) if isinstance(end, Joined) else end


def release_of(scene: Scene, event: str | None) -> Release | None:
    """The break of an event, None for none."""
    if event is None:
        return None
    own = scene.events[event]
    if own.tension is None:
        return Release(number(own.start), number(own.time))
    return Release(number(jnp.inf), number(own.time), number(own.tension))


def _own_end(scene: Scene, layout: Layout, name: str, node: int):
    """What the scene file says at an end of a piece; None at a cut."""
    piece = next(p for p in layout.pieces if p.name == name)
    if (piece.starts_at if node == 0 else piece.ends_at) is not None:
        return None
    line = scene.lines[piece.line]
    return line.start if node == 0 else line.end


def _holder(scene: Scene, layout: Layout, joint: Joint):
    """The end of a joint's members that holds or moves it as a whole, None where none does."""
    for name, node in joint.members:
        end = _own_end(scene, layout, name, node)
        moved = isinstance(end, MovingEnd) or post_of(end) is not None or scene.on_body(end)
        if moved or held_place(end) is not None:
            return end
    return None


def _end(scene: Scene, layout: Layout, piece: Piece, node: int, coordinates: Coordinates) -> End:
    release = release_of(scene, layout.event_at(piece.name, node))
    joint = layout.joint_of(piece.name, node)
    own = mine = _own_end(scene, layout, piece.name, node)
    if coordinates.dimensions == 1 or not isinstance(mine, TiedEnd):
        mine = None  # nothing bends on a line, and what is joined to a clamped end may turn
    if joint is not None:
        own = _holder(scene, layout, layout.joints[joint])
        if own is None:
            return Joined(joint, release)
    if (held := held_force(own)) is not None:
        return Loaded(_force(held, coordinates), release)
    if (tied := body_place(scene, own, coordinates)) is not None:
        aim = None if mine is None else coordinates.vector(mine.direction)
        return Attached(*tied, release, aim)
    path = path_of(scene, own, coordinates)
    return Loaded() if path is None else Driven(path, release, aim_of(scene, mine, coordinates))


def _force(held: HeldForce, coordinates: Coordinates) -> Float[Array, " d"]:
    """The force (N) that holds an end."""
    return number(held.pretension) * coordinates.vector(held.direction)


def _junction(scene: Scene, layout: Layout, joint: Joint, coordinates: Coordinates) -> Junction:
    load = mass = lift = None
    if joint.body is not None:
        body = scene.bodies[joint.body]
        assert isinstance(body, Body)  # lines are tied to no other
        mass = number(body.mass)
        if scene.gravity is not None:
            weight, lift = mass, lift_of(scene, body, coordinates)
            if lift is None and body.volume is not None and scene.fluid is not None:
                weight = mass - number(scene.fluid.density) * number(body.volume)
            load = weight * number(scene.gravity) * coordinates.vector((0.0, 0.0, -1.0))
    for name, node in joint.members:
        held = held_force(_own_end(scene, layout, name, node))
        if held is not None:
            force = _force(held, coordinates)
            load = force if load is None else load + force
    return Junction(joint.members, mass, load, lift, layout.cuts(joint))
