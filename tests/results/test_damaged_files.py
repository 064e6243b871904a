"""Files that were results files once: what is wrong is told, and nothing stays open."""

import random

import h5py
import numpy as np
import pytest
import synthetic_result

from lumpedcable.export import export_result
from lumpedcable.results import ResultError, describe, open_result
from lumpedcable.results.sound import SoundFile


def scalar_runs(file):
    del file["run"]
    file["run"] = 3


def other_dimensions(file):
    file.attrs["dimensions"] = '{"run": 3'


def words_for_times(file):
    del file["time"]
    file["time"] = "soon"


def no_version(file):
    del file.attrs["schema_version"]


DAMAGES = {
    scalar_runs: r"expected run of shape \(run,\), found \(\)",
    other_dimensions: "its attribute dimensions is no JSON",
    words_for_times: "is damaged or lacks a part",
    no_version: "HDF5 but not a results file",
}


@pytest.fixture
def path(tmp_path):
    return synthetic_result.snapback(tmp_path / "r.h5", pretensions=(45e3,), segments=4)


@pytest.fixture
def files(monkeypatch):
    """Every HDF5 file that was opened."""
    found, real = [], h5py.File

    def opening(*arguments, **more):
        found.append(real(*arguments, **more))
        return found[-1]

    monkeypatch.setattr(h5py, "File", opening)
    return found


@pytest.mark.parametrize("look", [open_result, SoundFile.open, describe])
@pytest.mark.parametrize(
    ("damage", "words"), DAMAGES.items(), ids=lambda one: one.__name__ if callable(one) else ""
)
def test_a_damaged_file_is_told_and_let_go(path, files, damage, words, look):
    with h5py.File(path, "r+") as file:
        damage(file)
    with pytest.raises(ResultError, match=words) as error:
        look(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
    assert len(files) == 2
    assert not any(files)  # an open one is true


def test_what_cannot_be_made_of_a_file_leaves_it_closed(path, files, monkeypatch):
    def failing(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("lumpedcable.results.sound._SoundSeries", failing)
    with pytest.raises(KeyboardInterrupt):
        SoundFile.open(path)
    assert len(files) == 1
    assert not any(files)


def overwritten(path, whole, at, seed=7):
    path.write_bytes(whole[:at] + random.Random(seed).randbytes(64) + whole[at + 64 :])
    return path


def test_bytes_that_something_overwrote_are_told_wherever_they_are_met(tmp_path, path):
    path = synthetic_result.snapback(
        path, pretensions=(45e3,), segments=4, times=np.linspace(0.0, 0.02, 11)
    )
    whole, told = path.read_bytes(), {}
    places = random.Random(11).sample(range(len(whole) - 64), 60)
    for at in places:
        for look in (describe, lambda file: export_result(file, "csv", tmp_path / "r.csv")):
            try:
                look(overwritten(path, whole, at))
            except ResultError as error:
                told[at] = str(error)
    # of numbers alone nobody can tell that they are others
    assert all(str(path) in line and "\n" not in line for line in told.values())
    assert 5 < len(told) < len(places)


def test_what_the_reader_of_a_file_does_wrong_is_no_damage(path):
    with pytest.raises(ValueError, match="mine"), open_result(path):
        raise ValueError("mine")
