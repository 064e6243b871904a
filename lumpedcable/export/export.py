"""One call for every format, with the checks that they share."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from lumpedcable.export.gltf import write_gltf
from lumpedcable.export.moordyn import write_moordyn
from lumpedcable.export.spreadsheet import write_csv
from lumpedcable.export.vtkhdf import write_vtkhdf
from lumpedcable.results import OutputError, ResultFile
from lumpedcable.results.disk import reported
from lumpedcable.results.errors import did_you_mean
from lumpedcable.results.sound import SoundFile

__all__ = ["FORMATS", "export_result"]

Write = Callable[[ResultFile, Path, int | None], list[Path]]


class Format(NamedTuple):
    """What a format is called, how its files' names may end (the first is given), and what writes it."""

    called: str
    endings: tuple[str, ...]
    write: Write


FORMATS = {
    "vtkhdf": Format("VTKHDF", (".vtkhdf", ".hdf"), write_vtkhdf),
    "gltf": Format("binary glTF", (".glb",), write_gltf),
    "csv": Format("text with commas", (".csv",), write_csv),
    "moordyn": Format("MoorDyn's tables", (".out",), write_moordyn),
}

ELSE = {".vtk", ".vtu", ".gltf", ".xlsx", ".h5"}  # endings of what none of them is


def export_result(
    path: str | Path, kind: str, target: str | Path | None = None, run: int | None = None
) -> list[Path]:
    """Write a results file in another format, each run until it went wrong; one that stops rests then.

    Args:
        path: the results file, finished or not.
        kind: a key of `FORMATS`.
        target: the file to write; the results' name with the format's own end if not given.
        run: which run, from 0. CSV takes all runs where none is given, the others the first.

    Returns:
        The files made.

    Raises:
        ResultError: the file cannot be read, has no such run, or lacks what the format needs.
        OutputError: no such format, a file name of another one, or it cannot be written there.
    """
    if kind not in FORMATS:
        known = ", ".join(FORMATS)
        raise OutputError(
            f"expected a format, one of {known}, found {kind!r}{did_you_mean(kind, FORMATS)}"
        )
    called, endings, write = FORMATS[kind]
    others = ELSE.union(*(one.endings for one in FORMATS.values())) - set(endings)
    with SoundFile.open(path, stops=False) as result:
        if run is not None:
            result.hold(run)
        stem = Path(result.path.name.removesuffix(".partial")).stem
        goal = Path(target) if target is not None else result.path.with_name(stem + endings[0])
        if goal.is_dir():
            raise OutputError(f"expected a file name, found the folder {goal}")
        if goal.exists() and os.path.samefile(goal, result.path):
            raise OutputError(f"expected another file than the results, found {goal}")
        if goal.suffix.lower() in others:  # readers go by it
            raise OutputError(f"expected a name that ends in {endings[0]} ({called}), found {goal}")
        with reported(goal):
            goal.parent.mkdir(parents=True, exist_ok=True)
            return write(result, goal, run)
