"""Scenes at rest: numbers, table, file and figure; the scenes of a highline."""

from pathlib import Path

import numpy as np
import pytest
import xarray
from command_line import refused, rest_of, say
from highline_numbers import (
    DROP,
    EXACT_80_KN,
    EXACT_SHORT,
    FROM_80_KN,
    FROM_LENGTH,
    FROM_SAG,
    LOWERED,
    PLACES,
    SPAN,
    STRAIGHT_SHORT,
    WEIGHT,
)
from scipy.optimize import brentq

from lumpedcable.exact import dragged_from_tension, highline_from_length
from lumpedcable.results import open_result
from lumpedcable.results.chord import along_chord
from lumpedcable.scene import load_study
from lumpedcable.study.cables import cables
from lumpedcable.study.run import run_study

CONFIGS = Path(__file__).parents[2] / "configs" / "highline"
KEYS = ("sag", "horizontal_tension", "start_tension", "end_tension")


@pytest.fixture(scope="module")
def delivery(tmp_path_factory):
    """The delivery with cargo at 10 and 30 m on eight segments, run as a user does."""
    folder = tmp_path_factory.mktemp("delivery")
    said = say(
        folder, "run", CONFIGS / "delivery.toml", "-o", "d.h5", "--set", "before.segments=4",
        "--set", "after.segments=4", "--set", "cargo.x=[10 m, 30 m]",
    )  # fmt: skip
    assert (said.code, said.err) == (0, "")
    return folder, said.out


def test_the_file_holds_the_numbers_of_the_cable(delivery):
    with open_result(delivery[0] / "d.h5") as result:
        assert result.status == ["ok", "ok"]
        assert (result.cables, result.time.tolist()) == (["before+after"], [0.0])
        numbers = result.rest("before+after")
        ends = result.line("before").field("start_tension")[:, 0]
    rows = [PLACES.index(place) for place in (10.0, 30.0)]
    for model, table in (("exact", EXACT_SHORT), ("straight", STRAIGHT_SHORT)):
        found = np.array([numbers[f"{model}_{key}"] for key in KEYS]).T
        assert found == pytest.approx(np.array(table)[rows, 1:], rel=1e-8)
        assert numbers[f"{model}_joint_z"] == pytest.approx(-np.array(table)[rows, 0], rel=1e-8)
    # the mesh's error with four segments on either side of the cargo
    computed = np.array([numbers[key] for key in KEYS]).T
    assert computed == pytest.approx(np.array(EXACT_SHORT)[rows, 1:], rel=5e-3)
    assert numbers["start_tension"] == pytest.approx(ends)
    assert numbers["length"] == pytest.approx(62.5)
    assert numbers["joint_x"] == pytest.approx([10.0, 30.0])


def test_places_along_a_line_are_those_of_the_length_that_was_found(delivery):
    with open_result(delivery[0] / "d.h5") as result:
        joints = result.rest("before+after")["joint_length"]
        for run in (0, 1):
            before, after = (result.line(name).unstretched_position(run) for name in result.lines)
            assert (before[0], after[0]) == (0.0, 0.0)
            assert before[-1] == pytest.approx(joints[run])
            assert before[-1] + after[-1] == pytest.approx(62.5, rel=1e-9)
            middles = result.line("before").unstretched_segment(run)
            assert middles == pytest.approx(0.5 * (before[1:] + before[:-1]))
    with xarray.open_dataset(delivery[0] / "d.h5", engine="h5netcdf", group="lines/before") as line:
        assert "unstretched_position" in line.coords


TARGET = """
[targets.length]
change = "lines.line.length"
of = "line"
length = "45 m"
"""


@pytest.mark.slow  # four programs for a state of rest
@pytest.mark.parametrize(("length", "target"), [("45 m", ""), ("41 m", TARGET)])
def test_runs_of_other_meshes_have_their_own_places(tmp_path, length, target):
    (tmp_path / "scene.toml").write_text(f"""
gravity = 9.81
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.line]
material = "wire"
length = "{length}"
segments = 2
mass = "2 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ fixed = [40, 0, 0] }}
{target}
[output]
[sweep]
"lines.line.segments" = [2, 3]
""")
    run_study(load_study(tmp_path / "scene.toml"), tmp_path / "out.h5")
    with open_result(tmp_path / "out.h5") as result:
        line = result.line("line")
        assert line.unstretched_position(0)[:3] == pytest.approx([0.0, 22.5, 45.0])
        assert np.isnan(line.unstretched_position(0)[3])
        assert line.unstretched_position(1) == pytest.approx([0.0, 15.0, 30.0, 45.0])


