"""What materials that relax bring into natural modes: a stiffness that depends on the frequency.

A branch of EA_k and tau_k beside a law (`physics.relaxation`) carries of a strain of frequency omega

    EA_k i omega tau_k / (1 + i omega tau_k) = EA_k (w^2 + i w) / (1 + w^2),    w = omega tau_k,

storage and loss (J. D. Ferry, Viscoelastic Properties of Polymers, 3rd ed. 1980, chapter 3). So the
j-th mode has the omega whose square is the j-th eigenvalue of

    K(omega) = K + sum_k D_k w_k^2 / (1 + w_k^2),

D_k what branch k adds to K where it has no time to relax. That grows with omega more slowly than
omega^2, so that there is one such omega, between the j-th of slow loads and the j-th of fast ones. The
loss damps it to first order, by zeta = phi . sum_k D_k w_k / (1 + w_k^2) phi / (2 omega^2 phi . M phi).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from lumpedcable.model.model import Model
from lumpedcable.physics.relaxation import Memory, Relaxation
from lumpedcable.solve.modal_coupled import Found
from lumpedcable.solve.modal_linear import Stiffness, stiffness_of

__all__ = ["Relaxing", "Solved", "kinds_of", "modes_that_relax", "stiffer"]

Lowest = Callable[[Any], Found]

CLOSE = 1e-11  # of omega^2: closer is found
LOOKS = 60  # eigenvalue problems for one mode, at most
ROUNDS = 8  # frequencies whose own modes are taken into account, at most
SAME = 1e-9  # of omega^2: a change that ends them
NEW = 1e-7  # part of a motion that others do not add up to
TINY = 1e-300


class Relaxing(NamedTuple):
    """Branches of a model by their times tau_k (s), (k,), and D_k, each shaped as K, (k, ..)."""

    time: Float[np.ndarray, " k"]
    stiffness: Stiffness


@dataclass(frozen=True)
class Solved:
    """Natural modes of one stiffness, k of them: omega^2 and more as in `solve.modal.Modes`.

    motion: of all places of the net (k, places, d); turned: of bodies by name, (k, m); each mode with
    phi . M phi = 1 kg. loss: phi . K'' phi (N/m), (k,), K'' the loss of what relaxes.
    """

    square: Float[np.ndarray, " k"]
    growth: Float[np.ndarray, " k"]
    resolution: Float[np.ndarray, " k"]
    doubt: Float[np.ndarray, " k"]
    motion: Float[np.ndarray, "k places d"]
    turned: dict[str, Float[np.ndarray, "k m"]]
    asymmetry: float
    unknowns: int
    loss: Float[np.ndarray, " k"] | None = None


def kinds_of(model: Model) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The times tau (s) that branches have, (k,), and of each line which of its branches have which.

    The latter are 1 or 0, (k, branches), by line; a model whose lines do not relax has no times.
    """
    lines = {
        name: np.asarray(line.relaxation.time)
        for name, line in model.lines.items()
        if line.relaxation is not None
    }
    times = np.unique(np.concatenate([np.zeros(0), *lines.values()]))
    return times, {name: (own == times[:, None]).astype(float) for name, own in lines.items()}


def stiffer(
    model: Model,
    outlines: Mapping[str, Float[Array, "p d"]],
    shares: Mapping[str, Float[Array, "k branches"]],
) -> Stiffness:
    """K + D_k (k, ..) of a model at rest at its reference: its stiffness where those branches hold.

    `outlines` are those of the bodies that move, as in `linearised`.
    """

    def fast(share):
        lines = {}
        for name, part in share.items():
            line = model.lines[name]
            own = line.relaxation
            assert own is not None
            at_rest = Memory(own.at_rest(line.law, line.reference_strain))
            held = Relaxation(own.stiff * part, own.time)
            lines[name] = replace(line, relaxation=held, memory=at_rest)
        return stiffness_of(replace(model, lines={**model.lines, **lines}), outlines)

    return jax.lax.map(fast, dict(shares))


