"""Commands run as a user runs them, in this process or in one of their own."""

import os
import subprocess
import sys
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import good_scenes

from lumpedcable.cli import main
from lumpedcable.results import open_result

ROOT = Path(__file__).parents[1]
# The rope of the scene tests, short and coarse: 2 runs, 20 segments, 3 output times.
SMALL = (
    good_scenes.ROPE.replace("segments = 200", "segments = 20")
    .replace('"200 ms"', '"4 ms"')
    .replace('"1 ms"', '"2 ms"')
)


class Said(NamedTuple):
    """How a command ended and what it said."""

    code: int
    out: str
    err: str


def say(folder, *arguments):
    """Run a command in a folder, as the entry point does."""
    out, err, code = StringIO(), StringIO(), 0
    argv = mock.patch.object(sys, "argv", ["lumpedcable", *map(str, arguments)])
    with chdir(folder), argv, redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as left:
            code = left.code or 0
    return Said(code, out.getvalue(), err.getvalue())


def files(folder):
    return {p.relative_to(folder): p.stat().st_mtime_ns for p in folder.rglob("*") if p.is_file()}


def refused(folder, *arguments):
    """The message of a command that must fail, say why, and leave the folder as it was."""
    before = files(folder)
    said = say(folder, *arguments)
    assert said.code == 2
    assert said.out == ""
    assert "Traceback" not in said.err
    assert files(folder) == before
    return said.err


@contextmanager
def python(*arguments, **options):
    """A Python of its own with pipes of text; neither it nor a pipe outlives the block."""
    with subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    ) as child:
        try:
            yield child
        finally:
            child.kill()


def let_go(children):
    """Let processes that say "ready" and wait for a line go on at once; what each has to complain of."""
    for one in children:
        assert one.stdout.readline() == "ready\n"
    for one in children:
        one.stdin.write("go\n")
        one.stdin.flush()
    return [one.communicate(timeout=60)[1] for one in children]


def process(folder, *arguments, **options):
    """A command in a process of its own, which does not outlive the block."""
    return python("-m", "lumpedcable", *arguments, cwd=folder, **options)


def address(server):
    """The address that a server tells first of all."""
    said = server.stdout.readline()
    assert said, server.stderr.read()
    return said.split()[0]


def rest_of(folder, text):
    """The numbers of the only cable of a scene at rest, which is run as a user does."""
    (folder / "scene.toml").write_text(text)
    said = say(folder, "run", "scene.toml", "-o", "r.h5")
    assert (said.code, said.err) == (0, "")
    with open_result(folder / "r.h5") as result:
        return {key: float(value[0]) for key, value in result.rest(result.cables[0]).items()}
