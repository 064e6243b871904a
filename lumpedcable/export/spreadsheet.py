"""CSV: every number against time, a row for each run and saved time; or what sums up each run."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from lumpedcable.export.parts import replacing
from lumpedcable.results import ResultFile

__all__ = ["write_csv"]

BLOCK = 4096  # runs whose numbers are read at once


def write_csv(result: ResultFile, target: Path, run: int | None) -> list[Path]:
    """Write all histories of one run or of all; without histories the numbers that sum each up.

    Columns: run, case (its name, where a sweep has cases with names), the swept numbers, time, then
    every history by its path in the file, and what bodies do by component: "bodies/ship/position/x",
    "bodies/ship/attitude/roll". Of a file without histories: run, case, the swept numbers, status, then
    every number by its path. Units stand in brackets in the heading; numbers are SI with all the digits
    that they have.
    """
    # first of all, since it tells of a shard that is damaged, which else reads as not written
    status = result.status
    followed = {**result.series.histories, **result.series.motions}
    histories = {path: unit for path, (_, unit) in followed.items()}
    runs = range(result.runs) if run is None else range(run, run + 1)
    if histories:
        columns, rows = {"time": "s", **histories}, _in_time(result, histories, runs)
        heads = _named(columns)
    else:
        numbers = result.series.numbers
        heads, rows = ["status", *_named(numbers)], _summed_up(result, numbers, status, runs)
    with (
        replacing(target, "CSV") as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.writer(file, lineterminator="\n")
        case = ["case"] if result.cases else []
        swept = _named({axis.key: axis.unit for axis in result.axes})
        writer.writerow(["run", *case, *swept, *heads])
        writer.writerows(rows)
    return [target]


def _in_time(result: ResultFile, histories: Iterable[str], runs: range) -> Iterator[list[Any]]:
    axes, cases = result.axes, result.cases
    for number in runs:
        swept = [*cases[number : number + 1], *(float(axis.values[number]) for axis in axes)]
        columns = [result.series.read(path, number) for path in histories]
        for k, time in enumerate(result.time):
            yield [number, *swept, float(time), *(float(column[k]) for column in columns)]


def _summed_up(
    result: ResultFile, numbers: Iterable[str], status: list[str], runs: range
) -> Iterator[list[Any]]:
    axes, cases = result.axes, result.cases
    for first in range(runs.start, runs.stop, BLOCK):
        block = range(first, min(first + BLOCK, runs.stop))
        some = slice(block.start, block.stop)
        columns = [cases[some]] if cases else []
        columns += [axis.values[some].tolist() for axis in axes]
        columns += [status[some]]
        columns += [result.series.read(path, some).tolist() for path in numbers]
        for number, *row in zip(block, *columns, strict=True):
            yield [number, *row]


def _named(units: Mapping[str, str]) -> list[str]:
    return [f"{name} [{unit or '-'}]" for name, unit in units.items()]
