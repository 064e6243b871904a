"""What the commands share: how they fail, what they take. Imports nothing that takes time."""

from __future__ import annotations

import atexit
import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn

from cyclopts import Parameter, Token

from lumpedcable.commands.interrupts import ended_by

__all__ = [
    "Formats",
    "OneRun",
    "Output",
    "Set",
    "SomeRun",
    "SomeWhole",
    "Timed",
    "Whole",
    "at_home",
    "bare_name",
    "checked",
    "fail",
    "interrupted",
    "share_cores",
    "spoken",
    "study_of",
    "suit_device",
    "told",
]

FEW_NODES = 5000
"""Of all runs: a step of them takes a core 45 us, which on a GPU a step of one takes."""

Timed = Annotated[
    bool,
    Parameter(
        name="--timings",
        help="Print the wall time of each stage, from the start of the command.",
        negative="",
    ),
]
Output = Annotated[Path | None, Parameter(name=["--output", "-o"])]
Formats = Annotated[list[str] | None, Parameter(name="--format", negative="")]


def _whole(kind: Any, tokens: Sequence[Token]) -> int:
    """The number of an option that counts something; cyclopts would round 1.6."""
    (token,) = tokens
    try:
        return int(token.value)
    except ValueError:
        raise ValueError(f"expected a whole number, found {token.value!r}.") from None


Whole = Annotated[int, Parameter(converter=_whole)]
SomeWhole = Annotated[int | None, Parameter(converter=_whole)]
OneRun = Annotated[Whole, Parameter(name="--run")]
SomeRun = Annotated[SomeWhole, Parameter(name="--run")]
Set = Annotated[
    list[str] | None,
    Parameter(
        name="--set",
        help='KEY=VALUE: another value for any key of the scene, e.g. --set "break.time=50 ms". '
        "A dotted path or its unmistakable end; may be given several times.",
        negative="",
    ),
]


def fail(message: str, code: int = 2) -> NoReturn:
    """Print what is wrong and leave."""
    print(message, file=sys.stderr)
    raise SystemExit(code)


def at_home(argument: str) -> str:
    """An argument with the user's home in the place of ~, which shells leave in --output=~/x.h5."""
    name, equals, value = (
        argument.partition("=") if argument.startswith("-") else ("", "", argument)
    )
    return f"{name}{equals}{os.path.expanduser(value)}" if value.startswith("~") else argument


def bare_name(result: Path) -> str:
    """What files made of results are named after: a study's folder, or a file's name without its end."""
    if result.is_dir():
        return result.resolve().name  # dots and all, also of the folder "."
    return Path(result.name.removesuffix(".partial")).stem


def checked(folder: Path) -> Path:
    """A folder for what a command makes, or the end of it before it has computed anything."""
    from lumpedcable.results.target import check_folder

    with told():
        check_folder(folder)
    return folder


def interrupted(left: str = "") -> NoReturn:
    """Say that Ctrl-C or SIGTERM has ended the command and what is left, and leave.

    Without a farewell to libraries: where jax was compiling, a thread of its own goes on with that, and
    crashes once jax has put away what it needs.
    """
    word, code = ended_by()
    atexit.register(_leave, code)  # called before those that are registered already
    fail("; ".join(filter(None, [word, left])), code)


def _leave(code: int) -> NoReturn:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def share_cores(cores: int | None) -> None:
    """Let jax have so many cores of this machine as devices, all that the process may use if None.

    It reads this once, when it is imported. Who has said it in XLA_FLAGS has said it.
    """
    flags, name = os.environ.get("XLA_FLAGS", ""), "--xla_force_host_platform_device_count"
    if name in flags:
        return
    mine = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    os.environ["XLA_FLAGS"] = f"{flags} {name}={cores or mine or 1}".strip()


def suit_device(nodes: int) -> None:
    """Let runs that have few nodes altogether go to the processor, whatever else is there.

    A GPU waits for its kernels as long as a core takes for a step of some thousand nodes (`FEW_NODES`),
    and its compiler takes longer. jax reads this once, when it is imported; who has said it in
    JAX_PLATFORMS has said it.
    """
    if nodes < FEW_NODES:
        os.environ.setdefault("JAX_PLATFORMS", "cpu")


@contextmanager
def spoken() -> Iterator[None]:
    """What is printed meanwhile reaches its reader, or the command ends with a line that says so."""
    closed = sys.stdout is None
    if closed:
        # first of all, or the first file that is opened takes its place
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    elif isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors == "strict":
        # a letter that this terminal does not know is no reason to end; standard error spells it out
        sys.stdout.reconfigure(errors="replace")
    try:
        try:
            yield
        except SystemExit as left:
            if left.code or not closed:
                raise
        finally:
            sys.stdout.flush()
    except OSError as error:
        if not _mute():
            raise
        # leave without another complaint
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            raise SystemExit(128 + 13) from None  # the reader (head, less) has seen enough
        fail(f"cannot print to standard output: {error.strerror}", 1)
    if closed:
        fail("cannot print to standard output: it is closed", 1)


def _mute() -> bool:
    """Whether nothing can be printed; a line of its own, since what failed may be gone by now."""
    try:
        print(flush=True)
    except OSError:
        return True
    return False


@contextmanager
def told() -> Iterator[None]:
    """What a user can mend ends in a message and exit code 2, not in a traceback."""
    from lumpedcable.results.errors import OutputError, ResultError
    from lumpedcable.scene import SceneError

    try:
        yield
    except (SceneError, OutputError, ResultError) as error:
        fail(str(error))
    except MemoryError as error:
        fail(f"not enough memory for so many runs, nodes and output times: {error}".rstrip(": "))


def study_of(scene: Path, changes: list[str] | None, run: int):
    """A study that has a run of that number, or the end; for that run few nodes leave a GPU alone."""
    from lumpedcable.scene import load_study

    with told():
        study = load_study(scene, changes or [])
    runs = len(study.runs)
    if not 0 <= run < runs:
        expected = f"a run from 0 to {runs - 1}" if runs > 1 else "0, the scene's only run"
        fail(f"--run: expected {expected}, found {run}")
    suit_device(study.scene.nodes)
    return study