def modes_that_relax(
    slow: Any, relaxing: Relaxing, lowest: Lowest, finish: Callable[[Found], Solved], count: int
) -> Solved:
    """The `count` lowest modes of K(omega), from the `Linear` of slow loads.

    They are looked for among all motions that modes of slow loads, of fast ones and of some frequencies
    between add up to (Rayleigh-Ritz); more of those until no omega^2 changes. `lowest` finds modes of
    one K, `finish` makes of those what is told. Modes that grow, or that nothing resists, do so slowly:
    they are those of slow loads.
    """
    space = _Space(slow, relaxing, lowest)
    found, before, looked = [], None, [np.zeros_like(relaxing.time), np.ones_like(relaxing.time)]
    for _ in range(ROUNDS):
        known: dict[float, Solved] = {}

        def at(square: float, space=space, known=known) -> Solved:
            if square not in known:
                known[square] = finish(space.at(_storage(relaxing, square)))
            return known[square]

        rest = at(0.0)
        found, roots, far = [], [], []
        for j in range(min(count, rest.square.size)):
            square, own = 0.0, rest
            if rest.square[j] > rest.resolution[j]:
                square, own = _root(at, relaxing, j)
            energies = _energies(relaxing, own, j)
            found.append(_picked(own, j, float(energies @ _lost(relaxing, square))))
            roots.append(square)
            apart = np.abs(np.array(looked) - _storage(relaxing, square))
            far.append(np.min(apart @ np.abs(energies)) / max(square, TINY))
        squares = np.array(roots)
        if before is not None and np.all(np.abs(squares - before) <= SAME * squares):
            break
        before = squares
        looked.append(_storage(relaxing, roots[int(np.argmax(far))]))
        space.add(looked[-1])
    return _together(found)


class _Space:
    """Motions among which modes are looked for, orthonormal by M, and K of each branch between them."""

    def __init__(self, slow: Any, relaxing: Relaxing, lowest: Lowest) -> None:
        self._linear, self._relaxing, self._lowest = slow, relaxing, lowest
        alone = np.eye(relaxing.time.size)
        self._slow = lowest(slow)
        self._fast = [lowest(self._stiffened(share)) for share in alone]
        self._vectors = self._slow.vectors
        self._resolution = self._slow.resolution
        for one in self._fast:
            self._take(one)
        self._project()
        if len(self._fast) > 1:
            self.add(np.ones_like(relaxing.time))

    def add(self, share: Float[np.ndarray, " k"]) -> None:
        """Take up the modes of one more K + sum share_k D_k."""
        self._take(self._lowest(self._stiffened(share)))
        self._project()

    def at(self, share: Float[np.ndarray, " k"]) -> Found:
        """The lowest modes of K + sum share_k D_k among those motions."""
        form = self._forms[0] + np.tensordot(share, self._forms[1], 1)
        square, mix = np.linalg.eigh(0.5 * (form + form.T))
        count = self._slow.square.size

        def full(vectors):
            slow = self._slow.full(vectors)
            more = zip(share, self._fast, strict=True)
            return slow + sum(part * (one.full(vectors) - slow) for part, one in more)

        return self._slow._replace(
            square=square[:count],
            vectors=self._vectors @ mix[:, :count],
            resolution=self._resolution,
            full=full,
        )

    def _stiffened(self, share: Float[np.ndarray, " k"]) -> Any:
        stiffness = jax.tree.map(
            lambda k, d: k + np.tensordot(share, d, 1),
            self._linear.stiffness,
            self._relaxing.stiffness,
        )
        return self._linear._replace(stiffness=stiffness)

    def _take(self, found: Found) -> None:
        """Add what is new of some modes to the motions."""
        self._resolution = np.maximum(self._resolution, found.resolution)
        for vector in found.vectors.T:
            left = vector
            for _ in range(2):
                left = left - self._vectors @ (
                    self._vectors.T @ self._slow.scaled(left[:, None])[:, 0]
                )
            size = np.sqrt(max(float(left @ self._slow.scaled(left[:, None])[:, 0]), 0.0))
            if size > NEW:
                self._vectors = np.column_stack([self._vectors, left / size])

    def _project(self) -> None:
        """K of slow loads between the motions (r, r), and D_k (k, r, r)."""
        v = self._vectors
        slow = v.T @ self._slow.full(v)
        self._forms = slow, np.array([v.T @ one.full(v) - slow for one in self._fast])


