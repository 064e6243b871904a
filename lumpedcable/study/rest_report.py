"""What a person sees of a scene at rest: a table of its cables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console, JustifyMethod
from rich.text import Text

from lumpedcable.results import ResultFile, open_result
from lumpedcable.results.human import runs_named, scale
from lumpedcable.results.reader import OK
from lumpedcable.scene import Study
from lumpedcable.scene.bodies import ANGLES
from lumpedcable.status import remark_of
from lumpedcable.study.prescribed import MODELS
from lumpedcable.study.strength import UTILISATION, has_strength
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

__all__ = ["rest_table"]

# quantity -> (words over the column, unit)
HEADS = {
    "joint_length": ("length\nto joint", "m"),
    "joint_x": ("joint\nx", "m"),
    "joint_z": ("joint\nz", "m"),
    "length": ("length\nS", "m"),
    "sag": ("sag\nf", "m"),
    "start_tension": ("start\ntension", "N"),
    "end_tension": ("end\ntension", "N"),
    "horizontal_tension": ("horizontal\ntension", "N"),
}
# in the order in which a terminal too narrow for all goes without them
SPARE = ("joint_length", "length", "joint_z", "joint_x", "horizontal_tension", "end_tension", "sag",
         "start_tension")  # fmt: skip
SLACK = 1.1  # times as long as the exact, taut line: another line
MARKS = {"exact": "*", "straight": "+"}
STYLES = {"exact": "cyan", "straight": "dim"}

Numbers = Mapping[str, NDArray[np.float64]]


def rest_table(study: Study, target: Path) -> None:
    """One table a cable, one row a run: computed, exact, and by straight segments.

    A narrow terminal gets fewer columns.
    """
    console = console_of()
    with open_result(target) as result:
        if study.scene.title:
            console.print(Text(study.scene.title, "bold"))
        for cable in result.cables:
            numbers = result.rest(cable)
            models = [model for model in MODELS if f"{model}_sag" in numbers]
            if len(result.cables) > 1:
                console.print(Text(cable))
            table, shown = _fitting(console, study, result, numbers, models)
            table.hidden = models[len(shown) :]
            console.print(table)
            for note in _notes(numbers, models, shown, result.runs):
                console.print(Text(note, "dim"))
        for body in study.scene.settling:
            console.print(Text(body))
            console.print(_settled(study, result, body))
        if study.scene.measures:
            console.print(Text("measures"))
            console.print(_asked(study, result))
        said = list(enumerate(zip(result.status, result.status_message, strict=True)))
        print_told(console, ((k, why) for k, (state, why) in said if state != OK))
        remarks = ((k, remark_of(why)) for k, (_, why) in said)
        print_told(console, (one for one in remarks if one[1]), "with such a remark", "dim")
    console.print(f"written: {target}", soft_wrap=True)


def _fitting(
    console: Console, study: Study, result: ResultFile, numbers: Numbers, models: Sequence[str]
) -> tuple[WholeTable, Sequence[str]]:
    """The table with as many models beside the computed numbers as the console is wide enough for."""
    for count in range(len(models), 0, -1):
        table = _table(study, result, numbers, models[:count])
        if fits_on(console, table):
            return table, models[:count]
    return _table(study, result, numbers, ()), ()


def _table(study: Study, result: ResultFile, numbers: Numbers, models: Sequence[str]) -> WholeTable:
    table = new_table()
    place: dict[str, int] = {}  # of the column of a quantity

    def column(words: str, style: str = "", justify: JustifyMethod = "right") -> int:
        table.add_column(Text(words), justify=justify, style=style, vertical="bottom", no_wrap=True)
        return len(table.columns) - 1

    swept = [column(words, justify=side) for words, side in run_heads(study)][1:]
    columns: list[list[str]] = []
    for quantity, (words, unit) in HEADS.items():
        if quantity not in numbers:
            continue
        factor, shown = _unit(numbers[quantity], unit)
        place[quantity] = column(f"{words}\n({shown})")
        columns.append(_texts(numbers[quantity] * factor))
        for model in models if _compared(numbers, quantity) else ():
            told = numbers[f"{model}_{quantity}"]
            if _same(numbers, model, quantity):
                continue  # prescribed
            column(f"{model}{MARKS[model]}", STYLES[model])
            columns.append(_texts(told * factor))
    if has_strength(study.scene):
        column("utilisation\n(-)")
        columns.append(_texts(result.summary()["run"][UTILISATION]))
    table.add_column(Text("status"), vertical="bottom", no_wrap=True)
    table.spare = [*(place[name] for name in SPARE if name in place), *reversed(swept)]
    for run in range(min(result.runs, MOST_ROWS)):
        cells = [*run_cells(study, run), *(texts[run] for texts in columns)]
        table.add_row(*(Text(cell) for cell in (*cells, result.status[run].replace("_", " "))))
    return table


def _settled(study: Study, result: ResultFile, body: str) -> WholeTable:
    """Where a body that settles is at rest."""
    place, turn = (result.body(body, key)[:, 0] for key in ("position", "attitude"))
    heads = [f"{name}\n(m)" for name in "xyz"] + [f"{name}\n(deg)" for name in ANGLES]
    # rounding has no sign to show
    columns = [_texts(np.round(v, 9) + 0.0) for v in (*place.T, *np.degrees(turn).T)]
    return _rows(study, result, heads, columns)


def _asked(study: Study, result: ResultFile) -> WholeTable:
    """The numbers that the scene asks for, of the state of rest."""
    heads, columns, told = [], [], result.summary()["run"]
    for name, part in study.scene.measures.items():
        factor, unit = _unit(told[name], part.UNIT)
        heads.append(f"{name}\n({unit})")
        columns.append(_texts(told[name] * factor))
    return _rows(study, result, heads, columns)


def _rows(
    study: Study, result: ResultFile, heads: Sequence[str], columns: Sequence[Sequence[str]]
) -> WholeTable:
    """One row a run: what is swept, and columns under their heads."""
    table = new_table()
    every: list[tuple[str, JustifyMethod]] = [(words, "right") for words in heads]
    for words, side in run_heads(study) + every:
        table.add_column(Text(words), justify=side, vertical="bottom", no_wrap=True)
    for run in range(min(result.runs, MOST_ROWS)):
        cells = [*run_cells(study, run), *(texts[run] for texts in columns)]
        table.add_row(*map(Text, cells))
    return table


def _compared(numbers: Numbers, quantity: str) -> bool:
    """Whether models have something to say of a number: a joint's place only where it is not given."""
    if quantity == "joint_length":
        return False
    return not quantity.startswith("joint") or not _same(numbers, "exact", "joint_x")


