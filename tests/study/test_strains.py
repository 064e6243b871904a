"""A line that is stretched beyond max_strain of its material says so: when, which, how far."""

import re

import numpy as np
import pytest
from engine_runs import run_text, study_of

from lumpedcable.status import Status
from lumpedcable.study.run import run_study
from lumpedcable.study.strains import strain_under

# pulled from 10 m on at 10 m/s; waves of 1000 m/s leave steps of 2 v / c = 0.02 in the strain
LENGTH, SPEED = 10.0, 10.0
PULLED = f"""
[materials.cord]
law = "linear"
EA = "1 MN"
max_strain = 0.3
[lines.rope]
material = "cord"
length = {LENGTH}
segments = 8
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = [{LENGTH}, 0, 0], velocity = [{SPEED}, 0, 0] }} }}
[output]
duration = "400 ms"
every = "2 ms"
"""
SLOW = PULLED.replace('EA = "1 MN"', 'EA = "1 MN"\ndamping = "10 kN s"')
LEFT = PULLED.replace("[lines.rope]", "[materials.other]\nlaw = 'linear'\nEA = 1e6\n[lines.rope]")
LEFT += """
[lines.left]
material = "other"
length = 10
segments = 2
mass = "1 kg/m"
start = { fixed = [0, 1, 0] }
end = { fixed = [14, 1, 0] }
"""


RK4 = PULLED + "[solver]\nmethod = 'rk4'\nstep = '0.5 ms'\n"


@pytest.mark.parametrize(
    ("text", "keep"),
    [
        (PULLED, "fields"),
        (PULLED, "summaries"),
        pytest.param(RK4, "fields", marks=pytest.mark.slow),
        pytest.param(RK4, "summaries", marks=pytest.mark.slow),
        pytest.param(SLOW, "fields", marks=pytest.mark.slow),
        pytest.param(SLOW, "summaries", marks=pytest.mark.slow),
        # in another line, which is at 0.4 of its 0.5, there is none
        pytest.param(LEFT, "fields", marks=pytest.mark.slow),
        pytest.param(LEFT, "summaries", marks=pytest.mark.slow),
    ],
)
def test_a_line_stretched_beyond_says_which_when_and_how_far(tmp_path, text, keep):
    study = study_of(tmp_path, text, f"output.keep={keep}")
    (outcome,) = run_study(study, tmp_path / "result.h5")
    assert outcome.status is Status.STRAIN_EXCEEDED
    reaches = 0.3 * LENGTH / SPEED
    steps = 2.0 * LENGTH / 1000.0
    assert reaches - steps <= outcome.status_time <= reaches + 4e-3
    assert f"at {1e3 * outcome.status_time:.6g} ms" in outcome.message
    assert 'line "rope"' in outcome.message
    then, later = re.findall(r"a strain of (\S+), and (\S+) later on", outcome.message)[0]
    stretched = outcome.status_time * SPEED / LENGTH
    assert 0.3 < float(then) == pytest.approx(stretched, abs=0.021)
    assert float(later) == pytest.approx(0.4, abs=0.021)  # at the end, 4 m further
    assert "max_strain of its material is 0.3" in outcome.message
    assert "raise max_strain" in outcome.message
    assert "units" in outcome.message


def test_told_the_truth_about_the_rope_it_runs(tmp_path):
    swept = PULLED + '[sweep]\n"materials.cord.max_strain" = [0.3, 0.45, 0.2]\n'
    ran = run_text(tmp_path, swept)
    assert ran.statuses == ["STRAIN_EXCEEDED", "OK", "STRAIN_EXCEEDED"]
    assert ran.outcomes[2].status_time == pytest.approx(0.2, abs=0.02)
    assert ran.outcomes[1].message == "ok"


def test_a_record_in_mm_that_is_read_as_m(tmp_path):
    text = PULLED.replace(f"position = [{LENGTH}, 0, 0]", "position = [10200, 0, 0]")
    (outcome,) = run_text(tmp_path, text).outcomes
    # before anything has moved it is stretched to 1020 times its length
    assert outcome.status is Status.STRAIN_EXCEEDED
    assert outcome.status_time == 0.0
    assert "a strain of 1019" in outcome.message


BLOCK, STIFFNESS = 1e3 - 0.5, 1e5  # kg, N/m; half of the line's kg moves along
PERIOD = 2.0 * np.pi * np.sqrt(1e3 / STIFFNESS)
# a block at 1 m/s is caught by a line of 1 m and back half a period later: strain v / w = 0.1; then the
# line is slack
CAUGHT = f"""
[materials.elastic]
law = "linear"
EA = {STIFFNESS}
tension_only = true
max_strain = 0.05
[lines.rope]
material = "elastic"
length = 1
segments = 1
mass = 1
start = {{ fixed = [0, 0, 0] }}
end = "block.face"
[bodies.block]
mass = {BLOCK}
position = [1.5, 0, 0]
velocity = [1, 0, 0]
points = {{ face = [-0.5, 0, 0] }}
free = ["x"]
[solver]
step = "0.2 ms"
[output]
duration = {PERIOD}
every = {PERIOD / 2}
"""


def test_a_strain_that_comes_and_goes_between_two_outputs_is_seen(tmp_path):
    (outcome,) = run_text(tmp_path, CAUGHT).outcomes
    assert outcome.status is Status.STRAIN_EXCEEDED
    assert outcome.status_time == pytest.approx(PERIOD / 2)
    assert "a strain of 0.1," in outcome.message
    (fine,) = run_text(tmp_path, CAUGHT.replace("0.05", "0.11")).outcomes
    assert fine.status is Status.OK


def test_slack_is_no_strain_beyond(tmp_path):
    text = CAUGHT.replace("velocity = [1,", "velocity = [-1,")
    (outcome,) = run_text(tmp_path, text).outcomes  # the block comes to 0.37 m from the wall
    assert outcome.status is Status.OK


@pytest.mark.parametrize(
    ("law", "share", "strain"),
    [
        (lambda e: 1e3 * e, 2.0, 1.0),
        (lambda e: 1e3 * e**2, 4.0, 1.0),
        (lambda e: 1e3 * np.tanh(e), 1e3, None),  # it gives that nowhere
        (lambda e: 1e3 * np.minimum(e, 0.6 - e), 2.0, None),  # and that at 0.3 already
    ],
)
def test_the_strain_beyond_that_a_law_gives_a_tension_at(law, share, strain):
    found = strain_under(law, share, 0.5)
    assert found == (None if strain is None else pytest.approx(strain, rel=1e-12))
