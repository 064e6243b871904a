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
