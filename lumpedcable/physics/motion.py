"""Prescribed motions: where an end that something else moves is at a time."""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.precision import cast
from lumpedcable.physics.ramp import grown_time, growth

__all__ = [
    "AbstractMotion",
    "Harmonic",
    "Hauled",
    "Recorded",
    "Spooled",
    "Still",
    "mean_acceleration_of",
    "mean_velocity_of",
    "velocity_of",
    "way_of",
]


class AbstractMotion(eqx.Module):
    """A path x(t) in the scene's own coordinates, shape (d,), in m over s."""

    @property
    def from_rest(self) -> bool:
        """Whether its structure tells that it has no speed at t = 0."""
        return False

    @abc.abstractmethod
    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x(t) (m)."""


def velocity_of(motion: AbstractMotion, t: Float[Array, ""]) -> Float[Array, " d"]:
    """dx/dt (m/s), the derivative of the path."""
    t = jnp.asarray(t)
    return jax.jvp(motion.position, (t,), (jnp.ones_like(t),))[1]


def way_of(
    motion: AbstractMotion, start: Float[Array, ""], end: Float[Array, ""]
) -> Float[Array, " d"]:
    """x(end) - x(start) (m) between two times (s), in double precision.

    Places of tens of metres have steps of micrometres in single precision: an end that goes by these
    stands still and jumps, and a stiff line rings with it.
    """
    path = cast(motion, "float64")
    return path.position(end) - path.position(start)


def mean_velocity_of(
    motion: AbstractMotion, t: Float[Array, ""], dt: Float[Array, ""]
) -> Float[Array, " d"]:
    """(x(t + dt) - x(t)) / dt (m/s): a step of dt (s) with it lands on the path exactly."""
    if isinstance(motion, Still):
        return jnp.zeros_like(motion.at)
    return way_of(motion, t, t + dt) / dt


def mean_acceleration_of(
    motion: AbstractMotion, t: Float[Array, ""], dt: Float[Array, ""] | None
) -> Float[Array, " d"]:
    """d2x/dt2 (m/s2) at t (s), or the mean over a kick of dt (s) about t, not before t = 0.

    In double precision: a step is short beside what speeds are rounded to.
    """
    t, motion = jnp.asarray(t), cast(motion, "float64")
    if dt is None:
        return jax.jvp(lambda s: velocity_of(motion, s), (t,), (jnp.ones_like(t),))[1]
    half = 0.5 * dt.astype(t.dtype)
    before, after = jnp.maximum(t - half, 0.0), t + half
    span = jnp.where(after > before, after - before, 1.0)  # a scene at rest has no steps
    return (velocity_of(motion, after) - velocity_of(motion, before)) / span


class Still(AbstractMotion):
    """x(t) = x0."""

    at: Float[Array, " d"]

    @property
    def from_rest(self) -> bool:
        """Always."""
        return True

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x0 (m)."""
        return self.at


class Harmonic(AbstractMotion):
    """x(t) = x0 + v R(t) + r(t) a sin(2 pi t / P + phase), R' = r.

    x0 the mean position (m), v a steady velocity (m/s), a the amplitude (m) with period P (s) and
    phase (rad); what is absent is None. r rises from 0 to 1 as sin^2(pi t / (2 ramp)) over `ramp` (s),
    so that R = t - ramp / 2 beyond it: the end is never faster than v. Without a ramp r = 1 and R = t.
    """

    mean: Float[Array, " d"]
    velocity: Float[Array, " d"] | None = None
    amplitude: Float[Array, " d"] | None = None
    period: Float[Array, ""] | None = None
    phase: Float[Array, ""] | None = None
    ramp: Float[Array, ""] | None = None

    @property
    def from_rest(self) -> bool:
        """With a ramp, over which it grows."""
        return self.ramp is not None

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x(t) (m)."""
        offset = jnp.zeros_like(self.mean)
        if self.velocity is not None:
            at_speed = t if self.ramp is None else grown_time(t, self.ramp)
            offset += (self.velocity * at_speed).astype(offset.dtype)
        if self.amplitude is not None:
            assert self.period is not None
            angle = 2.0 * jnp.pi * t / self.period
            angle = angle if self.phase is None else angle + self.phase
            swing = jnp.sin(angle)
            if self.ramp is not None:
                swing *= growth(t, self.ramp)
            offset += (self.amplitude * swing).astype(offset.dtype)
        return self.mean + offset


class Recorded(AbstractMotion):
    """A measured path: times (K,) in s and positions (K, d) in m, joined by a cubic spline.

    Catmull-Rom slopes make the velocity continuous. Before the record the end rests. Behind it, it goes
    on as it went at last: a step that ends with the record asks where it goes.
    """

    time: Float[Array, " K"]
    record: Float[Array, "K d"]

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x(t) (m)."""
        last = self.time.shape[0] - 2
        # not `clip`, whose derivative at its bounds is half of that inside
        behind = jnp.where(t > self.time[-1], t - self.time[-1], 0.0)
        t = jnp.where(t < self.time[0], self.time[0], t) - behind
        k = jnp.clip(jnp.searchsorted(self.time, t, side="right") - 1, 0, last)
        h = self.time[k + 1] - self.time[k]
        s = (t - self.time[k]) / h
        start, end = self.record[k], self.record[k + 1]
        slope = jnp.gradient(self.record, self.time, axis=0)
        left, right = h * slope[k], h * slope[k + 1]
        rise = end - start
        value = start + s * (
            left + s * (3 * rise - 2 * left - right + s * (left + right - 2 * rise))
        )
        return (value + behind * slope[-1]).astype(self.record.dtype)


