"""The numbers that a run comes down to: how it ended, what recoiled how fast, whether energy closed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from lumpedcable.model.bodies import body_key
from lumpedcable.model.ends import Loaded, end_name
from lumpedcable.model.layout import Layout
from lumpedcable.model.seams import at_end
from lumpedcable.results.schema import END_SPEED, PEAK_TENSION, exact_name
from lumpedcable.scene import Scene
from lumpedcable.scene.outcomes import QUANTITIES, SUMMARIES
from lumpedcable.solve.observe import ARRIVAL_DROP, FAR, Recoil
from lumpedcable.status import MEANING, Status, advice_of
from lumpedcable.study.account import Account, balance, statuses
from lumpedcable.study.begins import begins_of, earliest, other_begins, source_of, starts_of
from lumpedcable.study.carried import measure_outcome, missed_extremes
from lumpedcable.study.compiled import Ready
from lumpedcable.study.known_waves import curve_of, exact_wave, still, tensions_of
from lumpedcable.study.plan import recoil_event, recoils_of
from lumpedcable.study.speeds import EXCESS, excess_words
from lumpedcable.study.strains import strained
from lumpedcable.study.strength import UTILISATION, has_strength, utilised

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.contents import Contents
    from lumpedcable.study.run import Part

__all__ = [
    "EXACT",
    "QUANTITIES",
    "SUMMARIES",
    "Outcome",
    "Table",
    "empty_table",
    "message_of",
    "outcomes_of",
    "recoil_name",
    "recoil_names",
    "summaries_of",
    "summarise",
]

EXACT = {
    "static_strain": ("1", "strain of a straight line under that tension", "no weight"),
    END_SPEED: (
        "m/s", "speed of the broken end in the exact wave", "instantaneous break, no drag, no weight"),
    "front_arrival": (
        "s", "time at which the exact wave front reaches the far end",
        "instantaneous break, no drag, no weight"),
}  # fmt: skip

# ends of a run of which all steps that were taken are right
SOUND = (Status.OK, Status.STILL_MOVING, Status.LENGTH_LOST)

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


def recoil_name(recoil: Recoil) -> str:
    """ "rope.end" for the end of rope."""
    return end_name(recoil.line, recoil.node)


def recoil_names(layout: Layout) -> list[str]:
    """Names of all recoiling ends of a layout."""
    return [recoil_name(recoil) for recoil in recoils_of(layout)]


def summaries_of(scene: Scene) -> dict[str, tuple[str, str]]:
    """Those of `SUMMARIES` that the runs of a scene have: utilisation where a line has a strength."""
    strong = has_strength(scene)
    return {name: told for name, told in SUMMARIES.items() if strong or name != UTILISATION}


def empty_table(contents: Contents, runs: int) -> Table:
    """The table of runs of which nothing is known."""
    table: Table = {"status": np.full(runs, int(Status.INTERRUPTED))}
    table["status_time"] = np.full(runs, np.nan)
    table["status_message"] = np.full(runs, "", object)
    table["summary/solver_steps"] = np.zeros(runs, int)
    names = [f"summary/{n}" for n in (*summaries_of(contents.scene), *contents.scene.measures)]
    for end in contents.ends:
        names += [f"summary/{end}/{name}" for name in QUANTITIES]
        if contents.exact:
            names += [f"summary/{end}/{exact_name(name)}" for name in EXACT]
    table |= {name: np.full(runs, np.nan) for name in names}
    for line in contents.peaked:
        table[f"lines/{line}/{PEAK_TENSION}"] = np.full((runs, contents.segments[line]), np.nan)
    if contents.energy:
        table["energy/residual"] = np.full((runs, contents.laid.count + 1), np.nan)
    return table


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
        return _joined(MEANING[status], remark)
    at = "" if not np.isfinite(when) else f" at {1e3 * when:.6g} ms"
    return f"{MEANING[status]}{at}; {advice_of(status, step_given)}"


def summarise(contents: Contents, part: Part, ready: Ready, account: Account, table: Table) -> None:
    """The numbers of every run of a part into their rows, whether or not it got to its end."""
    if account.reached < 0:
        return  # interrupted before it began
    lived, rows = len(part.runs), part.rows
    every = contents.laid.scene.output.every
    times = (np.arange(account.count + 1) * every).astype(float)
    converged = np.asarray(ready.converged)[:lived]
    status, when = statuses(account, converged, times)
    energy = balance(account, status, when, times)
    open_ = energy.opened.any(axis=1) & (status == Status.OK)
    status[open_] = Status.ENERGY_NOT_CLOSED
    when = np.where(open_, times[energy.opened.argmax(axis=1)], when)
    beyond = strained(contents, part, ready, account, curve_of)
    over = beyond.over(status, when, times)
    if over.any():
        status[over], when[over] = Status.STRAIN_EXCEEDED, times[beyond.first[over]]
        energy = balance(account, status, when, times)
    if not account.complete:
        cut = status == Status.OK
        status[cut], when[cut] = Status.INTERRUPTED, times[account.reached]
    gone = np.full(lived, np.nan)
    if part.plan.stop is not None and account.complete:
        moving = np.isnan(account.stopped) & (status == Status.OK)
        status[moving], when[moving] = Status.STILL_MOVING, times[-1]
        d = contents.laid.coordinates.dimensions
        moved = account.displacement[body_key(part.plan.stop)][:, :d]
        with np.errstate(over="ignore"):  # of a run that has blown up
            gone = np.linalg.norm(moved, axis=1)
    # a run that has stopped well stays as it is: a stop of one that went wrong came after that
    stops = ~np.isnan(account.stopped) & (status == Status.OK)
    table["status"][rows], table["status_time"][rows] = status, when
    begun = status != Status.STATICS_NOT_CONVERGED
    good = begun[:, None] & ~(times >= when[:, None])
    good[:, 0] = begun
    sound = np.isin(status, SOUND)
    numbers = {
        "solver_steps": np.full(lived, part.steps * account.count),
        "solver_step": np.full(lived, np.nan if part.plan.adaptive else every / part.steps),
        "energy_closure": energy.closure,
        "released_energy": energy.released,
        "static_imbalance": np.asarray(ready.imbalance, float)[:lived],
        "peak_tension": _largest(account.largest["tension"], good),
        "stop_time": np.where(stops, account.stopped, np.nan),
        "stop_distance": np.where(stops, gone, np.nan),
        "peak_kinetic_energy": _largest(account.largest["kinetic"], good),
    }
    measured = {n: np.where(good, history, np.nan) for n, history in account.measures.items()}
    for name, history in measured.items():
        numbers[name] = measure_outcome(contents.scene, name, history)
    missed = missed_extremes(contents.scene, measured, lived)
    used = utilised(contents.study, part, ready, account, good, sound, times)
    if has_strength(contents.scene):
        numbers[UTILISATION] = used.most
    for name, values in numbers.items():
        table[f"summary/{name}"][rows] = values
    for line in account.peaks.keys() & set(contents.peaked):
        kept = np.where(sound[:, None], account.peaks[line], np.nan)
        table[f"lines/{line}/{PEAK_TENSION}"][rows, : kept.shape[1]] = kept
    if contents.energy:
        table["energy/residual"][rows] = energy.residual
    for index, recoil in enumerate(part.plan.recoils):
        found, words = _recoil(contents, part, ready, account, recoil, index, status, when, good)
        for name, values in found.items():
            table[f"summary/{recoil_name(recoil)}/{name}"][rows] = values
        missed = [_joined(*both) for both in zip(missed, words, strict=True)]
    step_given = contents.scene.solver.step is not None
    said = [
        beyond.message(k, float(when[k]))
        if s == Status.STRAIN_EXCEEDED
        else message_of(Status(int(s)), float(when[k]), missed[k], step_given=step_given)
        for k, s in enumerate(status)
    ]
    for k in np.flatnonzero(status == Status.LINE_REVERSED):
        said[k] = _about(said[k], part.structure.scene, _reversed_line(ready, account, int(k)))
    both = zip(said, used.words, strict=True)
    table["status_message"][rows] = [_joined(*words) for words in both]


def _about(message: str, scene: Scene, name: str) -> str:
    """A message on a line, or a part of one, with its name and those of its keys."""
    source = source_of(scene, name)
    keys = {"materials.NAME": f"materials.{scene.lines[source].material}",
            "lines.NAME": f"lines.{source}", "the line reversed": f"{name} reversed"}  # fmt: skip
    for general, own in keys.items():
        message = message.replace(general, own, 1)
    return message


def _reversed_line(ready: Ready, account: Account, run: int) -> str:
    """The line of the model that reversed first in a run."""
    first = int(account.signs[Status.LINE_REVERSED][run].argmax())
    return sorted(ready.model.lines)[int(account.largest["reversed of"][run, first])]


def _joined(*words: str) -> str:
    return "; ".join(filter(None, words))


def _largest(history: NDArray[np.float64], good: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The largest value of each run up to where it went wrong, NaN where it never began."""
    known = np.max(np.where(good & np.isfinite(history), history, -np.inf), axis=1)
    return np.where(np.isfinite(known), known, np.nan)


