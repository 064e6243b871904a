"""Strain and tension of an end at rest are those at the end, not in the middle of its last segment."""

import re

import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text

from lumpedcable.results import open_result
from lumpedcable.view.sampling import RecoilingEnd

HEAVY = """
gravity = "9.81 m/s2"

[materials.rope]
law = "linear"
EA = "50 kN"

[bodies.weight]
mass = "50 kg"
position = [0, 0, -10.1]
free = ["z"]
inertia = [1, 1, 1]
points = { top = [0, 0, 0] }
settle = true

[events.parts]
breaks = "rope.end"
time = "1 ms"

[output]
duration = "10 ms"
every = "5 ms"
"""


@pytest.mark.parametrize(
    ("end", "below", "segments"),
    [
        ("start", 5.0, 1),
        pytest.param("start", 5.0, 4, marks=pytest.mark.slow),
        pytest.param("end", 0.0, 4, marks=pytest.mark.slow),
    ],
)
def test_half_a_segment_of_weight_is_not_left_out(tmp_path, end, below, segments):
    rope = line_text("rope", "rope", 10, segments, 0.5, fixed(0, 0, 0), '"weight.top"')
    found = (
        run_text(tmp_path, HEAVY + rope, f"events.parts.breaks=rope.{end}")
        .outcomes[0]
        .recoils[f"rope.{end}"]
    )
    force = (50.0 + below) * 9.81
    assert found["static_tension"] == pytest.approx(force, rel=1e-8)
    assert found["static_strain"] == pytest.approx(force / 50e3, rel=1e-8)


FAST = """
[materials.rope]
law = "linear"
EA = "100 kN"
max_strain = 0.04

[events.parts]
breaks = "rope@5 m"
tension = "5 kN"
time = "2 ms"

[output]
duration = "0.5 s"
every = "10 ms"
"""


@pytest.mark.slow
def test_what_a_run_does_after_its_end_is_not_told_as_its_own(tmp_path):
    """Its break at 5 kN, a strain of 0.05, comes when its law is no longer used as it is."""
    pulled = '{ motion = { position = [10, 0, 0], velocity = [2, 0, 0], ramp = "0.2 s" } }'
    rope = line_text("rope", "rope", 10, 8, 0.5, fixed(0, 0, 0), pulled)
    outcome = run_text(tmp_path, FAST + rope).outcomes[0]
    assert outcome.status.name == "STRAIN_EXCEEDED"
    assert not outcome.recoils
    told = re.search(r"at (\S+) ms: .* a strain of (\S+), and (\S+) later on", outcome.message)
    assert told
    when, then, later = map(float, told.groups())
    # the far end has gone 2 (t - 0.1) metres: strains within those of a wave of it
    assert 0.04 < then < 0.04 + 0.004
    assert 1e-3 * when == pytest.approx(0.1 + 0.4 / 2.0, abs=0.011)
    assert 0.05 < later < 0.056
    with open_result(tmp_path / "result.h5") as result:
        assert result.ends
        for name in result.ends:
            assert np.isnan(result.summary()[name]["break_start"]).all()
            assert np.isnan(RecoilingEnd(result, name).displacement(0)).all()
