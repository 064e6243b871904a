"""Lines that are folded at rest already, where the mesh has no more to say: only new folds are told."""

import pytest
from engine_runs import run_text

# 6 m over 0.5 m: the bottom of the U turns by more than 90 degrees at one joint or two
NARROW = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "100 kN"
[lines.chain]
material = "steel"
length = "6 m"
segments = 12
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { fixed = [0.5, 0, 0] }
[output]
duration = "0.1 s"
every = "10 ms"
quantities = ["velocity"]
"""


# 4 are turned at one joint as 12 are, 3 at two
@pytest.mark.parametrize(
    "segments",
    [3, pytest.param(4, marks=pytest.mark.slow), pytest.param(12, marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_a_chain_at_rest_in_a_narrow_u_is_not_reversed(tmp_path, segments):
    ran = run_text(tmp_path, NARROW, f"lines.chain.segments={segments}")
    assert ran.statuses == ["OK"]
    assert abs(ran["velocity"]).max() < 1e-6


# rods have no damping that they could be given
@pytest.mark.parametrize(
    ("law", "advised"),
    [
        ('law = "linear"\nEA = "100 kN"', "materials.steel.damping and lines.chain.drag"),
        pytest.param(
            'law = "inextensible"\n[solver]\nstep = "1 ms"',
            "or give the line lines.chain.drag",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_one_that_folds_elsewhere_is_told(tmp_path, law, advised):
    # its end is thrown down beside itself, faster than it falls: there it doubles back
    thrown = "{ motion = { position = [0.5, 0, 0], velocity = [2, 0, -10] } }"
    text = NARROW.replace("{ fixed = [0.5, 0, 0] }", thrown)
    ran = run_text(
        tmp_path, text.replace('law = "linear"\nEA = "100 kN"', law), "output.duration=0.3 s"
    )
    assert ran.statuses == ["LINE_REVERSED"]
    assert 0.0 < ran.outcomes[0].status_time < 0.3
    assert advised in ran.outcomes[0].message
