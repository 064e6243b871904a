"""Fitting a problem: searches, the step that the best values need, and how sure they are."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import jax
import numpy as np
from numpy.typing import NDArray

from lumpedcable.fitting.arrays import Arrays, Spec, arrays_of, grouped
from lumpedcable.fitting.bounds import at_bounds, falling, way_of
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.minimise import REVERSE_FROM, Found
from lumpedcable.fitting.outliers import Forgiven, deviations_of, forgiven, influence
from lumpedcable.fitting.residual import Prediction, group_start, unpacked
from lumpedcable.fitting.seek import Sought, Start, ordered, seek
from lumpedcable.fitting.transforms import slope_at, to_values
from lumpedcable.fitting.uncertainty import (
    Certainty,
    Criteria,
    Draws,
    Profile,
    certainty_of,
    criteria_of,
    effective_of,
)
from lumpedcable.scene import Fault, Scene, SceneError
from lumpedcable.scene.units import format_quantity
from lumpedcable.status import ADVICE, MEANING, Status

__all__ = ["Fitted", "Start", "failure_text", "fit_problem", "fitted_from", "slopes_of"]

Array = NDArray[np.float64]
SPARE = 1.25  # steps beyond those needed at the start, where reverse mode fixes their number


@dataclass(frozen=True)
class Fitted:
    """The outcome of a fit, all in SI.

    predicted: the model's answer, one array a series. deviation (n,): (model - data) over the noise,
    or over the largest value where no noise was given. rough: by series, the largest change that a
    coarser interpolation between outputs would make, 0 where none was needed. stalled: numbers at whose
    bound the search ended though the loss falls inwards. began: what the start values give, one array a
    series, None where that is not known.
    """

    problem: FitProblem
    values: Array
    certainty: Certainty
    criteria: Criteria
    predicted: tuple[Array, ...]
    deviation: Array
    rough: tuple[float, ...]
    failures: tuple[tuple[str, Status], ...]
    at_bound: tuple[bool, ...]
    spec: Spec
    sought: Sought
    seconds: float
    profiles: tuple[Profile, ...] = ()
    draws: Draws | None = None
    stalled: tuple[bool, ...] = ()
    began: tuple[Array, ...] | None = None

    @property
    def starts(self) -> tuple[Start, ...]:
        """All searches."""
        return self.sought.starts

    @property
    def sampled(self) -> int:
        """Places tried without derivatives, where the first search ended badly."""
        return self.sought.sampled

    @property
    def loss(self) -> float:
        """Sum of the squared deviations, after the robust loss if there is one."""
        return self.sought.loss

    @property
    def evaluations(self) -> int:
        """Evaluations of the model with its derivatives, in all searches."""
        return sum(start.steps for start in self.starts)

    @property
    def converged(self) -> bool:
        """Whether the best search came to its end."""
        return min(self.starts, key=lambda s: s.loss).converged and not self.failures

    def scene(self, base: Scene, experiment: str | None = None) -> Scene:
        """A scene with the values found: those for all, and those of one experiment."""
        own = {
            p.key: float(x)
            for p, x in zip(self.problem.parameters, self.values, strict=True)
            if p.experiment in (None, experiment)
        }
        known = base.numbers()
        return base.with_numbers({key: x for key, x in own.items() if key in known})


def fit_problem(problem: FitProblem, tell: Callable[[str], None] = lambda words: None) -> Fitted:
    """Find the parameters of a problem.

    Args:
        problem: parameters, data and method.
        tell: called with a few words before each search.
    """
    begun = clock.perf_counter()
    spec, arrays = arrays_of(problem)
    if problem.method.solver != "levenberg-marquardt" and len(problem.parameters) >= REVERSE_FROM:
        spec, arrays = _fixed_steps(problem, spec, arrays)
    with np.errstate(over="ignore", invalid="ignore"):  # told by `fitted_from`
        sought = seek(problem, spec, arrays, tell)
    return fitted_from(problem, spec, sought, clock.perf_counter() - begun)


def _fixed_steps(problem: FitProblem, spec: Spec, arrays: Arrays) -> tuple[Spec, Arrays]:
    """The same problem with steps as structure, for reverse mode."""
    counts = []
    for group, a in zip(spec.groups, arrays.groups, strict=True):
        bound = group_bound(group, a, np.array([p.start for p in problem.parameters]))
        counts.append(int(np.ceil(SPARE * float(np.max(a.every)) / (float(a.courant) * bound))))
    return arrays_of(problem, counts)


def group_bound(group, arrays, values) -> float:
    """The longest step (s) that all runs of a group are stable with."""
    _, bound, _ = group_start(group, arrays, values)
    return float(np.min(bound))


def fitted_from(problem: FitProblem, spec: Spec, sought: Sought, seconds: float) -> Fitted:
    """What searches have found, with how sure it is.

    Raises:
        SceneError: they never came to where numbers are finite.
    """
    sought = ordered(problem, spec, sought)
    found, arrays = sought.best, sought.arrays
    values = np.asarray(to_values(arrays.transform, found.z))
    prediction = jax.tree.map(np.asarray, unpacked(arrays, found.flat))
    predicted, failures, rough = _by_series(problem, prediction)
    deviation = np.concatenate(
        [(p - s.values) * s.weight for p, s in zip(predicted, problem.series, strict=True)]
    )
    slope = slopes_of(arrays, found)
    used = _used_rows(arrays, found)
    rows, data = slope[used], int(np.sum(used[: _data_rows(arrays)]))
    # what is left of them as the loss saw it
    left, loss, seen = found.residual[used][:data], Forgiven(1.0, 1.0), rows
    with np.errstate(over="ignore", invalid="ignore"):
        forgives = spec.loss != "squares" and np.isfinite(np.sum(rows**2))
        if forgives:
            rows, loss = _as_forgiven(spec, arrays, seen, left)
    bound = at_bounds(problem, values, rows, left)
    if forgives and np.any(bound):  # what is held there was not found
        rows, loss = _as_forgiven(spec, arrays, seen, left, bound)
    sizes = np.array([_size(*one) for one in zip(problem.parameters, values, bound, strict=True)])
    with np.errstate(over="ignore", invalid="ignore"):
        shares = np.sum((rows * sizes) ** 2)
    if not np.all(np.isfinite([shares, sought.loss])):
        raise SceneError([Fault(problem.file, None, "free", _overflow_words(problem))])
    known = problem.known_noise
    certainty = certainty_of(
        values, rows, left, problem.points, known, problem.method.confidence, sizes, bound,
        loss.noise,
    )  # fmt: skip
    edges = np.array([(p.low, p.high) for p in problem.parameters])
    low, high = np.maximum(certainty.low, edges[:, 0]), np.minimum(certainty.high, edges[:, 1])
    certainty = certainty._replace(
        low=np.where(bound, low, certainty.low), high=np.where(bound, high, certainty.high)
    )
    criteria = criteria_of(left, problem.points, certainty.effective, known)
    if failures:  # what has no answer has no deviations, and is not the best for that
        certainty = certainty._replace(factor=np.inf)
        criteria = Criteria(np.inf, np.inf)
    return Fitted(
        problem, values, certainty, criteria, predicted, deviation, rough, failures,
        tuple(map(bool, bound)), spec, sought, seconds,
        stalled=tuple(map(bool, falling(problem, arrays, found) & found.converged)),
        began=_began(problem, sought),
    )  # fmt: skip


def _began(problem: FitProblem, sought: Sought) -> tuple[Array, ...] | None:
    """What the start values give of every series, where a search found out and no run failed."""
    if sought.began is None:
        return None
    prediction = jax.tree.map(np.asarray, unpacked(sought.arrays, jax.numpy.asarray(sought.began)))
    predicted, failures, _ = _by_series(problem, prediction)
    return None if failures else predicted


def _as_forgiven(
    spec: Spec, arrays: Arrays, rows: Array, left: Array, held: NDArray[np.bool_] | None = None
) -> tuple[Array, Forgiven]:
    """J of the deviations themselves, by the root of the loss's mean curvature; and that loss.

    Parameters that are `held` at their bounds do not count among those found.

    What was squared is the root of the loss, g = sqrt(rho) with the sign of r, `left` (m,); the first m
    rows are its derivatives, psi/g of those of r.
    """
    c, data = float(arrays.threshold), left.size
    r = deviations_of(left, spec.loss, c)
    psi, _ = influence(r, spec.loss, c)
    rows = np.array(rows)
    rows[:data] *= np.where(psi != 0.0, left / np.where(psi != 0.0, psi, 1.0), 1.0)[:, None]
    norms = np.sqrt(np.sum(rows**2, axis=0))
    scaled = rows / np.where(norms > 0.0, norms, 1.0)
    count = effective_of(scaled if held is None else scaled[:, ~held], data)
    loss = forgiven(r, spec.loss, c, count)
    rows[:data] *= np.sqrt(loss.curvature)
    return rows, loss


def _overflow_words(problem: FitProblem) -> str:
    """What is wrong with start values from which no search finds its way."""
    starts = [f"{p.name} = {format_quantity(p.start, p.unit)}" for p in problem.parameters]
    return (
        "expected start values from which the deviations and their derivatives are finite, found "
        f"{', '.join(starts)}"
    )


def _size(p, x: float, at_bound: bool) -> float:
    """What a parameter is measured by: itself, or where it is 0 or at its bound, how far it may go."""
    if at_bound:
        return max(abs(x), way_of(p))
    if x != 0.0:
        return abs(x)
    gap = 0.5 * (p.high - p.low)
    return gap if np.isfinite(gap) else 1.0


def slopes_of(arrays: Arrays, found: Found) -> Array:
    """Derivatives (n, p) of the rows that were squared by the parameters in SI.

    Args:
        arrays: what was fitted.
        found: where a search ended, `with_slopes`.
    """
    return found.slope / slope_at(arrays.transform, found.z)


def _data_rows(arrays: Arrays) -> int:
    return sum(a.data.size for a in (*arrays.tables, *arrays.groups))


def _used_rows(arrays: Arrays, found: Found) -> NDArray[np.bool_]:
    """Rows of measured values and of smoothness, without padding and without those for failures."""
    weights = [np.ravel(a.weight) > 0.0 for a in (*arrays.tables, *arrays.groups)]
    used = np.concatenate(weights)
    runs = sum(a.every.shape[0] for a in arrays.groups)
    rest = found.residual.size - used.size
    return np.concatenate([used, np.arange(rest) < rest - runs])


def _by_series(problem: FitProblem, found: Prediction):
    """Predictions, failures and roughness in the order of the problem's series."""
    by_record: dict[str, tuple[list[Array], Status, list[float]]] = {}
    for members, values, status, rough in zip(
        _members(problem), found.groups, found.status, found.rough, strict=True
    ):
        for k, record in enumerate(members):
            rows = [values[k, i, : s.x.size] for i, s in enumerate(record.series)]
            by_record[record.name] = (rows, Status(int(status[k])), list(map(float, rough[k])))
    predicted = [f[: t.series.x.size] for f, t in zip(found.tables, problem.tables, strict=True)]
    roughness = [0.0] * len(found.tables)
    failures = []
    for record in problem.records:
        rows, status, rough = by_record[record.name]
        predicted += rows
        roughness += rough
        if status is not Status.OK:
            failures.append((record.name, status))
    return tuple(predicted), tuple(failures), tuple(roughness)


def _members(problem: FitProblem):
    """The records of every group, in the order of its runs."""
    return [[member.record for member in group] for group in grouped(problem)]


def failure_text(name: str, status: Status) -> str:
    """What went wrong with an experiment's run, and what to do."""
    return f"experiments.{name}: {MEANING[status]}; {ADVICE[status]}"
