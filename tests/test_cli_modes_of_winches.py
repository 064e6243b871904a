"""The command `modes` of lines on winches, of cargo on them, and of what is damped."""

import json

import good_scenes
import numpy as np
import pytest
from command_line import say

from lumpedcable import exact

WINCH = """
gravity = 9.81

[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.high]
material = "hooke"
length = "40 m"
segments = 20
mass = "2 kg/m"
start = { fixed = [0, 0, "10 m"] }
end = { winch = { at = ["40 m", 0, "10 m"], tension = "20 kN" } }

[output]
duration = 1
every = 1
"""
CARGO = '\n[bodies.cargo]\nmass = "500 kg"\non = { line = "high", place = "20 m" }\n'


@pytest.mark.slow
def test_winches_pay_out_and_it_is_said(tmp_path):
    good_scenes.write(tmp_path, WINCH)
    said = say(tmp_path, "modes", "scene.toml", "-n", "2")
    assert (said.code, said.err) == (0, "")
    assert "Winches pay out and haul in to keep their tension." in said.out
    # a string of 40 m under 20 kN, stretched by 2 %: its tension stays while it swings
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    string = exact.string_frequencies(40.0, 20e3, 2.0 / 1.02, 2)
    assert [mode["frequency"] for mode in told["modes"]] == pytest.approx(string, rel=0.01)


def test_damping_has_a_column(tmp_path):
    text = WINCH.replace('EA = "1 MN"', 'EA = "1 MN"\ndamping = "2 kN s"')
    text = (
        text[: text.index("end = {")]
        + "end = { fixed = [40.5, 0, 10] }\n"
        + text[text.index("[output]") :]
    )
    good_scenes.write(tmp_path, f"dimensions = 1\n{text.replace('gravity = 9.81', '')}")
    said = say(tmp_path, "modes", "scene.toml", "-n", "2")
    assert (said.code, said.err) == (0, "")
    assert (
        "Damping is the share of the critical one, to first order: good while it is small."
        in said.out
    )
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())["modes"]
    # B omega / (2 EA)
    known = [2e3 / 1e6 * np.pi * mode["frequency"] for mode in told]
    assert [mode["damping_ratio"] for mode in told] == pytest.approx(known, rel=1e-9)
    assert f" {100 * known[0]:.3g} " in said.out
    # of 0.055, five and fifty times as much
    for factor, remark in ((5, "strongly damped"), (50, "damped too strongly to swing")):
        more = f"materials.hooke.damping={2e3 * factor}"
        said = say(tmp_path, "modes", "scene.toml", "-n", "1", "--set", more)
        assert said.out.count(remark) == 1


def test_cargo_on_an_ideal_line_moves_in_modes(tmp_path):
    good_scenes.write(tmp_path, WINCH + CARGO)
    said = say(tmp_path, "modes", "scene.toml", "--set", 'lines.high.model="ideal"')
    assert (said.code, said.err) == (0, "")
    assert "There are 2 modes in all." in said.out
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    assert [mode["bodies_move_in"] for mode in told["modes"]] == [
        {"cargo": ["x"]},
        {"cargo": ["z"]},
    ]
    # the two straight parts of 20 m / cos a carry the weight with 2 T sin a
    sine = 500 * 9.81 / 2 / 20e3
    stiff = 2 * 20e3 / (20 / np.sqrt(1 - sine**2)) * np.array([sine**2, 1 - sine**2])
    found = [mode["omega_squared"] for mode in told["modes"]]
    assert found == pytest.approx(stiff / 500, rel=1e-9)
    assert np.shape(told["lines"]["high"]["shapes"]) == (2, 3, 3)
    assert (tmp_path / "scene" / "modes.png").stat().st_size > 10_000


@pytest.mark.slow
def test_what_holds_a_trolley_is_said(tmp_path):
    text = (WINCH + CARGO).replace('"20 m" }', '"10 m" }')
    good_scenes.write(tmp_path, text.replace("[bodies.cargo]", "[bodies.cargo]\nheight = 11"))
    said = say(tmp_path, "modes", "scene.toml", "-n", "3")
    assert (said.code, said.err) == (0, "")
    told = json.loads((tmp_path / "scene" / "modes.json").read_text())
    aside = '"cargo" moves about its rest here; the scene lets it go from another height.'
    force = told["held_against"]["cargo"]
    held = f'"cargo" is held along its line, where {force:.3g} N would set it going.'
    for note in (aside, held):
        assert note in told["conditions"]
        assert note in said.out
    # parts of 10 and 30 m, drawn at by one tension; the line's own weight is a sixth of the cargo's
    drop = 10.0 - told["bodies"]["cargo"]["position"][2]
    pull = 20e3 * (30 / np.hypot(30, drop) - 10 / np.hypot(10, drop))
    assert force == pytest.approx(pull, rel=0.03)
