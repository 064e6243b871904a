"""Which numbers of a scene have sliders on the live page, what they are called, what they give."""

import numpy as np
import pytest
from command_line import ROOT

from lumpedcable.page.controls import FaultError
from lumpedcable.page.elastic import elastic_model
from lumpedcable.scene import load_study
from lumpedcable.study.resting import Resting

CONFIGS = ROOT / "configs"
HELD = """
[materials.wire]
law = "linear"
EA = "1 MN"

[lines.stay]
material = "wire"
length = 10
segments = 4
mass = 1
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "2 kN", direction = [1, 0, 0] } }

[output]
duration = 1
every = 1
"""
NAMED = """
gravity = 9.81

[water]
density = 1025
current = { profile = "table", z = [-50, 0], velocity = [[0, 0, 0], [1, 0, 0]] }

[seabed]
height = -60
stiffness = "1 MPa"
profile = { x = [0, 100], depth = [0, 5] }

[materials.damping]
law = "polynomial"
coefficients = ["1 MN", "2 MN"]

[lines.stop]
material = "damping"
length = 70
segments = 4
mass = 5
diameter = 0.05
drag = { normal = 1, tangential = 0 }
start = { fixed = [0, 0, -50] }
end = "ship.velocity"

[bodies.ship]
position = [40, 0, 0]
points = { velocity = [1, 0, 0] }
motion = { heave = { amplitude = 1, period = 8, phase = 1 } }

[output]
duration = 1
every = 1
"""


def model_of(folder, text, *sets):
    (folder / "scene.toml").write_text(text)
    return elastic_model(load_study(folder / "scene.toml", sets))


def told(answer):
    return {row["key"]: row["value"] for row in answer["numbers"]}


@pytest.mark.parametrize("changed", [{"1": 0.75}, {"0": 2.0}, {"0": 0.0, "2": -3.0}])
def test_a_direction_has_no_size(tmp_path, changed):
    model = model_of(tmp_path, HELD)
    key = "lines.stay.end.held.direction."
    answer = model.solve({key + axis: value for axis, value in changed.items()})
    numbers = told(answer)
    assert numbers["stay/start_tension"] == pytest.approx(2000.0)
    way = np.diff(answer["lines"][0]["position"], axis=0).sum(axis=0)
    asked = np.array([1.0, 0.0, 0.0])
    for axis, value in changed.items():
        asked[int(axis)] = value
    np.testing.assert_allclose(way / np.linalg.norm(way), asked / np.linalg.norm(asked), atol=1e-9)


def test_no_direction_at_all_is_told(tmp_path):
    with pytest.raises(FaultError, match="expected a direction, found the zero vector"):
        model_of(tmp_path, HELD).solve({"lines.stay.end.held.direction.0": 0.0})


def test_nothing_pulls_a_cantilever_sideways():
    model = elastic_model(load_study(CONFIGS / "peers" / "cantilever.toml"))
    assert abs(told(model.solve({}))["beam/horizontal"]) < 1e-6


def test_the_scene_of_one_run_keeps_its_references_until_a_number_changes(tmp_path):
    study = load_study(CONFIGS / "snapback.toml")
    (tmp_path / "own.toml").write_text(elastic_model(study, 6).toml({}))
    own = load_study(tmp_path / "own.toml")
    assert len(own.runs) == 1
    stated = {key: (values[6],) for key, values in study.references["zhu2018"].values.items()}
    assert own.references["zhu2018"].values == stated
    (tmp_path / "other.toml").write_text(elastic_model(study, 6).toml({"lines.rope.length": 70.0}))
    other = load_study(tmp_path / "other.toml")
    assert other.references == {}
    assert other.runs[0].lines["rope"].length == 70.0


def test_names_hide_no_slider_and_lists_are_counted(tmp_path):
    controls = {control.key: control for control in model_of(tmp_path, NAMED).controls}
    assert {
        "materials.damping.coefficients.1": "coefficients 2",
        "lines.stop.length": "length",
        "lines.stop.mass": "mass",
        "lines.stop.start.fixed.2": "start fixed z",
        "bodies.ship.points.velocity.0": "points velocity x",
        "bodies.ship.motion.heave.phase": "motion heave phase",
        "bodies.ship.motion.heave.amplitude": "motion heave amplitude",
        "water.current.velocity.1.0": "velocity 2 x",
        "water.current.z.1": "z 2",
        "seabed.profile.x.0": "x 1",
        "seabed.profile.depth.1": "depth 2",
    }.items() <= {key: control.words for key, control in controls.items()}.items()
    assert "bodies.ship.motion.heave.period" not in controls


def test_what_grows_from_rest_is_at_its_mean_place(tmp_path):
    model = model_of(tmp_path, NAMED, "bodies.ship.motion.ramp=5 s")
    assert not any("heave" in control.key for control in model.controls)


def test_angles_are_called_so():
    study = load_study(CONFIGS / "highline" / "transfer-sea.toml")
    words = {control.key: control.words for control in elastic_model(study).controls}
    assert words["bodies.supply.control.stiffness.0"] == "control stiffness x"
    turns = [text for key, text in words.items() if "turn_stiffness" in key]
    assert all(text.split()[-1] in ("roll", "pitch", "yaw") for text in turns)


BROKEN = HELD.replace("length = 10\nsegments = 4", "length = 60\nsegments = 8").replace(
    "[output]", '[events.cut]\nbreaks = "stay"\nplace = 30\ntime = 0.001\n\n[output]'
)


def test_a_line_that_breaks_is_cut_where_its_length_says(tmp_path):
    model = model_of(tmp_path, BROKEN)
    assert [len(line["tension"]) for line in model.solve({})["lines"]] == [4, 4]
    longer = model.solve({"lines.stay.length": 80.0})
    assert [len(line["tension"]) for line in longer["lines"]] == [3, 5]
    assert told(longer)["stay-1/length"] == pytest.approx(30.0 * (1 + 2e3 / 1e6), rel=1e-6)


@pytest.mark.parametrize("time", [0.0, pytest.param(1e-12, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_stiff_lines_from_far_too_short_ones_are_found(time):
    study = load_study(CONFIGS / "highline" / "erection.toml")
    lines = Resting(study).solve({"lines.highline.payout.time": time}).lines
    # of inextensible cables: 4122.76 N, and what is asked for
    assert lines["highline"].ends[0] == pytest.approx(4122.76, abs=0.02)
    assert lines["traction"].ends[1] == pytest.approx(4000.0, rel=1e-6)


@pytest.mark.parametrize(
    ("most", "said"), [(0.02, ""), (0.01, ", beyond max_strain of its material, 1 %")]
)
def test_a_strain_that_the_material_does_not_bear_is_told(tmp_path, most, said):
    text = HELD.replace('EA = "1 MN"', f'EA = "1 MN"\nmax_strain = {most}')
    fixed = text.replace(
        '{ held = { pretension = "2 kN", direction = [1, 0, 0] } }', "{ fixed = [10.15, 0, 0] }"
    )
    rows = model_of(tmp_path, fixed).solve({})["numbers"]
    (row,) = (row for row in rows if row["key"] == "stay/strain")
    assert row["words"] == f"largest strain{said}"
    assert row["value"] == pytest.approx(1.5)
