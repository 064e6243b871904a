import math
from pathlib import Path

import good_scenes
import pytest

from lumpedcable.scene import (
    FixedEnd,
    SceneError,
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
    assert load_study(SNAPBACK, "break.time=50 ms").scene == by_end.scene  # one text alone


def test_override_of_a_swept_key_takes_its_axis_away():
    study = load_study(SNAPBACK, ["pretension=180 kN"])
    assert [axis.key for axis in study.axes] == ["events.break.time"]
    assert {run.lines["rope"].end.held.pretension for run in study.runs} == {180e3}


def test_an_override_of_several_lines_is_one_value(rope):
    study = load_study(rope, ["fixed=[0,  # no way along\n 0,\n 5 ]", 'title="""a\nb"""'])
    assert study.scene.lines["rope"].start == FixedEnd(fixed=(0.0, 0.0, 5.0))
    assert study.scene.title == "a\nb"
    again = load_study(good_scenes.write(rope.parent, study.effective_text))
    assert again.scene.title == study.scene.title


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


@pytest.mark.parametrize(
    ("swept", "override"),
    [
        ('"lines.rope.segments" = [5, 10]', "rope.segments=10"),
        ('"materials.nylon.breaking_strength" = ["1 MN", "2 MN"]', "breaking_strength=2 MN"),
        ('"lines.rope.end.held.direction.2" = [1, 2]', "direction.2=2"),
        ('"lines.rope.end.held.pretension" = ["45 kN", "90 kN"]', "pretension=90 kN"),
    ],
)
def test_references_follow_any_number_that_is_set(rope, swept, override):
    text = good_scenes.ROPE
    text = text[: text.index("[sweep]")] + text[text.index("[solver]") : text.index("[references")]
    text += f'[sweep]\n{swept}\n[references.paper]\nsource = "x"\nvalues = {{ reach = [3, 4] }}\n'
    study = load_study(good_scenes.write(rope.parent, text), [override])
    assert study.references["paper"].values["reach"] == (4.0,)


def test_references_may_leave_runs_out(rope):
    given = load_study(rope).references["paper"].values["static_strain"]
    assert given[0] == 0.1
    assert math.isnan(given[1])


CUT = good_scenes.ROPE.replace('"rope.end"\n', '"rope@37.5 m"\n').replace(
    '{ held = { pretension = "45 kN", direction = [1, 0, 0] } }', '{ fixed = ["61 m", 0, 0] }'
)
CUT = CUT[: CUT.index("[sweep]")] + CUT[CUT.index("[solver]") : CUT.index("[references")]


def test_a_place_in_the_short_form_is_overridden_and_swept_like_any_other(tmp_path):
    measures = '[measures.here]\ntension = "rope@30 m"\n'
    path = good_scenes.write(tmp_path, CUT + measures)
    scene = load_study(path, ["break.place=20 m", "here.place=10 m"]).scene
    assert (scene.events["break"].breaks, scene.events["break"].place) == ("rope", 20.0)
    assert (scene.measures["here"].tension, scene.measures["here"].place) == ("rope", 10.0)
    study = load_study(path, ["break.place=[20 m, 30 m]"])
    assert [run.events["break"].place for run in study.runs] == [20.0, 30.0]
    swept = '[sweep]\n"events.break.place" = [20, 30]\nmeasures.here.place = ["5 m", "6 m"]\n'
    study = load_study(good_scenes.write(tmp_path, CUT + measures + swept))
    assert study.scene.events["break"].place == 37.5
    places = [(r.events["break"].place, r.measures["here"].place) for r in study.runs]
    assert places == [(20.0, 5.0), (20.0, 6.0), (30.0, 5.0), (30.0, 6.0)]
    # the short form itself is still replaced as a whole, by a place or by an end
    path = good_scenes.write(tmp_path, CUT)
    assert load_study(path, ["breaks=rope@12 m"]).scene.events["break"].place == 12.0
    assert load_study(path, ["breaks=rope.start"]).scene.events["break"].place is None
    with pytest.raises(SceneError, match="found place and breaks"):
        load_study(path, ["breaks=rope.start", "break.place=12 m"])
    for wrong in ("breaks=rope@90 m", "break.place=90 m"):
        with pytest.raises(
            SceneError, match=f"^--set {wrong}: events.break.place: expected a place"
        ):
            load_study(path, [wrong])


def test_a_measured_place_off_its_line_is_told_where_it_is_written(tmp_path):
    path = good_scenes.write(tmp_path, f'{CUT}[measures.here]\nspeed = "rope@90 m"\n')
    with pytest.raises(SceneError) as caught:
        load_study(path)
    (fault,) = caught.value.faults
    line = path.read_text().splitlines().index('speed = "rope@90 m"') + 1
    assert (fault.key, fault.line) == ("measures.here.place", line)


def test_a_text_that_looks_like_a_number_stays_a_text(tmp_path):
    path = good_scenes.write(tmp_path, CUT)
    for value in ("12", "1e3", "true", "[1, 2]", "2018-01-30", '"12"'):
        assert load_study(path, [f"title={value}"]).scene.title == value.strip('"')


def test_what_is_a_text_now_may_become_a_table(tmp_path):
    path = good_scenes.write(tmp_path, CUT)
    scene = load_study(path, ["lines.rope.end='free'", "lines.rope.end={fixed=[54, 0, 0]}"]).scene
    assert scene.lines["rope"].end.fixed == (54.0, 0.0, 0.0)


def test_an_item_of_a_list_has_one_number(tmp_path):
    path = good_scenes.write(tmp_path, CUT)
    with pytest.raises(SceneError, match=r'found "lines.rope.end.fixed.00"'):
        load_study(path, ["lines.rope.end.fixed.00=54 m"])
    swept = f'{CUT}[sweep]\n"lines.rope.end.fixed.00" = [54, 55]\n'
    with pytest.raises(SceneError, match=r"expected the full path of a number of the scene, found"):
        load_study(good_scenes.write(tmp_path, swept))


def test_draws_can_be_fewer_and_others(tmp_path):
    draws = f'{CUT}[sweep.sample]\ncount = 64\n"lines.rope.mass" = {{ from = 1, to = 2 }}\n'
    path = good_scenes.write(tmp_path, draws)
    few = load_study(path, ["sweep.sample.count=4", "sweep.sample.seed=3"])
    masses = [run.lines["rope"].mass for run in few.runs]
    written = good_scenes.write(tmp_path, draws.replace("64", "4\nseed = 3"))
    assert masses == [run.lines["rope"].mass for run in load_study(written).runs]
    assert len(masses) == 4
    again = load_study(good_scenes.write(tmp_path, few.effective_text))
    assert [run.lines["rope"].mass for run in again.runs] == masses
    with pytest.raises(
        SceneError, match=r"sweep\.sample\.count: expected a whole number from 1 to"
    ):
        load_study(good_scenes.write(tmp_path, draws), ["sweep.sample.count=0"])


def test_draws_that_were_written_down_are_set_as_before(tmp_path):
    draws = f'{CUT}[sweep.sample]\ncount = 64\n"lines.rope.mass" = {{ from = 1, to = 2 }}\n'
    text = load_study(good_scenes.write(tmp_path, draws)).effective_text
    assert "[[sweep.sample]]" in text
    assert len(load_study(good_scenes.write(tmp_path, text), ["sweep.sample.count=4"]).runs) == 4


def test_a_place_in_short_takes_its_axis_away(tmp_path):
    swept = f'{CUT}[sweep]\n"events.break.place" = ["20 m", "30 m"]\n'
    path = good_scenes.write(tmp_path, swept)
    assert [run.events["break"].place for run in load_study(path).runs] == [20.0, 30.0]
    study = load_study(path, ["break.breaks=rope@33 m"])
    assert [(run.events["break"].breaks, run.events["break"].place) for run in study.runs] == [
        ("rope", 33.0)
    ]


def test_an_override_adds_a_branch_of_a_material(rope):
    fast = "materials.nylon.relaxation.fast"
    study = load_study(SNAPBACK, [f"{fast}={{EA='3 kN', time='20 ms'}}", "fast.EA=[1 kN, 2 kN]"])
    assert study.axes[-1].label == "nylon fast EA"
    branches = [run.materials["nylon"].relaxation["fast"] for run in study.runs[:2]]
    assert [(one.EA, one.time) for one in branches] == [(1e3, 0.02), (2e3, 0.02)]
    again = load_study(good_scenes.write(rope.parent, study.effective_text))
    assert again.runs[1].materials == study.runs[1].materials
    # what is not there has no names below it, and a part of an entry is none
    for wrong in (fast.replace("nylon", "nylom"), f"{fast}.EA"):
        with pytest.raises(SceneError, match=r"did you mean \"materials\.nylon\.relaxation\""):
            load_study(SNAPBACK, [f"{wrong}={{EA='3 kN', time='20 ms'}}"])
