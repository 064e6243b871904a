"""The live page without a browser: sliders, answers, faults, and the scene that is given back."""

import asyncio
import json
import re
from contextlib import nullcontext

import numpy as np
import pytest
from command_line import ROOT, refused
from highline_numbers import EXACT_SHORT, FROM_80_KN, PLACES, STRAIGHT_SHORT
from page.test_bodies_on_the_page import TRANSFER

from lumpedcable.exact import (
    STAGES,
    IdealHighline,
    elastic_catenary,
    loaded_from_length,
    loaded_from_tension,
)
from lumpedcable.page.elastic import elastic_model
from lumpedcable.page.live import live_page
from lumpedcable.page.server import application
from lumpedcable.scene import load_study
from lumpedcable.study import resting
from lumpedcable.study.resting import AtRest, Resting, RestingLine

HIGHLINE = """\
title = "Highline with cargo"
gravity = "10 m/s2"

[materials.wire]
law = "linear"
EA = "57 GN"  # as good as inextensible

[bodies.cargo]
mass = "2 t"

[lines.left]
material = "wire"
length = "31.5 m"
segments = 8
mass = "4 kg/m"
start = { fixed = [0, 0, 0] }
end = "cargo"

[lines.right]
material = "wire"
length = "31 m"
segments = 8
mass = "4 kg/m"
start = "cargo"
end = { fixed = [60, 0, -16] }

[output]
duration = "1 s"
every = "1 s"
"""
CATENARY = """\
gravity = 9.80665

[materials.wire]
law = "linear"
EA = "20 MN"

[lines.wire]
material = "wire"
length = "110 m"
segments = 50
mass = "3 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = [100, 0, 20] }

[output]
duration = "1 s"
every = "1 s"
"""


class Asked:
    """A live page, asked as the browser asks it."""

    def __init__(self, folder, text):
        path = folder / "scene.toml"
        path.write_text(text)
        self.study = load_study(path)
        page, self.answers = live_page(self.study)
        head = re.search(r'<script id="head"[^>]*>(.*?)</script>', page, re.DOTALL)[1]
        self.head = json.loads(head)

    def solve(self, model, **values):
        return self.answers["/solve"]({"model": model, "values": values})

    def numbers(self, model, **values):
        return {n["key"]: n["value"] for n in self.solve(model, **values)["numbers"]}

    def toml(self, model, **values):
        return self.answers["/toml"]({"model": model, "values": values})["text"]


@pytest.fixture(scope="module")
def highline(tmp_path_factory):
    return Asked(tmp_path_factory.mktemp("highline"), HIGHLINE)


@pytest.fixture(scope="module")
def catenary(tmp_path_factory):
    return Asked(tmp_path_factory.mktemp("catenary"), CATENARY)


# --- a highline ----------------------------------------------------------------------------------


def test_a_highline_has_its_stages_with_its_own_numbers(highline):
    assert [m["key"] for m in highline.head["models"]] == [*STAGES, "scene"]
    assert highline.head["first"] == "delivery"
    delivery = next(m for m in highline.head["models"] if m["key"] == "delivery")
    values = {c["key"]: c["value"] for c in delivery["controls"]}
    place = values.pop("place")
    assert values == {"span": 60, "drop": 16, "weight": 40, "load": 20e3, "length": 62.5}
    # the cargo hangs where there are 31.5 m before it: 29.2 m by straight segments
    assert 29.0 < place < 29.6
    assert float(loaded_from_length(60, 16, 40, 20e3, place, 62.5).parts[0].length) == (
        pytest.approx(31.5, rel=1e-9)
    )
    assert all(c["low"] <= c["value"] <= c["high"] for c in delivery["controls"])


