"""Cargo on an ideal cable: no weight, no stiffness, one tension from post to post."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite, positive
from .law import Array, root

__all__ = ["IdealHighline"]


@dataclass(frozen=True)
class IdealHighline:
    """A mass on a weightless cable that a winch keeps at constant tension between two fixed posts.

    The cable runs straight from either post to the mass (Gao et al. 2022, eq. 17-18, without the
    swing of the cargo). Its potential energy is tension times length, so that with the mass moved
    along at x = `place` the height z follows from m z'' = T (sin a + sin b) - m g. The printed x
    equation of eq. 17 has the wrong sign: the horizontal force is T (cos b - cos a) with a towards the
    post at 0, as a step towards one post must be pulled back; as printed the rest state is unstable.

    Args:
        span: horizontal distance of the posts, m.
        tension: T, N.
        mass: m, kg.
        gravity: g, m/s^2.
        place: horizontal distance of the mass from the first post, m; midspan if absent.
        rise: height of the second post over the first, m.
    """

    span: float
    tension: float
    mass: float
    gravity: float
    place: float | None = None
    rise: float = 0.0

    def __post_init__(self) -> None:
        positive("span", "m", self.span)
        positive("tension", "N", self.tension)
        positive("mass", "kg", self.mass)
        finite(gravity=self.gravity, place=self._a, rise=self.rise)
        if self.gravity < 0.0:
            raise ValueError(f"expected a gravity of 0 m/s^2 or more, found {self.gravity:g}")
        if not 0.0 < self._a < self.span:
            raise ValueError(
                f"expected a place between the posts, from 0 m to {self.span:g} m, "
                f"found {self._a:g} m"
            )
        if not self.mass * self.gravity < 2.0 * self.tension:
            raise ValueError(
                f"expected a tension above half the weight, {self.mass * self.gravity / 2:g} N, "
                f"found {self.tension:g} N"
            )

    @property
    def _a(self) -> float:
        return 0.5 * self.span if self.place is None else self.place

    @property
    def _b(self) -> float:
        return self.span - self._a

    def lift(self, z: float) -> float:
        """Return the vertical force of the cable (N) on the mass at height z (m) over the first post."""
        up_a, up_b = -z, self.rise - z
        return self.tension * (up_a / np.hypot(self._a, up_a) + up_b / np.hypot(self._b, up_b))

    def potential(self, z: Array | float) -> Array:
        """Return tension times length plus m g z (J) at a height z (m)."""
        z = np.asarray(z, float)
        length = np.hypot(self._a, z) + np.hypot(self._b, self.rise - z)
        return self.tension * length + self.mass * self.gravity * z

    def height(self) -> float:
        """Return the height z (m) of the mass at rest, over the first post; negative where it sags."""
        weight = self.mass * self.gravity
        far = self.span
        while self.lift(-far) < weight:
            far *= 2.0
        return root(lambda z: self.lift(z) - weight, -far, max(0.0, self.rise))

    def stiffness(self) -> tuple[float, float]:
        """Return (along, vertical) stiffness (N/m) about the place of rest; no coupling counted.

        A part of length s at the slope sin p adds T sin^2 p / s along and T cos^2 p / s upwards. At
        midspan between level posts the two directions do not couple.
        """
        z = self.height()
        along = vertical = 0.0
        for across, up in ((self._a, -z), (self._b, self.rise - z)):
            size = np.hypot(across, up)
            along += self.tension * up**2 / size**3
            vertical += self.tension * across**2 / size**3
        return along, vertical

    def periods(self) -> tuple[float, float]:
        """Return the periods (s) of small oscillations along and up and down, at midspan."""
        along, vertical = (2.0 * np.pi * np.sqrt(self.mass / k) for k in self.stiffness())
        return float(along), float(vertical)

    def hung_periods(self, depth: float, inertia: float) -> Array:
        """Return the three small-oscillation periods (s), longest first, of a body under its trolley.

        The cable carries the body at a point `depth` h (m) above its centre of mass; it turns with
        `inertia` J (kg m2) about that centre. At midspan between level posts, with the along
        stiffness k and the turn f, the potential is k (x + h f)^2 / 2 + m g h f^2 / 2; up and down the
        body moves as a point does.
        """
        finite(depth=depth)
        positive("inertia", "kg m2", inertia)
        k, vertical = self.stiffness()
        weight = self.mass * self.gravity
        stiff = np.array([[k, k * depth], [k * depth, k * depth**2 + weight * depth]])
        scale = 1.0 / np.sqrt(np.array([self.mass, inertia]))
        squares = np.linalg.eigvalsh(stiff * np.outer(scale, scale))
        squares = np.append(squares, vertical / self.mass)
        return np.sort(2.0 * np.pi / np.sqrt(squares))[::-1]

    def _above(self, first: ArrayLike, second: ArrayLike) -> Array:
        """Potential at `first` less that at `second`, J, over the difference of both heights (N).

        Heights are counted from rest, where the pulls hold the weight. For a post a across the mass and
        z0 over it at rest, with h = hypot(a, z) and g = (h0 h - z0 z + a^2)/(h + h0),

            h1 - h2 - (z0/h0)(z1 - z2) = (z1 - z2)(g1 (z1 - z0) + g2 (z2 - z0))/(h0 (h1 + h2)):

        no difference of near numbers, of which potentials of MJ would leave none of a small swing.
        """
        rest = self.height()
        total = np.zeros(np.broadcast_shapes(np.shape(first), np.shape(second)))
        for a, z0 in ((self._a, rest), (self._b, rest - self.rise)):
            h0 = np.hypot(a, z0)
            moments, lengths = 0.0, 0.0
            for u in (np.asarray(first, float), np.asarray(second, float)):
                h = np.hypot(a, z0 + u)
                moments = moments + u * (h0 * h - z0 * (z0 + u) + a**2) / (h + h0)
                lengths = lengths + h
            total = total + self.tension * moments / (h0 * lengths)
        return total

    def lowest(self, start: float) -> float:
        """Return the height z (m) at which a mass let go at rest from `start` (m) turns round."""
        finite(start=start)
        rest = self.height()
        return rest + self._turn(start - rest)

    def _turn(self, up: float) -> float:
        """Where a mass let go `up` (m) over rest turns round, m over rest: below 0."""
        if up == 0.0:
            return 0.0
        if not up > 0.0:
            rest = self.height()
            raise ValueError(f"expected a start above rest at {rest:g} m, found {rest + up:g} m")
        far = -up
        while self._above(far, up) > 0.0:  # V there is still below that of the start
            far -= up
        return root(lambda u: float(self._above(u, up)), far, 0.0)

    def top_speed(self, start: float) -> float:
        """Return the largest speed (m/s) of a mass let go at rest from `start` (m)."""
        finite(start=start)
        up = start - self.height()
        return float(np.sqrt(2.0 * up * self._above(up, 0.0) / self.mass))

    def period_from(self, start: float, points: int = 200) -> float:
        """Return the period (s) of the up and down motion of a mass let go from `start` (m).

        2 times the integral of dz / sqrt(2 (E - V) / m) between the turning points, which
        z = middle - half cos(p) makes smooth, by Gauss's rule with `points` points. From rest, the
        period of small oscillations.
        """
        finite(start=start)
        up = start - self.height()
        if up == 0.0:
            return self.periods()[1]
        low = self._turn(up)
        half = 0.5 * (up - low)
        node, weight = np.polynomial.legendre.leggauss(points)
        p = 0.5 * np.pi * (node + 1.0)
        # E is V at both turning points: each half of the way takes the nearer
        fallen, risen = 2.0 * half * np.cos(0.5 * p) ** 2, 2.0 * half * np.sin(0.5 * p) ** 2
        upper = p > 0.5 * np.pi
        lost = np.where(
            upper,
            fallen * self._above(up, up - fallen),
            -risen * self._above(low, low + risen),
        )
        speed = np.sqrt(2.0 * lost / self.mass)
        return float(2.0 * np.sum(0.5 * np.pi * weight * half * np.sin(p) / speed))
