"""What a person sees of a study: a progress bar while it runs, a table when it is done."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console, JustifyMethod
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.text import Text

from lumpedcable.results.human import scale
from lumpedcable.results.schema import partial_of
from lumpedcable.results.target import followed
from lumpedcable.scene import Study
from lumpedcable.status import Status, remark_of
from lumpedcable.study.compiling import heard
from lumpedcable.study.outcome import EXACT, Outcome
from lumpedcable.study.progress import now_and_then, preparing
from lumpedcable.study.run import run_study
from lumpedcable.study.strength import has_strength
from lumpedcable.study.tables import (
    MOST_ROWS,
    WholeTable,
    console_of,
    fits_on,
    new_table,
    print_told,
    rows_shown,
    run_cells,
    run_heads,
)
from lumpedcable.timings import Timings

__all__ = ["results_table", "run_with_progress"]

# quantity -> (words over the column, unit shown, factor to it, format)
HEADS = {
    "static_strain": ("strain", "-", 1.0, "{:.4f}"),
    "peak_end_speed": ("peak end\nspeed", "m/s", 1.0, "{:.2f}"),
    "end_displacement": ("end dis-\nplacement", "m", 1.0, "{:.3f}"),
    "front_arrival": ("far end\nfeels it", "ms", 1e3, "{:.2f}"),
}
PREPARING = "start state and programs, compiled the first time"
PEAK = "peak_tension"  # which no measure may be called
STOPS = {"stop_time": ("stops\nafter", "s"), "stop_distance": ("gone by\nthen", "m")}
BEGINS = {"break_start": ("breaks\nafter", "s", 1.0, "{:.4f}")}
# spaces between columns and what stands beside the measured values, from wide to narrow
LOOKS = ((1, ("references", "exact")), (0, ("references", "exact")), (0, ("exact",)), (0, ()))


def run_with_progress(
    study: Study,
    target: Path,
    stopped: Callable[[], bool] = lambda: False,
    timings: Timings | None = None,
) -> list[Outcome]:
    """`run_study` with a live bar where there is a terminal to show it, else a line now and then.

    `stopped` is asked after every piece whether somebody has interrupted it.
    """
    timings = timings or Timings()
    console = Console(stderr=True)
    title = study.scene.title or study.path.name
    with (
        heard(timings),
        preparing(title, console.is_terminal) as begun,
        Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("output times"),
            TimeRemainingColumn(),
            console=console,
            transient=True,  # the table takes its place
            disable=not console.is_terminal,
        ) as progress,
    ):
        tell = now_and_then(title, console.is_terminal)
        task = progress.add_task(f"{title}: {PREPARING}", total=None)

        def show(done: int, total: int) -> None:
            if stopped():
                raise KeyboardInterrupt
            if done:
                begun()
            words = title if done else f"{title}: {PREPARING}"
            progress.update(task, completed=done, total=total, description=words)
            tell(done, total)

        def say() -> None:
            words = f"{title}: goes on with {partial_of(followed(target))}"
            print(words, file=sys.stderr, flush=True)

        return run_study(study, target, show, timings, say)


def results_table(study: Study, target: Path, outcomes: Sequence[Outcome]) -> None:
    """One row a run and recoiling end: measured, the reference's value, the exact one.

    A narrow terminal gets less space between columns, then fewer of them.
    """
    console = console_of()
    ends = list(dict.fromkeys(end for o in outcomes for end in o.recoils))
    rows = len(outcomes) * max(len(ends), 1)
    known = _known(outcomes)
    table, beside = _fitting(console, study, outcomes, ends, known)
    table.hidden = _hidden(study, beside, known)
    if study.scene.title:
        console.print(Text(study.scene.title, "bold"))
    console.print(table)
    for note in _notes(study, ends, beside, rows):
        console.print(Text(note, "dim"))
    print_told(console, ((o.run, o.message) for o in outcomes if o.status is not Status.OK))
    said = ((o.run, remark_of(o.message)) for o in outcomes)
    print_told(console, (one for one in said if one[1]), "with such a remark", "dim")
    console.print(f"written: {target}", soft_wrap=True)


def _fitting(
    console: Console, study: Study, outcomes: Sequence[Outcome], ends: Sequence[str], known: bool
) -> tuple[WholeTable, Sequence[str]]:
    """The richest look that the console is wide enough for, and what stands beside the values.

    `known`: whether an exact value is.
    """
    looks = [(pad, tuple(w for w in words if known or w != "exact")) for pad, words in LOOKS]
    for padding, beside in looks[:-1]:
        table = _table(study, outcomes, ends, beside, padding)
        if fits_on(console, table):
            return table, beside
    padding, beside = looks[-1]
    return _table(study, outcomes, ends, beside, padding), beside


def _known(outcomes: Sequence[Outcome]) -> bool:
    """Whether an exact value is known of any run: not of a material that relaxes, for one."""
    exact = tuple(f"exact_{quantity}" for quantity in EXACT)
    ends = (numbers for outcome in outcomes for numbers in outcome.recoils.values())
    return any(np.isfinite(numbers.get(key, np.nan)) for numbers in ends for key in exact)


def _table(
    study: Study,
    outcomes: Sequence[Outcome],
    ends: Sequence[str],
    beside: Sequence[str],
    padding: int,
) -> WholeTable:
    """The table; what is named in `beside` stands right of the value that it belongs to.

    Where even the plainest look has no room, the numbers of a run are left out one by one, then the
    swept ones.
    """
    table = new_table(padding)
    numbers = []

    def column(words: str, unit: str = "", style: str = "", justify: JustifyMethod = "right"):
        head = f"{words}\n({unit})" if unit else words
        table.add_column(Text(head), justify=justify, style=style, vertical="bottom", no_wrap=True)
        return len(table.columns) - 1

    def referred(quantity: str) -> None:
        for name in _told(study, quantity) if "references" in beside else ():
            numbers.append(column(name, style="dim"))

    swept = [column(words, justify=side) for words, side in run_heads(study)][1:]
    if _several(study, ends):
        column("end", justify="left")
    for quantity, (words, unit, _, _) in _heads(study).items() if ends else ():
        numbers.append(column(words, unit))
        referred(quantity)
        if quantity in EXACT and "exact" in beside:
            numbers.append(column("exact*", style="cyan"))
    measured = _measured(study, outcomes)
    if not ends:  # nothing parts: what the lines bear is what is asked for
        measured = {PEAK: _scaled([o.peak_tension for o in outcomes], "N")} | measured
    for name, (_, unit) in measured.items():
        numbers.append(column("peak\ntension" if name == PEAK else name, unit))
        referred(name)
    for name, (words, unit) in STOPS.items() if study.scene.output.stop is not None else ():
        numbers.append(column(words, unit))
        referred(name)
    if has_strength(study.scene):
        numbers.append(column("utili-\nsation", "-"))
    closure = column("energy\nclosure", "%")
    column("status", justify="left")
    table.spare = [closure, *reversed(numbers), *reversed(swept)]
    rows = [(outcome, end) for outcome in outcomes for end in ends or [""]]
    for outcome, end in rows[:MOST_ROWS]:
        table.add_row(*_row(study, outcome, end, ends, beside, measured))
    return table


def _measured(study: Study, outcomes: Sequence[Outcome]) -> dict[str, tuple[float, str]]:
    """By measure: the unit of its column, larger than SI's where its numbers would be long, and the
    factor to it."""
    found = {}
    for name, part in study.scene.measures.items():
        found[name] = _scaled([o.measures.get(name, np.nan) for o in outcomes], part.UNIT)
    return found


def _scaled(values: Sequence[float], unit: str) -> tuple[float, str]:
    """Factor and unit in which numbers read well, those that are known."""
    size = np.abs(values)
    return scale(float(np.max(size, where=np.isfinite(size), initial=1.0)), unit)


def _several(study: Study, ends: Sequence[str]) -> bool:
    """Whether it must be told which end a row is of: where another could have broken, too."""
    return len(ends) > 1 or (len(ends) == 1 and len(study.scene.events) > 1)


def _heads(study: Study) -> dict[str, tuple[str, str, float, str]]:
    """The columns of an end that recoils: with when it breaks, where nobody knew before."""
    found = any(event.tension is not None for event in study.scene.events.values())
    return BEGINS | HEADS if found else HEADS


def _told(study: Study, quantity: str) -> list[str]:
    """The references that have a number for a quantity."""
    return [name for name, r in study.scene.references.items() if quantity in r.values]


def _row(
    study: Study,
    outcome: Outcome,
    end: str,
    ends: Sequence[str],
    beside: Sequence[str],
    measured: Mapping[str, tuple[float, str]],
) -> list[Text]:

    def referred(quantity: str, factor: float, form: str) -> list[str]:
        names = _told(study, quantity) if "references" in beside else ()
        values = (study.scene.references[name].values[quantity][outcome.run] for name in names)
        return [_cell(value, factor, form) for value in values]

    cells = run_cells(study, outcome.run)
    if _several(study, ends):
        cells.append(end)
    numbers = outcome.recoils.get(end, {})
    for quantity, (_, _, factor, form) in _heads(study).items() if ends else ():
        cells.append(_cell(numbers.get(quantity), factor, form))
        cells += referred(quantity, factor, "{:.4g}")
        if quantity in EXACT and "exact" in beside:
            cells.append(_cell(numbers.get(f"exact_{quantity}"), factor, form))
    told = {PEAK: outcome.peak_tension} | dict(outcome.measures)
    for name, (factor, _) in measured.items():
        cells.append(_cell(told.get(name), factor, "{:.3f}"))
        cells += referred(name, factor, "{:.3f}")
    for name in STOPS if study.scene.output.stop is not None else ():
        cells.append(_cell(getattr(outcome, name), 1.0, "{:.3f}"))
        cells += referred(name, 1.0, "{:.3f}")
    if has_strength(study.scene):
        cells.append(_cell(outcome.utilisation, 1.0, "{:.3f}"))
    cells.append(_cell(outcome.energy_closure, 100.0, "{:.3f}"))
    cells.append(outcome.status.name.lower().replace("_", " "))
    return [Text(cell) for cell in cells]


def _cell(value: float | None, factor: float, form: str) -> str:
    return form.format(value * factor) if value is not None and np.isfinite(value) else "-"


def _hidden(study: Study, beside: Sequence[str], known: bool) -> list[str]:
    """What stands beside the values where there is room for it, in words."""
    hidden = ["exact values"] if known and "exact" not in beside else []
    if study.scene.references and "references" not in beside:
        hidden.append("references")
    return hidden


def _notes(study: Study, ends: Sequence[str], beside: Sequence[str], rows: int) -> list[str]:
    notes = rows_shown(MOST_ROWS, rows)
    if ends and "exact" in beside:
        notes.append(
            "* exact: a straight line without drag, damping or weight, broken instantaneously; drag and "
            "a slower break lower the speed and delay the arrival (1 % of the tension gone), damping "
            "lowers the speed and spreads the front out."
        )
    for name, reference in study.scene.references.items() if "references" in beside else ():
        note = f" {reference.note}." if reference.note else ""
        changed = " These numbers belong to the scene without --set." if study.overrides else ""
        notes.append(f"{name}: {reference.source}.{note}{changed}")
    return notes
