"""Studies in folders: shards finished or absent, resumed, seen as one file."""

import json
import os
import shutil
import signal
import time

import good_scenes
import jax
import numpy as np
import pytest
import xarray
from command_line import process, say
from file_contents import assert_equal_bits, contents

import lumpedcable
from lumpedcable.commands.console import share_cores
from lumpedcable.results import StudyFolder, open_result
from lumpedcable.scene import load_study, run_checks
from lumpedcable.study import contents as contents_of_files
from lumpedcable.study import shards
from lumpedcable.study.run import run_study
from lumpedcable.study.shards import Share, open_study, run_here

PRETENSION, DRAG = "lines.rope.end.held.pretension", "lines.rope.drag.tangential"
# 12 short runs of one structure
SMALL = good_scenes.short_runs(
    "4 ms", f'["45 kN", "90 kN", "180 kN"]\n"{DRAG}" = [0, 0.01, 0.02, 0.03]'
)
KEPT = 'every = "1 ms"\nkeep = "histories"'


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return good_scenes.write(
        tmp_path_factory.mktemp("scene"), SMALL.replace('every = "1 ms"', KEPT)
    )


@pytest.fixture(scope="module")
def whole(scene, tmp_path_factory):
    """All runs computed at one go, shards of five."""
    path = tmp_path_factory.mktemp("study") / "whole"
    folder, laid = open_study(load_study(scene), path, 5)
    seen = []
    assert run_here(folder, laid, Share(), lambda done, total: seen.append((done, total))) == []
    assert seen[0] == (0, 48)
    assert seen[-1] == (48, 48)
    return folder


def test_shards_hold_what_one_file_holds(scene, whole, tmp_path):
    run_study(load_study(scene), tmp_path / "all.h5")
    with open_result(tmp_path / "all.h5") as file, open_result(whole.path) as view:
        assert view.complete
        assert view.status == file.status == ["ok"] * 12
        one, other = file.summary(), view.summary()
        for end, numbers in other.items():
            for name, values in numbers.items():
                # lanes of batches of other sizes may round otherwise
                scale = np.max(np.nan_to_num(np.abs(one[end][name])))
                atol = 1e-9 * scale if name != "static_imbalance" else 1e-9
                atol = 1e-9 if name == "energy_closure" else atol
                np.testing.assert_allclose(values, one[end][name], rtol=1e-9, atol=atol)
        assert [axis.key for axis in view.axes] == [PRETENSION, DRAG]
        for mine, theirs in zip(view.axes, file.axes, strict=True):
            assert list(mine.values) == list(theirs.values)
        assert view.written.tolist() == [5] * 12


def test_the_numbers_of_a_run_are_those_of_its_histories(whole):
    with open_result(whole.path) as view:
        run = view.summary()["run"]
        kinetic = view.energy("kinetic").max(axis=1)
        ends = [view.line("rope").field(f"{side}_tension") for side in ("start", "end")]
        np.testing.assert_allclose(run["peak_kinetic_energy"], kinetic, rtol=1e-12)
        # the tension of the segments is at most what their ends are extrapolated to
        assert np.all(run["peak_tension"] >= 0.99 * np.max(ends, axis=(0, 2)))
        end = view.summary()["rope.end"]
        # the end still flies away at the last time: it has never been farther
        np.testing.assert_allclose(end["reach"], end["end_displacement"], rtol=1e-12)


def test_the_view_opens_in_xarray_with_names_and_units(whole):
    with xarray.open_dataset(whole.view, engine="h5netcdf") as root:
        assert root.sizes["run"] == 12
        assert root["held_pretension"].attrs["units"] == "N"
        assert root["status"].values.tolist() == [0] * 12
    with xarray.open_dataset(whole.view, engine="h5netcdf", group="summary/rope.end") as end:
        assert end["peak_end_speed"].attrs["units"] == "m/s"
        assert np.all(end["peak_end_speed"] > 0.0)


def test_a_saved_study_has_its_runs_in_it(whole, tmp_path):
    result = lumpedcable.open(whole.path)
    speeds = result.summary("rope.end").peak_end_speed.values
    assert result.energy.sizes["run"] == result.dataset.sizes["run"] == 12
    found = contents(whole.view)
    result.save(tmp_path / "elsewhere" / "all.h5")
    saved = lumpedcable.open(tmp_path / "elsewhere" / "all.h5")
    assert saved.status == ["ok"] * 12
    assert saved.summary("rope.end").peak_end_speed.values.tolist() == speeds.tolist()
    assert saved.line("rope").end_tension.sizes == {"run": 12, "time": 5}
    assert_equal_bits(contents(saved.path), found)


