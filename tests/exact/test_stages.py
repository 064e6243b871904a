"""The stages of a highline: shapes, equations and numbers for a page with sliders."""

import re

import numpy as np
import pytest
from highline_numbers import EXACT_SHORT, FROM_80_KN, FROM_SAG, LOWERED, STRAIGHT_SHORT

from lumpedcable.exact import STAGES, stage_shape
from lumpedcable.exact.stages import UNITS

SIX = {"erection", "stabilisation", "adjustment", "delivery", "unloading", "withdrawal"}


def told(equation, x):
    """z of a shape equation in words."""
    words = equation.partition("= ")[2].replace("[", "(").replace("]", ")")
    return eval(re.sub(r"(?<=\d) (?=[(x])", "*", words), {"cosh": np.cosh, "x": x})


def test_there_are_six():
    assert {name.partition("-")[0] for name in STAGES} == SIX


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_has_a_shape(stage):
    shape = stage_shape(stage, points=101)
    sliders = STAGES[stage].sliders
    assert all(s.low <= s.value <= s.high and s.unit for s in sliders.values())
    assert set(shape.numbers) <= set(UNITS)
    assert (shape.x[0], shape.z[0], shape.x[-1]) == (0.0, 0.0, sliders["span"].value)
    lowered = sliders["lowered"].value if "lowered" in sliders else 0.0
    assert shape.z[-1] == pytest.approx(-sliders["drop"].value - lowered)
    assert np.all(np.diff(shape.x) >= 0.0)
    for each in (shape, shape.approximate):
        if each is None:
            continue
        cut = [0, *([] if each.split is None else [each.split - 1]), each.x.size - 1]
        assert len(each.equations) == len(cut) - 1
        for equation, first, last in zip(each.equations, cut, cut[1:], strict=False):
            x, z = each.x[first : last + 1], each.z[first : last + 1]
            # six digits of the span are printed
            assert told(equation, x) == pytest.approx(z, abs=1e-3)
        # the length of what is drawn is the length that is told
        drawn = float(np.sum(np.hypot(np.diff(each.x), np.diff(each.z))))
        whole = each.numbers["S"] + each.numbers.get("S_traction", 0.0)
        assert drawn == pytest.approx(whole, rel=1e-4)


@pytest.mark.parametrize("stage", ["adjustment", "unloading", "delivery-tension", "erection"])
def test_the_equation_of_a_taut_line_is_that_of_its_shape(stage):
    # a scale of 40 km before a difference of numbers near 1
    taut = {"span": 80.0, "drop": 1.5, "weight": 5.0}
    sliders = STAGES[stage].sliders
    taut |= {"tension": 200e3} if "tension" in sliders else {}
    taut |= {"load": 1e3} if "load" in sliders else {}
    shape = stage_shape(stage, **taut, points=101)
    cut = [0, *([] if shape.split is None else [shape.split - 1]), shape.x.size - 1]
    for equation, first, last in zip(shape.equations, cut, cut[1:], strict=False):
        x, z = shape.x[first : last + 1], shape.z[first : last + 1]
        assert told(equation, x) == pytest.approx(z, abs=2e-4)


def test_numbers_are_those_of_the_closed_forms():
    keys = ("S", "f", "F_TA", "F_TB", "F_H")

    def numbers(stage, **values):
        return [stage_shape(stage, **values).numbers[key] for key in keys]

    assert numbers("stabilisation") == pytest.approx(FROM_SAG[:5], rel=1e-9)
    assert numbers("adjustment") == pytest.approx(FROM_80_KN[:5], rel=1e-9)
    assert numbers("unloading", lowered=3.0) == pytest.approx(LOWERED[3][:5], rel=1e-9)
    shape = stage_shape("delivery", place=20.0)
    for found, expected in ((shape, EXACT_SHORT[1]), (shape.approximate, STRAIGHT_SHORT[1])):
        assert found.mark == pytest.approx((20.0, -expected[0]), rel=1e-9)
        assert [found.numbers[key] for key in ("f", "F_H", "F_TA", "F_TB")] == pytest.approx(
            expected[1:], rel=1e-9
        )


def test_a_delivery_to_a_higher_ship():
    # straight segments hold the load with this tension too
    shape = stage_shape(
        "delivery-tension", span=40.0, drop=-20.0, place=5.0, load=20e3, tension=17e3
    )
    found = [shape.numbers[key] for key in ("S", "F_TA", "F_TB", "F_H")]
    assert found == pytest.approx([51.52, 17000.0, 13932.6, 10736.0], rel=1e-4)
    S, *pulls, H = found
    # A and B hold up the load and the line, which ends at B
    assert sum(np.sqrt(pull**2 - H**2) for pull in pulls) == pytest.approx(20e3 + 40.0 * S)
    assert shape.z[-1] == pytest.approx(20.0)
    assert shape.approximate.numbers["F_TA"] == pytest.approx(17e3)


def test_erection_and_withdrawal_are_one_way_and_back():
    out = stage_shape("erection", speed=0.5, time=40.0)
    back = stage_shape("withdrawal", start=60.0, speed=2.0, time=20.0)
    assert out.numbers["S"] == pytest.approx(20.0)
    assert out.mark == pytest.approx(back.mark)
    assert out.mark_words == "joint"


def test_what_has_no_shape_says_why():
    for stage, numbers, words in (
        ("delivry", {}, 'did you mean "delivery"'),
        ("delivery", {"plaec": 3.0}, 'did you mean "place"'),
        ("delivery", {"place": 70.0}, "cargo on the span"),
        ("delivery-tension", {"tension": 9e3}, "15323.4 N or more"),
        ("withdrawal", {"time": 65.0}, "0 m or more, found -5 m"),
    ):
        with pytest.raises(ValueError, match=words):
            stage_shape(stage, **numbers)
