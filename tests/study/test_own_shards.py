"""Shards of one study alone are shown together: of one program, under their names, in its folder."""

import json
import shutil

import good_scenes
import pytest
from command_line import say

from lumpedcable.results import ResultError, StudyFolder, errors
from lumpedcable.scene import load_study
from lumpedcable.study import shards
from lumpedcable.study.shards import Share, open_study, run_here

# 6 short runs of one structure
SMALL = good_scenes.short_runs(
    "2 ms", '{ from = "45 kN", to = "180 kN", count = 6 }', '\nkeep = "summaries"'
)


def nothing(done, total):
    pass


@pytest.fixture
def scene(tmp_path):
    return good_scenes.write(tmp_path, SMALL)


@pytest.fixture
def begun(scene, tmp_path):
    """A study of three shards of two runs each, of which the first is there."""
    folder, laid = open_study(load_study(scene), tmp_path / "s", 2)
    run_here(folder, laid, Share(0, 3), nothing)
    assert folder.missing() == [1, 2]
    return folder, laid


# --- one program ---------------------------------------------------------------------------------


def other_sources(monkeypatch):
    monkeypatch.setattr(shards, "SOURCES", "0" * 32)
    return "sources 000000000000"


def other_library(monkeypatch):
    known = shards.versions()
    monkeypatch.setattr(shards, "versions", lambda: known | {"jax": "0.0.1"})
    return "jax 0.0.1"


def other_version(monkeypatch):
    monkeypatch.setattr(shards, "__version__", "99.0")
    return "lumpedcable 99.0"


OTHERS = [other_sources, other_library, other_version]


@pytest.mark.parametrize("other", OTHERS)
def test_shards_of_another_program_are_not_mixed_in(begun, scene, tmp_path, monkeypatch, other):
    words = other(monkeypatch)
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 2
    assert said.err.count("\n") == 1
    assert "cannot go on in s: it was begun with" in said.err
    assert f"this is {words}, whose" in said.err
    assert "give another folder" in said.err
    assert begun[0].missing() == [1, 2]
    # what is there can be read by any program
    for command in (["info", "s"], ["export", "s", "--to", "csv", "-o", "s.csv"]):
        assert say(tmp_path, *command).code == 0


def test_a_worker_of_another_program_computes_nothing(begun, monkeypatch):
    cluster = pytest.importorskip("lumpedcable.study.cluster")
    folder, _ = begun
    with monkeypatch.context() as patch:
        other_library(patch)
        with pytest.raises(errors.OutputError, match=r"this is jax 0\.0\.1"):
            cluster._shard(str(folder.path), 1)
    assert cluster._shard(str(folder.path), 1) is True


def test_a_folder_that_says_nothing_of_its_program_goes_by_the_version(
    begun, scene, tmp_path, monkeypatch
):
    path = begun[0].path / "study.json"
    told = json.loads(path.read_text())
    del told["program"]
    path.write_text(json.dumps(told))
    with monkeypatch.context() as patch:
        other_version(patch)
        assert "this is lumpedcable 99.0" in say(tmp_path, "study", scene, "-o", "s").err
    other_sources(monkeypatch)
    assert say(tmp_path, "study", scene, "-o", "s").code == 0
    assert begun[0].missing() == []


def test_what_a_later_version_says_of_a_study_is_left_out(begun, tmp_path):
    path = begun[0].path / "study.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "weather": "fine"}))
    assert StudyFolder.open(begun[0].path) == begun[0]
    path.write_text(json.dumps({**json.loads(path.read_text()), "program": "mine"}))
    with pytest.raises(ResultError, match=r"damaged: program: expected a table, found \"mine\""):
        StudyFolder.open(begun[0].path)
    path.write_text("[1]")
    with pytest.raises(ResultError, match=r"study\.json is damaged"):
        StudyFolder.open(begun[0].path)


def test_the_same_study_of_two_programs_has_shards_of_other_names(scene, tmp_path, monkeypatch):
    # a reference to a file that is absent is looked for in the folder that the process is in, too
    study = load_study(scene)
    one, _ = open_study(study, tmp_path / "one", 2)
    same, _ = open_study(study, tmp_path / "same", 2)
    other_library(monkeypatch)
    other, _ = open_study(study, tmp_path / "other", 2)
    assert one.name(0) == same.name(0) != other.name(0)


# --- under its name ------------------------------------------------------------------------------


def test_a_shard_under_the_name_of_another_is_named(begun, scene, tmp_path):
    folder, laid = begun
    shutil.copy(folder.file(0), folder.file(2))
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 2
    assert said.err == (
        f"s/{folder.name(2)} is damaged: expected runs 4 to 5, found 0 to 1; once it is deleted, "
        "lumpedcable study computes it again\n"
    )
    folder.file(2).unlink()
    assert run_here(folder, laid, Share(), nothing) == []
    assert folder.missing() == []


# --- in its folder -------------------------------------------------------------------------------


@pytest.mark.parametrize("at_once", [1, 2])
@pytest.mark.parametrize("when", ["between two shards", "in a shard"])
def test_a_folder_that_is_moved_meanwhile_ends_a_study(begun, tmp_path, monkeypatch, at_once, when):
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)
    folder, laid = begun
    moved, real = tmp_path / "moved", shards.run_runs

    def computed(*arguments, **more):
        if when == "between two shards" and not moved.exists():
            folder.path.rename(moved)
        return real(*arguments, **more)

    def told(done, total):
        if when == "in a shard" and done > 0 and not moved.exists():
            folder.path.rename(moved)

    monkeypatch.setattr(shards, "run_runs", computed)
    with pytest.raises(errors.DiskError, match="has gone, moved or deleted meanwhile"):
        run_here(folder, laid, Share(), told)
    assert not folder.path.exists()
    moved.rename(folder.path)
    assert folder.failures() == {}
    monkeypatch.undo()
    assert run_here(folder, laid, Share(), nothing) == []
    assert folder.missing() == []


def test_a_folder_that_has_gone_takes_neither_reasons_nor_the_file_that_shows_all(begun, tmp_path):
    folder, laid = begun
    folder.path.rename(tmp_path / "moved")
    for wanted in (
        lambda: folder.note_failure(1, "no memory"),
        lambda: shards.show_all(folder, laid),
        lambda: shards.compute_shard(folder, laid, 1),
    ):
        with pytest.raises(errors.DiskError, match="has gone"):
            wanted()
    assert not folder.path.exists()
