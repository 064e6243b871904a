"""Studies on dask workers: equal to one process bit for bit, also where a worker is killed."""

import os
import signal
import time

import good_scenes
import h5py
import pytest
from command_line import process, say

pytest.importorskip("distributed")
import psutil

from lumpedcable.results import StudyFolder

SMALL = good_scenes.short_runs("4 ms", '{ from = "45 kN", to = "450 kN", count = 24 }')


def bits(path):
    """Every dataset of a results file as bytes."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: (
                found.update({name: item[()].tobytes()})
                if isinstance(item, h5py.Dataset) and item.dtype.kind != "O"
                else None
            )
        )
    return found


def workers_of(child):
    """The worker processes below a command: those that dask's nannies have spawned."""
    below = psutil.Process(child.pid).children(recursive=True)
    return [p for p in below if "spawn_main" in " ".join(p.cmdline()) and p.num_threads() > 1]


def test_a_killed_worker_costs_nothing_but_time(tmp_path):
    scene = good_scenes.write(tmp_path, SMALL)
    # one core, as each worker has: on more of them a batch is shared out and its lanes round otherwise
    single = process(tmp_path, "study", scene, "-o", "alone", "--shard", "2", "--cores", "1")
    err = single.communicate(timeout=300)[1]
    assert single.returncode == 0, err
    alone = StudyFolder.open(tmp_path / "alone")

    child = process(tmp_path, "study", scene, "-o", "many", "--shard", "2", "--executor", "dask")
    shards = tmp_path / "many" / "shards"
    deadline = time.monotonic() + 300
    while child.poll() is None and time.monotonic() < deadline:
        if shards.exists() and any(shards.glob("*.h5")):
            break
        time.sleep(0.01)
    victims = workers_of(child)
    assert victims
    assert len(list(shards.glob("*.h5"))) < alone.shards  # in the middle
    os.kill(victims[0].pid, signal.SIGKILL)
    out, err = child.communicate(timeout=300)
    assert child.returncode == 0, err
    assert "complete: 12 of 12 shards, 24 of 24 runs" in out
    many = StudyFolder.open(tmp_path / "many")
    for shard in range(alone.shards):
        one, other = bits(alone.file(shard)), bits(many.file(shard))
        assert len(one) > 20
        assert one == other


def test_a_scheduler_that_does_not_answer_is_told(tmp_path, monkeypatch):
    from lumpedcable.study import cluster

    monkeypatch.setattr(cluster, "PATIENCE", "0.5s")
    scene = good_scenes.write(tmp_path, SMALL)
    said = say(
        tmp_path, "study", scene, "-o", "s", "--executor", "dask", "--scheduler",
        "tcp://127.0.0.1:9",
    )  # fmt: skip
    assert said.code == 2
    assert "no dask scheduler at tcp://127.0.0.1:9" in said.err
