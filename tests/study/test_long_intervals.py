"""Output intervals of many steps: gone through in several calls, between which signals are heard."""

import jax
import numpy as np
import pytest
from engine_runs import nylon_rope, run_text, sliding_block

from lumpedcable.study import batches, shrinking

SLIDING = sliding_block(
    speed=1, step="2 ms", duration="0.4 s", every="40 ms",
    more="""stop = "block"
quantities = ["position", "tension", "energy"]
[sweep]
"bodies.block.velocity.0" = [0.5, 1, 2]
""",
)  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(nylon_rope(20, "20 ms", every="5 ms"), id="a line that parts"),
        pytest.param(SLIDING, id="runs that stop", marks=pytest.mark.slow),
    ],
)
def test_an_interval_in_several_calls_is_the_same_interval(text, tmp_path, monkeypatch):
    whole = run_text(tmp_path, text)
    asked = []
    plainly = shrinking.advance_runs
    monkeypatch.setattr(
        shrinking, "advance_runs", lambda *given: (asked.append(given[-1]), plainly(*given))[1]
    )
    monkeypatch.setattr(batches, "CALL_TIME", 1e-9)  # less than a step takes
    cut = run_text(tmp_path, text)
    assert len(asked) > 10
    assert all(end == start + 1 for start, end in asked)
    for mine, same in zip(
        jax.tree.leaves(_found(cut)), jax.tree.leaves(_found(whole)), strict=True
    ):
        assert np.array_equal(mine, same, equal_nan=True)


def _found(ran):
    return [x.stop_time for x in ran.outcomes], ran.time, ran.lines, ran.energy, ran.bodies
