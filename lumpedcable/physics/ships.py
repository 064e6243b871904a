"""Motions of whole bodies that something else moves, and the paths of points on them."""

import abc

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.physics.motion import AbstractMotion, Recorded
from lumpedcable.physics.ramp import growth
from lumpedcable.physics.rigid import rotation

__all__ = [
    "AbstractBodyMotion",
    "HarmonicBody",
    "HeldBody",
    "PointOfBody",
    "RecordedBody",
    "SeaBody",
    "Swing",
    "grown",
    "jonswap",
]

GRAVITY = 9.80665  # m/s2, for the length of waves on deep water
FEW = 36  # components below which equal bands would be wider than a tenth of the peak frequency
SPECTRUM = 3600  # parts of a spectrum's range whose energies are summed, its peak on a border


class AbstractBodyMotion(eqx.Module):
    """How a body moves about its mean place: six numbers over time.

    Surge, sway, heave (m) along x, y, z and roll, pitch, yaw (rad) about them.
    """

    @property
    def from_rest(self) -> bool:
        """Whether its structure tells that it has no speed at t = 0."""
        return False

    @abc.abstractmethod
    def freedoms(self, t: Float[Array, ""]) -> Float[Array, " 6"]:
        """Surge, sway, heave (m), roll, pitch, yaw (rad) at t (s)."""


def grown(
    values: Float[Array, " 6"], t: Float[Array, ""], ramp: Float[Array, ""] | None
) -> Float[Array, " 6"]:
    """The numbers times r(t), which rises from 0 to 1 over `ramp` (s): see `growth`."""
    if ramp is None:
        return values
    return values * growth(t, ramp)


class Swing(eqx.Module):
    """amplitude (m or rad), period (s) and phase (rad) of one freedom of a body, 0 to 5."""

    freedom: int = eqx.field(static=True)
    amplitude: Float[Array, ""]
    period: Float[Array, ""]
    phase: Float[Array, ""]


class HarmonicBody(AbstractBodyMotion):
    """q_k(t) = r(t) a_k sin(2 pi t / P_k + phase_k) (Gao et al. 2022, eq. 19-20).

    r as in `grown`, 1 where `ramp` is None.
    """

    swings: tuple[Swing, ...]
    ramp: Float[Array, ""] | None = None

    @property
    def from_rest(self) -> bool:
        """With a ramp, over which it grows."""
        return self.ramp is not None

    def freedoms(self, t: Float[Array, ""]) -> Float[Array, " 6"]:
        """The six numbers (m, rad) at t (s)."""
        parts = [jnp.zeros(())] * 6
        for swing in self.swings:
            angle = 2.0 * jnp.pi * t / swing.period + swing.phase
            parts[swing.freedom] = swing.amplitude * jnp.sin(angle)
        q = jnp.stack(parts)
        return grown(q, t, self.ramp)


class RecordedBody(AbstractBodyMotion):
    """A record of all six freedoms, (K, 6), joined by the cubic spline of `Recorded`."""

    path: Recorded

    def freedoms(self, t: Float[Array, ""]) -> Float[Array, " 6"]:
        """The six numbers (m, rad) at t (s)."""
        return self.path.position(t)


class HeldBody(AbstractBodyMotion):
    """A body that stays at six numbers (m, rad): a moment of one that moves freely."""

    at: Float[Array, " 6"]

    @property
    def from_rest(self) -> bool:
        """Always."""
        return True

    def freedoms(self, t: Float[Array, ""]) -> Float[Array, " 6"]:
        """The six numbers, at any t."""
        return self.at


def jonswap(
    omega: Float[Array, " K"], period: Float[Array, ""], gamma: Float[Array, ""]
) -> Float[Array, " K"]:
    """Shape of the JONSWAP spectrum at angular frequencies (rad/s), without its scale.

    w^-5 exp(-5/4 (wp/w)^4) gamma^b, b = exp(-(w - wp)^2 / (2 s^2 wp^2)), wp = 2 pi / period,
    s = 0.07 for w <= wp and 0.09 beyond (Hasselmann et al. 1973; DNV-RP-C205, section 3.5.5).
    """
    peak = 2.0 * jnp.pi / period
    width = jnp.where(omega <= peak, 0.07, 0.09)
    bump = jnp.exp(-((omega / peak - 1.0) ** 2) / (2.0 * width**2))
    return (omega / peak) ** -5.0 * jnp.exp(-1.25 * (peak / omega) ** 4) * gamma**bump


