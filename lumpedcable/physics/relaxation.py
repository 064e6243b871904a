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
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.precision import rounded_off
from lumpedcable.physics.tension import AbstractTensionLaw, TensionOnly, tension_and_stiffness

__all__ = ["Memory", "Relaxation", "Relaxed", "mean_decay"]

LOOKS, AGAIN = 24, 2
"""Times that the strain of a folded rope is looked for, and from where it was a step before."""
SMALL = 1e-3
"""h / tau below which the mean of a decay is a series: its slope is a difference of large numbers."""
TINY = 1e-30  # N, for branches without any stiffness


class Memory(NamedTuple):
    """How far the dashpots of n segments with k branches are stretched (-), (k, n).

    At an instant where `step` is None, else half a `step` (s) before; `guess` (n,) is the strain (-)
    that the substance had a step ago, and `low` (k, n) what rounding has left out of the stretches (-),
    None where that is not asked for.
    """

    stretch: Float[Array, "k n"]
    step: Float[Array, ""] | None = None
    guess: Float[Array, " n"] | None = None
    low: Float[Array, "k n"] | None = None


class Relaxed(NamedTuple):
    """What a line of n segments with k branches carries at one instant.

    `tension` (N) is that of the law and of all branches, `stiffness` (N) its slope, both 0 where it
    folds; `strain` (-) that of the substance. `now` are the dashpots' stretches (-) at that instant,
    `after` is the memory half a step later, None where no step was given; `rate` is ds/dt (1/s) and
    `lost` (W per metre of unstretched length) what the dashpots take.
    """

    tension: Float[Array, " n"]
    stiffness: Float[Array, " n"]
    strain: Float[Array, " n"]
    now: Float[Array, "k n"]
    after: Memory | None
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

    def in_steps(self, step: Float[Array, "*n"]) -> Float[Array, "*n"]:
        """Stiffness (N) of all branches for an e that turns with every step dt (s), shaped as dt.

        Then s_n+1/2 = (-1)^n tanh(dt / (2 tau)) e, and it is sum EA (2 tau / dt) tanh(dt / (2 tau)): EA
        where steps are short beside tau, that of a dashpot EA tau half a step late where they are long.
        It decides how long steps may be.
        """
        halves = 0.5 * step[..., None] / self.time
        return jnp.sum(self.stiff * jnp.tanh(halves) / halves, axis=-1)

    def at_rest(self, law: AbstractTensionLaw, strain: Float[Array, " n"]) -> Float[Array, "k n"]:
        """s (-) at rest at strains e (-): e, but where the line is slack the least that may pull."""
        slack = _slack_strain(law)
        strain = strain if slack is None else jnp.maximum(strain, slack)
        return jnp.tile(strain, (self.branches, 1))

    def relaxed(
        self, law: AbstractTensionLaw, strain: Float[Array, " n"], memory: Memory
    ) -> Relaxed:
        """What a law with these branches carries at strains e (-), as its dashpots stand.

        Dashpots that are known half a step dt (s) before go with the e of the middle of a step,

            s_n+1/2 = s_n-1/2 + (1 - exp(-dt/tau)) (e_n - s_n-1/2),

        exact for an e that stays and of second order otherwise, and q is the mean over the step, which
        is what its impulse is: EA tau (s_n+1/2 - s_n-1/2) / dt.
        """
        stretch, step, _, low = memory
        slack = _slack_strain(law)
        tension, slope = tension_and_stiffness(law, strain)
        time = self.time[:, None]
        lead, share = jnp.ones_like(time), jnp.ones_like(time)
        if step is not None:
            lead, share = -jnp.expm1(-step / time), mean_decay(step / time)
        stiff = share * self.stiff[:, None]
        total = tension + jnp.sum(stiff * (strain - stretch), axis=0)
        slope = slope + (self.at_once if step is None else self.in_steps(step))
        if slack is not None:
            folds = total <= 0.0
            folded = _folded(law, jnp.maximum(strain, slack), memory, stiff)
            strain = jnp.where(folds, folded, strain)
            total, slope = jnp.where(folds, 0.0, total), jnp.where(folds, 0.0, slope)
        ahead = strain - stretch
        if step is None:
            now, after, rate = stretch, None, ahead / time
        else:
            change = lead * (ahead if low is None else ahead - low)
            now, rate = strain - share * ahead, change / step
            if low is not None:
                change = change + low
            later = stretch + change
            if low is not None:
                low = jax.lax.stop_gradient(rounded_off(later, stretch, change))
            after = Memory(later, step, jax.lax.stop_gradient(strain), low)
        lost = jnp.sum(stiff * ahead * rate, axis=0)
        return Relaxed(total, slope, strain, now, after, rate, lost)

    def half_a_step_on(self, found: Relaxed, step: Float[Array, ""], rounds: bool) -> Memory:
        """The memory half a step dt (s) after the instant of `found`, for steps of that length.

        `rounds`: with what rounding leaves out of it.
        """
        change = -jnp.expm1(-0.5 * step / self.time[:, None]) * (found.strain - found.now)
        later = found.now + change
        low = jax.lax.stop_gradient(rounded_off(later, found.now, change)) if rounds else None
        return Memory(later, step, jax.lax.stop_gradient(found.strain), low)

    def energy(self, found: Relaxed) -> Float[Array, " n"]:
        """sum EA_k (e - s_k)^2 / 2 (J per metre of unstretched length) in the branches' springs."""
        return 0.5 * self.stiff @ (found.strain - found.now) ** 2


