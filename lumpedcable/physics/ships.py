"""Motions of whole bodies that something else moves, and the paths of points on them."""

import abc

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.motion import AbstractMotion, Recorded
from lumpedcable.physics.ramp import growth
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.sea import SeaState

__all__ = [
    "AbstractBodyMotion",
    "DirectionOfBody",
    "HarmonicBody",
    "HeldBody",
    "PointOfBody",
    "RecordedBody",
    "SeaBody",
    "Swing",
    "grown",
]


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


class SeaBody(AbstractBodyMotion):
    """A body in long-crested waves: sum over components of wave amplitude times response.

    q_k(t) = r(t) sum_i a_i R_k(w_i) cos(w_i t - k_i d . x + e_i + p_k(w_i)), with the amplitudes a_i
    (m), phases e_i (rad) and wave numbers k_i (1/m) of the sea, the way d . x (m) of the body along the
    waves' direction, and the response R (m/m or rad/m) with its phase p (rad), linear between the
    frequencies of its table and nothing beyond them. r as in `grown`, 1 where `ramp` is None.
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
        sea: SeaState,
        way: Float[Array, ""],
        table: Float[Array, " K"],
        response: dict[int, Float[Array, "K 2"]],
        ramp: Float[Array, ""] | None = None,
    ) -> "SeaBody":
        """The motion in a sea, `way` (m) along its direction, from a response table."""
        cosine, sine = jnp.zeros((6, sea.omega.size)), jnp.zeros((6, sea.omega.size))
        for freedom, values in response.items():
            real = values[:, 0] * jnp.cos(values[:, 1])
            imaginary = values[:, 0] * jnp.sin(values[:, 1])
            both = [jnp.interp(sea.omega, table, v, left=0.0, right=0.0) for v in (real, imaginary)]
            cosine, sine = cosine.at[freedom].set(both[0]), sine.at[freedom].set(both[1])
        phase = sea.phase - sea.number * way
        return cls(sea.omega, sea.amplitude, phase, cosine, sine, ramp)

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


class DirectionOfBody(AbstractMotion):
    """The way of a direction that is fixed to a moved body: c(t) = R(t) c.

    c (3,) in the body's axes, of length 1; `axes` (3, d) lead to the scene's own coordinates.
    """

    motion: AbstractBodyMotion
    direction: Float[Array, " 3"]
    axes: Float[Array, "3 d"]

    @property
    def from_rest(self) -> bool:
        """As the body does."""
        return self.motion.from_rest

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """c(t) (-)."""
        angles = self.motion.freedoms(t)[3:].astype(self.direction.dtype)
        return self.axes.T @ (rotation(angles) @ self.direction)
