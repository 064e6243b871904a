"""Natural modes: small vibrations about static equilibrium, from the residual that dynamics has.

With F(x) the net force on the free nodes at rest and M their mass matrix, small displacements u obey

    M u'' = -K u,   K = -dF/dx,   K phi = omega^2 M phi.

K holds all that statics knows: elastic and geometric stiffness, bending, the drag of a current, a bed
that holds what lies on it, up as well as down as long as the motion is small. M holds the masses
along and across the line, added mass included, and the points at junctions. Damping and wave
corrections take no part. The drag of a current has no energy and makes K unsymmetric; its symmetric
part is used, and what is left out is reported: it changes single frequencies to second order.

Inextensible lines have the masses of rods and only those motions that keep their lengths
(`solve.modal_rods`).

Frequencies converge with the square of the segment length: on N segments n half-waves of a string are
low by (n pi / N)^2 / 24, 0.05 % at 30 segments to a half-wave.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model import inertia
from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.line import node_tangent
from lumpedcable.model.model import Model
from lumpedcable.model.net import Net, make_net
from lumpedcable.physics.rod import ROD_SHARES
from lumpedcable.physics.tension import tension_and_stiffness
from lumpedcable.solve.blocks import BlockTridiagonal, block_jacobian
from lumpedcable.solve.modal_rods import (
    Found,
    Rods,
    lowest_of_rods,
    rods_of,
    shares_of_rods,
    with_known_tensions,
)
from lumpedcable.solve.spectrum import SymmetricBlocks, lowest
from lumpedcable.solve.statics import static_residual

__all__ = ["Linear", "Modes", "linearised", "natural_modes"]

EPS = float(np.finfo(float).eps)
TINY = 1e-300
SAME = 1e-9  # relative: eigenvalues closer than this are one, with any mixture of their modes


@dataclass(frozen=True)
class Modes:
    """Natural modes, the lowest omega^2 first; k modes.

    square: omega^2 (rad2/s2), shape (k,); negative where the equilibrium is unstable.
    resolution: what rounding leaves uncertain of each omega^2 (rad2/s2), (k,).
    nodes: equilibrium by line of the scene, (nodes, 3) in m.
    shapes: displacements by line, (k, nodes, 3); the largest displacement of each mode is 1.
    mass: modal mass phi . M phi (kg) of those shapes, (k,).
    axial, transverse, bodies: shares of the kinetic energy along the lines, across them (each with
        its added mass) and of point masses, (k,) each; they add up to 1.
    asymmetry: size of the antisymmetric part of K over that of the symmetric part (-).
    skew: the same of their forces in each mode (-), (k,).
    unknowns: number of all modes there are.
    axes: the coordinates that modes can move in, orthonormal columns (3, d) in x, y, z.
    held: net force (N) on joints where the scene puts them, which modes leave out; 0 where they stay.
    """

    square: Float[np.ndarray, " k"]
    resolution: Float[np.ndarray, " k"]
    nodes: dict[str, Float[np.ndarray, "nodes 3"]]
    shapes: dict[str, Float[np.ndarray, "k nodes 3"]]
    mass: Float[np.ndarray, " k"]
    axial: Float[np.ndarray, " k"]
    transverse: Float[np.ndarray, " k"]
    bodies: Float[np.ndarray, " k"]
    asymmetry: float
    skew: Float[np.ndarray, " k"]
    unknowns: int
    axes: Float[np.ndarray, "3 d"]
    held: float = 0.0

    @property
    def unstable(self) -> np.ndarray:
        """Where a mode grows instead of swinging, (k,)."""
        return self.square < -self.resolution

    @property
    def neutral(self) -> np.ndarray:
        """Where nothing resists a mode: a mechanism, a slack line, a drifting body, (k,)."""
        return np.abs(self.square) <= self.resolution

    @property
    def frequency(self) -> Float[np.ndarray, " k"]:
        """f = omega / 2 pi (Hz), 0 where nothing resists a mode and NaN where it is unstable."""
        square = np.where(self.neutral, 0.0, self.square)
        return np.sqrt(np.where(self.unstable, np.nan, square)) / (2.0 * np.pi)


class Linear(NamedTuple):
    """A model linearised about its reference, in the order of `make_net(model)`.

    stiffness: K (N/m) by blocks of the net. mass: of every place (places, d, d), in kg. points: the
    part of it that is point masses (places,), in kg. frames: tangents and masses of the lines' own
    nodes, or of their rods. reference: their places (d, nodes) in m, in the model's coordinates.
    doubt: what rounding of the places leaves uncertain of each segment's tension over its length
    (n,), in N/m.
    """

    stiffness: BlockTridiagonal
    mass: Float[Array, "places d d"]
    points: Float[Array, " places"]
    frames: dict[str, inertia.Frame | Rods]
    reference: dict[str, Float[Array, "d nodes"]]
    doubt: dict[str, Float[Array, " n"]]


def linearised(model: Model) -> Linear:
    """K = -dF/dx and M of a model at its reference, with 3 b directional derivatives of F."""
    net = make_net(model)
    d = next(iter(model.lines.values())).dimensions
    blocks = (net.size // net.width, net.width * d)

    known = with_known_tensions(model)

    def force(x):
        return static_residual(known, x.reshape(net.size, d), net).reshape(blocks)

    _, (lower, diagonal, upper) = block_jacobian(force, jnp.zeros(blocks))
    points = jnp.zeros(net.size)
    for junction in model.junctions:
        if junction.mass is not None:
            name, node = junction.members[0]
            points = points.at[int(net.index[name][node])].add(junction.mass)
    mass = points[:, None, None] * jnp.eye(d)
    frames, doubt = {}, {}
    for name, line in model.lines.items():
        shape = line.shape(jnp.zeros_like(line.reference))
        if line.inextensible:
            frames[name] = rods = rods_of(line, shape)
            for end in (net.index[name][:-1], net.index[name][1:]):
                mass = mass.at[end].add(ROD_SHARES[0] * rods.whole)
        else:
            nodes = inertia.frame(line, shape, None)
            mass_n = nodes.mass_t if nodes.tangent is None else nodes.mass_n
            nodes = nodes._replace(tangent=node_tangent(shape.tangent), mass_n=mass_n)
            mass = mass.at[net.index[name]].add(_nodal_masses(nodes, d))
            frames[name] = nodes
        _, stiff = tension_and_stiffness(line.law, shape.strain)
        far = jnp.max(jnp.abs(line.reference))
        doubt[name] = 8.0 * EPS * jnp.abs(stiff) * (1.0 + far / shape.length) / shape.length
    reference = {name: line.reference for name, line in model.lines.items()}
    return Linear((-lower, -diagonal, -upper), mass, points, frames, reference, doubt)


def _nodal_masses(nodes: inertia.Frame, d: int) -> Float[Array, "nodes d d"]:
    """m_t t t^T + m_n (I - t t^T) of each node (kg)."""
    assert nodes.tangent is not None
    along = nodes.tangent.T[:, :, None] * nodes.tangent.T[:, None, :]
    extra = (nodes.mass_t - nodes.mass_n)[:, None, None]
    return nodes.mass_n[:, None, None] * jnp.eye(d) + extra * along


def natural_modes(
    linear: Linear, net: Net, layout: Layout, coordinates: Coordinates, count: int
) -> Modes:
    """The `count` lowest modes of a linearised model.

    Args:
        linear: `linearised(model)` of a model placed at static equilibrium.
        net: `make_net(model)`.
        layout: says how the scene's lines are cut into those of the model.
        coordinates: those of the model. Nothing can move out of them: a line along x in one
            dimension has no transverse modes.
        count: number of modes, positive; fewer are returned where there are not so many.

    Raises:
        ValueError: nothing can move.
    """
    d = coordinates.dimensions
    free = np.repeat(~net.fixed, d)
    if not free.any():
        raise ValueError("nothing can move: every node is held")
    here: Any = jax.device_get(linear)
    lower, diagonal, upper = _free_parts(here.stiffness, free)
    even, odd = _half(lower, diagonal, upper, 1.0), _half(lower, diagonal, upper, -1.0)
    rods = {name: own for name, own in here.frames.items() if isinstance(own, Rods)}
    # two more than asked for, so that a pair of equal ones is not parted
    if rods:
        found = lowest_of_rods((even.diagonal, even.lower), here.mass, rods, net, count + 2)
    else:
        found = _of_lumps(here, even, net, free, count + 2)
    square, resolution = found.square, found.resolution
    motion = _aligned(square, resolution, found.motion, found.weigh, coordinates)
    square, resolution, motion = square[:count], resolution[:count], motion[:count]

    lines = {name: np.moveaxis(motion[:, places], 1, 2) for name, places in net.index.items()}
    for name, spring in here.doubt.items():
        turns = np.sum(np.diff(lines[name], axis=2) ** 2, axis=1)
        resolution = resolution + np.sum(spring * turns, axis=1)
    mass, (axial, transverse, bodies) = _shares(here, lines, motion)
    shapes, largest = _shapes(lines, layout, coordinates)
    places = {name: coordinates.expand(x, 0, place=True).T for name, x in here.reference.items()}
    return Modes(
        square=square,
        resolution=resolution,
        nodes=_merged(places, layout, 0),
        shapes=shapes,
        mass=mass / largest**2,
        axial=axial,
        transverse=transverse,
        bodies=bodies,
        asymmetry=odd.size() / max(even.size(), TINY),
        skew=found.reach(odd.force(motion)) / np.maximum(found.reach(even.force(motion)), TINY),
        unknowns=found.unknowns,
        axes=coordinates.axes,
    )


def _of_lumps(linear: Linear, even: "_Half", net: Net, free: np.ndarray, count: int) -> Found:
    """The lowest modes where every place has a mass of its own: M^-1/2 K M^-1/2 by blocks."""
    mass = np.asarray(linear.mass)
    root = _inverse_root(mass, net)
    matrix = SymmetricBlocks(root @ even.diagonal @ root, root @ even.lower @ _before(root), free)
    square, vectors, resolution = lowest(matrix, count)
    motion = np.zeros((vectors.shape[1], free.size))
    motion[:, free] = vectors.T
    motion = root @ motion.reshape(-1, *even.diagonal.shape[:2], 1)
    return Found(
        square, resolution, motion.reshape(-1, net.size, mass.shape[1]), int(free.sum()),
        weigh=lambda u: np.einsum("pij,kpj->kpi", mass, u),
        reach=lambda f: np.sqrt(np.sum((root @ f[..., None]) ** 2, axis=(1, 2, 3))),
    )  # fmt: skip


def _inverse_root(mass: np.ndarray, net: Net) -> np.ndarray:
    """M^-1/2 (kg^-1/2) by blocks of the net, (blocks, b, b); places without mass get 1."""
    d = mass.shape[1]
    mass = np.where(np.trace(mass, axis1=1, axis2=2)[:, None, None] > 0.0, mass, np.eye(d))
    values, vectors = np.linalg.eigh(mass)
    root = (vectors / np.sqrt(values)[:, None, :]) @ np.swapaxes(vectors, 1, 2)
    root = root.reshape(-1, net.width, d, d)
    blocks = np.zeros((root.shape[0], net.width, d, net.width, d))
    for k in range(net.width):
        blocks[:, k, :, k, :] = root[:, k]
    return blocks.reshape(-1, net.width * d, net.width * d)


def _free_parts(stiffness: BlockTridiagonal, free: np.ndarray):
    """K without the rows and columns of what is held, and without the blocks that mean nothing."""
    lower, diagonal, upper = (np.array(part) for part in stiffness)  # copies
    lower[0] = upper[-1] = 0.0
    mine = free.reshape(diagonal.shape[:2])
    lower *= mine[:, :, None] & _before(mine)[:, None, :]
    diagonal *= mine[:, :, None] & mine[:, None, :]
    upper *= mine[:, :, None] & np.roll(mine, -1, axis=0)[:, None, :]
    return lower, diagonal, upper


def _before(blocks: np.ndarray) -> np.ndarray:
    """Each block's predecessor."""
    return np.roll(blocks, 1, axis=0)


