"""Strains beyond the range that a law is used for: when, of which line, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from lumpedcable.results.human import quantity
from lumpedcable.scene import Scene
from lumpedcable.status import MEANING, Status, advice_of
from lumpedcable.study.account import Account
from lumpedcable.study.begins import source_of
from lumpedcable.study.compiled import Ready

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from lumpedcable.study.contents import Contents
    from lumpedcable.study.part import Part

Law = Callable[["ArrayLike"], "NDArray[np.float64]"]
Curve = Callable[[Scene, str], Law]

__all__ = ["Strained", "strain_under", "strained"]

# share by which a strain may pass max_strain: what rounding and the noise of a mesh make of one there
MORE = 1e-3
LATER = 0.01  # share by which the strain of a later time is larger, if it is told
SAMPLES = 201  # strains looked at between 0 and max_strain, both included


class Strained:
    """Which runs strained a line beyond max_strain of its material, and what to say of them.

    Attributes:
        first: number of the first output that shows it, shape (runs,); one after the last of none.
        words: of each run which line, and how far; "" where none was.
    """

    def __init__(self, runs: int, times: int):
        self.first: NDArray[np.int64] = np.full(runs, times)
        self.words: list[str] = [""] * runs

    def say(
        self, run: int, first: int, line: str, strains: tuple[float, float], most: float
    ) -> None:
        """Note strains (-) of a line beyond the `most` that its material is used for.

        They are that of the `first` output that shows it, and the largest of the run.
        """
        self.first[run] = first
        then, top = strains
        later = f", and {top:.4g} later on" if top > (1.0 + LATER) * then else ""
        self.words[run] = (
            f'line "{line}" reached a strain of {then:.4g}{later}, '
            f"max_strain of its material is {most:g}"
        )

    def over(
        self, status: NDArray[np.int64], when: NDArray[np.float64], times: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Of which runs that is the first thing that went wrong, beside what else did at `when` (s).

        A wave that became too fast for the step, as beyond max_strain it may, is what is told of it.
        """
        begins = np.append(times, np.inf)[self.first]
        told = (int(Status.STATICS_NOT_CONVERGED), int(Status.STEP_BOUND_BROKEN))
        earlier = np.isfinite(begins) & ((status == Status.OK) | (begins < when))
        return earlier & ~np.isin(status, told)

    def message(self, run: int, when: float) -> str:
        """What happened in a run at a time (s), and what to do about it."""
        status = Status.STRAIN_EXCEEDED
        at = f"at {quantity(when, 's', 6)}"
        return f"{MEANING[status]} {at}: {self.words[run]}; {advice_of(status, False)}"


def strained(
    contents: Contents, part: Part, ready: Ready, account: Account, curve: Curve
) -> Strained:
    """Look for strains beyond max_strain in what is kept of the runs of a part.

    At the output times their strains say so. Between them the largest tension of any step does, where it
    is known: without damping a law gives more than it has on [0, max_strain] beyond it alone. `curve`
    makes the law of a line of a scene (N over strain).
    """
    times = account.reached + 1
    found = Strained(len(part.runs), account.count + 1)
    names = sorted(ready.model.lines)
    for what in ("stretch", "pull"):
        if what not in account.largest:
            continue
        share, whose = account.largest[what][:, :times], account.largest[f"{what} of"]
        beyond = (share > 1.0 + MORE) & np.isfinite(share)  # what overflows has a status of its own
        for run in np.flatnonzero(beyond.any(axis=1) & (found.first > account.count)):
            top = int(np.argmax(np.where(beyond[run], share[run], -np.inf)))
            scene = contents.study.runs[int(part.runs[run])]
            line = source_of(scene, names[int(whose[run, top])])
            most, first = scene.materials[scene.lines[line].material].max_strain, beyond[run]
            when = int(first.argmax())
            law = curve(scene, line) if what == "pull" else None
            if (largest := _strain(law, float(share[run, top]), most)) is not None:
                then = _strain(law, float(share[run, when]), most) or largest
                found.say(int(run), when, line, (then, largest), most)
    return found


def _strain(law: Law | None, share: float, most: float) -> float | None:
    """So many times `most`; with a law, the strain at which it gives so many times its tension there."""
    return share * most if law is None else strain_under(law, share, most)


def strain_under(law: Law, share: float, most: float) -> float | None:
    """The strain above `most` at which a law gives so many times its tension at `most`.

    None where it gives that much below already, or nowhere.
    """

    def under(strain: float) -> float:
        return float(law(np.asarray([strain]))[0]) - tension

    tension = share * float(law(np.asarray([most]))[0])
    if np.max(law(np.linspace(0.0, most, SAMPLES))) * (1.0 + MORE) >= tension:
        return None
    low, high = most, 2.0 * most
    while under(high) < 0.0:
        low, high = high, 2.0 * high
        if not np.isfinite(high):
            return None
    return float(brentq(under, low, high))  # type: ignore[arg-type]
