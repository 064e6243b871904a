"""What rests pushed together is told."""

import pytest
from engine_runs import run_text

LAID = """
gravity = 9.81
[seabed]
height = 0
stiffness = "100 kPa"
[materials.own]
law = "linear"
EA = "1 MN"
MORE
[lines.rope]
material = "own"
length = 11
segments = 8
mass = 20
start = { fixed = [0, 0, 0] }
end = { fixed = [END, 0, 0] }
[output]
"""


@pytest.mark.parametrize(
    ("end", "more", "words"),
    [
        # ends on a bed, a tenth too near: on it nothing can give way
        (10, "", "ok; rope rests pushed together by 9.1 %, which no line without bending bears: give it "
         "materials.own.tension_only"),
        pytest.param(10, "tension_only = true", "ok", marks=pytest.mark.slow),
        pytest.param(11.1, "", "ok", marks=pytest.mark.slow),
    ],
)  # fmt: skip
@pytest.mark.slow
def test_a_line_that_rests_pushed_together_is_told(tmp_path, end, more, words):
    (outcome,) = run_text(tmp_path, LAID.replace("END", str(end)).replace("MORE", more)).outcomes
    assert outcome.status.name == "OK"
    assert outcome.message == words
