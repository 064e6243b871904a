"""What the formats share: files that appear whole, and the lines of one run without padding."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lumpedcable.results import ResultError, ResultFile
from lumpedcable.results.target import keep_others, whole

__all__ = ["LineOfRun", "lines_of", "replacing"]

Array = NDArray[Any]


class LineOfRun(NamedTuple):
    """One line in one run.

    Attributes:
        name: its name.
        position: m, shape (time, node, 3).
        nodes: other fields of nodes by name, vectors (time, node, 3) or numbers (time, node).
        segments: fields of segments by name, (time, segment).
    """

    name: str
    position: Array
    nodes: dict[str, Array]
    segments: dict[str, Array]


def lines_of(result: ResultFile, run: int) -> list[LineOfRun]:
    """The lines of a run whose positions are stored, without the padding of shorter ones.

    Raises:
        ResultError: there is none, or the run never began.
    """
    found = []
    for name in result.lines:
        line = result.line(name)
        if not line.has("position"):
            continue
        count = line.node_count(run)
        position = line.position(run)[:, :count]
        if not np.isfinite(position).any():
            raise ResultError(
                f"{result.path}: run {run} has no positions to export: {result.reason(run)}"
            )
        nodes = {
            f: line.field(f, run)[:, :count] for f in ("velocity", "bending_moment") if line.has(f)
        }
        segments = {
            f: line.field(f, run)[:, : count - 1] for f in ("tension", "strain") if line.has(f)
        }
        found.append(LineOfRun(name, position, nodes, segments))
    if not found:
        raise ResultError(
            f"{result.path} holds no positions of lines, and so no positions to export: an ideal cable "
            'has none, and other lines need "position" in output.quantities and output.keep = "fields"; '
            "csv takes what else the file holds"
        )
    return found


@contextmanager
def replacing(target: Path, kind: str) -> Iterator[Path]:
    """A name to write to, as of `whole`.

    Raises:
        OutputError: a file of another kind (see `keep_others`) has that name.
    """
    keep_others(target, kind)
    with whole(target) as partial:
        yield partial
