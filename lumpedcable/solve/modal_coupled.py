"""Natural modes where masses couple nodes, lengths are kept, or ends go with rigid bodies.

All motions are u = B y: free nodes move by themselves, the end of a line that is tied to a body by
J dq with the body's coordinates q, and rods keep their lengths. Then K = B^T K' B and M = B^T M' B, K'
and M' of nodes and bodies apart. A body's coordinates are measured so that each has the same mass:
angles become lengths. Trolleys and winches (`solve.modal_carried`) are bodies to which nothing is tied.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from lumpedcable.model.net import Net
from lumpedcable.physics.rod import ROD_SHARES
from lumpedcable.solve.modal_bodies import Floating
from lumpedcable.solve.modal_linear import Linear
from lumpedcable.solve.modal_rods import Rods
from lumpedcable.solve.pencil import BORDER, Pencil

__all__ = ["MORE", "ROUNDING", "Found", "asymmetry_of", "lowest_coupled"]

TINY = 1e-300
REACH = 3  # nodes along a line between those that a trolley couples
ROUNDING = 1e-9
"""Asymmetry of K that is nobody's doing."""
MORE = 30
"""Modes of the symmetric part beyond those asked for, of which modes of an unsymmetric K are made."""


class Found(NamedTuple):
    """The lowest modes as they come from a solver: omega^2 (rad2/s2), vectors (n, k) of its unknowns.

    They are those of the symmetric part of K, orthonormal by M. `spread` turns vectors into motions of
    nodes (k, places, d) and of bodies by name, (k, m); `weigh` into M u of the nodes (kg m),
    (k, places, d); `full` into K u of the whole K and `scaled` into M u,
    both (n, k). `asymmetry` is the size of the antisymmetric part of K over that of the other.
    """

    square: Float[np.ndarray, " k"]
    resolution: Float[np.ndarray, " k"]
    vectors: Float[np.ndarray, "n k"]
    unknowns: int
    asymmetry: float
    spread: Callable[[np.ndarray], tuple[np.ndarray, dict[str, np.ndarray]]]
    weigh: Callable[[np.ndarray], np.ndarray]
    full: Callable[[np.ndarray], np.ndarray]
    scaled: Callable[[np.ndarray], np.ndarray]


def lowest_coupled(linear: Linear, net: Net, count: int) -> Found:
    """The `count` lowest modes of a linearised model with rods or bodies that move.

    Raises:
        ValueError: nothing can move.
    """
    d, nodes = linear.mass.shape[1], net.size * linear.mass.shape[1]
    slots = _slots(linear.movers, nodes)
    whole = _stiffness(linear, net, slots)
    mass, ties = _masses(linear, net, slots), _ties(linear, net, slots)
    moves, blocks = _moves(linear, net, slots)
    stiffness = moves.T @ whole @ moves
    even, odd = 0.5 * (stiffness + stiffness.T), 0.5 * (stiffness - stiffness.T)
    asymmetry, wanted = asymmetry_of(_size(even), _size(odd), count)
    own = (moves.T @ mass @ moves).tocsc()
    pencil = Pencil(even.tocsc(), own, (ties @ moves).tocsc(), blocks)
    square, vectors, resolution, unknowns = pencil.lowest(wanted)

    def apart(everything):
        return everything[:nodes].T.reshape(everything.shape[1], net.size, d)

    def spread(vectors):
        everything = moves @ vectors
        return apart(everything), {name: everything[own].T for name, own in slots.items()}

    return Found(
        square, resolution, vectors, unknowns, asymmetry,
        spread=spread,
        weigh=lambda vectors: apart(mass @ (moves @ vectors)),
        full=lambda vectors: stiffness @ vectors,
        scaled=lambda vectors: own @ vectors,
    )  # fmt: skip


def asymmetry_of(even: float, odd: float, count: int) -> tuple[float, int]:
    """The asymmetry of K from the sizes of its halves, and how many modes of the symmetric half are
    wanted for `count` of K.
    """
    asymmetry = odd / max(even, TINY)
    return asymmetry, count + MORE if asymmetry > ROUNDING else count


def _size(matrix) -> float:
    """Frobenius norm."""
    return float(np.sqrt(matrix.multiply(matrix).sum()))


def _slots(bodies: dict[str, Floating], nodes: int) -> dict[str, np.ndarray]:
    """Where the coordinates of each body stand behind those of the nodes."""
    slots, at = {}, nodes
    for name, body in bodies.items():
        slots[name] = np.arange(at, at + body.free.size)
        at += body.free.size
    return slots


def _sparse(entries: list[Any], shape: tuple[int, int]) -> Any:
    """A sparse matrix of entries: rows, columns and values, of which those at one place add up."""
    from scipy.sparse import coo_matrix

    rows, columns, values = (
        np.concatenate([np.zeros(0), *(np.ravel(e[k]) for e in entries)]) for k in range(3)
    )
    matrix = coo_matrix((values, (rows.astype(int), columns.astype(int))), shape=shape).tocsc()
    matrix.eliminate_zeros()
    return matrix


