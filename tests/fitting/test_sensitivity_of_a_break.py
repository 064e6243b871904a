"""What the speed of a broken end depends on, against the simple wave."""

import numpy as np
import pytest
from engine_runs import nylon_rope, study_of
from nylon_line import MASS, P1, P2, P3, P4, P5

from lumpedcable.exact import release_wave
from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import sensitivity_of

LAW = [f"materials.nylon.p{k}" for k in range(1, 6)]
KEYS = (*LAW, "lines.rope.end.held.pretension", "lines.rope.mass")
VALUES = np.array([P1, P2, P3, P4, P5, 45e3, MASS])


def end_speed(numbers):
    """Speed (m/s) of the end of a line with these numbers, broken at once."""
    p1, p2, p3, p4, p5, force, mass = numbers

    def tension(e):
        return p1 * np.tanh(p2 * e + p3) + p4 + p5 * e

    return release_wave(tension, mass, tension0=force).end_speed


@pytest.mark.slow
def test_shares_of_the_speed_behind_the_front(tmp_path):
    assert end_speed(VALUES) == pytest.approx(43.17086886, rel=1e-8)
    wanted = {}
    for key, one in zip(KEYS, np.eye(VALUES.size), strict=True):
        more, less = (end_speed(VALUES * (1.0 + h * one)) for h in (1e-5, -1e-5))
        wanted[key] = (more - less) / 2e-5 / end_speed(VALUES)
    # p1 and p4 nearly cancel in the unstretched line, so that each alone matters most
    assert wanted[LAW[0]] == pytest.approx(-6.474, abs=1e-3)

    study = study_of(tmp_path, nylon_rope(200, "40 ms"))
    found = sensitivity_of(study, read_scalar("last velocity at rope.end", study.scene))
    assert found.value == pytest.approx(end_speed(VALUES), rel=1e-4)
    share = dict(zip(found.keys, found.shares, strict=True))
    for key, value in wanted.items():
        assert share[key] == pytest.approx(value, rel=1e-3, abs=1e-5), key
    # the line is too long to matter, and so is the time that the break takes
    assert share["lines.rope.length"] == pytest.approx(0.0, abs=3e-4)
    assert share["events.break.time"] == pytest.approx(0.0, abs=3e-4)
    assert found.remarks == []
    assert found.check is not None
    assert found.check.good


PULLED = """
[materials.wire]
law = "linear"
EA = 1e6
damping = 1e3
[lines.rope]
material = "wire"
length = 20
segments = 4
mass = 1
start = { fixed = [0, 0, 0] }
end = { motion = { position = [20, 0, 0], velocity = [0.02, 0, 0], ramp = 0.4 } }
[events.break]
breaks = "rope.end"
start = 1.0003
time = 2
[solver]
step = 1e-3
[output]
duration = 2.1
every = 0.05
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", ["leapfrog", "rk4"])
def test_a_line_under_growing_load_carries_more_the_later_it_breaks(tmp_path, method):
    study = study_of(tmp_path, PULLED, f"solver.method={method}")
    found = sensitivity_of(study, read_scalar("last tension at rope.start", study.scene))
    # slowly, T = EA v (s - ramp/2)/L cos^2(pi x/2), x = (t - s)/time: more is left, and of more
    start, time, pulled = 1.0003, 2.0, 1.0003 - 0.2
    x = (2.1 - start) / time
    held, rate = np.cos(0.5 * np.pi * x) ** 2, 0.5 * np.pi / time * np.sin(np.pi * x)
    assert found.value == pytest.approx(1e3 * pulled * held, rel=0.02)
    slope = dict(zip(found.keys, found.slopes, strict=True))["events.break.start"]
    assert slope == pytest.approx(1e3 * (held + pulled * rate), rel=0.02)
