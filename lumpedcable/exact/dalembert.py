"""Linear line fixed at one end and released at the other: all reflections, by d'Alembert.

With y the displacement towards the fixed end from the stretched line at rest, s the unstretched
distance from the released end, c = sqrt(EA/m) and f(t) = T0 - F(t) the force taken off the end,

    m y_tt = EA y_ss,    EA y_s(0, t) = -f(t),    y(L, t) = 0,

and every wave returns with a minus sign from the fixed end and a plus sign from the loaded one:

    y = (c/EA) sum_n (-1)^n [ I(t - (2 n L + s)/c) - I(t - (2 (n+1) L - s)/c) ],

I the integral of f from 0. Source: K. F. Graff, Wave Motion in Elastic Solids (1975), chapter
2 (images). The law is signed: the line carries compression as it carries tension.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite
from .law import Array


@dataclass(frozen=True)
class LinearRelease:
    """A linear elastic line released at once or along a cos^2 ramp; holds at all times.

    Attributes:
        length: unstretched length L, m.
        EA: axial stiffness, N.
        mass: mass per unstretched length m, kg/m.
        tension0: tension before the release T0, N.
        ramp_time: duration of F = T0 cos^2(pi t/(2 t_br)), s; 0 for an instantaneous release.
    """

    length: float
    EA: float
    mass: float
    tension0: float
    ramp_time: float = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "EA", "mass"):
            value = getattr(self, name)
            if not value > 0.0:
                raise ValueError(f"expected a positive {name}, found {value:g}")
            finite(**{name: value})
        finite(**{"tension before the release": self.tension0, "ramp": self.ramp_time})
        if self.ramp_time < 0.0:
            raise ValueError(f"expected a ramp of 0 s or more, found {self.ramp_time:g}")

    @property
    def wave_speed(self) -> float:
        """c = sqrt(EA/m), m/s per unstretched length."""
        return float(np.sqrt(self.EA / self.mass))

    def _force_off(self, t: Array) -> Array:
        """f(t), N; the jump of an instantaneous release counts from t = 0 on."""
        if self.ramp_time == 0.0:
            return np.where(t >= 0.0, self.tension0, 0.0)
        x = np.clip(t / self.ramp_time, 0.0, 1.0)
        return self.tension0 * np.sin(0.5 * np.pi * x) ** 2

    def _impulse_off(self, t: Array) -> Array:
        """I(t) = integral of f, N s."""
        t = np.maximum(t, 0.0)
        if self.ramp_time == 0.0:
            return self.tension0 * t
        on = np.minimum(t, self.ramp_time)
        k = np.pi / self.ramp_time
        return self.tension0 * (0.5 * (on - np.sin(k * on) / k) + (t - on))

    def _images(
        self, s: ArrayLike, t: ArrayLike, wave: Callable[[Array], Array], back: float
    ) -> Array:
        """Sum the outgoing waves and, times `back`, the ones on their way back."""
        s, t = np.broadcast_arrays(np.asarray(s, float), np.asarray(t, float))
        if np.any((s < 0.0) | (s > self.length)):
            raise ValueError(f"s runs from 0 at the released end to {self.length:g} m")
        c, L = self.wave_speed, self.length
        out = np.zeros(s.shape)
        latest = float(np.max(t, initial=0.0))
        for n in range(int(latest * c / (2.0 * L)) + 2):
            sign = (-1.0) ** n
            going, coming = t - (2 * n * L + s) / c, t - (2 * (n + 1) * L - s) / c
            out = out + sign * (wave(going) + back * wave(coming))
        return out

    def displacement(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return y(s, t), the displacement towards the fixed end, m."""
        return self._images(s, t, self._impulse_off, -1.0) * (self.wave_speed / self.EA)

    def velocity(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the velocity towards the fixed end, m/s."""
        return self._images(s, t, self._force_off, -1.0) * (self.wave_speed / self.EA)

    def tension(self, s: ArrayLike, t: ArrayLike) -> Array:
        """Return the tension, N (negative in compression)."""
        return self.tension0 - self._images(s, t, self._force_off, 1.0)

    def end_velocity(self, t: ArrayLike) -> Array:
        """Return the velocity of the released end, m/s."""
        return self.velocity(0.0, t)

    def end_displacement(self, t: ArrayLike) -> Array:
        """Return the displacement of the released end towards the fixed one, m."""
        return self.displacement(0.0, t)

    def wall_tension(self, t: ArrayLike) -> Array:
        """Return the tension at the fixed end, N."""
        return self.tension(self.length, t)
