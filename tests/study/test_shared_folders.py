"""Several processes on the folder of one study, none of them told which shards are its own."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import good_scenes
import pytest
from command_line import say

from lumpedcable.results import disk, open_result
from lumpedcable.results.schema import partial_of
from lumpedcable.scene import load_study
from lumpedcable.study import shards
from lumpedcable.study.contents import Contents
from lumpedcable.study.shards import Share, open_study, run_here, show_all

# 6 short runs of one structure, of 2 outputs each
SMALL = good_scenes.short_runs(
    "2 ms", '{ from = "45 kN", to = "180 kN", count = 6 }', '\nkeep = "summaries"'
)
OUTPUTS = 12


@pytest.fixture
def study(tmp_path):
    return load_study(good_scenes.write(tmp_path, SMALL))


@pytest.fixture
def begun(study, tmp_path):
    """A study of six shards of a run each, of which none is there."""
    return open_study(study, tmp_path / "s", 1)


def hold(folder, shard):
    """A shard that is being written, as another process would have it."""
    return disk.create(partial_of(folder.file(shard)))


def computed(monkeypatch, after=lambda run: None):
    """The runs that are computed from now on, one by one, and what happens after each."""
    real, seen = shards.run_runs, []

    def counted(laid, runs, *others, **more):
        found = real(laid, runs, *others, **more)
        seen.append(int(runs[0]))
        after(int(runs[0]))
        return found

    monkeypatch.setattr(shards, "run_runs", counted)
    return seen


@pytest.mark.parametrize("at_once", [1, 2])
def test_a_shard_that_another_process_writes_is_left_to_it(begun, monkeypatch, at_once):
    folder, laid = begun
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)
    done, told = computed(monkeypatch), []
    held = hold(folder, 2)
    assert run_here(folder, laid, Share(), lambda *told_now: told.append(told_now)) == []
    assert sorted(done) == [0, 1, 3, 4, 5]
    assert folder.missing() == folder.begun() == [2]
    assert told[0] == (0, OUTPUTS)
    assert told[-1] == (OUTPUTS, OUTPUTS)
    assert sorted(told) == told
    # it has not failed: nothing says so, neither here nor to whoever asks
    assert folder.failures() == {}
    assert "failed" not in say(folder.path, "info", ".").out
    held.close()  # as by kill -9: what it has left is no obstacle
    assert run_here(folder, laid, Share(), lambda *_: None) == []
    assert sorted(done) == [0, 1, 2, 3, 4, 5]
    assert folder.missing() == []


def test_what_was_locked_is_looked_at_again_in_the_end(begun, monkeypatch):
    folder, laid = begun
    held = {shard: hold(folder, shard) for shard in (0, 1)}
    # the writers die when 3 is there and when 0 is
    dies = {3: 0, 0: 1}
    done = computed(monkeypatch, lambda run: held[dies[run]].close() if run in dies else None)
    told = []
    assert run_here(folder, laid, Share(), lambda *told_now: told.append(told_now)) == []
    assert sorted(done) == [0, 1, 2, 3, 4, 5]
    assert set(done[-2:]) == {0, 1}
    assert folder.missing() == []
    assert told[-1] == (OUTPUTS, OUTPUTS)


def test_a_shard_that_another_process_has_finished_is_kept(begun, tmp_path, study, monkeypatch):
    other, laid = open_study(study, tmp_path / "other", 1)
    run_here(other, laid, Share(), lambda *_: None)
    folder, laid = begun
    monkeypatch.setattr(shards, "_at_once", lambda: 1)

    def finish(run):  # once 1 is there another process has computed 4
        if run == 1:
            other.file(4).rename(folder.file(4))

    done, told = computed(monkeypatch, finish), []
    assert run_here(folder, laid, Share(), lambda *told_now: told.append(told_now)) == []
    assert done == [0, 1, 2, 3, 5]
    assert told[-1] == (OUTPUTS, OUTPUTS)
    with open_result(folder.path) as view:
        assert view.complete
        assert view.status == ["ok"] * 6


def test_a_shard_that_is_finished_while_it_is_begun_is_not_written_twice(begun, monkeypatch):
    # between the look for its file and the lock
    folder, laid = begun
    prepare, finished = disk.prepare, folder.file(3)

    def late(target, *others):
        prepare(target, *others)
        if target == finished:
            finished.write_text("of another process")

    monkeypatch.setattr(disk, "prepare", late)
    assert shards.compute_shard(folder, laid, 3)
    assert finished.read_text() == "of another process"
    assert folder.begun() == []


def test_two_at_once_compute_every_shard_once(begun, monkeypatch):
    folder, laid = begun
    done, start = computed(monkeypatch), Barrier(2)

    def work(_):
        start.wait()
        told = []
        failed = run_here(folder, laid, Share(), lambda *told_now: told.append(told_now))
        return failed, told[-1]

    with ThreadPoolExecutor(2) as pool:
        ends = list(pool.map(work, range(2)))
    assert sorted(done) == [0, 1, 2, 3, 4, 5]
    assert [failed for failed, _ in ends] == [[], []]
    assert all(done == total for _, (done, total) in ends)
    assert folder.missing() == []
    assert folder.failures() == {}


def test_the_file_that_shows_all_knows_what_was_finished_while_it_was_begun(begun, monkeypatch):
    # else a process that is early would have the last word over one that knows more
    folder, laid = begun
    for shard in range(5):
        folder.file(shard).touch()
    real = Contents.open

    def late(*arguments, **more):
        writer = real(*arguments, **more)
        folder.file(5).touch()
        return writer

    monkeypatch.setattr(Contents, "open", late)
    show_all(folder, laid)
    with open_result(folder.path) as view:
        assert view.complete


def test_workers_of_a_cluster_leave_shards_to_others_too(begun):
    cluster = pytest.importorskip("lumpedcable.study.cluster")
    folder, _ = begun
    where = str(folder.path)
    held = hold(folder, 1)
    assert cluster._shard(where, 1) is False
    held.close()
    assert cluster._shard(where, 1) is True
    stamp = folder.file(1).stat().st_mtime_ns
    assert cluster._shard(where, 1) is True
    assert folder.file(1).stat().st_mtime_ns == stamp


def test_rounds_end_where_nothing_more_is_there_to_be_done():
    asked = []

    def compute(some):  # 7 stays with another process
        asked.append(some)
        return [shard for shard in some if shard == 7 or (shard == 8 and len(asked) == 1)]

    assert shards.in_rounds(compute, [6, 7, 8, 9]) == [7]
    assert asked == [[6, 7, 8, 9], [7, 8], [7]]
    assert shards.in_rounds(lambda some: [], []) == []
