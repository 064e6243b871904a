"""What the live page opens with: a scene's own numbers at rest, by a stage that has them or itself."""

import json
import re

import pytest
from command_line import ROOT
from highline_numbers import EXACT_SHORT, FROM_80_KN, FROM_LENGTH, FROM_SAG
from page.test_live_page import HIGHLINE

from lumpedcable.exact import dragged_from_tension, elastic_catenary, loaded_from_length
from lumpedcable.page.highline import highline_of
from lumpedcable.page.live import live_page
from lumpedcable.scene import load_study
from lumpedcable.study.resting import Resting

CONFIGS = ROOT / "configs"


def opened(path, *edits, run=0):
    """The head of the page and the numbers by key that it opens with."""
    page, answers = live_page(load_study(path, edits), run)
    head = json.loads(re.search(r'<script id="head"[^>]*>(.*?)</script>', page, re.DOTALL)[1])
    found = answers["/solve"]({"model": head["first"], "values": {}})
    return head, {row["key"]: row["value"] for row in found["numbers"]}


def wrote(folder, text):
    path = folder / "scene.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('gravity = "10 m/s2"', ""),
        ('gravity = "10 m/s2"', 'gravity = "10 m/s2"\n[seabed]\nheight = -90\nstiffness = 1e5'),
        ("{ fixed = [60, 0, -16] }", '"free"'),
        ("{ fixed = [60, 0, -16] }", "{ fixed = [0, 0, -16] }"),
        (
            "{ fixed = [60, 0, -16] }",
            "{ motion = { position = [60, 0, -16], velocity = [1, 0, 0] } }",
        ),
    ],
    ids=["no gravity", "a bed", "one end", "one above the other", "an end that is moved"],
)
def test_other_scenes_are_no_highline(tmp_path, old, new):
    path = wrote(tmp_path, HIGHLINE)
    assert highline_of(load_study(path).scene) is not None
    wrote(tmp_path, HIGHLINE.replace(old, new))
    assert highline_of(load_study(path).scene) is None


# S, f, F_H, F_TA, F_TB (m, N) of the references; of the dragged ones by their own closed form
@pytest.mark.parametrize(
    ("scene", "run", "first", "known"),
    [
        ("adjustment", 0, "adjustment", {"F_TA": 80e3, "F_TB": FROM_80_KN[3], "S": FROM_80_KN[0]}),
        ("delivery", 5, "delivery", {"S": 62.5, "F_TA": EXACT_SHORT[2][3]}),
        ("delivery", 9, "delivery", {"S": 62.5, "F_TA": EXACT_SHORT[4][3]}),
        ("delivery-tension", 0, "delivery-tension", {"F_TA": 80e3}),
        # 4 m are out when it begins, and the traction cable is pulled by 4 kN
        ("erection", 0, "erection", {"S": 4.0, "F_TB": 4e3}),
        ("erection", 3, "erection", {"S": 34.0, "F_TB": 4e3}),
        ("stabilisation", 0, "stabilisation-length", {"F_TA": FROM_LENGTH[2]}),
        ("stabilisation-sag", 0, "stabilisation", {"F_TA": FROM_SAG[2]}),
        ("withdrawal", 3, "withdrawal", {"S": 29.0, "F_TB": 4e3}),
    ],
)
def test_a_highline_opens_with_the_stage_that_has_its_numbers(scene, run, first, known):
    head, numbers = opened(CONFIGS / "highline" / f"{scene}.toml", run=run)
    assert head["first"] == first
    assert {key: numbers[key] for key in known} == pytest.approx(known, rel=1e-8)
    if "withdrawal" in scene:
        exact = dragged_from_tension(60, 16, 40, 29.0, 5, 4e3)
        assert numbers["F_TA"] == pytest.approx(float(exact.tension_a), rel=1e-9)


def test_a_stage_says_that_its_line_is_inextensible():
    head, _ = opened(CONFIGS / "highline" / "adjustment.toml")
    *stages, own = head["models"]
    assert {stage["remark"] for stage in stages} == {"closed form of an inextensible line"}
    assert own["remark"] == ""


def test_a_cable_that_is_shaken_opens_at_rest():
    """Taut: by what it stretches, 0.16 %, the tension is below two thirds of an inextensible one."""
    head, numbers = opened(CONFIGS / "sagged-cable.toml")
    assert [model["key"] for model in head["models"]] == ["scene"]
    exact = elastic_catenary(200.0, 0.0, 200.2, EA=50e6, weight=98.0665)
    assert numbers["cable/horizontal"] == pytest.approx(float(exact.horizontal), rel=1e-3)
    assert numbers["cable/sag"] == pytest.approx(6.227, rel=1e-3)


@pytest.mark.parametrize(
    ("stiffness", "first"), [("50 MN", "scene"), ("500 GN", "stabilisation-length")]
)
def test_a_taut_line_opens_with_a_stage_where_it_is_stiff(tmp_path, stiffness, first):
    text = (CONFIGS / "sagged-cable.toml").read_text()
    held = re.sub(r"end = \{ motion = .*", "end = { fixed = [200, 0, 0] }", text)
    path = wrote(tmp_path, held.replace("50 MN", stiffness))
    assert highline_of(load_study(path).scene).stage == (None if first == "scene" else first)
    head, numbers = opened(path)
    assert head["first"] == first
    exact = elastic_catenary(
        200.0, 0.0, 200.2, EA=50e6 if first == "scene" else 5e11, weight=98.0665
    )
    key = "cable/horizontal" if first == "scene" else "F_H"
    assert numbers[key] == pytest.approx(float(exact.horizontal), rel=1e-3)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        # 57 MN: by the 0.16 % that it stretches it hangs a quarter longer over its chord
        ("57 GN", "57 MN"),
        ('"31.5 m"', '"15 m"'),  # the lines do not meet
        ('length = "31.5 m"', 'length = "31.5 m"\nbending = { EI = 5.0 }'),
        ('mass = "4 kg/m"\nstart = "cargo"', 'mass = "8 kg/m"\nstart = "cargo"'),
    ],
    ids=["soft", "short", "stiff in bending", "two weights"],
)
def test_what_no_stage_has_opens_with_itself(tmp_path, old, new):
    text = HIGHLINE.replace(old, new)
    assert text != HIGHLINE
    assert highline_of(load_study(wrote(tmp_path, HIGHLINE)).scene).stage == "delivery"
    assert highline_of(load_study(wrote(tmp_path, text)).scene).stage is None


@pytest.mark.slow
def test_cargo_between_two_lines_hangs_where_the_engine_has_it(tmp_path):
    path = wrote(tmp_path, HIGHLINE)
    _, numbers = opened(path)
    lines = Resting(load_study(path)).solve({}).lines
    place = highline_of(load_study(path).scene).numbers["place"]
    # chords of 4 m, 8 a line
    assert lines["left"].position[-1][0] == pytest.approx(place, abs=2e-3)
    assert lines["left"].ends[0] == pytest.approx(numbers["F_TA"], rel=1e-3)
    exact = loaded_from_length(60, 16, 40, 20e3, place, 62.5)
    assert numbers["F_TB"] == pytest.approx(float(exact.tension_b), rel=1e-9)
