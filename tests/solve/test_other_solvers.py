"""Other integrators and another precision solve the same equations of motion."""

from itertools import pairwise

import numpy as np
import pytest
from engine_runs import ROPE, run_text

PLAIN = ROPE + '\n[solver]\nwaves = "plain"\n'
SMOOTH = ("rope.segments=20", "break.time=10 ms", "output.duration=10 ms", "output.every=5 ms")
SIZE = 43.0  # m/s, what the end gets to


def velocities(folder, text, *options):
    ran = run_text(folder, text, *SMOOTH, *options)
    assert ran.statuses == ["OK"]
    return ran["velocity"][0, :, :, 0]


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    """Leapfrog extrapolated to no step at all, by its second order (Richardson)."""
    folder = tmp_path_factory.mktemp("leapfrog")
    one, half = (velocities(folder, PLAIN, f"solver.step={h}") for h in (2e-5, 1e-5))
    return (4.0 * half - one) / 3.0


@pytest.mark.parametrize(
    "method", ["tsit5", *(pytest.param(m, marks=pytest.mark.slow) for m in ("dopri8", "kvaerno5"))]
)
def test_adaptive_solvers_come_as_close_as_they_are_asked_to(tmp_path, truth, method):
    errors = []
    for rtol in (1e-4, 1e-7):
        text = PLAIN + f'method = "{method}"\nrtol = {rtol}\natol = {1e-3 * rtol}\n'
        found = velocities(tmp_path, text)
        errors.append(np.max(np.abs(found - truth)) / SIZE)
    assert errors[0] < 1e-2
    assert errors[1] < 1e-5
    assert errors[1] < 0.1 * errors[0]


@pytest.mark.parametrize(
    ("method", "order"),
    [
        ("leapfrog", 2),
        pytest.param("heun", 2, marks=pytest.mark.slow),
        pytest.param("midpoint", 2, marks=pytest.mark.slow),
        pytest.param("euler", 1, marks=pytest.mark.slow),
    ],
)
def test_fixed_steps_converge_with_their_order(tmp_path, truth, method, order):
    errors = []
    for step in (1e-4, 5e-5):
        text = PLAIN + f'method = "{method}"\nstep = {step}\n'
        errors.append(np.max(np.abs(velocities(tmp_path, text) - truth)) / SIZE)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)
    assert errors[1] < (2e-3 if order == 2 else 0.1)


def test_runge_kutta_is_of_fourth_order(tmp_path, truth):
    text = PLAIN + 'method = "rk4"\n'
    found = [velocities(tmp_path, text, f"solver.step={h}") for h in (1e-3, 5e-4, 2.5e-4)]
    # it is the same motion, as far as the extrapolated leapfrog knows it
    np.testing.assert_allclose(found[2], truth, rtol=0, atol=1e-5 * SIZE)
    far, near = (np.max(np.abs(b - a)) for a, b in pairwise(found))
    assert np.log2(far / near) == pytest.approx(4, abs=0.4)


@pytest.mark.parametrize("method", ["tsit5", pytest.param("kvaerno5", marks=pytest.mark.slow)])
def test_what_an_end_does_does_not_depend_on_how_often_it_is_looked_at(tmp_path, method):
    found = []
    for every in ("20 ms", "0.25 ms"):
        changes = ("rope.segments=20", "output.duration=100 ms", f"output.every={every}")
        ran = run_text(tmp_path, PLAIN + f'method = "{method}"\n', *changes)
        assert ran.statuses == ["OK"]
        found.append(ran.outcomes[0].recoils["rope.end"])
    rarely, often = found
    # the speed is level at its peak: between steps of some tenths of a millisecond it hardly changes
    assert rarely["peak_end_speed"] == pytest.approx(often["peak_end_speed"], rel=2e-3)
    assert rarely["front_arrival"] == pytest.approx(often["front_arrival"], abs=0.2e-3)


def test_all_solvers_book_the_same_energies(tmp_path):
    # another integrator accumulates work as part of its state; the balance closes to its tolerance
    text = PLAIN + 'method = "dopri5"\nrtol = 1e-8\natol = 1e-10\n'
    ran = run_text(tmp_path, text, *SMOOTH)
    assert ran.outcomes[0].energy_closure < 1e-6
    assert "lost_stepping" not in ran.energy  # a loss of leapfrog's alone
    other = run_text(tmp_path, PLAIN, *SMOOTH, "solver.step=1e-5")
    for term in ("kinetic", "strain"):
        np.testing.assert_allclose(ran.energy[term], other.energy[term], rtol=1e-4, atol=1e-2)


