"""What is compared with a record: a tension or a motion at a place, at the times of the record."""

from __future__ import annotations

import re
from typing import NamedTuple, cast

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import NDArray

from lumpedcable.model.assemble import segment_lengths
from lumpedcable.model.bodies import body_key
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import reel_of, winch_name
from lumpedcable.model.layout import Layout
from lumpedcable.model.model import Model
from lumpedcable.model.places import PlaceMeasured, along_axis, segment_sizes
from lumpedcable.model.state import Seen
from lumpedcable.physics.vectors import size
from lumpedcable.scene import Scene, format_quantity
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried import CarriedBody
from lumpedcable.scene.ends import tie_of
from lumpedcable.scene.measures import PlaceKind
from lumpedcable.scene.part import SIDES, did_you_mean
from lumpedcable.scene.units import UnitError, parse_quantity
from lumpedcable.solve.observe import Sample

__all__ = [
    "MEASURE",
    "PEAK",
    "STOP",
    "UNITS",
    "Grid",
    "Watched",
    "grid_of",
    "look",
    "spacing_of",
    "watched",
    "weights_of",
]

UNITS = {"tension": "N", "displacement": "m", "velocity": "m/s", "position": "m"}
MEASURE = "measure"  # a number that the scene asks for: NaN while it does not count
STOP = "stop"  # when the body of output.stop came to rest: NaN before
PEAK = "peak"  # the largest tension of a rod so far, of every step
MOST_OUTPUTS = 20_000  # of a grid that meets all times of a record
MOST_PARTS = 10  # of the smallest gap between times that its spacing may be
ON_GRID = 1e-6  # of its spacing by which a time may miss a point of the grid
_PLACE = re.compile(r"([A-Za-z][\w-]*)(?:\.(start|end)|@(.+))")


Weights = Float[Array, " points"]


class Watched(NamedTuple):
    """One observed quantity, as far as it is structure.

    `node` is 0 or -1 at an end of the piece (of a peak: the segment), None elsewhere. `before` are the
    pieces between the line's start and this one. Of a measure or a `body`, `piece` is its name.
    """

    quantity: str
    piece: str
    node: int | None
    component: int | None
    body: bool = False
    before: tuple[str, ...] = ()


def watched(
    scene: Scene, layout: Layout, quantity: str, at: str, component: str | None
) -> tuple[Watched, float]:
    """The observed quantity at a place, and its unstretched distance (m) from the line's start.

    The distance is 0 where what is observed does not depend on it: at ends, of bodies.

    Raises:
        ValueError: there is no such place; the message follows the key.
    """
    match = _PLACE.fullmatch(at.strip())
    axis = None if component is None else "xyz".index(component)
    bodies = [
        name
        for name, body in scene.bodies.items()
        if isinstance(body, CarriedBody) or (isinstance(body, Body) and body.rigid)
    ]
    force = quantity in ("tension", PEAK)
    if force and (tied := _tied(scene, at.strip())) is not None:
        match = _PLACE.fullmatch(tied)
    elif at.strip() in bodies:
        if force:
            raise ValueError(f'expected a place on a line for a tension, found the body "{at}"')
        return Watched(quantity, at.strip(), None, axis, body=True), 0.0
    if match is None:
        body = f", or a rigid body or a trolley ({', '.join(bodies)})" if bodies else ""
        ends = [f"{name}.{side}" for name in scene.lines for side in SIDES]
        hint = did_you_mean(at.strip(), [*ends, *bodies])
        raise ValueError(
            f'expected "LINE.start", "LINE.end" or "LINE@DISTANCE"{body}, found "{at}"{hint}'
        )
    line, side, distance = match.groups()
    if line not in scene.lines:
        raise ValueError(
            f'expected a line of the scene, found "{line}"{did_you_mean(line, scene.lines)}'
        )
    pieces = layout.of_line(line)
    if not pieces:
        raise ValueError(f'expected a line with nodes, found "{line}", which is ideal')
    if quantity == PEAK and scene.materials[scene.lines[line].material].law != "inextensible":
        raise ValueError(
            f'expected a line that keeps its length for a peak of every step, found "{line}": '
            "take max, with output.every the step"
        )
    if side is not None:
        piece, node = (pieces[0], 0) if side == "start" else (pieces[-1], -1)
        return Watched(quantity, piece.name, node, axis), 0.0
    if line in (target.line for target in scene.targets.values()):
        raise ValueError(
            f'expected an end of "{line}", whose length a target finds, found "{at}": a measure, '
            f'{"tension" if force else quantity} = "{at}", looks there'
        )
    try:
        place = parse_quantity(distance, "m")
    except UnitError as error:
        raise ValueError(f"expected a length (m) after @, found {error}") from None
    length = scene.lines[line].length
    if not 0.0 <= place <= length:
        raise ValueError(
            f"expected a distance from 0 to the line's length, {format_quantity(length, 'm')}, "
            f"found {format_quantity(place, 'm')}"
        )
    begin, piece, own, before = 0.0, pieces[0], np.zeros(0), []
    for piece in pieces:
        own = np.broadcast_to(np.asarray(segment_lengths(scene, piece)), (piece.segments,))
        if place <= begin + own.sum() or piece is pieces[-1]:
            break
        begin += own.sum()
        before.append(piece.name)
    if quantity == PEAK:
        nodes = np.concatenate([[0.0], np.cumsum(own)])
        index = int(np.clip(np.searchsorted(nodes, place - begin) - 1, 0, own.size - 1))
        return Watched(quantity, piece.name, index, axis), 0.0
    if quantity == "tension" and own.size == 1:
        return Watched(quantity, piece.name, 0, axis), 0.0
    return Watched(quantity, piece.name, None, axis, before=tuple(before)), place


