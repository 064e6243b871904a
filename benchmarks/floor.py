"""What a front that is one segment wide costs, however well it is placed and shaped.

A chain knows its tension in the mean over a segment. The true history at the wall, averaged over the
time in which the front crosses one segment, is what a chain without any other fault would show.
"""

from __future__ import annotations

import numpy as np

from benchmarks.cases import MAIN, seen
from benchmarks.measures import FINE, Histories, relative
from benchmarks.problem import Array
from benchmarks.reference import load

MESHES = (50, 100, 200, 400)
PARTS = 50  # of a sample, in which the mean is taken


def floor(truth: Histories, segments: int) -> float:
    """T_c (relative L2, 0.1 ms samples) of the true history averaged over the crossing of a segment."""
    samples = truth.at(FINE)
    return relative(
        averaged(samples.time, samples.tension, truth.front / segments), samples.tension
    )


def averaged(time: Array, values: Array, width: float) -> Array:
    """Mean of a history, linear between its times (s), over `width` (s) around each of them.

    Before the first time and after the last one it keeps its value.
    """
    step = (time[1] - time[0]) / PARTS
    reach = np.arange(time[0] - width, time[-1] + width + step, step)
    at = np.interp(reach, time, values)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * step * (at[1:] + at[:-1]))])
    before, after = (np.interp(time + side, reach, integral) for side in (-width / 2, width / 2))
    return (after - before) / width


def table() -> str:
    """By mesh and case, in per cent."""
    truths = load()
    rows = []
    for kind in ("5 ms", "at once"):
        names, pretensions = seen([{"case": c.name} for c in MAIN if c.name.endswith(kind)])
        if not rows:
            meshes = " | ".join(f"N = {n}" for n in MESHES)
            rows = [f"| T_c, %, {pretensions} kN | {meshes} |", "|---" * (len(MESHES) + 1) + "|"]
        cells = (
            " / ".join(f"{100 * floor(truths[name].histories, n):.2g}" for name in names)
            for n in MESHES
        )
        rows.append(f"| break {kind} | {' | '.join(cells)} |")
    return "\n".join(rows)
