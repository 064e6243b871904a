"""From trolleys, winches and measures of a scene to those of the model."""

from dataclasses import replace
from typing import Any

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody, body_key
from lumpedcable.model.coordinates import Coordinates, plane_normal
from lumpedcable.model.couple import winch_name
from lumpedcable.model.floating import reference_of
from lumpedcable.model.layout import Layout
from lumpedcable.model.line import Line
from lumpedcable.model.model import AbstractMeasured, Model
from lumpedcable.model.moved import path_of
from lumpedcable.model.numbers import if_given, moving, number, vector
from lumpedcable.model.places import Later, place_measured
from lumpedcable.model.reels import Drum
from lumpedcable.model.riders import Coupled, Rider
from lumpedcable.model.sea import gauge, sea_surface
from lumpedcable.model.ships import motion_of
from lumpedcable.model.state import Seen
from lumpedcable.model.winches import Control, Schedule, Sheave, Winch
from lumpedcable.physics import measures
from lumpedcable.physics.contact import Hertz
from lumpedcable.physics.coupling import BodyPost, IdealCable, Trolley
from lumpedcable.physics.measures import AbstractMeasure, Near
from lumpedcable.physics.motion import AbstractMotion, Hauled, Spooled, Still, velocity_of
from lumpedcable.physics.rigid import place_of
from lumpedcable.physics.ships import HeldBody
from lumpedcable.physics.tension import strain_at
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody, Contact, DrumEnd, WinchEnd
from lumpedcable.scene.carried import Winch as WinchPart
from lumpedcable.scene.ends import joined_to
from lumpedcable.scene.measures import (
    SEA,
    BodyMeasure,
    ElevationMeasure,
    HeightMeasure,
    SpeedMeasure,
)
from lumpedcable.scene.moved import MovedBody

__all__ = [
    "Measured",
    "body_place",
    "make_couplings",
    "make_drums",
    "make_measures",
    "make_riders",
    "make_winches",
]


PARTS = 16  # of each interval of a schedule, between which what a metre costs is linear


class Measured(AbstractMeasured):
    """A measure of a body; `axes` (3, d) and `origin` (3,) lead from its coordinates to x, y, z.

    It ends with the hauling of the body where `until_rest` says so. `deck` is the rigid body whose deck
    the height counts from, `post` the post on one that it counts near; None where neither moves freely.
    """

    body: str = eqx.field(static=True)
    law: AbstractMeasure
    axes: Float[Array, "3 d"]
    origin: Float[Array, " 3"]
    until_rest: bool = eqx.field(static=True, default=False)
    deck: str | None = eqx.field(static=True, default=None)
    post: BodyPost | None = None

    def value(self, model: Model, t, seen: Seen) -> Float[Array, ""]:
        """The number at t (s)."""
        body, key = model.bodies[self.body], body_key(self.body)
        d = self.axes.shape[1]
        place = self.origin + self.axes @ (body.reference + seen.displacement[key])[:d]
        law = self._law(model, seen.displacement)
        found = law.value(t, place, self.axes @ seen.velocity[key][:d])
        if not self.until_rest:
            return found
        assert isinstance(body, Rider)  # the scene was checked
        assert isinstance(body.path, Hauled)
        return jnp.where(t <= body.path.arrival, found, jnp.nan)

    def _law(self, model: Model, displacement) -> AbstractMeasure:
        """The measure with what it counts from where that is at the moment."""
        law = self.law
        if self.deck is not None and isinstance(law, measures.HeightMeasure):
            at = self._six(model, displacement, self.deck)
            law = replace(law, motion=HeldBody(at), mean=jnp.zeros(3))
        if self.post is not None and law.near is not None:
            body = model.bodies[self.post.body]
            q = body.reference + displacement[body_key(self.post.body)]
            place = self.origin + self.axes @ body.place(q, self.post.point)
            law = replace(law, near=replace(law.near, post=Still(place)))
        return law

    def _six(self, model: Model, displacement, name: str) -> Float[Array, " 6"]:
        """Place (m) and roll, pitch, yaw (rad) of a rigid body."""
        q = model.bodies[name].reference + displacement[body_key(name)]
        d = self.axes.shape[1]
        turn = q[d:]
        if d == 2:
            turn = plane_normal(self.axes) * q[2]
        return jnp.concatenate([self.origin + self.axes @ q[:d], turn])


def body_place(scene: Scene, end: Any, coordinates: Coordinates):
    """The rigid body that an end is tied to and the point (m) in its axes; None for anything else."""
    tied = scene.body_point(end)
    if tied is None:
        return None
    name, point = tied
    part = scene.bodies[name]
    assert isinstance(part, Body)
    offset = (0.0, 0.0, 0.0) if point is None else part.points[point]
    return name, coordinates.vector(offset)


