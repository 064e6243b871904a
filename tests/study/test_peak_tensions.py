"""The largest tension is that of any step, whatever lies between the outputs."""

import numpy as np
import pytest
from engine_runs import HOOKE, run_text, study_of

from lumpedcable.exact import elastic_catenary
from lumpedcable.results import open_result
from lumpedcable.study import batches, shrinking
from lumpedcable.study.run import run_study

BLOCK, ROPE, STIFFNESS, SPEED = 1e3, 1.0, 1e5, 1.0  # kg, kg, EA / l in N/m, m/s
MASS = BLOCK + 0.5 * ROPE  # of one segment the half at either end
RATE = np.sqrt(STIFFNESS / MASS)
# a block that flies off and is caught by a line: T = v sqrt(k m) sin(w t)
CAUGHT = f"""
[materials.elastic]
law = "linear"
tension_only = true
EA = {STIFFNESS}
[lines.rope]
material = "elastic"
length = 1
segments = 1
mass = {ROPE}
start = {{ fixed = [0, 0, 0] }}
end = "block.face"
[bodies.block]
mass = {BLOCK}
position = [1.5, 0, 0]
velocity = [{SPEED}, 0, 0]
points = {{ face = [-0.5, 0, 0] }}
free = ["x"]
[output]
duration = {2.0 * np.pi / RATE}
every = {np.pi / RATE}
quantities = ["position", "tension"]
"""
# waves to and fro, in a line that is let go at its end or that parts
WAVES = HOOKE.replace("segments = 50", "segments = 12").replace("time = 0", 'time = "3 ms"')
WAVES = WAVES.replace('"100 ms"', '"240 ms"') + (
    'quantities = ["position", "tension"]\n[solver]\nstep = "2 ms"\n'
)
STEPS, SELDOM = "output.every=2 ms", "output.every=60 ms"
DAMPED = "materials.hooke.damping=20 kN s"
PARTED = ("events.break.breaks=rope", "events.break.place=[35 m, 90 m]")


def peaks_of(folder, name, text, *overrides):
    """Peaks of the runs, of each segment of each line, and the largest tensions at outputs."""
    path = folder / name
    path.mkdir()
    run_text(path, text, *overrides)
    with open_result(path / "result.h5") as result:
        lines = [result.line(name) for name in result.lines]
        segments = {line.name: line.field("peak_tension") for line in lines}
        outputs = {line.name: np.max(line.tension(), axis=1) for line in lines}
        return result.summary()["run"]["peak_tension"], segments, outputs


def test_a_load_that_comes_and_goes_between_two_outputs_is_seen(tmp_path):
    peak, segments, outputs = peaks_of(tmp_path, "a", CAUGHT, "solver.step=1 ms")
    exact = SPEED * np.sqrt(STIFFNESS * MASS)
    # a step of dt leaves (w dt)^2 / 8 of what lies between two, and as much of the motion
    assert peak == pytest.approx(exact, rel=(RATE * 1e-3) ** 2)
    assert segments["rope"] == pytest.approx(exact, rel=(RATE * 1e-3) ** 2)
    assert np.max(outputs["rope"]) < 1e-3 * exact


def test_with_another_method_it_is_that_of_the_outputs(tmp_path):
    text = CAUGHT + "[solver]\nmethod = 'rk4'\nstep = '1 ms'\n"
    run_text(tmp_path, text)
    with open_result(tmp_path / "result.h5") as result:
        assert not result.line("rope").has("peak_tension")
        top = np.max(result.line("rope").tension(), axis=(1, 2))
        assert result.summary()["run"]["peak_tension"] == pytest.approx(top)


@pytest.mark.parametrize(
    "more",
    [
        pytest.param((), marks=pytest.mark.slow),
        pytest.param(PARTED, marks=pytest.mark.slow),
        ('lines.rope.end.held.pretension=["9 kN", "50 kN"]',),
    ],
)
def test_it_is_the_largest_of_all_outputs_if_every_step_is_one(tmp_path, more):
    peak, segments, _ = peaks_of(tmp_path, "seldom", WAVES, SELDOM, *more)
    every, same, outputs = peaks_of(tmp_path, "steps", WAVES, STEPS, *more)
    assert segments.keys() == outputs.keys()
    for name, values in segments.items():
        np.testing.assert_allclose(values, outputs[name], rtol=1e-12)
        np.testing.assert_array_equal(values, same[name])
    top = np.nanmax(np.concatenate([*segments.values()], axis=1), axis=1)
    np.testing.assert_array_equal(peak, top)
    np.testing.assert_array_equal(every, top)


