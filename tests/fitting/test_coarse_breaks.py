"""What is said of breaks that are over before a wave is through a segment: c is 1000 m/s here."""

import pytest
from engine_runs import HOOKE, scene_of

from lumpedcable.fitting.coarse import coarse_breaks


def told(folder, *changes):
    """What is said of the 100 m line, with `changes` of its text."""
    text = HOOKE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return coarse_breaks([scene_of(folder, text)])


def breaking(time, segments=50):
    """A break of so long (ms) with so many segments, of 2 ms for 50."""
    return ("time = 0", f'time = "{time} ms"'), ("segments = 50", f"segments = {segments}")


@pytest.mark.parametrize(("time", "coarse"), [(1.9, True), (2.1, False)])
def test_from_a_segments_travel_on_all_is_well(tmp_path, time, coarse):
    assert bool(told(tmp_path, *breaking(time))) == coarse


def test_the_segments_that_would_do(tmp_path):
    (said,) = told(tmp_path, *breaking(0.5, 10))
    assert said.startswith(
        '"break" breaks in 500 us, and a wave takes 10 ms through a segment of "rope"'
    )
    assert 'Take 400 segments ("lines.rope.segments" in [set]).' in said
    assert not told(tmp_path, *breaking(0.5, 400))
    assert "Take" not in told(tmp_path, *breaking(0.01, 10))[0]  # nobody would


def test_a_break_at_once(tmp_path):
    (said,) = told(tmp_path)
    assert "breaks at once" in said


def test_the_segments_beside_it_count(tmp_path):
    # 2 m at the start, some 30 times as long as at the end
    graded = ("segments = 50", "segments = 50\ngrading = 0.0333")
    assert not told(tmp_path, graded, ("time = 0", "time = 0.0005"))
    assert told(tmp_path, graded, ("time = 0", "time = 0.0005"), ('"rope.end"', '"rope.start"'))


def test_the_worst_of_all_records_alone_is_told(tmp_path):
    scenes = [scene_of(tmp_path, HOOKE, f"break.time={time} ms") for time in (1.5, 0.5, 1.0, 9.0)]
    (said,) = coarse_breaks(scenes)
    assert '"break" breaks in 500 us' in said