def _posts(scene: Scene, line: str, coordinates: Coordinates) -> list[AbstractMotion | BodyPost]:
    """The paths of the two ends of a line that a body runs on, or the bodies that they stand on."""
    found = []
    for own in (scene.lines[line].start, scene.lines[line].end):
        end = joined_to(scene.lines, own)
        tied = body_place(scene, end, coordinates)
        if tied is not None:
            found.append(BodyPost(*tied))
            continue
        motion = path_of(scene, end, coordinates)
        assert motion is not None  # the scene was checked
        found.append(motion)
    return found


def _winch(scene: Scene, line: str):
    part = scene.lines[line]
    for node, end in ((0, part.start), (-1, part.end)):
        if isinstance(end, WinchEnd):
            return node, end.winch
    return None


def make_winches(scene: Scene, lines: dict[str, Line]) -> dict[str, AbstractBody]:
    """The winches of the lines that have nodes."""
    found: dict[str, AbstractBody] = {}
    for name, line in lines.items():
        given = _winch(scene, name) if name in scene.lines else None
        if given is None:
            continue
        node, winch = given
        tension = number(winch.tension)
        pull, stretch = _kept(line, tension)
        length = jnp.sum(line.node_length)
        control = _control(winch)
        integral = control is not None and control.rate is not None
        found[winch_name(name)] = Winch(
            reference=jnp.stack([length, jnp.zeros_like(length)][: 2 if integral else 1]),
            mass_per_metre=line.mass,
            drum=if_given(winch.inertia),
            pull=pull,
            tension=tension,
            stretch=stretch,
            damping=if_given(winch.damping),
            speed=if_given(winch.speed),
            control=control,
            sheave=_sheave(winch),
            schedule=_schedule(winch, line),
            line=name,
            node=node,
        )
    return found


def make_drums(scene: Scene, lines: dict[str, Line]) -> dict[str, AbstractBody]:
    """The drums at ends of lines."""
    found: dict[str, AbstractBody] = {}
    for name, part in scene.lines.items():
        for node, end in ((0, part.start), (-1, part.end)):
            if not isinstance(end, DrumEnd):
                continue
            length, schedule = jnp.sum(lines[name].node_length)[None], end.drum.schedule
            # a scene at rest pays nothing out
            path = Spooled(length, vector(schedule.time), moving(scene) * vector(schedule.speed))
            found[winch_name(name)] = Drum(
                reference=length,
                path=path,
                least=path.least(number(scene.output.duration)),
                free=jnp.zeros_like(length),
                line=name,
                node=node,
                start_velocity=velocity_of(path, jnp.zeros(())),
            )
    return found


def _kept(line: Line, tension: Array) -> tuple[Array, Array]:
    """What a metre of line costs a winch that keeps a tension (N), and its stretch (-)."""
    strain = strain_at(line.law, tension, line.max_strain)
    return (1.0 + strain) * tension - line.law.energy(strain), 1.0 + strain


def _schedule(winch: WinchPart, line: Line) -> Schedule | None:
    if winch.schedule is None:
        return None
    told = vector([0.0, *winch.schedule.time]), vector([winch.tension, *winch.schedule.tension])
    knots = jnp.arange(told[0].size)
    finer = jnp.linspace(0.0, knots[-1], PARTS * (knots.size - 1) + 1)
    time, tension = (jnp.interp(finer, knots, values) for values in told)
    pull, stretch = _kept(line, tension)
    return Schedule(time, pull, tension, stretch)


def _control(winch: WinchPart) -> Control | None:
    if winch.control is None:
        return None
    gain, time = number(winch.control.gain), winch.control.integral_time
    return Control(gain, None if time is None else gain / number(time))


def _sheave(winch: WinchPart) -> Sheave | None:
    if winch.sheave is None:
        return None
    grip = number(winch.sheave.friction) * number(winch.sheave.wrap)
    return Sheave(grip, number(winch.sheave.speed))


def make_riders(scene: Scene, coordinates: Coordinates) -> dict[str, AbstractBody]:
    """The bodies that run on lines, at their places of the start, level with their line's start."""
    found: dict[str, AbstractBody] = {}
    for name, body in scene.bodies.items():
        if isinstance(body, CarriedBody):
            found[name] = _rider(scene, body, coordinates)
    return found


def _at_start(
    scene: Scene, post: AbstractMotion | BodyPost, coordinates: Coordinates
) -> Float[Array, " d"]:
    """Where a post is at t = 0 (m)."""
    if not isinstance(post, BodyPost):
        return post.position(jnp.zeros(()))
    body = scene.bodies[post.body]
    assert isinstance(body, Body)
    return place_of(reference_of(body, coordinates), post.point)


