"""What a person sees of a study in a folder: a bar with rate and time left, and how it ended."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskProgressColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from lumpedcable.results import describe
from lumpedcable.scene import Study
from lumpedcable.study.compiling import heard
from lumpedcable.study.progress import now_and_then
from lumpedcable.study.shards import Share, open_study, run_here
from lumpedcable.timings import Timings

__all__ = ["study_with_progress"]


class _Rate(ProgressColumn):
    """Runs a second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text("" if speed is None else f"{speed:.3g} runs/s")


def study_with_progress(
    study: Study,
    path: Path,
    shard: int | None,
    share: tuple[int, int],
    stopped: Callable[[], bool],
    cluster: tuple[str | None, int] | None = None,
    timings: Timings | None = None,
) -> bool:
    """Compute what a study folder lacks, with a live bar where there is a terminal to show it.

    Elsewhere a line tells now and then how far it is.

    Args:
        study: the scene file with its sweep.
        path: the folder, new or of this study.
        shard: runs in a shard, None for the folder's own or the default.
        share: this process's share, (which, of how many).
        stopped: asked after every piece whether somebody has interrupted it.
        cluster: address of a dask scheduler (None for an own cluster) and workers; None to compute
            here.
        timings: filled with the wall time of each stage.

    Returns:
        Whether all runs of the share are there now.
    """
    timings = timings or Timings()
    timings.mark("load")
    folder, laid = open_study(study, path, shard)
    timings.mark("lay out")
    console = Console(stderr=True)
    with (
        heard(timings),
        Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            TaskProgressColumn(),
            _Rate(),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        ) as progress,
    ):
        title = study.scene.title or study.path.name
        task, tell = progress.add_task(title, total=None), now_and_then(title, console.is_terminal)

        def show(done: int, total: int) -> None:
            if stopped():
                raise KeyboardInterrupt
            runs = max(laid.count, 1)
            progress.update(task, completed=done / runs, total=total / runs)
            tell(done, total)

        mine = Share(*share)
        if cluster is None:
            run_here(folder, laid, mine, show)
        else:
            from lumpedcable.study.cluster import run_on_cluster  # loads dask

            run_on_cluster(folder, laid, mine, show, *cluster)
    timings.mark("compute")
    print(describe(path))
    timings.mark("tell")
    return not mine.missing(folder, laid)
