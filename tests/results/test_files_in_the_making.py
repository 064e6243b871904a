"""A results file in the making is its writer's alone, until it has its name or is gone."""

import os
import sys
from pathlib import Path

import pytest

from lumpedcable.results import OutputError, ResultWriter, Variable, disk
from lumpedcable.results.errors import BusyError


@pytest.fixture
def small():
    return {
        "dims": {"run": 2, "time": 3},
        "variables": [Variable("energy/kinetic", ("run", "time"), "f8", "J")],
    }


@pytest.mark.skipif(sys.platform == "win32", reason="opened files keep their names there anyway")
@pytest.mark.parametrize("end", ["finish", "abandon"])
def test_a_temporary_name_is_its_writers_until_it_is_renamed(tmp_path, monkeypatch, small, end):
    # closed but not yet renamed it looks as a leftover does, but for its lock
    target = tmp_path / "study.h5"
    writer = ResultWriter(target, **small)
    names, tried = {"finish": (os, "replace"), "abandon": (Path, "unlink")}, []
    where, name = names[end]
    real = getattr(where, name)

    def between(*arguments, **more):
        monkeypatch.undo()
        with pytest.raises(BusyError, match="another run is writing it"):
            ResultWriter(target, **small)
        tried.append(name)
        return real(*arguments, **more)

    monkeypatch.setattr(where, name, between)
    getattr(writer, end)()
    assert tried == [name]
    assert [p.name for p in tmp_path.iterdir()] == (["study.h5"] if end == "finish" else [])


@pytest.mark.skipif(sys.platform == "win32", reason="opened files keep their names there")
def test_what_another_process_has_put_under_the_temporary_name_is_not_renamed(tmp_path, small):
    # as on a disk without locks, where it was taken for a leftover
    target = tmp_path / "study.h5"
    writer = ResultWriter(target, **small)
    writer.partial.unlink()
    writer.partial.write_text("half of another")
    with pytest.raises(BusyError, match="another run is writing it"):
        writer.finish()
    assert not target.exists()
    assert writer.partial.read_text() == "half of another"


def test_a_file_that_another_process_has_made_first_is_told(tmp_path, monkeypatch, small):
    target = tmp_path / "study.h5"
    prepare = disk.prepare

    def late(*arguments):
        prepare(*arguments)
        made.append(disk.create(tmp_path / "study.h5.partial"))

    made = []
    monkeypatch.setattr(disk, "prepare", late)
    with pytest.raises(BusyError, match="another run is writing it"):
        ResultWriter(target, **small)
    made.pop().close()
    monkeypatch.setattr(disk, "prepare", lambda *a: (prepare(*a), target.write_text("whole")))
    with pytest.raises(OutputError, match="it exists already"):
        ResultWriter(target, **small, overwrite=False)
    assert [p.name for p in tmp_path.iterdir()] == ["study.h5"]
