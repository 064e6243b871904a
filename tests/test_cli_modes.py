"""The command `modes`: a table, a picture, numbers in a file; mistakes and unstable scenes."""

import json
import re

import good_scenes
import numpy as np
import pytest
from command_line import ROOT, refused, say

from lumpedcable import exact

CABLE = ROOT / "configs" / "sagged-cable.toml"
# a mass on one rod above its support: in one piece the rod can only fall over
INVERTED = """
title = "Upside down"
gravity = 9.81
dimensions = 2

[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rod]
material = "hooke"
length = "10 m"
segments = 1
mass = "0.01 kg/m"
start = { fixed = [0, 0, 0] }
end = "bob"

[bodies.bob]
mass = "100 kg"
position = [0, 0, 10]

[sweep]
"bodies.bob.position.2" = ["10 m", "-10 m"]

[output]
duration = 1
every = 1
"""


@pytest.fixture(scope="module")
def cable(tmp_path_factory):
    """A folder in which the modes of the sagging cable have been found, and what was said."""
    folder = tmp_path_factory.mktemp("cable")
    return folder, say(folder, "modes", CABLE)


def rows(out):
    """The numbers of the table's rows: mode, frequency, period, shares."""
    found = re.findall(
        r"^ +(\d+) +([\d.]+) +([\d.]+) +([\d.]+) +([\d.]+) +([xyz, ]+?) *$", out, re.M
    )
    return [(int(k), *map(float, numbers), where) for k, *numbers, where in found]


def test_the_table_agrees_with_the_comment_in_the_scene(cable):
    _, said = cable
    assert (said.code, said.err) == (0, "")
    assert said.out.startswith("A sagging cable at the crossover\n")
    table = rows(said.out)
    assert [row[0] for row in table] == list(range(1, 11))
    comment = CABLE.read_text().split("title")[0]
    told = {
        kind: [float(n) for n in re.findall(r"\d\.\d{4}", line)]
        for kind in ("string", "antisymmetric", " symmetric")
        for line in comment.splitlines()
        if kind in line and "Hz" in line
    }
    # the comment's numbers are Irvine's for the elastic catenary of this cable
    weight, span = 10 * exact.STANDARD_GRAVITY, 200.0
    line = exact.elastic_catenary(span, 0.0, 200.2, 50e6, weight)
    per_span = 200.2 / span
    pull, mass = line.horizontal, 10 * per_span
    parameter = exact.irvine_parameter(span, pull, weight * per_span, 50e6)
    symmetric, antisymmetric = exact.sagged_cable_frequencies(span, pull, mass, parameter, 2)
    string = exact.string_frequencies(span, pull, mass, 4)
    assert told["string"] == pytest.approx(string, abs=6e-5)
    assert told["antisymmetric"] == pytest.approx(antisymmetric, abs=6e-5)
    assert told[" symmetric"] == pytest.approx(symmetric, abs=6e-5)
    expected = sorted([*string, *antisymmetric, *symmetric])
    assert [row[1] for row in table[:8]] == pytest.approx(expected, rel=0.005)
    assert [row[1] * row[2] for row in table] == pytest.approx([1.0] * 10, rel=1e-5)
    assert [row[5] for row in table[:8]] == ["y", "z", "z", "y", "y", "z", "z", "y"]
    assert all(row[3] + row[4] == pytest.approx(100.0) for row in table)


def test_picture_and_numbers_lie_beside_each_other(cable):
    folder, said = cable
    assert said.out.splitlines()[-2:] == ["sagged-cable/modes.png", "sagged-cable/modes.json"]
    assert (folder / "sagged-cable" / "modes.png").stat().st_size > 20_000
    told = json.loads((folder / "sagged-cable" / "modes.json").read_text())
    assert told["units"]["frequency"] == "Hz"
    assert told["stiffness_asymmetry"] < 1e-12
    table = rows(said.out)
    assert [mode["frequency"] for mode in told["modes"]] == pytest.approx(
        [row[1] for row in table], rel=1e-5
    )
    assert {mode["state"] for mode in told["modes"]} == {"stable"}
    line = told["lines"]["cable"]
    assert len(line["position"]) == 101
    assert line["position"][-1] == pytest.approx([200.0, 0.0, 0.0])
    assert [len(line["shapes"]), len(line["shapes"][0])] == [10, 101]
    assert line["shapes"][0][50] == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)


