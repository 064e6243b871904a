"""What ties a body to a cable that runs past it: an ideal cable, or a trolley on a lumped line."""

import abc
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from lumpedcable.physics import contact
from lumpedcable.physics.load import Shape
from lumpedcable.physics.motion import AbstractMotion

__all__ = [
    "AbstractCoupling",
    "BodyPost",
    "CableState",
    "IdealCable",
    "Kick",
    "PostState",
    "Posts",
    "Pull",
    "Taken",
    "Trolley",
]


SLOWINGS = 12  # Newton steps to a slip that friction slows


class Kick(NamedTuple):
    """What a kick of length `dt` (s) does to a line's nodes.

    `force` (d, n+1) is all on them (N) but for bodies that run on the line, `ease` (n+1,) one over their
    mass along the line (1/kg), 0 at the ends, which are held.
    """

    force: Float[Array, "d nodes"]
    ease: Float[Array, " nodes"]
    dt: Float[Array, ""]


class CableState(NamedTuple):
    """The line that a body runs on: its shape, velocities (d, n+1) in m/s or None at rest.

    `growth` (1/s) is the payout speed over the paid-out length, None without a winch. Payout leaves the
    line's substance where it is at the end without the winch, `still` segments from the line's start.
    `kick` is that at whose middle the forces are asked for, None at an instant.
    """

    shape: Shape
    velocity: Float[Array, "d nodes"] | None
    growth: Float[Array, ""] | None = None
    still: float = 0.0
    kick: Kick | None = None


class BodyPost(eqx.Module):
    """A post on a rigid body of the scene, at `point` (d,) in its axes (m)."""

    body: str = eqx.field(static=True)
    point: Float[Array, " d"]


class PostState(NamedTuple):
    """Where a post is (m) and how fast it moves (m/s); whether a body of the scene carries it."""

    place: Float[Array, " d"]
    velocity: Float[Array, " d"]
    carried: bool


class Posts(NamedTuple):
    """The two posts of a cable without nodes."""

    start: PostState
    end: PostState


class Taken(NamedTuple):
    """A force that takes energy (N): on the body (d,), on the line's nodes (d, n+1).

    `payout` (J) is its virtual work where the line's length grows by itself at fixed nodes.
    """

    body: Float[Array, " d"]
    line: Float[Array, "d nodes"]
    payout: Float[Array, ""]


class Pull(NamedTuple):
    """Forces of a coupling (N): on the body at its trolley (d,), on the line's nodes (d, n+1) or None.

    `energy` (J) is what it stores, of which `kink` is what it falls by where
    segments grow by their own length. `given`
    is the power (W) of moving posts; `taken` are those of the forces that take energy, by kind of work.
    """

    body: Float[Array, " d"]
    line: Float[Array, "d nodes"] | None
    energy: Float[Array, ""]
    given: dict[str, Float[Array, ""]]
    taken: dict[str, Taken]
    kink: Float[Array, ""] | None = None
    posts: tuple[Float[Array, " d"], ...] = ()


class AbstractCoupling(eqx.Module):
    """A law between a body's trolley at `place` (m) that moves at `velocity` (m/s) and a cable."""

    @property
    @abc.abstractmethod
    def energy_name(self) -> str:
        """The dataset that its energy is added to."""

    @property
    @abc.abstractmethod
    def works(self) -> tuple[str, ...]:
        """The kinds of work that it does, keys of `model.energy.WORKS`."""

    @abc.abstractmethod
    def pull(
        self,
        t: Float[Array, ""],
        place: Float[Array, " d"],
        velocity: Float[Array, " d"] | None,
        cable: CableState | Posts,
    ) -> Pull:
        """Forces, energy and work at t (s); without velocities (None) those at rest.

        `cable` is the line, or the posts of a cable without nodes.
        """

    @abc.abstractmethod
    def stiffness(self, place: Float[Array, " d"], posts: Posts | None) -> Float[Array, ""]:
        """Upper bound of the stiffness (N/m) with which it holds the body."""