def test_what_is_made_of_a_folder_has_its_whole_name(whole, tmp_path, monkeypatch):
    for name in ("map.1", "map.2"):
        shutil.copytree(whole.path, tmp_path / name)

    def drawn(path, folder, formats, run):
        return [folder / "a.png"]  # where pictures go, not what they show

    monkeypatch.setattr("lumpedcable.view.plot_result", drawn)
    assert say(tmp_path, "plot", "map.1").out == "map.1/a.png\n"
    # a study without positions has no film; what is asked for by "." is called like the folder
    monkeypatch.setattr("lumpedcable.view.animate_result", lambda result, target, *_: target)
    assert say(tmp_path, "animate", "map.2").out == "map.2.gif\n"
    assert say(tmp_path / "map.2", "animate", ".").out == "map.2.gif\n"


def test_a_shard_that_is_damaged_is_named(whole, tmp_path):
    shutil.copytree(whole.path, tmp_path / "s")
    folder = StudyFolder.open(tmp_path / "s")
    with folder.file(1).open("r+b") as file:
        file.truncate(3000)
    told = say(tmp_path, "info", "s")
    assert told.code == 2
    assert f"{folder.name(1)} is damaged; once it is deleted" in told.err


def test_all_shards_that_are_damaged_are_named_at_once(whole, tmp_path):
    shutil.copytree(whole.path, tmp_path / "s")
    folder = StudyFolder.open(tmp_path / "s")
    with folder.file(0).open("r+b") as file:
        file.truncate(0)
    with folder.file(1).open("r+b") as file:
        file.truncate(3000)
    told = say(tmp_path, "info", "s")
    assert told.code == 2
    both = f"{folder.name(0)}, s/{folder.name(1)} are damaged; once they are deleted"
    assert both in told.err.replace("\n", " ").replace("  ", " ")


def test_a_file_that_shows_shards_is_not_complete_without_them(whole, tmp_path):
    shutil.copytree(whole.path, tmp_path / "s")
    folder = StudyFolder.open(tmp_path / "s")
    assert "state     complete" in say(tmp_path, "info", "s/study.h5").out
    folder.file(1).unlink()
    told = say(tmp_path, "info", "s/study.h5")
    assert told.code == 0
    assert "incomplete: 7 of 12 runs" in told.out
    # and alone it shows nothing
    (tmp_path / "alone").mkdir()
    shutil.copy(folder.view, tmp_path / "alone")
    for command in (["info"], ["plot"], ["export", "--to", "csv"]):
        told = say(tmp_path / "alone", command[0], "study.h5", *command[1:])
        assert told.code == 2
        assert "of which none is there: move the whole folder of a study" in told.err.replace(
            "\n", " "
        )


def test_what_is_there_is_kept_and_what_is_not_is_computed(scene, whole, tmp_path):
    folder, laid = open_study(load_study(scene), tmp_path / "s", 5)
    assert folder.missing() == [0, 1, 2]
    run_here(folder, laid, Share(1, 3), lambda done, total: None)
    assert folder.missing() == [0, 2]
    with open_result(folder.path) as view:
        assert not view.complete
        assert view.status == ["interrupted"] * 5 + ["ok"] * 5 + ["interrupted"] * 2
        assert (
            np.isnan(view.summary()["rope.end"]["reach"]).tolist()
            == [True] * 5 + [False] * 5 + [True] * 2
        )
    stamp = folder.file(1).stat().st_mtime_ns
    run_here(folder, laid, Share(), lambda done, total: None)
    assert folder.missing() == []
    assert folder.file(1).stat().st_mtime_ns == stamp
    for shard in range(3):
        assert_equal_bits(contents(folder.file(shard)), contents(whole.file(shard)))


@pytest.mark.parametrize(("shard", "drag"), [(5, "0.5"), (4, "0.0")])
def test_a_study_is_never_told_by_the_shards_of_another(whole, tmp_path, monkeypatch, shard, drag):
    # a reference to a file that is absent is looked for in the folder that the process is in, too
    other = SMALL.replace('every = "1 ms"', KEPT).replace("normal = 1.5", f"normal = {drag}")
    assert other.count(f"normal = {drag}") == 1
    begun, _ = open_study(load_study(good_scenes.write(tmp_path, other)), tmp_path / "begun", shard)
    monkeypatch.chdir(whole.path)
    with open_result(begun.path) as view:
        assert view.status == ["interrupted"] * 12
        assert np.isnan(view.summary()["rope.end"]["reach"]).all()


