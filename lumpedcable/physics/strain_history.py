"""What a material that relaxes carries when its strain over time is known, as on a test bench."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.relaxation import Relaxation, mean_decay

__all__ = ["relaxing_tension"]

LEAST, MOST = 1e-100, 1e100
"""Times (s) that are told apart: a search may try any, and squares of these are still numbers."""


def relaxing_tension(
    relaxation: Relaxation, strain: Float[Array, " n"], time: Float[Array, " n"]
) -> Float[Array, " n"]:
    """sum q_k (N) of all branches at times t_i (s), which never fall, of strains e_i (-) there.

    Strain is straight between two times, and until the first the material was at rest at its first
    strain: q_k = 0 there. From dq/dt = EA de/dt - q / tau over h = t_i+1 - t_i follows

        q_i+1 = q_i exp(-h/tau) + EA (e_i+1 - e_i) (1 - exp(-h/tau)) tau / h,

    exactly. Two equal times are a jump, of which a branch takes EA (e_i+1 - e_i) (J. D. Ferry,
    *Viscoelastic Properties of Polymers*, 3rd ed. 1980, chapter 1: each branch's share of the integral
    of its modulus over the strain's history).
    """
    spans = jnp.diff(time)[:, None] / jnp.clip(relaxation.time, LEAST, MOST)
    gains = relaxation.stiff * jnp.diff(strain)[:, None] * mean_decay(spans)

    def on(carried, piece):
        decay, gain = piece
        now = decay * carried + gain
        return now, jnp.sum(now)

    _, total = jax.lax.scan(on, jnp.zeros_like(relaxation.stiff), (jnp.exp(-spans), gains))
    return jnp.concatenate([jnp.zeros(1), total])
