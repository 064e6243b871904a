"""Two anchors on either side of a ship, in space: mirrored, and in the middle as one in a plane."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_text

from lumpedcable.results import open_result

SCENE = Path(__file__).parents[2] / "configs" / "restraint-two-anchors.toml"
SIDES = {"left": 4.0, "right": -4.0}
OTHER = {"left": "right", "right": "left"}
# largest tensions in the plane at anchor and cable (kN), of rigid links by Runge-Kutta: case 1
ANCHOR = 396.1
CASES = """
[[sweep.cases]]
name = "as it is"
[[sweep.cases]]
name = "mirrored"
"bodies.ship.position.1" = "-1 m"
"lines.left_cable.end.at.1" = "3 m"
"lines.right_cable.end.at.1" = "-5 m"
[[sweep.cases]]
name = "in the middle"
"bodies.ship.position.1" = 0
"""


def in_the_middle():
    """Numbers of the last case: each cable in an upright plane of its own, the ship between them.

    Two lines of half the mass have the added mass of the one, and sqrt(2) times its drag if their
    coefficients are the same.
    """
    text = ""
    for side, y in SIDES.items():
        text += f'"bodies.{side}_anchor.position.1" = {y}\n"lines.{side}_cable.end.at.1" = {y}\n'
        for part, diameter in (("chain", 152.6), ("cable", 47.4)):
            line = f"lines.{side}_{part}"
            text += f'"{line}.diameter" = "{diameter / np.sqrt(2.0)} mm"\n'
            text += f'"{line}.drag.normal" = {1.21 / np.sqrt(2.0)}\n'
            text += f'"{line}.drag.tangential" = {0.062 / np.sqrt(2.0)}\n'
    return text


def mirror_of(name):
    """The name of what stands where this one does on the other side."""
    side, _, part = name.partition("_")
    return f"{OTHER[side]}_{part}" if side in OTHER else name


def all_goes_the_other_way(ran):
    # what is left of two runs is rounding, which friction, a bed and a snap could blow up
    first, second = ran.outcomes[:2]
    assert first.stop_time == pytest.approx(second.stop_time, abs=1e-9)
    turn = np.array([1.0, -1.0, 1.0])
    for name in ran.lines:
        place = ran[f"{name}.position"][0], ran[f"{mirror_of(name)}.position"][1]
        assert np.max(np.abs(place[0] - place[1] * turn)) < 1e-10
        pull = ran[f"{name}.tension"][0], ran[f"{mirror_of(name)}.tension"][1]
        assert np.max(np.abs(pull[0] - pull[1])) < 1e-2
    for name, body in ran.bodies.items():
        other = ran.bodies[mirror_of(name)]
        assert np.max(np.abs(body["position"][0] - other["position"][1] * turn)) < 1e-10
        assert np.max(np.abs(body["attitude"][0] + other["attitude"][1] * turn)) < 1e-10
    # and it is not the middle, where nothing would be told
    assert abs(ran.bodies["ship"]["attitude"][0, -1, 2]) > 0.02


def two_are_as_one_of_twice_the_mass(ran, folder):
    with open_result(folder / "result.h5") as found:
        peaks = [found.line(f"{side}_chain").field("peak_tension", 2)[0] for side in SIDES]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-9)
    assert 2e-3 * peaks[0] == pytest.approx(ANCHOR, rel=0.01)
    # rigid links in the plane: 20.018 s
    assert ran.outcomes[2].stop_time == pytest.approx(20.018, abs=0.03)
    ship = ran.bodies["ship"]
    assert np.max(np.abs(ship["position"][2, :, 1])) < 1e-9
    assert np.max(np.abs(ship["attitude"][2][:, [0, 2]])) < 1e-9


# one test, so that its program, which takes minutes to compile, is made once
@pytest.mark.slow
def test_two_anchors(tmp_path):
    text = SCENE.read_text() + CASES + in_the_middle()
    ran = run_text(tmp_path, text, "output.every=0.1 s", "output.duration=30 s")
    assert ran.statuses == ["OK"] * 3
    all_goes_the_other_way(ran)
    two_are_as_one_of_twice_the_mass(ran, tmp_path)