@pytest.mark.parametrize("place", range(5))
def test_delivery_is_the_known_one(highline, place):
    """S is given; f, F_H, F_TA, F_TB of two exact catenaries, and of straight segments."""
    found = highline.solve("delivery", place=PLACES[place])
    rows = {n["key"]: n for n in found["numbers"]}
    keys = ("f", "F_H", "F_TA", "F_TB")
    assert [rows[k]["value"] for k in keys] == pytest.approx(EXACT_SHORT[place][1:], rel=1e-9)
    assert [rows[k]["second"] for k in keys] == pytest.approx(STRAIGHT_SHORT[place][1:], rel=1e-9)
    (cargo,) = found["points"]
    assert cargo["at"] == pytest.approx([PLACES[place], 0, -EXACT_SHORT[place][0]], rel=1e-9)
    # what is coloured along the line meets the tensions told at its ends
    line = found["lines"][0]
    assert line["tension"][0] == pytest.approx(rows["F_TA"]["value"], rel=1e-3)
    assert line["tension"][-1] == pytest.approx(rows["F_TB"]["value"], rel=1e-3)


def test_adjustment_is_the_known_one(highline):
    found = highline.numbers("adjustment", tension=80e3)
    assert list(found.values()) == pytest.approx(FROM_80_KN[:5], rel=1e-9)


@pytest.mark.parametrize(
    "stage",
    [s if s == "delivery" else pytest.param(s, marks=pytest.mark.slow) for s in STAGES],
)
def test_a_stage_is_given_back_as_a_scene_that_hangs_so(highline, tmp_path, stage):
    changes = {"time": 20.0} if "time" in STAGES[stage].sliders else {"span": 58.0}
    told = highline.numbers(stage, **changes)
    path = tmp_path / "saved.toml"
    path.write_text(highline.toml(stage, **changes))
    study = load_study(path)
    # one mesh for all stages, so that few programs are compiled
    lines = list(Resting(study).solve({}).lines.values())
    # 50 segments a part: their own error is of the order of (1/50)^2
    assert lines[0].ends[0] == pytest.approx(told["F_TA"], rel=4e-4)
    assert lines[-1].ends[1] == pytest.approx(told["F_TB"], rel=4e-4)


def test_numbers_without_a_line_are_told(highline):
    with pytest.raises(ValueError, match="expected a length S over"):
        highline.solve("stabilisation-length", length=62.0)
    with pytest.raises(ValueError, match=r"expected a tension F_TA of .* N or more"):
        highline.solve("adjustment", tension=100.0)


# --- any scene -----------------------------------------------------------------------------------


def test_a_number_beyond_all_floats_is_told(catenary):
    for value in (10**400, float("inf"), True):
        with pytest.raises(ValueError, match="expected a number, found"):
            catenary.solve("scene", **{"lines.wire.length": value})


def test_any_scene_has_its_own_numbers_as_sliders(catenary):
    own = next(m for m in catenary.head["models"] if m["key"] == "scene")
    keys = {c["key"]: (c["value"], c["unit"], c["factor"]) for c in own["controls"]}
    assert set(keys) == {
        "gravity", "materials.wire.EA", "lines.wire.length", "lines.wire.mass",
        *(f"lines.wire.{end}.fixed.{k}" for end in ("start", "end") for k in range(3)),
    }  # fmt: skip
    assert keys["materials.wire.EA"] == (20e6, "MN", 1e-6)
    assert keys["lines.wire.end.fixed.0"] == (100.0, "m", 1.0)


def test_sliders_lead_to_the_exact_catenary_and_compile_once(catenary):
    catenary.solve("scene")
    compiled = resting._at_rest._cache_size()
    for span, length, weight, EA in ((100, 110, 3, 20e6), (90, 108, 5, 20e6), (100, 102.5, 3, 8e6)):
        found = catenary.numbers(
            "scene",
            **{"lines.wire.end.fixed.0": span, "lines.wire.length": length,
               "lines.wire.mass": weight, "materials.wire.EA": EA},
        )  # fmt: skip
        exact = elastic_catenary(span, 20.0, length, EA=EA, weight=weight * 9.80665)
        for key, s in (("start", 0.0), ("end", float(length))):
            # 50 segments: of the order of (1/50)^2
            pull = np.hypot(exact.horizontal, exact.vertical_tension(s))
            assert found[f"wire/{key}_tension"] == pytest.approx(float(pull), rel=1e-3)
        assert found["wire/horizontal"] == pytest.approx(exact.horizontal, rel=1e-3)
    assert resting._at_rest._cache_size() == compiled


