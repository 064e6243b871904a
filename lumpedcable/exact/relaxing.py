"""A line whose material relaxes, fixed at one end and released at the other: by its natural modes.

With x from the fixed end, w the displacement from the stretched line at rest, away from that end, and
f(t) = T0 - F(t) the force taken off the other one,

    m w_tt = N_x,      N = EA w_x + sum_j E_j (w_x - z_j),      dz_j/dt = (w_x - z_j) / tau_j,
    w(0, t) = 0,       N(L, t) = -f(t),

the shapes sin(k x), k = (n + 1/2) pi / L, part the problem into linear systems of 2 + j numbers each,

    a'' = -(k^2/m) [EA a + sum_j E_j (a - b_j)] - (-1)^n 2 f(t) / (m L),      b_j' = (a - b_j) / tau_j,

which are solved in their own eigenvalues; what the force would do slowly is summed in closed form, so
that the sums converge. A front of a release at once moves with the stiffness of fast loads and loses
its height as exp(-x / (c tau) E / (2 (EA + E))). Source: R. M. Christensen, Theory of Viscoelasticity
(2nd ed. 1982), chapters 2 and 4, for one branch. The line carries compression as it carries tension.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .checks import finite, positive
from .law import Array


class _Modes(NamedTuple):
    """Wave numbers k (1/m), ends' shapes (-1)^n, eigenvalues (1/s) and what each has of every number."""

    number: Array
    sign: Array
    rate: NDArray[np.complex128]
    share: NDArray[np.complex128]


