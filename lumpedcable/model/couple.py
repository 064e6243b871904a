"""Bodies that run on cables, and lines that winches and drums pay out: how they act on each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.bodies import body_key
from lumpedcable.model.evaluation import Evaluation, Splice
from lumpedcable.model.inertia import kinetic_energy
from lumpedcable.model.line import Line, LineForces
from lumpedcable.model.model import Model
from lumpedcable.model.passing import GIVEN, on_payout, passing_kinds
from lumpedcable.model.reels import AbstractReel, Drum
from lumpedcable.model.riders import Coupled, Rider
from lumpedcable.model.turned import clamp_force, clamped_to
from lumpedcable.model.winches import Winch
from lumpedcable.physics.coupling import (
    BodyPost,
    CableState,
    IdealCable,
    Kick,
    Posts,
    PostState,
    Pull,
)
from lumpedcable.physics.motion import velocity_of
from lumpedcable.physics.waterline import Lift
from lumpedcable.physics.weight import Weight

__all__ = [
    "Found",
    "body_force",
    "body_powers",
    "body_works",
    "coupling_energies",
    "live_line",
    "paid_out",
    "payout_force",
    "posts_of",
    "reel_of",
    "winch_name",
    "winch_of",
]

Values = dict[str, Array]


def winch_name(line: str) -> str:
    """The body that is the winch or the drum of a line; no body of a scene has such a name."""
    return f"winch of {line}"


def winch_of(model: Model, line: str) -> Winch | None:
    """The winch at an end of a line, None where it has none."""
    reel = reel_of(model, line)
    return reel if isinstance(reel, Winch) else None


def reel_of(model: Model, line: str) -> AbstractReel | None:
    """The winch or the drum at an end of a line, None where it has neither."""
    reel = model.bodies.get(winch_name(line))
    assert reel is None or isinstance(reel, AbstractReel)  # no other body has such a name
    return reel


def _reels(model: Model) -> Iterator[tuple[str, AbstractReel]]:
    """The winches and drums of the lines of a model, or of the part of one, by name."""
    for name, body in model.bodies.items():
        if isinstance(body, AbstractReel) and body.line in model.lines:
            yield name, body


def _rider(model: Model, coupled: Coupled) -> Rider:
    """The body that runs on a cable."""
    body = model.bodies[coupled.body]
    assert isinstance(body, Rider)  # nothing else does
    return body


def live_line(model: Model, name: str, displacement: Values, velocity: Values | None) -> Line:
    """A line as long as it is at the moment: its winch or drum has paid out L, and pays out dL/dt."""
    line, reel = model.lines[name], reel_of(model, name)
    if reel is None:
        return line
    # of the whole length single precision has no digits for what a strain is of it
    share = displacement[body_key(winch_name(name))][0] / reel.reference[0]
    return _longer(line, share, _growth(model, name, displacement, velocity))


def paid_out(line: Line, length: Float[Array, ""]) -> Line:
    """The line with the unstretched length (m) shared out over its segments as before."""
    return _longer(line, length / jnp.sum(line.node_length) - 1.0)


def _longer(line: Line, share: Float[Array, ""], growth: Float[Array, ""] | None = None) -> Line:
    """The line longer by a share r of its unstretched length, each of its segments alike.

    Its reference stays where it is, so that its strain there changes, to (1 + e) / (1 + r) - 1.
    """
    ratio = 1.0 + share
    return replace(
        line,
        segment_length=line.segment_length * ratio,
        node_length=line.node_length * ratio,
        reference_strain=(line.reference_strain - share) / ratio,
        growth=growth,
    )


class Found(dict[str, Evaluation]):
    """Evaluations of lines by name; what couplings do, in their order; and how lines pull at winches.

    `drawn` is that pull (N), `payouts` what comes of it with the winch's control; `held` the friction
    on bodies on the bed (N), once a kick has found it; `passed` the force on the paid-out length (N) of
    what resists along the line, by winch and kind of work. `splices` are what bends over joints.
    """

    splices: tuple[Splice, ...] = ()
    pulls: tuple[Pull, ...] = ()
    drawn: dict[str, Float[Array, ""]]
    payouts: dict[str, Float[Array, " m"]]
    held: dict[str, Float[Array, " m"]]
    passed: dict[str, dict[str, Float[Array, ""]]]

    def add_couplings(
        self,
        model: Model,
        t,
        displacement: Values,
        velocity: Values | None,
        dt: Array | None = None,
    ) -> None:
        """Work out what couplings and winches do, and add it to the forces of the lines.

        With `dt` (s) for a kick of that length, from velocities half a step before its middle.
        """
        self.held, self.passed = {}, {}
        self.pulls = tuple(
            _pull(model, coupled, t, self, displacement, velocity, dt)
            for coupled in model.couplings
        )
        self.drawn = {
            name: payout_force(model, reel, self[reel.line].line, displacement)
            + self._spliced(reel.line)
            for name, reel in _reels(model)
        }
        for coupled, pull in zip(model.couplings, self.pulls, strict=True):
            if coupled.line is not None and pull.line is not None:
                e = self[coupled.line]
                force = e.line.force + pull.line
                self[coupled.line] = e._replace(line=e.line._replace(force=force))
                winch = winch_name(coupled.line)
                if winch in self.drawn and pull.kink is not None:
                    # the kink's stiffness goes with one over the segments' length, and payout moves
                    # the line's substance past the body
                    length = jnp.sum(e.line.shape.node_length)
                    grown = sum((force.payout for force in pull.taken.values()), pull.kink)
                    self.drawn[winch] = self.drawn[winch] + grown / length
        self.payouts = {
            name: _answer(reel, name, self, velocity, t)
            for name, reel in _reels(model)
            if isinstance(reel, Winch)
        }

    def _spliced(self, line: str) -> float | Float[Array, ""]:
        """-dE/dL (N) of what bends over joints of a line: the longer it is, the softer they are."""
        bent = [each.stored * each.shares[line] for each in self.splices if line in each.shares]
        return sum(bent, 0.0) / jnp.sum(self[line].line.shape.node_length) if bent else 0.0

    def add_passing(self, model: Model, t, velocity: Values | None, middle: Values | None) -> None:
        """Add what drag, friction and waves along a line do to what is paid out (see `passing`).

        `velocity` is that of the evaluation, `middle` that at which drag acts; None at rest.
        """
        for name, reel in _reels(model):
            line = model.lines[reel.line]
            if not passing_kinds(line):
                continue
            v = None if middle is None else middle[reel.line]
            held = None if velocity is None else velocity[reel.line][:, reel.node]
            self.passed[name] = on_payout(line, self[reel.line], v, reel.node, held)
            self.drawn[name] = sum(self.passed[name].values(), self.drawn[name])
            if isinstance(reel, Winch):
                self.payouts[name] = _answer(reel, name, self, velocity, t)


def _answer(
    winch: Winch, name: str, found: Found, velocity: Values | None, t
) -> Float[Array, " m"]:
    """What comes of the pull at a winch with its control (N)."""
    if velocity is None:
        return winch.answer(found.drawn[name], None)
    return winch.answer(found.drawn[name], velocity[body_key(name)], t)


def _pull(
    model: Model, coupled: Coupled, t, found: Found, displacement: Values, velocity: Values | None,
    dt: Array | None,
) -> Pull:  # fmt: skip
    """What a coupling does."""
    body, key = _rider(model, coupled), body_key(coupled.body)
    d = body.dimensions
    place = (body.reference + displacement[key])[:d]
    speed = None if velocity is None else velocity[key][:d]
    if coupled.line is None:
        posts = posts_of(model, coupled, t, displacement, velocity)
        assert posts is not None  # only an ideal cable has no nodes
        return coupled.law.pull(t, place, speed, posts)
    own = None if velocity is None else velocity[coupled.line]
    growth, still = _growth(model, coupled.line, displacement, velocity), 0.0
    reel = reel_of(model, coupled.line)
    if reel is not None and reel.node == 0:
        still = float(model.lines[coupled.line].segments)
    e, kick = found[coupled.line], None
    if velocity is not None and dt is not None:
        inner = jnp.ones_like(e.nodes.mass_t).at[0].set(0.0).at[-1].set(0.0)
        kick = Kick(e.line.force, inner / e.nodes.mass_t, dt)
    cable = CableState(e.line.shape, own, growth, still, kick)
    return coupled.law.pull(t, place, speed, cable)


def _growth(
    model: Model, line: str, displacement: Values, velocity: Values | None
) -> Float[Array, ""] | None:
    """dL/dt over L (1/s) of a line on a winch or drum, None without one and at rest."""
    reel, key = reel_of(model, line), body_key(winch_name(line))
    if velocity is None or reel is None:
        return None
    return velocity[key][0] / (reel.reference + displacement[key])[0]


def posts_of(
    model: Model, coupled: Coupled, t, displacement: Values | None, velocity: Values | None
) -> Posts | None:
    """The posts of an ideal cable at t (s), None of another; with None as at the start, and at rest."""
    law, found = coupled.law, []
    if not isinstance(law, IdealCable):
        return None
    for post in (law.start, law.end):
        if not isinstance(post, BodyPost):
            found.append(PostState(post.position(t), velocity_of(post, t), False))
            continue
        body, key = model.bodies[post.body], body_key(post.body)
        q = body.reference if displacement is None else body.reference + displacement[key]
        v = jnp.zeros_like(q) if velocity is None else velocity[key]
        place = body.place(q, post.point)
        found.append(PostState(place, body.rate(q, v, post.point)[1], True))
    return Posts(*found)


def body_force(
    model: Model, name: str, found: Found, displacement: Values | None = None
) -> Array | None:
    """Generalised force on a body from the cable that it runs on, or on a winch from its line.

    Of a rigid body that of the ideal cables whose posts stand on it and of the lines that are clamped
    to it, at `displacement`, the start if None. None where there is neither.
    """
    body = model.bodies[name]
    if isinstance(body, Winch):
        return found.payouts[name]
    force, u = None, jnp.zeros_like(body.reference)
    u = u if displacement is None else displacement[body_key(name)]
    if clamped_to(model, name):
        shapes = {line: e.line.shape for line, e in found.items()}
        force = clamp_force(model, name, body.reference + u, shapes)
    for coupled, pull in zip(model.couplings, found.pulls, strict=True):
        law = coupled.law
        ends = (law.start, law.end) if isinstance(law, IdealCable) else ()
        for post, pushed in zip(ends, pull.posts, strict=True):
            if isinstance(post, BodyPost) and post.body == name:
                turn = body.rate(body.reference + u, jnp.zeros_like(u), post.point)[0]
                force = turn.T @ pushed if force is None else force + turn.T @ pushed
    for coupled, pull in zip(model.couplings, found.pulls, strict=True):
        if coupled.body == name:
            force = jnp.zeros_like(body.reference) if force is None else force
            force = force.at[: _rider(model, coupled).dimensions].add(pull.body)
    return force


def payout_force(
    model: Model, reel: AbstractReel, forces: LineForces, displacement: Values
) -> Float[Array, ""]:
    """What the line pulls out of its winch or drum (N): -dE/dL at fixed nodes, and of what resists.

    Strain energy U per metre gives the mean of (1 + e) T - U, weight what hangs less what it weighs at
    the post: the rope on the drum is as heavy, so that the work of weight counts from there.
    """
    line, shape = model.lines[reel.line], forces.shape
    share = shape.segment_length * jnp.ones_like(shape.strain)
    length = jnp.sum(share)
    stored = line.stored_per_metre(shape, forces.relaxed)
    density = forces.total_tension() * (1.0 + shape.strain) - stored
    force = jnp.sum(density * share) / length + _drum_weight(model, reel, displacement)
    rest = tuple(load for load in line.loads if not isinstance(load, Weight))
    for load in line.loads:
        if isinstance(load, Weight):
            force = force - load.energy(shape) / length
    if rest:

        def energy(ratio):
            scaled = shape._replace(
                segment_length=shape.segment_length * ratio, node_length=shape.node_length * ratio
            )
            return sum(load.energy(scaled) for load in rest)

        force = force - jax.grad(energy)(jnp.ones_like(length)) / length
    return force


def _drum_weight(model: Model, reel: AbstractReel, displacement: Values) -> Float[Array, ""]:
    """Potential energy (J) that a metre of line has at the post."""
    line = model.lines[reel.line]
    post = (line.reference + displacement[reel.line])[:, reel.node]
    total = jnp.zeros((), post.dtype)
    for load in line.loads:
        if isinstance(load, Weight):
            total = total - jnp.dot(load.per_length, post)
        elif isinstance(load, Lift):
            total = total + load.per_metre(post)
    return total


def coupling_energies(model: Model, found: Found) -> dict[str, Float[Array, ""]]:
    """Energies (J) of couplings by dataset."""
    total: dict[str, Float[Array, ""]] = {}
    for coupled, pull in zip(model.couplings, found.pulls, strict=True):
        name = coupled.law.energy_name
        total[name] = total[name] + pull.energy if name in total else pull.energy
    return total


def body_works(model: Model, name: str) -> tuple[str, ...]:
    """The kinds of work of a body, of what it runs on, of what hauls it and of the line it pays out."""
    body = model.bodies[name]
    mine = (coupled for coupled in model.couplings if coupled.body == name)
    kinds = [*body.works(), *(kind for coupled in mine for kind in coupled.law.works)]
    if isinstance(body, Rider) and body.path is not None:
        kinds.append("hauling")
    if isinstance(body, AbstractReel):
        kinds += ["payout", *passing_kinds(model.lines[body.line])]
    return tuple(dict.fromkeys(kinds))


def body_powers(
    model: Model, name: str, t, found: Found, displacement: Values, velocity: Values, gain: Array
) -> dict[str, Float[Array, ""]]:
    """Power (W) of each of `body_works` beyond the body's own, at t (s) and the gain of its rates."""
    body, key = model.bodies[name], body_key(name)
    q, v = body.reference + displacement[key], velocity[key]
    total: dict[str, Float[Array, ""]] = {}
    for coupled, pull in zip(model.couplings, found.pulls, strict=True):
        if coupled.body != name:
            continue
        power = dict(pull.given)
        for kind, force in pull.taken.items():
            assert coupled.line is not None  # nothing resists on an ideal cable
            power[kind] = -jnp.dot(force.body, v[: _rider(model, coupled).dimensions])
            power[kind] -= jnp.sum(force.line * velocity[coupled.line])
            growth = _growth(model, coupled.line, displacement, velocity)
            power[kind] -= 0.0 if growth is None else force.payout * growth
        total = {kind: total.get(kind, 0.0) + value for kind, value in power.items()}
    if isinstance(body, Rider) and body.path is not None and body.free is not None:
        pull = body_force(model, name, found)
        force = body.force(q, v) if pull is None else body.force(q, v) + pull
        total["hauling"] = jnp.dot((body.mass(q) @ gain - force) * (1.0 - body.free), v)
    if isinstance(body, AbstractReel):
        # what is paid out brings its energy of motion and of height with it, added mass included
        line = live_line(model, body.line, displacement, velocity)
        moving = kinetic_energy(found[body.line].nodes, velocity[body.line])
        moving = moving / jnp.sum(line.node_length)
        if isinstance(body, Drum):
            total["control"] = found.drawn[name] * v[0]
        elif isinstance(body, Winch) and body.driven:
            total["control"] = body.taken(q, v, gain, found.drawn[name], t)
        own = body.resisting(q, v)
        for kind, force in found.passed.get(name, {}).items():
            power = (force + own[kind][0] if kind in own else force) * v[0]
            total[kind] = power if kind in GIVEN else -power
        total["payout"] = v[0] * (moving + _drum_weight(model, body, displacement))
        if (slower := found[body.line].hastened) is not None:
            total["payout"] = total["payout"] + jnp.sum(slower * velocity[body.line])
    return total
