"""Bodies that run on cables, and lines that winches pay out: how they act on each other."""

from collections.abc import Iterator
from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.line import Line
from lumpedcable.model.riders import Rider, Winch
from lumpedcable.physics.coupling import AbstractCoupling, CableState, Pull
from lumpedcable.physics.motion import mean_velocity_of, velocity_of
from lumpedcable.physics.weight import Weight

__all__ = [
    "Coupled",
    "body_force",
    "body_powers",
    "body_works",
    "coupling_energies",
    "line_forces",
    "live_line",
    "steered",
    "steered_gain",
    "winch_name",
    "winch_of",
]

Values = dict[str, Array]


class Coupled(eqx.Module):
    """A body that runs on a cable by a law; `line` is None where the cable has no nodes."""

    body: str = eqx.field(static=True)
    line: str | None = eqx.field(static=True)
    law: AbstractCoupling


def winch_name(line: str) -> str:
    """The body that is the winch of a line; no body of a scene has such a name."""
    return f"winch of {line}"


def winch_of(model, line: str) -> Winch | None:
    """The winch at an end of a line, None where it has none."""
    return model.bodies.get(winch_name(line))


def live_line(model, name: str, displacement: Values, velocity: Values | None) -> Line:
    """A line as long as it is at the moment: its winch has paid out L, and pays out dL/dt."""
    line, winch = model.lines[name], winch_of(model, name)
    if winch is None:
        return line
    key = body_key(winch_name(name))
    length = (winch.reference + displacement[key])[0]
    growth = None if velocity is None else velocity[key][0] / length
    return paid_out(line, length, growth)


def paid_out(line: Line, length: Float[Array, ""], growth: Float[Array, ""] | None = None) -> Line:
    """The line with the unstretched length (m) shared out over its segments as before.

    Its reference stays where it is, so that its strain there changes.
    """
    ratio = length / jnp.sum(line.node_length)
    return replace(
        line,
        segment_length=line.segment_length * ratio,
        node_length=line.node_length * ratio,
        reference_strain=(1.0 + line.reference_strain) / ratio - 1.0,
        growth=growth,
    )


def _couplings(model, body: str) -> Iterator[Coupled]:
    return (coupled for coupled in model.couplings if coupled.body == body)


def _pull(
    model, coupled: Coupled, t, found, displacement: Values, velocity: Values | None,
    middle: Array | None = None,
) -> Pull:  # fmt: skip
    """What a coupling does; `middle` are other rates of the body than those in `velocity`."""
    body, key = model.bodies[coupled.body], body_key(coupled.body)
    d = body.dimensions
    place = (body.reference + displacement[key])[:d]
    speed = None if velocity is None else (velocity[key] if middle is None else middle)[:d]
    cable = None
    if coupled.line is not None:
        line = live_line(model, coupled.line, displacement, velocity)
        own = None if velocity is None else velocity[coupled.line]
        cable = CableState(found[coupled.line].line.shape, own, line.growth)
    return coupled.law.pull(t, place, speed, cable)


def line_forces(model, t, found, displacement: Values, velocity: Values | None) -> Values:
    """Forces (N) of trolleys on the nodes of the lines that they run on, (d, n+1) by line."""
    total: Values = {}
    for coupled in model.couplings:
        if coupled.line is None:
            continue
        force = _pull(model, coupled, t, found, displacement, velocity).line
        assert force is not None
        total[coupled.line] = total[coupled.line] + force if coupled.line in total else force
    return total


def body_force(
    model, name: str, t, found, displacement: Values, velocity: Values | None,
    middle: Array | None = None,
) -> Array | None:  # fmt: skip
    """Generalised force on a body from the cable that it runs on, or on a winch from its line.

    None where there is neither.
    """
    body = model.bodies[name]
    if isinstance(body, Winch):
        return _payout_force(model, body, found, displacement, velocity)
    force = None
    for coupled in _couplings(model, name):
        pull = _pull(model, coupled, t, found, displacement, velocity, middle)
        force = jnp.zeros_like(body.reference) if force is None else force
        force = force.at[: body.dimensions].add(pull.body)
    return force


