"""What lies between two outputs is in no measure: a run says where that may matter."""

from contextlib import redirect_stdout
from io import StringIO
from types import SimpleNamespace

import numpy as np
import pytest
from engine_runs import study_of

from lumpedcable.results import describe
from lumpedcable.scene.measures import ElevationMeasure
from lumpedcable.study.carried import missed_extremes, never_counted
from lumpedcable.study.report import results_table
from lumpedcable.study.run import run_study

WORDS = "the extreme of {} may lie between output times: lower output.every"
NAN = np.nan


def scene(least=False, limit=1.0):
    part = SimpleNamespace(LEAST=least, limit=limit)
    return SimpleNamespace(measures={"pull": part})


@pytest.mark.parametrize(
    ("history", "least", "told"),
    [
        ([4.0, 111.0, 70.0, 65.0], False, True),  # a snap seen on its way down
        ([4.0, 4.0, 111.0, 108.0], False, True),
        ([97.0, 99.0, 100.0, 99.0], False, False),
        ([100.0, 50.0, 20.0, 10.0], False, False),  # it starts there
        ([0.0, 50.0, 80.0, 100.0], False, False),  # it ends there
        ([5.0, 3.0, 5.0, 5.0], True, True),
        ([5.0, 4.9, 5.0, 5.0], True, False),
        ([NAN, 5.0, 5.0, 4.9], False, True),  # it counts from there on
        ([NAN, NAN, NAN, NAN], False, False),
    ],
)
def test_an_extreme_that_stands_out_is_told(history, least, told):
    table = {"pull": np.array([history])}
    assert missed_extremes(scene(least), table, 1) == [WORDS.format("pull") if told else ""]
    assert missed_extremes(scene(least, limit=None), table, 1) == [""]


def test_what_never_counted_is_told_where_it_has_a_limit():
    table = {"pull": np.array([[NAN, NAN], [NAN, 1.0]])}
    told = "pull never counted, so that nothing tells whether its limit is kept"
    assert never_counted(scene(), table, 2) == [told, ""]
    assert never_counted(scene(limit=None), table, 2) == ["", ""]


def test_what_has_a_sign_is_judged_by_its_range():
    gauge = ElevationMeasure(elevation=(0.0, 0.0), limit=1.0)
    # a sine that a hundred outputs a period resolve, all of it below 0 but for a tip
    sine = np.sin(np.arange(100) * 2 * np.pi / 100) - 0.9999
    one = SimpleNamespace(measures={"pull": gauge})
    assert sine.max() == pytest.approx(1e-4)
    assert abs(sine[24]) > 10 * sine.max()
    assert missed_extremes(one, {"pull": sine[None]}, 1) == [""]
    snap = np.where(np.arange(100) == 25, 0.5, sine)
    assert missed_extremes(one, {"pull": snap[None]}, 1) == [WORDS.format("pull")]


# an end is pulled to and fro 25 times a second
SHAKEN = """
[materials.hooke]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "hooke"
length = "10 m"
segments = 2
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { motion = { position = [10.1, 0, 0], amplitude = [0.05, 0, 0], period = "40 ms" } }
[measures.pull]
tension = "rope.start"
limit = "30 kN"
[solver]
step = "0.1 ms"
[output]
duration = "200 ms"
every = "13 ms"
keep = "summaries"
"""


@pytest.mark.parametrize(("every", "remarks"), [("10 ms", True), ("0.5 ms", False)])
def test_a_run_remarks_on_it_under_its_table(tmp_path, every, remarks):
    study = study_of(tmp_path, SHAKEN.replace("13 ms", every))
    outcomes = run_study(study, tmp_path / "r.h5")
    with redirect_stdout(StringIO()) as out:
        results_table(study, tmp_path / "r.h5", outcomes)
    assert outcomes[0].status.name == "OK"
    assert (f"run 0: {WORDS.format('pull')}" in out.getvalue()) is remarks
    assert outcomes[0].message == ("ok; " + WORDS.format("pull") if remarks else "ok")
    # and whoever asks for the file again, or ends a study, is told as well
    assert (WORDS.format("pull") in describe(tmp_path / "r.h5")) is remarks
