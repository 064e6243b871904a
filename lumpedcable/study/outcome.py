"""What is told of a run that has ended: its status, its numbers, and words on both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lumpedcable.results.human import quantity
from lumpedcable.results.schema import END_SPEED
from lumpedcable.scene import Scene
from lumpedcable.scene.outcomes import SUMMARIES
from lumpedcable.status import MEANING, Status, advice_of
from lumpedcable.study.strength import UTILISATION, has_strength

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["EXACT", "Outcome", "Table", "joined", "message_of", "outcomes_of", "summaries_of"]

EXACT = {
    "static_strain": ("1", "strain of a straight line under that tension", "no weight"),
    END_SPEED: (
        "m/s", "speed of the broken end in the exact wave",
        "instantaneous break, no drag, damping or weight"),
    "front_arrival": (
        "s", "time at which the exact wave front reaches the far end",
        "instantaneous break, no drag, damping or weight"),
}  # fmt: skip

Table = dict[str, "NDArray[Any]"]
"""Numbers of runs by their place in the file, each with the runs first."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended, and its numbers (SI); NaN where the run did not get that far."""

    run: int
    status: Status
    status_time: float
    message: str
    steps: int
    solver_step: float
    energy_closure: float
    released_energy: float
    static_imbalance: float
    residual: NDArray[np.float64]
    recoils: Mapping[str, Mapping[str, float]]
    measures: Mapping[str, float] = field(default_factory=dict)
    stop_time: float = float("nan")
    stop_distance: float = float("nan")
    utilisation: float = float("nan")
    peak_tension: float = float("nan")


def summaries_of(scene: Scene) -> dict[str, tuple[str, str]]:
    """Those of `SUMMARIES` that the runs of a scene have: utilisation where a line has a strength."""
    strong = has_strength(scene)
    return {name: told for name, told in SUMMARIES.items() if strong or name != UTILISATION}


def outcomes_of(table: Table, runs: NDArray[np.int64]) -> list[Outcome]:
    """The rows of a table, one by one."""
    ends: dict[str, list[str]] = {}
    for path in table:
        parts = path.split("/")
        if parts[0] == "summary" and len(parts) == 3:
            ends.setdefault(parts[1], []).append(parts[2])
    own_numbers = {*SUMMARIES, "solver_steps"}
    flat = (path.removeprefix("summary/") for path in table if path.count("/") == 1)
    measured = [n for n in flat if n not in own_numbers and f"summary/{n}" in table]
    nothing = np.full((len(runs), 1), np.nan)
    residual = table.get("energy/residual", nothing)
    found = []
    for k, run in enumerate(runs):
        told = (name for name in SUMMARIES if f"summary/{name}" in table)
        own = {name: float(table[f"summary/{name}"][k]) for name in told}
        recoils = {
            end: {name: float(table[f"summary/{end}/{name}"][k]) for name in names}
            for end, names in ends.items()
            if not np.isnan(table[f"summary/{end}/break_start"][k])
        }
        outcome = Outcome(
            run=int(run),
            status=Status(int(table["status"][k])),
            status_time=float(table["status_time"][k]),
            message=str(table["status_message"][k]),
            steps=int(table["summary/solver_steps"][k]),
            solver_step=own["solver_step"],
            energy_closure=own["energy_closure"],
            released_energy=own["released_energy"],
            static_imbalance=own["static_imbalance"],
            residual=residual[k],
            recoils=recoils,
            measures={name: float(table[f"summary/{name}"][k]) for name in measured},
            stop_time=own["stop_time"],
            stop_distance=own["stop_distance"],
            utilisation=own.get(UTILISATION, float("nan")),
            peak_tension=own["peak_tension"],
        )
        found.append(outcome)
    return found


def message_of(status: Status, when: float, remark: str = "", *, step_given: bool = False) -> str:
    """What happened at a time (s), and what to do about it; of a run that went well, a remark.

    `step_given` is whether the scene gives `solver.step`.
    """
    if status is Status.OK:
        return joined(MEANING[status], remark)
    at = "" if not np.isfinite(when) else f" at {quantity(when, 's', 6)}"
    return f"{MEANING[status]}{at}; {advice_of(status, step_given)}"


def joined(*words: str) -> str:
    """What is said, one after the other."""
    return "; ".join(filter(None, words))
