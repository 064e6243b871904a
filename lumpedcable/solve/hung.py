"""A first place for a body that sinks between two lines over a bed."""

import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.seabed import AbstractSeabed
from lumpedcable.physics.vectors import size, unit

__all__ = ["hung_over"]


def hung_over(
    start: Float[Array, " d"],
    end: Float[Array, " d"],
    first: Float[Array, ""],
    second: Float[Array, ""],
    bed: AbstractSeabed,
) -> Float[Array, " d"]:
    """Where two lines from places (m), of lengths `first` and `second` (m), first meet at a body.

    Under their chord, both stretched out; where that is below the bed, on the bed over it; and where
    that is beyond the end, since the first is so long, on the bed in between.
    """
    chord = end - start
    long = size(chord)
    along = unit(chord)
    share = (long**2 + first**2 - second**2) / (2.0 * jnp.maximum(long, 1e-300))
    share = jnp.clip(share, 0.0, first)
    down = unit(jnp.dot(bed.up, along) * along - bed.up)
    low = start + share * along + jnp.sqrt(jnp.maximum(first**2 - share**2, 0.0)) * down
    ground = bed.level(low)
    over, far = (x - start - bed.up * jnp.dot(bed.up, x - start) for x in (low, end))
    beyond = jnp.dot(over, far) > jnp.dot(far, far)
    lies = jnp.where(beyond, _between(start, far, first, second, bed.up, ground), low)
    lies = lies + bed.up * (bed.level(lies) - jnp.dot(bed.up, lies))
    return jnp.where(jnp.dot(bed.up, low) < ground, lies, low)


def _between(
    start: Float[Array, " d"],
    far: Float[Array, " d"],
    first: Float[Array, ""],
    second: Float[Array, ""],
    up: Float[Array, " d"],
    ground: Float[Array, ""],
) -> Float[Array, " d"]:
    """A place (m) on level ground, as far along the way `far` (m) to the end as the first is a share."""
    high = jnp.dot(up, start) - ground
    most = jnp.sqrt(jnp.maximum(first**2 - high**2, 0.0))
    along = jnp.minimum(size(far) * first / (first + second), most)
    return start + unit(far) * along - high * up
