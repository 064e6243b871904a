"""What rods are jerked to where something that they hang on moves at the start all at once.

Nothing has moved yet, and no finite force has had time to act: the impulses of the rods alone change
velocities. With those of ends and bodies given, all others follow from momentum and from lengths that
have no rate,

    M v - sum of u P = M v-,      u . (v_j+1 - v_j) = 0,

v- = 0, P the rods' impulses (N s), u their directions: the system of a step without its forces. Rods
that give way need time to pull, so that they have no impulse, and pass on what their mass does.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.attached import follow_rate
from lumpedcable.model.bodies import body_key
from lumpedcable.model.ends import Driven
from lumpedcable.model.forces import evaluate
from lumpedcable.model.model import Model
from lumpedcable.model.paths import Path, paths_of
from lumpedcable.model.rods import to_lines
from lumpedcable.solve.blocks import solve_blocks
from lumpedcable.solve.chains import Chain, Hub, chain_of
from lumpedcable.solve.matrices import eliminated, onto
from lumpedcable.solve.rods import (
    Lengths,
    Motion,
    assembled,
    hub_gain,
    hub_weight,
    inertia_of,
    on_course,
    pinned_of,
)

__all__ = ["jerked"]

# times the mass of its rods that a body has at least whose velocity is given: it keeps that, but where
# rods cannot follow, and a straight line between it and a fixed place has what gives way
HEAVY = 1e8
# rate over impulse, in 1 over the mass of all its rods, by which a path may miss its lengths: none, but
# that lengths may be conditions of each other, as those of a straight line between two places
LOOSE = 1e-15


def jerked(
    model: Model, t: Float[Array, ""], displacement: dict[str, Array], velocity: dict[str, Array]
) -> dict[str, Array]:
    """Velocities (m/s) just after t (s), where rods hang on what has a velocity and had none before."""
    if not any(line.inextensible for line in model.lines.values()):
        return velocity
    paths = [path for path in paths_of(model) if _pulled(model, path)]
    if not paths:
        return velocity
    found, moved = evaluate(model, t, displacement, velocity, {}, None), dict(velocity)
    for path in paths:
        moved |= _jerked_path(model, chain_of(model, path, t, found, displacement, velocity, None))
    return follow_rate(model, t, displacement, moved)


def _pulled(model: Model, path: Path) -> bool:
    """Whether something on a path may have a velocity at the start."""
    ends = [model.end(*side) for side in path.points.values()]
    driven = (end.motion for end in ends if isinstance(end, Driven))
    given = (model.bodies[name].start_velocity for name in path.bodies.values())
    return any(not motion.from_rest for motion in driven) or any(v is not None for v in given)


def _jerked_path(model: Model, chain: Chain) -> dict[str, Array]:
    size, d = chain.before.shape[1], chain.tangent.shape[0]
    mass, cross = inertia_of(model, chain)
    masses = {at: _mass(chain, hub) for at, hub in chain.hubs.items()}
    momentum = {at: masses[at] @ hub.v for at, hub in chain.hubs.items()}
    # the impulses change all of a velocity: as a kick of one second from rest
    rest = {
        at: hub._replace(mass=masses[at], v=jnp.zeros_like(hub.v)) for at, hub in chain.hubs.items()
    }
    chain = chain._replace(hubs=rest)
    weights = {
        at: hub_weight(hub, size, pinned_of(hub, None), 1.0, momentum[at], None)
        for at, hub in rest.items()
    }
    for at, target in chain.driven.items():
        weights[at] = on_course(jnp.pad(target, (0, size - d)))
    free = Motion(mass, cross, jnp.zeros_like(chain.before))
    lengths, give = _lengths(model, chain)
    system = assembled(chain, free, lengths, weights, give)
    x = solve_blocks(system.blocks, system.right, eliminated)
    found = to_lines(chain.path, x[:, :d].T)
    for at, name in chain.path.bodies.items():
        found[body_key(name)] = hub_gain(system, chain, at, None, x, 1.0)[0]
    return found


def _lengths(model: Model, chain: Chain) -> tuple[Lengths, Float[Array, " n"]]:
    """What lengths ask of velocities, and how far they may lose that to an impulse (m/s over N s)."""
    along = chain.tangent.T
    none = jnp.zeros_like(chain.spread.length)
    give = none + LOOSE / (none.size * jnp.sum(chain.spread.along))
    if any(model.lines[leg.line].give is not None for leg in chain.path.legs):
        kept = chain.spread.give == 0.0
        along = jnp.where(kept[:, None], along, 0.0)
        give = jnp.where(kept, give, 1.0)  # their row is P = 0
    return Lengths(onto(chain.first, along), onto(chain.last, along), none), give


def _mass(chain: Chain, hub: Hub) -> Float[Array, "m m"]:
    if hub.body.start_velocity is None:
        return hub.mass
    return hub.mass * (1.0 + HEAVY * jnp.sum(chain.spread.along) / hub.mass[0, 0])