def _root(at: Callable[[float], Solved], relaxing: Relaxing, j: int) -> tuple[float, Solved]:
    """The omega^2 that is the j-th eigenvalue of its own K(omega), and the modes of that K."""
    low, high = at(0.0).square[j], at(np.inf).square[j]
    x, own = low, at(low)
    for _ in range(LOOKS):
        over = own.square[j] - x
        if abs(over) <= max(CLOSE * x, own.resolution[j]):
            break
        low, high = (x, high) if over > 0.0 else (low, x)
        slope = _energies(relaxing, own, j) @ _storage_slope(relaxing, x)
        x = x - over / min(slope - 1.0, -TINY)
        if not low < x < high:
            x = np.sqrt(low * high)
        own = at(x)
    return x, own


def _storage(relaxing: Relaxing, square: float) -> Float[np.ndarray, " k"]:
    """w^2 / (1 + w^2) of each branch at an omega^2 (rad2/s2)."""
    if np.isinf(square):
        return np.ones_like(relaxing.time)
    w2 = square * relaxing.time**2
    return w2 / (1.0 + w2)


def _storage_slope(relaxing: Relaxing, square: float) -> Float[np.ndarray, " k"]:
    """Its derivative by omega^2 (s2)."""
    return relaxing.time**2 / (1.0 + square * relaxing.time**2) ** 2


def _lost(relaxing: Relaxing, square: float) -> Float[np.ndarray, " k"]:
    """w / (1 + w^2) of each branch."""
    w = np.sqrt(square) * relaxing.time
    return w / (1.0 + w**2)


def _energies(relaxing: Relaxing, own: Solved, j: int) -> Float[np.ndarray, " k"]:
    """phi . D_k phi (N/m) of the j-th mode."""
    motion = own.motion[j]
    if not isinstance(relaxing.stiffness, tuple):
        everything = np.concatenate([motion.ravel(), *(q[j] for q in own.turned.values())])
        return np.einsum("i,kij,j->k", everything, relaxing.stiffness, everything)
    lower, diagonal, upper = relaxing.stiffness
    x = motion.reshape(diagonal.shape[1:3])
    found = np.einsum("ni,knij,nj->k", x, diagonal, x)
    found += np.einsum("ni,knij,nj->k", x[1:], lower[:, 1:], x[:-1])
    return found + np.einsum("ni,knij,nj->k", x[:-1], upper[:, :-1], x[1:])


def _picked(own: Solved, j: int, loss: float) -> Solved:
    """The j-th mode alone, with its loss."""
    one = slice(j, j + 1)
    return replace(
        own,
        square=own.square[one],
        growth=own.growth[one],
        resolution=own.resolution[one],
        doubt=own.doubt[one],
        motion=own.motion[one],
        turned={name: q[one] for name, q in own.turned.items()},
        loss=np.array([loss]),
    )


def _together(found: list[Solved]) -> Solved:
    """Modes one after the other."""
    first = found[0]

    def all_of(name: str) -> np.ndarray:
        return np.concatenate([getattr(one, name) for one in found])

    return replace(
        first,
        **{n: all_of(n) for n in ("square", "growth", "resolution", "doubt", "motion", "loss")},
        turned={n: np.concatenate([one.turned[n] for one in found]) for n in first.turned},
    )