def _slack_strain(law: AbstractTensionLaw) -> Float[Array, ""] | None:
    """The strain (-) up to which a law carries nothing, None of one that can push."""
    return law.slack_strain if isinstance(law, TensionOnly) else None


def _folded(
    law: AbstractTensionLaw, strain: Float[Array, " n"], memory: Memory, stiff: Float[Array, "k 1"]
) -> Float[Array, " n"]:
    """The strain (-) at which a law and its branches carry nothing together, at least the given one.

    It is between that and the one at which the branches alone carry nothing, and is looked for by
    Newton's method, in halves of what is left where that leads out of it. Nothing of this has a
    derivative; a last step has that of the root (implicit function theorem).
    """
    whole = jnp.maximum(jnp.sum(stiff), TINY)
    middle = jnp.sum(stiff * memory.stretch, axis=0) / whole

    def carried(x: Float[Array, " n"]) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
        tension, slope = tension_and_stiffness(law, x)
        # a law that falls somewhere must not make the sum of slopes vanish
        return tension + whole * (x - middle), jnp.maximum(slope, 0.0) + whole

    def look(_, bounds):
        low, x, high = bounds
        force, slope = carried(x)
        low, high = jnp.where(force > 0.0, low, x), jnp.where(force > 0.0, x, high)
        on = x - force / slope
        return low, jnp.where((on >= low) & (on <= high), on, 0.5 * (low + high)), high

    low, high = strain, jnp.maximum(middle, strain)
    start = high if memory.guess is None else jnp.clip(memory.guess, low, high)
    bounds = jax.lax.stop_gradient((low, start, high))
    if memory.guess is None:
        bounds = jax.lax.fori_loop(0, LOOKS, look, bounds)
    else:
        for k in range(AGAIN):
            bounds = look(k, bounds)
    low, found, high = jax.lax.stop_gradient(bounds)
    force, slope = carried(found)
    on = found - force / jax.lax.stop_gradient(slope)
    return jnp.where((on >= low) & (on <= high), on, found)


def mean_decay(x: Float[Array, "..."]) -> Float[Array, "..."]:
    """(1 - exp(-x)) / x for x >= 0, 1 at 0."""
    near = x < SMALL
    far = jnp.where(near, 1.0, x)
    series = 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)))
    return jnp.where(near, series, -jnp.expm1(-far) / far)