def weights_of(
    model: Model, coordinates: Coordinates, what: Watched, place: Float[Array, ""]
) -> Weights | PlaceMeasured | None:
    """Weights of nodes (of a tension: segments) in what is at `place` (m); None at ends, of bodies.

    Linear between the two neighbours. As the place is a distance along the line, they are others
    where a line gets longer, and derivatives by its length know of it. Where it is paid out in the run
    they are others at each time: then it is looked at as by a measure of the place.
    """
    if what.node is not None or what.body or what.quantity in (MEASURE, STOP, PEAK):
        return None
    if reel_of(model, what.piece) is not None:
        kind = cast(PlaceKind, what.quantity)
        seen_along = along_axis(coordinates, kind, what.component)
        return PlaceMeasured(kind, (what.piece,), None, place, *seen_along)
    own = segment_sizes(model.lines[what.piece])
    ends = jnp.cumsum(own)
    starts = ends - own
    tension = what.quantity == "tension"
    points = 0.5 * (starts + ends) if tension else jnp.concatenate([starts, ends[-1:]])
    along = place.astype(own.dtype) - sum(
        jnp.sum(segment_sizes(model.lines[name])) for name in what.before
    )
    k = jnp.clip(jnp.sum(points < along) - 1, 0, points.size - 2)
    share = (along - points[k]) / (points[k + 1] - points[k])
    index = jnp.arange(points.size)
    return jnp.where(index == k, 1.0 - share, jnp.where(index == k + 1, share, 0.0))


def _tied(scene: Scene, at: str) -> str | None:
    """The end "LINE.start" or "LINE.end" of the one line that is tied to a body or to a point of it.

    Raises:
        ValueError: several lines are.
    """
    if at.split(".")[0] not in scene.bodies:
        return None
    sides = [(n, s, getattr(line, s)) for n, line in scene.lines.items() for s in SIDES]
    ends = [f"{name}.{side}" for name, side, end in sides if tie_of(end) == at]
    if len(ends) > 1:
        raise ValueError(f'expected the end of one line, found "{at}" with {", ".join(ends)}')
    return ends[0] if ends else None


def look(
    model: Model,
    coordinates: Coordinates,
    seen: Sample,
    what: Watched,
    weights: Weights | PlaceMeasured | None,
) -> Float[Array, ""]:
    """The value (SI) of an observed quantity at one output time, from what is sampled there.

    Between nodes (of a tension: the middles of segments) it is linear, an error of the second order
    in the segments' length.
    """
    if what.quantity == MEASURE:
        return seen.measures[what.piece]
    if isinstance(weights, PlaceMeasured):
        return weights.value(model, jnp.zeros(()), _seen_of(model, seen, what.piece))
    if what.quantity == "tension":
        if what.node is not None:
            return seen.ends[what.piece][what.node]
        assert weights is not None
        return seen.fields[what.piece]["tension"] @ weights
    if what.body:
        here = _of_body(model, seen, what, coordinates.dimensions)
    else:
        here = _of_line(model, seen, what, weights)
    if what.component is None:
        return size(here)
    value = jnp.asarray(coordinates.axes)[what.component] @ here
    if what.quantity == "position":
        value = value + jnp.asarray(coordinates.origin)[what.component]
    return value


