"""How commands end when somebody interrupts them, or when what they print or compute on is not there."""

import gc
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from unittest import mock

import good_scenes
import h5py
import pytest
import synthetic_result
from command_line import ROOT, SMALL, files, process, python, say

from lumpedcable.commands import console, interrupts
from lumpedcable.commands.console import suit_device
from lumpedcable.commands.interrupts import interruptible, stopped
from lumpedcable.results import describe
from lumpedcable.scene import load_study


def press(*_, **__):
    signal.raise_signal(signal.SIGINT)


def terminate(*_, **__):
    signal.raise_signal(signal.SIGTERM)


# --- Ctrl-C --------------------------------------------------------------------------------------

# what a command calls, and the command
CALLED = {
    "lumpedcable.view.plot_result": ["plot", "x.h5"],
    "lumpedcable.view.animate_result": ["animate", "x.h5"],
    "lumpedcable.export.export_result": ["export", "x.h5", "--to", "csv"],
    "lumpedcable.results.describe": ["info", "x.h5"],
    "lumpedcable.scene.load_study": ["check", "x.toml"],
    "lumpedcable.study.modes.find_modes": ["modes", "scene.toml"],
    "lumpedcable.fits.study_sensitivity": ["sensitivity", "scene.toml"],
    "lumpedcable.fitting.load.load_fit": ["fit", "fit.toml"],
}


@pytest.mark.parametrize("called", CALLED)
def test_every_command_that_is_interrupted_says_so(tmp_path, called):
    good_scenes.write(tmp_path, SMALL)
    before = signal.getsignal(signal.SIGINT)  # of tests in the background, that it is ignored
    # nobody is to leave these tests in the way of an interrupted command
    with mock.patch(called, press), mock.patch.object(console.atexit, "register"):
        said = say(tmp_path, *CALLED[called])
    assert said == (130, "", "interrupted\n")
    assert signal.getsignal(signal.SIGINT) is before


def test_a_command_that_a_scheduler_ends_says_so(tmp_path):
    before = signal.getsignal(signal.SIGTERM)
    register = mock.patch.object(console.atexit, "register")
    with mock.patch("lumpedcable.results.describe", terminate), register as registered:
        assert say(tmp_path, "info", "x.h5") == (143, "", "terminated\n")
    assert registered.call_args.args[1] == 143
    assert signal.getsignal(signal.SIGTERM) is before


def test_an_import_that_is_cut_short_is_an_interruption(tmp_path):
    def cut(*_):
        with pytest.raises(KeyboardInterrupt):
            press()
        raise ImportError("half of it")

    register = mock.patch.object(console.atexit, "register")
    with mock.patch("lumpedcable.results.describe", cut), register:
        assert say(tmp_path, "info", "x.h5") == (130, "", "interrupted\n")


@contextmanager
def pressed_in_a_collection():
    """Press it once inside of a callback of the garbage collector, where Python drops it."""
    pressed = []  # collections may come by themselves too

    def collect(phase, info):
        if phase == "start" and not pressed:
            pressed.append(phase)
            press()

    gc.callbacks.append(collect)
    try:
        gc.collect(0)  # all that other tests have left behind would take seconds
        yield
    finally:
        gc.callbacks.remove(collect)
    assert pressed


def test_an_interruption_that_is_dropped_is_raised_again():
    def go_on():
        with interruptible(), pressed_in_a_collection():
            time.sleep(60.0)

    with pytest.raises(KeyboardInterrupt):
        go_on()


def test_who_has_heard_of_it_is_not_interrupted_again():
    # the moment of the second time is this test's to choose
    with mock.patch.object(interrupts.threading, "Timer") as timer:
        with interruptible(), pressed_in_a_collection():
            (after, again), _ = timer.call_args
            assert stopped()
            again()
            time.sleep(0.01)

        def go_on():
            with interruptible(), pressed_in_a_collection():
                again()
                time.sleep(0.01)

        with pytest.raises(KeyboardInterrupt):
            go_on()
    assert after == interrupts.AGAIN
    timer.return_value.start.assert_called()


SLOW = """
import sys, time
from lumpedcable.commands.interrupts import interruptible
with interruptible():
    try:
        print("ready", flush=True)
        time.sleep(60)
    except KeyboardInterrupt:
        print("once", flush=True)
        time.sleep(60)
"""


