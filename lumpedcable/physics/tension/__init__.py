"""Tension laws T(e): how a line's tension (N) follows from its strain (-)."""

from lumpedcable.physics.tension.base import (
    AbstractTensionLaw,
    stiffness,
    stiffness_bound,
    strain_at,
    tension_and_stiffness,
)
from lumpedcable.physics.tension.linear import Linear
from lumpedcable.physics.tension.polynomial import Polynomial
from lumpedcable.physics.tension.rigid import Rigid
from lumpedcable.physics.tension.table import Table
from lumpedcable.physics.tension.tanh import Tanh
from lumpedcable.physics.tension.tension_only import TensionOnly

__all__ = [
    "AbstractTensionLaw",
    "Linear",
    "Polynomial",
    "Rigid",
    "Table",
    "Tanh",
    "TensionOnly",
    "stiffness",
    "stiffness_bound",
    "strain_at",
    "tension_and_stiffness",
]
