"""What bodies that run on lines, and winches that keep a tension, bring into natural modes.

Lines, trolleys and paid-out lengths L act on each other through the nodes next to a trolley and through
all nodes of a line that grows, so that K is the derivative of the whole residual of statics. A
winch has the mass m L / 3 + J / r^2 that it has in dynamics. With a gain g its drive multiplies what
the line pulls too much by 1 + g / (1 + e): the drum then is as much lighter, and K stays symmetric.
What a drive integrates takes no part.

A trolley that nothing holds along its line is at rest only where the line is level under it; elsewhere
it is held along the line's span. A winch with friction at its sheave is held as well: small motions do
not overcome that, and leave the line as long as it is.
"""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.attached import pull_of_lines
from lumpedcable.model.bodies import body_key
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net
from lumpedcable.model.riders import Rider
from lumpedcable.model.winches import Winch
from lumpedcable.physics.coupling import IdealCable, Trolley
from lumpedcable.solve.carried import Unknowns, dimensions_of, span_of
from lumpedcable.solve.modal_bodies import Floating, resting

__all__ = ["Carried", "carried_motion", "carried_rest"]

SWING = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0))  # roll, pitch and yaw of the two angles of a hanger
AT_REST = 1e-6  # of its line's tension: what may be left on a trolley that rests


class Carried(NamedTuple):
    """K of a whole model, and what moves beside its nodes: bodies and winches, by name.

    stiffness (n, n): of all coordinates of places of the net, then of bodies, then of winches, by name,
    in N/m, N and N m; ends of lines do not go with the bodies yet. rolling: by trolley, the force (N)
    along the line's span against which it is held, 0 where it rests.
    """

    stiffness: Float[Array, "n n"]
    bodies: dict[str, Floating]
    winches: dict[str, Floating]
    rolling: dict[str, Float[Array, ""]]


def carried_rest(model: Model, net: Net) -> Float[Array, "places d"]:
    """Net force (N) on every node of the net at rest, as trolleys and winches act; 0 where held."""
    unknowns = Unknowns(net, (), dimensions_of(model))
    return unknowns.residual(model, jnp.zeros(unknowns.size)).reshape(net.size, -1)


def carried_motion(model: Model, net: Net, outlines: Mapping[str, Float[Array, "p d"]]) -> Carried:
    """Everything at its reference, which is rest; rigid bodies that move have `outlines` (m)."""
    d = dimensions_of(model)
    # by name, the order in which a compiled program returns what it tells by name
    every = dict(sorted(model.bodies.items()))
    movers = {n: body for n, body in every.items() if isinstance(body, Rider) or n in outlines}
    movers |= {n: body for n, body in every.items() if isinstance(body, Winch)}
    slots = tuple(
        (name, way) for name, body in movers.items() for way in jnp.eye(body.reference.size)
    )
    unknowns = Unknowns(net if model.lines else None, slots, d)
    own, at = {}, unknowns.nodal
    for name, body in movers.items():
        own[name] = slice(at, at + body.reference.size)
        at += body.reference.size

    def on_places(forces):
        return forces[: unknowns.nodal].reshape(-1, d)

    def force(x):
        acting, moved = unknowns.forces(model, x), unknowns.split(model, x)
        # what the pull itself changes by is in the forces on the ends
        pulls = jax.lax.stop_gradient(on_places(acting))
        for name in outlines:
            q = model.bodies[name].reference + moved[body_key(name)]
            acting = acting.at[own[name]].add(pull_of_lines(model, net, name, pulls, q))
        return acting, acting

    slope, still = jax.jacfwd(force, has_aux=True)(jnp.zeros(unknowns.size))
    lighter = jnp.ones(unknowns.size)
    bodies, winches, rolling = {}, {}, {}
    for name, body in movers.items():
        left = still[own[name]]
        if isinstance(body, Winch):
            lighter = lighter.at[own[name]].set(1.0 / body.quickened)
            winches[name] = _winch(body, d)
        elif isinstance(body, Rider):
            bodies[name], rolling[name] = _rider(body, left, *_on(model, name))
        else:
            bodies[name] = resting(model, net, name, on_places(still), outlines[name], left)
    return Carried(-lighter[:, None] * slope, bodies, winches, rolling)


def _on(model: Model, name: str) -> tuple[Float[Array, ""], Float[Array, " d"]]:
    """The tension (N) of the line that a body runs on, and the level direction of its span."""
    law = next(coupled.law for coupled in model.couplings if coupled.body == name)
    assert isinstance(law, IdealCable | Trolley)  # there is no other
    return law.tension, span_of(model, name)


def _rider(
    body: Rider, left: Float[Array, " m"], tension: Float[Array, ""], span: Float[Array, " d"]
) -> tuple[Floating, Float[Array, ""]]:
    """A trolley with its cargo, on which the forces `left` act; and the force along its line's span
    against which it is held."""
    q, d = body.reference, body.dimensions
    free = jnp.ones_like(q) if body.free is None else body.free
    along = jnp.abs(jnp.dot((free * left)[:d], span))
    rolls = along > AT_REST * tension

    def points(q):
        return jnp.stack([q[:d], body.centre(q)])

    mine = Floating(
        free=free,
        mass=body.mass(q),
        stiffness=jnp.zeros((q.size, q.size)),
        ends=jnp.zeros((0, d, q.size)),
        outline=points(q),
        moves=jax.jacfwd(points)(q),
        doubt=jnp.zeros_like(q),
        away=jnp.where(rolls, jnp.zeros_like(q).at[:d].set(span), 0.0),
        turns=None if d == 2 and q.size > d else jnp.array(SWING)[: q.size - d],
    )
    return mine, jnp.where(rolls, along, 0.0)


def _winch(body: Winch, d: int) -> Floating:
    """The length that a winch has paid out, with the mass that it has under its drive."""
    q = body.reference
    slides = 1.0 if body.sheave is None else jnp.where(body.sheave.grip > 0.0, 0.0, 1.0)
    return Floating(
        free=jnp.zeros_like(q).at[0].set(slides),
        mass=body.mass(q).at[0, 0].divide(body.quickened),
        stiffness=jnp.zeros((q.size, q.size)),
        ends=jnp.zeros((0, d, q.size)),
        outline=jnp.zeros((0, d)),
        moves=jnp.zeros((0, d, q.size)),
        doubt=jnp.zeros_like(q),
    )
