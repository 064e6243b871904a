"""How the runs of a part ended, and until when what they tell is to be believed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.status import Status
from lumpedcable.study.account import Account, Balance, balance, statuses
from lumpedcable.study.begins import Starts, starts_of
from lumpedcable.study.compiled import Ready
from lumpedcable.study.known_waves import curve_of
from lumpedcable.study.strains import Strained, strained

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.contents import Contents
    from lumpedcable.study.part import Part

__all__ = ["Ended", "ended_of"]

# ends of a run of which all steps that were taken are right
SOUND = (Status.OK, Status.STILL_MOVING, Status.LENGTH_LOST)


@dataclass(frozen=True)
class Ended:
    """The runs of a part when they are over.

    Attributes:
        contents, part, ready, account: what is kept of which runs, their start and their account.
        times: output times (s), shape (times,).
        status: how each run ended, shape (runs,).
        when: when that was (s), NaN of what went well, shape (runs,).
        energy: how energy went, until then.
        beyond: strains beyond those that a material is used for.
        starts: by event, when it begins in each run (s), inf where it never does, shape (runs,).
    """

    contents: Contents
    part: Part
    ready: Ready
    account: Account
    times: NDArray[np.float64]
    status: NDArray[np.int64]
    when: NDArray[np.float64]
    energy: Balance
    beyond: Strained
    starts: Starts

    @cached_property
    def begun(self) -> NDArray[np.bool_]:
        """Which runs have a state of rest to begin at, shape (runs,)."""
        return self.status != Status.STATICS_NOT_CONVERGED

    @cached_property
    def sound(self) -> NDArray[np.bool_]:
        """Of which runs all steps that were taken are right, shape (runs,)."""
        return np.isin(self.status, SOUND)

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """Which outputs of each run come before anything went wrong, shape (runs, times)."""
        good = self.begun[:, None] & ~(self.times >= self.when[:, None])
        good[:, 0] = self.begun
        return good

    @property
    def step(self) -> float:
        """The step (s), NaN where it is chosen on the way."""
        plan, every = self.part.plan, self.contents.laid.scene.output.every
        return float("nan") if plan.adaptive else every / self.part.steps

    @property
    def bound(self) -> NDArray[np.float64]:
        """The largest stable step of each run at rest (s), shape (runs,)."""
        return np.asarray(self.ready.bound, float)[: len(self.part.runs)]

    @cached_property
    def overstepped(self) -> NDArray[np.bool_]:
        """Which runs end at their start, since their step is too long even there, shape (runs,)."""
        return (self.when <= 0.0) & (self.step > self.bound)

    def largest(self, name: str) -> NDArray[np.float64]:
        """The largest value of each run up to where it went wrong, NaN where it never began."""
        history = self.account.largest[name]
        known = np.max(np.where(self.good & np.isfinite(history), history, -np.inf), axis=1)
        return np.where(np.isfinite(known), known, np.nan)

    def reversed_line(self, run: int) -> str:
        """The line of the model that reversed first in a run."""
        first = int(self.account.signs[Status.LINE_REVERSED][run].argmax())
        names = sorted(self.ready.model.lines)
        return names[int(self.account.largest["reversed of"][run, first])]


def ended_of(contents: Contents, part: Part, ready: Ready, account: Account) -> Ended:
    """How the runs of a part ended: whichever went wrong first, or that they were interrupted."""
    every = contents.laid.scene.output.every
    times = (np.arange(account.count + 1) * every).astype(float)
    converged = np.asarray(ready.converged)[: len(part.runs)]
    status, when = statuses(account, converged, times)
    starts = starts_of(contents.laid.study, part, account)
    energy = balance(account, status, when, times, starts)
    # what is open went wrong before anything else that did: after that the account is not looked at
    opened = energy.opened.any(axis=1)
    status[opened] = Status.ENERGY_NOT_CLOSED
    when = np.where(opened, times[energy.opened.argmax(axis=1)], when)
    beyond = strained(contents, part, ready, account, curve_of)
    over = beyond.over(status, when, times)
    if over.any():
        status[over], when[over] = Status.STRAIN_EXCEEDED, times[beyond.first[over]]
        energy = balance(account, status, when, times, starts)
    well = status == Status.OK
    if not account.complete:
        status[well], when[well] = Status.INTERRUPTED, times[account.reached]
    elif part.plan.stop is not None:
        moving = well & np.isnan(account.stopped)
        status[moving], when[moving] = Status.STILL_MOVING, times[-1]
    return Ended(contents, part, ready, account, times, status, when, energy, beyond, starts)
