"""What is looked at while a scene moves: fields at output times, and watches at every step."""

from collections.abc import Iterator
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from lumpedcable.model.attached import follow
from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import Found, winch_of
from lumpedcable.model.cuts import LEAST
from lumpedcable.model.ends import Joined, end_name
from lumpedcable.model.energy import WORKS, energies
from lumpedcable.model.forces import evaluate
from lumpedcable.model.layout import part_names
from lumpedcable.model.line import Line, last_segments
from lumpedcable.model.model import Model
from lumpedcable.model.places import asks_for_moments
from lumpedcable.model.splices import bent_over, moments
from lumpedcable.model.state import Seen, State
from lumpedcable.model.turned import clamped_to, turned
from lumpedcable.physics.linear import pick
from lumpedcable.physics.load import Shape
from lumpedcable.physics.seam import EXTRA
from lumpedcable.physics.tips import AFTER, BEFORE
from lumpedcable.physics.vectors import dot
from lumpedcable.solve.bound import clamp_courant, courant_number
from lumpedcable.solve.end_forces import end_tension, resisted
from lumpedcable.solve.largest import reversals, stretches, tensions_of
from lumpedcable.solve.run_out import run_out

__all__ = [
    "ARRIVAL_DROP",
    "FAR",
    "Recoil",
    "Sample",
    "Watch",
    "sample",
    "tips",
    "watch",
    "watched",
    "watches",
]

FAR = {0: -1, -1: 0, BEFORE: 0, AFTER: -1}  # the other end of a line, or of its part
ARRIVAL_DROP = 0.01  # share of the start tension that must be gone for the far end to feel it
AT_ONCE = 1e-6  # of a step: times as near as that are the same, told by rounding


class Recoil(NamedTuple):
    """An end of a line that recoils once it is broken."""

    line: str
    node: int


class Watch(NamedTuple):
    """What an end has done since its break began, at `begins` (s): its peak speed (m/s), -inf before.

    `reach` is the square of its largest distance (m2) from where it was then, `place` its displacement
    there (m). `arrival` is the time at which the tension at the far end first lost 1 % of `loaded`,
    linear between steps, NaN before. That is its tension (N) when the break begins; `rest` is that at
    the start, `last` that of the step before.
    """

    peak_speed: Float[Array, ""]
    arrival: Float[Array, ""]
    last: Float[Array, ""]
    loaded: Float[Array, ""]
    rest: Float[Array, ""]
    reach: Float[Array, ""]
    begins: Float[Array, ""]
    place: Float[Array, " d"]


class Sample(NamedTuple):
    """One output time: fields by line and quantity, energies (J), end tensions (N) and checks.

    `largest` has the largest tension of all segments (N), the kinetic energy (J), what `solve.largest`
    tells of each line, and what `watched` adds; `bodies` the coordinates q and their rates of each body,
    (2, m); `measures` the numbers that the scene asks for, NaN while they do not count; `stuck` is as of
    a run; `upright` the least |cos(pitch)| so far of bodies that turn in space; `tips` how far ends have
    moved (m) and their velocities (m/s); `run_out` by trolley whether its line has come to an end;
    `rests` strain (-) and tension (N) at rest of recoiling ends, of the first sample alone.
    """

    fields: dict[str, dict[str, Array]]
    energy: dict[str, Float[Array, ""]]
    ends: dict[str, Float[Array, " 2"]]
    largest: dict[str, Float[Array, ""]]
    finite: Bool[Array, ""]
    reversed: Bool[Array, ""]
    courant: Float[Array, ""]
    stuck: Int[Array, ""]
    bodies: dict[str, Float[Array, "2 m"]]
    measures: dict[str, Float[Array, ""]]
    stopped: Bool[Array, ""]
    lost: Bool[Array, ""]
    upright: dict[str, Float[Array, ""]] = {}  # noqa: RUF012 (a default that nobody changes)
    tips: dict[str, Float[Array, "2 d"]] = {}  # noqa: RUF012
    run_out: dict[str, Bool[Array, ""]] = {}  # noqa: RUF012
    rests: dict[str, Float[Array, " 2"]] = {}  # noqa: RUF012


def watches(model: Model, y: State, recoils: tuple[Recoil, ...]) -> tuple[Watch, ...]:
    """Watches at the start."""
    result = []
    for recoil in recoils:
        far = _far_tension(model, y, recoil)
        never = jnp.full_like(far, jnp.nan)
        nothing = jnp.zeros_like(far)
        begins = _begins(model, recoil)
        peak = jnp.where(begins > 0.0, -jnp.inf, nothing)
        place = jnp.zeros_like(y.displacement[recoil.line][:, 0])
        result.append(Watch(peak, never, far, far, far, nothing, begins, place))
    return tuple(result)


