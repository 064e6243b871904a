"""CSV of histories: every number against time, one row for each run and saved time."""

from __future__ import annotations

import csv
from pathlib import Path

from lumpedcable.export.parts import replacing
from lumpedcable.results import ResultFile

__all__ = ["write_csv"]


def write_csv(result: ResultFile, target: Path, run: int | None) -> list[Path]:
    """Write all histories of one run or of all.

    Columns: run, the swept numbers, time, then every history by its path in the file; units stand in
    brackets in the heading, numbers are SI with all the digits that they have.
    """
    histories = result.series.histories
    axes = result.axes
    head = ["run", *(_named(axis.key, axis.unit) for axis in axes), "time [s]"]
    head += [_named(path, unit) for path, (_, unit) in histories.items()]
    runs = range(result.runs) if run is None else [run]
    with (
        replacing(target, "CSV") as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        for number in runs:
            swept = [float(axis.values[number]) for axis in axes]
            columns = [result.series.read(path, number) for path in histories]
            for k, time in enumerate(result.time):
                row = [number, *swept, float(time), *(float(column[k]) for column in columns)]
                writer.writerow(row)
    return [target]


def _named(name: str, unit: str) -> str:
    return f"{name} [{unit or '-'}]"
