"""What judges is judged: every checker turns down a wrong answer."""

from dataclasses import replace

import numpy as np
import pytest
from case import assert_gradient, assert_order, assert_right, assert_step_order, relative_error
from catalogue import CASES
from mode_cases import (
    CHAIN_W,
    EA,
    EI,
    SWING,
    K,
    bar_wave,
    beam_wave,
    bouncing,
    chain_shape,
    damped_wave,
)
from motion_cases import STRETCHED, SWUNG, G, shaken, sinking
from nylon_line import MASS, RUNS
from player import play
from release_cases import from_end, linear


def soft_string(seen):
    return SWING * np.sin(K * seen.s) * np.cos(K * np.sqrt(5e4) * seen.time)[:, None]


def small_swing(seen):
    a = SWUNG * np.cos(np.sqrt(G / STRETCHED) * seen.time)
    return STRETCHED * np.stack([np.sin(a), 1.0 - np.cos(a)], axis=-1)[:, None]


def by_sound_speed(seen):
    """Run 4 with its front at the speed of sound ahead of it, as the paper has it."""
    gone = from_end(seen)[:-1] < RUNS[3].c0 * seen.time[:, None]
    return np.where(gone, 0.0, 450e3)


# mistakes that somebody may make
WRONG = {
    "standing axial wave": lambda seen: bar_wave(seen, 1.02 * EA),
    "damped axial mode": lambda seen: damped_wave(seen, 1e-9),
    "body on a heavy line": lambda seen: bouncing(seen, 1.02 * EA),
    "body on one segment": lambda seen: -SWING * np.cos(np.sqrt(1e5 / 20.0) * seen.time)[:, None],
    "taut string": soft_string,  # the mass not thinned by the stretch
    "hanging chain": lambda seen: (
        SWING * chain_shape(seen.s) * np.cos(1.02 * CHAIN_W * seen.time)[:, None]
    ),
    "cantilever": lambda seen: beam_wave(seen, 1.05 * EI),
    "pendulum": small_swing,
    "free fall": lambda seen: -0.5 * 9.7 * seen.time**2,
    "sinking": lambda seen: sinking(seen, 1.01 * 1.2),
    "shaken end": lambda seen: -np.asarray(shaken(seen)),
    "linear release, at once": lambda seen: linear(seen, 0.0, 75e3),
    "linear release, ramped": lambda seen: linear(seen, 0.0),
    "rarefaction": lambda seen: np.where(  # Hooke's line of the same sound speed
        from_end(seen) < RUNS[0].c0 * seen.time[:, None], 45e3 / MASS / RUNS[0].c0, 0.0
    ),
    "plateau": lambda seen: np.array([45e3 / MASS / RUNS[0].c0]),
    "shock": by_sound_speed,
}


def test_every_case_has_its_mistake():
    assert set(WRONG) == set(CASES)


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_answer_is_turned_down(name):
    case = CASES[name]
    with pytest.raises(AssertionError, match="error"):
        assert_right(replace(case, exact=WRONG[name]), case.play())


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
