"""Derivatives through a state of rest: of places beside targets, and where it has no stiffness."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import study_of

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes, sensitivity_of
from lumpedcable.scene import load_study

DELIVERY = Path(__file__).parents[2] / "configs" / "highline" / "delivery-tension.toml"
PLACES = ("lines.after.end.fixed.0", "lines.after.end.fixed.2", "lines.before.start.fixed.2")


@pytest.mark.slow
def test_places_of_held_ends_matter_where_targets_choose_the_lengths_of_joined_lines():
    short = ("before.segments=4", "after.segments=4", "targets.cargo.x=30 m", "EA=75 MN")
    study = load_study(DELIVERY, short)
    scalar = read_scalar("max tension at after.end", study.runs[0])
    values = np.array([study.runs[0].numbers()[key] for key in PLACES])
    _, _, slopes = scalar_slopes(study, scalar, PLACES, values)
    for k, one in enumerate(np.eye(3)):
        more, less = (
            scalar_slopes(study, scalar, PLACES, values + h * one)[0] for h in (0.01, -0.01)
        )
        assert slopes[k] == pytest.approx((more - less) / 0.02, rel=1e-5)
    # raised together, the posts change nothing
    assert abs(slopes[1]) > 300
    assert slopes[1] + slopes[2] == pytest.approx(0.0, abs=1e-6 * abs(slopes[1]))


SLACK = """
[materials.hooke]
law = "linear"
EA = "1 MN"
tension_only = true
max_strain = 0.1
[lines.rope]
material = "hooke"
length = "50 m"
segments = 4
mass = "1 kg/m"
start = { motion = { position = ["-24.875 m", 0, 0], velocity = ["-2.5 m/s", 0, 0] } }
end = { fixed = ["24.875 m", 0, 0] }
[output]
duration = "200 ms"
every = "4 ms"
"""

HANGING = """
gravity = 9.81
[seabed]
height = -8
stiffness = "100 kPa"
[materials.wire]
law = "linear"
EA = "1 MN"
[lines.wire]
material = "wire"
length = 5
segments = 3
mass = 3
start = { fixed = [0, 0, 0] }
end = "free"
[output]
duration = "20 ms"
every = "20 ms"
"""


def both_ways(study, of):
    """A scalar's derivatives by key, forward and in reverse mode."""
    scalar = read_scalar(of, study.runs[0])
    found = (sensitivity_of(study, scalar, reverse=back) for back in (False, True))
    return [dict(zip(one.keys, map(float, one.slopes), strict=True)) for one in found]


@pytest.mark.parametrize("asked", ["max velocity at rope@24m", "max tension at rope@30m"])
@pytest.mark.slow
def test_a_place_stays_at_its_distance_from_the_start(tmp_path, asked):
    # of a longer line of as many segments it lies nearer to the start's node, or segment
    study = study_of(tmp_path, SLACK)
    of, length = read_scalar(asked, study.runs[0]), ("lines.rope.length",)
    _, _, (slope,) = scalar_slopes(study, of, length, np.array([50.0]))
    more, less = (scalar_slopes(study, of, length, np.array([50 + h]))[0] for h in (1e-5, -1e-5))
    assert slope == pytest.approx((more - less) / 2e-5, rel=1e-6)


@pytest.mark.slow
def test_a_slack_line_without_weight_has_derivatives_either_way(tmp_path):
    forward, reverse = both_ways(study_of(tmp_path, SLACK), "max velocity at rope@24m")
    assert all(np.isfinite(list(reverse.values())))
    # only the distance of the ends counts
    assert reverse["lines.rope.end.fixed.0"] == pytest.approx(
        -reverse["lines.rope.start.motion.position.0"], rel=1e-9
    )
    for key, slope in forward.items():
        assert reverse[key] == pytest.approx(slope, rel=1e-8, abs=1e-9), key


@pytest.mark.slow
def test_a_line_that_hangs_over_a_bed_has_derivatives_either_way(tmp_path):
    # tension at the top: m g L
    wanted = {"lines.wire.length": 3 * 9.81, "lines.wire.mass": 5 * 9.81, "gravity": 15.0}
    for found in both_ways(study_of(tmp_path, HANGING), "max tension at wire.start"):
        assert all(np.isfinite(list(found.values())))
        for key, slope in found.items():
            assert slope == pytest.approx(wanted.get(key, 0.0), rel=1e-8, abs=1e-6), key
