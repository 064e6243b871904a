"""The same fit to the data of many ropes: those of one structure go together, one a lane (vmap)."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace

import jax
import numpy as np

from lumpedcable.fitting.arrays import Arrays, GroupArrays, Spec, TableArrays, arrays_of
from lumpedcable.fitting.bounds import falling, with_slopes
from lumpedcable.fitting.data import FitProblem
from lumpedcable.fitting.minimise import Found, searches
from lumpedcable.fitting.profile import flagged, with_profiles
from lumpedcable.fitting.residual import unpacked
from lumpedcable.fitting.run import Fitted, fit_problem, fitted_from
from lumpedcable.fitting.seek import Sought, Start, at_own_steps, beside, seek, wants_others
from lumpedcable.fitting.transforms import to_unbounded, to_values

__all__ = ["fit_ropes"]

Setting = tuple[Spec, Arrays]


def fit_ropes(problems: Mapping[str, FitProblem]) -> dict[str, Fitted]:
    """Fit every rope by itself, all at once.

    Ropes whose problems differ in numbers alone are lanes of one search (`jax.vmap`), shorter data
    padded with weights of zero. A rope whose search ends badly is searched again alone, from other
    starts. Profiles are made one after the other, of numbers whose file asks for them alone.
    """
    made = dict(zip(problems, _alike([arrays_of(p) for p in problems.values()]), strict=True))
    lanes: dict[object, list[str]] = {}
    for name, (spec, arrays) in made.items():
        shapes = tuple(np.shape(leaf) for leaf in jax.tree.leaves(arrays))
        lanes.setdefault((spec, jax.tree.structure(arrays), shapes), []).append(name)
    found = {}
    for names in lanes.values():
        if len(names) == 1:
            found[names[0]] = fit_problem(problems[names[0]])
        else:
            with np.errstate(over="ignore", invalid="ignore"):  # told by `fitted_from`
                found |= _together({name: problems[name] for name in names}, made)
    return {name: _profiled(found[name]) for name in problems}


def _profiled(fitted: Fitted) -> Fitted:
    """A fit with the profiles that its file asks for."""
    asked = [k for k in flagged(fitted) if fitted.problem.parameters[k].profile]
    return with_profiles(fitted, asked)


def _together(problems: Mapping[str, FitProblem], made: Mapping[str, Setting]) -> dict[str, Fitted]:
    begun = clock.perf_counter()
    first = next(iter(problems.values()))
    spec = made[next(iter(problems))][0]
    arrays = jax.tree.map(lambda *leaves: np.stack(leaves), *[made[name][1] for name in problems])
    z = np.stack(
        [
            to_unbounded(made[name][1].transform, np.array([q.start for q in p.parameters]))
            for name, p in problems.items()
        ]
    )
    found, arrays = _searched(first, spec, arrays, z)
    share = (clock.perf_counter() - begun) / len(problems)
    fits = {}
    for k, (name, problem) in enumerate(problems.items()):
        begun = clock.perf_counter()
        mine, own = (jax.tree.map(lambda leaf, k=k: leaf[k], tree) for tree in (found, arrays))
        mine = with_slopes(spec, own, mine)
        start = np.array([p.start for p in problem.parameters])
        values = np.asarray(to_values(own.transform, mine.z))
        one = Start(
            start, values, float(np.sum(mine.residual**2)), int(mine.steps), int(mine.failed),
            bool(mine.converged) and not np.any(falling(problem, own, mine)),
        )  # fmt: skip
        sought = Sought((one,), mine, own, 0)
        if problem.method.starts is not None or wants_others(problem, spec, sought):
            sought = seek(problem, *made[name])
        alone = clock.perf_counter() - begun
        fits[name] = fitted_from(problem, spec, sought, share + alone)
    return fits


def _searched(problem: FitProblem, spec: Spec, arrays: Arrays, z) -> tuple[Found, Arrays]:
    """All lanes searched, once more from beside their ends, and at the steps that their ends want."""
    method = problem.method

    def once(z, arrays: Arrays) -> Found:
        found = searches(spec, arrays, z, method.solver, method.tolerance, method.max_steps, 0)
        return jax.tree.map(np.asarray, found)

    found = once(z, arrays)
    if problem.records:
        random = np.random.default_rng(method.seed)
        found = _better(found, once(beside(found.z, random), arrays))

    def again(found: Found, arrays: Arrays) -> Found:
        after = once(found.z, arrays)
        return after._replace(steps=found.steps + after.steps, failed=found.failed + after.failed)

    def taken(arrays: Arrays, found: Found):
        return jax.vmap(lambda a, flat: unpacked(a, flat).steps)(arrays, found.flat)

    return at_own_steps(spec, arrays, found, taken, again)


def _better(one: Found, other: Found) -> Found:
    """By lane the end with the smaller loss; what both took together."""
    losses = [np.sum(f.residual**2, axis=1) for f in (one, other)]
    second = losses[1] < losses[0]

    def pick(a, b):
        return np.where(second.reshape(-1, *[1] * (a.ndim - 1)), b, a)

    best = jax.tree.map(pick, one, other)
    return best._replace(steps=one.steps + other.steps, failed=one.failed + other.failed)


def _alike(settings: Sequence[Setting]) -> list[Setting]:
    """The same problems, data padded to the longest and outputs of all runs as many as the most."""
    tables = [
        max(a.tables[k].data.size for _, a in settings) for k in range(_fewest(settings, "tables"))
    ]
    groups = range(_fewest(settings, "groups"))
    points = [max(a.groups[k].data.shape[2] for _, a in settings) for k in groups]
    counts = [max(s.groups[k].count for s, _ in settings) for k in groups]
    own = [[_own_outputs(s, a, k) for k in groups] for s, a in settings]
    even = [all(np.all(mine[k] == counts[k]) for mine in own) for k in groups]
    found = []
    for (spec, arrays), mine in zip(settings, own, strict=True):
        ends = [None if even[k] else mine[k] for k in groups]
        specs = tuple(replace(s, count=n) for s, n in zip(spec.groups, counts, strict=False))
        found.append(
            (
                replace(spec, groups=(*specs, *spec.groups[len(specs) :])),
                arrays._replace(
                    tables=tuple(map(_longer_table, arrays.tables, tables)),
                    groups=tuple(map(_longer_group, arrays.groups, points, ends)),
                ),
            )
        )
    return found


def _fewest(settings: Sequence[Setting], kind: str) -> int:
    return min(len(getattr(arrays, kind)) for _, arrays in settings)


def _longer_table(table: TableArrays, points: int) -> TableArrays:
    more = (0, points - table.data.size)
    return table._replace(
        strain=np.pad(table.strain, more, mode="edge"), data=np.pad(table.data, more),
        weight=np.pad(table.weight, more),
        time=None if table.time is None else np.pad(table.time, more, mode="edge"),
    )  # fmt: skip


def _own_outputs(spec: Spec, arrays: Arrays, k: int) -> np.ndarray:
    """Outputs (runs,) that the data of each run of a group need."""
    group = arrays.groups[k]
    own = group.last
    return np.full(group.every.shape, spec.groups[k].count) if own is None else own


def _longer_group(group: GroupArrays, points: int, last: np.ndarray | None) -> GroupArrays:
    more = (0, points - group.data.shape[2])

    def rows(values):
        return np.pad(values, [(0, 0), more, (0, 0)])

    def behind(values):
        return np.pad(values, [(0, 0), (0, 0), more])

    return group._replace(
        last=last, near=rows(group.near), mix=rows(group.mix), less=rows(group.less),
        data=behind(group.data), weight=behind(group.weight),
    )  # fmt: skip
