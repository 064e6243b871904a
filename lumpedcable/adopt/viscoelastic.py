"""Ropes of two springs and two dashpots in series, as MoorDyn has them, as branches beside a law.

MoorDyn takes a segment for two parts in series, each a spring beside a dashpot: a fast one of EA_d (N)
and BA_d (N s), and a slow one of EA_1 = EA_d EA_s / (EA_d - EA_s) and BA_s, so that a load that stays
finds EA_s. Of a strain that goes as exp(s t) such a segment bears (EA_d + BA_d s) (EA_1 + BA_s s) /
(EA_d + EA_1 + (BA_d + BA_s) s) times as much, which is the same as

    EA_s + c s + EA tau s / (1 + tau s),

a spring, a dashpot and a spring in series with a dashpot, all beside each other.

Sources: MoorDyn documentation, "Input Files" (moordyn.readthedocs.io), for EA_s|EA_d and BA_s|BA_d;
`Line::getStateDeriv` of MoorDyn 2, and the paper that it names (ASME IOWTC 2023, V001T01A029), for the
two parts. The sum is the product in partial fractions.
"""

from __future__ import annotations

from math import fsum
from typing import NamedTuple

__all__ = ["Parallel", "parallel"]

# shares of stiffness and of damping that differ by less are the same but for rounding
ALIKE = 1e-12


class Parallel(NamedTuple):
    """What stands beside the spring EA_s: a dashpot c, `damping` (N s), and a branch, `EA` (N) and
    `time` (s).

    `EA` is 0 where both parts relax within the same time, so that there is no branch.
    """

    damping: float
    EA: float
    time: float


def parallel(EA: float, EA_d: float, BA: float, BA_d: float) -> Parallel:
    """Of stiffnesses EA < EA_d (N) and damping BA and BA_d (N s), not both 0, static and dynamic:

    tau = (BA_d + BA) / (EA_d + EA_1), c = BA_d BA / (BA_d + BA), and the branch's stiffness is
    (EA_d + EA_1) (EA_d / (EA_d + EA_1) - BA_d / (BA_d + BA))^2, which is never negative.
    """
    whole = EA_d * EA_d / (EA_d - EA)  # EA_d + EA_1
    damping = BA_d + BA
    # EA_d / whole = 1 - EA / EA_d
    apart = fsum((1.0, -EA / EA_d, -BA_d / damping))
    branch = whole * apart**2 if abs(apart) > ALIKE else 0.0
    return Parallel(BA_d * BA / damping, branch, damping / whole)
