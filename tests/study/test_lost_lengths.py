"""Inextensible lines at steps that are too long for them: told as that, and ended before it shows."""

import h5py
import numpy as np
import pytest
from engine_runs import run_text

# a body of 1 t on four light rods: where neighbours go against each other, with a third of their mass,
# omega^2 = 12 T / (m l^2) = 12 * 9810 N / 0.1 kg/m / 1 m^2 = (1085 1/s)^2, and omega dt = 2 at 1.8 ms
HUNG = """
gravity = 9.81
[materials.stiff]
law = "inextensible"
[lines.rope]
material = "stiff"
length = "4 m"
segments = 4
mass = "0.1 kg/m"
start = { fixed = [0, 0, 0] }
end = "load.eye"
[bodies.load]
mass = "1 t"
position = [0, 0, -4]
velocity = ["2 m/s", 0, 0]
points = { eye = [0, 0, 0] }
free = ["x", "z"]
[solver]
step = "8 ms"
[output]
duration = "1.2 s"
every = "40 ms"
stop = "load"
quantities = ["position", "tension", "energy"]
"""
# a pendulum of 4 m has T = m (g + v^2 / l) at most, and rests after a quarter of 2 pi sqrt(l / g);
# that the body jerks its line sideways as it starts, adds to the tension
MOST = 1000.0 * (9.81 + 2.0**2 / 4.0)
QUARTER = 0.5 * np.pi * np.sqrt(4.0 / 9.81)


def peaks_of(folder):
    with h5py.File(folder / "result.h5") as file:
        return file["lines/rope/peak_tension"][()]


@pytest.mark.slow
def test_a_step_too_long_for_rods_is_told_as_that(tmp_path):
    ran = run_text(tmp_path, HUNG)
    (outcome,) = ran.outcomes
    assert ran.statuses == ["LENGTH_LOST"]
    assert 0.0 < outcome.status_time < 1.2
    assert "lower solver.step" in outcome.message
    # the run ends before the step in which they are lost: what is kept is a motion of rods
    lengths = np.linalg.norm(np.diff(ran["position"][0], axis=1), axis=2)
    assert lengths == pytest.approx(1.0, abs=1e-4)
    assert outcome.energy_closure < 0.05
    assert np.max(np.abs(ran["end_tension"])) < 3.0 * MOST
    assert np.nanmax(peaks_of(tmp_path)) < 3.0 * MOST
    assert np.isnan([outcome.stop_time, outcome.stop_distance]).all()


@pytest.mark.slow
def test_a_step_that_rods_bear_is_not(tmp_path):
    ran = run_text(tmp_path, HUNG, "solver.step=1 ms")
    (outcome,) = ran.outcomes
    assert ran.statuses == ["OK"]
    assert outcome.stop_time == pytest.approx(QUARTER, rel=0.02)
    assert MOST <= np.nanmax(peaks_of(tmp_path)) < 3.0 * MOST


@pytest.mark.slow
def test_others_of_the_batch_go_on_and_each_ends_as_it_does_alone(tmp_path):
    swept = '[sweep]\n"bodies.load.mass" = [20.0, 1000.0]\n'  # the light one bears 13 ms
    fine = HUNG.replace('"8 ms"', '"4 ms"')
    both = run_text(tmp_path, fine + swept)
    alone = run_text(tmp_path, fine)
    assert both.statuses == ["OK", "LENGTH_LOST"]
    assert alone.statuses == ["LENGTH_LOST"]
    assert both.outcomes[1].status_time == alone.outcomes[0].status_time


@pytest.mark.slow
def test_ends_that_are_moved_too_far_apart_are_named(tmp_path):
    """No step helps there: 10 m of rods whose ends are 9.8 m apart and go at 0.2 m/s."""
    head, rest = HUNG.split("start = {")
    moved = '{ position = [9.8, 0, 0], velocity = ["0.2 m/s", 0, 0], ramp = "0.5 s" }'
    text = (
        f"{head}start = {{ fixed = [0, 0, 0] }}\nend = {{ motion = {moved} }}\n"
        + "[solver]"
        + rest.split("[solver]")[1].replace('stop = "load"\n', "")
    )
    text = text.replace('"4 m"', '"10 m"').replace('"1.2 s"', '"1.6 s"')
    ran = run_text(tmp_path, text)
    (outcome,) = ran.outcomes
    assert ran.statuses == ["LENGTH_LOST"]
    assert outcome.status_time == pytest.approx(1.25, abs=0.05)
    assert "its ends are moved farther apart than it is long" in outcome.message
