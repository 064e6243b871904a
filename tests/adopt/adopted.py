"""Texts of MoorDyn's input files as scenes, and what is told of them."""

import tomllib
from contextlib import chdir, contextmanager

import pytest

from lumpedcable.adopt.moordyn import read_moordyn
from lumpedcable.adopt.mooring import mooring_scene
from lumpedcable.scene import SceneError, load_study


def scene_of(folder, text):
    """The tables of the scene that a file becomes, which reads, and the remarks."""
    (folder / "mooring.txt").write_text(text, encoding="utf-8")
    toml, remarks = mooring_scene(read_moordyn(folder / "mooring.txt"), "a mooring")
    (folder / "mooring.toml").write_text(toml)
    load_study(folder / "mooring.toml")
    return tomllib.loads(toml), remarks


def tells(folder, text, line, words):
    """That a text is refused with such words at that line."""
    (folder / "mooring.txt").write_text(text)
    with pytest.raises(SceneError) as caught:
        read_moordyn(folder / "mooring.txt")
    found = [(fault.line, str(fault)) for fault in caught.value.faults]
    assert any(at == line and words in told for at, told in found), found


@contextmanager
def moordyn_at_rest(folder, coupled=()):
    """MoorDyn and its system of the file `mooring.txt` at rest, coupled points at places (m, flat)."""
    moordyn = pytest.importorskip("moordyn")
    with chdir(folder):
        system = moordyn.Create("mooring.txt")
        try:
            still = [0.0] * len(coupled)
            moordyn.Init(system, list(coupled), still)
            moordyn.Step(system, list(coupled), still, 0.0, 0.5)
            yield moordyn, system
        finally:
            moordyn.Close(system)
