"""Hulls that turn over: linear hydrostatics would spin them ever faster, so that they are refused."""

import pytest
from command_line import say
from engine_runs import fixed, line_text, study_of

from lumpedcable.scene import SceneError
from lumpedcable.scene.bodies import Body
from lumpedcable.study.laying import lay_out

# a box of 1 t, 1 m broad and high: T = 1000 / (1025 * 2) m, GM = T / 2 + 1 / (12 T) - 1 / 2
BOX = (
    "gravity = 9.81\n[water]\ndensity = 1025\n"
    '[materials.wire]\nlaw = "linear"\nEA = 2e6\n'
    "[bodies.box]\nmass = 1000\nsize = [2, 1, 1]\nposition = [0, 0, 0]\nattitude = [ROLL, 0, 0]\n"
    "hull = { HULL }\npoints = { eye = [1, 0, 0] }\nMORE\n"
    + line_text("rope", "wire", 12, 6, 1, '"box.eye"', fixed(8, 0, -6), "diameter = 0.03")
    + "[output]\n"
)
DRAUGHT = 1000.0 / 2050.0
HEIGHT = 0.5 * DRAUGHT + 1.0 / (12.0 * DRAUGHT) - 0.5


def box(hull="", more="", roll=0.05):
    return BOX.replace("HULL", hull).replace("MORE", more).replace("ROLL", str(roll))


def test_the_command_says_which_way_and_how_high(tmp_path):
    assert pytest.approx(-0.0853, abs=1e-4) == HEIGHT
    (tmp_path / "scene.toml").write_text(box())
    said = say(tmp_path, "check", "scene.toml")
    assert said.code == 2
    assert "bodies.box.hull: expected a hull that rights itself" in said.err
    assert "turns over in roll, its metacentric height -85.3 mm" in said.err


@pytest.mark.parametrize(
    ("hull", "more"),
    [
        ("above_keel = 0.41", ""),  # 5 mm above where it does
        ("above_water = -0.078", ""),
        ("", f"control.turn_stiffness = [{1.01 * 1000 * 9.81 * -HEIGHT}, 0, 0]"),
        ("", 'free = ["x", "z", "pitch"]'),
    ],
    ids=["low", "low over the water", "held", "not free"],
)
def test_one_that_is_righted_is_taken(tmp_path, hull, more):
    roll = 0 if "free" in more else 0.05
    assert lay_out(study_of(tmp_path, box(hull, more, roll))).coordinates.dimensions >= 2


@pytest.mark.parametrize("hull", ["above_keel = 0.42", "above_water = -0.068"])
def test_one_that_is_not_is_refused(tmp_path, hull):
    with pytest.raises(SceneError, match="turns over in roll"):
        lay_out(study_of(tmp_path, box(hull)))


def test_in_a_plane_it_does_not_roll(tmp_path):
    assert lay_out(study_of(tmp_path, box(roll=0))).coordinates.dimensions == 2


def test_both_ways_are_those_of_a_box():
    body = Body(mass=1000.0, size=(2.0, 1.0, 1.0), hull={})
    ways = body.righting(1025.0, 9.81)
    assert ways["roll"][0] == pytest.approx(HEIGHT, rel=1e-12)
    long = 0.5 * DRAUGHT + 4.0 / (12.0 * DRAUGHT) - 0.5
    assert ways["pitch"] == pytest.approx((long, 9810.0 * long), rel=1e-12)
