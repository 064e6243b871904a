"""What rods bring into natural modes: masses between their ends, and lengths that they keep.

A rod of mass m has m/3 at each end and m/6 between them (`physics.rod`), and keeps its length where

    t . (u_2 - u_1) = 0,   t its direction at rest,

so that of all small motions those remain for which that is true of every rod. What it carries at
rest, T, resists turning as T/l across it. A rod with `EA` is a spring along itself instead.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.model.rods import spread_of
from lumpedcable.physics.load import Shape
from lumpedcable.physics.rod import ROD_SHARES, rod_mass
from lumpedcable.physics.tension import Rigid

__all__ = ["Rods", "rods_of", "shares_of_rods", "with_known_tensions"]


class Rods(NamedTuple):
    """The rods of a line: directions (d, n), whole masses along and across them (kg), (n,).

    `kept`: 1 where a rod keeps its length, 0 where it is a spring.
    """

    tangent: Float[Array, "d n"]
    along: Float[Array, " n"]
    across: Float[Array, " n"]
    kept: Float[Array, " n"]

    @property
    def whole(self) -> Float[Array, "n d d"]:
        """Mass matrices of whole rods (kg)."""
        return rod_mass(self.along, self.across, self.tangent)


def rods_of(line: Line, shape: Shape) -> Rods:
    """The rods of an inextensible line as it lies."""
    spread = spread_of(line)
    kept = jnp.full(line.segments, 1.0 if line.give is None else 0.0)
    return Rods(shape.tangent, spread.along, spread.across, kept)


def with_known_tensions(model: Model) -> Model:
    """The model with rods that carry what they do, however they are stretched.

    The stiffness of their law at rest is a means to find their shape, and nothing that they have.
    """
    laws = {}
    for name, line in model.lines.items():
        if line.inextensible and line.give is None:
            shape = line.shape()
            laws[name] = Rigid(line.law.tension(shape.strain), jnp.zeros(()))
    if not laws:
        return model
    names = list(laws)
    return eqx.tree_at(
        lambda m: [m.lines[name].law for name in names], model, [laws[name] for name in names]
    )


def shares_of_rods(own: Rods, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """phi . M phi (kg) along and across the rods of a line, (k,), from its nodes' (k, d, nodes)."""
    first, last = ends[..., :-1], ends[..., 1:]
    t = np.asarray(own.tangent)
    along, across = np.zeros(ends.shape[0]), np.zeros(ends.shape[0])
    for a, b in ((first, first), (last, last), (first, last)):
        s, r = np.sum(a * t, axis=1), np.sum(b * t, axis=1)
        along += ROD_SHARES[0] * np.sum(own.along * s * r, axis=1)
        across += ROD_SHARES[0] * np.sum(own.across * (np.sum(a * b, axis=1) - s * r), axis=1)
    return along, across