@dataclass(frozen=True)
class _Half:
    """The symmetric (sign 1) or antisymmetric (sign -1) half of K (N/m) by blocks."""

    diagonal: np.ndarray
    lower: np.ndarray
    sign: float

    def size(self) -> float:
        """Frobenius norm (N/m)."""
        return float(np.sqrt(2.0 * np.sum(self.lower**2) + np.sum(self.diagonal**2)))

    def force(self, motion: np.ndarray) -> np.ndarray:
        """K phi (N) of each mode, (k, blocks, b)."""
        x = motion.reshape(motion.shape[0], *self.diagonal.shape[:2], 1)
        force = self.diagonal @ x
        force[:, 1:] += self.lower[1:] @ x[:, :-1]
        force[:, :-1] += self.sign * np.swapaxes(self.lower[1:], 1, 2) @ x[:, 1:]
        return force[..., 0]


def _half(lower, diagonal, upper, sign: float) -> _Half:
    """(K + sign K^T) / 2."""
    return _Half(
        0.5 * (diagonal + sign * np.swapaxes(diagonal, 1, 2)),
        0.5 * (lower + sign * np.swapaxes(_before(upper), 1, 2)),
        sign,
    )


def _aligned(
    square: np.ndarray, resolution: np.ndarray, motion: np.ndarray,
    weigh: Callable[[np.ndarray], np.ndarray], coordinates: Coordinates,
) -> np.ndarray:  # fmt: skip
    """Modes of equal frequency turned so that they move along z, x or y as far as they can.

    Any mixture of them is a mode as well; this choice does not depend on rounding.
    """
    motion = motion.copy()
    axes = coordinates.axes
    prefer = axes.T @ np.diag([2.0, 3.0, 1.0]) @ axes
    start = 0
    for stop in range(1, square.size + 1):
        near = max(resolution[start], SAME * abs(square[start]))
        if stop < square.size and square[stop] - square[start] <= near:
            continue
        if stop - start > 1:
            group = motion[start:stop]
            form = np.einsum("kpi,ij,lpj->kl", weigh(group), prefer, group)
            _, turn = np.linalg.eigh(form + form.T)
            motion[start:stop] = np.einsum("kl,kpi->lpi", turn, group)
        start = stop
    return motion


