"""Runs whose steps nobody can wait for: found before they begin, so that the others go on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.status import MEANING, Status
from lumpedcable.study.summary import Table, message_of

if TYPE_CHECKING:
    from lumpedcable.scene import Scene
    from lumpedcable.study.compiled import Ready

__all__ = ["MOST_STEPS", "EndlessError", "endless_words", "mark_endless", "total_steps"]

MOST_STEPS = 10**10
"""Steps of a run beyond which it is not begun: a line of ten segments takes hours for so many."""


class EndlessError(ValueError):
    """A run that would take more than `MOST_STEPS`."""


def endless_words(total: float, step: float) -> str:
    """Why a run of so many steps of `step` (s) is not begun, and what to do about it."""
    return (
        f"{MEANING[Status.TOO_MANY_STEPS]}: it would take {total:.3g} of {step:.3g} s, at most "
        f"{MOST_STEPS:.0e} are taken; check stiffness, mass and damping for their units, take longer "
        "segments, or lower output.duration"
    )


def total_steps(scene: Scene, steps: ArrayLike) -> NDArray[np.float64]:
    """Steps of runs of so many `steps` in an output interval: floats, which do not overflow."""
    return np.asarray(steps, float) * max(scene.output.count, 1)


def mark_endless(
    scene: Scene, ready: Ready, steps: NDArray[np.int64], rows: NDArray[np.int64], table: Table
) -> NDArray[np.bool_]:
    """Which runs are endless; they are marked in the table, with their reason.

    Args:
        scene: any that has the runs' structure.
        ready: the runs at rest.
        steps: of each run in an output interval, shape (runs,).
        rows: of each run in the table, shape (runs,).
        table: filled where a run is endless.
    """
    totals, every = total_steps(scene, steps), scene.output.every
    found = totals > MOST_STEPS
    for k in np.flatnonzero(found):
        begun = bool(ready.converged[k])
        status = Status.TOO_MANY_STEPS if begun else Status.STATICS_NOT_CONVERGED
        words = endless_words(totals[k], every / steps[k]) if begun else message_of(status, 0.0)
        table["status"][rows[k]], table["status_time"][rows[k]] = int(status), 0.0
        table["status_message"][rows[k]] = words
        table["summary/static_imbalance"][rows[k]] = ready.imbalance[k]
    return found
