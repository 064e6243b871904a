"""Exact simple wave of a nonlinear line whose end force falls along a cos^2 ramp.

The end force is F(t) = F1 + (T0 - F1) cos^2(pi t / (2 t_br)) up to t_br and F1 after it. Until
characteristics cross, every strain e leaves the end at the time t'(e) at which T(e) = F(t') and
travels unchanged at its own speed,

    s = c(e) (t - t'(e)),    c = sqrt(T'(e)/m),    w = integral from e to e0 of c de,

a simple wave (G. B. Whitham, Linear and Nonlinear Waves (1974), chapter 6). Neighbouring
characteristics cross at t' + c/(dc/dt') where c grows with t'; the smallest such time is the
birth of the shock.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from .checks import finite
from .law import (
    Array,
    Law,
    LawRange,
    SpeedIntegral,
    Truth,
    bisect,
    law_range,
    released_strain,
    root,
    smallest,
    speed_integral,
    tension_values,
)
from .waves import start_strain


@dataclass(frozen=True)
class RampedRelease:
    """The wave of a smooth release; velocities are positive towards the fixed end.

    `s` is the unstretched distance from the released end (m), `t` the time since the ramp began
    (s). The fields hold until `shock_time`, and before a reflection arrives.

    Attributes:
        mass: mass per unstretched length m, kg/m.
        strain0: strain before the release.
        tension0: tension before the release, N.
        end_strain: strain after the ramp.
        end_tension: force on the end after the ramp F1, N.
        ramp_time: t_br, s.
        end_speed: speed of the end after the ramp, m/s.
        shock_time: time at which the first shock forms, s; inf if none does.
        shock_place: where it forms, m from the released end; inf if none does.
        shock_label: time t' at which the first crossing characteristics left the end, s; NaN if
            none cross.
    """

    law: LawRange = field(repr=False, compare=False)
    integral: SpeedIntegral = field(repr=False, compare=False)
    mass: float
    strain0: float
    tension0: float
    end_strain: float
    end_tension: float
    ramp_time: float
    end_speed: float
    shock_time: float
    shock_place: float
    shock_label: float

    def end_force(self, t: ArrayLike) -> Array:
        """Return the force F(t) on the released end, N."""
        t = np.asarray(t, float)
        x = np.clip(t / self.ramp_time, 0.0, 1.0)
        drop = self.tension0 - self.end_tension
        force = self.end_tension + drop * np.cos(0.5 * np.pi * x) ** 2
        return np.where(t >= self.ramp_time, self.end_tension, force)

    def end_strain_history(self, t: ArrayLike) -> Array:
        """Return the strain at the released end at time t, from T(e) = F(t)."""
        F = self.end_force(t)
        lo, hi = np.full(F.shape, self.law.lo), np.full(F.shape, self.law.hi)
        e = bisect(lambda x: self.law.tension(x) > F, lo, hi)
        e = np.where(self.tension0 <= F, self.strain0, e)
        return np.where(self.end_tension >= F, self.end_strain, e)

    def end_velocity(self, t: ArrayLike) -> Array:
        """Return the velocity of the released end, m/s; exact until `end_valid_until`."""
        return self.integral(self.end_strain_history(t))

    def release_time(self, strain: ArrayLike) -> Array:
        """Return the time t'(e) at which a strain leaves the end, s."""
        T = self.law.tension(strain)
        down = np.maximum(self.tension0 - T, 0.0)
        left = np.maximum(T - self.end_tension, 0.0)
        return self.ramp_time * (2.0 / np.pi) * np.arctan2(np.sqrt(down), np.sqrt(left))

    def sound_speed(self, strain: ArrayLike) -> Array:
        """Return c(e) in m/s per unstretched length."""
        return self.law.sound_speed(strain, self.mass)

    def strain(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the strain at distance s and time t; broadcasts s against t.

        Raises ValueError for s < 0 and for t beyond `shock_time`, where the simple wave ends.
        """
        s, t = np.broadcast_arrays(np.asarray(s, float), np.asarray(t, float))
        if np.any(s < 0.0):
            raise ValueError("s is the distance from the released end: found a negative one")
        if np.any(t > self.shock_time):
            raise ValueError(
                f"a shock forms at t = {self.shock_time:.6g} s, {self.shock_place:.6g} m from the "
                f"released end; the simple wave does not hold after it (t = {np.max(t):.6g} s)"
            )
        lo = self.end_strain_history(np.maximum(t, 0.0))

        def ahead(e: Array) -> Truth:
            return self.sound_speed(e) * (t - self.release_time(e)) > s

        e = bisect(ahead, lo, np.full(s.shape, self.strain0))
        quiet = s >= float(self.sound_speed(self.strain0)) * np.maximum(t, 0.0)
        behind = s <= float(self.sound_speed(self.end_strain)) * (t - self.ramp_time)
        return np.where(quiet, self.strain0, np.where(behind, self.end_strain, e))

    def velocity(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the velocity towards the fixed end at (s, t), m/s."""
        return self.integral(self.strain(s, t))

    def tension(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the tension at (s, t), N."""
        return self.law.tension(self.strain(s, t))

    def end_valid_until(self, length: float) -> float:
        """Return until when `end_velocity` is exact on a line fixed at `length` (m), in s.

        The first thing that comes back to the end is the reflection from the fixed end, or what
        the forming shock sends back. Both run along ds/dt = -c through the simple wave. With the
        label t' of the characteristics they cross and tau = t - t', s = c tau gives

            d(tau sqrt(c))/dt' = -sqrt(c)/2,

        a quadrature; the end is reached at tau = 0.
        """
        if not length > 0.0:
            raise ValueError(f"expected a positive length in m, found {length:g}")
        c0 = float(self.sound_speed(self.strain0))
        back = self._return(0.0, length / c0)
        if self.shock_place < length:
            label = self.shock_label
            back = min(back, self._return(label, self.shock_time - label))
        return back

    def _return(self, label: float, tau: float) -> float:
        def root_c(x: float) -> float:
            return float(np.sqrt(self.sound_speed(self.end_strain_history(x))))

        start = tau * root_c(label)

        def left(x: float) -> float:
            return start - 0.5 * quad(root_c, label, x, limit=200)[0]

        rest = left(self.ramp_time)
        if rest <= 0.0:
            return root(left, label, self.ramp_time)
        c_end = float(self.sound_speed(self.end_strain))
        return self.ramp_time + 2.0 * rest / float(np.sqrt(c_end)) if c_end > 0.0 else np.inf


def ramped_release(
    tension: Law,
    mass: float,
    ramp_time: float,
    *,
    strain0: float | None = None,
    tension0: float | None = None,
    end_tension: float = 0.0,
    derivative: Law | None = None,
    knots: Iterable[float] = (),
    bracket: tuple[float, float] = (-0.5, 2.0),
) -> RampedRelease:
    """Return the exact wave that follows a release along a cos^2 ramp of `ramp_time` (s).

    Args:
        tension: vectorised law T(e), N, rising between the two states.
        mass: mass per unstretched length, kg/m.
        ramp_time: duration t_br of the ramp, s.
        strain0: strain before the release, or
        tension0: tension before the release, N (exactly one of the two).
        end_tension: force that stays on the end, N.
        derivative: vectorised T'(e), N; None for differences.
        knots: strains of the corners of the law.
        bracket: strains between which the strain of `tension0` is looked for.

    Raises:
        ValueError: if the mass or the ramp is not positive (an instantaneous release is
            `release_wave`), or the law does not rise all the way.
    """
    if not mass > 0.0:
        raise ValueError(f"expected a positive mass per length in kg/m, found {mass:g}")
    if not ramp_time > 0.0:
        raise ValueError(f"expected a positive ramp in s, found {ramp_time:g}; 0 is release_wave")
    finite(mass=mass, **{"ramp": ramp_time, "end tension": end_tension})
    e0 = start_strain(tension, strain0, tension0, bracket)
    e_r = released_strain(tension, e0, end_tension)
    law = law_range(tension, e_r, e0, derivative, knots)
    e = np.linspace(e_r, e0, 2001)
    falls = np.flatnonzero(np.diff(law.tension(e)) < 0.0)
    if falls.size:
        raise ValueError(f"a simple wave needs a rising law; this one falls at {e[falls[0]]:g}")
    integral = speed_integral(law, mass)
    T0 = float(tension_values(tension, e0))
    draft = RampedRelease(
        law, integral, mass, e0, T0, e_r, float(end_tension), float(ramp_time),
        float(integral(e_r)), np.inf, np.inf, np.nan,
    )  # fmt: skip
    time, place, label = _shock(draft)
    return RampedRelease(
        law, integral, mass, e0, T0, e_r, float(end_tension), float(ramp_time),
        float(integral(e_r)), time, place, label,
    )  # fmt: skip


def _shock(wave: RampedRelease) -> tuple[float, float, float]:
    """Return time, place and label t' of the first crossing of characteristics."""
    law, tbr = wave.law, wave.ramp_time
    drop = wave.tension0 - wave.end_tension

    def crossing(label: Array) -> tuple[Array, Array]:
        e = wave.end_strain_history(label)
        slope = np.maximum(law.slope(e), 1e-300)
        force_rate = -0.5 * np.pi / tbr * drop * np.sin(np.pi * label / tbr)
        # dc/dt' over c, from c^2 = T'/m and T' de/dt' = F'.
        growth = 0.5 * law.curvature(e) / slope**2 * force_rate
        tau = np.where(growth > 0.0, 1.0 / np.where(growth > 0.0, growth, 1.0), np.inf)
        return label + tau, wave.sound_speed(e) * tau

    found = [(np.inf, np.inf, np.nan)]
    for k in law.edges[1:-1]:
        # Unloading passes a corner downwards: a steeper law below it is a shock at the end.
        if float(law.slope(k, "left")) > float(law.slope(k)) * (1.0 + 1e-9):
            found.append((float(wave.release_time(k)), 0.0, float(wave.release_time(k))))
    labels = np.linspace(0.0, tbr, 2002)[1:-1]
    times, _ = crossing(labels)
    i = int(np.argmin(times))
    # Rounding makes a straight law cross itself somewhere far beyond any line of interest.
    if times[i] < 1e6 * tbr:
        lo, hi = labels[max(i - 1, 0)], labels[min(i + 1, len(labels) - 1)]
        x, best = smallest(lambda x: float(crossing(np.asarray(x))[0]), float(lo), float(hi))
        if best > times[i]:
            x = float(labels[i])
        time, place = crossing(np.asarray(x))
        found.append((float(time), float(place), x))
    return min(found)
