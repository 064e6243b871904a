"""What is told of a long run where no terminal shows a bar."""

import re
import time

import pytest
from command_line import SMALL, say
from good_scenes import write

from lumpedcable.study import progress, report, shards_report


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands still until it is set."""
    now = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def told(capsys, clock, seconds, shown=False):
    """What is said of a run of a hundred pieces that takes so long."""
    tell = progress.now_and_then("A rope", shown)
    for done in range(101):
        clock[0] = 1000.0 + seconds * done / 100
        tell(done, 100)
    return capsys.readouterr().err.splitlines()


def test_a_long_run_tells_of_every_tenth(capsys, clock):
    lines = told(capsys, clock, 6000.0)
    assert len(lines) == 9
    assert lines[0] == "A rope: 10 % after 0:10:00, about 1:30:00 left"
    assert lines[-1] == "A rope: 90 % after 1:30:00, about 0:10:00 left"


def test_a_run_of_minutes_tells_once_a_minute(capsys, clock):
    lines = told(capsys, clock, 200.0)
    assert [re.search(r"after (\S+),", line)[1] for line in lines] == [
        "0:01:00",
        "0:02:00",
        "0:03:00",
    ]


def test_what_is_left_is_told_by_what_went_through_time(capsys, clock):
    # four minutes of compiling, or four of ten pieces that an earlier command has done, then 50 s each
    for first, words in ((1, "20 %"), (4, "50 %")):
        clock[0] = 1000.0
        tell = progress.now_and_then("A rope", False)
        tell(0, 10)
        clock[0] = 1240.0
        tell(first, 10)
        clock[0] = 1310.0
        tell(first + 1, 10)
        said = capsys.readouterr().err.splitlines()
        assert (
            said[0] == f"A rope: {10 * first} % after 0:04:00"
        )  # how fast it goes is not known yet
        left = 70 * (10 - first - 1)
        assert (
            said[1] == f"A rope: {words} after 0:05:10, about 0:{left // 60:02}:{left % 60:02} left"
        )


@pytest.mark.parametrize(("seconds", "shown"), [(50.0, False), (6000.0, True)])
def test_a_short_run_and_one_with_a_bar_tell_nothing(capsys, clock, seconds, shown):
    assert told(capsys, clock, seconds, shown) == []


@pytest.mark.parametrize("command", ["run", "study"])
def test_commands_tell_of_it_where_their_output_goes_to_a_file(tmp_path, monkeypatch, command):
    calls = []

    def spied(title, shown):
        assert (title, shown) == ("A rope", False)
        return lambda done, total: calls.append(done / total)

    for module in (report, shards_report):
        monkeypatch.setattr(module, "now_and_then", spied)
    write(tmp_path, SMALL)
    assert say(tmp_path, command, "scene.toml", "-o", "out").code == 0
    assert calls[0] == 0.0
    assert calls[-1] == 1.0
    assert calls == sorted(calls)


@pytest.mark.parametrize(
    ("shown", "early", "told"), [(False, False, 1), (True, False, 0), (False, True, 0)]
)
def test_what_takes_long_before_anything_is_done_is_told(capsys, monkeypatch, shown, early, told):
    monkeypatch.setattr(progress, "PATIENCE", 0.2 if early else 0.0)
    with progress.preparing("A rope", shown) as begun:
        if early:
            begun()
        time.sleep(0.4)
    lines = capsys.readouterr().err.splitlines()
    words = "A rope: under way; what is compiled now is kept for the next run of such a scene"
    assert lines == [words] * told
