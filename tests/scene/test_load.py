import re
import subprocess
import sys
from pathlib import Path

import good_scenes
import numpy as np
import pytest

from lumpedcable.scene import (
    CHECKED,
    HarmonicMotion,
    HeldForce,
    LinearMaterial,
    PolynomialMaterial,
    RecordedMotion,
    SceneError,
    TableMaterial,
    TanhMaterial,
    load_study,
)

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
PRETENSION = "lines.rope.end.held.pretension"


def test_snapback_is_the_job_of_the_paper():
    study = load_study(SNAPBACK)
    assert [axis.key for axis in study.axes] == [PRETENSION, "events.break.time"]
    assert study.axes[0].values == (45e3, 180e3, 315e3, 450e3)  # section 3
    assert study.axes[1].values == (0.005, 0.05)  # sections 3 and 4
    assert [axis.unit for axis in study.axes] == ["N", "s"]
    assert [axis.label for axis in study.axes] == ["rope pretension", "break time"]
    assert study.shape == (4, 2)
    rope = study.scene.lines["rope"]
    assert (rope.length, rope.segments, rope.mass, rope.diameter) == (60.0, 200, 2.238, 0.05)
    nylon = study.scene.materials["nylon"]
    assert isinstance(nylon, TanhMaterial)
    assert nylon.tension_only
    # Zhu 2018: zero tension near zero strain, and the four pretensions at the printed strains.
    strains = np.array([0.0994175, 0.1776298, 0.2278275, 0.2922839])
    assert nylon.curve(strains) == pytest.approx(study.axes[0].values, rel=1e-5)
    assert rope.drag is not None
    assert (rope.drag.normal, rope.drag.tangential) == (1.5, 0.01)
    assert study.scene.fluid is study.scene.water
    values = study.references["zhu2018"].values
    assert {len(column) for column in values.values()} == {8}
    # The strains printed in the paper belong to the pretensions of the same runs.
    tensions = [run.lines["rope"].end.held.pretension for run in study.runs]
    assert nylon.curve(np.array(values["static_strain"])) == pytest.approx(tensions, rel=0.012)


def test_runs_are_the_grid_with_the_first_axis_slowest():
    study = load_study(SNAPBACK)
    seen = [(run.lines["rope"].end.held.pretension, run.events["break"].time) for run in study.runs]
    assert seen == [(t, b) for t in (45e3, 180e3, 315e3, 450e3) for b in (0.005, 0.05)]
    assert len(study.runs) == 8
    assert study.runs[-1] == study.runs[7]
    assert study.runs[1:3] == (study.runs[1], study.runs[2])
    assert study.runs.indices(5) == (2, 1)
    assert study.runs.values(5) == {PRETENSION: 315e3, "events.break.time": 0.05}
    with pytest.raises(IndexError):
        study.runs[8]


def test_every_kind_of_part_is_read(bridle):
    scene = load_study(bridle).scene
    assert scene.fluid is scene.air
    assert scene.water is None
    assert scene.gravity is None
    assert scene.air.current.velocity == pytest.approx((10 * 1852 / 3600, 0, 0))
    assert scene.air.current.surface is None
    kinds = {name: type(material) for name, material in scene.materials.items()}
    assert kinds == {
        "steel": LinearMaterial,
        "fibre": PolynomialMaterial,
        "tested": TableMaterial,
    }
    assert scene.materials["fibre"].max_strain == 0.2
    assert scene.materials["tested"].strain == (0.0, 0.1, 0.2)
    assert scene.materials["tested"].tension == (0.0, 20e3, 80e3)
    upper = scene.lines["upper"]
    assert isinstance(upper.start.motion, HarmonicMotion)
    assert upper.start.motion.period == 8.0
    assert upper.end == "bob"
    tail = scene.lines["tail"].end.motion
    assert isinstance(tail, RecordedMotion)
    assert tail.time == (0.0, 1.0, 60.0)
    assert tail.position[2] == (45.0, 1.0, 1.0)
    assert scene.lines["lower"].segment_lengths == (4.0, 3.0, 3.0)
    assert scene.events["cut"].target() == ("upper", None, 37.5)
    assert scene.events["slip"].target() == ("lower", "start", None)
    assert scene.bodies["bob"].mass == 500.0
    assert scene.output.duration == 60.0
    assert scene.solver.rtol == 1e-6


def test_defaults_are_those_of_the_language(rope):
    scene = load_study(rope).scene
    assert (scene.solver.courant, scene.solver.dtype, scene.solver.waves) == (0.9, "float64", None)
    assert (scene.statics.tolerance, scene.statics.max_iterations) == (1e-10, 200)
    assert scene.output.precision == "float64"
    assert "energy" in scene.output.quantities
    assert scene.materials["nylon"].max_strain == 0.5
    assert not scene.materials["nylon"].tension_only
    assert scene.lines["rope"].drag.convention == "textbook"
    assert scene.events["break"].start == 0.0
    assert scene.bodies == {}


def test_direction_is_made_a_unit_vector(rope):
    held = load_study(rope, ["direction=[3, 0, 4]"]).scene.lines["rope"].end.held
    assert isinstance(held, HeldForce)
    assert held.direction == pytest.approx((0.6, 0.0, 0.8), rel=1e-15)


