"""Fields that are kept more seldom than histories: some of those that there are otherwise."""

import base64
import csv
import gzip
import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from engine_runs import HOOKE, run_text, sliding_block, study_of
from PIL import Image

import lumpedcable
from lumpedcable.export import export_result
from lumpedcable.page.recorded import recorded
from lumpedcable.results import describe, open_result
from lumpedcable.results.sound import SoundFile
from lumpedcable.scene import SceneError
from lumpedcable.solve.keeping import field_slots, fields_done
from lumpedcable.study import batches, shrinking
from lumpedcable.study.shards import Share, open_study, run_here
from lumpedcable.view import animate_result
from lumpedcable.view.plot import figures_of

FIELDS = ("position", "velocity", "tension", "strain")
SWEPT = (
    HOOKE.replace("segments = 50", "segments = 10").replace('"100 ms"', '"38 ms"')
    + '[sweep]\n"lines.rope.end.held.pretension" = ["20 kN", "50 kN", "35 kN"]\n'
)
ALONE = SWEPT.partition("[sweep]")[0]
SELDOM = "output.fields_every=7 ms"  # at 0, 7, ..., 35 of 38 ms


def same(seldom, whole, after=7, rounding=0.0):
    """Fields are those of the other runs at some times, everything else is the same at all.

    To `rounding`, where another program was compiled for them: one run is not laid out as three are.
    """

    def equal(mine, other):
        scale = np.nanmax(np.abs(other), initial=0.0)
        np.testing.assert_allclose(mine, other, rtol=rounding, atol=rounding * scale)

    np.testing.assert_array_equal(seldom.time, whole.time)
    for name, line in whole.lines.items():
        for quantity, values in line.items():
            every = after if quantity in FIELDS else 1
            equal(seldom.lines[name][quantity], values[:, ::every])
    largest = max(np.max(np.abs(values)) for values in whole.energy.values())
    for term, values in whole.energy.items():
        assert np.max(np.abs(seldom.energy[term] - values)) <= rounding * largest
    for found, other in zip(seldom.outcomes, whole.outcomes, strict=True):
        assert (found.status, found.steps) == (other.status, other.steps)
        assert found.energy_closure == pytest.approx(other.energy_closure, rel=0.0, abs=rounding)
        mine, others = dict(found.recoils["rope.end"]), dict(other.recoils["rope.end"])
        assert mine.keys() == others.keys()
        equal(np.array([*mine.values()], float), np.array([*others.values()], float))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run_text(tmp_path_factory.mktemp("whole"), SWEPT)