@pytest.mark.slow
def test_of_a_line_with_weight_it_is_that_of_its_ends(tmp_path):
    # the middles of five segments bear a fifth less than the supports that they hang at
    text = """
    gravity = 9.81
    [materials.steel]
    law = "linear"
    EA = "50 MN"
    [lines.chain]
    material = "steel"
    length = 100
    segments = 5
    mass = 20
    start = { fixed = [0, 0, 0] }
    end = { fixed = [50, 0, 0] }
    [output]
    duration = "0.1 s"
    every = "10 ms"
    """
    run_text(tmp_path, text)
    exact = elastic_catenary(50.0, 0.0, 100.0, 50e6, 20.0 * 9.81)
    with open_result(tmp_path / "result.h5") as result:
        peak = result.summary()["run"]["peak_tension"]
        assert peak == pytest.approx(exact.tension(0.0), rel=0.01)
        assert np.max(result.line("chain").tension()) < 0.85 * exact.tension(0.0)


def test_damping_counts_as_of_the_kick(tmp_path):
    # in a kick the damping lags by half a step: of first order beside that at the outputs
    peak, _, outputs = peaks_of(tmp_path, "damped", WAVES, STEPS, DAMPED, "solver.step=0.5 ms")
    assert peak == pytest.approx(np.max(outputs["rope"]), rel=1e-2)


def test_of_a_run_that_goes_wrong_it_is_that_of_before(tmp_path):
    # caught once, the block flies back past the start of its slack line, which is turned round then
    run_text(tmp_path, CAUGHT, "solver.step=1 ms", "output.every=0.1 s", "output.duration=2 s")
    with open_result(tmp_path / "result.h5") as result:
        assert result.status == ["line_reversed"]
        assert np.pi / RATE < result.status_time[0] < 1.1 + np.pi / RATE + 0.1
        exact = SPEED * np.sqrt(STIFFNESS * MASS)
        assert result.summary()["run"]["peak_tension"] == pytest.approx(exact, rel=1e-4)
        assert np.isnan(result.line("rope").field("peak_tension")).all()


def test_summaries_alone_keep_none_of_segments(tmp_path):
    study = study_of(tmp_path, WAVES, SELDOM, "output.keep=summaries")
    run_study(study, tmp_path / "result.h5")
    with open_result(tmp_path / "result.h5") as result:
        assert not result.line("rope").has("peak_tension")
        assert result.summary()["run"]["peak_tension"] >= 50e3 * (1.0 - 1e-9)


@pytest.mark.slow
def test_lanes_that_are_given_up_keep_theirs(tmp_path, monkeypatch):
    # springs that stop their blocks after a quarter of a period, one after the other
    text = CAUGHT.replace("[output]", '[output]\nstop = "block"')
    swept = f'"bodies.block.mass" = {[100, 150, 200, 300, 400, 900]}'
    text = f"{text}[solver]\nstep = '1 ms'\n[sweep]\n{swept}\n"
    monkeypatch.setattr(shrinking, "COMPILING", 0.0)
    monkeypatch.setattr(shrinking, "FEWEST", 1)
    monkeypatch.setattr(batches, "CPU", batches.CPU._replace(first=1))
    peak, segments, _ = peaks_of(tmp_path, "a", text, "output.every=40 ms", "output.duration=0.4 s")
    masses = np.array([100, 150, 200, 300, 400, 900])
    exact = SPEED * np.sqrt(STIFFNESS * (masses + 0.5 * ROPE))
    np.testing.assert_allclose(peak, exact, rtol=STIFFNESS / 100 * 1e-6)
    np.testing.assert_array_equal(segments["rope"][:, 0], peak)
