"""Programs compiled ahead are those that are called; what goes wrong with them is told by the call."""

import logging
import time
from threading import Thread

import jax
import numpy as np
import pytest
from engine_runs import run_text, study_of
from tiny_scene import TINY

from lumpedcable.study import ahead, run
from lumpedcable.study.run import run_study

FLOATING = """
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
surface = 0
[materials.hooke]
law = "linear"
EA = "1 MN"
[bodies.buoy]
mass = "1 t"
volume = "2 m3"
free = ["x", "z"]
position = [0, 0, "-0.5 m"]
points = { eye = [0, 0, "-0.5 m"] }
[lines.rope]
material = "hooke"
length = "10 m"
segments = SEGMENTS
mass = "1 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, "-10 m"] }
end = "buoy.eye"
[output]
duration = "4 ms"
every = "2 ms"
"""
PROGRAMS = "begin_batch", "advance_batch"
MIDDLE = 'breaks = "rope"\nplace = "5 m"'
SWEEP = '[sweep]\n"events.break.time" = ["10 ms", "20 ms", "30 ms"]\n'
# each with segments of its own: a program that is known already is not compiled
SCENES = {
    "one run": TINY,
    "three runs": TINY + SWEEP,
    "no fields": TINY.replace('quantities = ["position"]', 'keep = "summaries"'),
    "parts in the middle": TINY.replace('breaks = "rope.end"', MIDDLE),
    "float32": TINY.replace('waves = "plain"', 'waves = "plain"\ndtype = "float32"'),
    "adaptive": TINY.replace('waves = "plain"', 'method = "tsit5"'),
    "breaks at a tension": TINY.replace('"rope.end"\n', '"rope.start"\ntension = "10 kN"\n'),
    "floating body": FLOATING,
}


ALONE = pytest.mark.skipif(
    not ahead.ON_CPU or jax.device_count() > 1,
    reason="only of a batch on one CPU is anything foreseen",
)


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    """Whatever this machine has."""
    monkeypatch.setattr(ahead, "_cores", lambda: 2)


def of_segments(text, segments):
    return text.replace("segments = 8", f"segments = {segments}").replace("SEGMENTS", str(segments))


SELDOM = ("adaptive", "float32", "floating body", "parts in the middle")


@ALONE
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n in SELDOM else n for n in SCENES],
)
def test_what_is_compiled_ahead_is_what_is_called(caplog, tmp_path, monkeypatch, name):
    ours, foreseen = run.foresee, []
    monkeypatch.setattr(run, "foresee", lambda *given: foreseen.append(ours(*given)))
    text = of_segments(SCENES[name], 20 + list(SCENES).index(name))
    with jax.log_compiles(), caplog.at_level(logging.WARNING):
        outcomes = run_study(study_of(tmp_path, text), tmp_path / "result.h5")
    words = "\n".join(record.getMessage() for record in caplog.records)
    assert [words.count(f"XLA compilation of jit({name})") for name in PROGRAMS] == [1, 1]
    assert len(foreseen) == 1
    assert {outcome.status.name for outcome in outcomes} == {"OK"}


def test_a_fault_of_the_thread_is_no_fault_of_the_run(tmp_path, monkeypatch):
    text = of_segments(TINY, 9)
    right = run_text(tmp_path, text)["position"]

    def fails(*given):
        raise MemoryError("no room")

    monkeypatch.setattr(ahead.advance_batch, "lower", fails)
    np.testing.assert_array_equal(run_text(tmp_path, text)["position"], right)


def test_a_call_waits_for_what_is_done_ahead():
    order = []
    function = ahead.Foreseen(order.append)
    done = function.wait_for()

    def work():
        time.sleep(0.05)
        order.append("ahead")
        done()

    Thread(target=work).start()
    function("called")
    function("again")
    assert order == ["ahead", "called", "again"]


def test_calls_from_several_threads_all_wait():
    order = []
    function = ahead.Foreseen(order.append)
    done = [function.wait_for() for _ in range(50)]
    calls = [Thread(target=function, args=(k,)) for k in range(8)]
    for call in calls:
        call.start()
    time.sleep(0.02)
    assert order == []
    for one in done:
        one()
    for call in calls:
        call.join()
    assert sorted(order) == list(range(8))


def test_nothing_is_done_ahead_on_one_core(tmp_path, monkeypatch):
    monkeypatch.setattr(ahead, "_cores", lambda: 1)
    monkeypatch.setattr(ahead, "Thread", None)
    assert run_text(tmp_path, TINY).statuses == ["OK"]
