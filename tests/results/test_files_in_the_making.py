"""A results file in the making is its writer's alone, until it has its name or is gone."""

import os
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from command_line import let_go, python

from lumpedcable.results import OutputError, ResultWriter, Variable, disk
from lumpedcable.results.errors import BusyError, first_line
from lumpedcable.results.target import is_draft, whole


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


@pytest.mark.parametrize("said", ["", "\n", "  \n\n"])
def test_an_error_that_says_nothing_is_told_by_its_kind(tmp_path, said):
    with (
        pytest.raises(OutputError, match=r"cannot write .*a\.h5: OSError$"),
        disk.reported(tmp_path / "a.h5"),
    ):
        raise OSError(said)
    assert first_line(TimeoutError(said)) == "TimeoutError"
    assert first_line(said, "nobody knows why") == "nobody knows why"


def test_of_an_error_of_many_lines_the_first_that_is_not_empty_is_told():
    assert first_line(ValueError("\n  one \ntwo\n")) == "one"


# --- files that appear whole ---------------------------------------------------------------------


def test_two_that_write_one_file_do_not_disturb_each_other(tmp_path):
    target = tmp_path / "a.json"
    with whole(target) as late, late.open("w") as file:
        file.write("half of it, ")
        file.flush()
        with whole(target) as early:
            early.write_text("all of the early one")
        assert target.read_text() == "all of the early one"
        file.write("and the other half")
    assert target.read_text() == "half of it, and the other half"
    assert list(tmp_path.iterdir()) == [target]


WRITE = """
import sys
from pathlib import Path
from lumpedcable.results.target import is_draft, whole
letter = sys.argv[1]
print("ready", flush=True)
sys.stdin.readline()
for _ in range(200):
    with whole(Path("a.txt")) as draft:
        draft.write_text(letter * 10000)
"""


def test_processes_may_write_one_file_at_once(tmp_path):
    with ExitStack() as ended:
        writers = [
            ended.enter_context(python("-c", WRITE, letter, cwd=tmp_path, stdin=subprocess.PIPE))
            for letter in "ABC"
        ]
        assert let_go(writers) == [""] * 3
    (file,) = tmp_path.iterdir()
    text = file.read_text()
    assert len(text) == 10000
    assert len(set(text)) == 1


@pytest.mark.parametrize("name", ["a.csv", ".csv", ".hidden.csv", "a.b[1].csv", "bare"])
def test_a_draft_is_hidden_and_ends_as_its_file(tmp_path, name):
    target = tmp_path / name
    with whole(target) as draft:
        assert draft.parent == tmp_path
        assert draft.suffix == target.suffix or not target.suffix
        assert draft.name.startswith(".")
        assert is_draft(draft.name, name)
        assert not is_draft(draft.name, f"x{name}")
        draft.write_text("x")
    assert not is_draft(name, name)
    assert list(tmp_path.iterdir()) == [target]


def test_what_a_link_leads_to_is_written_and_the_link_stays(tmp_path):
    (tmp_path / "there").mkdir()
    link, real = tmp_path / "a.txt", tmp_path / "there" / "b.txt"
    link.symlink_to(real)
    with whole(link) as draft:
        assert draft.parent == real.parent
        draft.write_text("x")
    assert link.is_symlink()
    assert real.read_text() == "x"
    assert list(real.parent.iterdir()) == [real]


def test_drafts_that_a_killed_process_has_left_are_cleared_in_the_end(tmp_path):
    target, other = tmp_path / "a.csv", tmp_path / "b.csv"
    left = []
    for path in (target, target, other):
        with whole(path) as draft:
            draft.write_text("x")
        draft.write_text("half")  # as if it had been killed there
        left.append(draft)
    day = 24 * 3600.0
    now = time.time()
    for draft, age in zip(left, [2 * day, day / 2, 2 * day], strict=True):
        os.utime(draft, (now - age, now - age))
    mine = tmp_path / ".a.mine.partial.csv"  # the user's own
    mine.write_text("mine")
    os.utime(mine, (now - 2 * day, now - 2 * day))
    with whole(target) as draft:
        draft.write_text("y")
    assert set(tmp_path.iterdir()) == {target, other, left[1], left[2], mine}