def test_a_folder_that_says_nothing_of_names_has_shards_of_numbers_alone(whole, tmp_path):
    told = json.loads((whole.path / "study.json").read_text())
    del told["names"]
    (tmp_path / "shards").mkdir()
    (tmp_path / "study.json").write_text(json.dumps(told))
    shutil.copy(whole.scene, tmp_path)
    for name in ("000001.h5", "000002.h5.partial", f"{whole.manifest.names}000000.h5"):
        (tmp_path / "shards" / name).touch()
    folder = StudyFolder.open(tmp_path)
    assert (folder.missing(), folder.begun()) == ([0, 2], [2])
    folder.note_failure(2, "no memory")
    assert folder.failures() == {2: "no memory"}


@pytest.mark.parametrize("at_once", [pytest.param(2, marks=pytest.mark.slow), 3])
def test_shards_under_way_at_once_have_the_same_bits(scene, whole, tmp_path, monkeypatch, at_once):
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)
    under_way, most = set(), []
    real = shards.run_runs

    def watched(laid, runs, *others, **more):
        under_way.add(runs[0])
        most.append(len(under_way))
        found = real(laid, runs, *others, **more)
        under_way.discard(runs[0])
        return found

    monkeypatch.setattr(shards, "run_runs", watched)
    folder, laid = open_study(load_study(scene), tmp_path / "s", 2)
    seen = []
    assert run_here(folder, laid, Share(), lambda done, total: seen.append((done, total))) == []
    assert 1 < max(most) <= at_once
    assert seen[0] == (0, 48)
    assert seen[-1] == (48, 48)
    assert sorted(seen) == seen
    small, all_ = contents(folder.view), contents(whole.view)
    for name in ("status", "summary/rope.end/peak_end_speed", "summary/rope.end/reach"):
        np.testing.assert_allclose(small[name], all_[name], rtol=1e-9)
    monkeypatch.setattr(shards, "_at_once", lambda: 1)
    alone, laid = open_study(load_study(scene), tmp_path / "alone", 2)
    run_here(alone, laid, Share(), lambda done, total: None)
    for shard in range(6):
        assert_equal_bits(contents(folder.file(shard)), contents(alone.file(shard)))


@pytest.mark.parametrize("at_once", [1, 2])
def test_an_interruption_stops_all_that_is_under_way(scene, tmp_path, monkeypatch, at_once):
    monkeypatch.setattr(shards, "_at_once", lambda: at_once)
    folder, laid = open_study(load_study(scene), tmp_path / "s", 2)
    seen = []

    def interrupt(done, total):
        seen.append(done)
        if done >= 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_here(folder, laid, Share(), interrupt)
    # told once, and nobody goes on: of six shards two or three at most can have been finished
    assert sum(done >= 16 for done in seen) == 1
    assert 3 <= len(folder.missing()) < 6
    assert run_here(folder, laid, Share(), lambda done, total: None) == []
    assert folder.missing() == []


def test_another_study_is_not_mixed_in(scene, whole):
    where = whole.path
    other = say(where.parent, "study", scene, "-o", where, "--set", "gravity=1.62")
    assert other.code == 2
    assert "it holds another study" in other.err
    sized = say(where.parent, "study", scene, "-o", where, "--shard", "6")
    assert sized.code == 2
    assert "its shards have 5 runs, found --shard 6" in sized.err
    again = say(where.parent, "study", scene, "-o", where)
    assert again.code == 0
    assert "complete: 3 of 3 shards, 12 of 12 runs" in again.out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--part", "3/2"], "--part: expected K/M with K from 1 to M, found 3/2"),
        (["--part", "x"], "--part: expected K/M"),
        (["--shard", "0"], "--shard: expected at least 1, found 0"),
        (["--cores", "0"], "--cores: expected at least 1"),
        (["--cores", "2", "--executor", "dask"], "found --executor dask, whose workers have one"),
        (["--scheduler", "tcp://a:1"], "--scheduler: expected --executor dask beside it"),
    ],
)
def test_wrong_arguments_are_told_and_nothing_is_made(scene, tmp_path, arguments, words):
    said = say(tmp_path, "study", scene, "-o", "s", *arguments)
    assert said.code == 2
    assert words in said.err
    assert list(tmp_path.iterdir()) == []


