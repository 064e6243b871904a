"""A broken line of a damped material, at steps as large as the bound lets them be."""

import numpy as np
import pytest
from engine_runs import run_text

LINE = """
[materials.damped]
law = "linear"
EA = "1 MN"
tension_only = false
damping = "1 kN s"

[lines.rope]
material = "damped"
length = "50 m"
segments = 50
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ held = {{ pretension = "50 kN", direction = [1, 0, 0] }} }}

[events.break]
breaks = "rope.end"
time = "2 ms"

[solver]
waves = "{waves}"

[sweep]
"materials.damped.damping" = ["0.2 kN s", "0.5 kN s", "1 kN s", "2 kN s"]

[output]
duration = "200 ms"
every = "20 ms"
quantities = ["velocity", "energy"]
"""


@pytest.mark.parametrize("waves", ["corrected", pytest.param("viscous", marks=pytest.mark.slow)])
def test_damping_and_viscosity_together_are_stable(tmp_path, waves):
    # the end goes at T / sqrt(EA m) once the break and k / EA, at most 2 ms, are long past
    ran = run_text(tmp_path, LINE.format(waves=waves))
    assert ran.statuses == ["OK"] * 4
    assert max(outcome.energy_closure for outcome in ran.outcomes) < 1e-3
    assert np.abs(ran["velocity"][:, 2, -1, 0]) == pytest.approx(50.0, rel=2e-3)
    # 200 ms are four ways to the wall and back, and damping takes energy all along
    assert np.max(np.abs(ran["velocity"])) < 60.0