def _entries(rows: np.ndarray, columns: np.ndarray, blocks: Any):
    """Row, column and value of every entry of blocks (m, a, b), from the unknowns (m, a), (m, b)."""
    shape = blocks.shape
    return (
        np.broadcast_to(rows[:, :, None], shape),
        np.broadcast_to(columns[:, None, :], shape),
        blocks,
    )


def _own(slots: dict[str, np.ndarray], matrices: dict[str, Any]):
    """The entries of bodies' own matrices (m, m)."""
    return [_entries(own[None], own[None], matrices[name][None]) for name, own in slots.items()]


def _height(linear: Linear, slots: dict[str, np.ndarray]) -> int:
    """Number of all coordinates, of nodes and of bodies."""
    return linear.mass.shape[0] * linear.mass.shape[1] + sum(map(len, slots.values()))


def _square(linear: Linear, slots: dict[str, np.ndarray]) -> tuple[int, int]:
    """The shape of K' and M'."""
    size = _height(linear, slots)
    return size, size


def _stiffness(linear: Linear, net: Net, slots: dict[str, np.ndarray]):
    """K' (N/m, N, N m), of held nodes too."""
    if not isinstance(linear.stiffness, tuple):
        everything = np.arange(linear.stiffness.shape[0])[None]
        whole = _entries(everything, everything, np.asarray(linear.stiffness)[None])
        return _sparse([whole], _square(linear, slots))
    lower, diagonal, upper = (np.asarray(part) for part in linear.stiffness)
    blocks = np.arange(diagonal.shape[0] * diagonal.shape[1]).reshape(diagonal.shape[:2])
    entries = [
        _entries(blocks, blocks, diagonal),
        _entries(blocks[1:], blocks[:-1], lower[1:]),
        _entries(blocks[:-1], blocks[1:], upper[:-1]),
        *_own(slots, {name: body.stiffness for name, body in linear.bodies.items()}),
    ]
    places = _unknowns(linear, net)
    for name, body in linear.bodies.items():
        for clamp in body.clamps:
            here = places[np.asarray(clamp.nodes)].reshape(1, -1)
            cross = np.asarray(clamp.cross).reshape(1, here.size, -1)
            across = _entries(here, slots[name][None], cross)
            entries += [across, (across[1], across[0], across[2])]
    return _sparse(entries, _square(linear, slots))


def _masses(linear: Linear, net: Net, slots: dict[str, np.ndarray]):
    """M' (kg, kg m, kg m2)."""
    places = _unknowns(linear, net)
    entries = [
        _entries(places, places, np.asarray(linear.mass)),
        *_own(slots, {name: body.mass for name, body in linear.movers.items()}),
    ]
    for first, last, own in _rods(linear, net, places):
        between = _entries(last, first, ROD_SHARES[1] * np.asarray(own.whole))
        entries += [between, (between[1], between[0], between[2])]
    return _sparse(entries, _square(linear, slots))


def _ties(linear: Linear, net: Net, slots: dict[str, np.ndarray]):
    """G, whose rows are the lengths that rods keep."""
    entries, count = [], 0
    for first, last, own in _rods(linear, net, _unknowns(linear, net)):
        kept = np.flatnonzero(np.asarray(own.kept) > 0.0)
        row = count + np.arange(kept.size)[:, None]
        t = np.asarray(own.tangent).T[kept][:, None]
        entries += [_entries(row, end[kept], s * t) for s, end in ((-1.0, first), (1.0, last))]
        count += kept.size
    return _sparse(entries, (count, _height(linear, slots)))


def _unknowns(linear: Linear, net: Net) -> np.ndarray:
    """The coordinates of every place, (places, d)."""
    d = linear.mass.shape[1]
    return np.arange(net.size * d).reshape(net.size, d)


def _rods(linear: Linear, net: Net, places: np.ndarray):
    """The rods of each line that has them, with the coordinates of their first and last ends."""
    for name, own in linear.frames.items():
        if isinstance(own, Rods):
            index = net.index[name]
            yield places[index[:-1]], places[index[1:]], own


def _moves(linear: Linear, net: Net, slots: dict[str, np.ndarray]):
    """B, and the block of the net that each unknown stands in."""
    places, d = _unknowns(linear, net), linear.mass.shape[1]
    free = np.flatnonzero(np.repeat(~net.fixed, d))
    entries: list[Any] = [(free, np.arange(free.size), np.ones(free.size))]
    width = net.width if isinstance(linear.stiffness, tuple) else REACH * net.width
    blocks, count = [free // (width * d)], free.size
    for name, body in linear.movers.items():
        ways = body.ways
        column = count + np.arange(ways.shape[1])
        entries.append(_entries(slots[name][None], column[None], ways[None]))
        ends = places[net.tied.get(name, np.zeros(0, int))]
        columns = np.broadcast_to(column, (ends.shape[0], column.size))
        entries.append(_entries(ends, columns, body.ends @ ways))
        blocks.append(np.full(column.size, BORDER))
        count += column.size
    return _sparse(entries, (_height(linear, slots), count)), np.concatenate(blocks)