def _recoil(
    contents: Contents, part: Part, ready: Ready, account: Account, recoil: Recoil, index: int,
    status: NDArray[np.int64], when: NDArray[np.float64], good: NDArray[np.bool_],
) -> tuple[dict[str, NDArray[np.float64]], list[str]]:  # fmt: skip
    """Numbers of one recoiling end of every run, measured and exact, and remarks on them."""
    lived, study = len(part.runs), contents.laid.study
    line = jax.tree.map(lambda x: np.asarray(x)[:lived], ready.model.lines[recoil.line])
    strain = at_end(line, np.asarray(line.reference_strain, float), recoil.node)
    source = source_of(part.structure.scene, recoil.line)
    tension = tensions_of(study, part, source, strain)
    starts = starts_of(study, part, account)
    begins = begins_of(part, starts, recoil)
    first = np.min(list(starts.values()), axis=0)
    nan = np.full(lived, np.nan)
    numbers = dict.fromkeys(QUANTITIES, nan)
    numbers["break_start"] = np.where(np.isfinite(begins), begins, nan)
    begun = status != Status.STATICS_NOT_CONVERGED
    numbers["static_strain"] = np.where(begun, strain, nan)
    numbers["static_tension"] = np.where(begun, tension, nan)
    numbers[END_SPEED] = _largest(account.largest[f"speed {index}"], good)
    breaks = np.isfinite(numbers[END_SPEED])  # not where the run ended before
    with np.errstate(over="ignore"):
        reach = np.sqrt(_largest(account.largest[f"reach {index}"], good))
    numbers["reach"] = np.where(breaks, reach, nan)
    if account.complete:
        watch = account.watches[index]
        arrival = np.asarray(watch.arrival, float)
        # a far end that lost tension before the break lost it to something else
        rest = np.asarray(watch.rest, float)
        full = np.asarray(watch.loaded, float) >= (1.0 - ARRIVAL_DROP) * rest
        full &= ~(other_begins(part, starts, recoil) < arrival)
        felt = np.where(begun & full & ~(arrival >= when), arrival, nan) - begins
        # and so did one that lost it before anything can come from there
        soonest = np.maximum(earliest(ready, recoil)[:lived], 0.0)
        numbers["front_arrival"] = np.where(felt >= soonest, felt, nan)
        with np.errstate(over="ignore"):  # of a run that has blown up, which has no displacement
            moved = at_end(line, account.displacement[recoil.line], recoil.node)
            move = np.linalg.norm(moved - watch.place, axis=1)
        numbers["end_displacement"] = np.where((status == Status.OK) & breaks, move, nan)
    # after an earlier break the line is no longer at rest under this tension
    known = still(account, index, begins, contents.laid.scene.output.every) & breaks & begun
    known &= begins == first
    peak, mass = numbers[END_SPEED], np.asarray(line.mass, float)
    if not contents.exact:
        with np.errstate(invalid="ignore"):
            known &= peak > (1.0 + EXCESS) * np.sqrt(tension * strain / mass)
    scenes = {int(k): study.runs[int(part.runs[k])] for k in np.flatnonzero(known)}
    waves = {
        k: exact_wave(scene, line, recoil, k, float(tension[k]), float(begins[k]))
        for k, scene in scenes.items()
    }
    for name in EXACT if contents.exact else ():
        values = [waves.get(k, {}).get(name, np.nan) for k in range(lived)]
        numbers[exact_name(name)] = np.array(values)
    said = [_pulled_words(ready, part.structure.scene, recoil)] * lived
    event = recoil_event(part.structure.layout, recoil)
    lengths = np.broadcast_to(np.asarray(line.segment_length, float), line.reference_strain.shape)
    length = at_end(line, lengths, recoil.node)
    for k, wave in waves.items():
        if status[k] == Status.OK and wave:
            crossing = float(length[k] * strain[k]) / wave[END_SPEED]  # of a segment by the wave
            sudden = event if scenes[k].events[event].time < crossing else None
            ends = float(peak[k]), wave[END_SPEED], wave["allowance"]
            said[k] = _joined(excess_words(recoil_name(recoil), *ends, sudden), said[k])
    return numbers, said


def _pulled_words(ready: Ready, scene: Scene, recoil: Recoil) -> str:
    """What is said where a force holds the other end of a broken piece, and takes it along; else ""."""
    far = FAR[recoil.node]
    end = ready.model.end(recoil.line, far)
    if not isinstance(end, Loaded) or end.force is None or end.release is not None:
        return ""
    key = f"lines.{source_of(scene, recoil.line)}.{'start' if far == 0 else 'end'}"
    return f"{key}.held goes on pulling at the broken piece: a place that held it would be fixed"
