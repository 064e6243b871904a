"""Rods that give way: which stretch of theirs a tension goes by.

A rod with `EA` has the tension of a mean of its stretches e (m) at the end of the step to come, now, and
at the ends of the two steps before,

    T give = (8 e_n+1 + 12 e_n + 6 e_n-1 + e_n-2) / 27.

The weights add up to 1 and their first moment about now is 0, so that the motion is of second order.
What is too stiff for the step dies out as fast as four instants let it: that moment asks the roots r of
the weights' polynomial for a sum of 1 / (1 - r) of 2, so that the largest is of size 1/2 at least, and
of size 1 for three instants; here it is (z + 1/2)^3. A step halves it, whereas a motion of 60 steps a
period loses 1e-4 of its amplitude in that period, one of 12 steps 1 %. Any step is stable: with s =
(omega dt)^2 the roots of z (z - 1)^2 + s (z + 1/2)^3 8/27 are within the unit circle. Of the kind of the
generalised-alpha methods (Chung & Hulbert, J. Appl. Mech. 60 (1993) 371), for unknown tensions.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.vectors import dot
from lumpedcable.solve.chains import Chain
from lumpedcable.solve.matrices import lengthening, onto

__all__ = ["WEIGHTS", "giving_way"]

WEIGHTS = (8 / 27, 12 / 27, 6 / 27, 1 / 27)  # of the stretch to come, now, and of the last two


def giving_way(
    chain: Chain, last: Float[Array, "2 n"] | None, ahead: Float[Array, ""]
) -> tuple[Chain, Float[Array, "2 n"]]:
    """A chain with the lengths that its rods are to have at the end of the step, and their stretches.

    Of T above e_n+1 alone is not known, so that a rod is as long then as one of another unstretched
    length that gives way by another amount. `last` are the stretches (m) of the last two instants, None
    at the start: then they go by how fast the rods stretch. Rods that do not give way keep theirs.

    Returns:
        The chain; the stretches now and before, as the next step wants them.
    """
    own, (to_come, now, before, long_before) = chain.spread, WEIGHTS
    step = chain.place.last - chain.place.first
    stretch = jnp.sqrt(dot(step, step)) - own.length
    if last is None:
        along = chain.tangent.T
        speed = lengthening(onto(chain.first, along), onto(chain.last, along), chain.before)
        last = jnp.stack([stretch - ahead * speed, stretch - 2.0 * ahead * speed])
    known = now * stretch + before * last[0] + long_before * last[1]
    length = jnp.where(own.give > 0.0, own.length - known / to_come, own.length)
    spread = own._replace(length=length, give=own.give / to_come)
    return chain._replace(spread=spread), jnp.stack([stretch, last[0]])
