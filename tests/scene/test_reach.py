"""Targets that no line can meet: cargo off the span, tensions too low to carry it."""

import math
from pathlib import Path

import pytest

from lumpedcable import exact
from lumpedcable.scene import SceneError, load_study
from lumpedcable.scene.bodies import Body
from lumpedcable.scene.carried_checks import anchor
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


YAWED = """\
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
[materials.wire]
law = "linear"
EA = "10 MN"
[lines.rope]
material = "wire"
length = "31 m"
segments = 20
mass = "5 kg/m"
diameter = "50 mm"
start = { fixed = [0, 0, "10 m"] }
end = "ship.bow"
[bodies.ship]
mass = "500 t"
size = ["50 m", "10 m", "5 m"]
position = ["55 m", 0, "1.5 m"]
attitude = [0, 0, "180 deg"]
points = { bow = ["25 m", 0, "8.5 m"] }
hull = { above_keel = "2.5 m" }
[output]
[targets.winch]
change = "lines.rope.length"
of = "rope.end"
tension = "1 kN"
"""
HAULED = YAWED[: YAWED.index("[output]")].replace(
    '{ fixed = [0, 0, "10 m"] }', '{ winch = { at = [0, 0, "10 m"], tension = "80 kN" } }'
) + (
    '[bodies.cargo]\nmass = "1 t"\n'
    'on = { line = "rope", place = "25 m", speed = "1 m/s", stop = "2 m" }\n'
    '[output]\nduration = "4 s"\nevery = "1 s"\n'
)


def written(folder, text, *sets):
    (folder / "scene.toml").write_text(text)
    return load_study(folder / "scene.toml", sets)


def test_the_bow_of_a_turned_ship_is_where_it_is_turned_to(tmp_path):
    # 0.7544 w l is the least tension at the ends of a level catenary over the span l; the bow of the
    # ship that looks back is at 30 m, not at 80 m
    weight = 9.81 * (5.0 - 1025.0 * math.pi * 0.05**2 / 4.0)
    written(tmp_path, YAWED, f"winch.tension={0.7544 * weight * 30.0 + 5.0}")
    with pytest.raises(SceneError, match="the least tension with which"):
        written(tmp_path, YAWED, f"winch.tension={0.7544 * weight * 30.0 - 5.0}")


def test_a_trolley_hangs_between_the_posts_of_a_turned_ship(tmp_path):
    written(tmp_path, HAULED)
    with pytest.raises(SceneError, match="between 0 m and 30 m, found 40 m"):
        written(tmp_path, HAULED, "cargo.on.place=40 m")
    beam = "ship.points.bow=[0, 25 m, 8.5 m]"  # of a ship that heads along y: towards the line
    written(tmp_path, HAULED, beam, "ship.attitude=[0, 0, 90 deg]")
    with pytest.raises(SceneError, match="found it aslant"):
        written(tmp_path, HAULED, beam, "ship.attitude=[0, 0, 80 deg]")


@pytest.mark.parametrize(
    ("attitude", "place"),
    [
        # roll takes y to z, pitch z to x, yaw x to y: in this order all three bring it back
        ((90.0, 0.0, 0.0), (1.0, 2.0, 4.0)),
        ((90.0, 90.0, 0.0), (2.0, 2.0, 3.0)),
        ((90.0, 90.0, 90.0), (1.0, 3.0, 3.0)),
        ((0.0, 90.0, 90.0), (0.0, 2.0, 3.0)),
    ],
)
def test_a_body_turns_by_roll_then_pitch_then_yaw(attitude, place):
    ship = Body(
        mass=1.0, position=(1.0, 2.0, 3.0), points={"p": (0.0, 1.0, 0.0)},
        attitude=tuple(map(math.radians, attitude)),
    )  # fmt: skip
    assert anchor({"ship": ship}, "ship.p") == pytest.approx(place, abs=1e-12)


def test_what_still_water_needs_is_not_asked_of_a_line_in_a_current(tmp_path):
    # a current across a line that slopes can carry all of its weight, and a buoy beyond its span
    current = '{ velocity = ["1.1 m/s", 0, 0] }'
    low = (YAWED, "ship.attitude=[0, 0, 0]", "winch.tension=100 N")
    with pytest.raises(SceneError, match="the least tension"):
        written(tmp_path, *low)
    dragged = "drag={ normal = 1, tangential = 0 }"
    rope = ("rope.diameter=20 mm", f"rope.{dragged}")
    written(tmp_path, *low, f"water.current={current}", *rope)
    sizes = ("before.diameter=20 mm", "after.diameter=20 mm")
    wind = f"air={{ density = 1.2, current = {current} }}"
    wind = (wind, f"before.{dragged}", f"after.{dragged}")
    load_study(HIGHLINE / "delivery.toml", ["targets.cargo.x=70 m", *wind, *sizes])
