"""Tension that a material loses with time: springs in series with dashpots, beside its law.

A rope that is pulled fast is stiffer than one that is pulled slowly, and loses energy in every cycle.
Beside the law T(e) of slow loads each branch k, a spring EA_k (N) in series with a dashpot
EA_k tau_k (N s), carries

    q_k = EA_k (e - s_k),        ds_k/dt = (e - s_k) / tau_k,

with s_k the stretch of its dashpot (-): the generalised Maxwell model, whose relaxation modulus is the
Prony series T' + sum EA_k exp(-t / tau_k) (J. D. Ferry, *Viscoelastic Properties of Polymers*, 3rd ed.
1980, chapter 1). At rest s_k = e, and the branches carry nothing.

A line that cannot push carries max(T + sum q_k, 0). Where that is 0 it folds, and its substance has the
strain e_m > e at which T(e_m) + sum EA_k (e_m - s_k) = 0, to which it shrinks back as its branches do.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.tension import AbstractTensionLaw, tension_and_stiffness

__all__ = ["Memory", "Relaxation", "Relaxed"]

NEWTON = 3
"""Steps to the strain of a folded rope; the first is exact where the law is linear."""


class Memory(NamedTuple):
    """How far the dashpots of n segments with k branches are stretched (-), (k, n).

    At an instant where `step` is None, else half a `step` (s) before.
    """

    stretch: Float[Array, "k n"]
    step: Float[Array, ""] | None = None


class Relaxed(NamedTuple):
    """What a line of n segments with k branches carries at one instant.

    `tension` (N) is that of the law and of all branches, `stiffness` (N) its slope, both 0 where it
    folds; `strain` (-) that of the substance. `now` and `after` are the dashpots' stretches (-) at that
    instant and half a step later, None where no step was given; `rate` is ds/dt (1/s) and `lost` (W per
    metre of unstretched length) what the dashpots take.
    """

    tension: Float[Array, " n"]
    stiffness: Float[Array, " n"]
    strain: Float[Array, " n"]
    now: Float[Array, "k n"]
    after: Float[Array, "k n"] | None
    rate: Float[Array, "k n"]
    lost: Float[Array, " n"]


class Relaxation(eqx.Module):
    """Branches of stiffness EA_k (N), `stiff`, that relax within times tau_k (s), `time`; both (k,)."""

    stiff: Float[Array, " k"]
    time: Float[Array, " k"]

    @property
    def branches(self) -> int:
        """Their number k."""
        return self.stiff.shape[0]

    @property
    def at_once(self) -> Float[Array, ""]:
        """What all branches add to the stiffness of the law for loads that are fast (N)."""
        return jnp.sum(self.stiff)

    def relaxed(
        self, law: AbstractTensionLaw, strain: Float[Array, " n"], memory: Memory, folds: bool
    ) -> Relaxed:
        """What a law with these branches carries at strains e (-), as its dashpots stand.

        `folds` says that it cannot push. Dashpots that are known half a step dt (s) before go with the e
        of the middle of a step,

            s_n+1/2 = s_n-1/2 + (1 - exp(-dt/tau)) (e_n - s_n-1/2),

        exact for an e that stays and of second order otherwise, and q is the mean over the step, which
        is what its impulse is: EA tau (s_n+1/2 - s_n-1/2) / dt.
        """
        stretch, step = memory
        tension, slope = tension_and_stiffness(law, strain)
        time = self.time[:, None]
        lead, share = jnp.ones_like(time), jnp.ones_like(time)
        if step is not None:
            lead = -jnp.expm1(-step / time)
            share = lead * time / step
        stiff = share * self.stiff[:, None]
        total = tension + jnp.sum(stiff * (strain - stretch), axis=0)
        slope = slope + jnp.sum(stiff)
        if folds:
            slack = total <= 0.0
            strain = jnp.where(slack, _folded(law, strain, stretch, stiff), strain)
            total, slope = jnp.where(slack, 0.0, total), jnp.where(slack, 0.0, slope)
        ahead = strain - stretch
        rate = lead * ahead / (time if step is None else step)
        after = None if step is None else stretch + lead * ahead
        now = stretch if step is None else strain - share * ahead
        lost = jnp.sum(stiff * ahead * rate, axis=0)
        return Relaxed(total, slope, strain, now, after, rate, lost)

    def half_a_step_on(self, found: Relaxed, step: Float[Array, ""]) -> Float[Array, "k n"]:
        """s (-) half a step dt (s) after the instant of `found`."""
        return found.now - jnp.expm1(-0.5 * step / self.time[:, None]) * (found.strain - found.now)

    def energy(self, found: Relaxed) -> Float[Array, " n"]:
        """sum EA_k (e - s_k)^2 / 2 (J per metre of unstretched length) in the branches' springs."""
        return 0.5 * self.stiff @ (found.strain - found.now) ** 2


def _folded(
    law: AbstractTensionLaw, strain: Float[Array, " n"], stretch: Float[Array, "k n"],
    stiff: Float[Array, "k 1"],
) -> Float[Array, " n"]:  # fmt: skip
    """The strain (-) at which a law and its branches carry nothing together, at least the given one.

    From where the branches by themselves carry nothing, which is above it, by Newton's method.
    """
    whole = jnp.sum(stiff)
    found = middle = jnp.sum(stiff * stretch, axis=0) / whole
    for _ in range(NEWTON):
        tension, slope = tension_and_stiffness(law, found)
        # a law that falls somewhere must not make the sum of slopes vanish
        slope = jnp.maximum(slope, 0.0) + whole
        found = found - (tension + whole * (found - middle)) / slope
    return jnp.maximum(found, strain)
