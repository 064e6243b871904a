"""Parts of a scene with coordinates of their own, beside the lines: rigid bodies.

A body's entry in `State.displacement` and `State.velocity` stands under `body_key(name)`, a name that
no line can have, and holds its generalised coordinates, counted from the body's `reference`, and their
rates. Solvers map over it as over a line's nodes. What else has a state of its own and an inertia (a
trolley, a winch) is another class on `AbstractBody`.
"""

import abc

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics.body import AbstractBedFriction, AbstractBodyLoad, AbstractBodyResistance
from lumpedcable.physics.hull import SeaPush, WetAddedMass
from lumpedcable.physics.rigid import (
    place_of,
    point_rate,
    rigid_mass,
    rotation,
    turning_force,
)
from lumpedcable.physics.wave_force import WaveForce

__all__ = ["AbstractBody", "RigidBody", "body_key"]

_MARK = "body "


def body_key(name: str) -> str:
    """Where a body stands in the state: no line has a name with a space."""
    return _MARK + name


class AbstractBody(eqx.Module):
    """Something with m generalised coordinates q and M(q, t) q'' = force + what lines pull at it.

    `reference` (m,) is q at the start and `start_velocity` (m,) its rate there, None at rest. `free`
    (m,) is 1 where a coordinate can change and 0 where it is held, None where all can. `friction` acts
    where it rests on a bed, None where it does not.
    """

    reference: eqx.AbstractVar[Float[Array, " m"]]
    start_velocity: eqx.AbstractVar[Float[Array, " m"] | None]
    free: eqx.AbstractVar[Float[Array, " m"] | None]
    friction: eqx.AbstractVar[AbstractBedFriction | None]

    @abc.abstractmethod
    def mass(self, q: Float[Array, " m"], t: Float[Array, ""] | None = None) -> Float[Array, "m m"]:
        """M, symmetric and positive, at t (s), None at rest."""

    @abc.abstractmethod
    def kinetic(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """Energy of motion (J): v . M v / 2, of those coordinates that are a motion."""

    @abc.abstractmethod
    def place(self, q: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """Where a point of the body is (m), for the ends of lines that are tied to it."""

    @abc.abstractmethod
    def shift(self, u: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """How far that point has moved (m) when q has by u: place(reference + u) - place(reference)."""

    @abc.abstractmethod
    def stored(self, q: Float[Array, " m"]) -> dict[str, Float[Array, ""]]:
        """Potential energies (J) by dataset."""

    @abc.abstractmethod
    def resisting(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> dict[str, Float[Array, " m"]]:
        """Generalised forces that take or give energy, by kind of work (a key of `model.energy.WORKS`).

        `t` (s) is the time, None at rest, where there are no waves.
        """

    @abc.abstractmethod
    def works(self) -> tuple[str, ...]:
        """The kinds of work of `resisting`, of `changing` and of `friction`."""

    def changing(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""]
    ) -> dict[str, Float[Array, ""]]:
        """The powers (W) by kind of work of a mass that changes otherwise than as q turns it."""
        return {}

    def lightest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """The least M that it may have in that attitude."""
        return self.mass(q)

    def energy(self, q: Float[Array, " m"]) -> Float[Array, ""]:
        """All potential energy (J)."""
        return sum(self.stored(q).values(), jnp.zeros((), q.dtype))

    def stiffest(
        self, q: Float[Array, " m"]
    ) -> tuple[Float[Array, "m m"], Float[Array, "m m"] | None]:
        """For the step: the largest stiffness (N/m, N m/rad) it may have, and damping that is strong."""
        return jax.hessian(self.energy)(q), None

    def force(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """Generalised force without lines: -dE/dq, resistance, and the velocity terms of inertia.

        Lagrange's equation of T = v . M v / 2: M v' = Q - (dM/dt) v + dT/dq.
        """
        total = -jax.grad(self.energy)(q) - self.turning(q, v, t)
        return sum(self.resisting(q, v, t).values(), total)

    def rate(
        self, q: Float[Array, " m"], v: Float[Array, " m"], point: Float[Array, " d"]
    ) -> tuple[Float[Array, "d m"], Float[Array, " d"], Float[Array, " d"]]:
        """Of a point of the body: J = dr/dq, its velocity J v (m/s), and (dJ/dt) v (m/s2)."""

        def jacobian(at):
            return jax.jacfwd(self.place)(at, point)

        matrix, change = jax.jvp(jacobian, (q,), (v,))
        return matrix, matrix @ v, change @ v

    def turning(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """The velocity terms of inertia: (dM/dt) v - dT/dq."""
        change = jax.jvp(self.mass, (q,), (v,))[1] @ v
        return change - jax.grad(lambda at: 0.5 * v @ self.mass(at) @ v)(q)


class RigidBody(AbstractBody):
    """A rigid body: coordinates as in `physics.rigid`, with its centre of gravity as its place.

    `translation` (d,) are its masses (kg) along its own axes, added mass included, and `inertia`
    (angles,) its moments of inertia about them (kg m2). Of a body that may leave the water the added
    mass is apart, `added`.
    """

    reference: Float[Array, " m"]
    translation: Float[Array, " d"]
    inertia: Float[Array, " a"]
    start_velocity: Float[Array, " m"] | None = None
    free: Float[Array, " m"] | None = None
    friction: AbstractBedFriction | None = None
    loads: tuple[AbstractBodyLoad, ...] = ()
    resistances: tuple[AbstractBodyResistance, ...] = ()
    waves: WaveForce | SeaPush | None = None
    added: WetAddedMass | None = None

    def masses(
        self, q: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " d"]:
        """Along its own axes (kg), with what of the water it takes along at t (s), None at rest."""
        return self.translation if self.added is None else self.translation + self.added.at(q, t)

    def mass(self, q: Float[Array, " m"], t: Float[Array, ""] | None = None) -> Float[Array, "m m"]:
        """M (kg, kg m, kg m2)."""
        return rigid_mass(q, self.masses(q, t), self.inertia)

    def lightest(self, q: Float[Array, " m"]) -> Float[Array, "m m"]:
        """Out of the water."""
        return rigid_mass(q, self.translation, self.inertia)

    def kinetic(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, ""]:
        """v . M v / 2 (J)."""
        return 0.5 * v @ self.mass(q, t) @ v

    def changing(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""]
    ) -> dict[str, Float[Array, ""]]:
        """u . (dm/dt) u / 2 (W) of its wet share, u its velocity along its own axes."""
        if self.added is None:
            return {}
        t = jnp.asarray(t, q.dtype)
        rate = jax.jvp(self.added.at, (q, t), (v, jnp.ones_like(t)))[1]
        d = rate.shape[0]
        return {"added_mass": 0.5 * jnp.dot(rate, (rotation(q[d:]).T @ v[:d]) ** 2)}

    def place(self, q: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """x + R(angles) point (m)."""
        return place_of(q, point)

    def shift(self, u: Float[Array, " m"], point: Float[Array, " d"]) -> Float[Array, " d"]:
        """The move of the centre of gravity and what the turn adds (m)."""
        d = point.shape[0]
        angles = self.reference[d:]
        return u[:d] + (rotation(angles + u[d:]) - rotation(angles)) @ point

    def rate(
        self, q: Float[Array, " m"], v: Float[Array, " m"], point: Float[Array, " d"]
    ) -> tuple[Float[Array, "d m"], Float[Array, " d"], Float[Array, " d"]]:
        """J = dr/dq, J v (m/s) and (dJ/dt) v (m/s2), written down."""
        return point_rate(q, v, point)

    def turning(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> Float[Array, " m"]:
        """The velocity terms of inertia, written down, with the masses of the moment."""
        return turning_force(q, v, self.masses(q, t), self.inertia)

    def stored(self, q: Float[Array, " m"]) -> dict[str, Float[Array, ""]]:
        """The loads' energies (J)."""
        total: dict[str, Float[Array, ""]] = {}
        for load in self.loads:
            value = load.energy(q)
            total[load.energy_name] = total.get(load.energy_name, jnp.zeros_like(value)) + value
        return total

    def stiffest(
        self, q: Float[Array, " m"]
    ) -> tuple[Float[Array, "m m"], Float[Array, "m m"] | None]:
        """That of its loads, and that of its resistances."""
        size = q.shape[0]
        stiffness = sum((load.stiffest(q) for load in self.loads), jnp.zeros((size, size), q.dtype))
        damping = [d for d in (r.stiffest(q) for r in self.resistances) if d is not None]
        return stiffness, sum(damping[1:], damping[0]) if damping else None

    def resisting(
        self, q: Float[Array, " m"], v: Float[Array, " m"], t: Float[Array, ""] | None = None
    ) -> dict[str, Float[Array, " m"]]:
        """The forces (N, N m) of the resistances and of waves."""
        total: dict[str, Float[Array, " m"]] = {}
        for resistance in self.resistances:
            value = resistance.force(q, v, t)
            kind = resistance.work_name
            total[kind] = total[kind] + value if kind in total else value
        if self.waves is not None:
            still = t is None
            total[self.waves.work_name] = jnp.zeros_like(q) if still else self.waves.force(q, t)
        return total

    def works(self) -> tuple[str, ...]:
        """The kinds of work of the resistances, of added mass that changes, of waves and of friction."""
        kinds = [r.work_name for r in self.resistances]
        kinds += [] if self.added is None else ["added_mass"]
        kinds += [] if self.waves is None else [self.waves.work_name]
        return tuple(dict.fromkeys(kinds + ["friction"] * (self.friction is not None)))