def _shares(linear: Linear, lines: dict[str, np.ndarray], motion: np.ndarray):
    """phi . M phi (kg) of each mode, and its shares along the lines, across them, of points."""
    along, across = np.zeros(motion.shape[0]), np.zeros(motion.shape[0])
    for name, nodes in linear.frames.items():
        if isinstance(nodes, Rods):
            mine = shares_of_rods(nodes, lines[name])
            along, across = along + mine[0], across + mine[1]
            continue
        part = np.sum(lines[name] * nodes.tangent, axis=1)
        rest = lines[name] - part[:, None] * nodes.tangent
        along += np.sum(nodes.mass_t * part**2, axis=1)
        across += np.sum(nodes.mass_n * np.sum(rest**2, axis=1), axis=1)
    points = np.sum(linear.points * np.sum(motion**2, axis=2), axis=1)
    whole = along + across + points
    return whole, (along / whole, across / whole, points / whole)


def _merged(pieces: dict[str, np.ndarray], layout: Layout, axis: int) -> dict[str, np.ndarray]:
    """The scene's lines out of the model's: pieces of a line that is to break share a node."""
    result = {}
    for piece in layout.pieces:
        nodes = pieces[piece.name]
        if piece.line in result:
            nodes = nodes[(slice(None),) * axis + (slice(1, None),)]
            nodes = np.concatenate([result[piece.line], nodes], axis=axis)
        result[piece.line] = nodes
    return result


def _shapes(lines: dict[str, np.ndarray], layout: Layout, coordinates: Coordinates):
    """Displacements (modes, nodes, 3) by line, the largest 1, and what they were divided by.

    Of the places that move the most, but for a tenth, the first moves towards +x, +y or +z.
    """
    pieces = {name: np.swapaxes(coordinates.expand(u, 1), 1, 2) for name, u in lines.items()}
    merged = _merged(pieces, layout, 1)
    everything = np.concatenate(list(merged.values()), axis=1)
    sizes = np.sqrt(np.sum(everything**2, axis=2))
    largest = np.max(sizes, axis=1)
    scale = largest.copy()
    for mode, top in enumerate(largest):
        first = everything[mode, np.argmax(sizes[mode] >= 0.9 * top)]
        leading = first[np.argmax(np.abs(first) >= 0.9 * np.max(np.abs(first)))]
        scale[mode] = top if leading >= 0.0 else -top
    return {name: shape / scale[:, None, None] for name, shape in merged.items()}, largest