def watched(seen: tuple[Watch, ...]) -> dict[str, Float[Array, ""]]:
    """Peak speeds (m/s) and squares of reaches (m2) so far, as `Sample.largest` has them.

    They are kept of every output time, so that a run that goes wrong has those of the last good one.
    """
    found = {}
    for index, one in enumerate(seen):
        found |= {f"speed {index}": one.peak_speed, f"reach {index}": one.reach}
    return found


def watch(
    model: Model,
    y: State,
    seen: tuple[Watch, ...],
    recoils: tuple[Recoil, ...],
    t: Float[Array, ""],
    dt: Float[Array, ""],
) -> tuple[Watch, ...]:
    """Watches after a step of dt that ended at t (s)."""
    result = []
    for recoil, old in zip(recoils, seen, strict=True):
        node = model.lines[recoil.line].node(recoil.node)
        speed = jnp.sqrt(jnp.sum(pick(y.velocity[recoil.line], node) ** 2))
        far = _far_tension(model, y, recoil)
        # a step that ends at the break but for rounding ends before it
        waits = t <= old.begins + AT_ONCE * dt
        ahead = jnp.minimum((old.begins - t) / dt, 0.0)  # steps from the break to now, negative
        back = ahead.astype(far.dtype)
        first = waits | (ahead > -1.0 - AT_ONCE)  # as at the break, between the steps about it
        loaded = jnp.where(first, far + back * (far - old.last), old.loaded)
        level = (1.0 - ARRIVAL_DROP) * loaded
        crossed = jnp.isnan(old.arrival) & (far < level) & ~waits
        share = (old.last - level) / jnp.where(crossed, old.last - far, 1.0)
        when = (t - dt * (1.0 - share)).astype(old.arrival.dtype)
        arrival = jnp.where(crossed, when, old.arrival)
        here = pick(y.displacement[recoil.line], node)
        place = jnp.where(first, here + back * (here - old.place), old.place)
        moved = jnp.sum((here - place) ** 2)
        peak = jnp.where((speed > old.peak_speed) & ~waits, speed, old.peak_speed)
        reach = jnp.where(moved > old.reach, moved, old.reach)
        result.append(Watch(peak, arrival, far, loaded, old.rest, reach, old.begins, place))
    return tuple(result)


def tips(model: Model, t, y: State, ends: tuple[Recoil, ...]) -> dict[str, Float[Array, "2 d"]]:
    """How far ends of lines have moved from where they started (m), and their velocities (m/s)."""
    found, place = {}, follow(model, t, y.displacement) if ends else {}
    for line, node in ends:
        at = model.lines[line].node(node)
        found[end_name(line, node)] = jnp.stack([pick(place[line], at), pick(y.velocity[line], at)])
    return found


def _begins(model: Model, recoil: Recoil) -> Float[Array, ""]:
    """When the break of a recoiling end begins (s): its own or, at a joint, the first there."""
    end = model.end(recoil.line, recoil.node)
    own = [] if end.release is None else [end.release]
    if not own and isinstance(end, Joined):
        own = [release for _, release in model.leavers(end.junction)]
    return jnp.min(jnp.stack([release.start for release in own]))


def _far_tension(model: Model, y: State, recoil: Recoil) -> Float[Array, ""]:
    """Tension (N) at the end across from the one that recoils, worked out there alone."""
    node = FAR[recoil.node]
    line = model.remembering(y.memory).lines[recoil.line]
    end, nodes = last_segments(line, node, 2)
    shape = end.shape(y.displacement[recoil.line][:, nodes])
    return end_tension(end, end.carried(shape.strain)[0], node)


