"""Energies of a model and the powers that change them: the account that must close.

E(t) = kinetic + strain + potential of every load. Work of the ends, drag, resistances, damping,
viscosity and the dispersion correction change it; so does added mass when a line turns or leaves the
water, because Morison's inertia force m_a a_n is not the rate of change of the momentum m_a v_n.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.attached import attached_ends
from lumpedcable.model.bodies import body_key
from lumpedcable.model.correction import end_gain
from lumpedcable.model.couple import Found, body_powers, body_works, coupling_energies, live_line
from lumpedcable.model.ends import Driven
from lumpedcable.model.evaluation import Evaluation
from lumpedcable.model.inertia import end_matrices
from lumpedcable.model.line import Line, strain_rate
from lumpedcable.model.model import Model, Vectors
from lumpedcable.model.rods import line_drag, line_energy
from lumpedcable.model.turned import clamp_power, turned
from lumpedcable.physics.afloat import BodyLift
from lumpedcable.physics.bending import Bending
from lumpedcable.physics.linear import pick
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.vectors import dot

__all__ = ["WORKS", "empty_body_work", "empty_work", "energies", "powers", "works_of"]

# kind -> (sign in the balance, long name)
WORKS = {
    "ends": (1.0, "work done on the line by what holds or moves its ends"),
    "added_mass": (1.0, "work of added mass that turns, leaves the water or meets a current"),
    "drag": (-1.0, "energy given to the fluid by drag"),
    "hauling": (1.0, "work done on bodies by what hauls them along a line"),
    "waves": (1.0, "work done on free ships and lines by waves"),
    "payout": (1.0, "energy of motion and height of the line that a winch or drum pays out"),
    "winch": (-1.0, "energy dissipated by winches"),
    "control": (
        -1.0,
        "energy taken by the drives of winches beyond their set tension, of drums and of ships",
    ),
    "hull": (-1.0, "energy given to the water by hulls"),
    "friction": (
        -1.0,
        "energy dissipated by friction of lines and bodies on the bed and of trolleys and sheaves",
    ),
    "contact": (-1.0, "energy dissipated by the seabed and by wheels on lines"),
    "damping": (-1.0, "energy dissipated by the material"),
    "relaxation": (-1.0, "energy lost as the material relaxes"),
    "viscosity": (-1.0, "energy dissipated by the shock viscosity"),
    "correction": (-1.0, "energy taken by the dispersion correction"),
    "stepping": (-1.0, "energy taken by the finite time step where the tension law curves"),
}


def works_of(line: Line, stepping: bool) -> tuple[str, ...]:
    """The kinds of work that a line has, in the order of `WORKS`; `stepping` only for leapfrog."""
    if line.inextensible:
        stepping = line.give is not None
    present = {
        "ends": True,
        "added_mass": _changes_added_mass(line),
        "drag": line.drag is not None,
        "waves": line.sea is not None,
        "friction": line.grip is not None,
        **{resistance.work_name: True for resistance in line.resistances},
        "damping": line.damping is not None,
        "relaxation": line.relaxation is not None,
        "viscosity": line.waves is not None,
        "correction": line.waves is not None and line.waves.corrected,
        "stepping": stepping,
    }
    return tuple(kind for kind in WORKS if present.get(kind, False))


def empty_body_work(model: Model, name: str) -> dict[str, Array]:
    """Accumulators of a body, all zero (J)."""
    dtype = model.bodies[name].reference.dtype
    return {kind: jnp.zeros((), dtype) for kind in body_works(model, name)}


def empty_work(line: Line, stepping: bool) -> dict[str, Array]:
    """Accumulators, all zero (J): per node, per segment, or one number for the ends."""
    dtype = line.reference.dtype
    if line.inextensible:
        return {kind: jnp.zeros((), dtype) for kind in works_of(line, stepping)}
    nodes, segments = jnp.zeros(line.segments + 1, dtype), jnp.zeros(line.segments, dtype)
    nodal = ("drag", "added_mass", "waves", "friction")
    per = {"ends": jnp.zeros((), dtype)} | dict.fromkeys(nodal, nodes)
    per |= {resistance.work_name: nodes for resistance in line.resistances}
    return {kind: per.get(kind, segments) for kind in works_of(line, stepping)}


def powers(
    model: Model,
    t: Float[Array, ""],
    found: Found,
    displacement: Vectors,
    before: Vectors,
    middle: Vectors,
    after: Vectors,
    dt: Float[Array, ""] | None,
    friction: Vectors | None = None,
    tension: dict[str, Float[Array, " n"]] | None = None,
) -> dict[str, dict[str, Array]]:
    """Power of each kind of work (W) at the velocities `middle` (m/s), by line.

    `before` and `after` are the velocities half a step to either side of a kick of length dt (s); an
    integrator without steps of its own gives accelerations (m/s2) as `after` and dt None. `friction`
    are the forces (N) on bodies that rest on a bed, where `found` does not have them, and, by
    inextensible line, the power (W) of what moves its ends. `tension` is that of such lines (N).
    """
    result, friction = {}, found.held | (friction or {})
    for name in model.lines:
        line = live_line(model, name, displacement, middle)
        e, v = found[name], middle[name]
        if line.inextensible:
            result[name] = _rod_powers(line, e, v, (tension or {}).get(name))
            moved = friction.get(name, jnp.zeros((), v.dtype))
            result[name]["ends"] = result[name]["ends"] + moved
            continue
        kinds = works_of(line, dt is not None)
        gain = after[name] if dt is None else (after[name] - before[name]) / dt
        rate = strain_rate(line, e.line.shape, v) * line.segment_length
        drag = inertia.drag_force(e.nodes, v)
        power: dict[str, Array] = {"ends": _end_power(model, name, t, e, v, gain, drag)}
        if "added_mass" in kinds:
            power["added_mass"] = _changing(line, e, v, t)
        if drag is not None:
            power["drag"] = -dot(drag, v)
        if e.push is not None:
            power["waves"] = dot(e.push, v)
        for resistance, force in zip(line.resistances, e.line.resistances, strict=True):
            taken = -dot(force, v)
            kind = resistance.work_name
            power[kind] = power[kind] + taken if kind in power else taken
        if line.grip is not None:  # a kick finds it, an instant has none
            power["friction"] = jnp.zeros_like(v[0]) if e.grip is None else -dot(e.grip, v)
        if e.line.damping is not None:
            power["damping"] = e.line.damping * rate
        if e.line.relaxed is not None:
            power["relaxation"] = e.line.relaxed.lost * line.segment_length
        if e.line.waves is not None:
            power["viscosity"] = e.line.waves.viscosity * rate
            if e.line.waves.correction is not None:
                power["correction"] = e.line.waves.correction * rate
                power["correction"] -= _end_gain_power(line, e, v, dt)
        if dt is not None:
            power["stepping"] = _stepping(line, e, before[name], after[name], dt)
        result[name] = {kind: power[kind] for kind in kinds}
    for splice in found.splices:
        if splice.power is not None:
            part = next(iter(splice.forces))
            result[part]["ends"] = result[part]["ends"] + splice.power
    for name, node, end in attached_ends(model):
        if end.release is None:
            continue
        # what holds an end while it breaks away from a body pulls that the other way
        key, hold = body_key(end.body), found[name].ends[0 if node == 0 else 1]
        assert hold is not None
        body = model.bodies[end.body]
        _, speed, _ = body.rate(body.reference + displacement[key], middle[key], end.point)
        given = jnp.where(end.release.begun(t), jnp.dot(hold, speed), 0.0)
        result[name]["ends"] = result[name]["ends"] - given
    for name, body in model.bodies.items():
        key = body_key(name)
        q, v = body.reference + displacement[key], middle[key]
        forces = body.resisting(q, v, t)
        power = {kind: WORKS[kind][0] * jnp.dot(f, v) for kind, f in forces.items()}
        for kind, changing in body.changing(q, v, t).items():
            power[kind] = power.get(kind, 0.0) + changing
        if name in friction:
            power["friction"] = -jnp.dot(friction[name], v)
        gain = after[key] if dt is None else (after[key] - before[key]) / dt
        result[key] = power | body_powers(model, name, t, found, displacement, middle, gain)
    return result


def _rod_powers(
    line: Line, e: Evaluation, v, tension: Float[Array, " n"] | None
) -> dict[str, Array]:
    """The powers (W) of an inextensible line, one number each.

    Rods that give way carry the `tension` (N) of a mean of their lengths over some instants: what it
    does beyond that of their length now is the step's.
    """
    shape = e.line.shape
    pulled = [(n, f) for n, f in zip(line.ends, e.ends, strict=True) if f is not None]
    power = {"ends": sum((jnp.dot(f, v[:, n]) for n, f in pulled), jnp.zeros((), v.dtype))}
    if line.added_mass is not None:
        # v . (dM/dt) v / 2, its rods turning as their ends move
        def energy(step):
            return line_energy(line, step / jnp.sqrt(dot(step, step)), v)

        step = shape.tangent * shape.length
        power["added_mass"] = jax.jvp(energy, (step,), (v[:, 1:] - v[:, :-1],))[1]
    if line.drag is not None:
        power["drag"] = -jnp.sum(line_drag(line, shape.tangent, v, e.nodes.flow) * v)
    if e.push is not None:
        power["waves"] = jnp.sum(e.push * v)
    for resistance, force in zip(line.resistances, e.line.resistances, strict=True):
        kind = resistance.work_name
        power[kind] = power.get(kind, 0.0) - jnp.sum(force * v)
    if e.grip is not None:
        power["friction"] = -jnp.sum(e.grip * v)
    if line.give is not None:
        assert tension is not None
        rate = dot(v[:, 1:] - v[:, :-1], shape.tangent)
        own = (shape.length / line.kept - 1.0) / line.give
        power["stepping"] = jnp.sum((tension - own) * rate)
    return power


def _end_power(model: Model, name: str, t, e: Evaluation, v, gain, drag) -> Float[Array, ""]:
    total = jnp.zeros((), v.dtype)
    line = model.lines[name]
    for side, force in zip(line.ends, e.ends, strict=True):
        node, end = line.node(side), model.end(name, side)
        if force is not None:
            total = total + jnp.dot(force, pick(v, node))
        if isinstance(end, Driven):
            assert isinstance(node, int)  # no line is held at a cut
            mass, _, _ = end_matrices(e.nodes, node, v[:, node])
            push = mass @ gain[:, node] - e.force[:, node]
            if drag is not None:
                push = push - drag[:, node]
            if end.release is not None:
                # what still holds it while it breaks is among the known forces
                push = jnp.where(end.release.begun(t), 0.0, push)
            total = total + jnp.dot(push, v[:, node])
        given = clamp_power(model, (name, side), end, t, e.line.shape)
        total = total if given is None else total + given
    return total


def _end_gain_power(line: Line, e: Evaluation, v, dt) -> Float[Array, " n"]:
    """Power (W) that the correction of a loaded end node adds, booked on the end segments."""
    result = jnp.zeros(line.segments, v.dtype)
    for end in line.ends:
        more = end_gain(line, e, end, dt)
        if more is not None:
            node, segment = line.node(end), line.segment(end)
            push = pick(e.nodes.mass_t, node) * more
            power = pick(result, segment) + jnp.dot(push, pick(v, node))
            result = place_at_end(result, segment, power)
    return result


def _stepping(line: Line, e: Evaluation, before, after, dt) -> Float[Array, " n"]:
    """What leapfrog's quadrature of T de misses (W), from its leading term.

    Leapfrog exchanges sum (T_n + T_n+1) / 2 de between kinetic and strain energy, the trapezoidal
    rule. Its error is sum (T'_n - T'_n+1) de^2 / 12; summed by parts, each kick contributes
    T'_n (de_+^2 - de_-^2) / 12 with de = g dt before and after it. Small and reversible in a smooth
    wave, a loss in a front that passes a segment in a few steps.
    """
    less, more = (strain_rate(line, e.line.shape, v) for v in (before, after))
    return e.line.stiffness * line.segment_length * dt * (less**2 - more**2) / 12.0


def _changes_added_mass(line: Line) -> bool:
    """Whether the water that a line takes along can change: as it turns, or leaves the water."""
    if line.added_mass is None:
        return False
    return line.dimensions > 1 or line.waterline is not None


def _changing(line: Line, e: Evaluation, v: Float[Array, "d nodes"], t) -> Float[Array, " nodes"]:
    """v . (dM/dt) v / 2 of the added mass at each node (W)."""
    total = jnp.zeros_like(v[0]) if e.nodes.tangent is None else _turning(e, v, line)
    if line.waterline is None:
        return total
    assert line.added_mass is not None
    place = e.line.shape.position

    def wet(t, place):
        return line.wet(e.line.shape._replace(position=place), t)

    t = jnp.asarray(t, place.dtype)
    more = 0.5 * jax.jvp(wet, (t, place), (jnp.ones_like(t), v))[1]
    tangential = line.added_mass.tangential
    if e.nodes.tangent is None:
        return total if tangential is None else total + more * tangential * dot(v, v)
    along, across = e.nodes.split(v)
    total = total + more * line.added_mass.normal * dot(across, across)
    return total if tangential is None else total + more * tangential * along**2


def _turning(e: Evaluation, v: Float[Array, "d nodes"], line: Line) -> Float[Array, " nodes"]:
    """v . (dM/dt) v / 2 of the added mass at each node (W)."""
    assert e.nodes.tangent is not None
    shape = e.line.shape
    across = v[:, 1:] - v[:, :-1]
    spin = (across - shape.tangent * dot(across, shape.tangent)) / shape.length
    if line.seam is not None:
        spin = jnp.where(line.seam.gap(line.segments), 0.0, spin)
    total = shape.tangent[:, 1:] + shape.tangent[:, :-1]
    size = jnp.sqrt(dot(total, total))
    size = jnp.where(size < 1e-6, 1.0, size)
    inner = (spin[:, 1:] + spin[:, :-1]) / size
    t = e.nodes.tangent
    rate = jnp.concatenate([spin[:, :1], inner, spin[:, -1:]], axis=1)
    rate = rate - t * dot(rate, t)
    extra = e.nodes.mass_n - e.nodes.mass_t
    return -extra * dot(rate, v) * dot(t, v)


def energies(
    model: Model, t: Float[Array, ""], found: Found, displacement: Vectors, velocity: Vectors
) -> dict[str, Float[Array, ""]]:
    """Kinetic, strain and potential energies (J) of the whole scene at t (s)."""
    total: dict[str, Float[Array, ""]] = {}

    def add(kind: str, value: Float[Array, ""]):
        total[kind] = total[kind] + value if kind in total else value

    model = turned(model, t, displacement)
    for name in model.lines:
        line = live_line(model, name, displacement, None)
        e = found[name]
        if line.inextensible:
            add("kinetic", line_energy(line, e.line.shape.tangent, velocity[name]))
        else:
            add("kinetic", inertia.kinetic_energy(e.nodes, velocity[name]))
        add("strain", line.stored_energy(e.line.shape))
        for load in line.loads:
            add(load.energy_name, load.energy(e.line.shape))
    for splice in found.splices:
        add(Bending.energy_name, splice.stored)
    for index, junction in enumerate(model.junctions):
        name, side = model.carrier(index)
        node = model.lines[name].node(side)
        v, x = pick(velocity[name], node), pick(found[name].line.shape.position, node)
        if junction.mass is not None:
            add("kinetic", 0.5 * junction.mass * jnp.dot(v, v))
        if junction.load is not None:
            add("gravitational", -jnp.dot(junction.load, x))
        if junction.lift is not None:
            add(BodyLift.energy_name, junction.lift.energy(x))
    for name, body in model.bodies.items():
        key = body_key(name)
        q, v = body.reference + displacement[key], velocity[key]
        add("kinetic", body.kinetic(q, v, t))
        for kind, value in body.stored(q).items():
            add(kind, value)
    for kind, value in coupling_energies(model, found).items():
        add(kind, value)
    return total