def test_the_table_stands_beside_the_closed_forms(delivery):
    out = delivery[1]
    rows = [line.split() for line in out.splitlines()]
    ten = next(row for row in rows if row[:3] == ["0", "10", "m"])
    # exact and straight: 71.87949676 and 67.38557108 kN
    assert "71.8795" in ten
    assert "67.3856" in ten
    assert ten[-1] == "ok"
    assert "Straight segments against exact: start tension -6.25 to -6.17 %" in out


def test_the_figure_is_drawn(delivery):
    said = say(delivery[0], "plot", "d.h5")
    assert said.code == 0
    assert [Path(line).name for line in said.out.split()] == ["rest.png"]
    assert (delivery[0] / "d" / "rest.png").stat().st_size > 20_000
    assert "before+after" not in say(delivery[0], "info", "d.h5").err


def test_places_count_towards_the_end_of_a_cable():
    # ends over (3, 4): 10 m along it are (6, 8); what is blown back over the start counts backwards
    nodes = np.array([[[1.0, 1.0 - 3.0, 1.0 + 6.0], [2.0, 2.0 - 4.0, 2.0 + 8.0], [0.0, -9.0, 1.0]]])
    assert along_chord(nodes) == pytest.approx(np.array([[0.0, -5.0, 10.0]]), rel=1e-14)
    nodes[:, :2, 2] += 50.0  # what lies beside the chord counts by its share along it
    away = nodes[0, :2, 1] - nodes[0, :2, 0]
    chord = nodes[0, :2, 2] - nodes[0, :2, 0]
    assert along_chord(nodes)[0, 1] == pytest.approx(away @ chord / np.linalg.norm(chord))
    nodes[:, :2, 2] = nodes[:, :2, 0]  # and with the ends over each other, from the plumb line
    assert along_chord(nodes) == pytest.approx(np.array([[0.0, 5.0, 0.0]]))


def test_what_a_cable_is():
    def named(file):
        return [(c.name, c.body, c.spans) for c in cables(load_study(CONFIGS / file, []).scene)]

    assert named("delivery.toml") == [("before+after", "cargo", True)]
    assert named("erection.toml") == [("highline+traction", None, True)]
    assert named("adjustment.toml") == [("highline", None, True)]
    # a line that hangs from one place alone spans nothing
    hung = load_study(CONFIGS / "adjustment.toml", ["highline.end=free"]).scene
    assert [(c.lines, c.spans) for c in cables(hung)] == [(("highline",), False)]


def test_every_stage_has_a_scene():
    stages = ("erection", "stabilisation", "stabilisation-sag", "adjustment", "delivery",
              "delivery-tension", "unloading", "withdrawal")  # fmt: skip
    assert {path.stem for path in CONFIGS.glob("*.toml")} >= set(stages)
    for stage in stages:
        study = load_study(CONFIGS / f"{stage}.toml", [])
        assert study.scene.output.static


def rest(tmp_path, stage, *changes):
    """The numbers of a scene's one cable."""
    options = [part for change in changes for part in ("--set", change)]
    said = say(tmp_path, "run", CONFIGS / f"{stage}.toml", "-o", "out.h5", *options)
    assert (said.code, said.err) == (0, "")
    with open_result(tmp_path / "out.h5") as result:
        (cable,) = result.cables
        return result.rest(cable)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stage", "expected"),
    [
        ("stabilisation", [FROM_LENGTH[:5]]),
        ("stabilisation-sag", [FROM_SAG[:5]]),
        ("adjustment", [FROM_80_KN[:5]]),
        ("unloading", [FROM_80_KN[:5], *(row[:5] for row in LOWERED.values())]),
    ],
)
def test_the_stages_under_their_own_weight(tmp_path, stage, expected):
    numbers = rest(tmp_path, stage)
    order = ("length", "sag", "start_tension", "end_tension", "horizontal_tension")
    computed = np.array([numbers[key] for key in order]).T
    # second order in 1/64, and what 75 GN still stretch
    assert computed == pytest.approx(np.array(expected), rel=2e-4)
    exact = np.array([numbers[f"exact_{key}"] for key in order]).T
    assert exact == pytest.approx(np.array(expected), rel=1e-8)


