"""Numbers at their bounds: which are there, what the data see of them, and whether they should stay."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.arrays import Arrays, Spec
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.minimise import Found
from lumpedcable.fitting.residual import value_and_jacobian
from lumpedcable.fitting.transforms import before_bounds, share_of
from lumpedcable.study.compiled import RUN_ONCE
from lumpedcable.study.kept import program

__all__ = ["AT_BOUND", "at_bounds", "falling", "inside", "slopes", "way_of", "with_slopes"]

Array = NDArray[np.float64]
AT_BOUND = 1e-4  # share of the gap between bounds (or of the start) within which a value is at one
UNFELT = 1e-2  # and change of all deviations together, over the noise, that the way to it may make
EXACT = 1e-6  # noise, over the largest value, below which data without a given noise have none
GAIN = 1e-5  # of the loss, which a search may leave where it ends
SEEN = 1e-6  # share of a column of J that those of the others must leave of it
INSIDE = 3.0  # |z| of a start off a bound: a twentieth of the way from it


def way_of(p) -> float:
    """The gap between a parameter's bounds, or how far from its only one it began; else its start."""
    if np.isfinite(p.high - p.low):
        return p.high - p.low
    ways = [abs(p.start - edge) for edge in (p.low, p.high) if np.isfinite(edge)]
    return ways[0] if ways else abs(p.start) or 1.0


def at_bounds(problem: FitProblem, values: Array, slope: Array, left: Array) -> NDArray[np.bool_]:
    """Whether each value is at a bound: near it for the search, and for the data as good as on it.

    A start far from a bound alone says nothing of how near the end is to it; what the data see of
    the way to it, |J_k| d over the noise, does.
    """
    low, high = (np.array([getattr(p, key) for p in problem.parameters]) for key in ("low", "high"))
    near = np.minimum(values - low, high - values)
    with np.errstate(invalid="ignore", over="ignore"):  # told by `fitted_from`
        felt = near * np.sqrt(np.sum(slope**2, axis=0))
        noise = _noise(problem, left)
    ways = np.array([way_of(p) for p in problem.parameters])
    return (near < AT_BOUND * ways) & (felt < UNFELT * noise)


def _noise(problem: FitProblem, left: Array) -> float:
    """The noise in deviations: 1 where it was given, else what is left."""
    free = max(problem.points - len(problem.parameters), 1)
    return 1.0 if problem.known_noise else max(float(np.sqrt(np.sum(left**2) / free)), EXACT)


def with_slopes(spec: Spec, arrays: Arrays, found: Found) -> Found:
    """An end whose derivatives are those at `before_bounds`, where they do not fade away.

    dx/dz goes to zero with exp(-|z|), and a search may run out so far that nothing is left of it. The
    model is asked once more only then.
    """
    z = before_bounds(arrays.transform, found.z)
    moved = z != found.z
    if not np.any(moved):
        return found
    slope = np.asarray(slopes(spec, arrays, z)[2])
    return found._replace(slope=np.where(moved, slope, found.slope))


@partial(program, static=("spec",), options=RUN_ONCE)
def slopes(spec: Spec, arrays: Arrays, z):
    """The residual (n,), the model's answers, and the derivatives (n, p) of the former by z."""
    return value_and_jacobian(spec, arrays, z)


def falling(problem: FitProblem, arrays: Arrays, found: Found) -> NDArray[np.bool_]:
    """Numbers (p,) next to a bound, from which the loss falls inwards: no minimum has them there.

    With J_k the derivatives of r by such a number and P what is left beside all J_j of numbers away
    from their bounds, the sum of squares falls by (J_k' P r)^2/|P J_k|^2 where J is constant, the
    others going along. The sign of J_k' P r tells whether it does so inwards.

    Args:
        problem, arrays: what was fitted.
        found: where a search ended, `with_slopes`.
    """
    near = share_of(arrays.transform, found.z) < AT_BOUND
    r, count = found.residual, found.z.size
    if not np.any(near) or not (np.all(np.isfinite(r)) and np.all(np.isfinite(found.slope))):
        return np.zeros(count, bool)
    largest = np.max(np.abs(found.slope), axis=0)  # first, or squares would underflow
    columns = found.slope / np.where(largest > 0.0, largest, 1.0)
    norms = np.sqrt(np.sum(columns**2, axis=0))
    columns = columns / np.where(norms > 0.0, norms, 1.0)
    inner = columns[:, ~near]
    own = columns - inner @ np.linalg.lstsq(inner, columns, rcond=None)[0]
    square = np.sum(own**2, axis=0)
    steep = own.T @ r
    gain = np.where(square > SEEN**2, steep**2 / np.maximum(square, SEEN**2), 0.0)
    least = (UNFELT * _noise(problem, r)) ** 2 + GAIN * float(np.sum(r**2))
    # |z| grows towards every bound
    return near & (steep * found.z > 0.0) & (gain > least)


def inside(z: Array, which: NDArray[np.bool_]) -> Array:
    """The same place with some numbers off their bounds."""
    return np.where(which, np.sign(z) * INSIDE, z)