def _rider(scene: Scene, body: CarriedBody, coordinates: Coordinates) -> Rider:
    d = coordinates.dimensions
    up = coordinates.vector((0.0, 0.0, 1.0))
    posts = _posts(scene, body.on.line, coordinates)
    start, end = (_at_start(scene, post, coordinates) for post in posts)
    way = end - start
    level = way - jnp.dot(way, up) * up
    span = jnp.sqrt(jnp.sum(level**2))
    along = level / span
    place = start + number(body.on.place) * along
    if body.height is not None:
        rise = number(body.height) - number(coordinates.origin[2]) - jnp.dot(place, up)
        place = place + rise * up
    angles = jnp.zeros(0 if body.depth is None else d - 1)
    q = jnp.concatenate([place, angles])
    mass, free, path = number(body.mass), None, None
    if body.on.speed is not None:
        # hauled along a coordinate axis: the scene was checked
        free = jnp.concatenate([1.0 - jnp.round(along**2), jnp.ones_like(angles)])
        travel = span - number(body.on.place) - number(body.on.stop)
        # no way at all in a scene at rest
        direction = moving(scene) * jnp.concatenate([along, jnp.zeros_like(angles)])
        path = Hauled(q, direction, number(body.on.speed), travel, number(body.on.ease))
    weight = None
    if scene.gravity is not None:
        weight = -mass * number(scene.gravity) * up
    return Rider(
        reference=q,
        kilograms=mass,
        depth=if_given(body.depth),
        inertia=if_given(body.inertia),
        weight=weight,
        free=free,
        path=path,
        dimensions=d,
        settles=body.height is None,
    )


def make_couplings(
    scene: Scene, lines: dict[str, Line], coordinates: Coordinates
) -> tuple[Coupled, ...]:
    """What ties each body on a line to it."""
    found = []
    for name, body in scene.bodies.items():
        if not isinstance(body, CarriedBody):
            continue
        line, given = body.on.line, _winch(scene, body.on.line)
        assert given is not None  # the scene was checked
        tension = number(given[1].tension)
        if scene.lines[line].model == "ideal":
            start, end = _posts(scene, line, coordinates)
            law = IdealCable(start, end, tension)
            found.append(Coupled(name, None, law))
            continue
        friction, bending = body.on.friction, scene.lines[line].bending
        law = Trolley(
            tension,
            _kept(lines[line], tension)[1],
            None if friction is None else number(friction.coefficient),
            None if friction is None else number(friction.speed),
            _hertz(body.on.contact),
            None if bending is None else number(bending.EI),
        )
        found.append(Coupled(name, line, law))
    return tuple(found)


def _hertz(part: Contact | None) -> Hertz | None:
    if part is None:
        return None
    damping = if_given(part.damping)
    depth = if_given(part.depth)
    return Hertz(number(part.stiffness), number(part.exponent), damping, depth)


def make_measures(
    scene: Scene, layout: Layout, coordinates: Coordinates
) -> dict[str, AbstractMeasured]:
    """The numbers that the scene asks for, by name."""
    found: dict[str, AbstractMeasured] = {}
    for name, part in scene.measures.items():
        if isinstance(part, BodyMeasure):
            found[name] = _measured(scene, part, coordinates)
        elif isinstance(part, ElevationMeasure):
            found[name] = gauge(scene, part)
        else:
            found[name] = place_measured(layout, coordinates, part)
        if part.after is not None:
            found[name] = Later(found[name], number(part.after))
    return found


def _measured(scene: Scene, part: BodyMeasure, coordinates: Coordinates) -> Measured:
    return Measured(
        part.body,
        _measure(scene, part),
        jnp.asarray(coordinates.axes, float),
        jnp.asarray(coordinates.origin, float),
        part.while_hauled,
        _free_deck(scene, part),
        _free_post(scene, part, coordinates),
    )


def _free_deck(scene: Scene, part: BodyMeasure) -> str | None:
    over = part.over if isinstance(part, HeightMeasure) else None
    return over if over is not None and isinstance(scene.bodies.get(over), Body) else None


def _free_post(scene: Scene, part: BodyMeasure, coordinates: Coordinates) -> BodyPost | None:
    tied = None if part.near is None else body_place(scene, part.near, coordinates)
    return None if tied is None else BodyPost(*tied)


def _measure(scene: Scene, part: BodyMeasure) -> AbstractMeasure:
    near = None
    if part.near is not None:
        path = path_of(scene, part.near, Coordinates(np.eye(3), np.zeros(3)))
        bounds = [if_given(b) for b in (part.within, part.beyond)]
        # a post on a free body is put in where it is at the moment
        near = Near(Still(jnp.zeros(3)) if path is None else path, *bounds)
    if isinstance(part, SpeedMeasure):
        return measures.ClimbMeasure(near=near)
    if part.over is None:
        return measures.HeightMeasure(level=number(part.level), near=near)
    if part.over == SEA:
        return measures.ClearanceMeasure(
            level=number(part.level), surface=sea_surface(scene), near=near
        )
    ship = scene.bodies[part.over]
    if not isinstance(ship, MovedBody):
        return measures.HeightMeasure(level=number(part.level), near=near)
    return measures.HeightMeasure(
        level=number(part.level),
        motion=motion_of(scene, ship),
        mean=vector(ship.position),
        near=near,
    )
