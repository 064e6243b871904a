"""The largest step at which leapfrog is stable, from what each force along a line contributes."""

from collections.abc import Mapping

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import AbstractBody
from lumpedcable.model.couple import Coupled, paid_out, posts_of, reel_of
from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.model.reels import Drum
from lumpedcable.model.riders import Rider
from lumpedcable.model.turned import Clamped, clamped_to, swing_of
from lumpedcable.model.winches import Winch
from lumpedcable.physics.contact import read
from lumpedcable.physics.coupling import Trolley
from lumpedcable.physics.load import Shape
from lumpedcable.physics.seabed import AbstractSeabed
from lumpedcable.physics.tension import stiffness_bound

__all__ = ["clamp_courant", "courant_number", "line_step_bound", "step_bound"]

LOOKS = 40
"""Times that the step of a line with branches is made longer: each halves, or so, what it lacks."""


def line_step_bound(line: Line) -> Float[Array, ""]:
    """Largest stable step (s) of one line.

    A segment between two lumps of half its mass is the stiffest element there can be:
    omega^2 = 4 S / (m l^2) with S the largest stiffness of the law (N) and, for steps as long as that,
    of what relaxes beside it; loads add theirs. Material damping has the rate g = 4 c / (m l^2), c in
    N s; resistances add theirs. Of the spread mass of rods a third moves where their ends go against
    each other, so that what loads and resistances add counts three times.
    """
    stiff = 0.0 if line.inextensible else stiffness_bound(line.law, line.max_strain)
    per_stiffness = 4.0 / (line.mass * line.segment_length**2)
    square = stiff * per_stiffness
    for load in line.loads:
        square = square + load.rate_squared(line.mass, line.segment_length)
    rate = jnp.zeros_like(square)
    if line.damping is not None:
        rate = line.damping * per_stiffness
    for resistance in line.resistances:
        rate = rate + resistance.rate(line.mass, line.segment_length)
    if line.inextensible:
        square, rate = 3.0 * square, 3.0 * rate
    if (relaxation := line.relaxation) is None:
        return jnp.min(_stable_step(square, rate))

    def longer(_, step: Float[Array, "*n"]) -> Float[Array, "*n"]:
        # branches are the less stiff the longer the step is: from below, so that each is stable
        return _stable_step(square + relaxation.in_steps(step) * per_stiffness, rate)

    first = _stable_step(square + relaxation.at_once * per_stiffness, rate)
    return jnp.min(jax.lax.fori_loop(0, LOOKS, longer, first))


def _stable_step(square: Float[Array, "*n"], rate: Float[Array, "*n"]) -> Float[Array, "*n"]:
    """Largest step (s) at which leapfrog follows an oscillation of omega^2 `square` (1/s2), damped.

    Without damping it needs omega dt <= 2. Damping that lags by half a step, of `rate`
    g = 2 zeta omega (1/s), lowers that to 2 (sqrt(1 + zeta^2) - zeta) (Belytschko, Liu & Moran 2000,
    section 6.2.4), which is dt <= 4 / (g + sqrt(g^2 + 4 omega^2)).
    """
    return 4.0 / (rate + jnp.sqrt(rate**2 + 4.0 * square))


def step_bound(model: Model) -> Float[Array, ""]:
    """Largest stable step (s) of the scene: the smallest of its lines' and bodies'."""
    bounds = [line_step_bound(line) for line in model.lines.values()]
    bounds += [body_step_bound(body) for body in model.bodies.values()]
    bounds += [coupling_step_bound(model, coupled) for coupled in model.couplings]
    bounds += [
        winch_step_bound(model.lines[body.line], body)
        for body in model.bodies.values()
        if isinstance(body, Winch)
    ]
    bounds += [
        clamp_step_bound(model, name, clamps)
        for name in model.bodies
        if (clamps := clamped_to(model, name))
    ]
    # what a drum hauls in shortens all segments: the step is that of the shortest
    bounds += [
        line_step_bound(paid_out(model.lines[body.line], body.least))
        for body in model.bodies.values()
        if isinstance(body, Drum)
    ]
    return jnp.min(jnp.stack(bounds))


def winch_step_bound(line: Line, winch: Winch) -> Float[Array, ""]:
    """Largest stable step (s) of a winch with its line, added to that of the line by itself.

    The line is a spring of stiffness S / L that a gain K makes 1 + K times as strong, and the integral
    by another share; damping and a sheave's friction have their rates.
    """
    length = jnp.sum(line.node_length)
    stiff = stiffness_bound(line.law, line.max_strain)
    stiff = stiff if line.relaxation is None else stiff + line.relaxation.at_once
    stiff = stiff / (length * winch.kilograms)
    rate = jnp.zeros_like(stiff)
    if winch.damping is not None:
        rate = rate + winch.damping / winch.kilograms
    if winch.sheave is not None:
        slope = winch.stretch * winch.tension * winch.sheave.grip / winch.sheave.fade
        if winch.damping is not None:
            # (T + c v) (exp(g tanh(v / v0)) - 1) has no slope beyond this more than at c = 0
            slope = slope + winch.damping * jnp.expm1(2.0 * winch.sheave.grip)
        rate = rate + slope / winch.kilograms
    square = 4.0 / line_step_bound(line) ** 2
    if winch.control is not None:
        square = square + stiff * (1.0 + winch.control.gain)
    return _stable_step(square, rate)