def test_a_full_folder_is_left_alone(scene, tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "mine.txt").write_text("mine")
    said = say(tmp_path, "study", scene, "-o", "s")
    assert said.code == 2
    assert "expected a new or empty folder" in said.err
    assert [p.name for p in (tmp_path / "s").iterdir()] == ["mine.txt"]


@pytest.mark.slow
def test_a_study_goes_on_after_kill_9(scene, whole, tmp_path, monkeypatch):
    # as many devices as this process has: lanes of batches of other sizes may round otherwise
    name = "--xla_force_host_platform_device_count"
    monkeypatch.setenv("XLA_FLAGS", f"{os.environ['XLA_FLAGS']} {name}={jax.device_count()}")
    shards, deadline = tmp_path / "s" / "shards", time.monotonic() + 300
    with process(tmp_path, "study", scene, "-o", "s", "--shard", "5") as child:
        while not list(shards.glob("*-000000.h5")):
            assert child.poll() is None, child.stderr.read()
            assert time.monotonic() < deadline
            time.sleep(0.002)
        child.kill()
        _, err = child.communicate(timeout=60)
    # somebody who slept through the two other shards has found the study at its end
    assert child.returncode in (-signal.SIGKILL, 0), err
    folder = StudyFolder.open(tmp_path / "s")
    assert 0 not in folder.missing()
    assert say(tmp_path, "info", "s").code == 0
    folder, laid = open_study(load_study(scene), tmp_path / "s")
    run_here(folder, laid, Share(), lambda done, total: None)
    assert folder.missing() == folder.begun() == []
    for shard in range(3):
        assert_equal_bits(contents(folder.file(shard)), contents(whole.file(shard)))


def test_a_run_that_cannot_be_is_marked_and_the_others_are_run(tmp_path, monkeypatch):
    # of many runs the edges alone are checked when a file is read; the tension of the middle one is
    # beyond what its law reaches at a fifth of strain, 195 kN
    monkeypatch.setattr(run_checks, "CHECKED", 1)
    monkeypatch.setattr(contents_of_files, "CHECKED", 1)
    text = SMALL.replace('["45 kN", "90 kN", "180 kN"]', '["45 kN", "400 kN", "46 kN"]').replace(
        f'"{DRAG}" = [0, 0.01, 0.02, 0.03]', '"materials.nylon.max_strain" = [0.5, 0.2, 0.49]'
    )
    text = text.replace('every = "1 ms"', 'every = "1 ms"\nkeep = "summaries"')
    laid = shards.lay_out(load_study(good_scenes.write(tmp_path, text)))
    path = tmp_path / "x.h5"
    ((runs, table),) = shards.run_runs(laid, np.arange(3, 6), path, exact=False)
    assert runs.tolist() == [3, 4, 5]
    assert table["status"].tolist() == [0, 8, 0]
    assert "pretension: expected at most" in table["status_message"][1]
    with open_result(path) as result:
        assert result.status == ["ok", "scene_impossible", "ok"]
        # nothing is kept but numbers
        assert result.line("rope").fields == result.energy_terms == []
        end = result.summary()["rope.end"]
        assert np.isfinite(end["peak_end_speed"]).tolist() == [True, False, True]


def test_cores_are_devices_unless_the_user_has_said_how_many(monkeypatch):
    name = "--xla_force_host_platform_device_count"
    monkeypatch.setenv("XLA_FLAGS", "--xla_dump_to=there")
    share_cores(3)
    assert os.environ["XLA_FLAGS"] == f"--xla_dump_to=there {name}=3"
    share_cores(2)
    assert os.environ["XLA_FLAGS"] == f"--xla_dump_to=there {name}=3"
    monkeypatch.setenv("XLA_FLAGS", "")
    share_cores(None)
    assert int(os.environ["XLA_FLAGS"].removeprefix(f"{name}=")) >= 1


def test_a_part_of_a_study_is_done_when_its_own_shards_are(scene, tmp_path):
    """Tasks of an array job that end before the others have not failed."""
    words = ("study", scene, "-o", "parts", "--shard", "5", "--cores", "1", "--part")
    codes = [say(tmp_path, *words, part).code for part in ("1/2", "2/2")]
    assert codes == [0, 0]
    assert say(tmp_path, "info", "parts").code == 0
    assert say(tmp_path, "study", scene, "-o", "parts", "--workers", "3").err == (
        "--workers: expected --executor dask beside it, found none\n"
    )
