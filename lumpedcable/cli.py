"""The command line. Each command imports what it needs when it runs, so that help comes at once."""

from __future__ import annotations

import gc
import os
import sys
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

import lumpedcable
from lumpedcable.commands import adopt, fit, show
from lumpedcable.commands.console import (
    Formats,
    OneRun,
    Output,
    Set,
    SomeWhole,
    Timed,
    Whole,
    at_home,
    bare_name,
    checked,
    fail,
    interrupted,
    share_cores,
    spoken,
    study_of,
    suit_device,
)
from lumpedcable.commands.console import told as _told
from lumpedcable.commands.interrupts import interruptible, stopped
from lumpedcable.timings import command_timings

__all__ = ["app", "main"]

app = App(
    name="lumpedcable",
    help="Cable dynamics for violent, short, nonlinear events, from a TOML file to HDF5 and plots.",
    version=lumpedcable.__version__,
    suppress_keyboard_interrupt=False,  # `main` tells of it
)

CHECKED_RUNS = 1000  # of a sweep are laid out by `check`


@app.command
def run(
    scene: Path,
    /,
    *,
    output: Output = None,
    set_: Set = None,
    pictures: Annotated[bool, Parameter(name="--plot", negative="")] = False,
    timings: Timed = False,
) -> None:
    """Run a scene, with its sweep as one batch, and write an HDF5 file.

    The exit code is 0 where at least one run came to its end, 1 where none did. What was interrupted, or
    killed, goes on within some seconds of where it was when the same command is given again.

    Parameters
    ----------
    scene
        Scene file (TOML).
    output
        Results file (HDF5); the scene's name with .h5 in this folder if not given. Folders on the way
        that are not there are made.
    set_
        KEY=VALUE: another value for any key of the scene.
    pictures
        Draw its pictures as well, as `plot` does.
    timings
        Print the wall time of each stage, from the start of the command.
    """
    clock = command_timings()
    from lumpedcable.scene import load_study

    with _told():
        study = load_study(scene, set_ or [])
    suit_device(study.scene.nodes * len(study.runs))
    clock.mark("read")
    target = output or Path(f"{scene.stem}.h5")
    _check_target(target, scene)
    if pictures:
        checked(target.parent / bare_name(target))

    try:
        with _told():
            from lumpedcable.study.report import results_table, run_with_progress

            clock.mark("load")
            outcomes = run_with_progress(study, target, stopped, clock)
    except KeyboardInterrupt:
        from lumpedcable.results.schema import partial_of
        from lumpedcable.results.target import followed
        from lumpedcable.study.bookmark import bookmark_of

        partial = partial_of(followed(target))
        left = f"what was finished is in {partial}" if partial.exists() else ""
        noted = left and bookmark_of(target).exists()
        interrupted(f"{left}; the same command goes on with it" if noted else left)
    if study.scene.output.static:
        from lumpedcable.study.rest_report import rest_table

        rest_table(study, target)
    else:
        results_table(study, target, outcomes)
    clock.mark("tell")
    if pictures:
        show.plot(target)
        clock.mark("plot")
    if timings:
        print(*clock.lines(), sep="\n")
    if all(outcome.status != 0 for outcome in outcomes):
        raise SystemExit(1)


def _check_target(target: Path, scene: Path) -> None:
    """Refuse to write results over a folder, the scene itself or what is no results file, or nowhere."""
    from lumpedcable.results.target import check_folder, followed, keep_others

    if os.path.isdir(target):
        fail(f"--output: expected a file name, found the folder {target}")
    if os.path.exists(target) and os.path.samefile(target, scene):
        fail(f"--output: expected another file than the scene, found {target}")
    with _told():
        keep_others(target, "results")
        check_folder(followed(target).parent, target)


