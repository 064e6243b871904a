"""A derivative says that its run went wrong, as the run itself does."""

import numpy as np
import pytest
from engine_runs import ROPE, run_scenes, study_of

from lumpedcable.fitting.scalar import read_scalar
from lumpedcable.fitting.sensitivity import scalar_slopes

# 450 kN without drag: the line arrives at the wall and goes through itself
PILES_UP = ROPE.replace("tension_only = false", "tension_only = true")
PULLED = ("segments=50", "pretension=450 kN")  # one program for as many outputs
PULLED_ON = """
[materials.m]
law = "linear"
EA = "1 kN"
max_strain = 0.4
[lines.rope]
material = "m"
length = "5 m"
segments = 10
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { motion = { position = ["5 m", 0, 0], velocity = ["8 m/s", 0, 0] } }
[output]
duration = "0.3 s"
every = "10 ms"
"""
TIPS = """
dimensions = 3
[materials.m]
law = "linear"
EA = "1 kN"
[lines.rope]
material = "m"
length = "2 m"
segments = 1
mass = "10 g/m"
start = { fixed = [0, 0, 1] }
end = "b"
[bodies.b]
mass = "100 kg"
position = [0, 0, 0]
inertia = [10, 20, 15]
control.moment = [0, "40 N m", 0]
[output]
duration = "2 s"
every = "50 ms"
[solver]
step = "5 ms"
"""


@pytest.mark.parametrize(
    ("text", "overrides", "wanted"),
    [
        pytest.param(
            PILES_UP,
            (*PULLED, "output.duration=120 ms", "output.every=6 ms"),
            "LINE_REVERSED",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            PILES_UP,
            (*PULLED, "output.duration=20 ms", "output.every=1 ms"),
            "OK",
            marks=pytest.mark.slow,
        ),
        # pulled on at 8 m/s, c = 31.6 m/s: a strain of 0.253, and twice that from the wall at 0.158 s
        pytest.param(PULLED_ON, (), "STRAIN_EXCEEDED", marks=pytest.mark.slow),
        pytest.param(PULLED_ON, ("materials.m.max_strain=0.9",), "OK", marks=pytest.mark.slow),
        pytest.param(TIPS, (), "BODY_UPENDED", marks=pytest.mark.slow),
    ],
)
def test_a_derivative_tells_how_its_run_ended(tmp_path, text, overrides, wanted):
    study = study_of(tmp_path, text, *overrides)
    scalar, key = read_scalar("max tension at rope.start", study.scene), "lines.rope.mass"
    values = np.array([study.scene.numbers()[key]])
    _, status, _ = scalar_slopes(study, scalar, (key,), values)
    assert [status.name] == run_scenes(tmp_path, study).statuses == [wanted]