def body_step_bound(body: AbstractBody) -> Float[Array, ""]:
    """Largest stable step (s) of a body by itself at its reference, 2 / omega.

    omega^2 is at most the Frobenius norm of M^-1 K, with K the second derivatives of its energy, and the
    rate that of M^-1 C where a bed damps it.
    """
    q = body.reference
    stiffness, damping = body.stiffest(q)
    square = jnp.maximum(_frobenius(body, stiffness), 1e-300)
    if damping is None:
        return 2.0 / jnp.sqrt(square)
    return _stable_step(square, _frobenius(body, damping))


def clamp_step_bound(model: Model, name: str, clamps: list[Clamped]) -> Float[Array, ""]:
    """Largest step (s) for a body and the lines that are clamped to it, 2 / omega of all as one.

    Drums haul their lines in to their least length, where all is stiffest.
    """
    lines = {}
    for line, *_ in clamps:
        own, reel = model.lines[line], reel_of(model, line)
        lines[line] = paid_out(own, reel.least) if isinstance(reel, Drum) else own
    return 2.0 / jnp.sqrt(_clamped_square(model, name, clamps, lines))


def clamp_courant(
    model: Model, name: str, clamps: list[Clamped], lengths: Mapping[str, Array], dt: Array
) -> Float[Array, ""]:
    """The share (-) of the largest step of `clamp_step_bound`, of lines that are so long now (m)."""
    lines = {line: paid_out(model.lines[line], lengths[line]) for line, *_ in clamps}
    return 0.5 * dt * jnp.sqrt(_clamped_square(model, name, clamps, lines))


def _clamped_square(
    model: Model, name: str, clamps: list[Clamped], lines: Mapping[str, Line]
) -> Float[Array, ""]:
    """omega^2 (1/s2) of a body and the lines that are clamped to it, at most.

    With the inertia M and k = EI/s of the clamps, whose directions c turn with the body, its own omega^2
    of `body_step_bound` grows by at most sum k |dc/dq M^-1 dc/dq^T|; that of the stiffest line is added.
    """
    body = model.bodies[name]
    q = body.reference
    square = 4.0 / body_step_bound(body) ** 2
    for line, node, end in clamps:
        own = lines[line]
        assert own.bending is not None  # what is clamped bends
        turn = swing_of(body, q, end)
        turn = turn if body.free is None else turn * body.free
        give = turn @ jnp.linalg.solve(body.lightest(q), turn.T)
        stiff = own.bending.EI / own.node_length[node]
        square = square + stiff * jnp.sqrt(jnp.sum(give**2))
    stiffest = [4.0 / line_step_bound(own) ** 2 for own in lines.values()]
    return square + jnp.max(jnp.stack(stiffest))


def _frobenius(body: AbstractBody, matrix: Float[Array, "m m"]) -> Float[Array, ""]:
    """The norm of M^-1 times a matrix."""
    return jnp.sqrt(jnp.sum(jnp.linalg.solve(body.lightest(body.reference), matrix) ** 2))


def coupling_step_bound(model: Model, coupled: Coupled) -> Float[Array, ""]:
    """Largest step (s) for a body on a cable: 2 / omega of the two as a pair.

    On an ideal cable, which has nothing smaller to resolve, the thirtieth part of that: the bound is to
    give the motion and not only its stability, and the body comes nearer to a post on its way.
    On a lumped line the pair's omega^2 = k (w . w / (m h) + 1 / M) is added to that of the segments.
    """
    body = model.bodies[coupled.body]
    assert isinstance(body, Rider)
    place = body.reference[: body.dimensions]
    stiff = coupled.law.stiffness(place, posts_of(model, coupled, jnp.zeros(()), None, None))
    if coupled.line is None:
        return 2.0 / 30.0 / jnp.sqrt(stiff / body.kilograms)
    line = model.lines[coupled.line]
    assert isinstance(coupled.law, Trolley)
    # the weights on four nodes have squares that sum up to 1/2 at most, and d is least at a node: 5/9
    EI, bend = coupled.law.EI, None
    if EI is not None:
        bend = line.segment_length[0] * jnp.sqrt(coupled.law.tension / EI)
    least = read(jnp.zeros_like(line.segment_length[0]), 1, bend).shortfall
    contact = 2.0 * coupled.law.tension / (line.segment_length * least)
    pair = contact * (0.5 / (line.mass * line.segment_length) + 1.0 / body.kilograms)
    square = 4.0 / line_step_bound(line) ** 2 + jnp.max(pair)
    hertz = coupled.law.hertz
    if hertz is None or hertz.damping is None:
        return 2.0 / jnp.sqrt(square)
    rate = jnp.max(hertz.damping * (0.5 / (line.mass * line.segment_length) + 1.0 / body.kilograms))
    return _stable_step(square, rate)


def courant_number(
    line: Line, stiffness: Float[Array, " n"], dt: Float[Array, ""], shape: Shape
) -> Float[Array, ""]:
    """Largest sqrt(T'/m) dt / l over the segments (-); leapfrog is stable below 1.

    l is the length that a segment has by then: a winch that hauls in shortens all of them. With material
    damping it is the share of the largest stable step (`_stable_step`), 1 at its limit as well. Of rods,
    whose step a scene gives, dt over the step that the bed under them allows; 0 above it.
    """
    if line.inextensible:
        beds = [load for load in line.loads if isinstance(load, AbstractSeabed)]
        lying = sum((jnp.max(bed.contact(shape)) for bed in beds), jnp.zeros_like(dt))
        return lying * dt / line_step_bound(line)
    stiff = jnp.maximum(jnp.max(stiffness / shape.segment_length**2), 0.0)
    if line.damping is None:
        return jnp.sqrt(stiff / line.mass) * dt
    rate = 4.0 * line.damping / (line.mass * jnp.min(shape.segment_length) ** 2)
    return dt / _stable_step(4.0 * stiff / line.mass, rate)
