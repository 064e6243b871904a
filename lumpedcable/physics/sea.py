"""Waves at sea: a spectrum as a sum of sines, how long these are, and how the water moves in them."""

import math

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.physics.ramp import growth

__all__ = ["SeaFlow", "SeaState", "SeaSurface", "jonswap", "wave_numbers"]

GRAVITY = 9.80665  # m/s2, for the length of waves on deep water
FEW = 36  # components below which equal bands would be wider than a tenth of the peak frequency
SPECTRUM = 3600  # parts of a spectrum's range whose energies are summed, its peak on a border
# of the series, whose first terms left out are below 1e-13 at a quarter turn
SINE = [(-1.0) ** n / math.factorial(2 * n + 1) for n in range(10)]
COSINE = [(-1.0) ** n / math.factorial(2 * n) for n in range(10)]
NEWTON = 4  # steps from the explicit wave number, which is off by less than 0.8 %


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


def circle(angle: Float[Array, "..."]) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """sin and cos of angles (rad) to 2e-13, in a third of the time that the library's take on a CPU.

    By their series at half the angle, which whole turns have brought to within a quarter of one, and
    sin 2y = 2 sin y cos y, cos 2y = 1 - 2 sin^2 y.
    """
    turns = angle * (0.5 / math.pi)
    half = math.pi * (turns - jnp.round(turns))
    square = half * half
    sine, cosine = SINE[-1], COSINE[-1]
    for s, c in zip(SINE[-2::-1], COSINE[-2::-1], strict=True):
        sine, cosine = sine * square + s, cosine * square + c
    sine = sine * half
    return 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine


def wave_numbers(omega: Float[Array, " N"], depth: Float[Array, ""] | None) -> Float[Array, " N"]:
    """k (1/m) of w^2 = g k tanh(k h), of w^2 = g k where no depth h (m) is given.

    Newton's method from k h = x^2 (1 - exp(-x^b))^(-1/b), x = w sqrt(h / g), b = 2.4908 (J. Guo, Coastal
    Engineering 45 (2002), 71-74, eq. 14).
    """
    deep = omega**2 / GRAVITY
    if depth is None:
        return deep
    wanted = deep * depth  # x^2 = y tanh y with y = k h
    power = 2.4908
    y = wanted * (-jnp.expm1(-(wanted ** (0.5 * power)))) ** (-1.0 / power)
    for _ in range(NEWTON):
        t = jnp.tanh(y)
        y = y - (y * t - wanted) / (t + y * (1.0 - t**2))
    return y / depth


class SeaState(eqx.Module):
    """Long-crested waves: eta(X, t) = sum_i a_i cos(w_i t - k_i X + e_i), X (m) along their direction.

    Amplitudes a_i (m), angular frequencies w_i (rad/s), wave numbers k_i (1/m), phases e_i (rad) drawn
    once; `depth` (m) is that of the water, None where it is deep.
    """

    omega: Float[Array, " N"]
    amplitude: Float[Array, " N"]
    phase: Float[Array, " N"]
    number: Float[Array, " N"]
    depth: Float[Array, ""] | None = None

    @classmethod
    def of(
        cls,
        height: Float[Array, ""],
        period: Float[Array, ""],
        gamma: Float[Array, ""],
        seed: int,
        components: int,
        depth: Float[Array, ""] | None = None,
    ) -> "SeaState":
        """The sea of a significant height (m), a peak period (s) and a gamma.

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
        return cls(omega, amplitude, jnp.asarray(angle), wave_numbers(omega, depth), depth)

    def turned(self, t: Float[Array, ""]) -> Float[Array, " N"]:
        """w t + e (rad) within a turn, in the clock's own precision, however long it has run."""
        return jnp.mod(self.omega * t + self.phase, 2.0 * jnp.pi)


class SeaSurface(eqx.Module):
    """The surface of the water in a sea: z = level + sum a cos(w t - k X + e), X = x cos b + y sin b.

    `level` (m) is that of the water at rest, b = `direction` (rad) the way that the waves go from the
    x axis towards y; they grow over `ramp` (s) as in `growth`, None where they are there from the start.
    """

    sea: SeaState
    direction: Float[Array, ""]
    level: Float[Array, ""]
    ramp: Float[Array, ""] | None = None

    def height(self, t: Float[Array, ""], place: Float[Array, "... 3"]) -> Float[Array, "..."]:
        """z (m) at t (s) over or under places (m)."""
        sea = self.sea
        along = place[..., 0] * jnp.cos(self.direction) + place[..., 1] * jnp.sin(self.direction)
        risen = jnp.cos(sea.turned(t) - sea.number * along[..., None]) @ sea.amplitude
        if self.ramp is not None:
            risen = growth(t, self.ramp) * risen
        return (self.level + risen).astype(place.dtype)