def _payout_force(model, winch: Winch, found, displacement: Values, velocity) -> Array:
    """What the line pulls out of its winch (N): -dE/dL at fixed nodes, and of what resists.

    The rope on the drum is as heavy as that which hangs at the post, so that the work of weight counts
    from there.
    """
    name = winch.line
    line = model.lines[name]
    key = body_key(winch_name(name))
    length = (winch.reference + displacement[key])[0]

    def energy(length):
        live = paid_out(line, length)
        shape = live.shape(displacement[name])
        loads = (load.energy(shape) for load in live.loads)
        return sum(loads, live.stored_energy(shape))

    force = -jax.grad(energy)(length) + _drum_weight(model, winch, displacement)
    e = found[name].line
    extra = e.total_tension() - e.tension  # what damping and viscosity add
    live = live_line(model, name, displacement, velocity)
    return (force + jnp.sum(extra * (1.0 + e.shape.strain) * live.segment_length) / length)[None]


def _drum_weight(model, winch: Winch, displacement: Values) -> Float[Array, ""]:
    """Potential energy (J) that a metre of line has at the post."""
    line = model.lines[winch.line]
    post = (line.reference + displacement[winch.line])[:, winch.node]
    total = jnp.zeros((), post.dtype)
    for load in line.loads:
        if isinstance(load, Weight):
            total = total - jnp.dot(load.per_length, post)
    return total


def coupling_energies(model, t, found, displacement: Values) -> dict[str, Float[Array, ""]]:
    """Energies (J) of couplings by dataset."""
    total: dict[str, Float[Array, ""]] = {}
    for coupled in model.couplings:
        pull = _pull(model, coupled, t, found, displacement, None)
        name = coupled.law.energy_name
        total[name] = total[name] + pull.energy if name in total else pull.energy
    return total


def body_works(model, name: str) -> tuple[str, ...]:
    """The kinds of work of a body, of what it runs on, of what hauls it and of its winch."""
    body = model.bodies[name]
    kinds = [*body.works(), *(kind for c in _couplings(model, name) for kind in c.law.works)]
    if isinstance(body, Rider) and body.path is not None:
        kinds.append("hauling")
    if isinstance(body, Winch):
        kinds.append("payout")
    return tuple(dict.fromkeys(kinds))


def body_powers(
    model, name: str, t, found, displacement: Values, velocity: Values, gain: Array
) -> dict[str, Float[Array, ""]]:
    """Power (W) of each of `body_works` beyond those of the body itself, at its rates' gain."""
    body, key = model.bodies[name], body_key(name)
    q, v = body.reference + displacement[key], velocity[key]
    total: dict[str, Float[Array, ""]] = {}
    for coupled in _couplings(model, name):
        for kind, power in _pull(model, coupled, t, found, displacement, velocity).work.items():
            total[kind] = total[kind] + power if kind in total else power
    if isinstance(body, Rider) and body.path is not None:
        pull = body_force(model, name, t, found, displacement, velocity)
        force = body.force(q, v) if pull is None else body.force(q, v) + pull
        held = (body.mass(q) @ gain - force) * (1.0 - body.free)
        total["hauling"] = jnp.dot(held, v)
    if isinstance(body, Winch):
        # what is paid out brings its energy of motion and of height with it
        line = live_line(model, body.line, displacement, velocity)
        share = line.node_length / jnp.sum(line.node_length)
        squares = jnp.sum(share * jnp.sum(velocity[body.line] ** 2, axis=0))
        moving = 0.5 * line.mass * squares
        total["payout"] = v[0] * (moving + _drum_weight(model, body, displacement))
    return total


# --- coordinates whose motion is given ------------------------------------------------------


def _hauled(model) -> Iterator[tuple[str, Rider]]:
    for name, body in model.bodies.items():
        if isinstance(body, Rider) and body.path is not None:
            yield body_key(name), body


def steered(model, t, dt: Float[Array, ""] | None, velocity: Values) -> Values:
    """The same velocities, but hauled bodies as they are hauled: at t (s), or over the dt (s) after."""
    moved = dict(velocity)
    for key, body in _hauled(model):
        own = velocity[key]
        given = velocity_of(body.path, t) if dt is None else mean_velocity_of(body.path, t, dt)
        moved[key] = jnp.where(body.free > 0.0, own, given.astype(own.dtype))
    return moved


def steered_gain(model, t, gains: Values) -> Values:
    """The same accelerations, but of hauled coordinates those of their paths."""
    moved = dict(gains)
    for key, body in _hauled(model):

        def speed(s, path=body.path):
            return velocity_of(path, s)

        given = jax.jvp(speed, (t,), (jnp.ones_like(t),))[1].astype(gains[key].dtype)
        moved[key] = jnp.where(body.free > 0.0, gains[key], given)
    return moved
