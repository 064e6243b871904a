"""The classical fourth-order Runge-Kutta method, which diffrax does not have."""

from collections.abc import Callable
from typing import ClassVar

import diffrax
import numpy as np

__all__ = ["RK4"]

# no error estimate belongs to it: the zeros keep it from steps of its own choice
_TABLEAU = diffrax.ButcherTableau(
    a_lower=(np.array([0.5]), np.array([0.0, 0.5]), np.array([0.0, 0.0, 1.0])),
    b_sol=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    b_error=np.zeros(4),
    c=np.array([0.5, 0.5, 1.0]),
)


class RK4(diffrax.AbstractERK):
    """Four evaluations a step, fourth order, fixed steps.

    Kutta, Z. Math. Phys. 46 (1901) 435-453; Hairer, Norsett & Wanner, Solving Ordinary
    Differential Equations I (1993), table II.1.2.
    """

    tableau: ClassVar[diffrax.ButcherTableau | diffrax.MultiButcherTableau] = _TABLEAU
    interpolation_cls: ClassVar[Callable] = diffrax.ThirdOrderHermitePolynomialInterpolation.from_k

    def order(self, terms):
        """4."""
        return 4
