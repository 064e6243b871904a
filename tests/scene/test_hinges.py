"""Who joins two lines that bend is told that the joint is a hinge."""

import pytest
from engine_runs import scene_of

from lumpedcable.scene.idle import idle_parts

PIPES = """
[materials.steel]
law = "linear"
EA = "1 MN"

[lines.a]
material = "steel"
length = "2 m"
segments = 4
mass = "2 kg/m"
{a}
start = {{ fixed = [0, 0, 0], direction = [1, 0, 0] }}

[lines.b]
material = "steel"
length = "2 m"
segments = 4
mass = "2 kg/m"
{b}
start = "a.end"
end = "free"

[output]
duration = "1 s"
every = "0.5 s"
"""
BENDS = 'bending = { EI = "300 N m2" }'


@pytest.mark.parametrize(("b", "said"), [(BENDS, 1), ("", 0)])
def test_a_joint_of_two_that_bend_is_a_hinge(tmp_path, b, said):
    text = PIPES.format(a=BENDS, b=b).replace("lines.a]", 'lines.a]\nend = "free"')
    words = list(idle_parts(scene_of(tmp_path, text)))
    assert len(words) == said
    assert all(w.startswith("lines.b.start is a hinge") for w in words)
