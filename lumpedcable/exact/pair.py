"""Two catenaries that share their horizontal tension H and meet at a point K.

With the slopes of `lumpedcable.exact.highline`, downwards positive, the upward pulls of both parts
carry the load G that hangs at K: H (u- - u+) = G, u- and u+ the slopes left and right of K. A line
is known by H and its slope at A: one condition is that it ends at B, the other what is known of it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .highline import Highline, Part
from .roots import STEP, Values, met

Meets = Callable[[Values, Values], Values]
"""H (N) and the slope at A to the x (m) at which the first part ends."""

Known = Callable[[Highline], Values]
"""What is known of a line: its length (m), or the tension (N) at one end."""

_OWED = 1e-8  # of both conditions: far over their rounding, far under what is no root


@dataclass(frozen=True)
class Pair:
    """What is known of two catenaries between A and B but for H and one more number."""

    span: Values
    drop: Values
    weights: tuple[Values, Values]
    load: Values
    meets: Meets

    def line(self, H: Values, slope: Values) -> Highline:
        """The line that leaves A with a slope, wherever it ends."""
        reach = self.meets(H, slope)
        zero = np.zeros_like(reach)
        first = Part(zero, zero, reach, self.weights[0], H, np.arcsinh(slope))
        beyond = np.arcsinh(np.sinh(first.end_angle) - self.load / H)
        second = Part(reach, -first.drop, self.span - reach, self.weights[1], H, beyond)
        return Highline(self.span, self.drop, (first, second))

    def below(self, line: Highline) -> Values:
        """How far under B the line ends, m."""
        return line.parts[0].drop + line.parts[1].drop - self.drop

    def meant(self, line: Highline, of: Known, known: Values) -> Values:
        """Where the line ends at B and has what is known of it."""
        size = np.abs(line.length) + np.hypot(np.real(self.span), np.real(self.drop))
        ends = np.abs(np.real(self.below(line))) <= _OWED * size
        return ends & (np.abs(np.real(of(line) - known)) <= _OWED * np.abs(known))

    def sagging(self, length: Values) -> Values:
        """log H of about a line of this length (m)."""
        sag = np.sqrt(np.maximum(np.real(length - self.span) * np.real(length + self.span), 1e-300))
        weight = np.real(self.load + self.weights[0] * self.span)
        return np.log(np.real(0.25 * weight * self.span) / sag)

    def pulled(self, tension: Values) -> Values:
        """log H of about a line with this tension (N) at one end."""
        hung = np.real(self.load + (self.weights[0] + self.weights[1]) * self.span)
        return 0.5 * np.log(np.maximum(np.real(tension) ** 2 - 0.25 * hung**2, 1e-300))

    def off(self, of: Known, known: Values) -> Callable[[Values, Values], Values]:
        """Log H and the slope at A to what both conditions miss, (2, ...)."""

        def missed(x: Values, slope: Values) -> Values:
            line = self.line(np.exp(x), slope)
            return np.array([self.below(line), of(line) - known])

        return missed

    def at_once(
        self, of: Known, known: Values, x: Values, slope: Values | None = None, taut: bool = False
    ) -> Values | None:
        """Log H and slope of the line, (2, ...): Newton's method for both, from log H = x.

        Tens of times as quick as one root inside another, to which it leaves what it does not find:
        None where it comes to no line, where the line should be taut and is slack (a little shorter,
        it would have less of the tension), and where the numbers carry derivatives.
        """
        if slope is None:
            hung = np.real(self.load + (self.weights[0] + self.weights[1]) * self.span)
            slope = np.real(self.drop / self.span) + 0.5 * hung / np.exp(x)
        found = met(self.off(of, known), x, slope)
        if found is None:
            return None
        place, ((a, b), _) = found
        log_H, steep = place
        with np.errstate(all="ignore"):
            good = self.meant(self.line(np.exp(log_H), steep), of, known)
            if taut:  # among the lines that end at B, its neighbours
                moved = self.line(np.exp(log_H + 1j * STEP), steep - 1j * STEP * a / b)
                good &= np.imag(of(moved)) * np.imag(moved.length) < 0.0
        return place if np.all(good) else None
