import json
from pathlib import Path

import good_scenes
import pytest

from lumpedcable.scene import (
    load_study,
)

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
PRETENSION = "lines.rope.end.held.pretension"


def test_numbers_are_every_float_by_path(rope):
    numbers = load_study(rope).scene.numbers()
    assert numbers[PRETENSION] == 45e3
    assert numbers["lines.rope.start.fixed.2"] == 0.0
    assert numbers["materials.nylon.max_strain"] == 0.5
    assert numbers["solver.courant"] == 0.9
    assert "lines.rope.segments" not in numbers
    assert not [key for key in numbers if key.startswith(("references", "title", "sweep"))]
    assert all(type(value) is float for value in numbers.values())


def test_with_numbers_puts_anything_in_without_touching_it(rope):
    scene = load_study(rope).scene
    marks = {key: object() for key in scene.numbers()}
    marked = scene.with_numbers(marks)
    assert marked.lines["rope"].end.held.pretension is marks[PRETENSION]
    assert marked.lines["rope"].start.fixed[1] is marks["lines.rope.start.fixed.1"]
    assert marked.water.density is marks["water.density"]
    assert scene.with_numbers({}) == scene
    assert scene.with_numbers(scene.numbers()) == scene
    assert scene.lines["rope"].end.held.pretension == 45e3  # the original is as it was


@pytest.mark.parametrize("key", ["lines.rop.length", "lines.rope.lenght", "water.current", "x"])
def test_with_numbers_refuses_unknown_paths(rope, key):
    with pytest.raises(KeyError):
        load_study(rope).scene.with_numbers({key: 1.0})


def test_equal_skeletons_are_equal_structures(rope):
    study = load_study(rope)
    bones = study.scene.skeleton()
    assert {run.skeleton() for run in study.runs} == {bones}
    assert json.loads(bones)["lines"]["rope"]["segments"] == 200
    assert json.loads(bones)["lines"]["rope"]["length"] is None
    same = ["title=another", "length=61 m", "courant=0.9", "solver.dtype=float64"]
    assert load_study(rope, same).scene.skeleton() == bones
    for change in [
        "segments=100",
        "tension_only=true",
        "solver.dtype=float32",
        "bending={EI=1}",
        "rope.start={motion={position=[0,0,0]}}",
        "events.two={breaks='rope@3 m', time=0}",
        "breaks=rope@30 m",
    ]:
        assert load_study(rope, [change]).scene.skeleton() != bones, change


def test_data_from_files_are_structure_and_written_lists_are_numbers(bridle, tmp_path):
    scene = load_study(bridle).scene
    assert not [key for key in scene.numbers() if key.startswith("materials.tested.strain")]
    assert "lines.tail.end.motion.time.0" not in scene.numbers()
    bones = scene.skeleton()
    (tmp_path / "tail.csv").write_text(good_scenes.TAIL_CSV.replace("45,0,1", "46,0,1"))
    assert load_study(bridle).scene.skeleton() != bones
    # The name of the file says nothing about the structure.
    (tmp_path / "tail.csv").rename(tmp_path / "other.csv")
    (tmp_path / "other.csv").write_text(good_scenes.TAIL_CSV)
    assert load_study(bridle, ["tail.end.motion.file=other.csv"]).scene.skeleton() == bones
    table = "tested={law='table', strain=[0, 0.3], tension=[0, '50 kN']}"
    inline = load_study(bridle, ["tail.end=bob", table])
    assert inline.scene.numbers()["materials.tested.tension.1"] == 50e3
