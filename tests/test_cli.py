"""The command line: help without jax, a scene from end to end, pipes and interruptions."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import good_scenes
import h5py
import numpy as np
import pytest
from command_line import ROOT, SMALL, process, refused, say

import lumpedcable

# a fit is no scene
CONFIGS = sorted(p for p in (ROOT / "configs").rglob("*.toml") if p.parent.name != "fit")
COMMANDS = ["run", "plot", "modes", "info", "check", "schema"]


# --- help ----------------------------------------------------------------------------------------


def test_help_of_every_command_comes_without_jax():
    code = f"""
import sys
from lumpedcable.cli import main
for command in [[], *([name] for name in {COMMANDS})]:
    sys.argv = ["lumpedcable", *command, "--help"]
    try:
        main()
    except SystemExit as left:
        assert not left.code, command
print(sorted({{"jax", "numpy", "h5py", "matplotlib"}} & set(sys.modules)))
"""
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    for command in COMMANDS:
        assert f"Usage: lumpedcable {command}" in ran.stdout
    assert ran.stdout.strip().endswith("[]")


def test_version(tmp_path):
    assert say(tmp_path, "--version").out.strip() == lumpedcable.__version__


def test_the_module_is_the_command():
    ran = subprocess.run(
        [sys.executable, "-m", "lumpedcable", "--version"], capture_output=True, text=True, cwd=ROOT
    )
    assert (ran.returncode, ran.stdout.strip(), ran.stderr) == (0, lumpedcable.__version__, "")


# --- from end to end -----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A folder in which the small scene has been run, and what was said."""
    folder = tmp_path_factory.mktemp("small")
    good_scenes.write(folder, SMALL)
    return folder, say(folder, "run", "scene.toml", "--timings")


def test_run_writes_a_file_named_after_the_scene_and_a_table(ran):
    folder, said = ran
    assert (said.code, said.err) == (0, "")
    assert sorted(p.name for p in folder.glob("scene.*")) == ["scene.h5", "scene.toml"]
    assert "A rope" in said.out
    assert re.search(r"^ +0 +45 kN .* ok *$", said.out, re.MULTILINE)
    assert re.search(r"^ +1 +180 kN .* ok *$", said.out, re.MULTILINE)
    assert "paper: nobody." in said.out
    assert "written: scene.h5" in said.out
    assert re.search(r"^ +advance +\d+\.\d\d s$", said.out, re.MULTILINE)
    with h5py.File(folder / "scene.h5") as file:
        assert file["lines/rope/position"].shape == (2, 3, 21, 3)
        assert file.attrs["scene"] == SMALL


def test_info_tells_of_the_file(ran):
    said = say(ran[0], "info", "scene.h5")
    assert (said.code, said.err) == (0, "")
    assert re.search(r"^title +A rope$", said.out, re.MULTILINE)
    assert re.search(r"^state +complete$", said.out, re.MULTILINE)


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_plot_names_the_pictures_that_it_makes(ran, tmp_path, kind):
    said = say(ran[0], "plot", "scene.h5", "-o", tmp_path / "pictures", "--format", kind)
    assert (said.code, said.err) == (0, "")
    made = [Path(line) for line in said.out.splitlines()]
    assert made == [tmp_path / "pictures" / path.name for path in made]
    assert {path.suffix for path in made} == {f".{kind}"}
    assert {"tension", "velocity", "end_speed", "xt", "energy"} <= {path.stem for path in made}
    assert all(path.stat().st_size > 5000 for path in made)


def test_a_path_below_home_is_found_where_the_shell_leaves_the_tilde(ran, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))
    for output in (["--output=~/a.csv"], ["-o", "~/b.csv"], ["--output", "~/c.csv"]):
        assert say(ran[0], "export", "scene.h5", "--to", "csv", *output).code == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.csv", "b.csv", "c.csv"]
    assert not (ran[0] / "~").exists()


def test_plot_makes_a_folder_named_after_the_file(ran):
    said = say(ran[0], "plot", "scene.h5")
    assert said.out.splitlines()[0].startswith("scene" + os.sep)
    assert (ran[0] / "scene" / "energy.png").is_file()


def test_set_changes_the_scene_and_is_recorded(ran, tmp_path):
    changes = ["--set", "pretension=[90 kN, 120 kN]", "--set", "break.time=1 ms"]
    said = say(ran[0], "run", "scene.toml", "-o", tmp_path / "new" / "r.h5", "--plot", *changes)
    assert said.code == 0
    # with --plot the pictures are drawn at once, beside the file
    assert str(tmp_path / "new" / "r" / "energy.png") in said.out.splitlines()
    assert (tmp_path / "new" / "r" / "energy.png").is_file()
    with h5py.File(tmp_path / "new" / "r.h5") as file:
        assert file["held_pretension"][()].tolist() == [90e3, 120e3]
        assert file["lines/rope/tension"][:, 0, -1] == pytest.approx([90e3, 120e3], rel=1e-9)
        assert json.loads(file.attrs["overrides"]) == changes[1::2]


def test_a_study_of_which_no_run_comes_to_its_end_exits_with_1(tmp_path):
    # a free line under gravity falls for ever: there is nothing to start from
    text = SMALL.replace("start = { fixed = [0, 0, 0] }", 'start = "free"')
    good_scenes.write(tmp_path, text)
    said = say(tmp_path, "run", "scene.toml")
    assert said.code == 1
    assert "runs 0 and 1: no static equilibrium was found to start from" in said.out
    assert (tmp_path / "scene.h5").is_file()


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_the_scenes_of_the_house_are_right(tmp_path, path):
    said = say(tmp_path, "check", path)
    assert (said.code, said.err) == (0, "")
    assert re.fullmatch(rf"{re.escape(str(path))}: ok, \d+ runs?\n", said.out)