def _same(numbers: Numbers, model: str, quantity: str) -> bool:
    told = numbers.get(f"{model}_{quantity}", np.nan)
    return np.allclose(told, numbers[quantity], rtol=1e-9, atol=0.0, equal_nan=True)


def _unit(values: NDArray[np.float64], unit: str) -> tuple[float, str]:
    """Factor and unit for a column: lengths in m, forces in what suits the largest."""
    finite = np.abs(values[np.isfinite(values)])
    return (1.0, unit) if unit == "m" or not finite.size else scale(float(finite.max()), unit)


def _texts(values: NDArray[np.float64]) -> list[str]:
    """A column: six digits of its largest value."""
    finite = np.abs(values[np.isfinite(values)])
    top = float(finite.max()) if finite.size else 0.0
    digits = 5 - int(np.floor(np.log10(top))) if top > 0.0 else 0
    form = f"{{:.{min(max(digits, 0), 6)}f}}"
    return [form.format(value) if np.isfinite(value) else "-" for value in values]


def _notes(numbers: Numbers, models: Sequence[str], shown: Sequence[str], runs: int) -> list[str]:
    notes = rows_shown(MOST_ROWS, runs)
    notes += [f"{MARKS[model]} {model}: {MODELS[model]}." for model in shown]
    notes += _slack(numbers)
    if "straight" in models:
        told = []
        for quantity, words in (("start_tension", "start tension"), ("sag", "sag")):
            error = numbers[f"straight_{quantity}"] / numbers[f"exact_{quantity}"] - 1.0
            if np.isfinite(error).any():
                low, high = 100.0 * np.nanmin(error), 100.0 * np.nanmax(error)
                told.append(f"{words} {low:+.2f} to {high:+.2f} %")
        if told:
            notes.append(f"Straight segments against exact: {', '.join(told)}.")
    return notes


def _slack(numbers: Numbers) -> list[str]:
    """A note on runs whose line is the slack one of the two that have the tension asked for.

    Stretch and mesh leave a line within per cents of the exact, taut one, and shorter; only near the
    least tension of all, where both meet, is the slack one less than a tenth longer.
    """
    longer = numbers["length"] > SLACK * numbers.get("exact_length", np.nan)
    if not np.any(longer):
        return []
    which = runs_named(np.flatnonzero(longer).tolist())
    return [
        f"{which}: this line is slack, and far longer than the taut one with the same tension, which is "
        "the exact one here: begin with a shorter length."
    ]