def _of_equal_energy(share, gamma: Float[Array, ""]) -> Float[Array, " N"]:
    """Frequencies, over the peak's, below which such shares (N,) of the sea's energy lie.

    Each of the N shares is somewhere in a band that holds 1/N of the energy; the one in whose band the
    peak lies stands at the peak itself, so that a sea of one component is a sine of its period.
    """
    x = jnp.linspace(0.4, 4.0, SPECTRUM + 1)
    density = jonswap(x, jnp.asarray(2.0 * jnp.pi), gamma)
    below = jnp.concatenate([jnp.zeros(1), jnp.cumsum(density[1:] + density[:-1])])
    below = below / below[-1]
    holds = jnp.floor(jnp.interp(1.0, x, below) * share.size)
    return jnp.where(jnp.arange(share.size) == holds, 1.0, jnp.interp(share, below, x))


class SeaBody(AbstractBodyMotion):
    """A body in long-crested waves: sum over components of wave amplitude times response.

    q_k(t) = r(t) sum_i a_i R_k(w_i) cos(w_i t - k_i d . x + e_i + p_k(w_i)), with wave amplitudes
    a_i (m), phases e_i (rad) drawn once, deep-water wave numbers k_i = w_i^2 / g (1/m), the way x (m)
    of the body along the waves' direction, and the response R (m/m or rad/m) with its phase p (rad),
    linear between the frequencies of its table and nothing beyond them. r as in `grown`, 1 where
    `ramp` is None.
    """

    omega: Float[Array, " N"]
    amplitude: Float[Array, " N"]
    phase: Float[Array, " N"]
    cosine: Float[Array, "6 N"]
    sine: Float[Array, "6 N"]
    ramp: Float[Array, ""] | None = None

    @property
    def from_rest(self) -> bool:
        """With a ramp, over which it grows."""
        return self.ramp is not None

    @classmethod
    def of(
        cls,
        height: Float[Array, ""],
        period: Float[Array, ""],
        gamma: Float[Array, ""],
        seed: int,
        components: int,
        way: Float[Array, ""],
        table: Float[Array, " K"],
        response: dict[int, Float[Array, "K 2"]],
        ramp: Float[Array, ""] | None = None,
    ) -> "SeaBody":
        """The motion from significant height (m), peak period (s), gamma and a response table.

        Components stand in equal bands from 0.4 to 4 times the peak frequency, one anywhere in each so
        that the sea does not repeat; they share out (height / 4)^2 exactly. Fewer than `FEW` would be
        farther apart than the peak is wide and could miss it: see `_of_equal_energy`.
        """
        draw = np.random.default_rng(seed)
        jitter, angle = draw.uniform(size=components), draw.uniform(0.0, 2.0 * np.pi, components)
        peak = 2.0 * jnp.pi / period
        band = (np.arange(components) + jitter) / components
        if components < FEW:
            omega = peak * _of_equal_energy(band, gamma)
            share = jnp.ones(components)
        else:
            omega = peak * (0.4 + 3.6 * (np.arange(components) + jitter) / components)
            share = jonswap(omega, period, gamma)
        amplitude = height / 4.0 * jnp.sqrt(2.0 * share / jnp.sum(share))
        cosine, sine = jnp.zeros((6, components)), jnp.zeros((6, components))
        for freedom, values in response.items():
            real = values[:, 0] * jnp.cos(values[:, 1])
            imaginary = values[:, 0] * jnp.sin(values[:, 1])
            both = [jnp.interp(omega, table, v, left=0.0, right=0.0) for v in (real, imaginary)]
            cosine, sine = cosine.at[freedom].set(both[0]), sine.at[freedom].set(both[1])
        phase = jnp.asarray(angle) - omega**2 / GRAVITY * way
        return cls(omega, amplitude, phase, cosine, sine, ramp)

    def freedoms(self, t: Float[Array, ""]) -> Float[Array, " 6"]:
        """The six numbers (m, rad) at t (s)."""
        angle = self.omega * t + self.phase
        wave, turned = self.amplitude * jnp.cos(angle), self.amplitude * jnp.sin(angle)
        return grown(self.cosine @ wave - self.sine @ turned, t, self.ramp)


class PointOfBody(AbstractMotion):
    """The path of a point of a moved body: x(t) = x0 + shift(t) + R(t) p.

    x0 (3,) the body's mean place and p (3,) the point in the body's axes (m), in x, y, z; `axes`
    (3, d) and `origin` (3,) lead to the scene's own coordinates.
    """

    motion: AbstractBodyMotion
    mean: Float[Array, " 3"]
    point: Float[Array, " 3"]
    axes: Float[Array, "3 d"]
    origin: Float[Array, " 3"]

    @property
    def from_rest(self) -> bool:
        """As the body does."""
        return self.motion.from_rest

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x(t) (m)."""
        q = self.motion.freedoms(t)
        place = self.mean + q[:3].astype(self.mean.dtype)
        place = place + rotation(q[3:].astype(self.mean.dtype)) @ self.point
        return self.axes.T @ (place - self.origin)
