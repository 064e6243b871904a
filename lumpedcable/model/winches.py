"""Winches that keep the tension of lines: ideal ones, and drives with a control law and a top speed."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.model.reels import AbstractReel
from lumpedcable.physics.body import AbstractBedFriction

__all__ = ["Control", "Schedule", "Sheave", "Winch"]


ROUND = 1e-9  # of a schedule's time: more than rounding of t, less than any step


class Control(eqx.Module):
    """A PI law on tension: the drive adds K e + (K / Ti) I to the pull of the line, with I' = e.

    e = T - T_set (N) is what the line is too taut by, `gain` K (-) and `rate` K / Ti (1/s), None without
    an integral. At its top speed, while e asks for more, the drive does not integrate (anti-windup by
    clamping; K. J. Astrom & T. Hagglund, Advanced PID Control, 2006, section 3.5).
    """

    gain: Float[Array, ""]
    rate: Float[Array, ""] | None = None


class Sheave(eqx.Module):
    """A fixed sheave at the post, over which the line slides on its way to the drum.

    The line beyond it carries P exp(s mu theta) of the drum's pull P, s = tanh(v / v0) with the speed v
    at which it is paid out (Euler's formula for a belt), to the order of the strain. P is the set
    tension and the damping c v, without what a control adds, and not below 0. `grip` is mu theta (-),
    `fade` v0 (m/s).
    """

    grip: Float[Array, ""]
    fade: Float[Array, ""]


class Schedule(eqx.Module):
    """What a winch keeps over time: knots (s), and `Winch`'s pull, tension (N) and stretch (-) there.

    All three are linear between them, which the tension is; the others are to the order of the strain.
    """

    time: Float[Array, " K"]
    pull: Float[Array, " K"]
    tension: Float[Array, " K"]
    stretch: Float[Array, " K"]

    def at(self, t: Float[Array, ""]) -> tuple[Array, Array, Array]:
        """Pull, tension (N) and stretch (-) at t (s); after the last knot those there."""
        # a sum of kinks |t - t_k| that are rounded so little that only their slope tells: solvers often
        # step on one, and by the slope of one side derivatives would count a whole step as that side
        after = t - self.time[1:]
        bent = 0.5 * (jnp.sqrt(after**2 + (ROUND * self.time[-1]) ** 2) + after)

        def along(values: Float[Array, " K"]) -> Array:
            slopes = jnp.diff(values) / jnp.diff(self.time)
            turns = jnp.diff(slopes, append=0.0)
            return (values[0] + slopes[0] * t + turns @ bent).astype(values.dtype)

        return along(self.pull), along(self.tension), along(self.stretch)


class Winch(AbstractReel):
    """The winch at an end of a line: q = (L), the length (m) that is paid out.

    All segments of the line are L / n long, so that what is paid out is spread over the line at once.
    The mass that belongs to it is that of the line as it is drawn out, m L0 / 3 with m its
    `mass_per_metre` (kg/m) and L0 what is out at the start, and that of the drum, J / r^2 (kg), None
    without one. `pull` (N) is what L costs per metre: (1 + e) T - U(e) at the strain e of the tension
    T that the winch keeps, U the strain energy per metre, since what is hauled in is stretched;
    `stretch` is 1 + e. |dL/dt| stays below `speed` (m/s), None where it has no bound.

    Where the tension that it keeps changes, as its `schedule` says, `pull`, `tension` and `stretch` are
    those at t = 0, and its drive does the difference.

    With a `control` that integrates there is a second coordinate, whose rate is the integral I (N s):
    it has the mass 1 and no energy.
    """

    reference: Float[Array, " m"]
    mass_per_metre: Float[Array, ""]
    pull: Float[Array, ""]
    tension: Float[Array, ""]
    stretch: Float[Array, ""]
    drum: Float[Array, ""] | None = None
    damping: Float[Array, ""] | None = None
    speed: Float[Array, ""] | None = None
    control: Control | None = None
    sheave: Sheave | None = None
    schedule: Schedule | None = None
    line: str = eqx.field(static=True, default="")
    node: int = eqx.field(static=True, default=-1)
    start_velocity: Float[Array, " m"] | None = None
    free: Float[Array, " m"] | None = None
    friction: AbstractBedFriction | None = None

    @property
    def kilograms(self) -> Float[Array, ""]:
        """m L0 / 3 + J / r^2 (kg); statics finds L0 and puts it into `reference`."""
        line = self.mass_per_metre * self.reference[0] / 3.0
        return line if self.drum is None else line + self.drum

    @property
    def quickened(self) -> Float[Array, ""]:
        """1 + gain / stretch (-), by which its drive multiplies what the line pulls too much."""
        if self.control is None:
            return jnp.ones(())
        return 1.0 + self.control.gain / self.stretch

    @property
    def driven(self) -> bool:
        """Whether its drive does more than keep one force."""
        return not (self.control is None and self.speed is None and self.schedule is None)

    def kept(self, t: Float[Array, ""] | None) -> tuple[Array, Array, Array]:
        """Pull, tension (N) and stretch (-) that it keeps at t (s), None at rest."""
        if self.schedule is None or t is None:
            return self.pull, self.tension, self.stretch
        return self.schedule.at(t)

    def mass(self, q: Float[Array, " m"], t: Float[Array, ""] | None = None) -> Float[Array, "m m"]:
        """m L0 / 3 + J / r^2 (kg), and 1 of the integral."""
        return jnp.diag(jnp.ones_like(q).at[0].set(self.kilograms))

    def kinetic(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """That of drum and line (J)."""
        return 0.5 * self.kilograms * v[0] ** 2

    def stored(self, q: Float[Array, " m"]) -> dict[str, Float[Array, ""]]:
        """pull L (J)."""
        return {"winch": self.pull * q[0]}

    def resisting(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> dict[str, Float[Array, " m"]]:
        """-c dL/dt, the friction of the sheave, and the drive's part of integral and schedule (N)."""
        found, none = {}, jnp.zeros_like(q)
        pull, tension, stretch = self.kept(t)
        if self.damping is not None:
            found["winch"] = none.at[0].set(-self.damping * v[0])
        if self.sheave is not None:
            grip = self.sheave.grip * jnp.tanh(v[0] / self.sheave.fade)
            drum = stretch * tension
            if self.damping is not None:
                drum = jnp.maximum(drum + self.damping * v[0], 0.0)  # a line cannot be pushed
            found["friction"] = none.at[0].set(-drum * jnp.expm1(grip))
        driven = none
        if self.control is not None and self.control.rate is not None:
            driven = driven.at[0].add(self.control.rate * v[1])
        if self.schedule is not None:
            driven = driven.at[0].add(self.pull - pull)
        if driven is not none:
            found["control"] = driven
        return found

    def works(self) -> tuple[str, ...]:
        """Of its damping, its sheave and its drive."""
        present = {
            "winch": self.damping is not None,
            "friction": self.sheave is not None,
            "control": self.driven,
        }
        return tuple(kind for kind in present if present[kind])

    def answer(
        self,
        drawn: Float[Array, ""],
        velocity: Float[Array, " m"] | None,
        t: Float[Array, ""] | None = None,
    ) -> Float[Array, " m"]:
        """Generalised force (N, and N of the integral) where the line pulls with `drawn` (N) at t (s).

        `velocity` are the rates of q; both None at rest.
        """
        force = jnp.zeros_like(self.reference).at[0].set(drawn)
        if self.control is None:
            return force
        pull, _, stretch = self.kept(t)
        error = (drawn - pull) / stretch
        force = force.at[0].add(self.control.gain * error)
        if self.control.rate is None:
            return force
        if self.speed is not None and velocity is not None:
            full = jnp.abs(velocity[0]) >= self.speed * (1.0 - 1e-9)
            error = jnp.where(full & (error * velocity[0] > 0.0), 0.0, error)
        return force.at[1].set(error)

    def limited(
        self, v: Float[Array, " m"], gain: Float[Array, " m"], dt: Float[Array, ""] | None
    ) -> Float[Array, " m"]:
        """The gain (m/s2) that keeps dL/dt within its bound, over a kick of dt (s) or at the moment."""
        if self.speed is None:
            return gain
        top = self.speed.astype(v.dtype)
        if dt is None:
            outwards = (jnp.abs(v[0]) >= top) & (gain[0] * v[0] > 0.0)
            return gain.at[0].set(jnp.where(outwards, 0.0, gain[0]))
        after = jnp.clip(v[0] + dt * gain[0], -top, top)
        return gain.at[0].set((after - v[0]) / dt)

    def taken(
        self, q: Float[Array, " m"], v: Float[Array, " m"], gain: Float[Array, " m"], drawn, t
    ) -> Float[Array, ""]:
        """Power (W) that the drive takes beyond its first tension: what the other forces leave over."""
        own = self.resisting(q, v, t)
        others = sum((own[kind][0] for kind in own if kind != "control"), drawn - self.pull)
        return -(self.kilograms * gain[0] - others) * v[0]
