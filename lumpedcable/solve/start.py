"""The start of a scene: a first shape for every line from no guess, then static equilibrium."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.assemble import assemble
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.couple import winch_of
from lumpedcable.model.ends import Driven, Joined, Junction, Loaded
from lumpedcable.model.layout import Layout
from lumpedcable.model.line import Line, alike, done_alike, placed
from lumpedcable.model.model import Model
from lumpedcable.model.turned import turned
from lumpedcable.physics.bisection import bisected
from lumpedcable.physics.motion import Still
from lumpedcable.physics.vectors import size, unit
from lumpedcable.scene import Scene
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.ends import JoinedEnd
from lumpedcable.solve.carried import carried_equilibrium, is_carried
from lumpedcable.solve.clamps import arched, bent_out, folded, opened_out, stiffened
from lumpedcable.solve.hanging import hanging_line, nodal_weight
from lumpedcable.solve.hung import hung_over
from lumpedcable.solve.resting import (
    any_bed_of,
    bed_under,
    draped,
    laid_on_slope,
    lifted,
    rested,
    seabed_of,
    slope_under,
)
from lumpedcable.solve.statics import Equilibrium, held_position
from lumpedcable.solve.stiffening import stiffening
from lumpedcable.solve.wholes import wholes_of

__all__ = ["at_places", "start_of"]

Places = dict[str, Float[Array, " m"]]


def at_places(model: Model, places: Places | None) -> Model:
    """The model with some of its bodies at other coordinates (m, rad)."""
    if not places:
        return model
    bodies = {n: eqx.tree_at(lambda b: b.reference, model.bodies[n], q) for n, q in places.items()}
    return turned(eqx.tree_at(lambda m: m.bodies, model, model.bodies | bodies))


def start_of(
    scene: Scene, layout: Layout, coordinates: Coordinates, places: Places | None = None
) -> Equilibrium:
    """The scene's model at static equilibrium before anything breaks or moves.

    `places` are coordinates (m, rad) of rigid bodies that are elsewhere than the scene puts them.
    Each line of the scene, cut or not, is first laid out by itself between its two ends, those that are
    joined rigidly as one; then Newton's method on all of them together finishes the work. Lines on
    winches and bodies on cables are found apart from the others, none of which they touch.
    """
    model = at_places(assemble(scene, layout, coordinates), places)
    joints = _joint_places(scene, layout, model, coordinates)
    given = _given_places(scene, layout, model, coordinates)
    joints = [given.get(k, place) for k, place in enumerate(joints)]
    joints = _laid_on_bed(scene, layout, model, joints, set(given))
    joints = _hung_over_bed(scene, layout, model, joints, set(given))
    lines, wholes, paths, spans = dict(model.lines), {}, {}, {}
    laid = wholes_of(scene, layout, model, set(given))
    for name, whole in laid.items():
        if winch_of(model, name) is not None:
            continue  # laid out with what runs on it
        wholes[name] = whole.line(scene, coordinates)
        start, end = (_place(model, side, joints) for side in whole.outer)
        if start is not None and end is not None:
            spans[name] = start, end
        else:
            paths[name] = _lay_out(wholes[name], model, whole.outer, start, end)
    for names in alike({name: wholes[name] for name in spans}):
        ends = (jnp.stack(side) for side in zip(*(spans[name] for name in names), strict=True))
        found = done_alike(_laid_between, [wholes[name] for name in names], *ends)
        paths |= zip(names, found, strict=True)
    for name, path in paths.items():
        for piece, nodes in laid[name].shared(path):
            lines[piece] = placed(lines[piece], nodes)
    model = eqx.tree_at(lambda m: m.lines, model, lines)
    tolerance = jnp.asarray(scene.statics.tolerance, float)
    most = scene.statics.max_iterations
    # the far end of a line on a winch is held, so that nothing at rest hears of it but what runs on it
    wound = [name for name in lines if winch_of(model, name) is not None]
    rest = [name for name in lines if name not in wound]

    def at_rest(part: Model) -> Equilibrium:
        held = _held_joints(part, given)
        return _upright(stiffening(scene, held, tolerance, most, bool(given)))

    if not is_carried(model):
        found = at_rest(model)
        return found._replace(model=eqx.tree_at(lambda m: m.lines, model, found.model.lines))
    riders = carried_equilibrium(_part(model, wound, ()), tolerance, most)
    found = riders if not rest else at_rest(_part(model, rest, model.junctions))
    both = found.model.lines | riders.model.lines, riders.model.bodies
    return Equilibrium(
        eqx.tree_at(lambda m: (m.lines, m.bodies), model, both),
        jnp.maximum(found.imbalance, riders.imbalance),
        found.converged & riders.converged,
        jnp.maximum(found.iterations, riders.iterations),
    )


def _upright(found: Equilibrium) -> Equilibrium:
    """What was found, unless a touch would turn it over."""
    return found._replace(converged=found.converged & ~folded(found.model))


def _part(model: Model, names: list[str], junctions: tuple[Junction, ...]) -> Model:
    """The model with some of its lines alone, and their junctions."""
    lines = {name: model.lines[name] for name in names}
    part = lines, {name: model.ends[name] for name in names}, junctions
    return eqx.tree_at(
        lambda m: (m.lines, m.ends, m.junctions), model, part, is_leaf=lambda x: x is None
    )


def _given_places(scene: Scene, layout: Layout, model: Model, coordinates: Coordinates):
    """Places (m) at which joints are held while the start state is found, by junction."""
    given = {}
    for name, line in scene.lines.items():
        pieces = layout.of_line(name)
        if not pieces:
            continue  # an ideal line
        for end, (piece, node) in zip((line.start, line.end), layout.ends_of(name), strict=True):
            kind = model.end(piece, node)
            if isinstance(end, JoinedEnd) and end.at is not None and isinstance(kind, Joined):
                given[kind.junction] = coordinates.point(end.at)
    return given


def _laid_on_bed(scene: Scene, layout: Layout, model: Model, joints, given: set[int]):
    """First places (m) of joints that lie on the bed: straight out from the end that is on it already.

    So it is where a line from there to the joint lies stretched out and the next one is long enough
    to reach on to its own other end.
    """
    if not joints:
        return joints
    bed = seabed_of(next(iter(model.lines.values())))
    if bed is None or model.lines[next(iter(model.lines))].dimensions == 1:
        return joints
    found = list(joints)
    for index, junction in enumerate(model.junctions):
        if index in given or len(junction.members) != 2 or junction.mass is not None:
            continue
        far, lengths = _beyond(scene, layout, model, joints, junction)
        if far[0] is None or far[1] is None:
            continue
        for a, b, own, rest in ((far[0], far[1], *lengths), (far[1], far[0], *lengths[::-1])):
            across = (b - a) - bed.up * jnp.dot(bed.up, b - a)
            level = jnp.minimum(
                *(bed_under(model.lines[m], bed).level for m, _ in junction.members)
            )
            place = a + own * unit(across) + bed.up * (level - jnp.dot(bed.up, a))
            on_bed = jnp.abs(jnp.dot(bed.up, a) - bed.height) < 0.01 * own
            reaches = jnp.sum((b - place) ** 2) <= rest**2
            found[index] = jnp.where(on_bed & reaches, place, found[index])
    return found


def _hung_over_bed(scene: Scene, layout: Layout, model: Model, joints, given: set[int]):
    """First places (m) of bodies that sink, over a bed: where their two lines meet stretched out.

    From a place between the others, high over its own, a body has far to fall, and lines of many
    segments lose their way.
    """
    if not joints:
        return joints
    first = next(iter(model.lines.values()))
    bed = any_bed_of(first)
    if bed is None or first.dimensions == 1:
        return joints
    found = list(joints)
    for index, junction in enumerate(model.junctions):
        if index in given or len(junction.members) != 2 or not _may_sink(scene, layout, junction):
            continue
        (start, end), (own, rest) = _beyond(scene, layout, model, joints, junction)
        assert junction.load is not None
        if start is None or end is None:
            continue
        low = hung_over(start, end, own, rest, bed)
        found[index] = jnp.where(jnp.dot(bed.up, junction.load) <= 0.0, low, found[index])
    return found


def _may_sink(scene: Scene, layout: Layout, junction: Junction) -> bool:
    """Whether a joint is of a body with weight that the scene gives no place and no water bears."""
    if junction.mass is None or junction.load is None or junction.lift is not None:
        return False
    body = _body_of(scene, layout, junction)
    return body is not None and body.position is None


def _body_of(scene: Scene, layout: Layout, junction: Junction) -> Body | None:
    """The body of the scene that lines meet at, None where they meet at none."""
    joint = next(j for j in layout.joints if j.members == junction.members)
    body = None if joint.body is None else scene.bodies[joint.body]
    return body if isinstance(body, Body) else None


def _beyond(scene: Scene, layout: Layout, model: Model, joints, junction: Junction):
    """Where the other ends of the lines at a joint are (m), None if unknown; and their lengths (m)."""
    far, lengths = [], []
    for name, node in junction.members:
        line = next(p.line for p in layout.pieces if p.name == name)
        lengths.append(jnp.asarray(scene.lines[line].length, float))
        other = layout.ends_of(line)[1 if node == 0 else 0]
        far.append(_place(model, other, joints))
    return far, lengths


def _held_joints(model: Model, given: dict[int, Float[Array, " d"]]) -> Model:
    """The model with some of its joints held at places (m)."""
    if not given:
        return model

    def held(end):
        still = isinstance(end, Joined) and end.junction in given
        return Driven(Still(given[end.junction])) if still else end

    ends = {name: (held(start), held(end)) for name, (start, end) in model.ends.items()}
    return eqx.tree_at(lambda m: m.ends, model, ends, is_leaf=lambda x: x is None)


def _place(model: Model, end: tuple[str, int], joints) -> Float[Array, " d"] | None:
    """Where an end is (m), None where only the force on it is known."""
    kind = model.end(*end)
    return joints[kind.junction] if isinstance(kind, Joined) else held_position(model, kind)


def _pull(model: Model, end: tuple[str, int]) -> Float[Array, " d"]:
    kind = model.end(*end)
    if isinstance(kind, Loaded) and kind.force is not None:
        return kind.force
    return jnp.zeros(model.lines[end[0]].dimensions)


def _laid_between(
    line: Line, start: Float[Array, " d"], end: Float[Array, " d"]
) -> Float[Array, "d nodes"]:
    """First shape (m) of a line between two places (m)."""
    slope = slope_under(line)
    path = bent_out(line, opened_out(line, start, end), jnp.zeros_like(start), (True, True))
    path = arched(line, path)
    if slope is not None:
        return lifted(line, slope, path)
    return rested(line, start, end, path)


def _lay_out(line: Line, model: Model, outer, start, end) -> Float[Array, "d nodes"]:
    """First shape (m) of a line of whose ends one place at most is known (m)."""
    slope = slope_under(line)
    from_start = start is not None or end is None
    anchor = next(
        (place for place in (start, end) if place is not None), jnp.zeros(line.dimensions)
    )
    pull = _pull(model, outer[1 if from_start else 0])
    path = hanging_line(line, anchor, pull, from_start)
    load = _swept(line, model, path, pull)
    if load is not None:
        path = hanging_line(line, anchor, pull, from_start, load)
    path = draped(line, anchor, path, from_start)
    path = path if slope is None else laid_on_slope(slope, path, from_start)
    path = bent_out(line, path, pull, (from_start, not from_start))
    return stiffened(line, path, pull, from_start)


def _swept(
    line: Line, model: Model, path: Float[Array, "d nodes"], pull: Float[Array, " d"]
) -> Float[Array, "d nodes"] | None:
    """Weight and drag (N) on the nodes of a line that streams away from its one end; None: no current.

    It is taken to be straight, at the angle p to the current w (m/s) at which it can stay: with G the
    force on the free end and the weight together (N), n across the line and Dn the drag across it
    per metre and (m/s)^2, G . n = L Dn w^2 sin^2 p. Exact for a line under its own weight in a
    uniform current (L. Pode, David Taylor Model Basin Report 687, 1951). From the shape without
    current, which the current folds, Newton's method does not unfold a line of many segments.
    """
    if line.current is None or line.drag is None or model.up is None or model.base is None:
        return None
    weight = nodal_weight(line)
    flow = jnp.mean(line.current.velocity(model.base + model.up @ path), axis=1)
    flow, load = jax.lax.stop_gradient((flow, pull + jnp.sum(weight, axis=1)))
    along = unit(flow)
    across = unit(load - jnp.dot(load, along) * along)
    drag = jnp.sum(line.node_length) * line.drag.normal * jnp.dot(flow, flow)

    def steeper(p):
        turn = jnp.cos(p) * jnp.dot(load, across) - jnp.sin(p) * jnp.dot(load, along)
        return turn > drag * jnp.sin(p) ** 2

    p, _ = bisected(steeper, jnp.zeros(()), jnp.full((), jnp.pi), 50)
    tangent = unit(jnp.cos(p) * along + jnp.sin(p) * across)
    slip = jnp.dot(flow, tangent)
    side = flow - slip * tangent
    per_metre = line.drag.normal * size(side) * side
    per_metre = per_metre + line.drag.tangential * jnp.abs(slip) * slip * tangent
    return weight + per_metre[:, None] * line.node_length


def _joint_places(
    scene: Scene, layout: Layout, model: Model, coordinates: Coordinates
) -> list[Float[Array, " d"]]:
    """First places (m) of the junctions: a net of springs of stiffness 1 / length.

    Each junction is pulled by a unit force along its load and what hangs on it or pulls at it through
    lines that nothing else holds, so that a single line hangs at its own length. Where the scene gives
    a body's position, that is taken. None starts below the seabed.
    """
    count = len(model.junctions)
    if count == 0:
        return []
    known = [
        place for *_, end in model.outer_ends() if (place := held_position(model, end)) is not None
    ]
    # by the height of what is held, lines hang in the air or are lifted by the water
    middle = sum(known[1:], known[0]) / len(known) if known else None
    about = None if middle is None else (middle, middle)
    d = coordinates.dimensions
    matrix = 1e-9 * jnp.eye(count)
    right, pulls = jnp.zeros((count, d)), jnp.zeros((count, d))
    for name in scene.lines:
        pieces = layout.of_line(name)
        if not pieces:
            continue  # an ideal line
        ends = layout.ends_of(name)
        stiffness = 1.0 / jnp.asarray(scene.lines[name].unstretched, float)
        kinds = [model.end(*end) for end in ends]
        for this, other, far in ((0, 1, ends[1]), (1, 0, ends[0])):
            here, there = kinds[this], kinds[other]
            if not isinstance(here, Joined):
                continue
            if isinstance(there, Joined):
                matrix = matrix.at[here.junction, here.junction].add(stiffness)
                matrix = matrix.at[here.junction, there.junction].add(-stiffness)
            elif (place := held_position(model, there)) is not None:
                matrix = matrix.at[here.junction, here.junction].add(stiffness)
                right = right.at[here.junction].add(stiffness * place)
            else:
                weights = [
                    jnp.sum(nodal_weight(model.lines[p.name], about), axis=1) for p in pieces
                ]
                pulls = pulls.at[here.junction].add(sum(weights, _pull(model, far)))
    for index, junction in enumerate(model.junctions):
        if junction.load is not None:
            pulls = pulls.at[index].add(junction.load)
        if junction.lift is not None:
            pulls = pulls.at[index].add(junction.lift.weight * junction.lift.up)
    places = jax.numpy.linalg.solve(matrix, right + unit(pulls.T).T)
    result = [places[k] for k in range(count)]
    for index, junction in enumerate(model.junctions):
        body = _body_of(scene, layout, junction)
        if body is not None and body.position is not None:
            result[index] = coordinates.point(body.position)
        elif (lift := junction.lift) is not None:  # not above the water that it floats on
            result[index] = result[index] - jnp.maximum(lift.height(result[index]), 0.0) * lift.up
    bed = any_bed_of(next(iter(model.lines.values())))
    if bed is not None:
        result = [x + bed.up * jnp.maximum(bed.level(x) - bed.up @ x, 0.0) for x in result]
    return result
