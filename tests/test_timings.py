"""Where the time of a command goes: stages without a gap, compiling apart."""

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
    found = Timings()
    begun = time.perf_counter()
    with heard(found):
        jax.jit(lambda x: jnp.sin(x) + 17.25)(1.0)
    found.mark("call")
    past = time.perf_counter() - begun
    assert 0.0 < found.stages["compile"] <= past
    assert sum(found.stages.values()) == pytest.approx(past, abs=0.01)
    before = dict(found.stages)
    jax.jit(lambda x: jnp.sin(x) + 18.25)(1.0)
    found.mark("another")
    assert found.stages["compile"] == before["compile"]


@pytest.mark.parametrize(
    ("words", "stages"),
    [
        (["run"], ["start up", "read", "load", "lay out", "statics", "advance", "write", "tell"]),
        (["study", "--cores", "1"], ["start up", "read", "load", "lay out", "compute", "tell"]),
        (["modes", "-n", "1"], ["start up", "read", "load", "find", "tell"]),
    ],
)
def test_the_stages_of_a_command_are_all_of_its_time(tmp_path, words, stages):
    good_scenes.write(tmp_path, SMALL)
    command, *more = words
    begun = time.perf_counter()
    said = say(tmp_path, command, "scene.toml", *more, "--timings")
    past = time.perf_counter() - begun
    assert said.code == 0
    found = [(name, float(seconds)) for name, seconds in STAGE.findall(said.out)]
    assert set(stages) | {"compile", "total"} <= {name for name, _ in found}
    *each, (last, total) = found
    assert last == "total"
    assert total == pytest.approx(sum(seconds for _, seconds in each), abs=0.01 * len(found))
    # the first command of a process counts what was loaded before it as well
    assert total > 0.9 * past
