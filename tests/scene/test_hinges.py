"""Who joins two lines that bend is told that the joint is a hinge."""

import pytest
from engine_runs import line_text, scene_of

from lumpedcable.scene.idle import idle_parts

PIPES = """
[materials.steel]
law = "linear"
EA = "1 MN"

[output]
duration = "1 s"
every = "0.5 s"
"""
BENDS = 'bending = { EI = "300 N m2" }'


@pytest.mark.parametrize(("b", "said"), [(BENDS, 1), ("", 0)])
def test_a_joint_of_two_that_bend_is_a_hinge(tmp_path, b, said):
    clamped = "{ fixed = [0, 0, 0], direction = [1, 0, 0] }"
    first = line_text("a", "steel", 2, 4, 2, clamped, '"free"', BENDS)
    second = line_text("b", "steel", 2, 4, 2, '"a.end"', '"free"', b)
    words = list(idle_parts(scene_of(tmp_path, PIPES + first + second)))
    assert len(words) == said
    assert all(w.startswith("lines.b.start is a hinge") for w in words)
