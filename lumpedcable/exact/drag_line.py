"""A weightless inextensible line swept sideways by a uniform current."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .checks import finite
from .law import Array, root


@dataclass(frozen=True)
class DragLine:
    """A line held at two points across a current; y across the flow, x downstream.

    Only the normal drag per length D sin^2(phi) acts, phi the angle between line and current and
    D = rho d C_dn U^2/2. It has no component along the line, so the tension T is constant, and

        T dphi/ds = D sin^2(phi)

    is the curve x = a cosh(y/a), a = T/D: the line takes the shape of a catenary. Both ends lie
    on the same line across the current. Source: L. Pode, David Taylor Model Basin Report 687
    (1951), for zero weight and zero tangential drag.

    Attributes:
        span: distance between the ends across the current, m.
        length: length of the line, m.
        drag: D, normal drag per length of a line across the current, N/m.
        tension: T, N.
    """

    span: float
    length: float
    drag: float
    tension: float

    def position(self, s: ArrayLike) -> tuple[Array, Array]:
        """Return y(s) from mid-span and x(s) from the line through the ends, m.

        s is the distance along the line from the end at y = -span/2, m.
        """
        a = self.tension / self.drag
        y = a * np.arcsinh((np.asarray(s, float) - 0.5 * self.length) / a)
        return y, a * (np.cosh(0.5 * self.span / a) - np.cosh(y / a))

    @property
    def sag(self) -> float:
        """How far the middle is swept downstream, m."""
        return float(self.position(0.5 * self.length)[1])


def drag_line(span: float, length: float, drag: float) -> DragLine:
    """Return the line between two points `span` apart across the current.

    With a = T/D the length is L = 2 a sinh(B/(2 a)).

    Args:
        span: B, m.
        length: L, m, longer than the span.
        drag: D = rho d C_dn U^2/2, N/m.

    Raises:
        ValueError: if the line is not longer than the span or the drag not positive.
    """
    finite(span=span, length=length, drag=drag)
    if not 0.0 < span < length:
        raise ValueError(f"expected 0 < span < length, found {span:g} m and {length:g} m")
    if not drag > 0.0:
        raise ValueError(f"expected a positive drag in N/m, found {drag:g}")
    ratio = length / span
    # sinh(k)/k = L/B with k = B/(2 a).
    k = root(lambda k: np.sinh(k) / k - ratio, 1e-9, 2.0 + 2.0 * np.log(2.0 * ratio))
    return DragLine(span, length, drag, drag * span / (2.0 * k))