def _seen_of(model: Model, seen: Sample, line: str) -> Seen:
    """What a measure of a place is taken of, of a line that is paid out and of what pays it out."""
    name = winch_name(line)
    q, rate = seen.bodies[name]
    own, key = seen.fields[line], body_key(name)
    moved = {line: own["position"], key: q - model.bodies[name].reference}
    rates = {line: own["velocity"], key: rate}
    return Seen(moved, rates, {line: own["tension"]}, seen.ends)


def _of_line(model: Model, seen: Sample, what: Watched, weights) -> Float[Array, " d"]:
    """Displacement, place (m) or velocity (m/s) of a place on a line."""
    field = seen.fields[what.piece]["velocity" if what.quantity == "velocity" else "position"]
    if what.quantity == "position":
        field = field + model.lines[what.piece].reference
    return field[:, what.node] if what.node is not None else field @ weights


def _of_body(model: Model, seen: Sample, what: Watched, d: int) -> Float[Array, " d"]:
    """Displacement, place (m) or velocity (m/s) of a body's centre of gravity, or of a trolley."""
    q, rate = seen.bodies[what.piece]
    if what.quantity == "velocity":
        return rate[:d]
    return q[:d] - model.bodies[what.piece].reference[:d] * (what.quantity == "displacement")


class Grid(NamedTuple):
    """Output times k every (s), k = 0 to outputs, and each data time as a sum of four of them.

    near, weight: (times, 4); `less` are the weights of a parabola through three of the four.
    `exact` says that every data time is an output time.
    """

    every: float
    outputs: int
    near: NDArray[np.int64]
    weight: NDArray[np.float64]
    less: NDArray[np.float64]
    exact: bool


def spacing_of(times: NDArray[np.float64]) -> float | None:
    """The spacing (s) that data times (s) are multiples of, None where there is none to be used.

    It is the smallest gap between two of them, or a part of it: what was thinned or begins later is
    still of the spacing that it was taken with.
    """
    gaps = np.diff(np.concatenate([[0.0], times]))
    least = float(np.min(gaps[gaps > 0.0]))
    for part in range(1, MOST_PARTS + 1):
        # the spacing to all digits that the times have
        every = times[-1] / max(round(times[-1] / least * part), 1)
        k = np.rint(times / every)
        if k[-1] > MOST_OUTPUTS:
            break
        if np.all(np.abs(times / every - k) <= ON_GRID):
            return float(every)
    return None


def grid_of(times: NDArray[np.float64], step: float) -> Grid:
    """The output times for data times (s).

    Where the data times are multiples of one spacing they are output times themselves. Otherwise
    outputs come at every `step` (s) of the solver, with a cubic through the nearest four.
    """
    every = spacing_of(times)
    if every is not None:
        k = np.rint(times / every).astype(int)
        index = np.repeat(k[:, None], 4, axis=1)
        alone = np.tile([1.0, 0.0, 0.0, 0.0], (k.size, 1))
        return Grid(every, round(times[-1] / every), index, alone, alone, True)
    every = min(step, times[-1] / 3.0)
    count = max(int(np.ceil(times[-1] / every * (1.0 - 1e-12))), 3)
    first = np.clip(np.floor(times / every).astype(int) - 1, 0, count - 3)
    index, x = first[:, None] + np.arange(4), times / every - first
    parabola = np.pad(_lagrange(x, 3), ((0, 0), (0, 1)))
    return Grid(every, count, index, _lagrange(x, 4), parabola, False)


def _lagrange(x: NDArray[np.float64], points: int) -> NDArray[np.float64]:
    """Weights (times, points) at x of the polynomial through points 0, 1, 2, ..."""
    weights = np.ones((x.size, points))
    for i in range(points):
        for j in range(points):
            if j != i:
                weights[:, i] *= (x - j) / (i - j)
    return weights