@pytest.mark.slow
def test_single_precision_is_enough(tmp_path):
    # strains come from displacement differences, not from places: no digits are lost
    text = ROPE.replace("tension_only = false", "tension_only = true")
    double = run_text(tmp_path, text, "output.duration=60 ms")
    single = run_text(tmp_path, text + '\n[solver]\ndtype = "float32"\n', "output.duration=60 ms")
    assert single.attributes["dtype"] == "float32"
    moves = [r.outcomes[0].recoils["rope.end"]["end_displacement"] for r in (double, single)]
    assert moves[1] == pytest.approx(moves[0], rel=1e-5)
    assert moves[1] != moves[0]  # it was another precision
    velocity = np.max(np.abs(single["velocity"] - double["velocity"]))
    assert velocity < 1e-3 * SIZE


MOVED = """
[materials.wire]
law = "linear"
EA = 1e6
damping = 1e3
[lines.rope]
material = "wire"
length = 20
segments = 4
mass = 1
start = { fixed = [0, 0, 0] }
end = { motion = { position = [20, 0, 0], velocity = [0.02, 0, 0], ramp = 0.4 } }
[output]
duration = 3
every = 0.5
"""


@pytest.mark.parametrize(
    "method", ["rk4", *(pytest.param(m, marks=pytest.mark.slow) for m in ("heun", "dopri8"))]
)
def test_a_moved_end_stays_on_its_path(tmp_path, method):
    # its ramp ends with a step in its acceleration, which once left a velocity behind for good
    ran = run_text(tmp_path, MOVED + f'[solver]\nmethod = "{method}"\n')
    t = np.arange(0.0, 3.01, 0.5)
    # as fast as told from 0.4 s on, half as fast before, on the mean
    way = 0.02 * np.maximum(t - 0.2, 0.0)
    np.testing.assert_allclose(ran["position"][0, :, -1, 0], 20.0 + way, rtol=1e-13)
    np.testing.assert_allclose(ran["velocity"][0, 1:, -1, 0], 0.02, rtol=1e-13)


BREAK = '[events.break]\nbreaks = "rope.end"\nstart = 1\ntime = 2\n'


@pytest.mark.parametrize(
    ("method", "place"),
    [
        ("rk4", "rope.end"),
        pytest.param("tsit5", "rope.end", marks=pytest.mark.slow),
        pytest.param("rk4", "rope@10 m", marks=pytest.mark.slow),
        pytest.param("tsit5", "rope@10 m", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_what_decays_is_what_the_end_carried_when_the_break_began(tmp_path, method, place):
    # slack at the start, stretched by 0.016 m when it breaks, EA 0.016/20 = 0.8 kN, and slowly: half
    # of it is left halfway, give or take the wave of the pull, m c v / 2 = 10 N
    text = MOVED + BREAK.replace("rope.end", place) + f'[solver]\nmethod = "{method}"\n'
    ran = run_text(tmp_path, text)
    times = list(np.arange(0.0, 3.01, 0.5))
    line = "rope" if place == "rope.end" else "rope-1"
    tension = ran.lines[line]["tension"][0, :, -1]
    np.testing.assert_allclose(tension[times.index(1.0)], 800.0, atol=20.0)
    np.testing.assert_allclose(tension[times.index(2.0)], 400.0, atol=20.0)
    np.testing.assert_allclose(tension[times.index(3.0)], 0.0, atol=20.0)


@pytest.mark.slow
def test_a_moved_end_costs_single_precision_no_digits(tmp_path):
    # 20 m have digits of 2 um, 0.4 N of a segment's tension; the way of 60 mm has them of 4 nm, 1 mN
    text = MOVED + '[solver]\nmethod = "rk4"\n'
    double, single = (run_text(tmp_path, text, f"solver.dtype={d}") for d in ("float64", "float32"))
    assert single.attributes["dtype"] == "float32"
    np.testing.assert_allclose(single["tension"], double["tension"], rtol=0, atol=0.1)