def test_check_counts_the_runs_of_an_override(ran):
    said = say(ran[0], "check", "scene.toml", "--set", "rope.length=[40 m, 50 m, 60 m]")
    assert said.out == "scene.toml: ok, 6 runs\n"


def test_check_names_what_nothing_uses(tmp_path):
    more = """
[materials.spare]
law = "linear"
EA = "1 MN"

[bodies.ball]
mass = "10 kg"
"""
    good_scenes.write(tmp_path, SMALL + more)
    said = say(tmp_path, "check", "scene.toml")
    assert said.code == 0
    first, *rest = said.out.splitlines()
    assert first.startswith("scene.toml: ok")
    assert rest == [
        '  materials.spare is not used: no line is of "spare"',
        '  bodies.ball is not there: no line ends at "ball", a point mass',
    ]


def test_schema_is_json(tmp_path):
    said = say(tmp_path, "schema")
    assert set(json.loads(said.out)["properties"]) >= {"lines", "materials", "sweep", "output"}


# --- as a process of its own ---------------------------------------------------------------------


def test_a_reader_that_has_seen_enough_is_no_error(tmp_path):
    with process(tmp_path, "schema") as ended:
        ended.stdout.close()
        assert ended.stderr.read() == ""
        assert ended.wait(timeout=60) == 128 + signal.SIGPIPE


def stopped(folder, how):
    """What a long run says when it is stopped after its first output times, and its exit code."""
    good_scenes.write(folder, SMALL)
    with process(folder, "run", "scene.toml", "--set", "duration=40 s") as started:
        _wait_for(lambda: _flushed(folder / "scene.h5.partial"), started)
        started.send_signal(how)
        out, err = started.communicate(timeout=60)
    assert out == ""
    return err, started.returncode


def _wait_for(condition, started, patience=120.0):
    """Wait until something holds; the process must live until then, and not for so long (s)."""
    deadline = time.monotonic() + patience
    while not condition():
        assert started.poll() is None, started.stderr.read()
        assert time.monotonic() < deadline, "it has not come about"
        time.sleep(0.2)


@pytest.mark.parametrize(
    ("how", "word", "code"),
    [
        pytest.param(signal.SIGINT, "interrupted", 130, marks=pytest.mark.slow),
        (signal.SIGTERM, "terminated", 143),
    ],
)
def test_an_interrupted_run_keeps_what_it_has(tmp_path, how, word, code):
    said = stopped(tmp_path, how)
    # on a machine that has much to do a bookmark was due before there was something to stop at
    noted = (tmp_path / "scene.h5.bookmark").exists() * "; the same command goes on with it"
    assert said == (f"{word}; what was finished is in scene.h5.partial{noted}\n", code)
    _check_unfinished(tmp_path)


@pytest.mark.parametrize(
    "wait",
    [
        pytest.param(1.0, id="compiling"),
        pytest.param(12.0, id="stepping", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_a_run_of_a_single_long_interval_can_be_interrupted(tmp_path, wait, monkeypatch):
    monkeypatch.setenv("LUMPEDCABLE_CACHE", "off")
    good_scenes.write(tmp_path, SMALL)
    long = ["--set", "output.duration=5e6 s", "--set", "output.every=5e6 s"]  # an hour of steps
    with process(tmp_path, "run", "scene.toml", *long) as started:
        _wait_for((tmp_path / "scene.h5.partial").exists, started)
        with pytest.raises(subprocess.TimeoutExpired):
            started.wait(timeout=wait)
        started.send_signal(signal.SIGINT)
        _, err = started.communicate(timeout=60)
    told = "interrupted; what was finished is in scene.h5.partial\n"
    assert (err, started.returncode) == (told, 130)


def test_a_killed_run_has_kept_what_it_had(tmp_path):
    assert stopped(tmp_path, signal.SIGKILL) == ("", -signal.SIGKILL)
    _check_unfinished(tmp_path)


def _check_unfinished(folder):
    said = say(folder, "info", "scene.h5.partial")
    assert (said.code, said.err) == (0, "")
    state = (
        r"^state +incomplete: 0 of 2 runs written to the end, 2 up to [1-9][\d.]* m?s or further$"
    )
    assert re.search(state, said.out, re.MULTILINE), said.out


def _flushed(partial):
    """Whether the file says that it holds an output time after the start.

    Only a flush says so: values can reach the disk before, and mean nothing then.
    """
    try:
        with h5py.File(partial, "r", locking=False) as file:
            return bool(np.all(file["written"][...] > 1))
    except (OSError, KeyError):
        return False


@pytest.mark.parametrize(
    "arguments",
    [
        ("plot", "--run"),
        ("animate", "--fps"),
        ("view", "--port"),
        ("study", "--shard"),
        ("modes", "-n"),
    ],
    ids=" ".join,
)
@pytest.mark.parametrize("number", ["1.6", "2e0", "two"])
def test_a_number_that_counts_is_whole(tmp_path, arguments, number):
    command, option = arguments
    told = refused(tmp_path, command, "any", option, number)
    assert f"{option}: expected a whole number, found {number!r}" in told
    assert told.count("\n") == 1