@app.command
def study(
    scene: Path,
    /,
    *,
    output: Output = None,
    set_: Set = None,
    shard: SomeWhole = None,
    part: str = "1/1",
    cores: SomeWhole = None,
    executor: Literal["here", "dask"] = "here",
    scheduler: str | None = None,
    workers: SomeWhole = None,
    timings: Timed = False,
) -> None:
    """Run a large sweep into a folder, shard by shard; run again, it goes on where it stopped.

    Each shard is finished or absent, whatever happens. The folder opens as one results file. The
    exit code is 0 where all runs are there, or all of this --part, and 1 where shards failed or
    another process still writes one.

    Parameters
    ----------
    scene
        Scene file (TOML).
    output
        Folder of the study; the scene's name in this folder if not given.
    set_
        KEY=VALUE: another value for any key of the scene.
    shard
        Runs in each shard; an eighth of them all if not given, in full batches, at most 1024 (8192 on a
        GPU).
    part
        K/M: take the K-th of M shares of the shards, and leave the rest to other processes.
    cores
        Cores of this machine that share the work; all if not given, one with --part K/M.
    executor
        here: in this process. dask: on workers of dask.distributed.
    scheduler
        Address of a dask scheduler, e.g. tcp://host:8786; a cluster of its own if not given.
    workers
        Worker processes of dask's own cluster.
    timings
        Print the wall time of each stage, from the start of the command.
    """
    clock = command_timings()
    from lumpedcable.scene import load_study

    with _told():
        loaded = load_study(scene, set_ or [])
    clock.mark("read")
    folder = output or Path(scene.stem)
    share = _share(part)
    if executor == "dask" and find_spec("distributed") is None:
        fail('--executor dask needs dask.distributed: pip install "lumpedcable[dask]"')
    if shard is not None and shard < 1:
        fail(f"--shard: expected at least 1, found {shard}")
    for name, given in (("scheduler", scheduler), ("workers", workers)):
        if executor == "here" and given is not None:
            fail(f"--{name}: expected --executor dask beside it, found none")
    if cores is not None and (cores < 1 or executor == "dask"):
        found = str(cores) if cores < 1 else "--executor dask, whose workers have one each"
        fail(f"--cores: expected at least 1, and --executor here, found {found}")
    if workers is not None and workers < 1:
        fail(f"--workers: expected at least 1, found {workers}")

    if executor == "here":
        share_cores(1 if cores is None and share[1] > 1 else cores)
    try:
        with _told():
            from lumpedcable.study.shards_report import study_with_progress

            complete = study_with_progress(
                loaded, folder, shard, share, stopped,
                (scheduler, workers or 2) if executor == "dask" else None, clock,
            )  # fmt: skip
    except KeyboardInterrupt:
        kept = f"finished shards are in {folder}, the same command goes on"
        interrupted(kept if folder.is_dir() else "nothing is finished yet")
    if timings:
        print(*clock.lines(), sep="\n")
    if not complete:
        raise SystemExit(1)


def _share(text: str) -> tuple[int, int]:
    """The share K/M of independent processes, counted from 0."""
    first, slash, last = text.partition("/")
    if not (slash and first.isdecimal() and last.isdecimal() and 1 <= int(first) <= int(last)):
        fail(f"--part: expected K/M with K from 1 to M, found {text}")
    return int(first) - 1, int(last)


@app.command
def modes(
    scene: Path,
    /,
    *,
    count: Annotated[Whole, Parameter(name=["--count", "-n"])] = 10,
    output: Output = None,
    set_: Set = None,
    run_: OneRun = 0,
    format_: Formats = None,
    timings: Timed = False,
) -> None:
    """Find the natural modes of a scene about its static equilibrium.

    Prints a table, draws the shapes (modes.png) and writes both as numbers (modes.json). The exit
    code is 1 where no equilibrium was found.

    Parameters
    ----------
    scene
        Scene file (TOML).
    count
        How many modes, the lowest first.
    output
        Folder for picture and numbers; the scene's name in this folder if not given.
    set_
        KEY=VALUE: another value for any key of the scene.
    run_
        Which run of a sweep, from 0.
    format_
        png (default), svg or pdf; may be given several times.
    timings
        Print the wall time of each stage, from the start of the command.
    """
    clock = command_timings()
    if count < 1:
        fail(f"--count: expected at least 1, found {count}")
    study = study_of(scene, set_, run_)
    folder = checked(output or Path(scene.stem))
    clock.mark("read")

    from lumpedcable.study.compiling import heard
    from lumpedcable.study.modes import NoEquilibriumError
    from lumpedcable.vibrations import study_modes

    with _told():
        clock.mark("load")
        try:
            with heard(clock):
                found = study_modes(study, count, run_)
        except NoEquilibriumError as error:
            fail(f"{scene}: {error}", 1)
        clock.mark("find")
        made = [*found.plot(folder, tuple(format_ or ["png"])), *found.save(folder)]
    found.report()
    for path in made:
        print(path)
    clock.mark("tell")
    if timings:
        print(*clock.lines(), sep="\n")


