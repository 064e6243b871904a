"""Which runs go into one figure, what the panels are called, and what the file is called."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumpedcable.results.axes import Axis
from lumpedcable.results.human import quantity
from lumpedcable.results.reader import OK, ResultFile
from lumpedcable.results.sound import NOT_YET, WELL
from lumpedcable.results.spread import even
from lumpedcable.view import style

MOST_PANELS = 12
"""Panels in one figure; of more runs an even choice is shown."""

_DIGITS = 4  # of values in titles


@dataclass(frozen=True)
class Group:
    """Runs shown in one figure.

    Attributes:
        label: the swept numbers that they share, e.g. "break time 5 ms".
        tag: part of a file name that sets this group apart, e.g. "break_time_5ms"; "" if it is all.
        runs: the runs shown.
        titles: one per run shown: what sets it apart, and its status where it failed.
        note: what a reader must know, such as runs left out; "" if nothing.
        every: all its runs, those that are not shown too.
    """

    label: str
    tag: str
    runs: tuple[int, ...]
    titles: tuple[str, ...]
    note: str
    every: tuple[int, ...]

    def heading(self, result: ResultFile, what: str) -> str:
        """Title of a figure of this group."""
        first = str(result.attributes.get("title", ""))
        return "\n".join(filter(None, [first, ", ".join(filter(None, [what, self.label]))]))

    def clock(self, result: ResultFile, times: NDArray[np.float64]) -> style.Clock:
        """How figures of this group tell output times (s): to where the last went wrong or stopped."""
        runs = list(self.runs)
        ended, stop = result.status_time[runs], result.summary().get("run", {}).get("stop_time")
        if stop is not None:
            ended = np.where(np.isfinite(ended), ended, stop[runs])
        return style.clock(times, float(ended.max()) if np.isfinite(ended).all() else None)


def groups(result: ResultFile) -> list[Group]:
    """The groups of a result: one per value of the last swept number where several are swept.

    A last number of more than `MOST_PANELS` values does not make groups: so many figures would help
    nobody. Nor does one that is another in every run, as where numbers move together.
    """
    axes = result.axes_apart
    last = axes[-1] if len(axes) + bool(result.cases) > 1 and axes else None
    values = np.unique(last.values) if last else np.zeros(0)
    # of numbers that move together each is another in every run, of a grid only a single one is
    sizes = [np.unique(axis.values).size for axis in axes]
    grid = np.prod([*sizes, max(len(set(result.cases)), 1)]) == result.runs
    together = len(values) == result.runs and not grid
    if last is None or together or not 1 < len(values) <= MOST_PANELS:
        return [_group(result, list(range(result.runs)), "")]
    made: list[Group] = []
    for value in dict.fromkeys(last.values.tolist()):
        runs = [run for run in range(result.runs) if last.values[run] == value]
        tag = file_tag(f"{last.words} {quantity(float(value), last.unit)}")
        if tag in [group.tag for group in made]:  # values that differ beyond the digits shown
            tag += f"_{len(made)}"
        made.append(_group(result, runs, tag))
    return made


def ends_note(result: ResultFile, runs: Sequence[int], then: str = "") -> str:
    """How many of some runs went wrong, and what `then`, and how many are to be computed yet; or "".

    One alone is told by its title.
    """
    every = result.status  # read once for all
    ends, notes = [every[run] for run in runs], []
    wrong, open_yet = sum(end not in WELL for end in ends), ends.count(NOT_YET)
    if wrong and len(runs) > 1:
        notes.append("; ".join(filter(None, [f"{wrong} of {len(runs)} runs went wrong", then])))
    if open_yet and len(runs) > 1:
        are = "is" if open_yet == 1 else "are"
        notes.append(f"{open_yet} of {len(runs)} runs {are} not computed yet")
    return " ".join(f"{note}." for note in notes)


def alone(result: ResultFile, run: int) -> Group:
    """One run of a result, whatever it belongs to; its number sets it apart where there are others."""
    return _group(result, [run], f"run_{run}" if result.runs > 1 else "")


def file_tag(label: str) -> str:
    """A label as part of a file name: "break time 5 ms" is break_time_5ms."""
    text = re.sub(r"(?<=\d) (?=[^\W\d])", "", label).replace("µ", "u").replace("/", "_per_")
    return re.sub(r"[^A-Za-z0-9.+-]+", "_", text).strip("_")


def _group(result: ResultFile, runs: list[int], tag: str) -> Group:
    shown = runs
    notes = []
    if len(runs) > MOST_PANELS:
        shown = [runs[place] for place in even(len(runs), MOST_PANELS)]
        which = ", ".join(map(str, shown))
        notes.append(f"{len(shown)} of {len(runs)} runs shown: numbers {which}.")
    if not result.complete:
        notes.append("The study is incomplete.")
    # what the runs share goes above the figure, what sets them apart above the panels
    axes = result.axes_apart
    shared = [axis for axis in axes if len(set(axis.values[runs].tolist())) == 1]
    label = ", ".join(axis.text(runs[0], _DIGITS) for axis in shared)
    apart = [axis for axis in axes if len(set(axis.values[runs].tolist())) > 1]
    cases = result.cases
    ends = _ends(result)
    titles = tuple(_title(result, cases[run : run + 1], apart, run, ends[run]) for run in shown)
    return Group(label, tag, tuple(shown), titles, " ".join(notes), tuple(runs))


def _ends(result: ResultFile) -> list[str]:
    """How each run ended and when, "" where it came to its end."""
    found = []
    for status, time in zip(result.status, result.status_time.tolist(), strict=True):
        when = f" at {quantity(time, 's')}" if np.isfinite(time) else ""
        found.append("" if status == OK else f"{status.replace('_', ' ')}{when}")
    return found


def _title(result: ResultFile, case: list[str], axes: list[Axis], run: int, end: str) -> str:
    name = ", ".join([*case, *(axis.text(run, _DIGITS) for axis in axes)])
    if not name and result.runs > 1:
        name = f"run {run}"
    return "\n".join(filter(None, [name, end]))


def foremost(peaks: Sequence[float]) -> list[int]:
    """Which of so many panels have the largest peaks, as many as there is room for, in their order."""
    return sorted(sorted(range(len(peaks)), key=lambda k: -peaks[k])[:MOST_PANELS])
