"""Exact release wave of a straight, uniform, nonlinear line whose end lets go at once.

With s the unstretched distance from the released end, e the strain, w the velocity towards the
fixed end, T(e) the tension and m the mass per unstretched length, without weight and drag,

    e_t = w_s,    m w_t = T(e)_s,

which is gas dynamics in Lagrangian coordinates with T as minus the pressure. The release of the
end from e0 is a Riemann problem; its solution depends on xi = s/t only and follows the lower
convex envelope That of T between the released strain e_r and e0:

    xi = sqrt(That'(e)/m),    w(e) = integral from e to e0 of sqrt(That'/m) de,

a rarefaction where That = T and a shock on every chord, where w jumps by sqrt(chord slope/m)
times the jump of strain. Source: R. J. LeVeque, Finite Volume Methods for Hyperbolic Problems
(2002), section 16.1; O. A. Oleinik, Uspekhi Mat. Nauk 14 (1959).
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite
from .envelope import Kind, lower_convex_envelope
from .law import (
    Array,
    Law,
    LawRange,
    SpeedIntegral,
    bisect,
    inverse_tension,
    law_range,
    released_strain,
    speed_integral,
    tension_values,
)


@dataclass(frozen=True)
class WavePiece:
    """One elementary wave of a release, by falling strain from the front to the end.

    Attributes:
        kind: "rarefaction", "shock", or "contact" (a jump on a straight part of the law).
        strain_lo: strain behind it.
        strain_hi: strain ahead of it.
        speed_lo: speed of its rear, m/s per unstretched length.
        speed_hi: speed of its head, m/s; equal to `speed_lo` for a jump.
        velocity_lo: velocity of the material behind it, m/s.
        velocity_hi: velocity of the material ahead of it, m/s.
    """

    kind: Kind
    strain_lo: float
    strain_hi: float
    speed_lo: float
    speed_hi: float
    velocity_lo: float
    velocity_hi: float
    integral: SpeedIntegral | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class ReleaseWave:
    """The self-similar wave that follows an instantaneous release of one end.

    Velocities are positive towards the fixed end. `xi` is the unstretched distance from the
    released end over the time since the release, m/s. On a jump itself the state behind it is
    returned. Valid until the front has come back from the fixed end, see `reflection_return`.

    Attributes:
        mass: mass per unstretched length m, kg/m.
        strain0: strain e0 before the release.
        tension0: tension T(e0), N.
        end_strain: strain e_r of the released part.
        end_tension: force on the end after the release, N.
        end_speed: speed of the released end, m/s.
        isentropic_end_speed: integral of sqrt(T'/m) de over the law itself, m/s: the speed if no
            shock formed, as after a slow release; NaN where the law falls in between.
        front_speed: speed of the leading front, m/s per unstretched length.
        tail_speed: speed of the rear of the last wave, m/s.
        pieces: the elementary waves, from the front to the released end.
    """

    law: LawRange = field(repr=False, compare=False)
    mass: float
    strain0: float
    tension0: float
    end_strain: float
    end_tension: float
    end_speed: float
    isentropic_end_speed: float
    front_speed: float
    tail_speed: float
    pieces: tuple[WavePiece, ...]

    def front_arrival(self, length: float) -> float:
        """Return the time in s at which the front reaches the unstretched `length` (m)."""
        return length / self.front_speed

    def reflection_return(self, length: float) -> float:
        """Return when the reflection from a fixed end at `length` (m) is back at the end, s.

        The head of the reflection crosses the fan along ds/dt = -c; with s = c t in the fan this
        gives t sqrt(c) = constant, and through the uniform part behind the fan it runs at the
        sound speed there: t = (L/c_f) sqrt(c_f c_t) (1/c_t + 1/c_r), c_f, c_t the speeds of
        front and tail and c_r the sound speed of the released part. Exact where the reflected
        front is a rarefaction or a contact (law convex below the foot of the front). inf if the
        released part carries no sound.
        """
        if not length > 0.0:
            raise ValueError(f"expected a positive length in m, found {length:g}")
        last = self.pieces[-1]
        c_r = self.tail_speed
        if last.kind == "shock":
            c_r = float(self.law.sound_speed(last.strain_lo, self.mass))
        if c_r <= 0.0 or self.tail_speed <= 0.0:
            return float("inf")
        c_f, c_t = self.front_speed, self.tail_speed
        return length * float(np.sqrt(c_t / c_f)) * (1.0 / c_t + 1.0 / c_r)

    def strain(self, xi: ArrayLike) -> Array:
        """Return the strain at xi = s/t (m/s), in the shape of `xi`.

        Raises ValueError where xi is negative (off the line).
        """
        xi = np.asarray(xi, float)
        if np.any(xi < 0.0):
            raise ValueError("xi = s/t is a distance into the line over a time: found a negative")
        e = np.full(xi.shape, self.strain0)
        for p in self.pieces:
            e = np.where(xi <= p.speed_hi, p.strain_lo, e)
            if p.kind == "rarefaction":
                fan = (xi > p.speed_lo) & (xi < p.speed_hi)
                e = np.where(fan, self._in_fan(p, xi), e)
        return e

    def _in_fan(self, p: WavePiece, xi: Array) -> Array:
        lo, hi = np.full(xi.shape, p.strain_lo), np.full(xi.shape, p.strain_hi)
        return bisect(lambda e: self.law.sound_speed(e, self.mass) > xi, lo, hi)

    def velocity(self, xi: ArrayLike) -> Array:
        """Return the velocity towards the fixed end at xi = s/t, m/s."""
        xi = np.asarray(xi, float)
        e = self.strain(xi)
        w = np.zeros(xi.shape)
        for p in self.pieces:
            w = np.where(xi <= p.speed_hi, p.velocity_lo, w)
            if p.integral is not None:
                fan = (xi > p.speed_lo) & (xi < p.speed_hi)
                w = np.where(fan, p.velocity_hi + p.integral(e), w)
        return w

    def tension(self, xi: ArrayLike) -> Array:
        """Return the tension at xi = s/t, N."""
        return self.law.tension(self.strain(xi))

    @property
    def dissipation_rate(self) -> float:
        """Energy lost in the shocks per second, W.

        A shock at speed sigma from strain b to a turns the area between the law and its chord
        into heat, sigma (integral of T de - (T(a) + T(b)) (b - a)/2).
        """
        x, weight = np.polynomial.legendre.leggauss(32)
        rate = 0.0
        for p in self.pieces:
            if p.kind != "shock":
                continue
            edges = [k for k in self.law.edges if p.strain_lo < k < p.strain_hi]
            cuts = np.unique([*np.linspace(p.strain_lo, p.strain_hi, 33), *edges])
            half = 0.5 * np.diff(cuts)[:, None]
            e = 0.5 * (cuts[1:] + cuts[:-1])[:, None] + half * x
            under_law = float(np.sum(half * weight * self.law.tension(e)))
            ends = float(np.sum(self.law.tension([p.strain_lo, p.strain_hi])))
            rate += p.speed_hi * (under_law - 0.5 * ends * (p.strain_hi - p.strain_lo))
        return rate


def start_strain(
    tension: Law, strain0: float | None, tension0: float | None, bracket: tuple[float, float]
) -> float:
    """Return the strain before a release, given itself or through the tension (N)."""
    if (strain0 is None) == (tension0 is None):
        raise ValueError("give exactly one of strain0 and tension0")
    if strain0 is not None:
        return float(strain0)
    assert tension0 is not None
    return inverse_tension(tension, tension0, bracket)


def release_wave(
    tension: Law,
    mass: float,
    *,
    strain0: float | None = None,
    tension0: float | None = None,
    end_tension: float = 0.0,
    derivative: Law | None = None,
    knots: Iterable[float] = (),
    bracket: tuple[float, float] = (-0.5, 2.0),
    samples: int = 4001,
) -> ReleaseWave:
    """Return the exact wave that follows the instantaneous release of one end.

    Args:
        tension: vectorised law T(e), N; cut at zero or signed, smooth or with corners.
        mass: mass per unstretched length, kg/m.
        strain0: strain before the release, or
        tension0: tension before the release, N (exactly one of the two).
        end_tension: force that stays on the end, N.
        derivative: vectorised T'(e), N; None for differences (about 1e-12 relative).
        knots: strains of the corners of the law, such as the points of a table.
        bracket: strains between which the strain of `tension0` is looked for.
        samples: number of samples of the law between the two states.

    Raises:
        ValueError: if the data do not describe a release, see `released_strain` and
            `inverse_tension`.
    """
    if not mass > 0.0:
        raise ValueError(f"expected a positive mass per length in kg/m, found {mass:g}")
    finite(mass=mass, **{"end tension": end_tension})
    knots = tuple(knots)
    e0 = start_strain(tension, strain0, tension0, bracket)
    e_r = released_strain(tension, e0, end_tension)
    envelope = lower_convex_envelope(
        tension, e_r, e0, derivative=derivative, knots=knots, samples=samples
    )
    law = envelope.law
    pieces: list[WavePiece] = []
    w = 0.0
    for p in reversed(envelope.pieces):
        c_lo, c_hi = (np.sqrt(max(k, 0.0) / mass) for k in (p.slope_lo, p.slope_hi))
        ahead, integral = w, None
        if p.kind == "rarefaction":
            part = law_range(tension, p.strain_lo, p.strain_hi, derivative, knots)
            integral = speed_integral(part, mass)
            w += float(integral(p.strain_lo))
        else:
            w += float(c_hi) * (p.strain_hi - p.strain_lo)
        pieces.append(
            WavePiece(
                kind=p.kind,
                strain_lo=p.strain_lo,
                strain_hi=p.strain_hi,
                speed_lo=float(c_lo),
                speed_hi=float(c_hi),
                velocity_lo=w,
                velocity_hi=ahead,
                integral=integral,
            )
        )
    return ReleaseWave(
        law=law,
        mass=mass,
        strain0=e0,
        tension0=float(tension_values(tension, e0)),
        end_strain=e_r,
        end_tension=float(end_tension),
        end_speed=w,
        isentropic_end_speed=_isentropic(law, mass),
        front_speed=pieces[0].speed_hi,
        tail_speed=pieces[-1].speed_lo,
        pieces=tuple(pieces),
    )


def _isentropic(law: LawRange, mass: float) -> float:
    """Return the integral of the sound speed over the range, NaN if the law falls in it."""
    e = np.linspace(law.lo, law.hi, 4001)
    if np.any(np.diff(law.tension(e)) < 0.0):
        return float("nan")
    return float(speed_integral(law, mass)(law.lo))
