"""How fast natural modes die out, to first order in what damps them.

With C = -dF/dv at rest, the rate of change of forces with velocity, a mode phi of omega decays as
exp(-zeta omega t),

    zeta = phi . C phi / (2 omega phi . M phi)

(J. W. Strutt, Lord Rayleigh, The Theory of Sound I, 1877, section 102): to the order of zeta where modes
are apart. C has the damping of materials, of beds, of bodies and winches, and the drag of a current, by
which a small motion against it is resisted in proportion. Drag in still water goes with the square of
the motion and is none of it; nor is friction, which small motions do not overcome; what materials lose
that relax hangs on the frequency (`solve.modal_relaxing`).
"""

from collections.abc import Mapping
from dataclasses import replace

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.balance import nothing_at_ends
from lumpedcable.model.bodies import body_key
from lumpedcable.model.couple import body_force
from lumpedcable.model.forces import evaluate
from lumpedcable.model.model import Model
from lumpedcable.model.winches import Winch
from lumpedcable.physics.coupling import Trolley

__all__ = ["modal_damping"]

BEFORE = -1.0  # s: no break has begun


def modal_damping(
    model: Model,
    lines: Mapping[str, Float[Array, "k d nodes"]],
    bodies: Mapping[str, Float[Array, "k m"]],
) -> Float[Array, " k"]:
    """phi . C phi (kg/s) of modes of a model at rest at its reference.

    Args:
        model: without inextensible lines.
        lines: how its lines move in each mode, in m.
        bodies: how its bodies do, in their coordinates; those that are not there stand still.
    """
    calm = _calm(model)
    at_rest = {name: jnp.zeros_like(line.reference) for name, line in calm.lines.items()}
    at_rest |= {body_key(n): jnp.zeros_like(body.reference) for n, body in calm.bodies.items()}
    t, ends = jnp.full((), BEFORE), nothing_at_ends(calm)

    def forces(velocity):
        found = evaluate(calm, t, at_rest, velocity, ends)
        found.add_passing(calm, t, velocity, velocity)
        total = {}
        for name, e in found.items():
            drag = inertia.drag_force(e.nodes, velocity[name])
            total[name] = e.force if drag is None else e.force + drag
        for name, body in calm.bodies.items():
            force = body.force(body.reference, velocity[body_key(name)])
            pull = body_force(calm, name, found)
            force = force if pull is None else force + pull
            total[body_key(name)] = force / body.quickened if isinstance(body, Winch) else force
        return total

    def lost(motion):
        change = jax.jvp(forces, (at_rest,), (motion,))[1]
        return -sum(jnp.vdot(motion[key], change[key]) for key in motion)

    count = next(iter((lines or bodies).values())).shape[0]
    motion = {key: jnp.zeros((count, *x.shape)) for key, x in at_rest.items()}
    motion |= dict(lines) | {body_key(name): q for name, q in bodies.items()}
    return jax.lax.map(lost, motion)


def _calm(model: Model) -> Model:
    """The model without friction, without waves of the sea, and without terms for its own waves."""
    lines = {
        name: replace(line, waves=None, grip=None, sea=None) for name, line in model.lines.items()
    }
    bodies = {
        name: replace(body, sheave=None) if isinstance(body, Winch) else body
        for name, body in model.bodies.items()
    }
    couplings = tuple(
        replace(each, law=replace(each.law, friction=None, fade=None))
        if isinstance(each.law, Trolley)
        else each
        for each in model.couplings
    )
    return replace(model, lines=lines, bodies=bodies, couplings=couplings)
