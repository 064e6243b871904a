"""Runs whose steps nobody can wait for: found before they begin, so that the others go on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lumpedcable.status import MEANING, Status
from lumpedcable.study.plan import output_count
from lumpedcable.study.summary import Table, message_of

if TYPE_CHECKING:
    from lumpedcable.scene import Scene
    from lumpedcable.study.compiled import Ready

__all__ = ["MOST_STEPS", "endless", "endless_words", "mark_endless"]

MOST_STEPS = 10**10
"""Steps of a run beyond which it is not begun: a line of ten segments takes hours for so many."""


def endless(scene: Scene, steps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which runs of so many `steps` in an output interval are not begun."""
    # as floats: integers as large as these overflow
    return np.asarray(steps, float) * max(output_count(scene), 1) > MOST_STEPS


def endless_words(scene: Scene, steps: int) -> str:
    """Why a run of so many steps in an output interval is not begun, and what to do about it."""
    total, step = float(steps) * max(output_count(scene), 1), scene.output.every / steps
    return (
        f"{MEANING[Status.TOO_MANY_STEPS]}: it would take {total:.3g} of {step:.3g} s, at most "
        f"{MOST_STEPS:.0e} are taken; check stiffness, mass and damping for their units, take longer "
        "segments, or lower output.duration"
    )


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
    found = endless(scene, steps)
    for k in np.flatnonzero(found):
        begun = bool(ready.converged[k])
        status = Status.TOO_MANY_STEPS if begun else Status.STATICS_NOT_CONVERGED
        words = endless_words(scene, int(steps[k])) if begun else message_of(status, 0.0)
        table["status"][rows[k]], table["status_time"][rows[k]] = int(status), 0.0
        table["status_message"][rows[k]] = words
        table["summary/static_imbalance"][rows[k]] = ready.imbalance[k]
    return found
