"""The numbers that a run comes down to: how it ended, what recoiled how fast, whether energy closed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumpedcable.model.bodies import body_key
from lumpedcable.results.human import quantity
from lumpedcable.results.schema import PEAK_TENSION, exact_name
from lumpedcable.scene import Scene
from lumpedcable.scene.materials import InextensibleMaterial
from lumpedcable.scene.outcomes import QUANTITIES
from lumpedcable.status import CALMED, MEANING, TURNED_OVER, UNFOLDED, Status
from lumpedcable.study.account import Account
from lumpedcable.study.begins import source_of
from lumpedcable.study.carried import (
    measure_names,
    measure_outcomes,
    missed_extremes,
    never_counted,
)
from lumpedcable.study.compiled import Ready
from lumpedcable.study.endings import Ended, ended_of
from lumpedcable.study.outcome import EXACT, Table, joined, message_of, summaries_of
from lumpedcable.study.plan import recoil_name
from lumpedcable.study.pushed import pushed
from lumpedcable.study.recoils import recoiled
from lumpedcable.study.strength import UTILISATION, has_strength, utilised
from lumpedcable.study.sunk import sunk

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lumpedcable.study.contents import Contents
    from lumpedcable.study.part import Part

__all__ = ["empty_table", "summarise"]


def empty_table(contents: Contents, runs: int) -> Table:
    """The table of runs of which nothing is known."""
    table: Table = {"status": np.full(runs, int(Status.INTERRUPTED))}
    table["status_time"] = np.full(runs, np.nan)
    table["status_message"] = np.full(runs, "", object)
    table["summary/solver_steps"] = np.zeros(runs, int)
    own = (*summaries_of(contents.scene), *measure_names(contents.scene))
    names = [f"summary/{n}" for n in own]
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


def summarise(contents: Contents, part: Part, ready: Ready, account: Account, table: Table) -> None:
    """The numbers of every run of a part into their rows, whether or not it got to its end."""
    if account.reached < 0:
        return  # interrupted before it began
    ended, rows = ended_of(contents, part, ready, account), part.rows
    measured = {n: np.where(ended.good, own, np.nan) for n, own in account.measures.items()}
    used = utilised(contents.study, part, ready, account, ended.good, ended.sound, ended.times)
    numbers = _numbers(ended)
    for name, own in measured.items():
        numbers |= measure_outcomes(contents.scene, name, own)
    if has_strength(contents.scene):
        numbers[UTILISATION] = used.most
    table["status"][rows], table["status_time"][rows] = ended.status, ended.when
    for name, values in numbers.items():
        table[f"summary/{name}"][rows] = values
    for line in account.peaks.keys() & set(contents.peaked):
        kept = np.where(ended.sound[:, None], account.peaks[line], np.nan)
        table[f"lines/{line}/{PEAK_TENSION}"][rows, : kept.shape[1]] = kept
    if contents.energy:
        table["energy/residual"][rows] = ended.energy.residual
    lived = len(part.runs)
    told = (
        missed_extremes(contents.scene, measured, lived),
        never_counted(contents.scene, measured, lived),
        sunk(ended),
        pushed(ended),
    )
    remarks = [joined(*words) for words in zip(*told, strict=True)]
    for index, recoil in enumerate(part.plan.recoils):
        found, words = recoiled(ended, index)
        for name, values in found.items():
            table[f"summary/{recoil_name(recoil)}/{name}"][rows] = values
        remarks = [joined(*both) for both in zip(remarks, words, strict=True)]
    both = zip(_messages(ended, remarks), used.words, strict=True)
    table["status_message"][rows] = [joined(*words) for words in both]


def _numbers(ended: Ended) -> dict[str, NDArray[np.float64]]:
    """Those numbers of every run that any scene has, but for the utilisation."""
    part, account, lived = ended.part, ended.account, len(ended.part.runs)
    # a run that has stopped well stays as it is: a stop of one that went wrong came after that
    stops = ~np.isnan(account.stopped) & (ended.status == Status.OK)
    steps = np.full(lived, part.steps * account.count)
    if np.any(stops):
        upto = account.stopped[stops] / float(part.numbers.every) * part.steps
        steps[stops] = np.minimum(np.ceil(upto * (1.0 - 1e-9)), steps[stops])
    return {
        "solver_steps": steps,
        "solver_step": np.full(lived, ended.step),
        "energy_closure": ended.energy.closure,
        "released_energy": ended.energy.released,
        "static_imbalance": np.asarray(ended.ready.imbalance, float)[:lived],
        "peak_tension": ended.largest("tension"),
        "stop_time": np.where(stops, account.stopped, np.nan),
        "stop_distance": np.where(stops, _gone(ended), np.nan),
        "peak_kinetic_energy": ended.largest("kinetic"),
    }


def _gone(ended: Ended) -> NDArray[np.float64]:
    """How far the body whose rest ends a run has gone (m), NaN where there is none."""
    stop, account = ended.part.plan.stop, ended.account
    if stop is None or not account.complete:
        return np.full(len(ended.part.runs), np.nan)
    moved = account.displacement[body_key(stop)][:, : ended.contents.laid.coordinates.dimensions]
    with np.errstate(over="ignore"):  # of a run that has blown up
        return np.linalg.norm(moved, axis=1)


def _messages(ended: Ended, remarks: list[str]) -> list[str]:
    """What is said of each run; its remark where it went well."""
    step_given = ended.contents.scene.solver.step is not None
    said = []
    for k, (number, time) in enumerate(zip(ended.status, ended.when, strict=True)):
        status, when = Status(int(number)), float(time)
        if status is Status.STRAIN_EXCEEDED:
            said.append(ended.beyond.message(k, when))
            continue
        message = message_of(status, when, remarks[k], step_given=step_given)
        if status is Status.STATICS_NOT_CONVERGED and ended.ready.overturned[k]:
            message = f"{MEANING[status]}: what was found is {TURNED_OVER}; {UNFOLDED}"
        if status is Status.STEP_BOUND_BROKEN and ended.overstepped[k]:
            message = _too_long(ended, k)
        if status is Status.LINE_REVERSED:
            message = _about(message, ended.part.structure.scene, ended.reversed_line(k))
        said.append(message)
    return said


def _too_long(ended: Ended, run: int) -> str:
    """What is said of a run whose step is too long from the start."""
    step, stable = (quantity(float(x), "s", 3) for x in (ended.step, ended.bound[run]))
    key = "solver.courant" if ended.contents.scene.solver.step is None else "solver.step"
    return f"the step is too long: {step}; up to {stable} is stable at any strain; lower {key}"


def _about(message: str, scene: Scene, name: str) -> str:
    """A message on a line that reversed, or a part of one, with its name and what it could be given."""
    source = source_of(scene, name)
    line = scene.lines[source]
    material = scene.materials[line.material]
    calming = {f"lines.{source}.drag": line.drag}
    if not isinstance(material, InextensibleMaterial):
        calming = {f"materials.{line.material}.damping": material.damping, **calming}
    missing = [key for key, own in calming.items() if own is None]
    calmed = ", or give the line " + " and ".join(missing) if missing else ""
    if line.drag is None and scene.water is None and scene.air is None:
        calmed += " in water or air"
    message = message.replace("the line reversed", f"{name} reversed", 1)
    return message.replace(CALMED, calmed, 1)