def test_a_scene_is_given_back_with_what_was_changed(catenary, tmp_path):
    path = tmp_path / "saved.toml"
    path.write_text(catenary.toml("scene", **{"lines.wire.length": 120.0}))
    before, after = catenary.study.scene.numbers(), load_study(path).scene.numbers()
    assert after == {**before, "lines.wire.length": 120.0}


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ([], 'expected {"model"'),
        ({"model": "nix", "values": {}}, "expected a model, one of"),
        ({"model": "scene", "values": {"lines.wire.lenght": 1}}, "nearest: lines.wire.length"),
        ({"model": "scene", "values": {"gravity": "9.81"}}, "gravity: expected a number"),
        ({"model": "scene", "values": {"gravity": float("nan")}}, "expected a number, found nan"),
        ({"model": "scene", "values": {"lines.wire.mass": -1}}, "expected a positive mass"),
        ({"model": "scene", "values": {"materials.wire.EA": 0}}, "expected a positive force"),
    ],
)
def test_what_cannot_be_asked_is_told(catenary, asked, told):
    with pytest.raises(ValueError, match=re.escape(told)):
        catenary.answers["/solve"](asked)


def posted(answers, body, error=None):
    """Status and JSON of what the server answers to bytes posted at /solve, raising an error or none."""
    pytest.importorskip("starlette")
    app, said = application("", answers), []

    async def receive():
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message):
        said.append(message)

    scope = {"type": "http", "http_version": "1.1", "method": "POST", "path": "/solve",
             "query_string": b"", "headers": [(b"host", b"127.0.0.1")]}  # fmt: skip
    with pytest.raises(error) if error else nullcontext():
        asyncio.run(app(scope, receive, send))
    return said[0]["status"], json.loads(said[1]["body"])


def test_what_is_posted_too_deep_is_refused():
    answers = {"/solve": lambda asked: {"found": asked}}
    assert posted(answers, b"[1, 2]") == (200, {"found": [1, 2]})
    assert posted(answers, b"[1, 2")[0] == 200  # a fault of the page itself, told there
    deep = b"[" * 100_000
    assert posted(answers, deep) == (400, {"fault": "expected plain JSON, found it too deep"})


def test_only_what_the_page_asks_for_is_its_fault(catenary):
    status, told = posted(catenary.answers, b'{"model": "scene", "values": {"gravity": "9.81"}}')
    assert (status, told) == (200, {"fault": "gravity: expected a number, found '9.81'"})

    def broken(asked):
        raise ValueError("shapes (3,) and (4,)")

    # what goes wrong in the program is told where that runs
    for answer in (broken, lambda asked: {"found": float("nan")}):
        told = posted({"/solve": answer}, b"{}", ValueError)
        assert told == (500, {"fault": "an error in the program: its terminal tells where"})


# --- the command ---------------------------------------------------------------------------------


def test_what_the_command_cannot_do_is_told(tmp_path):
    scene = ROOT / "configs" / "sagged-cable.toml"
    assert "expected a results file" in refused(tmp_path, "view", scene, "-o", "page.html")
    assert "--run: expected 0" in refused(tmp_path, "view", scene, "--run", "1", "--no-browser")
    assert "expected a scene (*.toml)" in refused(tmp_path, "view", "r.h5", "--set", "a=1")
    assert "none.toml" in refused(tmp_path, "view", "none.toml", "--no-browser")