class Hauled(AbstractMotion):
    """x(t) = x0 + u s(t): at the speed v until it comes to rest within `ease` after the way w.

    s = v t up to t1 = (w - v ease / 2) / v, then the speed falls as v cos^2(pi (t - t1) / (2 ease)); u
    (d,) is the direction, v in m/s, w in m, ease in s.
    """

    start: Float[Array, " d"]
    direction: Float[Array, " d"]
    speed: Float[Array, ""]
    way: Float[Array, ""]
    ease: Float[Array, ""]

    @property
    def arrival(self) -> Float[Array, ""]:
        """When it comes to rest (s)."""
        return self.way / self.speed + 0.5 * self.ease

    def position(self, t: Float[Array, ""]) -> Float[Array, " d"]:
        """x(t) (m)."""
        even = self.way / self.speed - 0.5 * self.ease
        share = jnp.clip((t - even) / self.ease, 0.0, 1.0)
        slowing = 0.5 * (share + jnp.sin(jnp.pi * share) / jnp.pi)
        way = self.speed * (jnp.minimum(t, even) + self.ease * slowing)
        return self.start + self.direction * way.astype(self.start.dtype)


class Spooled(AbstractMotion):
    """x(t) = x0 + the integral of v from 0 to t, v linear between times and constant beyond them.

    x0 (1,) in m, `time` (K,) in s with t_0 >= 0, `speed` (K,) in m/s. Parabolas, without error.
    """

    start: Float[Array, " 1"]
    time: Float[Array, " K"]
    speed: Float[Array, " K"]

    def position(self, t: Float[Array, ""]) -> Float[Array, " 1"]:
        """x(t) (m)."""
        steps, slopes = self._pieces()
        ways = 0.5 * (self.speed[1:] + self.speed[:-1]) * steps
        knots = jnp.cumsum(jnp.append(self.speed[0] * self.time[0], ways))
        k = jnp.clip(jnp.searchsorted(self.time, t, side="right") - 1, 0, None)
        past = t - self.time[k]
        bend = jnp.where(past < 0.0, 0.0, slopes[k])
        way = knots[k] + past * (self.speed[k] + 0.5 * bend * past)
        return self.start + way.astype(self.start.dtype)

    def least(self, end: Float[Array, ""]) -> Float[Array, ""]:
        """The least of x (m) from 0 to `end` (s)."""
        steps, slopes = self._pieces()
        # where v goes through 0 between two of the times, x may turn
        slope = jnp.where(slopes == 0.0, 1.0, slopes)[:-1]
        turns = self.time[:-1] + jnp.clip(-self.speed[:-1] / slope, 0.0, steps)
        times = jnp.concatenate([jnp.zeros(1), self.time, turns, jnp.ones(1) * end])
        return jnp.min(jax.vmap(self.position)(jnp.clip(times, 0.0, end)))

    def _pieces(self) -> tuple[Array, Array]:
        """How long the pieces between the times are (K - 1,), in s, and slopes of v from each (K,)."""
        steps = jnp.diff(self.time)
        return steps, jnp.append(jnp.diff(self.speed) / steps, 0.0)
