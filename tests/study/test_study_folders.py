"""Folders of studies that somebody has changed, that lack a part, or whose disk is full."""

import json
import os
import subprocess
import textwrap
from contextlib import ExitStack
from pathlib import Path

import good_scenes
import pytest
from command_line import let_go, python, say

from lumpedcable.results import ResultError, StudyFolder, disk, errors
from lumpedcable.scene import load_study
from lumpedcable.study import shards
from lumpedcable.study.shards import Share, open_study, run_here

# 8 short runs of one structure
SMALL = good_scenes.short_runs(
    "2 ms", '{ from = "45 kN", to = "180 kN", count = 8 }', '\nkeep = "summaries"'
)
ROOT = Path(__file__).parents[2]
TEXT = "title = 'x'\n"


@pytest.fixture
def scene(tmp_path):
    return good_scenes.write(tmp_path, SMALL)


@pytest.fixture
def bare(tmp_path):
    """The folder of a study of six runs, two in a shard, of which none is there."""
    return StudyFolder.make(tmp_path / "s", TEXT, 6, 2, "1")


def nothing(done, total):
    pass


# --- folders in the making -----------------------------------------------------------------------

RACE = """
    import sys, time
    from pathlib import Path
    from lumpedcable.results import StudyFolder
    print("ready", flush=True)
    sys.stdin.readline()
    for k in range(40):
        StudyFolder.make(Path(f"s{k}"), "title = 'x'\\n" * 20, 6, 2, "1")
"""


def racer(folder):
    """A process that waits for a line and then makes folders; it does not outlive the block."""
    return python("-c", textwrap.dedent(RACE), cwd=folder, stdin=subprocess.PIPE)


def test_processes_may_make_a_folder_at_once(tmp_path):
    with ExitStack() as ended:
        racers = [ended.enter_context(racer(tmp_path)) for _ in range(4)]
        assert let_go(racers) == [""] * 4
        assert [one.returncode for one in racers] == [0] * 4
    for k in range(40):
        folder = StudyFolder.open(tmp_path / f"s{k}")
        assert sorted(p.name for p in folder.path.iterdir()) == [
            "shards",
            "study.json",
            "study.toml",
        ]


@pytest.mark.parametrize("place", [1, 2])
def test_a_process_that_dies_while_it_makes_a_folder_is_no_obstacle(tmp_path, monkeypatch, place):
    # killed before its first or its second file has its name: the draft stays
    real, placed = os.replace, []

    def killed(draft, path):
        placed.append(path)
        if len(placed) == place:
            raise SystemExit
        real(draft, path)

    monkeypatch.setattr(os, "replace", killed)
    monkeypatch.setattr(Path, "unlink", lambda path, missing_ok=False: None)
    with pytest.raises(SystemExit):
        StudyFolder.make(tmp_path / "s", TEXT, 6, 2, "1")
    monkeypatch.undo()
    assert len(list((tmp_path / "s").iterdir())) == 1 + place
    with pytest.raises(ResultError, match="is no study folder"):
        StudyFolder.open(tmp_path / "s")
    folder = StudyFolder.make(tmp_path / "s", TEXT, 6, 2, "1")
    assert folder == StudyFolder.open(tmp_path / "s")
    assert folder.missing() == [0, 1, 2]


@pytest.mark.parametrize("name", ["study.toml", "shards/mine.h5", "shards", "notes.txt"])
def test_what_is_no_study_in_the_making_is_kept(tmp_path, name):
    mine = tmp_path / "s" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    found = name.partition("/")[0]
    with pytest.raises(errors.OutputError, match=f"expected a new or empty folder, found {found}$"):
        StudyFolder.make(tmp_path / "s", TEXT, 6, 2, "1")
    assert mine.read_text() == "mine"
    assert [p for p in (tmp_path / "s").rglob("*") if p.is_file()] == [mine]


def test_of_two_studies_that_begin_at_once_one_is_told(tmp_path, monkeypatch):
    # another process makes the folder after this one has found it empty
    mkdir = Path.mkdir

    def late(path, *arguments, **more):
        monkeypatch.undo()
        StudyFolder.make(tmp_path / "s", "title = 'y'\n", 6, 2, "1")
        mkdir(path, *arguments, **more)

    monkeypatch.setattr(Path, "mkdir", late)
    with pytest.raises(errors.OutputError, match="it holds another study"):
        StudyFolder.make(tmp_path / "s", TEXT, 6, 2, "1")
    assert StudyFolder.open(tmp_path / "s").scene.read_text() == "title = 'y'\n"


