"""Where searches begin and how they go on: given starts, more of them, and others where one fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.stats import qmc

from lumpedcable.fitting.arrays import Arrays, Spec
from lumpedcable.fitting.bounds import falling, inside, with_slopes
from lumpedcable.fitting.branches import as_begun, in_order
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.linear import is_linear, linear_start
from lumpedcable.fitting.minimise import Found, search
from lumpedcable.fitting.residual import penalised, unpacked
from lumpedcable.fitting.transforms import to_unbounded, to_values, transform_of
from lumpedcable.fitting.uncertainty import effective_of
from lumpedcable.status import Status
from lumpedcable.study.compiled import RUN_OFTEN
from lumpedcable.study.kept import program

__all__ = [
    "UNLIKELY",
    "Sought",
    "Start",
    "at_own_steps",
    "beside",
    "chance_of",
    "ordered",
    "seek",
    "settled",
    "wants_others",
]

Array = NDArray[np.float64]

STEP_ROUNDS = 3
NUDGES, NUDGE, WORTH = 4, 1e-3, 1e-3
"""Most starts beside an end, their relative distance from it, and the gain that asks for one more."""
SAMPLE, RESCUES, REACH = 64, 4, 3.0
"""Where a search ends badly: places tried, searches from the best of them, and the factor by which a
number without bounds is at most changed."""
DECADES = 30.0
"""That factor for times within which something relaxes."""
SAME, ALIKE = 1e-3, 3
"""Relative difference of two losses that are one, and how many of one are believed to be the least."""
UNLIKELY = 1e-3
"""Probability of such deviations by chance, below which the scene is in doubt."""
POOR = 0.1
"""Deviation over the largest value that is too much where the noise is not known."""


class Start(NamedTuple):
    """One search: where it began and ended (SI), the loss there, and what it took."""

    start: Array
    values: Array
    loss: float
    steps: int
    failed: int
    converged: bool


class Sought(NamedTuple):
    """All searches, the best with its arrays; `sampled` places were tried without derivatives.

    `began` is the `Prediction` at the start values, packed, of records whose first search ended badly.
    """

    starts: tuple[Start, ...]
    best: Found
    arrays: Arrays
    sampled: int
    began: Array | None = None

    @property
    def loss(self) -> float:
        """The least sum of squares."""
        return min(start.loss for start in self.starts)


def seek(
    problem: FitProblem,
    spec: Spec,
    arrays: Arrays,
    tell: Callable[[str], None] = lambda words: None,
) -> Sought:
    """Search from every start; without a number of starts, from others if the first ends badly."""
    sought: Sought | None = None

    def go(start: Array) -> Sought:
        tell(f"search {len(sought.starts) + 1 if sought else 1}")
        one, found, mine = settled(problem, spec, arrays, start)
        if sought is None:
            return Sought((one,), found, mine, 0)
        starts = (*sought.starts, one)
        if one.loss < sought.loss:
            return sought._replace(starts=starts, best=found, arrays=mine)
        return sought._replace(starts=starts)

    first, *more = _starts(problem)
    for start in (first, *more):
        sought = go(start)
    assert sought is not None
    if problem.method.starts is not None or not wants_others(problem, spec, sought):
        return sought
    badly = bad_end(problem, spec, sought)
    for start in _others(problem, spec, arrays, sought):
        sought = go(start)
        alike = [abs(s.loss - sought.loss) <= SAME * sought.loss for s in sought.starts]
        if sum(alike) >= ALIKE or not bad_end(problem, spec, sought):
            break
    if not badly:
        return sought
    began = None
    if problem.records:  # by the program that the sample was tried with
        began = np.asarray(_plain(spec, arrays, to_unbounded(arrays.transform, first))[1])
    return sought._replace(sampled=SAMPLE, began=began)


def ordered(problem: FitProblem, spec: Spec, sought: Sought) -> Sought:
    """The best search with the branches of each material in the order in which they began."""
    found = as_begun(problem, spec, sought.arrays, sought.best)
    if found is sought.best:
        return sought
    values = np.asarray(to_values(sought.arrays.transform, found.z))
    best = int(np.argmin([start.loss for start in sought.starts]))
    starts = list(sought.starts)
    starts[best] = starts[best]._replace(values=values, loss=float(np.sum(found.residual**2)))
    return sought._replace(starts=tuple(starts), best=found)


def _starts(problem: FitProblem) -> list[Array]:
    """The start values, and a scrambled Sobol sample between the bounds for more of them."""
    first = np.array([p.start for p in problem.parameters])
    more = (problem.method.starts or 1) - 1
    return [first, *_sample(problem, more)] if more else [first]


def _sample(problem: FitProblem, count: int) -> Array:
    """Values (count, p), seeded: between two bounds evenly, else by factors up to `REACH` either way.

    Of times within which something relaxes the logarithms are even, to bounds or to `DECADES`.
    """
    low, high, start = problem.ranges
    sobol = qmc.Sobol(start.size, rng=problem.method.seed)
    share = sobol.random_base2(int(np.ceil(np.log2(count))))[:count]
    factor = REACH ** (2.0 * share - 1.0)
    has_low, has_high = np.isfinite(low), np.isfinite(high)
    with np.errstate(invalid="ignore"):
        # bounds themselves are infinitely far away for the search
        between = low + (0.02 + 0.96 * share) * (high - low)
        above, below = low + (start - low) * factor, high - (high - start) * factor
    size = transform_of(problem.parameters).scale
    free = np.where(start != 0.0, start * factor, (2.0 * share - 1.0) * size)
    found = np.select([has_low & has_high, has_low, has_high], [between, above, below], free)
    spread = np.array([p.spread for p in problem.parameters])
    least = np.where(low > 0.0, low, start / DECADES)[spread]
    most = np.where(has_high, high, start * DECADES)[spread]
    found[:, spread] = least * (most / least) ** (0.02 + 0.96 * share[:, spread])
    return found


def _others(problem: FitProblem, spec: Spec, arrays: Arrays, sought: Sought) -> Iterator[Array]:
    """Starts from a sample: with its linear numbers solved for, if there are; the least loss first.

    Where something relaxes within times that are to be found, first with those alone changed where a
    search ended.
    """
    losses, places = [], _sample(problem, SAMPLE)
    first = np.array([p.start for p in problem.parameters])
    if _many_minima(problem):
        spread = [p.spread for p in problem.parameters]
        best = min(sought.starts, key=lambda s: s.loss).values
        retimed = np.where(spread, in_order(problem, places), best)
        solved = linear_start(problem, retimed, turned=False)
        if solved is not None:
            yield solved
    solved = linear_start(problem, [first, *places])
    if solved is not None:
        yield solved
    for place in places:
        rows, _ = _plain(spec, arrays, to_unbounded(arrays.transform, place))
        losses.append(float(np.sum(np.asarray(rows) ** 2)))
    order = np.argsort(np.nan_to_num(losses, nan=np.inf), kind="stable")
    yield from places[order[:RESCUES]]


_plain = program(penalised, ("spec",), RUN_OFTEN)


def bad_end(problem: FitProblem, spec: Spec, sought: Sought) -> bool:
    """Whether the best search has not come to an end that could be the right one."""
    best = min(sought.starts, key=lambda s: s.loss)
    if not best.converged or not np.isfinite(best.loss):
        return True
    status = unpacked(sought.arrays, sought.best.flat).status
    if any(np.any(np.asarray(s) != Status.OK) for s in status):
        return True
    if not problem.known_noise:
        return bool(np.sqrt(best.loss / problem.freedom) > POOR)
    square, free = best.loss, float(problem.freedom)
    if spec.smooth:  # the data alone, and what the numbers that they determine leave of them
        data = sum(a.data.size for a in (*sought.arrays.tables, *sought.arrays.groups))
        square = float(np.sum(sought.best.residual[:data] ** 2))
        free = max(problem.points - effective_of(np.asarray(sought.best.slope), data), 1.0)
    return chance_of(square, free) < UNLIKELY


def wants_others(problem: FitProblem, spec: Spec, sought: Sought) -> bool:
    """Whether others could find better than the first search: it ended badly, at no only minimum.

    Or where there are likely others, which noise that is not known does not tell from the least.
    """
    if _many_minima(problem):
        return True
    return bad_end(problem, spec, sought) and not (
        sought.starts[0].converged and is_linear(problem)
    )


def _many_minima(problem: FitProblem) -> bool:
    """Whether tables alone tell times within which something relaxes.

    A sum of decays has minima of its own where one of them is too short for any row, as a dashpot.
    """
    return not problem.records and any(p.spread for p in problem.parameters)


def chance_of(square: float, free: float) -> float:
    """Probability of a sum of squared deviations (over the noise) so large, if the scene is right."""
    return float(stats.chi2.sf(square, free))


def settled(
    problem: FitProblem, spec: Spec, arrays: Arrays, start: Array
) -> tuple[Start, Found, Arrays]:
    """A search, repeated from its end while its result wants another number of steps in time.

    While searching, more steps are taken where the values of the moment need them; the result is
    that of one fixed number, so that it does not depend on the way.
    """
    method = problem.method
    z = to_unbounded(arrays.transform, start)
    steps = failed = 0

    def once(z: Array, arrays: Arrays) -> Found:
        nonlocal steps, failed
        found = search(spec, arrays, z, method.solver, method.tolerance, method.max_steps)
        found = jax.tree.map(np.asarray, found)
        steps, failed = steps + int(found.steps), failed + int(found.failed)
        return found

    found = _nudged(problem, once, once(z, arrays), arrays)
    found = _off_bounds(problem, spec, once, with_slopes(spec, arrays, found), arrays)
    found, arrays = at_own_steps(
        spec, arrays, found, lambda a, end: unpacked(a, end.flat).steps,
        lambda end, a: with_slopes(spec, a, once(end.z, a)),
    )  # fmt: skip
    values = np.asarray(to_values(arrays.transform, found.z))
    loss = float(np.sum(found.residual**2))
    converged = bool(found.converged) and not np.any(falling(problem, arrays, found))
    return Start(start, values, loss, steps, failed, converged), found, arrays


def _off_bounds(problem: FitProblem, spec: Spec, once, found: Found, arrays: Arrays) -> Found:
    """A search that ran to a bound from which the loss falls inwards goes on from off that bound."""
    falls = falling(problem, arrays, found)
    if not (found.converged and np.any(falls)):
        return found
    other = with_slopes(spec, arrays, once(inside(found.z, falls), arrays))
    return other if np.sum(other.residual**2) < np.sum(found.residual**2) else found


def at_own_steps(
    spec: Spec,
    arrays: Arrays,
    found: Found,
    taken: Callable[[Arrays, Found], Sequence[Any]],
    again: Callable[[Found, Arrays], Found],
) -> tuple[Found, Arrays]:
    """A search and its arrays, gone on with until it ends at the steps that its end wants.

    Args:
        spec, arrays, found: the search, or searches side by side.
        taken: of arrays and ends, the steps of each group that they want.
        again: goes on from an end with other arrays.
    """
    for _ in range(STEP_ROUNDS):
        wanted = [np.asarray(n).astype(int) for n in taken(arrays, found)]
        if all(
            group.steps is not None or group.plan.adaptive or np.array_equal(a.steps, n)
            for group, a, n in zip(spec.groups, arrays.groups, wanted, strict=True)
        ):
            break
        groups = tuple(a._replace(steps=n) for a, n in zip(arrays.groups, wanted, strict=True))
        arrays = arrays._replace(groups=groups)
        found = again(found, arrays)
    return found, arrays


def beside(z: Array, random: np.random.Generator) -> Array:
    """A place next to the end of a search."""
    return z + NUDGE * np.maximum(np.abs(z), 1.0) * random.standard_normal(z.shape)


def _nudged(problem: FitProblem, once, found: Found, arrays: Arrays) -> Found:
    """A search ended in a crease of the loss goes on beside it.

    Records of a line that goes slack have creases and small jumps; where the search ends in one, a
    start next to it finds the way on. Tables alone have none.
    """
    random = np.random.default_rng(problem.method.seed)
    for _ in range(NUDGES if problem.records else 0):
        other = once(beside(found.z, random), arrays)
        here, there = (float(np.sum(one.residual**2)) for one in (found, other))
        if there < here:
            found = other
        if there >= here * (1.0 - WORTH):
            break
    return found
