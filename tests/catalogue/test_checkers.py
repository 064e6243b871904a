"""What judges is judged: every checker turns down a wrong answer."""

import numpy as np
import pytest
from case import assert_gradient, assert_order, assert_right, assert_step_order, relative_error
from catalogue import CASES
from player import play
from wrong_answers import WRONG


def test_every_case_has_its_mistake():
    assert set(WRONG) == set(CASES)


def test_a_run_that_blew_up_is_turned_down():
    case = CASES["standing axial wave"]
    played = case.play()
    with pytest.raises(AssertionError):
        assert_right(case, played._replace(finite=False))
    moved = np.full_like(played.seen.moved, np.nan)
    with pytest.raises(AssertionError):
        assert_right(case, played._replace(seen=played.seen._replace(moved=moved)))


def test_a_step_too_long_is_seen():
    # the engine itself: 1 step in 10 ms is 1.6 times the stable one, and grows out of bounds
    case = CASES["standing axial wave"]
    played = case.play("output.duration=0.16", steps=1)
    with pytest.raises(AssertionError):
        assert_right(case, played)


@pytest.mark.parametrize("errors", [(1.0, 0.5), (1.0, 0.05), (1.0, 1.0), (1.0, np.nan)])
def test_a_wrong_order_is_turned_down(errors):
    assert_order((1.0, 0.25), 2, (1.8, 2.2))
    with pytest.raises(AssertionError, match="order"):
        assert_order(errors, 2, (1.8, 2.2))


def test_a_first_order_step_is_turned_down():
    # a damping force that lags by half a step
    case = CASES["damped axial mode"]
    with pytest.raises(AssertionError, match="order"):
        assert_step_order(case, steps=case.play().steps, band=(1.9, 2.1))


def test_a_wrong_gradient_is_turned_down():
    t = np.linspace(0.0, 5.0, 20)
    exact = -t * np.sin(t)  # of cos(p t) by p at 1
    assert_gradient(exact * 1.005, exact, 0.01)
    for wrong in (1.02 * exact, -exact, -np.sin(t), 0.0 * t, np.nan * t):
        with pytest.raises(AssertionError, match="gradient"):
            assert_gradient(wrong, exact, 0.01)


def test_shapes_must_agree():
    with pytest.raises(AssertionError):
        relative_error(np.zeros((3, 1)), np.zeros((3, 4)), 1.0)


def test_a_line_that_finds_no_rest_is_not_played():
    text = CASES["free fall"].text.replace("{ fixed = [0, 0, 0] }", '"free"').partition("[events")
    with pytest.raises(AssertionError):
        play(text[0] + "[output]" + text[2].partition("[output]")[2])
