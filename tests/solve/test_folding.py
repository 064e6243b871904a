"""A slack line that folds as it falls: what is there for fronts along it may not hold it up."""

import numpy as np
import pytest
from engine_runs import run_text

FALLS = """
gravity = 9.81
[water]
density = 1025
[materials.rope]
law = "linear"
EA = "1 MN"
tension_only = true
[lines.rope]
material = "rope"
length = "58 m"
segments = SEGMENTS
mass = "12 kg/m"
diameter = "80 mm"
drag = { normal = 1.2, tangential = 0.05 }
start = { fixed = [0, 0, -20] }
end = { fixed = [50, 0, -15] }
[events.go]
breaks = "rope.end"
time = "0.5 s"
[solver]
courant = 0.5
waves = "WAVES"
[output]
duration = "3 s"
every = "0.1 s"
"""


def shape(folder, segments, waves):
    text = FALLS.replace("SEGMENTS", str(segments)).replace("WAVES", waves)
    ran = run_text(folder, text)
    assert ran.statuses == ["OK"]
    return ran["position"][0, :, :: segments // 12]


@pytest.mark.slow
def test_a_line_that_is_let_go_folds_as_a_plain_chain_does(tmp_path):
    # nothing could hold its folds up; what keeps the lumps of a straight line apart would,
    # by 0.2 m. On this mesh a plain chain is 0.03 m off itself
    off = shape(tmp_path, 24, "corrected") - shape(tmp_path, 24, "plain")
    assert float(np.linalg.norm(off, axis=-1).max()) < 0.01  # m


@pytest.mark.slow
@pytest.mark.parametrize("waves", ["corrected", "viscous"])
def test_a_line_that_is_let_go_folds_to_second_order(tmp_path, waves):
    fine = shape(tmp_path, 48, "plain")
    coarse, middle = (
        float(np.linalg.norm(shape(tmp_path, n, waves) - fine, axis=-1).max()) for n in (12, 24)
    )
    assert coarse < 0.15  # m; a plain chain's own error is 0.12 m
    assert middle < coarse / 3.0
