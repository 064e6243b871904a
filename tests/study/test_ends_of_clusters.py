"""Studies on dask workers that are ended early, or wait: each is told in a line of its own."""

import logging
import os
import re
import signal
import threading
import time
from contextlib import contextmanager

import good_scenes
import pytest
from command_line import process, python

pytest.importorskip("distributed")

from lumpedcable.results.errors import OutputError
from lumpedcable.scene import load_study
from lumpedcable.study import cluster
from lumpedcable.study.shards import Share, open_study

SMALL = good_scenes.short_runs(
    "2 ms", '{ from = "45 kN", to = "180 kN", count = 4 }', '\nkeep = "summaries"'
)
# long enough to be interrupted
LONG = good_scenes.short_runs(
    "200 ms", '{ from = "45 kN", to = "180 kN", count = 4000 }', '\nkeep = "summaries"'
)
SCHEDULER = """
import asyncio
from distributed import Scheduler
async def serve():
    async with Scheduler(host="127.0.0.1", port=0, dashboard=False) as here:
        print(here.address, flush=True)
        await here.finished()
asyncio.run(serve())
"""


@contextmanager
def scheduler():
    """A scheduler without workers, in a process of its own: the process and its address."""
    with python("-c", SCHEDULER) as child:
        yield child, child.stdout.readline().strip()


def test_a_scheduler_without_workers_is_told_and_so_is_one_that_goes(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(cluster, "SOON", 0.2)
    folder, laid = open_study(load_study(good_scenes.write(tmp_path, SMALL)), tmp_path / "s", 2)
    awaited, waits = cluster._await_workers, threading.Event()

    def then(*arguments):
        awaited(*arguments)
        waits.set()

    monkeypatch.setattr(cluster, "_await_workers", then)
    with scheduler() as (child, where):

        def kill():
            waits.wait(60.0)
            time.sleep(0.3)  # so that the shards are with it
            child.kill()

        killer = threading.Thread(target=kill)
        killer.start()
        words = f"the scheduler at {where} has gone; finished shards are in {folder.path}, the same"
        with pytest.raises(OutputError, match=re.escape(words)):
            cluster.run_on_cluster(folder, laid, Share(), lambda done, total: None, where)
        killer.join()
    assert capfd.readouterr().err.splitlines() == [f"no workers at {where} yet, waiting"]
    assert folder.failures() == {}
    assert logging.root.manager.disable == logging.NOTSET


@pytest.mark.slow
@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize(("number", "word"), [("SIGINT", "interrupted"), ("SIGTERM", "terminated")])
def test_an_interrupted_study_says_so_in_one_line(tmp_path, number, word, whole):
    # by Ctrl-C, which the workers get as well, and by kill, which asks the command alone
    number, deadline = getattr(signal, number), time.monotonic() + 120.0
    scene = good_scenes.write(tmp_path, LONG)
    words = ["study", scene, "-o", "s", "--shard", "100", "--executor", "dask"]
    with process(tmp_path, *words, start_new_session=True) as child:
        while not list((tmp_path / "s" / "shards").glob("*.h5")):
            assert child.poll() is None, child.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.01)
        (os.killpg if whole else os.kill)(child.pid, number)
        _, err = child.communicate(timeout=60)
    assert child.returncode == 128 + number
    assert err == f"{word}; finished shards are in s, the same command goes on\n"