def test_an_unstable_scene_says_so(tmp_path):
    good_scenes.write(tmp_path, INVERTED)
    said = say(tmp_path, "modes", "scene.toml", "-o", tmp_path / "out", "--format", "svg")
    assert (said.code, said.err) == (0, "")
    # omega^2 = -g / L': it falls over e-fold in sqrt(L' / g), the rod shortened by a thousandth
    assert re.search(r"^ +1 +- +- .*unstable: grows e-fold in 1\.01 s *$", said.out, re.M)
    assert "The equilibrium is unstable: 1 mode shown would grow, not swing." in said.out
    assert "There are 2 modes in all." in said.out
    assert "Motion in x and z only; dimensions = 3 allows all." in said.out
    assert "Run 0 of 0 to 1; --run takes another." in said.out
    assert said.out.splitlines()[0] == "Upside down: bob position z 10 m"
    told = json.loads((tmp_path / "out" / "modes.json").read_text())
    first, second = told["modes"]
    assert (first["state"], first["frequency"], first["period"]) == ("unstable", None, None)
    assert first["omega_squared"] == pytest.approx(-9.81 / (10 * (1 - 981e-6)), rel=1e-3)
    assert (second["state"], second["share_bodies"]) == ("stable", pytest.approx(1.0, abs=1e-3))
    assert told["swept"] == {"bodies.bob.position.2": 10.0}
    assert "unstable" in (tmp_path / "out" / "modes.svg").read_text()


def test_another_run_and_fewer_modes(tmp_path):
    good_scenes.write(tmp_path, INVERTED)
    said = say(tmp_path, "modes", "scene.toml", "--run", "1", "-n", "1")
    assert said.code == 0
    assert "unstable" not in said.out
    assert "in all" not in said.out
    swing, _ = exact.elastic_pendulum_periods(10.0, 1e6, 100.0, 9.81)
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    assert [mode["period"] for mode in told["modes"]] == pytest.approx([swing], rel=2e-3)
    assert told["run"] == 1


def test_no_equilibrium_exits_with_1_and_advice(tmp_path):
    text = INVERTED.replace('end = "bob"', 'end = "free"').replace(
        "start = { fixed = [0, 0, 0] }", 'start = "free"'
    )
    good_scenes.write(tmp_path, text.split("[bodies")[0] + "[output]\nduration = 1\nevery = 1\n")
    said = say(tmp_path, "modes", "scene.toml")
    assert (said.code, said.out) == (1, "")
    assert said.err.startswith("scene.toml: no static equilibrium was found to start from")
    assert "check that something holds each line in its place" in said.err
    assert sorted(p.name for p in tmp_path.iterdir() if p.suffix != ".csv") == ["scene.toml"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-n", "0"], "--count: expected at least 1, found 0"),
        (["--run", "2"], "--run: expected a run from 0 to 1, found 2"),
        (["--run", "-1"], "--run: expected a run from 0 to 1, found -1"),
        (["--set", "segments=0"], "lines.rod.segments: expected a whole number from 1"),
        (["--set", "dimensions=1", "--set", "rod.start.fixed=[1, 0, 0]"],
         "--set dimensions=1: dimensions: expected at least 2, which"),
        (["--set", "rod.end={fixed=[0, 0, 9]}"], "lines: nothing can move: every node is held"),
    ],
)  # fmt: skip
def test_mistakes(tmp_path, arguments, words):
    good_scenes.write(tmp_path, INVERTED)
    told = refused(tmp_path, "modes", "scene.toml", *arguments)
    assert words in told
    assert told.count("\n") == 1


def test_a_format_that_nobody_draws(tmp_path):
    good_scenes.write(tmp_path, INVERTED)
    said = say(tmp_path, "modes", "scene.toml", "--format", "gif")
    assert said.code == 2
    assert "cannot draw in the format 'gif', expected one of pdf, png, svg" in said.err


def test_a_folder_that_cannot_be(tmp_path):
    good_scenes.write(tmp_path, INVERTED)
    said = say(tmp_path, "modes", "scene.toml", "-o", "scene.toml/deeper")
    assert said.code == 2
    assert "cannot make the folder scene.toml/deeper: " in said.err


def test_too_few_dimensions_stop_a_run_and_a_check_as_well(tmp_path):
    text = good_scenes.ROPE.replace("[water]", "dimensions = 1\n[water]")
    good_scenes.write(tmp_path, text)
    line = text[: text.index("dimensions")].count("\n") + 1
    for command in ("run", "check", "modes"):
        told = refused(tmp_path, command, "scene.toml")
        assert told.startswith(f"scene.toml:{line}: dimensions: expected at least 2, which"), (
            command
        )


