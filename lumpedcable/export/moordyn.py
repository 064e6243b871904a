"""Text files as MoorDyn writes them, for tools that read those.

One table of channels, NAME.out, and one for each line, NAME_LineN.out, lines numbered from 1 in the
order of the file: a row of names, a row of units, then numbers between tabs. End A, node 0, is the
line's start, the anchor; end B its end, the fairlead. Source: MoorDyn documentation, "Outputs"
(moordyn.readthedocs.io): channels AnchTenN and FairTenN, line files with NodeIpx, NodeIpy, NodeIpz and
SegITe.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumpedcable.export.parts import LineOfRun, lines_of, replacing
from lumpedcable.results import ResultFile
from lumpedcable.results.target import keep_others

__all__ = ["write_moordyn"]


def write_moordyn(result: ResultFile, target: Path, run: int | None) -> list[Path]:
    """Write one run: end tensions (N), and places (m) and tensions (N) along each line."""
    number = run or 0
    lines = lines_of(result, number)
    channels: list[tuple[str, ArrayLike]] = []
    for k, line in enumerate(lines, 1):
        data = result.line(line.name)
        for channel, field, segment in (
            (f"FairTen{k}", "end_tension", -1),
            (f"AnchTen{k}", "start_tension", 0),
        ):
            if data.has(field):
                channels.append((channel, data.field(field, number)))
            elif "tension" in line.segments:
                channels.append((channel, line.segments["tension"][:, segment]))
    own = target.name.removesuffix(".out")
    others = [target.with_name(f"{own}_Line{k}.out") for k in range(1, len(lines) + 1)]
    for path in others:  # before the first is written
        keep_others(path, "MoorDyn")
    made = [_table(target, result.time, [(name, "(N)", values) for name, values in channels])]
    made += [
        _table(path, result.field_time, _along(line))
        for path, line in zip(others, lines, strict=True)
    ]
    return made


def _along(line: LineOfRun) -> list[tuple[str, str, ArrayLike]]:
    columns: list[tuple[str, str, ArrayLike]] = [
        (f"Node{i}p{'xyz'[c]}", "(m)", line.position[:, i, c])
        for i in range(line.position.shape[1])
        for c in range(3)
    ]
    tension = line.segments.get("tension")
    if tension is not None:
        columns += [(f"Seg{j + 1}Te", "(N)", tension[:, j]) for j in range(tension.shape[1])]
    return columns


def _table(
    target: Path, time: NDArray[np.float64], columns: Sequence[tuple[str, str, ArrayLike]]
) -> Path:
    table = np.column_stack([time, *(values for _, _, values in columns)])
    with replacing(target, "MoorDyn") as partial, partial.open("w", encoding="utf-8") as file:
        file.write("\t".join(["Time", *(name for name, _, _ in columns)]) + "\n")
        file.write("\t".join(["(s)", *(unit for _, unit, _ in columns)]) + "\n")
        np.savetxt(file, table, fmt="%.8g", delimiter="\t")
    return target