class IdealCable(AbstractCoupling):
    """A cable without mass or stiffness, straight from either post to the body, of one tension.

    F = T (a + b) with a, b the unit vectors towards the posts (Gao et al. 2022, eq. 17-18; the sign of
    the printed horizontal force is wrong, see `exact.IdealHighline`). The winch gives and takes
    T times length, which is the energy; posts that are moved do the work T (dA/dt . -a + dB/dt . -b),
    those on bodies of the scene pull at them.
    """

    start: AbstractMotion | BodyPost
    end: AbstractMotion | BodyPost
    tension: Float[Array, ""]

    @property
    def energy_name(self) -> str:
        """The winch stores it."""
        return "winch"

    @property
    def works(self) -> tuple[str, ...]:
        """Of the posts."""
        return ("ends",)

    def pull(self, t, place, velocity, cable) -> Pull:
        """T (a + b), the energy T (|A - r| + |B - r|), and the power of the posts."""
        assert isinstance(cable, Posts)
        force, length = jnp.zeros_like(place), jnp.zeros((), place.dtype)
        power, T, posts = jnp.zeros((), place.dtype), self.tension, []
        for post in cable:
            way = post.place.astype(place.dtype) - place
            size = jnp.sqrt(jnp.sum(way**2))
            force = force + way / size
            length = length + size
            posts.append(-T * way / size)
            if not post.carried:
                power = power + jnp.dot(way / size, post.velocity.astype(place.dtype))
        return Pull(T * force, None, T * length, {"ends": T * power}, {}, None, tuple(posts))

    def stiffness(self, place, posts) -> Float[Array, ""]:
        """T (1/|A - r| + 1/|B - r|)."""
        ways = [jnp.sum((post.place - place) ** 2) for post in posts or ()]
        return self.tension * sum(1.0 / jnp.sqrt(way) for way in ways)


