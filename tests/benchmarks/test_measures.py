"""What measures an error finds it, and gives none to what is right."""

import math

import numpy as np
import pytest

from benchmarks.headline import Reached, ratio, reached
from benchmarks.measures import Histories, error_cells, errors, front_time

T = np.arange(2001) * 1e-4


def history(**changes):
    made = {
        "time": T,
        "tension": np.where(T < 0.05, 100.0, 100.0 * np.exp(-(T - 0.05) / 0.01)),
        "velocity": -10.0 * (1.0 - np.exp(-T / 0.02)),
        "displacement": -1.5,
    } | changes  # fmt: skip
    return Histories(front=front_time(made["time"], made["tension"]), **made)


def test_the_truth_has_no_error():
    assert errors(history(), history()) == (0.0, 0.0, 0.0, 0.0, 0.0)


def test_every_error_is_found_and_is_of_its_size():
    truth = history()
    assert errors(history(displacement=-1.53), truth).displacement == pytest.approx(0.02)
    assert errors(history(velocity=1.01 * truth.velocity), truth).velocity == pytest.approx(0.01)
    found = errors(history(tension=0.97 * truth.tension), truth)
    assert found.tension == pytest.approx(0.03)
    assert found.tension_fine == pytest.approx(0.03)
    # a history that is all as it should be, 3 ms late
    late = history(tension=np.interp(T - 3e-3, T, truth.tension))
    # the exact place falls between two samples of 0.1 ms
    assert errors(late, truth).front == pytest.approx(3e-3, abs=1e-6)


def test_the_front_is_where_half_the_tension_is_gone():
    level = 0.5 * (1.0 + np.exp(-15.0))
    assert history().front == pytest.approx(0.05 - 0.01 * math.log(level), abs=1e-6)
    assert math.isnan(front_time(T, np.full(T.size, 7.0)))


def test_a_history_of_longer_steps_is_straight_between_them():
    coarse = Histories(T[::25], history().tension[::25], history().velocity[::25], -1.5, 0.0)
    at = coarse.at(1e-4)
    np.testing.assert_allclose(at.time, T, atol=1e-15)
    np.testing.assert_allclose(at.velocity[::25], coarse.velocity, rtol=1e-12)
    middle = 0.5 * (coarse.velocity[0] + coarse.velocity[1])
    assert np.interp(12.5e-4, at.time, at.velocity) == pytest.approx(middle)


def test_a_level_is_reached_where_the_line_in_logarithms_crosses_it():
    # error = 1 / time
    found = reached([1.0, 10.0, 100.0], [1.0, 0.1, 0.01], 0.05)
    assert found.bound == ""
    assert found.time == pytest.approx(20.0)
    assert reached([1.0, 10.0], [1.0, 0.1], 2.0) == Reached(1.0, "<")
    assert reached([1.0, 10.0], [1.0, 0.1], 0.01) == Reached(10.0, ">")


def test_a_lucky_mesh_does_not_count():
    # at the second mesh the error is small by chance; at the third it is back
    lucky = reached([1.0, 2.0, 4.0, 8.0], [1.0, 0.001, 0.5, 0.01], 0.1)
    assert 4.0 < lucky.time < 8.0
    assert reached([1.0, 2.0], [0.01, math.nan], 0.1).bound == ">"


def test_a_row_shows_what_was_not_measured():
    known = errors(history(displacement=-1.53), history())._asdict()
    cells = error_cells([known, None, known | {"front": math.nan}])
    assert cells[0] == "2 / - / 2"
    assert cells[4] == "+0.000 / - / -"
    assert error_cells([known | {"velocity": 1.234}])[1] == "123"


def test_ratios_say_what_they_do_not_know():
    assert ratio(Reached(20.0), Reached(2.0)) == "10"
    assert ratio(Reached(20.0, ">"), Reached(2.0)) == "> 10"
    assert ratio(Reached(20.0), Reached(2.0, "<")) == "> 10"
    # two upper bounds say nothing of their ratio
    assert ratio(Reached(20.0, "<"), Reached(2.0, "<")) == "both on their coarsest mesh"
    assert ratio(Reached(20.0), Reached(2.0, ">")) == "not reached"
    assert ratio(Reached(20.0, ">"), Reached(2.0, ">")) == "neither reaches it"