class SeaFlow(eqx.Module):
    """How the water moves in a sea, to the first order in its steepness (Airy's waves).

    u = sum a w C cos(w t - k X + e) along the waves and -sum a w S sin(w t - k X + e) upwards (m/s),
    with C = cosh k(h + z) / sinh k h and S = sinh k(h + z) / sinh k h at the height z <= 0 (m) over the
    mean surface, both exp(k z) on deep water; and the local acceleration du/dt (m/s2). Above the mean
    surface the water moves as in it, below the bed not at all upwards. The amplitudes a grow over
    `ramp` (s) as in `growth`, and both with them; that they do is left out of du/dt.
    (G. B. Airy 1845; DNV-RP-C205, section 3.2.2.)

    Scene coordinates x (d,) are at X = `way` . x + `ahead` (m), and at the height `up` . x + `above` (m)
    over the mean surface.
    """

    sea: SeaState
    way: Float[Array, " d"]
    ahead: Float[Array, ""]
    up: Float[Array, " d"]
    above: Float[Array, ""]
    ramp: Float[Array, ""] | None = None

    def motion(
        self, t: Float[Array, ""], position: Float[Array, "d nodes"]
    ) -> tuple[Float[Array, "d nodes"], Float[Array, "d nodes"]]:
        """Velocity (m/s) and acceleration (m/s2) of the water at t (s) at each position (m)."""
        sea, dtype = self.sea, position.dtype
        height = jnp.minimum(self.up.astype(dtype) @ position + self.above.astype(dtype), 0.0)
        k = sea.number.astype(dtype)[:, None]
        sine, cosine = self._circle(t, position)
        level, upright = self._decay(k, height)
        fast = (sea.amplitude * sea.omega).astype(dtype)
        faster = (sea.amplitude * sea.omega**2).astype(dtype)
        velocity = self._spread(fast @ (level * cosine), -(fast @ (upright * sine)))
        acceleration = self._spread(-(faster @ (level * sine)), -(faster @ (upright * cosine)))
        if self.ramp is None:
            return velocity, acceleration
        share = growth(t, self.ramp).astype(dtype)
        return share * velocity, share * acceleration

    def risen(
        self, t: Float[Array, ""], position: Float[Array, "d nodes"]
    ) -> Float[Array, " nodes"]:
        """How far the surface is over the water at rest (m) at t (s), over or under positions (m)."""
        dtype = position.dtype
        _, cosine = self._circle(t, position)
        risen = self.sea.amplitude.astype(dtype) @ cosine
        return risen if self.ramp is None else growth(t, self.ramp).astype(dtype) * risen

    def _circle(self, t: Float[Array, ""], position: Float[Array, "d nodes"]):
        """sin and cos of w t - k X + e of each sine at each position, (N, nodes)."""
        sea, dtype = self.sea, position.dtype
        along = self.way.astype(dtype) @ position + self.ahead.astype(dtype)
        turned = sea.turned(t).astype(dtype)
        return circle(turned[:, None] - sea.number.astype(dtype)[:, None] * along)

    def _decay(self, k: Float[Array, "N 1"], height: Float[Array, " nodes"]):
        """C and S (-) at heights below the mean surface (m)."""
        if self.sea.depth is None:
            both = jnp.exp(k * height)
            return both, both
        depth = self.sea.depth.astype(height.dtype)
        height = jnp.maximum(height, -depth)
        down, back = jnp.exp(k * height), jnp.exp(-k * (height + 2.0 * depth))
        share = -1.0 / jnp.expm1(-2.0 * k * depth)
        return (down + back) * share, (down - back) * share

    def _spread(self, along: Float[Array, " nodes"], upwards: Float[Array, " nodes"]):
        way, up = self.way.astype(along.dtype), self.up.astype(along.dtype)
        return way[:, None] * along + up[:, None] * upwards