@dataclass(frozen=True)
class RelaxingRelease:
    """A linear line that relaxes, released at once or along a cos^2 ramp; holds at all times.

    Attributes:
        length: unstretched length L, m.
        EA: axial stiffness for slow loads, N.
        mass: mass per unstretched length m, kg/m.
        tension0: tension before the release T0, N.
        branches: stiffness E_j, N, and time tau_j, s, of each branch.
        ramp_time: duration of F = T0 cos^2(pi t/(2 t_br)), s; 0 for an instantaneous release.
        modes: number of natural modes that are summed.
    """

    length: float
    EA: float
    mass: float
    tension0: float
    branches: tuple[tuple[float, float], ...]
    ramp_time: float = 0.0
    modes: int = 400

    def __post_init__(self) -> None:
        for name, unit in (("length", "m"), ("EA", "N"), ("mass", "kg/m")):
            positive(name, unit, getattr(self, name))
        for stiff, time in self.branches:
            positive("stiffness of a branch", "N", stiff)
            positive("time of a branch", "s", time)
        finite(**{"tension before the release": self.tension0, "ramp": self.ramp_time})
        if self.ramp_time < 0.0:
            raise ValueError(f"expected a ramp of 0 s or more, found {self.ramp_time:g}")

    @property
    def front_speed(self) -> float:
        """c = sqrt((EA + sum E_j)/m), m/s per unstretched length: no wave is faster."""
        return float(np.sqrt((self.EA + sum(stiff for stiff, _ in self.branches)) / self.mass))

    def front_height(self, x: ArrayLike) -> Array:
        """What is left of the height of a release at once after x (m), of 1 at the start.

        Along its way the jump of strain e has de/dt = -sum_j E_j e / (2 m c^2 tau_j).
        """
        whole = self.mass * self.front_speed**2
        rate = sum(stiff / time for stiff, time in self.branches) / (2.0 * whole)
        return np.exp(-rate * np.asarray(x, float) / self.front_speed)

    @cached_property
    def _modes(self) -> _Modes:
        n = np.arange(self.modes, dtype=float)
        k, sign = (n + 0.5) * np.pi / self.length, np.cos(np.pi * n)
        stiff = np.array([s for s, _ in self.branches])
        time = np.array([t for _, t in self.branches])
        size = 2 + stiff.size
        matrix = np.zeros((self.modes, size, size))
        matrix[:, 0, 1] = 1.0
        matrix[:, 1, 0] = -(k**2) / self.mass * (self.EA + stiff.sum())
        matrix[:, 1, 2:] = k[:, None] ** 2 / self.mass * stiff
        matrix[:, 2:, 0] = 1.0 / time
        matrix[:, range(2, size), range(2, size)] = -1.0 / time
        push = np.zeros((self.modes, size, 1))
        push[:, 1, 0] = -sign * 2.0 * self.tension0 / (self.mass * self.length)
        rate, vectors = np.linalg.eig(matrix)
        share = vectors * np.linalg.solve(vectors, push).swapaxes(1, 2)
        return _Modes(k, sign, rate.astype(complex), share.astype(complex))

    def _off(self, t: Array) -> Array:
        """f(t) / T0; the jump of an instantaneous release counts from t = 0 on."""
        if self.ramp_time == 0.0:
            return np.where(t >= 0.0, 1.0, 0.0)
        return np.sin(0.5 * np.pi * np.clip(t / self.ramp_time, 0.0, 1.0)) ** 2

    def _off_rate(self, t: Array) -> Array:
        """df/dt / T0 (1/s), without the jump of an instantaneous release."""
        if self.ramp_time == 0.0:
            return np.zeros_like(t)
        on = (t > 0.0) & (t < self.ramp_time)
        turn = np.pi / self.ramp_time
        return np.where(on, 0.5 * turn * np.sin(turn * t), 0.0)

    def _grown(self, rate: NDArray[np.complex128], t: Array) -> NDArray[np.complex128]:
        """Integral from 0 to t of exp(rate (t - s)) f(s)/T0 ds, (modes, eigenvalues, times)."""
        rate, t = rate[..., None], np.maximum(t, 0.0)
        later, grown = t, 0.0
        if self.ramp_time > 0.0:
            on, turn = np.minimum(t, self.ramp_time), 1j * np.pi / self.ramp_time
            # of 1 - cos: the waves of both signs apart, so that one as fast as a mode grows with time
            swung = sum(_beat(rate, sign * turn, on) for sign in (1.0, -1.0))
            grown = 0.5 * np.expm1(rate * on) / rate - 0.25 * swung
            later = t - on
        return grown * np.exp(rate * later) + np.expm1(rate * later) / rate

    def _numbers(self, t: Array) -> tuple[Array, Array, Array]:
        """a (m) and a' (m/s) less those of slow loads, and a'' (m/s2), of each mode, (modes, times)."""
        k, sign, rate, share = self._modes
        grown = self._grown(rate, t)
        a, speed = (np.einsum("ni,nit->nt", share[:, row], grown).real for row in (0, 1))
        push = -2.0 * self.tension0 * (sign / (self.mass * self.length))[:, None]
        slow = push * self.mass / (self.EA * k[:, None] ** 2)
        gain = np.einsum("ni,nit->nt", share[:, 1] * rate, grown).real + push * self._off(t)
        return a - slow * self._off(t), speed - slow * self._off_rate(t), gain

    def _summed(self, s: ArrayLike, t: ArrayLike, kind: str) -> Array:
        s, t = np.broadcast_arrays(np.asarray(s, float), np.asarray(t, float))
        if np.any((s < 0.0) | (s > self.length)):
            raise ValueError(f"s runs from 0 at the released end to {self.length:g} m")
        x, k = self.length - s, self._modes.number
        times, index = np.unique(t, return_inverse=True)
        places, where = np.unique(x, return_inverse=True)
        a, speed, gain = self._numbers(times)
        if kind == "tension":
            waves = np.cos(k * places[:, None]) @ (-self.mass * gain / k[:, None])
            found = waves + self.tension0 * (1.0 - self._off(times))
        else:
            moved, share = (a, self._off) if kind == "displacement" else (speed, self._off_rate)
            slow = self.tension0 / self.EA * places[:, None] * share(times)
            found = slow - np.sin(k * places[:, None]) @ moved
        return found[where.reshape(s.shape), index.reshape(s.shape)]

    def displacement(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement towards the fixed end, m, s (m) from the released one."""
        return self._summed(s, t, "displacement")

    def velocity(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the velocity towards the fixed end, m/s, s (m) from the released one."""
        return self._summed(s, t, "velocity")

    def tension(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the tension, N (negative in compression), s (m) from the released end."""
        return self._summed(s, t, "tension")


def _beat(rate: NDArray[np.complex128], other: complex, t: Array) -> NDArray[np.complex128]:
    """Integral from 0 to t of exp(rate (t - s) + other s) ds, t exp(rate t) where the two are one."""
    apart = other - rate
    near = np.abs(apart * t) < 0.5
    x = np.where(near & (apart * t != 0.0), apart * t, 1e-12)
    far = np.where(apart != 0.0, apart, 1.0)
    alike, others = np.expm1(x) / x * t * np.exp(rate * t), np.exp(other * t) - np.exp(rate * t)
    return np.where(near, alike, others / far).astype(complex)
