"""Where the time of a command goes: stages without a gap, compiling apart."""

import importlib
import re
import time

import jax
import jax.numpy as jnp
import pytest
from command_line import SMALL, good_scenes, say

from lumpedcable import timings
from lumpedcable.study.compiling import heard
from lumpedcable.timings import Timings

STAGE = re.compile(r"^ *([a-z ]+?) +(\d+\.\d\d) s$", re.MULTILINE)


@pytest.fixture
def clock(monkeypatch):
    """The time (s) that timings see, to be set."""
    now = [0.0]
    monkeypatch.setattr(timings, "perf_counter", lambda: now[0])
    return now


def test_compiling_is_taken_out_of_the_stage_that_it_is_in(clock):
    found = Timings()
    # 1 to 4 s, told of inside of 0.5 to 5 s; 5 to 6 s in another thread, meanwhile 5.5 to 7 s
    for now, seconds in ((4.0, 3.0), (5.0, 4.5), (6.0, 1.0), (7.0, 1.5)):
        clock[0] = now
        found.compiled(seconds)
    clock[0] = 10.0
    found.mark("advance")
    clock[0] = 11.0
    found.mark("write")
    clock[0] = 13.0
    found.mark("advance")
    assert found.stages == pytest.approx({"compile": 6.5, "advance": 5.5, "write": 1.0})
    assert [line.split() for line in found.lines()][-1] == ["total", "13.00", "s"]


def test_what_jax_compiles_is_heard_and_no_longer_than_asked():
    before = time.perf_counter()
    found = Timings()
    begun = time.perf_counter()
    with heard(found):
        jax.jit(lambda x: jnp.sin(x) + 17.25)(1.0)
    ended = time.perf_counter()
    found.mark("call")
    after = time.perf_counter()
    every = sum(found.stages.values())
    assert ended - begun <= every <= after - before
    assert 0.0 < found.stages["compile"] <= every
    before = dict(found.stages)
    jax.jit(lambda x: jnp.sin(x) + 18.25)(1.0)
    found.mark("another")
    assert found.stages["compile"] == before["compile"]


@pytest.mark.parametrize(
    ("words", "stages", "last"),
    [
        (["run"], ["lay out", "statics", "advance", "write"], "study.report.results_table"),
        (["study", "--cores", "1"], ["lay out", "compute"], "study.shards_report.describe"),
        (["modes", "-n", "1"], ["find"], "study.modes_report.modes_table"),
    ],
)
def test_the_stages_of_a_command_are_all_of_its_time(tmp_path, monkeypatch, words, stages, last):
    good_scenes.write(tmp_path, SMALL)
    # the first and the last thing that it does take 100 s each, by the clock that the stages see
    slept = []
    monkeypatch.setattr(timings, "perf_counter", lambda: time.perf_counter() + 100.0 * len(slept))
    # loaded before they are changed: what is loaded later on would keep what they are changed to
    both = [
        (importlib.import_module(f"lumpedcable.{module}"), name)
        for module, _, name in (which.rpartition(".") for which in (last, "scene.load_study"))
    ]

    def slow(real):
        def slowly(*arguments, **more):
            slept.append(real)
            return real(*arguments, **more)

        return slowly

    for module, name in both:
        monkeypatch.setattr(module, name, slow(getattr(module, name)))
    # the first command of a process counts what was loaded before it as well: here none is the first
    monkeypatch.setattr(timings, "_loaded", [])
    command, *more = words
    begun = time.perf_counter()
    said = say(tmp_path, command, "scene.toml", *more, "--timings")
    past = time.perf_counter() - begun
    assert said.code == 0
    assert len(slept) == 2
    found = [(name, float(seconds)) for name, seconds in STAGE.findall(said.out)]
    *each, (name, total) = found
    assert name == "total"
    told = dict(each)
    assert {"start up", "read", "load", *stages, "tell", "compile"} <= set(told)
    assert min(told["read"], told["tell"]) >= 100.0
    rounding = 0.01 * len(found)
    assert total == pytest.approx(sum(told.values()), abs=rounding)
    assert 200.0 <= total <= 200.0 + past + rounding
