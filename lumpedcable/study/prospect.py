"""What runs would take, before any of them moves: which come to rest, and how each would be stepped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.results.human import runs_named, scale
from lumpedcable.status import TURNED_OVER
from lumpedcable.study.endless import MOST_STEPS, endless_words
from lumpedcable.study.laying import lay_out
from lumpedcable.study.plan import (
    asked_step,
    plan_of,
    relaxing_times,
    stable_bound,
    stepping,
    tolerances,
)
from lumpedcable.study.starts import starts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.scene import Study

__all__ = ["Prospect", "prospect_lines", "prospect_of"]


@dataclass(frozen=True)
class Prospect:
    """What the first runs of a study would take; arrays of shape (runs,).

    Attributes:
        study: whose runs they are.
        converged: which come to rest.
        imbalance: largest force left at rest over the largest force of the scene.
        overturned: runs whose state of rest a touch would turn over.
        bound: largest stable step of leapfrog at rest (s).
        asked: step that is asked for (s), before it is made to divide `output.every`.
        steps: number of steps of the whole run.
        adaptive: whether steps are chosen by the estimated error instead.
    """

    study: Study
    converged: NDArray[np.bool_]
    imbalance: NDArray[np.float64]
    overturned: NDArray[np.bool_]
    bound: NDArray[np.float64]
    asked: NDArray[np.float64]
    steps: NDArray[np.float64]
    adaptive: bool


def prospect_of(study: Study, most: int) -> Prospect:
    """Bring the first runs of a study to rest, at most so many, and tell how they would be stepped.

    Raises:
        SceneError: the scene cannot be laid out.
    """
    laid, runs = lay_out(study), np.arange(min(len(study.runs), most))
    converged, overturned = np.zeros((2, len(runs)), bool)
    imbalance, bound, asked, steps = np.full((4, len(runs)), np.nan)
    which, plan = laid.which(runs), plan_of(laid.scene, laid.structures[0].layout)
    for index in np.unique(which):
        structure, rows = laid.structures[index], np.flatnonzero(which == index)
        scene, mine = structure.scene, runs[rows]
        ready, swept = starts(laid, structure, mine), study.runs.columns(mine)
        converged[rows], imbalance[rows] = ready.converged, ready.imbalance
        overturned[rows] = ready.overturned
        least = np.asarray(ready.bound)
        bound[rows] = least if plan.adaptive else stable_bound(scene, least, swept)
        asked[rows] = asked_step(scene, bound[rows], swept)
        each = stepping(scene, structure.layout, bound[rows], swept)[:, 0]
        steps[rows] = each * laid.count
    return Prospect(study, converged, imbalance, overturned, bound, asked, steps, plan.adaptive)


def prospect_lines(prospect: Prospect) -> list[str]:
    """What a person reads of it."""
    return [_rest(prospect), *(_stepped(prospect) if prospect.converged.any() else ())]


def _rest(prospect: Prospect) -> str:
    """Which runs come to rest."""
    of = len(prospect.converged)
    lost = np.flatnonzero(~prospect.converged)
    first = "the first " if len(prospect.study.runs) > of else ""
    text = f"at rest: {of - len(lost)} of {first}{of} run{'' if of == 1 else 's'}"
    if len(lost):
        most = float(np.max(prospect.imbalance[lost]))
        left = f"largest force left {most:.1e} of the largest in the scene"
        if prospect.overturned[lost].all():
            left = f"what was found is {TURNED_OVER}"
        text += f"; not {runs_named(lost.tolist())}: {left}"
    return text


def _stepped(prospect: Prospect) -> list[str]:
    """How the runs that come to rest would be stepped."""
    scene = prospect.study.scene
    solver, output = scene.solver, scene.output
    if output.static:
        return ["steps: none, the scene is looked at at rest alone"]
    mine = prospect.converged
    if prospect.adaptive:
        rtol, atol = tolerances(solver)
        by_error = f"by their estimated error (rtol {rtol:g}, atol {atol:g})"
        bound = _span(prospect.bound[mine], "s")
        return [f"steps: {solver.method}, {by_error}",
                f"step: the largest stable one of leapfrog is {bound}"]  # fmt: skip
    steps = prospect.steps[mine]
    endless = steps > MOST_STEPS
    if endless.any():
        run = int(np.flatnonzero(mine)[endless.argmax()])
        own = {k: float(v[0]) for k, v in prospect.study.runs.columns(np.array([run])).items()}
        return [f"run {run}: {endless_words(scene, output.duration, prospect.asked[run], own)}"]
    taken = output.duration / steps
    shares = taken / prospect.bound[mine]
    least, most, total = (f"{int(n):,}" for n in (steps.min(), steps.max(), steps.sum()))
    each = most if least == most else f"{least} to {most}"
    known = len(prospect.converged) == len(prospect.study.runs) and np.all(mine)
    in_all = f", {total} in all" if len(steps) > 1 and known else ""
    upto = "at most " if output.stop is not None else ""
    whose = " (solver.step)" if solver.step is not None else ""
    step = f"step: {_span(taken, 's')}{whose}"
    if np.all(np.isfinite(prospect.bound[mine])):  # not of lines that keep their length
        alone = solver.method == "leapfrog" or relaxing_times(scene)
        of = "" if alone else " of leapfrog"
        step += f", {_span(shares, '1')} of the largest stable one{of} at rest"
    if solver.method == "leapfrog" and np.any(shares > 1.0):
        step += ": too long, lower solver.step"
    return [f"steps: {solver.method}, {upto}{each} a run{in_all}", step]


def _span(values: NDArray[np.float64], unit: str) -> str:
    """Values from the least to the largest, with their unit: "0.26 to 0.33 ms"."""
    low, high = float(np.min(values)), float(np.max(values))
    factor, text = scale(high, unit)
    ends = [f"{value * factor:.3g}" for value in (low, high)]
    return f"{ends[0] if ends[0] == ends[1] else ' to '.join(ends)} {text}".rstrip()