def sample(
    model: Model,
    t: Float[Array, ""],
    y: State,
    quantities: tuple[str, ...],
    dt: Float[Array, ""] | None,
    stuck: Int[Array, ""],
    gains: dict[str, Float[Array, "d nodes"]],
) -> Sample:
    """Everything that is kept of one output time; `gains` are accelerations (m/s2) of lines of rods."""
    model = model.remembering(y.memory)
    found = evaluate(model, t, y.displacement, y.velocity, y.reaction, dt)
    fields, ends, whole_ends, tensions = {}, {}, {}, {}
    place = follow(model, t, y.displacement)
    model = turned(model, t, place)
    bent: dict[str, Array] = {}
    if "bending_moment" in quantities or any(map(asks_for_moments, model.measures.values())):
        bent = moments(model, t, {name: e.line.shape for name, e in found.items()})
    over = bent_over(model)
    finite = jnp.ones((), bool)
    folded, most_at_ends = {}, {}
    courant = jnp.zeros((), next(iter(y.velocity.values())).dtype)
    for name, line in model.lines.items():
        e, own = found[name].line, y.velocity[name]
        whole = y.tension[name] if line.inextensible else e.pull
        tensions[name] = whole
        every = {
            "position": place[name],
            "velocity": own,
            "tension": whole,
            "strain": e.shape.strain,
        }
        if "bending_moment" in quantities:  # a straight line has none
            every["bending_moment"] = bent.get(name, jnp.zeros_like(place[name][0]))
        kept = {key: value for key, value in every.items() if key in quantities}
        at_ends = [
            end_tension(
                line,
                whole,
                node,
                e.shape,
                resisted(line, found[name], node, own, gains.get(name)),
                met,
                (name, node) in over,
            )
            for node, met in zip(line.ends, found[name].boundaries, strict=True)
        ]
        most_at_ends[name] = jnp.max(jnp.stack(at_ends))
        if line.seam is None:
            fields[name], ends[name] = kept, jnp.stack(at_ends)
        else:
            start, end, before, after = at_ends
            first, last = part_names(name)
            fields[first], fields[last] = parts(line, kept)
            ends[first], ends[last] = jnp.stack([start, before]), jnp.stack([after, end])
            whole_ends[name] = jnp.stack([start, end])
        finite &= jnp.all(jnp.isfinite(every["position"])) & jnp.all(
            jnp.isfinite(every["velocity"])
        )
        folded[name] = _reversed(line, e.shape)
        if dt is not None:
            courant = jnp.maximum(courant, courant_number(line, e.stiffness, dt, e.shape))
    if dt is not None:
        for share in _shares_of_clamps(model, found, dt):
            courant = jnp.maximum(courant, share.astype(courant.dtype))
    stored = energies(model, t, found, y.displacement, y.velocity)
    none = {"tension": jnp.full((), jnp.nan)}  # without a line that has nodes
    largest = {"kinetic": stored["kinetic"]} | none | tensions_of(model, tensions, most_at_ends)
    largest |= stretches(model, {name: found[name].line.shape.strain for name in model.lines})
    largest |= reversals(model, folded)
    back = largest.pop("reversed", jnp.zeros(())) > 0.0
    energy = {}
    if y.work:
        energy = dict(stored)
        for kinds in y.work.values():
            for kind, value in kinds.items():
                key = f"work_{kind}" if WORKS[kind][0] > 0 else f"lost_{kind}"
                energy[key] = energy.get(key, 0.0) + jnp.sum(value)
    bodies = {}
    for name, body in model.bodies.items():
        key = body_key(name)
        bodies[name] = jnp.stack([body.reference + place[key], y.velocity[key]])
        finite &= jnp.all(jnp.isfinite(bodies[name]))
    seen = Seen(place, y.velocity, tensions, ends | whole_ends, bent)
    measures = {name: measure.value(model, t, seen) for name, measure in model.measures.items()}
    not_yet = jnp.zeros((), bool)
    return Sample(
        fields, energy, ends, largest, finite, back, courant, stuck, bodies, measures,
        stopped=not_yet, lost=not_yet, run_out=run_out(model, found, place),
    )  # fmt: skip


def parts(line: Line, fields: dict[str, Array]) -> tuple[dict[str, Array], dict[str, Array]]:
    """Fields of a line that is cut, as those of its two parts, each filled up with NaN."""
    assert line.seam is not None
    first, last, longest = {}, {}, line.segments - EXTRA - LEAST
    for key, values in fields.items():
        nodes = values.shape[-1] - line.segments
        first[key], last[key] = line.seam.parts(values, longest + nodes, bool(nodes))
    return first, last


def _reversed(line: Line, shape: Shape) -> Bool[Array, ""]:
    """Whether a segment points back at its neighbour: the mesh no longer resolves the line.

    Not where it does so at rest, as in the bottom of a narrow U, nor across a cut.
    """
    if line.dimensions == 1:
        return jnp.any(shape.strain <= -1.0)
    turned = _turned(shape.tangent) & ~_turned(line.reference_step)
    if line.seam is not None:
        gap = line.seam.gap(line.segments)
        turned &= ~(gap[1:] | gap[:-1])
    return jnp.any(turned)


def _turned(steps: Float[Array, "d n"]) -> Bool[Array, " n-1"]:
    """Which segments point back at the one before."""
    return dot(steps[:, 1:], steps[:, :-1]) < 0.0


def _shares_of_clamps(model: Model, found: Found, dt) -> Iterator[Float[Array, ""]]:
    """Shares (-) of the largest step of bodies to which lines are clamped that a winch shortens."""
    for name in model.bodies:
        clamps = clamped_to(model, name)
        if any(winch_of(model, line) is not None for line, *_ in clamps):
            lengths = {line: jnp.sum(found[line].line.shape.node_length) for line, *_ in clamps}
            yield clamp_courant(model, name, clamps, lengths, dt)
