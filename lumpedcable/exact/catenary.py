"""Elastic catenary between two ends, hanging free or resting on a flat seabed.

With s the unstretched distance from end A, w the weight per unstretched length in water, H the
horizontal and V(s) = V_A + w s the vertical component of the tension t = sqrt(H^2 + V^2), and a
linear law of stiffness EA,

    x(s) = H s/EA + (H/w) [asinh(V(s)/H) - asinh(V_A/H)],
    z(s) = (V_A s + w s^2/2)/EA + [t(s) - t(0)]/w.

On the bottom V = 0, and friction takes C_B w per unstretched length off the tension towards an
anchor A: H(s) = max(H - C_B w (l_B - s), 0). Source: H. M. Irvine, Cable Structures (1981),
chapter 1, the elastic catenary; J. M. Jonkman, NREL/TP-500-41958 (2007), chapter 2, the
quasi-static mooring lines. Written here for any two heights over the bottom.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite
from .law import Array, root
from .newton import convex_minimum


@dataclass(frozen=True)
class Catenary:
    """A line in its plane: x horizontal from end A towards end B, z up, both 0 at A.

    Attributes:
        span: horizontal distance from A to B, m.
        rise: height of B over A, m.
        length: unstretched length, m.
        EA: axial stiffness, N; inf for an inextensible line.
        weight: weight per unstretched length in water, N/m; negative for a buoyant line.
        friction: coefficient C_B on the bottom.
        horizontal: horizontal tension H in the hanging part, N.
        bottom_start: unstretched position at which the line meets the bottom, m.
        bottom_end: unstretched position at which it leaves the bottom, m. Both are the lowest
            point (of the line or of its extension) where nothing rests on the bottom.
        vertical_a: vertical tension V_A, N (negative: the line leaves A downwards).
    """

    span: float
    rise: float
    length: float
    EA: float
    weight: float
    friction: float
    horizontal: float
    bottom_start: float
    bottom_end: float
    vertical_a: float

    @property
    def bottom_length(self) -> float:
        """Unstretched length on the bottom, m."""
        return self.bottom_end - self.bottom_start

    @property
    def force_on_a(self) -> tuple[float, float]:
        """Force (x, z) of the line on end A, N."""
        return float(self.horizontal_tension(0.0)), float(self.vertical_tension(0.0))

    @property
    def force_on_b(self) -> tuple[float, float]:
        """Force (x, z) of the line on end B, N."""
        return -self.horizontal, -float(self.vertical_tension(self.length))

    def horizontal_tension(self, s: ArrayLike) -> Array:
        """Return the horizontal component of the tension at s, N."""
        s = np.asarray(s, float)
        lost = self.friction * self.weight * (self.bottom_end - s)
        on = (s >= self.bottom_start) & (s <= self.bottom_end) & (self.bottom_length > 0.0)
        return np.where(on, np.maximum(self.horizontal - lost, 0.0), self.horizontal)

    def vertical_tension(self, s: ArrayLike) -> Array:
        """Return the vertical component of the tension at s, N; positive where z rises with s."""
        s = np.asarray(s, float)
        if self.bottom_length <= 0.0:
            return self.vertical_a + self.weight * s
        below = np.minimum(s - self.bottom_start, 0.0) + np.maximum(s - self.bottom_end, 0.0)
        return self.weight * below

    def tension(self, s: ArrayLike) -> Array:
        """Return the tension at s, N."""
        return np.hypot(self.horizontal_tension(s), self.vertical_tension(s))

    def position(self, s: ArrayLike) -> tuple[Array, Array]:
        """Return x(s) and z(s), m, at the unstretched distance s from end A (m).

        Length that is left over on the bottom (H = 0) lies in a heap below end B.
        """
        s = np.asarray(s, float)
        if np.any((s < 0.0) | (s > self.length)):
            raise ValueError(f"s runs from 0 at end A to {self.length:g} m at end B")
        H, w, EA = self.horizontal, self.weight, self.EA
        if self.bottom_length <= 0.0:
            return _reach(H, self.vertical_a, s, w, EA)
        first = np.minimum(s, self.bottom_start)
        x, z = _reach(H, -w * self.bottom_start, first, w, EA)
        on = np.clip(s - self.bottom_start, 0.0, self.bottom_length)
        x = x + on + self._bottom_stretch(on)
        x = np.minimum(x, self.span) if H == 0.0 else x
        x2, z2 = _reach(H, 0.0, np.maximum(s - self.bottom_end, 0.0), w, EA)
        return x + x2, z + z2

    def _bottom_stretch(self, on: Array) -> Array:
        """Stretch of the first `on` metres on the bottom: the integral of H(s)/EA, m."""
        lost = self.friction * self.weight
        pulled = _pulled(self.horizontal, self.bottom_length, lost)
        u = np.maximum(on - (self.bottom_length - pulled), 0.0)  # metres under tension
        return (self.horizontal * u - lost * (pulled * u - 0.5 * u**2)) / self.EA


def elastic_catenary(
    span: float,
    rise: float,
    length: float,
    EA: float,
    weight: float,
    *,
    seabed: float | None = None,
    friction: float = 0.0,
) -> Catenary:
    """Return the elastic catenary between A at (0, 0) and B at (span, rise).

    A free line is the minimum of its complementary energy in (H, V_A), strictly convex, found by
    damped Newton steps whatever the slackness. A line that would sink below the seabed rests on
    it: for a given H the hanging parts follow in closed form, and H from one bracketed root. Where
    the hanging parts reach the bottom vertically and length is left over, H = 0.

    Args:
        span: horizontal distance, m, zero or more.
        rise: height of B over A, m.
        length: unstretched length, m.
        EA: axial stiffness, N; inf is inextensible.
        weight: weight per unstretched length in water, N/m; 0 needs a taut line.
        seabed: height of the bottom over A, m (0: A lies on it); None: no bottom.
        friction: coefficient C_B of the bottom; needs A on it.

    Raises:
        ValueError: for a line that is too short, a weightless slack one, an end below the
            seabed, or friction without an anchor on the bottom.
    """
    finite(span=span, rise=rise, length=length, weight=weight, friction=friction)
    finite(seabed=0.0 if seabed is None else seabed)
    _check(span, rise, length, EA, weight)
    if seabed is not None:
        _check_seabed(rise, weight, seabed, friction)
    elif friction != 0.0:
        raise ValueError("friction needs a seabed: give seabed=0 for an anchor A on the bottom")
    data = (float(span), float(rise), float(length), float(EA), float(weight), float(friction))
    H, V_a = _free(*data[:5])
    lowest = -V_a / weight if weight != 0.0 else 0.0
    free = Catenary(*data, H, lowest, lowest, V_a)
    if seabed is None or not 0.0 < lowest < length:
        return free
    if float(free.position(lowest)[1]) >= seabed:
        return free
    return _on_bottom(data, -seabed, rise - seabed)


def _check(span: float, rise: float, length: float, EA: float, weight: float) -> None:
    for name, value in (("length", length), ("EA", EA)):
        if not value > 0.0:
            raise ValueError(f"expected a positive {name}, found {value:g}")
    if not span >= 0.0:
        raise ValueError(f"expected a span of 0 m or more, found {span:g}")
    chord = float(np.hypot(span, rise))
    if chord >= length and np.isinf(EA):
        raise ValueError(f"an inextensible line of {length:g} m does not span {chord:g} m")
    if weight == 0.0 and chord <= length:
        raise ValueError("a weightless line that is not taut has no definite shape")


def _check_seabed(rise: float, weight: float, seabed: float, friction: float) -> None:
    if not weight > 0.0:
        raise ValueError(f"a line rests on the seabed by its weight: found {weight:g} N/m")
    if seabed > min(0.0, rise):
        raise ValueError(f"an end lies below the seabed at {seabed:g} m over end A")
    if friction < 0.0:
        raise ValueError(f"expected a friction coefficient of 0 or more, found {friction:g}")
    if friction > 0.0 and seabed != 0.0:
        raise ValueError("friction acts towards an anchor A on the bottom: expected seabed = 0")


def _reach(H: float, V_a: float, s: ArrayLike, w: float, EA: float) -> tuple[Array, Array]:
    """Return x and z at the unstretched distance s from a point with tension (H, V_a).

    The differences of asinh and of t are written without cancellation, from
    tanh((y - x)/2) = (sinh y - sinh x)/(cosh y + cosh x), so that taut and light lines keep
    their digits.
    """
    s = np.asarray(s, float)
    V_b = V_a + w * s
    t_a, t_b = np.hypot(H, V_a), np.hypot(H, V_b)
    total = np.where(t_a + t_b > 0.0, t_a + t_b, 1.0)
    z = 0.5 * s * (V_a + V_b) * (1.0 / EA + 2.0 / total)
    if H <= 0.0:
        return np.zeros(s.shape), z
    q = _plus(H, V_a) + _plus(H, -V_b)
    turn = w * s
    straight = np.abs(turn) < 1e-300
    angle = np.log1p(2.0 * np.where(straight, 1.0, turn) / q) / np.where(straight, 1.0, turn)
    return H * s * (1.0 / EA + np.where(straight, 2.0 / q, angle)), z


def _plus(H: float, V: ArrayLike) -> Array:
    """sqrt(H^2 + V^2) + V without cancellation."""
    V = np.asarray(V, float)
    t = np.hypot(H, V)
    return np.where(V >= 0.0, t + V, H * H / (t + np.abs(V)))


def _free(span: float, rise: float, length: float, EA: float, w: float) -> tuple[float, float]:
    """Return H and V_A of a line that touches nothing."""
    chord = float(np.hypot(span, rise))
    size = max(chord, length)
    if w < 0.0:  # a buoyant line hangs upwards
        H, V_a = _free(span, -rise, length, EA, -w)
        return H, -V_a
    if span == 0.0:
        return 0.0, _vertical(rise, length, EA, w)
    if w == 0.0:
        T = EA * (chord / length - 1.0)
        return T * span / chord, T * rise / chord

    def gradient(x: Array) -> tuple[Array, Array]:
        H, V_a = float(x[0]), float(x[1])
        reach = _reach(H, V_a, length, w, EA)
        return np.array([reach[0] - span, reach[1] - rise]), _compliance(H, V_a, length, w, EA)

    return tuple(convex_minimum(gradient, _guess(span, rise, length, EA, w), size, 1).tolist())


def _guess(span: float, rise: float, length: float, EA: float, w: float) -> Array:
    """First guess of H and V_A: the parabola of a slack line, the spring of a taut one."""
    chord = float(np.hypot(span, rise))
    slack = max((length**2 - rise**2) / span**2 - 1.0, 0.0)
    sag = max(float(np.sqrt(3.0 * slack)), 0.2)
    pull = EA * max(chord / length - 1.0, 0.0) if np.isfinite(EA) else 0.0
    H = w * span / (2.0 * sag) + pull * span / chord
    V_b = 0.5 * w * (rise / np.tanh(sag) + length) + pull * rise / chord
    return np.array([H, V_b - w * length])


def _compliance(H: float, V_a: float, length: float, w: float, EA: float) -> Array:
    """Derivatives of the reach with respect to H and V_A, m/N, shape (2, 2)."""
    V_b = V_a + w * length
    up, down = np.arctan2(V_b, H), np.arctan2(V_a, H)
    half = 0.5 * np.arctan2(H * w * length, H**2 + V_a * V_b)
    mean = 0.5 * (up + down)
    sines, cosines = 2.0 * np.cos(mean) * np.sin(half), 2.0 * np.sin(mean) * np.sin(half)
    angle = float(np.log1p(2.0 * w * length / (_plus(H, V_a) + _plus(H, -V_b))))
    xx = max(angle - sines, 0.0) / w + length / EA
    return np.array([[xx, -cosines / w], [-cosines / w, sines / w + length / EA]])


def _vertical(rise: float, length: float, EA: float, w: float) -> float:
    """Return V_A of a line whose ends lie above one another (H = 0)."""

    def miss(V_a: float) -> float:
        return float(_reach(0.0, V_a, length, w, EA)[1]) - rise

    if w == 0.0:
        return float(np.copysign(EA * (abs(rise) / length - 1.0), rise))
    pull = EA * max(abs(rise) / length - 1.0, 0.0) if np.isfinite(EA) else 0.0
    bound = 2.0 * (pull + w * length)
    return root(miss, -bound, bound)


def _hanging(H: float, height: float, w: float, EA: float) -> float:
    """Return V at the top of a part that rises `height` from a horizontal tangent with tension H.

    With p = t - H the height is p (1 + (2 H + p)/(2 EA)) = w h, a quadratic.
    """
    b = 1.0 + H / EA
    p = 2.0 * w * height / (b + np.sqrt(b**2 + 2.0 * w * height / EA))
    return float(np.sqrt(p * (p + 2.0 * H)))


def _pulled(H: float, bottom: float, lost: float) -> float:
    """Length on the bottom that is under tension, m; friction takes `lost` (N/m) off it."""
    return bottom if lost * bottom <= H else H / lost


def _on_bottom(data: tuple[float, ...], height_a: float, height_b: float) -> Catenary:
    """Return the line that rests on the bottom, its ends at these heights over it."""
    span, rise, length, EA, w, friction = data

    def parts(H: float) -> tuple[float, float]:
        return _hanging(H, height_a, w, EA) / w, _hanging(H, height_b, w, EA) / w

    def build(H: float) -> Catenary:
        left, right = parts(H)
        return Catenary(
            span=span,
            rise=rise,
            length=length,
            EA=EA,
            weight=w,
            friction=friction,
            horizontal=H,
            bottom_start=left,
            bottom_end=max(length - right, left),
            vertical_a=-w * left,
        )

    def miss(H: float) -> float:
        line = build(H)
        # Without H nothing hangs sideways, and position() hides what is left over.
        reach = line.bottom_length if H == 0.0 else float(line.position(length)[0])
        return reach - span

    if miss(0.0) >= 0.0:
        return build(0.0)
    # Upper bound: the line reaches too far, or just lifts off (a soft one never does).
    top = w * length
    while sum(parts(top)) < length and miss(top) <= 0.0:
        top *= 2.0
    if sum(parts(top)) >= length:
        top = root(lambda H: sum(parts(H)) - length, 0.0, top)
    return build(root(miss, 0.0, top) if miss(top) > 0.0 else top)