class Trolley(AbstractCoupling):
    """A sheave that runs on a lumped line (see `contact`), with friction mu tanh(v / v0) |push|.

    `tension` (N) is the one that the contact is scaled with, the winch's or that of the start:
    the tension of the moment would feed axial waves. `stretch` is 1 + e under it. v is the speed of
    the sheave along the line relative to the line's own substance (Gao et al. 2022, eq. 11). With
    `hertz` the wheel sinks into the line (eq. 10); it is kept on the line from both sides. `EI` (N m2)
    is that of the line, None without bending.

    What a winch pays out is spread over all segments, so that the substance at s passes the nodes with
    -(s - s0) C' L'/L, s0 being the end without the winch: v has the part (s - s0) |C'| L'/L. The virtual
    work of the friction f is -f times the variation of the slip, of which L has its part as well,
    -f (s - s0) |C'| / L. So friction takes f v >= 0, and together with the mean of the line's tensions,
    which pulls at the winch, it leaves the tension between sheave and winch.
    """

    tension: Float[Array, ""]
    stretch: Float[Array, ""]
    friction: Float[Array, ""] | None = None
    fade: Float[Array, ""] | None = None
    hertz: contact.Hertz | None = None
    EI: Float[Array, ""] | None = None

    @property
    def energy_name(self) -> str:
        """The contact stores it."""
        return "contact"

    @property
    def works(self) -> tuple[str, ...]:
        """Of friction and of the contact's damping."""
        damped = self.hertz is not None and self.hertz.damping is not None
        present = {"friction": self.friction is not None, "contact": damped}
        return tuple(kind for kind in present if present[kind])

    def pull(self, t, place, velocity, cable) -> Pull:
        """The contact's push and friction on the sheave, the opposite on the nodes, and their energy."""
        assert isinstance(cable, CableState)
        nodes = cable.shape.position
        length = cable.shape.segment_length[0] * self.stretch
        touch = contact.contact(nodes, place, self.tension, length, self.hertz, self.EI)
        energy = touch.kink_energy
        if self.hertz is not None:
            energy = energy + self.hertz.energy(touch.depth)
        body, line = -touch.push, contact.spread(touch, touch.push, nodes.shape[1])
        taken = {}
        for kind in self.works:
            own, work = jnp.zeros_like(place), jnp.zeros_like(energy)
            if velocity is not None and cable.velocity is not None:
                own = self._resisting(kind, touch, velocity, cable)
                if kind == "friction" and cable.growth is not None:
                    work = jnp.dot(own, self._passed(touch, cable))
            other = -contact.spread(touch, own, nodes.shape[1])
            body, line, taken[kind] = body + own, line + other, Taken(own, other, work)
        return Pull(body, line, energy, {}, taken, touch.fall)

    def _resisting(
        self, kind: str, touch: contact.Contact, velocity, cable: CableState
    ) -> Float[Array, " d"]:
        """Force (N) on the sheave of one kind of work, where it moves."""
        assert cable.velocity is not None
        size = jnp.sqrt(jnp.maximum(jnp.dot(touch.push, touch.push), 1e-300))
        if kind == "friction" and self.friction is not None and self.fade is not None:
            slip = jnp.dot(self._slip(touch, velocity, cable), touch.tangent)
            limit = self.friction * size
            if cable.kick is not None:
                slip = _at_middle(slip, limit, self.fade, touch, cable.kick)
            return -limit * jnp.tanh(slip / self.fade) * touch.tangent
        assert self.hertz is not None
        across = touch.push / size
        sinking = jnp.dot(velocity - contact.velocity_at(touch, cable.velocity), across)
        return -self.hertz.drag(touch.depth, touch.stiffness) * sinking * across

    def _slip(self, touch: contact.Contact, velocity, cable: CableState) -> Float[Array, " d"]:
        """Velocity (m/s) of the sheave relative to the line's substance."""
        assert cable.velocity is not None  # at rest nothing slips
        slip = velocity - contact.velocity_at(touch, cable.velocity)
        return slip if cable.growth is None else slip + cable.growth * self._passed(touch, cable)

    def _passed(self, touch: contact.Contact, cable: CableState) -> Float[Array, " d"]:
        """Line (m) that passes the foot backwards where the length grows by itself at fixed nodes."""
        return (touch.foot - cable.still) * touch.spacing * touch.tangent

    def stiffness(self, place, posts) -> Float[Array, ""]:
        """None of its own: the line's nodes bound it."""
        return jnp.zeros((), place.dtype)


def _at_middle(
    slip: Float[Array, ""], limit, fade, touch: contact.Contact, kick: Kick
) -> Float[Array, ""]:
    """The slip (m/s) at the middle of a kick, from that of half a step before, with friction in between.

    A friction that lags throws light nodes to and fro: below the slip mu N dt / m that it gives them in
    a step it changes its sign in every one, and comes to nothing. The middle makes it of second order
    and keeps friction times slip above 0. Body and winch are heavy beside the nodes, whose motion alone
    is looked ahead at.
    """
    nodes = kick.ease.shape[0]
    weights = contact.spread(touch, jnp.ones_like(touch.push[:1]), nodes)[0]
    gain = (kick.force + touch.push[:, None] * weights) * kick.ease
    free = slip - 0.5 * kick.dt * jnp.dot(gain @ weights, touch.tangent)
    held = 0.5 * kick.dt * limit * jnp.sum(weights**2 * kick.ease)
    return slowed(free, held, fade)


def slowed(
    free: Float[Array, ""], held: Float[Array, ""], fade: Float[Array, ""]
) -> Float[Array, ""]:
    """v (m/s) of v + `held` tanh(v / `fade`) = `free`, all in m/s.

    By Newton's method from below, where the left side is concave: no step goes past the root.
    """
    sign = jnp.where(free < 0.0, -1.0, 1.0).astype(free.dtype)
    b, c = sign * free / fade, held / fade
    x = jnp.maximum(b - c, b / (1.0 + c))
    for _ in range(SLOWINGS):
        bent = jnp.tanh(x)
        x = x - (x + c * bent - b) / (1.0 + c * (1.0 - bent**2))
    return sign * fade * x
