import math
from pathlib import Path

import pytest

from lumpedcable.scene import (
    FixedEnd,
    load_study,
)

CONFIGS = Path(__file__).parents[2] / "configs"
SNAPBACK = CONFIGS / "snapback.toml"
PRETENSION = "lines.rope.end.held.pretension"


def test_override_by_full_path_and_by_unique_end():
    by_path = load_study(SNAPBACK, ["events.break.time=50 ms"])
    by_end = load_study(SNAPBACK, ["break.time=50 ms"])
    assert by_path.scene == by_end.scene
    assert by_path.scene.events["break"].time == 0.05


def test_override_of_a_swept_key_takes_its_axis_away():
    study = load_study(SNAPBACK, ["pretension=180 kN"])
    assert [axis.key for axis in study.axes] == ["events.break.time"]
    assert {run.lines["rope"].end.held.pretension for run in study.runs} == {180e3}


@pytest.mark.parametrize("value", ['["90 kN", 100e3]', "[90 kN, 100 kN]", "[90e3, 100e3]"])
def test_override_with_a_list_is_an_axis(value):
    study = load_study(SNAPBACK, [f"pretension={value}"])
    assert [axis.key for axis in study.axes] == [PRETENSION, "events.break.time"]
    assert study.axes[0].values == (90e3, 100e3)


def test_override_with_a_list_adds_an_axis_last(rope):
    study = load_study(rope, ["segments=[100, 200, 400]"])
    assert [axis.key for axis in study.axes] == [PRETENSION, "lines.rope.segments"]
    assert study.axes[1].values == (100, 200, 400)
    assert study.axes[1].unit == ""
    assert [run.lines["rope"].segments for run in study.runs] == [100, 200, 400] * 2


def test_override_with_a_list_for_a_vector_is_a_vector(rope):
    study = load_study(rope, ["fixed=[0, 0, 5 m]"])
    assert study.scene.lines["rope"].start == FixedEnd(fixed=(0.0, 0.0, 5.0))


@pytest.mark.parametrize(
    ("override", "value"),
    [
        ("solver.dtype=float32", lambda s: s.solver.dtype == "float32"),
        ("output.precision=float32", lambda s: s.output.precision == "float32"),
        ("precision=float32", lambda s: s.output.precision == "float32"),
        ("waves=viscous", lambda s: s.solver.waves == "viscous"),
        ("tension_only=true", lambda s: s.materials["nylon"].tension_only),
        ("segments=50", lambda s: s.lines["rope"].segments == 50),
        ("fixed.2=3 m", lambda s: s.lines["rope"].start.fixed == (0.0, 0.0, 3.0)),
        ("rope.end={fixed=[61,0,0]}", lambda s: s.lines["rope"].end.fixed == (61.0, 0.0, 0.0)),
        ("title = A = B", lambda s: s.title == "A = B"),
        ('length="59 m"', lambda s: s.lines["rope"].length == 59.0),
        ("break.start=0.1 s", lambda s: s.events["break"].start == 0.1),
        ("drag.normal=2", lambda s: s.lines["rope"].drag.normal == 2.0),
        ("bodies.bob={mass='1 t'}", lambda s: s.bodies["bob"].mass == 1000.0),
    ],
)
def test_override_reaches_what_the_language_allows(rope, override, value):
    assert value(load_study(rope, [override]).scene)


def test_an_end_that_the_scene_gives_comes_before_one_it_could_give(rope):
    # "start" is given by the line, and could be given by the event.
    scene = load_study(rope, ["start=free"]).scene
    assert scene.lines["rope"].start == "free"


def test_the_last_override_of_a_key_wins(rope):
    study = load_study(rope, ["pretension=90 kN", "pretension=[1 kN, 2 kN]", "pretension=5 kN"])
    assert study.scene.lines["rope"].end.held.pretension == 5e3
    assert study.axes == ()
    assert study.overrides[-1] == "pretension=5 kN"


def test_references_follow_the_runs_that_overrides_leave():
    study = load_study(SNAPBACK, ["break.time=50 ms", "segments=[100, 200]"])
    moved = study.references["zhu2018"].values["end_displacement"]
    # section 4 of the paper, each pretension for both meshes
    assert moved == tuple(d for d in (7.57, 12.86, 16.87, 20.74) for _ in range(2))
    partly = load_study(SNAPBACK, ["pretension=[100 kN, 180 kN]", "break.time=5 ms"])
    moved = partly.references["zhu2018"].values["end_displacement"]
    assert math.isnan(moved[0])
    assert moved[1] == 12.66
    assert load_study(SNAPBACK, ["pretension=100 kN"]).references == {}


def test_references_may_leave_runs_out(rope):
    given = load_study(rope).references["paper"].values["static_strain"]
    assert given[0] == 0.1
    assert math.isnan(given[1])
