"""The command that takes over input files of other programs."""

from __future__ import annotations

import sys
from pathlib import Path

from lumpedcable.commands.console import Output, fail, told

__all__ = ["import_"]


def import_(file: Path, /, *, output: Output = None) -> None:
    """Write a scene from an input file of MoorDyn (either layout): lines, points, bed and water.

    What has no counterpart in a scene is told; rods that move freely are refused.

    Parameters
    ----------
    file
        Input file of MoorDyn.
    output
        Scene file (TOML) to write; the file's name with .toml in this folder if not given.
    """
    from lumpedcable.adopt.moordyn import read_moordyn
    from lumpedcable.adopt.mooring import mooring_scene
    from lumpedcable.results.disk import reported
    from lumpedcable.results.target import whole
    from lumpedcable.scene import SceneError, load_study
    from lumpedcable.scene.errors import Fault

    target = output or Path(f"{file.stem}.toml")
    with told():
        text, remarks = mooring_scene(read_moordyn(file), f"{file.stem}, from MoorDyn")
        if target.exists():
            fail(f"cannot write {target}: it is there already; name another file with -o")
        with reported(target), whole(target) as partial:
            partial.write_text(text, encoding="utf-8")
            try:
                load_study(partial)
            except SceneError as error:  # told of the file that it comes from
                faults = [Fault(str(file), None, f.key, f.message) for f in error.faults]
                raise SceneError(faults) from None
    for remark in remarks:
        print(f"{file}: {remark}", file=sys.stderr)
    print(target)
