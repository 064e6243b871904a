"""Two anchors on either side of a ship, in space: the plane of one, and its own mirror image."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_text

SCENE = Path(__file__).parents[2] / "configs" / "restraint-two-anchors.toml"
PLANE = SCENE.with_name("restraint.toml")
# fewer links, and a ship that is soon stopped
COARSE = (
    "output.duration=3 s",
    "output.every=50 ms",
    "bodies.ship.mass=100 t",
    "solver.step=8 ms",
)


def coarse(text):
    cable = text.index("segment_lengths = [")
    links = text[cable : text.index("]", cable) + 1]
    text = text.replace(links, "segments = 8").replace("segments = 15", "segments = 3")
    # the resistance of a hull goes with its skin, which two ships of half the breadth have more of
    return text.replace(', resistance = { viscosity = "1.05e-6 m2/s" }', "")


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Ships 1 m to the left, 1 m to the right and in the middle, cables in planes of their own; two runs."""
    text = coarse(SCENE.read_text())
    for side, y in (("left", 4), ("right", -4)):
        for old in ('"12 m"', '"-12 m"'):
            text = text.replace(f'["-1 m", {old}', f'["-1 m", "{4 if old[1] == "1" else -4} m"')
    text = text.replace('"163.0735 m", "5 m"', '"163.0735 m", "4 m"')
    text = text.replace('"163.0735 m", "-3 m"', '"163.0735 m", "-4 m"')
    sweep = """
[sweep.zip]
"bodies.ship.position.1" = [0, 0.3, -0.3]
"lines.left_cable.end.at.1" = [4, 4.3, 3.7]
"lines.right_cable.end.at.1" = [-4, -3.7, -4.3]
"""
    # drag of two cables of half the mass each is sqrt(2) times that of one
    for key in ("normal = 1.21", "tangential = 0.062"):
        word, number = key.split(" = ")
        text = text.replace(key, f"{word} = {float(number) / np.sqrt(2.0)}")
    for old, one in (("107.9 mm", 152.6), ("33.5 mm", 47.4)):
        text = text.replace(old, f"{one / np.sqrt(2.0)} mm")
    return run_text(tmp_path_factory.mktemp("space"), text + sweep, *COARSE)


def test_in_the_middle_two_are_as_one_of_twice_the_mass(both, tmp_path):
    plane = coarse(PLANE.read_text().split("[[sweep.cases]]")[0])
    one = run_text(tmp_path, plane, *COARSE, 'output.precision="float64"')
    print(both.statuses, one.statuses, both.outcomes[0].stop_time, one.outcomes[0].stop_time)
    for name in ("position", "velocity"):
        ours, theirs = both.bodies["ship"][name][0], one.bodies["ship"][name][0]
        print(np.max(np.abs(ours - theirs)), np.max(np.abs(ours[:, 1])))
        a = both.bodies["left_anchor"][name][0]
        b = one.bodies["anchor"][name][0]
        print(np.max(np.abs(a[:, [0, 2]] - b[:, [0, 2]])))
    print(
        np.max(np.abs(both["left_chain.tension"][0] * 2 - one["chain.tension"][0])),
        np.max(one["chain.tension"][0]),
    )
    print(np.max(np.abs(both["left_chain.tension"][1] - both["right_chain.tension"][2])))
    print(
        np.max(
            np.abs(
                both.bodies["ship"]["position"][1] - both.bodies["ship"]["position"][2] * [1, -1, 1]
            )
        )
    )
    print(np.max(np.abs(both.bodies["ship"]["attitude"][1])))
    print([o.energy_closure for o in both.outcomes])
