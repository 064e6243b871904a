"""Runs that stop early leave their batch: nothing of what they or the others come to may change."""

import numpy as np
import pytest
from engine_runs import run_text, sliding_block

from lumpedcable.study import batches, shrinking

SLIDING = sliding_block(
    speed=1, step="2 ms", duration="1.2 s", every="40 ms",
    more="""stop = "block"
quantities = ["position", "energy"]
[sweep]
"bodies.block.velocity.0" = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 3, 4]
""",
)  # fmt: skip
SPEEDS = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 3.0, 4.0])


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The same runs with and without giving up lanes; and how many lanes there were."""
    sizes = []
    whole = run_text(tmp_path_factory.mktemp("whole"), SLIDING)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shrinking, "COMPILING", 0.0)
        patch.setattr(batches, "CPU", batches.CPU._replace(first=1))
        plain = shrinking.Batch.shrink
        patch.setattr(
            shrinking.Batch, "shrink", lambda b, s: (plain(b, s), sizes.append(b.size))[0]
        )
        less = run_text(tmp_path_factory.mktemp("less"), SLIDING)
    return whole, less, sizes


@pytest.mark.slow
def test_lanes_are_given_up_as_runs_stop(both):
    _, _, sizes = both
    assert sizes[0] == 8
    assert sizes[-1] == 4


@pytest.mark.slow
def test_what_runs_come_to_stays_the_same(both):
    whole, less, _ = both
    for name in ("position", "velocity"):
        same = whole.bodies["block"][name]
        assert less.bodies["block"][name] == pytest.approx(same, rel=1e-12, abs=1e-12)
    for kind, same in whole.energy.items():
        assert less.energy[kind] == pytest.approx(same, rel=1e-9, abs=1e-6)
    exact = SPEEDS / (0.4 * 9.81)  # v / (mu g)
    # the line, of a millionth of the mass, is all that the closed form does not know
    stops = np.array([outcome.stop_time for outcome in less.outcomes])
    assert stops == pytest.approx(exact, rel=3e-6)


@pytest.mark.slow
def test_lanes_are_given_up_at_the_same_outputs_however_they_are_asked_for(tmp_path, monkeypatch):
    """As many go at once as a machine's load allows; what is asked after is not how long it took."""
    monkeypatch.setattr(shrinking, "COMPILING", 0.0)
    plain, found = shrinking.Batch.shrink, []
    for first in (1, 16):
        monkeypatch.setattr(batches, "CPU", batches.CPU._replace(first=first))
        told = []
        monkeypatch.setattr(
            shrinking.Batch,
            "shrink",
            lambda b, left, told=told: (plain(b, left), told.append((left, b.size)))[0],
        )
        run_text(tmp_path, SLIDING)
        found.append(told)
    assert found[0] == found[1]
    assert found[0][0][1] > found[0][-1][1]


def test_a_run_is_looked_at_after_whole_parts_of_it():
    for count in (1, 30, 64, 65, 1000):
        done, looks = 0, 0
        while done < count:
            ahead = shrinking.until_look(done, count)
            assert not any(shrinking.looks_at(done + k, count) for k in range(1, ahead))
            done, looks = done + ahead, looks + 1
            assert shrinking.looks_at(done, count)
        assert looks <= shrinking.LOOKS
