"""Cases and rows that move together: what each of them has, and what it leaves to the scene."""

import good_scenes
import numpy as np
import pytest
from swept_rope import LIST, PRETENSION, REFERENCE, TIME, faults, study_of, values

from lumpedcable.scene import load_study


def test_cases_have_names_and_keys_of_their_own(tmp_path):
    study = study_of(
        tmp_path,
        f'[[sweep.cases]]\nname = "as built"\n'
        f'[[sweep.cases]]\nname = "tight"\n"{PRETENSION}" = "180 kN"\n'
        f'[[sweep.cases]]\nname = "long"\nlines.rope.length = "80 m"\n"{TIME}" = 0\n',
    )
    assert [study.runs.name(run) for run in range(3)] == ["as built", "tight", "long"]
    seen = [
        (r.lines["rope"].end.held.pretension, r.lines["rope"].length, r.events["break"].time)
        for r in study.runs
    ]
    assert seen == [(45e3, 60.0, 0.005), (180e3, 60.0, 0.005), (45e3, 80.0, 0.0)]


def test_what_a_case_leaves_out_may_be_what_its_absence_stands_for(tmp_path):
    start = "events.break.start"  # 0 if it is not given
    study = study_of(
        tmp_path,
        f'[[sweep.cases]]\nname = "at once"\n[[sweep.cases]]\nname = "later"\n{start} = "2 ms"\n',
    )
    assert [r.events["break"].start for r in study.runs] == [0.0, 0.002]


def test_what_one_case_gives_is_none_of_another(tmp_path):
    start = "events.break.start"
    cases = (
        f'[[sweep.cases]]\nname = "later"\n{start} = "2 ms"\n[[sweep.cases]]\nname = "at once"\n'
    )
    study = study_of(tmp_path, cases)
    assert [r.events["break"].start for r in study.runs] == [0.002, 0.0]
    study = study_of(tmp_path, cases, ["events.break.start=3 ms"])
    assert study.scene.events["break"].start == 0.003
    # a number that the scene must give, or each case
    key = "lines.rope.payout.speed"
    table = '"lines.rope.payout.time" = "1 s"\n'
    found = faults(tmp_path, f'[[sweep.cases]]\n"{key}" = "1 m/s"\n{table}[[sweep.cases]]\n{table}')
    assert found == [
        (f'sweep.cases.1."{key}"', f'expected "{key}" in every case or in the scene, found nothing')
    ]


def test_rows_are_judged_as_they_are_not_with_what_the_scene_has(tmp_path):
    # the second key is absent in the scene, whose first one goes with no row
    text = good_scenes.ROPE[:REFERENCE].replace(LIST, "")
    text = (
        text.replace("[water]", "[water]\nsurface = 0")
        + """
[sea]
height = "2 m"
period = "8 s"
depth = "40 m"
flow = {}
[sweep.zip]
"water.surface" = ["1 m", "2 m"]
"sea.flow.surface" = ["1 m", "2 m"]
"""
    )
    study = load_study(good_scenes.write(tmp_path, text))
    assert [(r.water.surface, r.sea.flow.surface) for r in study.runs] == [(1, 1), (2, 2)]


def test_a_scene_keeps_its_numbers_beside_a_row_that_has_others(tmp_path):
    # the damping stands in the cases alone, the pretension in the scene as well
    damping = "materials.nylon.damping"
    cases = f'[[sweep.cases]]\n"{damping}" = 100\n"{PRETENSION}" = "180 kN"\n'
    study = study_of(tmp_path, cases + f'[[sweep.cases]]\n"{damping}" = 0\n')
    alone = study_of(tmp_path, "").scene
    assert study.scene.lines["rope"].end == alone.lines["rope"].end
    assert study.scene.materials["nylon"].damping == 100
    assert values(study, PRETENSION) == [180e3, alone.lines["rope"].end.held.pretension]


def test_what_the_program_chooses_is_no_number_of_the_scene(tmp_path):
    key = "solver.courant"
    found = faults(tmp_path, f'[[sweep.cases]]\n"{key}" = 0.1\n[[sweep.cases]]\n')
    assert ("sweep.cases.1.\"solver.courant\"", f'expected "{key}" in every case or in the scene, '
            "found nothing") in found  # fmt: skip


@pytest.mark.parametrize("values_", [[1, 8], [-1, 0.5, 1]])
def test_a_component_of_a_direction_is_one_of_that_which_is_given(tmp_path, values_):
    text = good_scenes.ROPE[:REFERENCE].replace(LIST, "")
    assert "direction = [1, 0, 0]" in text
    text = text.replace("direction = [1, 0, 0]", "direction = [3, 0, 4]")
    key = "lines.rope.end.held.direction.2"
    study = load_study(good_scenes.write(tmp_path, text + f'[sweep]\n"{key}" = {values_}\n'))
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "scene.toml").write_text(study.effective_text)
    again = load_study(tmp_path / "again" / "scene.toml")
    for one in (study, again):
        for run, z in zip(one.runs, values_, strict=True):
            exact = np.array([3.0, 0.0, z]) / np.hypot(3.0, z)
            assert run.lines["rope"].end.held.direction == pytest.approx(exact, abs=1e-12)


def test_components_that_have_length_one_at_both_ends_are_not_so_between(tmp_path):
    key = "lines.rope.end.held.direction.0"
    study = study_of(tmp_path, f'[sweep]\n"{key}" = [-1, 0.5, 1]\n')
    assert [run.lines["rope"].end.held.direction[0] for run in study.runs] == [-1, 1, 1]


def test_a_case_without_keys_is_the_scene_as_it_is(tmp_path):
    study = study_of(tmp_path, f'[[sweep.cases]]\n[[sweep.cases]]\n"{PRETENSION}" = "180 kN"\n')
    asked = study.scene.lines["rope"].end.held.pretension
    assert [r.lines["rope"].end.held.pretension for r in study.runs] == [asked, 180e3]
    assert asked != 180e3
