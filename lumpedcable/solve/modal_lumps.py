"""Natural modes where every node has a mass of its own: M^-1/2 K M^-1/2 by blocks of the net."""

from dataclasses import dataclass

import numpy as np

from lumpedcable.model.net import Net
from lumpedcable.solve.blocks import BlockTridiagonal
from lumpedcable.solve.modal_coupled import Found, asymmetry_of
from lumpedcable.solve.spectrum import SymmetricBlocks, lowest

__all__ = ["lowest_of_lumps"]


def lowest_of_lumps(stiffness: BlockTridiagonal, mass: np.ndarray, net: Net, count: int) -> Found:
    """The `count` lowest modes of K (N/m) by blocks of the net and of masses (places, d, d) in kg."""
    d = mass.shape[1]
    free = np.repeat(~net.fixed, d)
    lower, diagonal, upper = _free_parts(stiffness, free)
    even, odd = _half(lower, diagonal, upper, 1.0), _half(lower, diagonal, upper, -1.0)
    root = _inverse_root(mass, net)
    matrix = SymmetricBlocks(root @ even.diagonal @ root, root @ even.lower @ _before(root), free)
    asymmetry, wanted = asymmetry_of(even.size(), odd.size(), count)
    square, vectors, resolution = lowest(matrix, wanted)

    def spread(vectors):
        motion = np.zeros((vectors.shape[1], free.size))
        motion[:, free] = vectors.T
        motion = root @ motion.reshape(-1, *even.diagonal.shape[:2], 1)
        return motion.reshape(-1, net.size, d), {}

    def full(vectors):
        motion, _ = spread(vectors)
        force = root @ (even.force(motion) + odd.force(motion))[..., None]
        return force.reshape(force.shape[0], -1)[:, free].T

    return Found(
        square, resolution, vectors, int(free.sum()), asymmetry,
        spread=spread,
        weigh=lambda vectors: np.einsum("pij,kpj->kpi", mass, spread(vectors)[0]),
        full=full,
        scaled=lambda vectors: vectors,
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