def second_of(whole):
    """The second of the swept runs, which is `ALONE`, as if there were no other."""
    lines = {
        name: {quantity: values[1:2] for quantity, values in line.items()}
        for name, line in whole.lines.items()
    }
    energy = {term: values[1:2] for term, values in whole.energy.items()}
    return replace(whole, outcomes=whole.outcomes[1:2], lines=lines, energy=energy)


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The same runs with fields at every seventh output alone, and their file."""
    path = tmp_path_factory.mktemp("seldom")
    return run_text(path, SWEPT, SELDOM), path / "result.h5"


@pytest.fixture(scope="module")
def seldom(both):
    return both[1]


@pytest.mark.slow
def test_fields_of_a_batch_are_some_of_those_that_there_are(whole, both):
    found, _ = both
    assert found["tension"].shape == (3, 6, 10)
    same(found, whole)


@pytest.mark.parametrize(
    "after", [pytest.param(1, marks=pytest.mark.slow), 4, pytest.param(38, marks=pytest.mark.slow)]
)
def test_so_are_those_of_a_single_run_however_its_outputs_are_called_for(
    whole, tmp_path, monkeypatch, after
):
    monkeypatch.setattr(batches, "CPU", batches.CPU._replace(first=1))
    monkeypatch.setattr(batches, "OUTPUTS", (2, 3))
    found = run_text(tmp_path, ALONE, f"output.fields_every={after} ms")
    same(found, second_of(whole), after, rounding=1e-12)


def test_intervals_of_many_calls_make_no_difference(whole, tmp_path, monkeypatch):
    # 16 runs of 11 nodes: a call that may take a step at most
    monkeypatch.setattr(shrinking, "steps_at_once", lambda layout, runs: 1)
    same(run_text(tmp_path, SWEPT, SELDOM), whole)


@pytest.mark.parametrize("outputs", [1, 8, 13])
@pytest.mark.parametrize("after", [1, 2, 7, 50])
def test_there_is_room_for_every_field_of_a_call(outputs, after):
    # the fields of outputs first + 1, ..., first + outputs, and of the one on its way
    begun = [
        len({-(-k // after) for k in range(first + 1, first + outputs + 1)}) for first in range(100)
    ]
    assert max(begun) == field_slots(outputs, after)
    done = [
        sum(k % after == 0 for k in range(first + 1, first + outputs + 1)) for first in range(100)
    ]
    assert [fields_done(first, outputs, after) for first in range(100)] == done


@pytest.mark.slow
@pytest.mark.parametrize("keep_lanes", [True, False])
def test_a_run_that_has_stopped_keeps_its_last_fields(tmp_path, monkeypatch, keep_lanes):
    # v / (mu g) = 25 to 510 ms: three of them stop between two fields, and long before the others
    text = sliding_block(
        speed=1, step="2 ms", duration="600 ms", every="40 ms",
        more='stop = "block"\n[sweep]\n"bodies.block.velocity.0" = [0.1, 0.4, 0.6, 2]\n',
    )  # fmt: skip
    if not keep_lanes:
        monkeypatch.setattr(batches, "CPU", batches.CPU._replace(first=1))
    whole, sizes, shrink = run_text(tmp_path, text), [], shrinking.Batch.shrink
    monkeypatch.setattr(
        shrinking.Batch, "shrink", lambda b, s: (shrink(b, s), sizes.append(b.size))[0]
    )
    if not keep_lanes:
        monkeypatch.setattr(shrinking, "COMPILING", 0.0)
        monkeypatch.setattr(shrinking, "FEWEST", 2)  # one size less to compile
    found = run_text(tmp_path, text, "output.fields_every=120 ms")
    assert keep_lanes or sizes[-1] < sizes[0]
    stops = np.array([outcome.stop_time for outcome in whole.outcomes])
    np.testing.assert_allclose(stops, np.array([0.1, 0.4, 0.6, 2]) / 3.924, rtol=1e-4)
    assert [outcome.steps for outcome in whole.outcomes] == [
        13,
        51,
        77,
        255,
    ]  # of 2 ms, up to there
    for quantity in ("position", "tension"):
        np.testing.assert_allclose(found[quantity], whole[quantity][:, ::3], rtol=1e-12, atol=1e-9)
    with SoundFile.open(tmp_path / "result.h5") as result:
        # the first field that follows a stop is of the stop: 25, 102, 153 and 510 of 0, 120, ..., 600 ms
        assert [result.last_frame(run) for run in range(4)] == [1, 1, 2, 5]


def test_shards_are_one_file_with_both_times(whole, tmp_path):
    study = study_of(tmp_path, SWEPT, SELDOM)
    shards, laid = open_study(study, tmp_path / "study", 1)
    assert run_here(shards, laid, Share(), lambda done, total: None) == []
    with open_result(shards.path) as result:
        np.testing.assert_array_equal(result.frames, np.arange(0, 39, 7))
        np.testing.assert_array_equal(result.line("rope").tension(), whole["tension"][:, ::7])
        assert result.written.tolist() == [39] * 3
    line = lumpedcable.open(shards.path).line("rope")
    assert line.tension.dims == ("run", "field_time", "segment")
    assert line.start_tension.dims == ("run", "time")
    np.testing.assert_allclose(line.field_time, np.arange(0, 36, 7) * 1e-3, rtol=1e-12)
    assert line.tension.sel(run=1, field_time=0.014, method="nearest").shape == (10,)


def test_a_line_tells_when_its_fields_are(seldom):
    with open_result(seldom) as result:
        line = result.line("rope")
        np.testing.assert_allclose(line.time, np.arange(0, 36, 7) * 1e-3, rtol=1e-12)
        assert line.tension(0, -1).shape == (10,)
        assert line.field("end_tension", 0).shape == (39,)
    assert "every 1 ms, 39 saved; fields every 7 ms, 6 saved" in " ".join(describe(seldom).split())


def test_what_came_after_a_run_went_wrong_is_left_out_at_either_time(seldom, tmp_path):
    path = tmp_path / "wrong.h5"
    path.write_bytes(seldom.read_bytes())
    with h5py.File(path, "r+") as file:
        file["status"][1], file["status_time"][1] = 4, 0.020
    with SoundFile.open(path) as result:
        line = result.line("rope")
        assert np.isnan(line.tension(1)).all(axis=1).tolist() == [False] * 3 + [True] * 3
        assert np.isnan(result.series.read("lines/rope/tension", 1)[3:]).all()
        assert np.isfinite(line.tension(0)).all()
        assert np.isnan(line.field("end_tension", 1)).tolist() == [False] * 20 + [True] * 19
        assert result.last_frame(1) == 2


def test_figures_show_fields_at_their_own_times(seldom):
    drawn = figures_of(seldom)
    axes = drawn["tension"].axes[0]
    assert len(axes.collections[0].get_segments()) == 6
    assert "A curve every 7 ms" in " ".join(text.get_text() for text in drawn["tension"].texts)
    assert len(drawn["end_speed"].axes[0].lines[0].get_xdata()) == 39
    top = max(axes.get_ylim()[1] for axes in drawn["xt"].axes[:3])
    assert top == pytest.approx(35.0)  # ms


def test_the_page_draws_frames_where_there_are_fields_and_curves_everywhere(seldom, whole):
    page = recorded(seldom)
    block = gzip.decompress(base64.b64decode(page.pack.text()))
    assert page["frames"] == list(range(0, 36, 7))
    keys = [history["key"] for history in page["histories"]]
    assert {"lines/rope/end_tension", "lines/rope/length"} <= set(keys)
    (length,) = (h for h in page["histories"] if h["key"] == "lines/rope/length")
    step = np.linalg.norm(np.diff(whole["position"][0], axis=1), axis=-1).sum(axis=1)
    # exact where there is a field, straight between two of them
    straight = np.interp(np.arange(39), np.arange(0, 36, 7), step[::7])
    shown = np.frombuffer(block, "<f4", 39, length["data"]["start"])
    np.testing.assert_allclose(shown, straight, rtol=1e-6)


def test_exports_and_films_go_by_the_times_of_fields(seldom, tmp_path):
    export_result(seldom, "vtkhdf", tmp_path / "r.vtkhdf")
    with h5py.File(tmp_path / "r.vtkhdf") as file:
        np.testing.assert_allclose(file["VTKHDF/Steps/Values"], np.arange(0, 36, 7) * 1e-3)
        assert file["VTKHDF/Points"].shape == (6 * 11, 3)
    export_result(seldom, "moordyn", tmp_path / "r.out")
    ends, along = (np.loadtxt(tmp_path / n, skiprows=2) for n in ("r.out", "r_Line1.out"))
    assert (ends.shape[0], along.shape[0]) == (39, 6)
    np.testing.assert_allclose(along[:, 0], ends[::7, 0])
    export_result(seldom, "gltf", tmp_path / "r.glb")
    blob = (tmp_path / "r.glb").read_bytes()
    head = json.loads(blob[20 : 20 + int.from_bytes(blob[12:16], "little")])
    times = head["accessors"][head["animations"][0]["samplers"][0]["input"]]
    assert times["count"] == 6
    export_result(seldom, "csv", tmp_path / "r.csv", run=0)
    assert len(list(csv.reader((tmp_path / "r.csv").read_text().splitlines()))) == 40
    with Image.open(animate_result(seldom, tmp_path / "r.gif", seconds=0.4)) as film:
        assert film.n_frames == 6


@pytest.mark.parametrize(
    ("key", "told"),
    [
        (["1.5 ms"], "expected a whole number of times every, 1 ms: 1 ms or 2 ms, found 1.5 ms"),
        (["0.4 ms"], "expected a whole number of times every, 1 ms: 1 ms, found 400 us"),
        (["1 s"], "expected at most the duration, 38 ms, found 1 s"),
        (["0 s"], "expected a positive time"),
        (["5 ms", "output.keep=histories"], 'expected keep = "fields" with it, found 5 ms'),
    ],
)
def test_what_makes_no_sense_is_told(tmp_path, key, told):
    first, *more = key
    with pytest.raises(SceneError, match=r"output\.fields_every") as error:
        study_of(tmp_path, ALONE, f"output.fields_every={first}", *more)
    assert told in str(error.value)