# --- a full disk ---------------------------------------------------------------------------------


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is Linux's")
@pytest.mark.parametrize("at_once", [1, 2])
def test_a_full_disk_ends_a_study_and_keeps_what_is_finished(scene, tmp_path, monkeypatch, at_once):
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)
    folder, laid = open_study(load_study(scene), tmp_path / "s", 1)
    create, tried = disk.create, []

    def filling(path):
        file = create(path)
        tried.append(path)
        if len(tried) > 3:
            with open("/dev/full", "r+b", buffering=0) as full:
                os.dup2(full.fileno(), file.id.get_vfd_handle(), inheritable=False)
        return file

    monkeypatch.setattr(disk, "create", filling)
    with pytest.raises(errors.DiskError, match=r"cannot write .*\.partial: No space left"):
        run_here(folder, laid, Share(), nothing)
    assert len(tried) <= 3 + at_once
    # one that is under way beside it is interrupted
    missing = folder.missing()
    assert 5 <= len(missing) < 5 + at_once
    assert set(folder.begun()) <= set(missing[: at_once - 1])
    assert folder.failures() == {}
    monkeypatch.undo()
    assert run_here(folder, laid, Share(), nothing) == []
    assert folder.missing() == []


def test_a_reason_that_finds_no_room_is_told_in_one_line(bare, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(errors.DiskError, match=r"cannot write .*000001\.txt: No space left"):
        bare.note_failure(1, "no memory")
    assert list((bare.path / "shards").iterdir()) == []


# --- what somebody has changed -------------------------------------------------------------------


def test_a_reason_may_be_empty(scene, tmp_path):
    folder, _ = open_study(load_study(scene), tmp_path / "s", 2)
    folder.note_failure(1, "")
    folder.file(2).with_suffix(".txt").touch()
    said = say(tmp_path, "info", "s")
    assert said.code == 0
    assert said.out.count("failed: nobody knows why") == 2


@pytest.mark.slow
def test_what_is_there_has_not_failed(scene, tmp_path):
    # one process gave up on shard 1, another had room for it
    folder, laid = open_study(load_study(scene), tmp_path / "s", 4)
    folder.note_failure(0, "no memory")
    folder.note_failure(1, "no memory")
    assert set(folder.failures()) == {0, 1}
    note = folder.file(1).with_suffix(".txt")
    told = note.read_text()
    run_here(folder, laid, Share(), nothing)
    assert not note.exists()
    note.write_text(told)
    assert folder.failures() == {}
    assert "failed" not in say(tmp_path, "info", "s").out
    note.unlink()
    folder.note_failure(1, "no memory")
    assert not note.exists()


def test_what_is_computed_while_failures_are_read_has_not_failed(bare, monkeypatch):
    for shard in (0, 1):
        bare.note_failure(shard, "no memory")
    there = StudyFolder._there

    def late(folder, ending):
        found = there(folder, ending)
        if ending == ".h5":  # after the names of the reasons have been read
            folder.forget_failure(0)
        return found

    monkeypatch.setattr(StudyFolder, "_there", late)
    assert bare.failures() == {1: "no memory"}


def test_a_scene_that_is_changed_inside_the_folder_is_told(scene, tmp_path):
    folder, _ = open_study(load_study(scene), tmp_path / "s", 2)
    text = folder.scene.read_text()
    assert text.count("60.0") == 1
    folder.scene.write_text(text.replace("60.0", "61.0"))
    for command in (["info", "s"], ["study", scene, "-o", "s"]):
        said = say(tmp_path, *command)
        assert said.code == 2
        assert "study.toml: expected the scene that the study was begun with" in said.err
        assert said.err.count("\n") == 1
    folder.scene.unlink()
    with pytest.raises(ResultError, match=r"study\.toml: cannot be read: No such file"):
        StudyFolder.open(folder.path)
    folder.scene.write_text(text)
    assert say(tmp_path, "info", "s").code == 0


@pytest.mark.parametrize("name", ["runs", "shard"])
@pytest.mark.parametrize("value", [0, -1, 2.5, "2", None, True])
def test_a_manifest_of_no_runs_is_damaged(bare, name, value):
    path = bare.path / "study.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), name: value}))
    with pytest.raises(
        ResultError, match=f"study.json is damaged: {name}: expected a whole number"
    ):
        StudyFolder.open(bare.path)


def test_a_table_of_a_study_tells_of_a_damaged_shard(scene, tmp_path):
    folder, laid = open_study(load_study(scene), tmp_path / "s", 4)
    run_here(folder, laid, Share(), nothing)
    assert say(tmp_path, "export", "s", "--to", "csv", "-o", "s.csv").code == 0
    head, *rows = (tmp_path / "s.csv").read_text().splitlines()
    assert "summary/rope.end/reach [m]" in head.split(",")
    assert [row.split(",")[2] for row in rows] == ["ok"] * 8
    with folder.file(1).open("r+b") as file:
        file.truncate(3000)
    said = say(tmp_path, "export", "s", "--to", "csv", "-o", "s.csv")
    assert said.code == 2
    assert f"{folder.name(1)} is damaged" in said.err


def test_processes_that_begin_at_once_wait_for_the_file_that_shows_all(
    scene, tmp_path, monkeypatch
):
    # another process has begun to write it, and ends after a few tries
    study = load_study(scene)
    prepare, tries = disk.prepare, []

    def busy(target, partial, overwrite):
        tries.append(target.name)
        if tries.count("study.h5") <= 3:
            raise errors.BusyError(f"cannot write {target}: another run is writing it")
        prepare(target, partial, overwrite)

    monkeypatch.setattr(disk, "prepare", busy)
    monkeypatch.setattr(shards, "WAIT", 0.0)
    folder, _ = open_study(study, tmp_path / "s", 4)
    assert tries == ["study.h5"] * 4
    assert folder.view.exists()
    monkeypatch.setattr(shards, "TURNS", 2)
    tries.clear()
    with pytest.raises(errors.BusyError, match="another run is writing it"):
        open_study(study, tmp_path / "t", 4)


def refusing(monkeypatch, error):
    """Have the file that shows all refused from now on, and count how often that is tried."""
    prepare, tries = disk.prepare, []

    def refuse(target, partial, overwrite):
        if target.name == "study.h5":
            tries.append(target)
            raise error
        prepare(target, partial, overwrite)

    monkeypatch.setattr(disk, "prepare", refuse)
    return tries


@pytest.mark.parametrize("kind", [errors.OutputError, errors.DiskError])
def test_a_file_that_shows_all_and_cannot_be_written_is_told_at_once(
    scene, tmp_path, monkeypatch, kind
):
    study = load_study(scene)
    folder, laid = open_study(study, tmp_path / "s", 4)
    tries = refusing(monkeypatch, kind("cannot write study.h5: Permission denied"))
    with pytest.raises(kind, match="Permission denied"):  # before anything is computed
        open_study(study, tmp_path / "s", 4)
    assert len(tries) == 1
    tries.clear()
    # after all: the one that is there says that shards are missing
    with pytest.raises(kind, match="Permission denied"):
        run_here(folder, laid, Share(), nothing)
    assert len(tries) == 1
    assert folder.missing() == []
    # nothing else is lost
    monkeypatch.undo()
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 0
    assert "complete: 2 of 2 shards, 8 of 8 runs" in said.out


@pytest.mark.parametrize("kind", [errors.OutputError, errors.DiskError])
def test_a_complete_study_is_shown_where_nothing_may_be_written(scene, tmp_path, monkeypatch, kind):
    folder, laid = open_study(load_study(scene), tmp_path / "s", 4)
    run_here(folder, laid, Share(), nothing)
    tries = refusing(monkeypatch, kind("cannot write study.h5: Permission denied"))
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 0
    assert "complete: 2 of 2 shards, 8 of 8 runs" in said.out
    assert tries
    folder.view.write_text("damaged")
    with pytest.raises(kind, match="Permission denied"):
        open_study(load_study(scene), tmp_path / "s", 4)


def test_a_folder_without_the_file_that_shows_all_says_who_makes_it(scene, tmp_path):
    # as of a process that was killed as it began, or that somebody has deleted
    folder, laid = open_study(load_study(scene), tmp_path / "s", 4)
    run_here(folder, laid, Share(0, 2), nothing)
    folder.view.unlink()
    said = say(tmp_path, "info", "s")
    assert said.code == 0
    assert "1 of 2 shards, 4 of 8 runs" in said.out
    assert "study.h5  absent; lumpedcable study makes it" in said.out
    for command in (["export", "s", "--to", "csv"], ["plot", "s"]):
        said = say(tmp_path, *command)
        assert said.code == 2
        assert "no such file: s/study.h5; lumpedcable study makes it" in said.err
    assert say(tmp_path, "study", scene, "-o", "s").code == 0
    assert say(tmp_path, "export", "s", "--to", "csv").code == 0


def test_a_folder_whose_shards_were_deleted_goes_on(scene, tmp_path):
    folder, _ = open_study(load_study(scene), tmp_path / "s", 4)
    (folder.path / "shards").rmdir()
    assert (folder.missing(), folder.begun(), folder.failures()) == ([0, 1], [], {})
    said = say(tmp_path, "info", "s")
    assert said.code == 0
    assert "0 of 2 shards, 0 of 8 runs" in said.out
    folder.note_failure(1, "no memory")
    assert folder.failures() == {1: "no memory"}
    folder.forget_failure(1)
    (folder.path / "shards").rmdir()
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 0
    assert "complete: 2 of 2 shards, 8 of 8 runs" in said.out
