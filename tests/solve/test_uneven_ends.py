"""The tension at an end does not depend on how the segments there are cut."""

import numpy as np
import pytest
from engine_runs import line_text, run_text

G, MASS, LENGTH = 9.81, 10.0, 10.0  # m/s2, kg/m, m
WIRE = f"""
gravity = {G}
[materials.wire]
law = "linear"
EA = 1e7
[output]
duration = 0.02
every = 0.01
"""
CUTS = [
    pytest.param([1.0] * 10, marks=pytest.mark.slow),
    pytest.param([0.01, 0.99, *[1.0] * 9], marks=pytest.mark.slow),
    pytest.param([0.1, 1.9, 2.0, 2.0, 2.0, 2.0], marks=pytest.mark.slow),
    [2.5, 0.5, 1.0, 5.9, 0.1],
]


def cut(lengths, start, end, more=""):
    text = line_text("wire", "wire", LENGTH, len(lengths), MASS, start, end, more)
    return WIRE + text.replace(f"segments = {len(lengths)}", f"segment_lengths = {lengths}")


@pytest.mark.parametrize("lengths", CUTS)
@pytest.mark.parametrize("turned", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_what_hangs_pulls_with_its_weight(tmp_path, lengths, turned):
    """A parabola of dT/ds = m g is a straight line, whatever it goes through."""
    ends = ["{ fixed = [0, 0, 0] }", '"free"']
    if turned:
        lengths, ends = lengths[::-1], ends[::-1]
    ran = run_text(tmp_path, cut(lengths, *ends))
    told = [ran["start_tension"][0, 0], ran["end_tension"][0, 0]]
    weight = MASS * G * LENGTH
    assert (told[::-1] if turned else told) == pytest.approx([weight, 0.0], rel=1e-8, abs=1e-6)


def test_a_clamp_pulls_along_its_direction_alone(tmp_path):
    """What hangs on a cantilever does not pull along it where it is clamped level."""
    lengths = [0.02, *[(LENGTH - 0.02) / 60] * 60]
    clamp = "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"
    text = cut(lengths, clamp, '"free"', "bending = { EI = 5e4 }")
    ran = run_text(tmp_path, text)
    nodes = ran["position"][0, 0]
    assert nodes[-1, 2] < -0.1 * LENGTH
    assert abs(ran["start_tension"][0, 0]) < 5e-4 * MASS * G * LENGTH
    assert np.abs(ran["tension"][0, 0]).max() > 0.1 * MASS * G * LENGTH
