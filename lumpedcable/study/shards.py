"""A study in a folder, shard by shard: what is there is kept, what is not is computed.

Any number of processes may work on one folder. Whoever writes a shard has it locked; the others go on
with the next one, and look again at the end.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Event, Lock
from types import TracebackType

import jax
import numpy as np

from lumpedcable import __version__
from lumpedcable.results import StudyFolder, open_result
from lumpedcable.results.errors import BusyError, DiskError, OutputError, ResultError
from lumpedcable.scene import SceneError, Study, load_study
from lumpedcable.sources import SOURCES
from lumpedcable.study.batches import shard_size
from lumpedcable.study.contents import Contents, versions
from lumpedcable.study.laying import Laid, lay_out
from lumpedcable.study.run import run_runs

__all__ = [
    "Share",
    "apart",
    "compute_shard",
    "open_study",
    "reason_of",
    "refuse_others_work",
    "run_here",
    "show_all",
]

# shards under way at once in a process: while one is checked, brought to rest, summed up or written,
# which is work of Python on one core, the other moves
AT_ONCE = 2
TURNS = 50
"""Times that a process tries to write what others write too."""
WAIT = 0.1
"""Seconds between two of them."""
PLAIN = (OutputError, ResultError, SceneError, MemoryError, OSError)
"""Errors of the disk, the machine or the scene, whose message says all there is to say."""


@dataclass(frozen=True)
class Share:
    """The shards that one of several independent processes takes, number `part` from 0 on, `of` them."""

    part: int = 0
    of: int = 1

    def missing(self, folder: StudyFolder, laid: Laid) -> list[int]:
        """What is missing of this share of a study's shards.

        Every `of`-th, so that all shares take about as long; but neighbours where there are several
        structures, which neighbours most often have in common, since each process lays out its own.
        """
        if len(laid.structures) == 1:
            return [shard for shard in folder.missing() if shard % self.of == self.part]
        return [
            shard for shard in folder.missing() if shard * self.of // folder.shards == self.part
        ]


def open_study(study: Study, path: Path, shard: int | None = None) -> tuple[StudyFolder, Laid]:
    """The folder of a study, made where it is not there, and the study laid out.

    What is laid out is the folder's own copy of the study, so that every process that works on it
    reads the same numbers.

    Raises:
        SceneError: the study cannot be laid out.
        OutputError: the folder cannot be made, or holds another study or another program's shards.
        ResultError: a shard in it is none of its own.
    """
    lay_out(study)  # told with the lines of the user's file, before anything is written
    text = study.effective_text
    runs = len(study.runs)
    folder = StudyFolder.make(
        path, text, runs, shard, __version__, shard_size(runs), program=_program()
    )
    laid = lay_out(load_study(folder.scene))
    show_all(folder, laid)
    return folder, laid


def _program() -> dict[str, str]:
    """What computes beside the version of the package: numbers of two are not mixed in one study."""
    return {"sources": (SOURCES or "")[:12], **versions()}


def refuse_others_work(folder: StudyFolder) -> None:
    """Raise OutputError where the shards of a folder are computed by another program than this one."""
    folder.refuse_program(__version__, _program())


def show_all(folder: StudyFolder, laid: Laid) -> None:
    """Write the file that shows all shards as one; it says whether they are complete.

    Raises:
        BusyError: there is none yet, and another process goes on writing it.
        DiskError: the folder has gone.
        OutputError: it cannot be written, and none that is there says that all shards are.
        ResultError: a shard has the name of another.
    """
    folder.refuse_misnamed()
    contents = Contents(laid, np.arange(folder.manifest.runs), exact=False)
    for turn in range(TURNS):
        try:
            with contents.open(folder.view, folder.parts(), folders=False) as writer:
                # looked at while nobody else writes it: the last who does must know of all
                writer.finish(complete=not folder.missing())
            return
        except BusyError:
            # another process that has begun on the same folder writes it now, and may not know yet
            # what is there
            if turn == TURNS - 1 and not folder.view.exists():
                raise
        except OutputError:
            folder.refuse_gone()
            if not _shown(folder):
                raise
            return  # of a study that is complete, on a disk that is full or may not be written
        time.sleep(WAIT)


def _shown(folder: StudyFolder) -> bool:
    """Whether the file that shows all shards is there and says that they are complete, as they are."""
    if folder.missing():
        return False
    try:
        with open_result(folder.view) as view:
            return view.complete
    except ResultError:
        return False


def reason_of(error: BaseException, where: TracebackType | None = None) -> str:
    """What is kept of why a shard failed: a line of what it was.

    Below it, of an error that is neither of the disk nor of the machine nor of the scene, there is where
    in the program it arose.

    Args:
        error: what was raised.
        where: its traceback; None for its own.
    """
    said = ": ".join(filter(None, [type(error).__name__, str(error).strip()]))
    if isinstance(error, PLAIN):
        return said
    trace = traceback.format_exception(type(error), error, where or error.__traceback__)
    return f"{said}\n\n{''.join(trace)}".rstrip()


def compute_shard(
    folder: StudyFolder,
    laid: Laid,
    shard: int,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> bool:
    """Compute a shard and put it into the folder; the same bits wherever it is done on as many devices.

    Returns:
        Whether it is there now, by whomever: not where another process is writing it.

    Raises:
        DiskError: the disk is full or gone, or the study's folder has gone.
        OutputError: it cannot be written.
    """
    runs, file = np.asarray(folder.runs(shard)), folder.file(shard)
    if not file.exists():
        try:
            # no folder is made: one in the place of a study that was moved would be no study
            run_runs(laid, runs, file, on_progress, exact=False, overwrite=False, folders=False)
        except BusyError:  # also where its file was moved or deleted with the folder
            folder.refuse_gone()
            return False
        except OutputError:
            folder.refuse_gone()
            if not file.exists():  # it is, where another process has finished it meanwhile
                raise
    folder.forget_failure(shard)
    return True


def run_here(
    folder: StudyFolder,
    laid: Laid,
    share: Share,
    on_progress: Callable[[int, int], None],
) -> list[int]:
    """Compute the missing shards of a share in this process, `AT_ONCE` of them under way.

    A shard that another process writes is left to it, and looked at again once the others are there.
    One that fails as a whole leaves its reason in the folder, and the rest goes on; but not on a disk
    that is full, where all others would fail.

    Args:
        folder, laid: the study.
        share: which shards are this process's.
        on_progress: called with finished and all outputs of all runs that are to be computed; by one
            thread at a time, not always the same. What other processes compute meanwhile counts as
            finished, and so does, in the end, what is left to them.

    Returns:
        The shards that failed; not those that are left to other processes.

    Raises:
        DiskError: the disk is full or gone; finished shards stay.
        KeyboardInterrupt: interrupted; finished shards stay.
    """
    missing, failed, spent = share.missing(folder, laid), [], []
    outputs = {shard: len(folder.runs(shard)) * laid.count for shard in missing}
    together = _Together(outputs, on_progress)
    together.tell()
    left: list[int] = []  # to other processes

    def compute(shard: int) -> None:
        try:
            together.tell()  # nobody begins once another has ended all
            try:
                if not compute_shard(
                    folder, laid, shard, lambda done, _: together.tell(shard, done)
                ):
                    left.append(shard)
                    return
            except DiskError as error:
                spent.append(error)
                together.stop()
                raise
            except Exception as error:
                folder.note_failure(shard, reason_of(error))
                failed.append(shard)
            together.tell(shard, outputs[shard])
        finally:
            together.moving.set()  # whatever becomes of it, nobody waits for it any more

    with ThreadPoolExecutor(_at_once()) as pool:

        def compute_all(some: list[int]) -> list[int]:
            left.clear()
            tasks = []
            for shard in some:
                tasks.append(pool.submit(compute, shard))
                if len(laid.structures) == 1:
                    together.moving.wait()  # programs are compiled by the first shard, for all
            for task in tasks:
                task.result()
            return sorted(left)

        try:
            for shard in in_rounds(compute_all, apart(missing, laid, _at_once())):
                together.tell(shard, outputs[shard])
        except BaseException:
            together.stop()
            pool.shutdown(cancel_futures=True)
            if spent:  # the others were interrupted because of it
                raise spent[0] from None
            raise
    show_all(folder, laid)
    return sorted(failed)


def in_rounds(compute: Callable[[list[int]], list[int]], shards: list[int]) -> list[int]:
    """Compute shards, and again those that were left to other processes, as long as that helps.

    Args:
        compute: computes shards and returns those that other processes were writing.
        shards: their numbers.

    Returns:
        Those that are left to others.
    """
    left = compute(shards)
    while 0 < len(left) < len(shards):
        shards, left = left, compute(left)
    return left


def _at_once() -> int:
    """Shards under way at once: one alone where a process is to keep to one core."""
    return 1 if jax.default_backend() == "cpu" and jax.device_count() == 1 else AT_ONCE


def apart(shards: list[int], laid: Laid, at_once: int) -> list[int]:
    """Shards in an order in which those under way at once are far from each other.

    Neighbours have the same structures most often: one of two would wait for the other to compile, or
    two processes would both do it. Shards of one structure keep their order.
    """
    step = -(-len(shards) // at_once) if len(laid.structures) > 1 else 1
    return [shard for first in range(step) for shard in shards[first::step]]


class _Together:
    """Adds up the outputs of shards under way in several threads.

    Attributes:
        moving: set once some shard has moved or ended.
    """

    def __init__(self, outputs: Mapping[int, int], on_progress: Callable[[int, int], None]):
        self.total, self.on_progress = sum(outputs.values()), on_progress
        self.moving = Event()
        self._done = dict.fromkeys(outputs, 0)
        self._lock, self._stopped = Lock(), False

    def tell(self, shard: int | None = None, done: int = 0) -> None:
        """Outputs of a shard that are done; KeyboardInterrupt once anybody has interrupted."""
        with self._lock:
            if self._stopped:
                raise KeyboardInterrupt
            if shard is not None:
                self._done[shard] = done
            try:
                self.on_progress(sum(self._done.values()), self.total)
            except BaseException:
                self.stop()
                raise
        if done > 0:
            self.moving.set()

    def stop(self) -> None:
        """Interrupt every shard at its next outputs."""
        self._stopped = True
