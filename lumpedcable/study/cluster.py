"""A study's shards on the workers of dask.distributed, its own or a cluster's.

A worker computes a shard as one process does alone, from the same file, with the same program, and
puts it into the folder, which all must see. A worker that dies loses the shard that it is at; another
one computes it.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
from asyncio import wait_for
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any

from distributed import Client, LocalCluster, WorkerPlugin, as_completed
from distributed.comm.core import CommClosedError
from distributed.scheduler import KilledWorker

from lumpedcable.results import StudyFolder
from lumpedcable.results.errors import DiskError, OutputError, first_line
from lumpedcable.scene import load_study
from lumpedcable.study.laying import Laid, lay_out
from lumpedcable.study.shards import (
    Share,
    apart,
    compute_shard,
    in_rounds,
    reason_of,
    refuse_others_work,
    show_all,
)

__all__ = ["run_on_cluster"]

PATIENCE = "10s"  # for a scheduler to answer
SOON = 5.0  # s until a scheduler without workers is told of
STUDIES = 4  # that a worker keeps laid out: its scheduler may outlive them all
ALLOWED_DEATHS = 3  # of workers, while one and the same shard was on them
# one core each: what a worker computes must not depend on how many there are
PINNED = {
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
}


def run_on_cluster(
    folder: StudyFolder,
    laid: Laid,
    share: Share,
    on_progress: Callable[[int, int], None],
    scheduler: str | None = None,
    workers: int = 2,
) -> list[int]:
    """Compute the missing shards of a share on dask workers.

    Args:
        folder, laid, share, on_progress: as of `run_here`.
        scheduler: address of a scheduler; None starts a cluster of processes on this machine.
        workers: processes of such a cluster.

    Returns:
        The shards that failed; not those that are left to other processes.

    Raises:
        OutputError: no scheduler answers at the address, or it goes away, or the disk is full or gone.
        KeyboardInterrupt: interrupted; finished shards stay.
    """
    missing = share.missing(folder, laid)
    outputs = {shard: len(folder.runs(shard)) * laid.count for shard in missing}
    done, failed, rounds = 0, [], count()
    on_progress(done, sum(outputs.values()))
    if not missing:
        return failed
    with _present(scheduler, folder), _client(scheduler, workers) as client:
        if scheduler is not None:
            _await_workers(client, scheduler)
        where = str(folder.path.resolve())

        def tell(shard: int) -> None:
            nonlocal done
            done += outputs[shard]
            on_progress(done, sum(outputs.values()))

        def compute_all(some: list[int]) -> list[int]:
            left, turn = [], next(rounds)
            tasks = {
                # under another name than in the round before, and than that of another study which
                # was in this folder before, whose answers are known
                client.submit(
                    _shard,
                    where,
                    shard,
                    key=f"{where}/{folder.name(shard)}-{turn}",
                    retries=1,
                    pure=False,
                ): shard
                for shard in some
            }
            for task in as_completed(tasks):
                if task.cancelled():  # by nobody here
                    raise CancelledError
                shard, error = tasks[task], task.exception()
                if isinstance(error, DiskError):
                    raise error
                if error is None and not task.result():
                    left.append(shard)
                    continue
                if error is not None:
                    reason = f"{ALLOWED_DEATHS} workers died while they computed it"
                    if not isinstance(error, KilledWorker):
                        reason = reason_of(error, task.traceback())
                    folder.note_failure(shard, reason)
                    failed.append(shard)
                tell(shard)
            return sorted(left)

        for shard in in_rounds(compute_all, apart(missing, laid, max(_workers(client), 1))):
            tell(shard)
    show_all(folder, laid)
    return failed


@contextmanager
def _present(scheduler: str | None, folder: StudyFolder) -> Iterator[None]:
    """A scheduler that goes away meanwhile is told in a line."""
    try:
        yield
    except (CommClosedError, CancelledError):
        which = "the scheduler" if scheduler is None else f"the scheduler at {scheduler}"
        raise OutputError(
            f"{which} has gone; finished shards are in {folder.path}, the same command goes on"
        ) from None


def _await_workers(client: Client, scheduler: str) -> None:
    """Say so once where a scheduler has no workers yet; those that come take what waits for them."""
    try:
        client.wait_for_workers(1, timeout=SOON)
    except TimeoutError:
        print(f"no workers at {scheduler} yet, waiting", file=sys.stderr, flush=True)


def _workers(client: Client) -> int:
    """How many workers there are now."""
    known = client.nthreads()
    assert isinstance(known, dict)  # of a client that is not asynchronous
    return len(known)


class _Impatient(Client):
    """A client that gives up a port that takes its connection and says nothing."""

    async def _ensure_connected(self, timeout=None):
        # dask limits the wait for a connection, and tells of it first; not that for the first answer
        longest = None if timeout is None else timeout + 1.0
        await wait_for(super()._ensure_connected(timeout), longest)


class _Own(WorkerPlugin):
    """In a worker of a cluster of its own: the command alone hears Ctrl-C, and tells of what it ends."""

    def setup(self, worker: Any) -> None:
        with suppress(ValueError):  # in a thread, which no signal reaches
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        # which warns of a task that is cut short as the worker is closed
        logging.getLogger("distributed.worker.state_machine").setLevel(logging.ERROR)
        logging.getLogger("distributed.worker").addFilter(_is_news)


def _is_news(record: logging.LogRecord) -> bool:
    """Whether a worker logs more than the error of a shard, which the command tells or keeps."""
    return not str(record.msg).startswith("Compute Failed")


@contextmanager
def _client(scheduler: str | None, workers: int) -> Iterator[Client]:
    """A client of the scheduler at an address, or of a cluster of its own.

    What ends it early is told by whoever hears of it: what the library has to say of connections that
    are closed under its hands, in many lines, is not.
    """
    with ExitStack() as stack:
        stack.callback(logging.disable, logging.root.manager.disable)
        if scheduler is None:
            stack.enter_context(_environment(PINNED))
            # processes are spawned, never forked: jax has threads
            options: dict[str, Any] = {"processes": True, "dashboard_address": None}
            cluster = LocalCluster(n_workers=workers, threads_per_worker=1, **options)
            client = stack.enter_context(Client(stack.enter_context(cluster)))
            client.register_plugin(_Own())
        else:
            unknown = f"no dask scheduler at {scheduler}"
            try:
                client = stack.enter_context(_Impatient(scheduler, timeout=PATIENCE))
            except TimeoutError:
                raise OutputError(f"{unknown}: no answer within {PATIENCE}") from None
            except (OSError, ValueError) as error:
                raise OutputError(f"{unknown}: {first_line(error)}") from None
            except MemoryError:  # the first bytes of another protocol, taken for a length
                raise OutputError(f"{unknown}: something else answers") from None
        try:
            yield client
        except BaseException:
            logging.disable()  # until all is closed
            raise


@contextmanager
def _environment(changes: dict[str, str]) -> Iterator[None]:
    """Variables that processes started meanwhile find set; what the user has set stays."""
    added = {key: value for key, value in changes.items() if key not in os.environ}
    os.environ.update(added)
    try:
        yield
    finally:
        for key in added:
            del os.environ[key]


@lru_cache(STUDIES)
def _laid(folder: StudyFolder) -> Laid:
    """The study of a folder laid out; known by path and manifest, since another may take its place."""
    return lay_out(load_study(folder.scene))


def _shard(where: str, shard: int) -> bool:
    """`compute_shard` on a worker; a study is laid out and compiled once in its life."""
    folder = StudyFolder.open(Path(where))
    refuse_others_work(folder)
    return compute_shard(folder, _laid(folder), shard)
