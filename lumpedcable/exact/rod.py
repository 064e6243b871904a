"""A rod or line that hangs straight down under its own weight and an end load."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .chain import StrainOfTension
from .checks import finite, positive
from .law import Array

_GAUSS_X, _GAUSS_W = np.polynomial.legendre.leggauss(20)


@dataclass(frozen=True)
class HangingRod:
    """A vertical line fixed at its top, s the unstretched distance from there.

    The tension is T(s) = F + w (L - s) and the displacement u(s) = integral from 0 to s of e(T),
    for a linear law u = (F s + w (L s - s^2/2))/EA. Source: equilibrium of the part below s.

    Attributes:
        length: unstretched length L, m.
        weight: weight per unstretched length in water w, N/m.
        end_force: downward force on the lower end F, N.
        strain: inverse law e(T), see `linear_strain` and `strain_of_tension`.
    """

    length: float
    weight: float
    end_force: float
    strain: StrainOfTension

    def __post_init__(self) -> None:
        positive("length", "m", self.length)
        finite(weight=self.weight, **{"end force": self.end_force})

    def tension(self, s: ArrayLike) -> Array:
        """Return T(s), N."""
        return self.end_force + self.weight * (self.length - np.asarray(s, float))

    def displacement(self, s: ArrayLike) -> Array:
        """Return how far the point s has moved down, m, by quadrature over 20 panels.

        The panels shrink towards the lower end, where a law may start without stiffness.
        """
        s = np.asarray(s, float)
        if np.any((s < 0.0) | (s > self.length)):
            raise ValueError(f"s runs from 0 at the top to {self.length:g} m")
        cuts = self.length * (1.0 - 2.0 ** -np.arange(0.0, 20.0))
        cuts = np.concatenate([cuts, [self.length]])
        lo = np.minimum(cuts[:-1], s[..., None])
        half = 0.5 * (np.minimum(cuts[1:], s[..., None]) - lo)
        at = (lo + half)[..., None] + half[..., None] * _GAUSS_X
        return np.sum(_GAUSS_W * half[..., None] * self.strain(self.tension(at)), axis=(-2, -1))

    @property
    def stretch(self) -> float:
        """Displacement of the lower end, m."""
        return float(self.displacement(self.length))
