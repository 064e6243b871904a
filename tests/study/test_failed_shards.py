"""Shards that fail as a whole: each leaves its reason, and the rest goes on."""

import pytest
from command_line import say
from engine_runs import nylon_rope, study_of

from lumpedcable.results import StudyFolder
from lumpedcable.study import shards
from lumpedcable.study.shards import Share, open_study, run_here

# 12 short runs of one structure
SMALL = (
    nylon_rope(12, "2 ms")
    + """
keep = "summaries"
[sweep]
"lines.rope.end.held.pretension" = { from = "45 kN", to = "180 kN", count = 12 }
[solver]
waves = "plain"
"""
)


@pytest.fixture
def study(tmp_path):
    return study_of(tmp_path, SMALL)


def test_a_shard_that_fails_leaves_its_reason_and_the_rest_goes_on(study, tmp_path, monkeypatch):
    folder, laid = open_study(study, tmp_path / "s", 5)
    real = shards.run_runs

    def spoilt(laid, runs, *others, **more):
        if runs[0] == 5:
            raise MemoryError("no room")
        return real(laid, runs, *others, **more)

    monkeypatch.setattr(shards, "run_runs", spoilt)
    assert run_here(folder, laid, Share(), lambda done, total: None) == [1]
    assert folder.missing() == [1]
    told = say(tmp_path, "info", "s").out
    assert "2 of 3 shards, 7 of 12 runs" in told
    assert "shard 1  " in told
    assert "failed: MemoryError: no room" in told
    monkeypatch.undo()
    assert run_here(folder, laid, Share(), lambda done, total: None) == []
    assert folder.failures() == {}


def test_an_error_of_the_program_leaves_where_it_arose(study, tmp_path, monkeypatch):
    folder, laid = open_study(study, tmp_path / "s", 5)

    def spoilt(laid, runs, *others, **more):
        raise (KeyError("mass") if runs[0] else MemoryError("no room"))

    monkeypatch.setattr(shards, "run_runs", spoilt)
    assert run_here(folder, laid, Share(0, 2), lambda done, total: None) == [0, 2]
    kept = folder.failures()
    assert kept[0] == "MemoryError: no room"
    first, *below = kept[2].splitlines()
    assert first == "KeyError: 'mass'"
    assert below[1] == "Traceback (most recent call last):"
    assert any(line.endswith(", in spoilt") for line in below)
    told = say(tmp_path, "info", "s").out
    assert "failed: KeyError: 'mass'\n" in told
    assert "Traceback" not in told


def test_a_reason_begins_with_a_line_that_says_something():
    assert shards.reason_of(MemoryError()) == "MemoryError"
    assert shards.reason_of(OSError("\n  no\nroom\n")) == "OSError: no\nroom"
    # one that was never raised arose nowhere
    assert shards.reason_of(ValueError("\n")) == "ValueError\n\nValueError:"


@pytest.mark.parametrize("at_once", [1, 2])
def test_a_reason_that_cannot_be_kept_is_raised(study, tmp_path, monkeypatch, at_once):
    # as on a full disk: nobody waits for the shard whose end could not be told
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)

    def full(*_, **__):
        raise OSError("no room")

    monkeypatch.setattr(shards, "run_runs", full)
    monkeypatch.setattr(StudyFolder, "note_failure", full)
    folder, laid = open_study(study, tmp_path / "s", 5)
    with pytest.raises(OSError, match="no room"):
        run_here(folder, laid, Share(), lambda done, total: None)
