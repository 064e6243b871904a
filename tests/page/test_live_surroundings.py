"""The live page of scenes on water: what floats, its cables and the surface go together."""

import math
from pathlib import Path

import pytest
from scipy.spatial.transform import Rotation

from lumpedcable.page.controls import FaultError
from lumpedcable.page.elastic import elastic_model
from lumpedcable.page.live import live_page
from lumpedcable.scene import load_study

CONFIGS = Path(__file__).parents[2] / "configs"
SHIP = """
gravity = 9.81
[water]
density = 1025
[materials.rope]
law = "linear"
EA = "1 MN"
[bodies.ship]
mass = "500 t"
size = [50, 10, 5]
position = [0, 0, 3.2]
hull = { above_keel = 2.5, surface = 2 }
settle = true
control = { stiffness = ["10 kN/m", 0, 0] }
free = ["x", "z", "pitch"]
[lines.hawser]
material = "rope"
length = 60
segments = 8
mass = 1
diameter = 0.03
start = { fixed = [-80, 0, 4] }
end = "ship"
[sea]
height = 1
period = 6
flow = { surface = 2 }
[[sweep.zip]]
"bodies.ship.hull.surface" = [2, 9]
"sea.flow.surface" = [2, 9]
"bodies.ship.position.2" = [3.2, 10.2]
[output]
duration = 1
every = 1
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "ship.toml"
    path.write_text(SHIP)
    return load_study(path)


def test_cables_end_at_ships_that_float():
    study = load_study(CONFIGS / "highline" / "transfer-sea.toml")
    answer = elastic_model(study).solve({})
    (line,) = answer["lines"]
    start, trolley, end = line["position"]
    # the posts stand 10.4955 and 11.2111 m over centres of gravity at 5.3045 and 4.9889 m
    assert start == pytest.approx([0.0, 0.0, 15.8])
    assert end == pytest.approx([0.0, 60.0, 16.2])
    assert trolley[1] == pytest.approx(3.0)


@pytest.mark.slow
def test_the_surface_goes_where_its_slider_is(study):
    model = elastic_model(study)
    keys = [control.key for control in model.controls]
    assert "sea.flow.surface" not in keys
    moved = {"bodies.ship.hull.surface": 4.0}
    before, after = model.solve({}), model.solve(moved)
    assert (before["surroundings"]["surface"], after["surroundings"]["surface"]) == (2.0, 4.0)
    heights = [
        next(p for p in a["points"] if p["name"] == "ship")["at"][2] for a in (before, after)
    ]
    assert heights[1] - heights[0] == pytest.approx(2.0, abs=0.01)
    # and what is saved can be read
    text = model.toml(moved)
    assert text.count("surface = 4.0") == 2


def test_a_run_of_a_sweep_has_its_own_water(study):
    page, _ = live_page(study, 1)
    assert '"surface": 9.0' in page or '"surface":9.0' in page


def test_what_would_be_no_scene_is_told(tmp_path):
    path = tmp_path / "uneven.toml"
    path.write_text(SHIP.split("[sea]")[0].replace("segments = 8", "segment_lengths = [20, 20, 20]")
                    + "[output]\nduration = 1\nevery = 1\n")  # fmt: skip
    model = elastic_model(load_study(path))
    for asked in (model.solve, model.toml):
        with pytest.raises(FaultError, match=r"lines\.hawser\.segment_lengths: expected"):
            asked({"lines.hawser.length": 61.0})


HANGING = """
gravity = 9.81
[materials.rope]
law = "linear"
EA = "1 MN"
[bodies.box]
mass = 100
size = [1, 1, 1]
position = [0.3, 0.2, -2.5]
points = { eye = [0.5, 0, 0.5] }
settle = true
[lines.sling]
material = "rope"
length = 2
segments = 4
mass = 0.1
start = { fixed = [0, 0, 0] }
end = "box.eye"
[output]
duration = 1
every = 1
"""


@pytest.mark.parametrize("eye", [[0.5, 0, 0.5], [0, 0.5, 0.5]])
@pytest.mark.slow
def test_a_body_is_drawn_as_it_has_turned_to_rest(tmp_path, eye):
    path = tmp_path / "box.toml"
    path.write_text(HANGING.replace("[0.5, 0, 0.5]", str(eye)))
    answer = elastic_model(load_study(path)).solve({})
    (box,) = (point for point in answer["points"] if point["name"] == "box")
    # it hangs with its eye above its middle, whatever way it then faces
    above = Rotation.from_quat(box["turn"], scalar_first=True).apply(eye)
    assert above == pytest.approx([0.0, 0.0, math.sqrt(0.5)], abs=1e-6)
    assert box["at"][:2] == pytest.approx([0.0, 0.0], abs=1e-6)
