"""Two anchors on either side of a ship, in space: in the middle as one of twice the mass in a plane."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_text

from lumpedcable.results import open_result

SCENE = Path(__file__).parents[2] / "configs" / "restraint-two-anchors.toml"
SIDES = {"left": 4.0, "right": -4.0}
# largest tensions in the plane at anchor and cable (kN), of rigid links by Runge-Kutta: case 1
ANCHOR = 396.1


def in_the_middle():
    """Overrides: each cable in an upright plane of its own, the ship between them.

    Two lines of half the mass have the added mass of the one, and sqrt(2) times its drag if their
    coefficients are the same.
    """
    changes = ["bodies.ship.position.1=0", "output.duration=3 s"]
    for side, y in SIDES.items():
        changes += [f"bodies.{side}_anchor.position.1={y}", f"lines.{side}_cable.end.at.1={y}"]
        for part, diameter in (("chain", 152.6), ("cable", 47.4)):
            line = f"lines.{side}_{part}"
            changes.append(f"{line}.diameter={diameter / np.sqrt(2.0)} mm")
            changes.append(f"{line}.drag.normal={1.21 / np.sqrt(2.0)}")
            changes.append(f"{line}.drag.tangential={0.062 / np.sqrt(2.0)}")
    return changes


@pytest.mark.slow
def test_in_the_middle_two_are_as_one_of_twice_the_mass(tmp_path):
    ran = run_text(tmp_path, SCENE.read_text(), *in_the_middle())
    assert ran.statuses == ["STILL_MOVING"]
    with open_result(tmp_path / "result.h5") as found:
        peaks = [found.line(f"{side}_chain").field("peak_tension", 0)[0] for side in SIDES]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-9)
    assert 2e-3 * peaks[0] == pytest.approx(ANCHOR, rel=0.01)
    ship = ran.bodies["ship"]
    assert np.max(np.abs(ship["position"][0, :, 1])) < 1e-9
    assert np.max(np.abs(ship["attitude"][0][:, [0, 2]])) < 1e-9


MIRRORED = """
[[sweep.cases]]
name = "as it is"
[[sweep.cases]]
name = "mirrored"
"bodies.ship.position.1" = "-1 m"
"lines.left_cable.end.at.1" = "3 m"
"lines.right_cable.end.at.1" = "-5 m"
"""
OTHER = {"left": "right", "right": "left"}


def mirror_of(name):
    """The name of what stands where this one does on the other side."""
    side, _, part = name.partition("_")
    return f"{OTHER[side]}_{part}" if side in OTHER else name


@pytest.mark.slow
def test_mirrored_about_the_middle_all_goes_the_other_way(tmp_path):
    # what is left of two runs is rounding, which friction, a bed and a snap could blow up
    text = SCENE.read_text() + MIRRORED
    ran = run_text(tmp_path, text, "output.every=0.1 s", "output.duration=30 s")
    assert ran.statuses == ["OK", "OK"]
    first, second = ran.outcomes
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
