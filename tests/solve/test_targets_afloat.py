"""Lengths that bring moored bodies to wanted tensions and places, where they are at rest."""

import pytest
from engine_runs import fixed, line_text, run_text, scene_of
from moored_buoy import BUOY, target

from lumpedcable.scene import SceneError

STIFF, LENGTH, APART, THRUST = 1e6, 10.0, 21.0, 3e3  # N, m, m, N
SPRINGS = (
    f"""
[materials.wire]
law = "linear"
EA = {STIFF}
tension_only = true

[bodies.box]
mass = 500
position = [9.7, 0, 0]
free = ["x"]
control = {{ force = [{THRUST}, 0, 0] }}
settle = true
"""
    + line_text("left", "wire", LENGTH, 3, 0.1, fixed(0, 0, 0), '"box"')
    + line_text("right", "wire", LENGTH, 3, 0.1, fixed(APART, 0, 0), '"box"')
    + "[output]\n"
)


def rest(folder, text):
    """Unstretched lengths (m), tensions at the fixed ends (N), and where the box is (m)."""
    ran = run_text(folder, text)
    assert ran.statuses == ["OK"]
    lengths = [ran.places[name][..., -1].item() for name in ("left", "right")]
    pulls = [ran[f"{name}.start_tension"][0, 0] for name in ("left", "right")]
    return lengths, pulls, ran.bodies["box"]["position"][0, 0]


@pytest.mark.slow
def test_a_tension(tmp_path):
    # the right line then pulls with T - F, and is EA-stretched from where the box must be
    lengths, pulls, place = rest(
        tmp_path, SPRINGS + target("tight", "left", "left.end", tension=6e4)
    )
    x = APART - LENGTH * (1.0 + (6e4 - THRUST) / STIFF)
    assert place[0] == pytest.approx(x, rel=1e-10)
    assert pulls == pytest.approx([6e4, 6e4 - THRUST], rel=1e-9)
    assert lengths == pytest.approx([x / (1.0 + 6e4 / STIFF), LENGTH], rel=1e-10)


@pytest.mark.slow
def test_a_place_and_a_tension(tmp_path):
    goals = target("here", "left", "box", x=10.2) + target(
        "tight", "right", "right.start", tension=5e4
    )
    lengths, pulls, place = rest(tmp_path, SPRINGS + goals)
    assert place[0] == pytest.approx(10.2, rel=1e-10)
    assert pulls == pytest.approx([5e4 + THRUST, 5e4], rel=1e-9)
    exact = [10.2 / (1.0 + (5e4 + THRUST) / STIFF), (APART - 10.2) / (1.0 + 5e4 / STIFF)]
    assert lengths == pytest.approx(exact, rel=1e-10)


@pytest.mark.slow
def test_a_buoy_on_catenaries(tmp_path):
    # that a buoy which settles on lines of the length found has that tension, statics alone tells
    text = BUOY + "[output]\n"
    goals = target("tight", "left", "left.end", tension=15e3) + target(
        "middle", "right", "buoy", x=2.0
    )
    ran = run_text(tmp_path, text + goals)
    assert ran.statuses == ["OK"]
    lengths = [ran.places[name][..., -1].item() for name in ("left", "right")]
    assert ran["left.end_tension"][0, 0] == pytest.approx(15e3, rel=1e-8)
    place = ran.bodies["buoy"]["position"][0, 0]
    assert place[0] == pytest.approx(2.0, abs=1e-8)
    left, right = lengths
    again = run_text(tmp_path, text, f"lines.left.length={left!r}", f"lines.right.length={right!r}")
    assert again.bodies["buoy"]["position"][0, 0] == pytest.approx(place, abs=1e-7)
    assert again["left.end_tension"][0, 0] == pytest.approx(15e3, rel=1e-7)


def test_a_body_that_is_held_has_no_place_to_be_found(tmp_path):
    text = SPRINGS.replace("settle = true", "") + target("here", "left", "box", x=10.2)
    with pytest.raises(
        SceneError, match=r'expected a body that statics moves, found "box", which is held'
    ):
        scene_of(tmp_path, text)
