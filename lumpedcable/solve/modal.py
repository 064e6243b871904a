"""Natural modes: small vibrations about static equilibrium, from the residual that dynamics has.

With F(x) the net force on the free nodes at rest and M their mass matrix, small displacements u obey

    M u'' = -K u,   K = -dF/dx,   K phi = omega^2 M phi.

K holds all that statics knows: elastic and geometric stiffness, bending, the drag of a current, a bed
that holds what lies on it, up as well as down as long as the motion is small. M holds the masses
along and across the line, added mass included, and the points at junctions. Wave corrections take no
part, and damping none in omega: how fast modes die out is found from them (`solve.modal_damping`).
Materials that relax are in each mode as stiff as at its omega (`solve.modal_relaxing`). The drag of a
current has no energy and makes K unsymmetric, as thrust does that turns with its body: of the lowest
modes of its symmetric part those of K are made then (Rayleigh-Ritz), and how well is reported. Two of
them may feed each other, and grow as they swing.

Rigid bodies that have been found at rest move too, with the lines that are tied to them
(`solve.modal_bodies`), bodies that run on lines, and lines that a winch keeps taut, as it pays them out
(`solve.modal_carried`). Inextensible lines have the masses of rods and only those motions that keep
their lengths (`solve.modal_rods`).

Frequencies converge with the square of the segment length: on N segments n half-waves of a string are
low by (n pi / N)^2 / 24, 0.05 % at 30 segments to a half-wave.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.model.layout import Layout
from lumpedcable.model.net import Net
from lumpedcable.solve.modal_bodies import RigidMotion, rigid_motions
from lumpedcable.solve.modal_coupled import MORE, ROUNDING, Found, lowest_coupled
from lumpedcable.solve.modal_linear import Linear
from lumpedcable.solve.modal_lumps import lowest_of_lumps
from lumpedcable.solve.modal_relaxing import Relaxing, Solved, modes_that_relax
from lumpedcable.solve.modal_rods import Rods, shares_of_rods

__all__ = ["Modes", "natural_modes"]

Damped = Callable[[dict[str, np.ndarray], dict[str, np.ndarray]], Array]

TINY = 1e-300
EPS = float(np.finfo(float).eps)
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
        its added mass) and of point masses and rigid bodies, (k,) each; they add up to 1.
    asymmetry: size of the antisymmetric part of K over that of the symmetric part (-).
    growth: rate (1/s) at which pairs of modes that feed each other grow as they swing, in quadrature,
        (k,); 0 of others. `square` is then that of the frequency.
    doubt: how far omega^2 may be off (-) where K is unsymmetric, (k,); 0 where it is not.
    damping: share of critical damping (-), (k,); NaN where a mode does not swing by itself, None where
        it is not asked for.
    unknowns: number of all modes there are.
    axes: the coordinates that modes can move in, orthonormal columns (3, d) in x, y, z.
    rigid: how rigid bodies and trolleys move, by name; those that are held are left out.
    payout: what each winch pays out, where shapes are in m, (k,) in m by the winch's name; winch_share:
        its share of the kinetic energy, (k,), which is in that of bodies.
    rolling: the force (N) that would set a trolley going along its line, where it is held; 0 where it
        moves.
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
    growth: Float[np.ndarray, " k"]
    doubt: Float[np.ndarray, " k"]
    unknowns: int
    axes: Float[np.ndarray, "3 d"]
    rigid: dict[str, RigidMotion] = field(default_factory=dict)
    payout: dict[str, Float[np.ndarray, " k"]] = field(default_factory=dict)
    winch_share: dict[str, Float[np.ndarray, " k"]] = field(default_factory=dict)
    rolling: dict[str, float] = field(default_factory=dict)
    held: float = 0.0
    damping: Float[np.ndarray, " k"] | None = None

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


def natural_modes(
    linear: Linear, net: Net, layout: Layout, coordinates: Coordinates, count: int,
    damped: Damped | None = None, relaxing: Relaxing | None = None,
) -> Modes:  # fmt: skip
    """The `count` lowest modes of a linearised model.

    Args:
        linear: `linearised(model)` of a model placed at static equilibrium.
        net: `make_net(model)`.
        layout: says how the scene's lines are cut into those of the model.
        coordinates: those of the model. Nothing can move out of them: a line along x in one
            dimension has no transverse modes.
        count: number of modes, positive; fewer are returned where there are not so many.
        damped: tells phi . C phi (kg/s) of motions of the model's lines and bodies, as
            `solve.modal_damping` does; None: nothing is damped.
        relaxing: what branches of materials add to its stiffness; None: nothing relaxes.

    Raises:
        ValueError: nothing can move.
    """
    here: Any = jax.device_get(linear)
    if net.fixed.all() and not any(body.ways.size for body in here.movers.values()):
        raise ValueError("nothing can move: every node is held")
    # two more than asked for, so that a pair of equal ones is not parted
    lowest = partial(_lowest, net, count + 2)
    finish = partial(_solved, here, coordinates, count)
    if relaxing is None:
        found = finish(lowest(here))
    else:
        found = modes_that_relax(here, relaxing, lowest, finish, count)
    square, growth, motion, turned = found.square, found.growth, found.motion, found.turned
    resolution = found.resolution
    lines = {name: np.moveaxis(motion[:, places], 1, 2) for name, places in net.index.items()}
    for name, spring in here.doubt.items():
        turns = np.sum(np.diff(lines[name], axis=2) ** 2, axis=1)
        resolution = resolution + np.sum(spring * turns, axis=1)
    for name, body in here.movers.items():
        resolution = resolution + np.sum(body.doubt * turned[name] ** 2, axis=1)
    mass, (axial, transverse, bodies) = _shares(here, lines, motion, turned)
    outlines = {
        name: np.einsum("pdm,km->kdp", body.moves, turned[name])
        for name, body in here.bodies.items()
    }
    damping = None
    if damped is not None or found.loss is not None:
        swings = (square > resolution) & (growth == 0.0)
        damping, omega = np.full(square.size, np.nan), np.sqrt(square[swings])
        lost = np.zeros(square.size) if damped is None else np.asarray(damped(lines, turned))
        damping[swings] = (lost / mass)[swings] / (2.0 * omega)
        if found.loss is not None:
            damping[swings] += (found.loss / mass)[swings] / (2.0 * omega**2)
    payout = {name: turned[name][:, 0] for name in here.winches}
    shapes, scale = _shapes(lines, outlines, payout, layout, coordinates)
    places = {name: coordinates.expand(x, 0, place=True).T for name, x in here.reference.items()}
    return Modes(
        square=square,
        resolution=resolution,
        nodes=_merged(places, layout, 0),
        shapes=shapes,
        mass=mass / scale**2,
        axial=axial,
        transverse=transverse,
        bodies=bodies,
        asymmetry=found.asymmetry,
        growth=growth,
        doubt=found.doubt,
        unknowns=found.unknowns,
        axes=coordinates.axes,
        rigid=rigid_motions(here.bodies, turned, mass, scale, here.places, coordinates),
        payout={name: paid / scale for name, paid in payout.items()},
        winch_share={
            name: here.winches[name].mass[0, 0] * paid**2 / mass for name, paid in payout.items()
        },
        rolling={name: float(force) for name, force in here.rolling.items()},
        damping=damping,
    )


def _lowest(net: Net, count: int, linear: Any) -> Found:
    """The `count` lowest modes of the symmetric part of one K and M."""
    if linear.movers or any(isinstance(own, Rods) for own in linear.frames.values()):
        return lowest_coupled(linear, net, count)
    return lowest_of_lumps(linear.stiffness, linear.mass, net, count)


def _solved(linear: Any, coordinates: Coordinates, count: int, found: Found) -> Solved:
    """The `count` lowest modes of K and M, out of those of its symmetric part."""
    if found.asymmetry > ROUNDING:
        square, growth, resolution, vectors, doubt = _unsymmetric(found)
    else:
        square, resolution = found.square, found.resolution
        vectors = found.vectors @ _aligned(found, linear, coordinates)
        growth = doubt = np.zeros(square.size)
    motion, turned = found.spread(vectors[:, :count])
    # what nothing at all resists is 0 but for numbers that mean nothing
    resolution = np.maximum(resolution, EPS**2 * np.max(np.abs(square), initial=0.0))
    square, growth, resolution, doubt = (x[:count] for x in (square, growth, resolution, doubt))
    return Solved(
        square, growth, resolution, doubt, motion, turned, found.asymmetry, found.unknowns
    )


def _unsymmetric(found: Found):
    """omega^2 (rad2/s2), growth (1/s), what rounding leaves, vectors (n, k) and the doubt of each.

    K in the space of the vectors that were found, which are orthonormal by M: its eigenvalues are real,
    or pairs whose vectors' real and imaginary parts swing in quadrature. Doubt is how far they are from
    those of fewer vectors.
    """
    form = found.vectors.T @ found.full(found.vectors)
    values, mix = np.linalg.eig(form)
    order = np.lexsort((-np.imag(values), np.abs(np.imag(values)), np.real(values)))
    values, mix = values[order], mix[:, order]
    resolution = np.abs(mix.T) ** 2 @ found.resolution
    doubt = np.zeros(values.size)
    if values.size < found.unknowns:
        fewer = np.linalg.eigvals(form[: -MORE // 2, : -MORE // 2])
        doubt = np.min(np.abs(values[:, None] - fewer), axis=1) / np.maximum(np.abs(values), TINY)
    vectors = found.vectors @ np.where(np.imag(values) < 0.0, np.imag(mix), np.real(mix))
    scale = np.sqrt(np.sum(vectors * found.scaled(vectors), axis=0))
    paired, omega = np.abs(np.imag(values)) > resolution, np.sqrt(values.astype(complex))
    square = np.where(paired, np.real(omega) ** 2, np.real(values))
    growth = np.where(paired, np.abs(np.imag(omega)), 0.0)
    return square, growth, resolution, vectors / scale, doubt


def _aligned(found: Found, linear: Linear, coordinates: Coordinates) -> np.ndarray:
    """What turns modes of equal frequency so that they move along z, x or y as far as they can.

    Any mixture of them is a mode as well; this choice does not depend on rounding. (k, k).
    """
    axes, square = coordinates.axes, found.square
    prefer = axes.T @ np.diag([2.0, 3.0, 1.0]) @ axes
    motion, turned = found.spread(found.vectors)
    form = np.einsum("kpi,ij,lpj->kl", found.weigh(found.vectors), prefer, motion)
    for name, body in linear.bodies.items():
        q, d = turned[name], coordinates.dimensions
        own = np.diag(4.0 + np.arange(q.shape[1], dtype=float))
        own[:d, :d] = prefer
        form += q @ np.asarray(body.mass) @ own @ q.T
    mix, start = np.eye(square.size), 0
    for stop in range(1, square.size + 1):
        near = max(found.resolution[start], SAME * abs(square[start]))
        if stop < square.size and square[stop] - square[start] <= near:
            continue
        group = slice(start, stop)
        if stop - start > 1:
            mix[group, group] = np.linalg.eigh(form[group, group] + form[group, group].T)[1]
        start = stop
    return mix


def _shares(linear: Linear, lines: dict[str, np.ndarray], motion: np.ndarray, turned):
    """phi . M phi (kg) of each mode, and its shares along the lines, across them, of bodies."""
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
    bodies = np.sum(linear.points * np.sum(motion**2, axis=2), axis=1)
    for name, q in turned.items():
        bodies = bodies + np.einsum("km,mn,kn->k", q, linear.movers[name].mass, q)
    whole = along + across + bodies
    return whole, (along / whole, across / whole, bodies / whole)


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


def _shapes(
    lines: dict[str, np.ndarray], outlines: dict[str, np.ndarray], payout: dict[str, np.ndarray],
    layout: Layout, coordinates: Coordinates,
):  # fmt: skip
    """Displacements (modes, nodes, 3) by line, the largest 1, and what they were divided by.

    Of the places that move the most, but for a tenth, the first moves towards +x, +y or +z; places of
    bodies (modes, d, points) come after those of lines, and what winches pay out (modes,) last.
    """
    pieces = {name: np.swapaxes(coordinates.expand(u, 1), 1, 2) for name, u in lines.items()}
    merged = _merged(pieces, layout, 1)
    drawn = [np.swapaxes(coordinates.expand(u, 1), 1, 2) for u in outlines.values()]
    paid = [length[:, None, None] * np.array([1.0, 0.0, 0.0]) for length in payout.values()]
    everything = np.concatenate([*merged.values(), *drawn, *paid], axis=1)
    sizes = np.sqrt(np.sum(everything**2, axis=2))
    largest = np.max(sizes, axis=1)
    scale = largest.copy()
    for mode, top in enumerate(largest):
        first = everything[mode, np.argmax(sizes[mode] >= 0.9 * top)]
        leading = first[np.argmax(np.abs(first) >= 0.9 * np.max(np.abs(first)))]
        scale[mode] = top if leading >= 0.0 else -top
    return {name: shape / scale[:, None, None] for name, shape in merged.items()}, scale