@pytest.mark.slow
def test_delivery_at_constant_tension(tmp_path):
    numbers = rest(tmp_path, "delivery-tension", "cargo.x=[10, 20, 30, 40, 50]")
    computed = np.array([numbers[key] for key in (*KEYS, "length")]).T
    assert computed == pytest.approx(np.array(EXACT_80_KN)[:, 1:], rel=2e-4)
    assert numbers["straight_sag"] / numbers["exact_sag"] - 1.0 == pytest.approx(-0.065, abs=2e-3)


@pytest.mark.slow
def test_erection_and_withdrawal(tmp_path):
    out, back = rest(tmp_path, "erection"), rest(tmp_path, "withdrawal")
    assert out["joint_length"] == pytest.approx(4.0 + np.array([0, 10, 20, 30, 40, 50, 55]))
    line = dragged_from_tension(SPAN, DROP, WEIGHT, out["joint_length"], 5.0, 4e3)
    x, z = line.middle
    assert out["joint_x"] == pytest.approx(x, rel=1e-4)
    assert out["joint_z"] == pytest.approx(z, rel=1e-4)
    assert out["start_tension"] == pytest.approx(line.tension_a, rel=1e-4)
    # both have 59 m and 4 m out at an end of the way
    for key in ("joint_x", "joint_z", "start_tension"):
        assert out[key][[0, -1]] == pytest.approx(back[key][[-1, 0]], rel=1e-6)


# --- lines that keep their length, or bend, or have one segment -----------------------------------

LINE = """
gravity = 9.81
[materials.wire]
{law}
[lines.span]
material = "wire"
length = {length}
segments = {segments}
mass = 1
start = {{ fixed = [0, 0, 0] }}
end = {{ fixed = [9, 0, 1] }}
[output]
"""
ELASTIC, RODS = 'law = "linear"\nEA = 1e9', 'law = "inextensible"\n[solver]\nstep = "1 ms"'


@pytest.mark.slow
def test_rods_have_a_table_at_rest(tmp_path):
    """13 m over 9.06 m: an inextensible catenary, by its own equations."""
    found = rest_of(tmp_path, LINE.format(law=RODS, length=13, segments=80))
    # 2 a sinh(span / 2a) = sqrt(length^2 - rise^2), H = w a
    a = brentq(lambda a: 2 * a * np.sinh(4.5 / a) - np.sqrt(13.0**2 - 1.0), 1.0, 100.0)
    assert found["horizontal_tension"] == pytest.approx(9.81 * a, rel=1e-3)
    lowest = 4.5 - a * np.arcsinh(1.0 / (2 * a * np.sinh(4.5 / a)))
    assert found["start_tension"] == pytest.approx(9.81 * a * np.cosh(lowest / a), rel=1e-3)


@pytest.mark.parametrize("law", [ELASTIC, RODS], ids=["elastic", "rods"])
def test_a_line_of_one_segment_is_its_chord(tmp_path, law):
    found = rest_of(tmp_path, LINE.format(law=law, length=np.hypot(9, 1), segments=1))
    assert found["sag"] == 0.0


def test_no_sag_is_asked_of_one_segment(tmp_path):
    text = LINE.format(law=ELASTIC, length=10, segments=1)
    text += '[targets.deep]\nchange = "lines.span.length"\nof = "span"\nsag = 1\n'
    (tmp_path / "scene.toml").write_text(text)
    told = refused(tmp_path, "run", "scene.toml")
    assert 'expected a line of two segments at least, found "span" with one' in told


@pytest.mark.slow
def test_the_slack_line_of_a_tension_is_remarked_on(tmp_path):
    said = say(
        tmp_path, "run", CONFIGS / "adjustment.toml", "--set", "winch.tension=3 kN",
        "--set", "highline.length=[62.2 m, 130 m]",
    )  # fmt: skip
    assert "run 1: this line is slack" in " ".join(said.out.split())
    with open_result(tmp_path / "adjustment.h5") as result:
        found = result.rest("highline")["length"]
    # both pull at the sending end with 3 kN; 64 chords: of the order of (1/64)^2
    ends = [
        brentq(lambda S: highline_from_length(SPAN, DROP, WEIGHT, S).tension_a - 3e3, *sides)
        for sides in ((62.2, 70.0), (100.0, 200.0))
    ]
    assert found == pytest.approx(ends, rel=1e-3)