@pytest.mark.parametrize(
    ("how", "told"),
    [(signal.SIGINT, (130, "interrupted\n")), (signal.SIGTERM, (143, "terminated\n"))],
)
def test_the_second_press_leaves_at_once(how, told):
    with python("-c", SLOW) as started:
        for word in ("ready\n", "once\n"):
            assert started.stdout.readline() == word
            started.send_signal(how)
        _, err = started.communicate(timeout=20)
    assert (started.returncode, err) == told


# --- standard output -----------------------------------------------------------------------------


LOST = "cannot print to standard output: "


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is Linux's")
@pytest.mark.parametrize(
    ("command", "code", "told"),
    [
        ("run scene.toml -o v.h5 >&-", 1, f"{LOST}it is closed\n"),
        ("info nothing.h5 >&-", 2, "no such file: nothing.h5\n"),
        ("schema > /dev/full", 1, f"{LOST}No space left on device\n"),
        ("check scene.toml > /dev/full", 1, f"{LOST}No space left on device\n"),
    ],
)
def test_what_nobody_can_read_is_told(tmp_path, command, code, told):
    good_scenes.write(tmp_path, SMALL)
    # in the place of the shell, so that it does not outlive the patience for it
    ended = subprocess.run(
        f"exec {sys.executable} -m lumpedcable {command}", shell=True, cwd=tmp_path, text=True,
        stderr=subprocess.PIPE, timeout=120, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (code, told)
    if command.startswith("run"):
        assert "complete" in describe(tmp_path / "v.h5")


# --- a device ------------------------------------------------------------------------------------


@pytest.mark.parametrize("asked", ["cuda", pytest.param("abacus", marks=pytest.mark.slow)])
def test_a_platform_that_is_not_there_is_told(tmp_path, monkeypatch, asked):
    good_scenes.write(tmp_path, SMALL)
    monkeypatch.setenv("JAX_PLATFORMS", asked)
    before = files(tmp_path)
    with process(tmp_path, "run", "scene.toml") as ended:
        out, err = ended.communicate(timeout=60)
    assert (ended.returncode, out) == (2, "")
    assert err == f"JAX_PLATFORMS: expected cpu, which jax finds here, found '{asked}'\n"
    assert files(tmp_path) == before


@pytest.mark.parametrize(
    ("nodes", "runs", "set_", "then"),
    [
        (100, 8, None, "cpu"), (100, 1000, None, None), (10_000, 1, None, None),
        (100, 8, "cuda", "cuda"), (100, 1000, "cuda", "cuda"),
    ],
)  # fmt: skip
def test_few_nodes_leave_a_gpu_alone(tmp_path, monkeypatch, nodes, runs, set_, then):
    pulls = [f"{45 + 0.1 * k:g} kN" for k in range(runs)]
    study = load_study(
        good_scenes.write(tmp_path, SMALL),
        [f"lines.rope.segments={nodes}", f"lines.rope.end.held.pretension={pulls}"],
    )
    environ = {} if set_ is None else {"JAX_PLATFORMS": set_}
    monkeypatch.setattr(console.os, "environ", environ)
    suit_device(study.scene.nodes * len(study.runs))
    assert environ.get("JAX_PLATFORMS") == then


def test_one_run_of_few_nodes_leaves_a_gpu_alone(tmp_path, monkeypatch):
    scene = good_scenes.write(tmp_path, SMALL)
    monkeypatch.setattr(console.os, "environ", environ := {})
    console.study_of(scene, ["lines.rope.segments=100"], 0)
    assert environ.get("JAX_PLATFORMS") == "cpu"
    environ.clear()
    console.study_of(scene, ["lines.rope.segments=10000"], 0)
    assert environ == {}


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_letters_that_a_terminal_does_not_know_are_replaced(tmp_path, encoding):
    title = "Größe σ, 2×"
    path = synthetic_result.snapback(tmp_path / "r.h5", segments=4)
    with h5py.File(path, "r+") as file:
        file.attrs["title"] = title
    ended = subprocess.run(
        [sys.executable, "-m", "lumpedcable", "info", "r.h5"], cwd=tmp_path, capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": encoding},
    )  # fmt: skip
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert title.encode(encoding, "replace") in ended.stdout
