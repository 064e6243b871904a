"""Runs whose steps nobody can wait for: found before they begin, so that the others go on."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.status import MEANING, Status
from lumpedcable.study.outcome import Table, message_of
from lumpedcable.study.plan import asked_step

if TYPE_CHECKING:
    from lumpedcable.scene import Scene
    from lumpedcable.study.compiled import Ready

__all__ = ["MOST_STEPS", "EndlessError", "endless_words", "mark_endless", "total_steps"]

MOST_STEPS = 10**10
"""Steps of a run beyond which it is not begun: a line of ten segments takes hours for so many."""


class EndlessError(ValueError):
    """A run that would take more than `MOST_STEPS`."""


def endless_words(
    scene: Scene, duration: float, step: float, swept: Mapping[str, float] = MappingProxyType({})
) -> str:
    """Why a run of so many s in steps of `step` (s) is not begun, and what to do about it.

    `swept` are the run's own numbers by key.
    """
    total = duration / step if step > 0.0 else math.inf
    many = f"{total:.3g}" if math.isfinite(total) else f"more than {sys.float_info.max:.3g}"
    if "solver.step" in swept or scene.solver.step is not None:
        whose, change = " (solver.step)", "raise solver.step"
    else:
        whose = ""
        change = "check stiffness, mass and damping for their units, take longer segments"
        if "courant" in scene.solver.model_fields_set:
            courant = swept.get("solver.courant", scene.solver.courant)
            whose = f" (solver.courant, {courant:.3g}, of the largest stable one)"
            change = f"raise solver.courant, {change}"
        graded = [
            f"lines.{n}.grading" for n, line in scene.lines.items() if line.grading is not None
        ]
        if graded:
            change += f" ({' and '.join(graded)} shortens them)"
    return (
        f"{MEANING[Status.TOO_MANY_STEPS]}: it would take {many} of {step:.3g} s{whose}, at most "
        f"{MOST_STEPS:.0e} are taken; {change}, or lower output.duration"
    )


def total_steps(scene: Scene, steps: ArrayLike) -> NDArray[np.float64]:
    """Steps of runs of so many `steps` in an output interval: floats, which do not overflow."""
    return np.asarray(steps, float) * max(scene.output.count, 1)


def mark_endless(
    scene: Scene,
    ready: Ready,
    swept: Mapping[str, NDArray[np.float64]],
    steps: NDArray[np.int64],
    rows: NDArray[np.int64],
    table: Table,
) -> NDArray[np.bool_]:
    """Which runs are endless; they are marked in the table, with their reason.

    Args:
        scene: any that has the runs' structure.
        ready: the runs at rest.
        swept: the runs' own numbers by key, shape (runs,).
        steps: of each run in an output interval, shape (runs,).
        rows: of each run in the table, shape (runs,).
        table: filled where a run is endless.
    """
    found = total_steps(scene, steps) > MOST_STEPS
    asked = asked_step(scene, np.asarray(ready.bound), swept)
    for k in np.flatnonzero(found):
        begun = bool(ready.converged[k])
        status = Status.TOO_MANY_STEPS if begun else Status.STATICS_NOT_CONVERGED
        words = message_of(status, 0.0)
        if begun:
            own = {key: float(values[k]) for key, values in swept.items()}
            words = endless_words(scene, scene.output.duration, float(asked[k]), own)
        table["status"][rows[k]], table["status_time"][rows[k]] = int(status), 0.0
        table["status_message"][rows[k]] = words
        table["summary/static_imbalance"][rows[k]] = ready.imbalance[k]
    return found
