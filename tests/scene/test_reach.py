"""Targets that no line can meet: cargo off the span, tensions too low to carry it."""

import math
from pathlib import Path

import pytest

from lumpedcable import exact
from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.reach import least_tension

HIGHLINE = Path(__file__).parents[2] / "configs" / "highline"


@pytest.mark.parametrize("place", [1.0, 10.0, 30.0, 59.0])
def test_the_least_tension_is_where_the_closed_form_ends(place):
    least = least_tension(60.0, 16.0, 40.0, 20e3, place, "start")
    exact.loaded_from_tension(60.0, 16.0, 40.0, 20e3, place, least * (1 + 1e-6))
    with pytest.raises(ValueError, match="the least that holds this line"):
        exact.loaded_from_tension(60.0, 16.0, 40.0, 20e3, place, least * (1 - 1e-6))
    # seen from its other end it is the same line
    other = least_tension(60.0, -16.0, 40.0, 20e3, 60.0 - place, "end")
    assert other == pytest.approx(least, rel=1e-9)


def test_the_least_tension_of_a_bare_line():
    # 2170.67 N by an independent solution of Lun, Li & Hou 2018, eq. 22; q c between the ends
    assert least_tension(60.0, 16.0, 40.0, 0.0, 30.0, "start") == pytest.approx(2170.67, abs=0.005)
    assert least_tension(60.0, 16.0, 40.0, 0.0, 7.0, "end") == pytest.approx(1530.67, abs=0.005)


EXTREMES = (1e-300, 1e-12, 1.0, 1e12, 1e300)


@pytest.mark.parametrize("span", EXTREMES)
@pytest.mark.parametrize("weight", EXTREMES)
def test_numbers_beyond_arithmetic_give_a_tension_or_none(span, weight):
    for load in (0.0, 1.0, 1e300):
        for drop in (0.0, -1.0, 1e308):
            least = least_tension(span, drop, weight, load, 0.5 * span, "start")
            # the higher end carries half the weight of a line of that span at least
            assert math.isnan(least) or least >= (0.5 * span * weight if drop >= 0.0 else 0.0)


@pytest.mark.parametrize("place", ["[-1e308, 0, 0]", "[0, 0, 1e308]", "[59.999999999, 0, 0]"])
def test_places_beyond_arithmetic_are_left_to_statics(place):
    load_study(HIGHLINE / "delivery-tension.toml", [f"lines.before.start.fixed={place}"])


@pytest.mark.parametrize(
    ("scene", "sets", "key", "words"),
    [
        ("adjustment.toml", "targets.winch.tension=2100", "targets.winch.tension",
         "expected 2.17068 kN or more, the least tension with which \"highline\" can carry itself, "
         "found 2.1 kN"),
        ("delivery-tension.toml", "targets.winch.tension=15 kN", "targets.winch.tension",
         'can carry itself and "cargo", found 15 kN'),
        ("delivery.toml", "targets.cargo.x=70 m", "targets.cargo.x",
         'expected a place on the span of "before + after", between 0 m and 60 m, found 70 m'),
        ("delivery.toml", "targets.cargo.x=-1 m", "targets.cargo.x", "found -1 m"),
    ],
)  # fmt: skip
def test_what_no_line_can_do_is_told(scene, sets, key, words):
    with pytest.raises(SceneError) as caught:
        load_study(HIGHLINE / scene, [sets])
    (fault, *_) = caught.value.faults
    assert fault.key.startswith(key)
    assert words in fault.message


def test_what_a_line_can_just_do_is_left_alone():
    load_study(HIGHLINE / "adjustment.toml", ["targets.winch.tension=2171"])
    for name in ("delivery.toml", "delivery-tension.toml", "unloading.toml", "erection.toml"):
        load_study(HIGHLINE / name)
