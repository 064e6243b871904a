"""Studies on dask workers: equal to one process bit for bit, also where a worker is killed."""

import shutil
import socket
import threading
import time
from contextlib import ExitStack, contextmanager, suppress

import good_scenes
import pytest
from command_line import process, python, say
from engine_runs import nylon_rope
from file_contents import assert_equal_bits, contents

pytest.importorskip("distributed")
import psutil

from lumpedcable.results import StudyFolder, open_result

SMALL = good_scenes.short_runs("4 ms", '{ from = "45 kN", to = "450 kN", count = 24 }')
# a program that is soon compiled, in each worker anew
DRY = (
    nylon_rope(12, "4 ms")
    + """
[sweep]
"lines.rope.end.held.pretension" = { from = "45 kN", to = "450 kN", count = 12 }
[solver]
waves = "plain"
"""
)


def kill_at_work(child):
    """Kill one of the processes below a command, dask's workers, that is at a shard."""
    for one in psutil.Process(child.pid).children(recursive=True):
        with suppress(psutil.NoSuchProcess, psutil.AccessDenied):
            if not is_at_work(one):
                continue
            one.suspend()  # so that it does not finish between looking and killing
            if one.status() == psutil.STATUS_STOPPED and is_at_work(one):
                one.kill()
                return True
            one.resume()
    return False


def is_at_work(process):
    """Whether a process has a file of a shard open that has not yet its name."""
    return any(opened.path.endswith(".h5.partial") for opened in process.open_files())


@pytest.mark.slow
def test_a_killed_worker_costs_nothing_but_time(tmp_path):
    scene = good_scenes.write(tmp_path, DRY)
    # one core, as each worker has: on more of them a batch is shared out and its lanes round otherwise
    words = ["study", scene, "--shard", "2", "-o"]
    with process(tmp_path, *words, "alone", "--cores", "1") as single:
        _, err = single.communicate(timeout=300)
    assert single.returncode == 0, err
    alone = StudyFolder.open(tmp_path / "alone")

    deadline = time.monotonic() + 300
    with process(tmp_path, *words, "many", "--executor", "dask") as child:
        while not kill_at_work(child):
            assert child.poll() is None, child.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.01)
        out, err = child.communicate(timeout=300)
    assert child.returncode == 0, err
    assert "complete: 6 of 6 shards, 12 of 12 runs" in out
    many = StudyFolder.open(tmp_path / "many")
    for shard in range(alone.shards):
        one = contents(alone.file(shard))
        assert len(one) > 20
        assert_equal_bits(one, contents(many.file(shard)))


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


def test_a_worker_knows_another_study_in_the_same_folder(tmp_path):
    # as on a scheduler that lives long: the first study is deleted, another one begins in its place
    from lumpedcable.scene import load_study
    from lumpedcable.study import cluster
    from lumpedcable.study.shards import open_study

    last = {}
    for highest in (100, 200):
        sweep = f'{{ from = "45 kN", to = "{highest} kN", count = 2 }}'
        text = good_scenes.short_runs("2 ms", sweep, '\nkeep = "summaries"')
        study = load_study(good_scenes.write(tmp_path, text))
        folder, _ = open_study(study, tmp_path / "s", 1)
        assert cluster._shard(str(folder.path), 1) is True
        assert folder.missing() == [0]
        with open_result(folder.file(1)) as result:
            last[highest] = result.summary()["rope.end"]["static_tension"][0]
        shutil.rmtree(folder.path)
    assert last == {100: pytest.approx(100e3), 200: pytest.approx(200e3)}
    assert cluster._laid.cache_info().currsize <= cluster.STUDIES


def test_an_error_on_a_worker_leaves_where_it_arose(tmp_path, monkeypatch):
    from distributed import LocalCluster

    from lumpedcable.scene import load_study
    from lumpedcable.study import cluster
    from lumpedcable.study.shards import Share, open_study

    def spoilt(folder, laid, shard):
        raise (KeyError("mass") if shard else MemoryError("no room"))

    folder, laid = open_study(load_study(good_scenes.write(tmp_path, SMALL)), tmp_path / "s", 12)
    monkeypatch.setattr(cluster, "compute_shard", spoilt)
    with LocalCluster(n_workers=1, processes=False, dashboard_address=None) as here:
        where = here.scheduler_address
        failed = cluster.run_on_cluster(folder, laid, Share(), lambda done, total: None, where)
    assert sorted(failed) == [0, 1]
    kept = folder.failures()
    assert kept[0] == "MemoryError: no room"
    first, *below = kept[1].splitlines()
    assert first == "KeyError: 'mass'"
    assert any(line.endswith(", in spoilt") for line in below)


@contextmanager
def listener(answer):
    """The address of a port that takes connections and sends them `answer`, or nothing where None."""
    taken = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            with suppress(OSError):  # until it is shut
                while True:
                    one, _ = server.accept()
                    taken.append(one)
                    if answer is not None:
                        one.sendall(answer)

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            yield f"tcp://127.0.0.1:{server.getsockname()[1]}"
        finally:
            server.shutdown(socket.SHUT_RDWR)
            thread.join()
            for one in taken:
                one.close()


ASK = """
import faulthandler
import sys
faulthandler.dump_traceback_later(100.0, exit=True)  # whoever waits longer says where
from lumpedcable.results.errors import OutputError
from lumpedcable.study import cluster
cluster.PATIENCE = "0.2s"
for address in sys.argv[1:]:
    try:
        with cluster._client(address, 1):
            print("a scheduler")
    except OutputError as error:
        print(error)
"""


@pytest.mark.parametrize(
    "answers",
    [
        pytest.param([None, b"SSH-2.0-OpenSSH_9.6\r\n"], id="silence and ssh"),
        # read as that of ssh is
        pytest.param([b"HTTP/1.1 400 Bad Request\r\n\r\n"], id="http", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_a_port_of_something_else_is_told_in_time(answers):
    # each in a process of its own, which can be given up: a client that failed may disturb the next
    with ExitStack() as ended:
        ports = [ended.enter_context(listener(answer)) for answer in answers]
        children = [ended.enter_context(python("-c", ASK, port)) for port in ports]
        found = [child.communicate(timeout=240) for child in children]
    for port, answer, (told, why) in zip(ports, answers, found, strict=True):
        said = "no answer within 0.2s" if answer is None else ""
        assert told.startswith(f"no dask scheduler at {port}: {said}"), why
