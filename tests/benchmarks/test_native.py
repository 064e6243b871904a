"""The default method in C: an implementation of its own, which must come to the same."""

import numpy as np
import pytest

from benchmarks.engine import Runner, scene_of
from benchmarks.native.line import compiler, go, parameters

pytestmark = pytest.mark.skipif(compiler() is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def engine():
    """The engine's run at 450 kN, 5 ms: its line, steps and end."""
    runner = Runner(scene_of("segments=50", "rope.end.held.pretension=450 kN"))
    found, _ = runner.histories(runner.every, runner.steps, runner.count)
    line = runner.ready.model.lines["rope"]
    strain = float(np.asarray(line.reference_strain)[0, 0])
    return runner, parameters(line, 5e-3), strain, found


@pytest.mark.parametrize("flags", ["exact", "fast"])
def test_engine_and_c_agree(engine, flags):
    runner, numbers, strain, found = engine
    steps, dt = runner.steps * runner.count, runner.every / runner.steps
    run = go(numbers, np.full(3, strain), np.full(3, 450e3), 50, steps, dt, flags=flags, threads=2)
    # two orders of summation, over some hundred steps and a line that folds up
    np.testing.assert_allclose(run.displacement, found.displacement, rtol=1e-9)
    assert np.all(run.peak_speed >= np.max(np.abs(found.velocity)) * (1.0 - 1e-9))


def test_the_process_keeps_its_denormal_numbers(engine):
    _, numbers, strain, _ = engine
    go(numbers, np.array([strain]), np.array([450e3]), 50, 10, 1e-5, flags="fast")
    smallest = np.array([np.finfo(float).tiny])
    assert (smallest / 2.0)[0] > 0.0
    assert float("1e-320") > 0.0


def test_another_line_would_be_found(engine):
    runner, numbers, strain, found = engine
    steps, dt = runner.steps * runner.count, runner.every / runner.steps
    heavier = numbers | {"mass": 1.001 * numbers["mass"]}
    run = go(heavier, np.array([strain]), np.array([450e3]), 50, steps, dt)
    assert abs(run.displacement[0] / found.displacement - 1.0) > 1e-5
