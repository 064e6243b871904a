"""Materials that relax faster than a step of leapfrog, under methods whose steps that bounds."""

import numpy as np
import pytest
from engine_runs import run_text

import lumpedcable as lc

# waves of 250 m/s cross a segment of 2.5 m in 10 ms; the branch relaxes within 2 ms
LINE = """
[materials.fibre]
law = "linear"
EA = "1.25 MN"
relaxation = { fast = { EA = "50 kN", time = "2 ms" } }
[lines.rope]
material = "fibre"
length = "10 m"
segments = 4
mass = "20 kg/m"
start = { fixed = [0, 0, 0] }
end = { motion = { position = [11, 0, 0], amplitude = [0.1, 0, 0], period = "1 s" } }
[solver]
method = "rk4"
waves = "plain"
[output]
duration = "0.3 s"
every = "50 ms"
"""


KEYS = ["materials.fibre.relaxation.fast.time", "materials.fibre.EA"]


@pytest.mark.slow
def test_a_response_by_rk4_takes_the_steps_of_a_run(tmp_path):
    ran = run_text(tmp_path, LINE)
    assert ran.statuses == ["OK"]
    found = lc.response(tmp_path / "scene.toml", KEYS, "last tension at rope.start")
    assert float(found(found.values)) == pytest.approx(ran["start_tension"][0, -1], rel=1e-9)


@pytest.mark.slow
def test_a_time_too_short_for_those_steps_is_no_number(tmp_path):
    (tmp_path / "scene.toml").write_text(LINE)
    found = lc.response(tmp_path / "scene.toml", KEYS, "last tension at rope.start")
    assert np.isfinite(float(found(found.values)))
    assert np.isnan(float(found(found.values * np.array([0.25, 1.0]))))