@pytest.mark.slow
def test_what_is_left_out_is_said(tmp_path):
    # a taut line in a current, with damping: all of it matters, none of it is swept under the rug
    text = INVERTED.split("[sweep]")[0].replace("mass =", 'diameter = "20 mm"\nmass =', 1)
    text = text.replace(
        "[materials.hooke]",
        '[water]\ndensity = 1025\ncurrent = { velocity = ["1 m/s", 0, 0] }\n[materials.hooke]\n'
        "damping = 100\nrelaxation = { slow = { EA = 1e5, time = 10 } }",
    ).replace("segments = 1\n", "segments = 6\ndrag = { normal = 1.2, tangential = 0.01 }\n")
    good_scenes.write(tmp_path, f"{text.replace('10]', '-10]')}[output]\nduration = 1\nevery = 1\n")
    said = say(tmp_path, "modes", "scene.toml")
    assert (said.code, said.err) == (0, "")
    assert "Damping is the share of the critical one, to first order" in said.out
    assert "Without" not in said.out  # what drags in a current is counted
    assert (
        "Materials that relax are as stiff, and lose as much, as at each mode's frequency."
        in said.out
    )
    assert "Drag of a current, or thrust that turns with its body, makes" in said.out
    assert "unstable" not in said.out
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    assert told["stiffness_asymmetry"] > 1e-9
    assert [mode["state"] for mode in told["modes"]] == ["stable"] * 10
    assert all(mode["damping_ratio"] > 0 for mode in told["modes"])


JOINED = """
gravity = 9.81
[materials.hooke]
law = "linear"
EA = "5 MN"
[lines.a]
material = "hooke"
length = 24.5
segments = 1
mass = 4
start = { fixed = [0, 0, 0] }
end = { joined = "b.start", at = [24, 3, -5] }
[lines.b]
material = "hooke"
length = 19.5
segments = 1
mass = 6
start = "a.end"
end = { fixed = [42, 0, 2] }
[output]
"""


@pytest.mark.slow
def test_a_joint_away_from_its_rest_is_told(tmp_path):
    good_scenes.write(tmp_path, JOINED)
    said = say(tmp_path, "modes", "scene.toml")
    joint, force = np.array([24.0, 3.0, -5.0]), np.zeros(3)
    for end, length, mass in ((np.zeros(3), 24.5, 4.0), (np.array([42.0, 0.0, 2.0]), 19.5, 6.0)):
        way = end - joint
        far = np.linalg.norm(way)
        force += 5e6 * (far / length - 1.0) * way / far - [0.0, 0.0, 0.5 * mass * length * 9.81]
    assert f"Not about rest: {np.linalg.norm(force):.4g} N are left" in said.out
    at_rest = JOINED.replace('{ joined = "b.start", at = [24, 3, -5] }', '"b.start"')
    good_scenes.write(tmp_path, at_rest)
    assert "Not about rest" not in say(tmp_path, "modes", "scene.toml").out


BUOY = ROOT / "configs" / "surface" / "buoy.toml"


@pytest.mark.slow
def test_a_buoy_that_floats_moves_in_modes(tmp_path):
    said = say(tmp_path, "modes", BUOY, "-n", "20")
    assert "Without drag, which grows with the square of the motion." in said.out
    assert (said.code, said.err) == (0, "")
    told = json.loads((tmp_path / "buoy" / "modes.json").read_text())
    shapes = np.array(told["bodies"]["buoy"]["shapes"])
    assert shapes.shape == (20, 6)
    assert np.all(shapes[:, 3:] == 0.0)  # it does not turn
    line = np.array(told["lines"]["ahead"]["shapes"])
    assert line[:, -1] == pytest.approx(shapes[:, :3], abs=1e-11)
    moves = [mode["bodies_move_in"].get("buoy", [""])[0] for mode in told["modes"]]
    assert {"x", "y", "z"} <= set(moves)
    shares = np.array([mode["share_bodies"] for mode in told["modes"]])
    assert np.array_equal(shares >= 0.05, np.array(moves) != "")
    assert "buoy: z" in said.out


@pytest.mark.slow
def test_a_body_that_is_held_is_told(tmp_path):
    text = INVERTED.split("[sweep]")[0].replace("position", 'free = ["x", "z"]\nposition')
    text = text.replace("segments = 1\n", "segments = 3\n")
    text = text.replace("[0, 0, 10]", "[0, 0, -10]") + "[output]\nduration = 1\nevery = 1\n"
    good_scenes.write(tmp_path, text)
    said = say(tmp_path, "modes", "scene.toml")
    assert '"bob" is held where the scene puts it; with settle = true it comes to rest' in said.out
    assert "bodies" not in json.loads((tmp_path / "scene" / "modes.json").read_text())
    said = say(tmp_path, "modes", "scene.toml", "--set", "bob.settle=true", "-n", "1")
    assert "is held" not in said.out
    assert "bob: x" in said.out
    # L' = 10 (1 + 981 / 1e6)
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    assert told["modes"][0]["frequency"] == pytest.approx(
        np.sqrt(9.81 / 10.0098) / 6.2832, rel=1e-3
    )
    assert told["modes"][0]["bodies_move_in"] == {"bob": ["x"]}