def test_ships_trolley_and_ideal_cable_are_there(tmp_path):
    asked = Asked(tmp_path, TRANSFER)
    assert [m["key"] for m in asked.head["models"]] == ["scene"]
    keys = [c["key"] for c in asked.head["models"][0]["controls"]]
    # what a shape at rest does not depend on is no slider
    assert "lines.highline.end.winch.tension" in keys
    assert not [key for key in keys if "speed" in key or "period" in key]
    swings = [key for key in keys if "motion" in key]  # where the ship is at the start
    assert {key.rpartition(".")[2] for key in swings} == {"amplitude", "phase"}
    up = asked.solve("scene", **{"bodies.ship.motion.heave.phase": np.pi / 2})
    assert {p["name"]: p["at"] for p in up["points"]}["ship"] == pytest.approx([0.0, 0.0, 3.0])
    for tension in (80e3, 60e3):
        found = asked.solve("scene", **{"lines.highline.end.winch.tension": tension})
        points = {point["name"]: point for point in found["points"]}
        # the height of the trolley under its post: tension times length and weight at their least
        exact = IdealHighline(50.0, tension, 2000.0, 9.81, place=10.0, rise=-2.0)
        trolley = [0.0, 10.0, 16.0 + exact.height()]
        assert points["trolley of cargo"]["at"] == pytest.approx(trolley, abs=1e-6)
        assert points["cargo"]["at"] == pytest.approx([0.0, 10.0, trolley[2] - 3.0], abs=1e-6)
        assert points["cargo"]["size"] == [2.0, 2.0, 1.0]
        assert points["ship"]["at"] == pytest.approx([0.0, 0.0, 1.0])
        assert points["ship"]["points"] == [[0.0, 0.0, 15.0]]
        (line,) = found["lines"]
        places = [[0.0, 0.0, 16.0], trolley, [0.0, 50.0, 14.0]]
        assert np.asarray(line["position"]) == pytest.approx(np.asarray(places), abs=1e-6)
        assert line["tension"] == [tension, tension]


@pytest.mark.slow  # half a minute of compiling
def test_targets_are_followed_step_by_step():
    edits = ["lines.before.segments=10", "lines.after.segments=10"]
    study = load_study(ROOT / "configs" / "highline" / "delivery-tension.toml", edits)
    model = elastic_model(study)
    # lengths that the targets choose are no numbers to drag
    assert not {c.key for c in model.controls} & {"lines.before.length", "lines.after.length"}
    for place in np.linspace(5.0, 30.0, 6):
        answer = model.solve({"targets.cargo.x": place, "targets.winch.tension": 84e3})
        told = {row["key"]: row["value"] for row in answer["numbers"]}
        assert told["before/start_tension"] == pytest.approx(84e3, rel=1e-8)
        exact = loaded_from_tension(60, 16, 40, 20e3, place, 84e3)
        # chords of 3 m for catenaries of 40 N/m under 84 kN
        assert told["before/length"] + told["after/length"] == pytest.approx(
            float(exact.length), rel=1e-4
        )
    with pytest.raises(
        ValueError, match=r"targets\.cargo\.x: expected a place on the span .* 70 m"
    ):
        model.solve({"targets.cargo.x": 70.0})
    again = model.solve({"targets.cargo.x": 30.0, "targets.winch.tension": 84e3})
    lengths = [row["value"] for row in again["numbers"] if row["key"].endswith("/length")]
    assert sum(lengths) == pytest.approx(told["before/length"] + told["after/length"], rel=1e-9)


def test_a_rest_that_is_not_found_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(Resting, "_at_rest", lambda self, numbers: None)
    path = tmp_path / "scene.toml"
    path.write_text(CATENARY)
    with pytest.raises(
        ValueError, match="no static equilibrium was found to start from: check that"
    ):
        elastic_model(load_study(path)).solve({})


def test_the_bed_goes_with_its_sliders(tmp_path, monkeypatch):
    nodes = np.array([[0.0, 0.0, 0.0], [50.0, 0.0, -5.0], [100.0, 0.0, 0.0]])
    line = RestingLine(nodes, np.ones(2), np.zeros(2), np.ones(2), np.ones(3))
    monkeypatch.setattr(Resting, "solve", lambda self, numbers: AtRest({"wire": line}, {}))
    path = tmp_path / "scene.toml"
    bed = "[seabed]\nheight = -30\nstiffness = 1e5\nprofile = { x = [0, 100], depth = [0, 5] }\n"
    path.write_text(CATENARY + bed)
    model = elastic_model(load_study(path))
    assert {"seabed.height", "seabed.profile.depth.1"} <= {c.key for c in model.controls}
    answer = model.solve({"seabed.height": -40.0, "seabed.profile.depth.1": 8.0})
    around = answer["surroundings"]["bed"]
    assert (around["x"][0], around["z"][0]) == (0.0, -40.0)
    assert (around["x"][-1], around["z"][-1]) == (100.0, pytest.approx(-48.0))
