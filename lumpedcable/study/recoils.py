"""What ends that recoil come down to: how fast and how far, what the exact wave has, and remarks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import jax
import numpy as np

from lumpedcable.model.ends import Loaded
from lumpedcable.model.line import Line
from lumpedcable.model.seams import at_end
from lumpedcable.results.schema import END_SPEED, exact_name
from lumpedcable.scene import Scene
from lumpedcable.scene.outcomes import QUANTITIES
from lumpedcable.solve.observe import ARRIVAL_DROP, FAR, Recoil
from lumpedcable.status import Status
from lumpedcable.study.begins import begins_of, earliest, other_begins, source_of
from lumpedcable.study.compiled import Ready
from lumpedcable.study.endings import Ended
from lumpedcable.study.known_waves import exact_wave, still, tensions_of
from lumpedcable.study.outcome import EXACT, joined
from lumpedcable.study.plan import recoil_event, recoil_name
from lumpedcable.study.speeds import EXCESS, excess_words

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["recoiled"]

Numbers = dict[str, "NDArray[np.float64]"]
"""Numbers of an end by their names, each of shape (runs,)."""


@dataclass(frozen=True)
class _Broken:
    """An end that recoils, in every run.

    Attributes:
        ended: how the runs ended.
        index: number of the end among those that are watched.
        recoil: the end.
        line: its line, of all runs.
        strain: its strain at rest (-), shape (runs,).
        tension: its tension at rest (N), shape (runs,).
        begins: when its break begins (s), inf where it never does, shape (runs,).
    """

    ended: Ended
    index: int
    recoil: Recoil
    line: Line
    strain: NDArray[np.float64]
    tension: NDArray[np.float64]
    begins: NDArray[np.float64]


def recoiled(ended: Ended, index: int) -> tuple[Numbers, list[str]]:
    """Numbers of one recoiling end of every run, measured and exact, and remarks on them.

    `index` is the number of the end in the plan. `EXACT` says what the exact wave tells of it.
    """
    broken = _broken(ended, index)
    numbers = _measured(broken)
    peak = numbers[END_SPEED]
    waves = _waves(broken, peak)
    for name in EXACT if ended.contents.exact else ():
        values = [waves.get(k, {}).get(name, np.nan) for k in range(len(peak))]
        numbers[exact_name(name)] = np.array(values)
    return numbers, _words(broken, peak, waves)


def _broken(ended: Ended, index: int) -> _Broken:
    part, study = ended.part, ended.contents.laid.study
    recoil, lived = part.plan.recoils[index], len(part.runs)
    line = jax.tree.map(lambda x: np.asarray(x)[:lived], ended.ready.model.lines[recoil.line])
    strain = at_end(line, np.asarray(line.reference_strain, float), recoil.node)
    rest = ended.account.rests.get(recoil_name(recoil))
    if rest is None:
        tension = tensions_of(study, part, source_of(part.structure.scene, recoil.line), strain)
    else:
        strain, tension = rest.T
    begins = begins_of(part, ended.starts, recoil)
    return _Broken(ended, index, recoil, line, strain, tension, begins)


def _measured(broken: _Broken) -> Numbers:
    """What the runs have of an end; NaN where they did not get so far."""
    ended, index, begins = broken.ended, broken.index, broken.begins
    nan = np.full(len(begins), np.nan)
    numbers = dict.fromkeys(QUANTITIES, nan)
    # a run that ended before it broke goes on in numbers that are not summed up
    comes = np.isfinite(begins) & ~(ended.when < begins)
    numbers["break_start"] = np.where(comes, begins, nan)
    numbers["static_strain"] = np.where(ended.begun, broken.strain, nan)
    numbers["static_tension"] = np.where(ended.begun, broken.tension, nan)
    speed = ended.largest(f"speed {index}")
    # not where the run ended before, nor at the break itself: the start counts in any case, when an end
    # that breaks there has no speed yet
    breaks = np.isfinite(speed) & ~(ended.when <= begins)
    numbers[END_SPEED] = np.where(breaks, speed, nan)
    with np.errstate(over="ignore"):
        reach = np.sqrt(ended.largest(f"reach {index}"))
    numbers["reach"] = np.where(breaks, reach, nan)
    if ended.account.complete:
        numbers["front_arrival"] = _arrival(broken)
        moved = np.where((ended.status == Status.OK) & breaks, _displacement(broken), nan)
        numbers["end_displacement"] = moved
    return numbers


def _arrival(broken: _Broken) -> NDArray[np.float64]:
    """Time (s) from the break until its front is felt at the far end, NaN where it is not."""
    ended, watch = broken.ended, broken.ended.account.watches[broken.index]
    arrival, rest = np.asarray(watch.arrival, float), np.asarray(watch.rest, float)
    # a far end that lost tension before the break lost it to something else
    full = np.asarray(watch.loaded, float) >= (1.0 - ARRIVAL_DROP) * rest
    full &= ~(other_begins(ended.part, ended.starts, broken.recoil) < arrival)
    known = ended.begun & full & ~(arrival >= ended.when)
    felt = np.where(known, arrival, np.nan) - broken.begins
    # and so did one that lost it before anything can come from there
    soonest = np.maximum(earliest(ended.ready, broken.recoil)[: len(felt)], 0.0)
    return np.where(felt >= soonest, felt, np.nan)


def _displacement(broken: _Broken) -> NDArray[np.float64]:
    """How far the end is at last from where it broke (m)."""
    account, recoil = broken.ended.account, broken.recoil
    with np.errstate(over="ignore"):  # of a run that has blown up, which has no displacement
        moved = at_end(broken.line, account.displacement[recoil.line], recoil.node)
        return np.linalg.norm(moved - account.watches[broken.index].place, axis=1)


def _waves(broken: _Broken, peak: NDArray[np.float64]) -> dict[int, dict[str, float]]:
    """The exact waves by run, of those that have one and keep it or are suspect.

    Whoever keeps no exact numbers needs the waves of ends alone that are, with a `peak` speed (m/s),
    faster than any wave can make them.
    """
    ended, begins = broken.ended, broken.begins
    every = ended.contents.laid.scene.output.every
    known = still(ended.account, broken.index, begins, every) & np.isfinite(peak) & ended.begun
    # after an earlier break the line is no longer at rest under this tension
    known &= begins == np.min(list(ended.starts.values()), axis=0)
    if not ended.contents.exact:
        mass = np.asarray(broken.line.mass_along, float)
        with np.errstate(invalid="ignore"):
            known &= peak > (1.0 + EXCESS) * np.sqrt(broken.tension * broken.strain / mass)
    waves = {}
    for k in map(int, np.flatnonzero(known)):
        at = float(broken.tension[k]), float(begins[k])
        waves[k] = exact_wave(_scene(ended, k), broken.line, broken.recoil, k, *at)
    return waves


def _scene(ended: Ended, k: int) -> Scene:
    """The scene of a run."""
    return ended.contents.laid.study.runs[int(ended.part.runs[k])]


def _words(
    broken: _Broken, peak: NDArray[np.float64], waves: dict[int, dict[str, float]]
) -> list[str]:
    """Remarks on an end of each run: faster than its wave allows, or pulled along by a force."""
    ended, line, recoil = broken.ended, broken.line, broken.recoil
    structure = ended.part.structure
    said = [_pulled_words(ended.ready, structure.scene, recoil)] * len(peak)
    event = recoil_event(structure.layout, recoil)
    lengths = np.broadcast_to(np.asarray(line.segment_length, float), line.reference_strain.shape)
    length = at_end(line, lengths, recoil.node)
    for k, wave in waves.items():
        if ended.status[k] == Status.OK and wave:
            crossing = float(length[k] * broken.strain[k]) / wave[END_SPEED]  # of a segment by it
            takes = _scene(ended, k).events[event].time
            sudden = (event, takes) if takes < crossing else None
            ends = float(peak[k]), wave[END_SPEED], wave["allowance"]
            said[k] = joined(excess_words(recoil_name(recoil), *ends, sudden), said[k])
    return said


def _pulled_words(ready: Ready, scene: Scene, recoil: Recoil) -> str:
    """What is said where a force holds the other end of a broken piece, and takes it along; else ""."""
    far = FAR[recoil.node]
    end = ready.model.end(recoil.line, far)
    if not isinstance(end, Loaded) or end.force is None or end.release is not None:
        return ""
    key = f"lines.{source_of(scene, recoil.line)}.{'start' if far == 0 else 'end'}"
    return f"{key}.held goes on pulling at the broken piece: a place that held it would be fixed"
