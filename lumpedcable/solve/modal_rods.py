"""What rods bring into natural modes: masses between their ends, and lengths that they keep.

A rod of mass m has m/3 at each end and m/6 between them (`physics.rod`), and keeps its length where

    t . (u_2 - u_1) = 0,   t its direction at rest,

so that of all small motions those remain for which that is true of every rod. What it carries at
rest, T, resists turning as T/l across it. A rod with `EA` is a spring along itself instead.
"""

from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.line import Line
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net
from lumpedcable.model.rods import spread_of
from lumpedcable.physics.load import Shape
from lumpedcable.physics.rod import ROD_SHARES, rod_mass
from lumpedcable.physics.tension import Rigid
from lumpedcable.solve.pencil import Pencil

__all__ = [
    "Found",
    "Rods",
    "lowest_of_rods",
    "rods_of",
    "shares_of_rods",
    "with_known_tensions",
]


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


class Found(NamedTuple):
    """The lowest modes as they come from a solver: omega^2 (rad2/s2), motions (k, places, d) and so on.

    `weigh` turns motions into M u (kg); `reach` forces (k, blocks, b) into their size by M^-1, (k,).
    """

    square: np.ndarray
    resolution: np.ndarray
    motion: np.ndarray
    unknowns: int
    weigh: Callable[[np.ndarray], np.ndarray]
    reach: Callable[[np.ndarray], np.ndarray]


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
            shape = line.shape(jnp.zeros_like(line.reference))
            laws[name] = Rigid(line.law.tension(shape.strain), jnp.zeros(()))
    if not laws:
        return model
    names = list(laws)
    return eqx.tree_at(
        lambda m: [m.lines[name].law for name in names], model, [laws[name] for name in names]
    )


def lowest_of_rods(
    stiffness: tuple[np.ndarray, np.ndarray], mass: np.ndarray, rods: dict[str, Rods], net: Net,
    count: int,
) -> Found:  # fmt: skip
    """The `count` lowest modes of rods; K and M as in `_pencil`.

    Raises:
        ValueError: nothing can move.
    """
    d = mass.shape[1]
    free = np.repeat(~net.fixed, d)
    pencil = _pencil(stiffness, mass, rods, net)
    square, vectors, resolution, unknowns = pencil.lowest(count)

    def everywhere(values):
        motion = np.zeros((values.shape[1], free.size))
        motion[:, free] = values.T
        return motion.reshape(-1, net.size, d)

    def moving(values):
        return values.reshape(values.shape[0], -1)[:, free].T

    return Found(
        square, resolution, everywhere(vectors), unknowns,
        weigh=lambda u: everywhere(pencil.mass @ moving(u)),
        reach=lambda f: pencil.reach(moving(f)),
    )  # fmt: skip


def _pencil(
    stiffness: tuple[np.ndarray, np.ndarray], mass: np.ndarray, rods: dict[str, Rods], net: Net
) -> Pencil:
    """K, M and the kept lengths of rods, of all that is free to move.

    Args:
        stiffness: the diagonal and lower blocks of K (N/m), by blocks of the net.
        mass: of every place (places, d, d), in kg.
        rods: by line, for what is between places.
        net: says where they are.
    """
    from scipy.sparse import coo_matrix

    d = mass.shape[1]
    unknowns = np.arange(net.size * d).reshape(net.size, d)
    free = np.flatnonzero(np.repeat(~net.fixed, d))

    def sparse(entries, height):
        rows, columns, values = (
            np.concatenate([np.ravel(e[k]) for e in entries]) for k in range(3)
        )
        whole = coo_matrix((values, (rows, columns)), shape=(height, net.size * d))
        whole = whole.tocsc()[:, free]
        whole.eliminate_zeros()
        return whole

    diagonal, lower = stiffness
    blocks = unknowns.reshape(diagonal.shape[:2])
    springs = [_entries(blocks, blocks, diagonal)]
    springs += _both_ways(blocks[1:], blocks[:-1], lower[1:])
    masses = [_entries(unknowns, unknowns, mass)]
    ties, count = [], 0
    for name, own in rods.items():
        first, last = (unknowns[net.index[name][part]] for part in (slice(-1), slice(1, None)))
        masses += _both_ways(last, first, ROD_SHARES[1] * np.asarray(own.whole))
        kept = np.flatnonzero(np.asarray(own.kept) > 0.0)
        row = count + np.arange(kept.size)[:, None]
        t = np.asarray(own.tangent).T[kept]
        ties += [
            _entries(row, end[kept], s * t[:, None]) for s, end in ((-1.0, first), (1.0, last))
        ]
        count += kept.size
    return Pencil(
        sparse(springs, net.size * d)[free],
        sparse(masses, net.size * d)[free],
        sparse(ties, count),
        (np.arange(net.size * d) // (net.width * d))[free],
    )


def _entries(rows: np.ndarray, columns: np.ndarray, blocks: np.ndarray):
    """Row, column and value of every entry of blocks (m, b, b), from the unknowns (m, b) of each."""
    shape = blocks.shape
    return (
        np.broadcast_to(rows[:, :, None], shape),
        np.broadcast_to(columns[:, None, :], shape),
        blocks,
    )


def _both_ways(rows: np.ndarray, columns: np.ndarray, blocks: np.ndarray):
    """The same of blocks beside the diagonal, below it and above."""
    below = _entries(rows, columns, blocks)
    return [below, (below[1], below[0], below[2])]


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