def test_swept_direction_is_a_unit_vector_in_every_run(rope):
    study = load_study(rope, ["direction.2=[0, 1]"])
    directions = [run.lines["rope"].end.held.direction for run in study.runs[:2]]
    assert directions[0] == (1.0, 0.0, 0.0)
    assert directions[1] == pytest.approx((0.5**0.5, 0.0, 0.5**0.5))
    assert study.axes[-1].label == "rope direction z"


def test_a_study_without_sweep_is_one_run(bridle):
    study = load_study(bridle)
    assert study.axes == ()
    assert study.shape == ()
    assert list(study.runs) == [study.scene]


def test_a_swept_number_may_stand_in_the_sweep_alone(tmp_path):
    text = good_scenes.ROPE.replace('pretension = "45 kN", ', "")
    study = load_study(good_scenes.write(tmp_path, text))
    assert study.scene.lines["rope"].end.held.pretension == 45e3


def test_sweep_keys_may_be_written_without_quotes(tmp_path):
    text = good_scenes.ROPE.replace(f'"{PRETENSION}" =', f"{PRETENSION} =")
    study = load_study(good_scenes.write(tmp_path, text))
    assert [axis.key for axis in study.axes] == [PRETENSION]


def test_absent_optional_number_may_be_swept(rope):
    study = load_study(rope, ["solver.courant=[0.5, 0.9]"])
    assert [run.solver.courant for run in study.runs] == [0.5, 0.9, 0.5, 0.9]


def test_text_of_the_file_is_kept_as_it_stands(rope):
    assert load_study(rope).text == good_scenes.ROPE


@pytest.mark.parametrize(
    ("text", "overrides"),
    [
        (good_scenes.ROPE, []),
        (good_scenes.ROPE, ['title=A "rope"', "duration=3 s", "pretension=[45 kN, 90 kN]"]),
        (good_scenes.ROPE, ["breaks=rope@37.5 m", "rope.length=[50 m, 60 m]"]),
        (good_scenes.BRIDLE, []),
        (good_scenes.BRIDLE, ["upper.length=[40 m, 50 m]"]),
    ],
)
def test_effective_text_reads_back_as_the_same_study(tmp_path, text, overrides):
    first = load_study(good_scenes.write(tmp_path, text), overrides)
    again_path = tmp_path / "elsewhere" / "again.toml"
    again_path.parent.mkdir()
    again_path.write_text(first.effective_text)
    again = load_study(again_path)
    assert again.effective_text == first.effective_text
    assert again.axes == first.axes
    assert len(again.runs) == len(first.runs)
    assert again.scene.numbers().items() >= first.scene.numbers().items()
    for part in ("gravity", "water", "air", "bodies", "events", "solver", "statics", "output"):
        assert getattr(again.scene, part) == getattr(first.scene, part)


def test_a_byte_order_mark_and_windows_lines_are_read(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + good_scenes.ROPE.replace("\n", "\r\n").encode())
    assert load_study(path).scene.lines["rope"].length == 60.0


def test_scene_models_are_frozen(rope):
    scene = load_study(rope).scene
    with pytest.raises(ValueError, match="frozen"):
        scene.lines["rope"].length = 3.0


def test_reading_scenes_does_not_load_jax():
    code = (
        f"import sys; from lumpedcable.scene import load_study; load_study({str(SNAPBACK)!r}); "
        "sys.exit('jax' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_of_a_hundred_thousand_runs_few_are_built(rope, scenes_built):
    values = [f"{i} N" for i in range(1, 401)]
    times = [i * 1e-5 for i in range(250)]
    study = load_study(rope, [f"pretension={values}", f"break.time={times}"])
    assert scenes_built[0] < 3 * CHECKED
    assert len(study.runs) == 100_000
    assert study.runs[99_999].lines["rope"].end.held.pretension == 400.0
    assert study.runs[99_999].events["break"].time == 249e-5
    assert study.references == {}


def test_a_value_out_of_reach_is_found_in_a_large_sweep(rope):
    values = [*(f"{i} N" for i in range(1, 400)), "600 kN", *(f"{i} N" for i in range(400, 500))]
    with pytest.raises(SceneError) as caught:
        load_study(rope, [f"pretension={values}", f"break.time={[i * 1e-5 for i in range(250)]}"])
    assert [fault.key for fault in caught.value.faults] == [f'sweep."{PRETENSION}".399']


def test_a_number_of_a_list_of_vectors_is_told_with_the_name_of_the_list(bridle):
    (current,) = re.findall(r"^current = .*$", bridle.read_text(), re.MULTILINE)
    table = 'profile = "table", z = [-20, 0], velocity = [[0, 0, 0], ["5 m/s", 0, 0]]'
    bridle.write_text(bridle.read_text().replace(current, f"current = {{ {table} }}"))
    study = load_study(bridle, ["air.current.velocity.1.0=[4, 5]"])
    assert [axis.label for axis in study.axes] == ["velocity 1 x"]
    assert [run.air.current.velocity[1][0] for run in study.runs] == [4.0, 5.0]
