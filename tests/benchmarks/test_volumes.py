"""The finite volumes are right where there is an exact answer, and so are the stored references."""

from dataclasses import replace

import numpy as np
import pytest
from nylon_line import RUNS

from benchmarks import reference
from benchmarks.cases import HELD_OUT, MAIN
from benchmarks.engine import scene_of
from benchmarks.measures import Errors, errors, relative
from benchmarks.problem import line_of
from benchmarks.volumes import Cells, solve
from lumpedcable.exact import LinearRelease

DRY = replace(line_of(scene_of()), drag=0.0)
HOOKE = replace(DRY, law=(0.0, 1.0, 0.0, 0.0, 1.5e6), cut=False, pull=150e3)


@pytest.mark.parametrize("run", RUNS, ids=lambda run: f"{run.T0 / 1e3:g} kN")
def test_released_at_once_the_end_gets_its_exact_speed(run):
    line = replace(DRY, pull=run.T0, break_time=0.0)
    assert line.strain(line.pull) == pytest.approx(run.e0, rel=1e-9)
    found = solve(line, 200, 0.02, 1e-3)
    # the start is some cells long: 2 ms at 45 kN, and shocks are of first order in the cell, 1/200
    assert found.velocity[3:].mean() == pytest.approx(-run.end_speed, rel=5e-3)
    assert found.velocity[3:].mean() != pytest.approx(-1.02 * run.end_speed, rel=5e-3)


def test_a_shock_runs_at_its_own_speed():
    run, cells = RUNS[3], 400
    mesh = Cells(replace(DRY, pull=run.T0, break_time=0.0), cells)
    dt, t = 0.9 * mesh.width / mesh.fastest, 0.0
    while t < 0.04:
        mesh.step(t, dt)
        t += dt
    middle = 0.5 * (run.e0 + run.tangent)
    front = 60.0 - mesh.width * np.count_nonzero(mesh.strain > middle)
    # found to a cell
    assert front == pytest.approx(run.shock_speed * t, abs=1.5 * mesh.width)
    # the sound ahead of the shock is slower, the sound behind it as fast
    assert front > 1.2 * run.c0 * t


def test_second_order_on_a_linear_line_with_reflections():
    exact = LinearRelease(HOOKE.length, 1.5e6, HOOKE.mass, HOOKE.pull, HOOKE.break_time)
    distance = []
    for cells in (100, 400):
        found = solve(HOOKE, cells, 0.2, 1e-3)
        distance.append(relative(found.tension, exact.wall_tension(found.time)))
        moved = exact.end_displacement(found.time[-1])
        assert found.displacement == pytest.approx(-moved, rel=5e-3)
    # second order where it is smooth, cut down at extrema and where the ramp ends: between 1 and 2
    assert 1.0 < np.log(distance[0] / distance[1]) / np.log(4.0) < 2.2
    wrong = LinearRelease(HOOKE.length, 1.6e6, HOOKE.mass, HOOKE.pull, HOOKE.break_time)
    assert relative(found.tension, wrong.wall_tension(found.time)) > 10 * distance[1]


def test_momentum_is_what_the_ends_gave():
    line = replace(DRY, pull=315e3)
    mesh, given = Cells(line, 100), 0.0
    dt = 0.9 * mesh.width / mesh.fastest
    for i in range(60):  # until the front is near the wall, where the tension stays T0
        mesh.step(i * dt, dt)
        given += dt * (line.force((i + 0.5) * dt) - line.pull)
    assert mesh.wall == pytest.approx(line.pull, rel=1e-12)
    total = line.mass * mesh.width * mesh.velocity.sum()
    assert total == pytest.approx(given, rel=1e-12)


def test_drag_alone_slows_a_line_as_it_must():
    # T = 0 everywhere: v = v0 / (1 + k v0 t / m), the same for every cell
    line = replace(line_of(scene_of()), pull=45e3)
    mesh = Cells(line, 10)
    mesh.velocity[:] = -50.0
    for _ in range(100):
        mesh.resist(1e-3)
    expected = -50.0 / (1.0 + line.drag * 50.0 * 0.1 / line.mass)
    np.testing.assert_allclose(mesh.velocity, expected, rtol=1e-12)


def test_what_is_stored_is_what_the_scheme_gives():
    stored = reference.load()
    assert set(stored) == {case.name for case in (*MAIN, *HELD_OUT)}
    assert reference.FILE.stat().st_size < 200_000
    case = next(c for c in MAIN if c.name == "180 kN, 5 ms")
    found = solve(line_of(scene_of(*case.changes)), 400, reference.DURATION, 1e-4)
    # second order: 400 cells are some 1000 times as far as 12800, which are 1e-6 off
    bound = Errors(1e-4, 5e-3, 2e-3, 2e-3, 1e-5)
    near = errors(found, stored[case.name].histories)
    assert all(abs(a) < b for a, b in zip(near, bound, strict=True))
    far = errors(found, stored["315 kN, 5 ms"].histories)
    assert all(abs(a) > 10 * b for a, b in zip(far, bound, strict=True))


def test_the_references_are_finer_than_what_they_judge():
    for name, stored in reference.load().items():
        # the smallest error that is asked for is 0.1 %; T_c is less sharp where a shock moves by a cell
        assert max(stored.distance[:3]) < 5e-4, name
        assert stored.distance.tension_fine < 2e-3, name
        assert abs(stored.distance.front) < 2e-5, name
