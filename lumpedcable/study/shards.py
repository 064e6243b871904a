"""A study in a folder, shard by shard: what is there is kept, what is not is computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lumpedcable import __version__
from lumpedcable.results import StudyFolder
from lumpedcable.results.errors import OutputError
from lumpedcable.scene import Study, load_study
from lumpedcable.study.contents import Contents
from lumpedcable.study.laying import Laid, lay_out
from lumpedcable.study.run import run_runs

__all__ = ["Share", "compute_shard", "open_study", "run_here", "show_all"]


@dataclass(frozen=True)
class Share:
    """The shards that one of several independent processes takes: every `of`-th from `part` on."""

    part: int = 0
    of: int = 1

    def among(self, shards: Iterable[int]) -> list[int]:
        """This share of some shards."""
        return [shard for shard in shards if shard % self.of == self.part]


def open_study(study: Study, path: Path, shard: int | None = None) -> tuple[StudyFolder, Laid]:
    """The folder of a study, made where it is not there, and the study laid out.

    What is laid out is the folder's own copy of the study, so that every process that works on it
    reads the same numbers.

    Raises:
        SceneError: the study cannot be laid out.
        OutputError: the folder cannot be made, or holds another study.
    """
    lay_out(study)  # told with the lines of the user's file, before anything is written
    text = study.effective_text
    folder = StudyFolder.make(path, text, len(study.runs), shard, __version__)
    laid = lay_out(load_study(folder.scene))
    show_all(folder, laid)
    return folder, laid


def show_all(folder: StudyFolder, laid: Laid) -> None:
    """Write the file that shows all shards as one; it says whether they are complete."""
    contents = Contents(laid, np.arange(folder.manifest.runs), exact=False)
    missing = folder.missing()
    try:
        with contents.open(folder.view, folder.parts()) as writer:
            writer.finish(complete=not missing)
    except OutputError:
        if not folder.view.exists():  # another process writes the same one now
            raise


def compute_shard(
    folder: StudyFolder,
    laid: Laid,
    shard: int,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """Compute a shard and put it into the folder; the same bits wherever it is done.

    Raises:
        OutputError: it cannot be written, or another process writes it.
    """
    runs = np.asarray(folder.runs(shard))
    run_runs(laid, runs, folder.file(shard), on_progress, exact=False)
    folder.forget_failure(shard)


def run_here(
    folder: StudyFolder,
    laid: Laid,
    share: Share,
    on_progress: Callable[[int, int], None],
) -> list[int]:
    """Compute the missing shards of a share in this process, one after the other.

    A shard that fails as a whole leaves its reason in the folder, and the rest goes on.

    Args:
        folder, laid: the study.
        share: which shards are this process's.
        on_progress: called with finished and all outputs of all runs that are to be computed.

    Returns:
        The shards that failed.

    Raises:
        KeyboardInterrupt: interrupted; finished shards stay.
    """
    missing, failed = share.among(folder.missing()), []
    total = sum(len(folder.runs(shard)) for shard in missing) * laid.count
    before = 0
    on_progress(0, total)
    for shard in missing:
        try:
            compute_shard(
                folder, laid, shard, lambda done, _, b=before: on_progress(b + done, total)
            )
        except Exception as error:
            folder.note_failure(shard, f"{type(error).__name__}: {error}")
            failed.append(shard)
        before += len(folder.runs(shard)) * laid.count
        on_progress(before, total)
    show_all(folder, laid)
    return failed