for command in (show.plot, fit.fit, fit.sensitivity, show.view, show.animate, show.export):
    app.command(command)
app.command(adopt.import_, name="import")


@app.command
def info(result: Path, /) -> None:
    """Say what a results file or study folder holds, how far it is, and how its runs ended.

    Parameters
    ----------
    result
        Results file (HDF5), finished or .partial, or the folder of a study.
    """
    from lumpedcable.results import describe

    with _told():
        print(describe(result))


@app.command
def check(
    scene: Path,
    /,
    *,
    set_: Set = None,
    steps: Annotated[bool, Parameter(negative="")] = False,
) -> None:
    """Validate a scene without running it; every fault is told at once.

    Parameters
    ----------
    scene
        Scene file (TOML).
    set_
        KEY=VALUE: another value for any key of the scene.
    steps
        Look for the state of rest as well, of the first thousand runs of a sweep, and tell how many
        steps each would take.
    """
    from lumpedcable.model.layout import layout_of
    from lumpedcable.scene import load_study
    from lumpedcable.scene.idle import idle_parts

    with _told():
        study = load_study(scene, set_ or [])
    scenes = list(islice(study.runs, CHECKED_RUNS))
    with _told():
        for one in scenes:
            layout_of(study, one)
    if any(one.dimensions is not None or one.steep or one.top_heavy for one in scenes):
        from lumpedcable.study.plan import common_coordinates  # loads jax, so only where needed

        with _told():
            common_coordinates(study, scenes)
    runs = len(study.runs)
    print(f"{scene}: ok, {runs} run{'' if runs == 1 else 's'}")
    for words in idle_parts(study.scene):
        print(f"  {words}")
    if steps:
        suit_device(study.scene.nodes * len(scenes))
        from lumpedcable.study.prospect import prospect_lines, prospect_of

        with _told():
            prospect = prospect_of(study, CHECKED_RUNS)
        print(*prospect_lines(prospect), sep="\n")


@app.command
def schema() -> None:
    """Print the JSON Schema of scene files, for editors."""
    import json

    from lumpedcable.scene import json_schema

    print(json.dumps(json_schema(), indent=2))


def main() -> None:
    """Entry point: bad arguments, a missing device or a lost output end in one message and a code."""
    # jax builds a program from a million small objects that all stay: to search them for garbage as
    # often as Python does by default takes a sixth of a short run
    gc.set_threshold(50_000, 50, 100)
    # what goes wrong in a compiler is raised as well; its alarms about time are no users' business
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
    try:
        with interruptible(), spoken():
            app([*map(at_home, sys.argv[1:])], exit_on_error=False, print_error=False)
    except UnusedCliTokensError as error:
        extra = " ".join(error.unused_tokens or [])
        fail(f"expected nothing more, found {extra!r}; see lumpedcable --help")
    except CycloptsError as error:
        fail(f"{str(error).strip()} See lumpedcable --help.")
    except KeyboardInterrupt:
        interrupted()
    except Exception as error:
        from lumpedcable.status import PlatformError

        if stopped():  # an import that Ctrl-C has cut short fails in its own words
            interrupted()
        if isinstance(error, PlatformError):
            fail(str(error))
        raise
