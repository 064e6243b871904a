"""What many runs have in common is read once, however many they are."""

from collections import Counter

import h5py
import numpy as np
import pytest
import synthetic_result

import lumpedcable as lc
from lumpedcable.page.recorded import recorded
from lumpedcable.results import (
    Coordinate,
    ResultWriter,
    Variable,
    describe,
    open_result,
    sweep_coordinates,
)
from lumpedcable.view.groups import groups
from lumpedcable.view.measures import bars_figure

FEW, MANY = 3, 9  # runs


@pytest.fixture
def reads(monkeypatch):
    """How often each dataset has been read, by its name."""
    counts, real = Counter(), h5py.Dataset.__getitem__

    def counted(dataset, *arguments, **more):
        counts[dataset.name] += 1
        return real(dataset, *arguments, **more)

    monkeypatch.setattr(h5py.Dataset, "__getitem__", counted)
    return counts


def written(path, runs):
    """A file of so many runs at 5 times, all of which failed."""
    return synthetic_result.snapback(
        path, pretensions=45e3 + 1e3 * np.arange(runs), break_times=(5e-3,), segments=4,
        times=np.linspace(0.0, 0.02, 5), failed=tuple(range(runs)),
    )  # fmt: skip


def bars(path):
    with open_result(path) as result:
        bars_figure(result, "energy_closure").clear()


def grouped(path):
    with open_result(path) as result:
        assert len(groups(result)[0].titles) == result.runs


LOOKS = {
    "open": lambda path: lc.open(path).labels,
    "describe": describe,
    "page": recorded,
    "bars": bars,
    "groups": grouped,
}


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_numbers_of_all_runs_are_read_as_often_for_many_as_for_few(tmp_path, reads, look):
    found = []
    for runs in (FEW, MANY):
        path = written(tmp_path / f"{runs}.h5", runs)
        reads.clear()
        look(path)
        with h5py.File(path) as file:
            found.append({f"/{name}": reads[f"/{name}"] for name in file if name in NUMBERS})
    assert len(found[0]) == len(NUMBERS)
    assert found[0] == found[1]


NUMBERS = ("held_pretension", "break_time", "status", "status_time", "status_message", "written")


def test_an_opened_result_has_read_no_label_that_nobody_asked_for(tmp_path, reads):
    path = written(tmp_path / "r.h5", FEW)
    reads.clear()
    result = lc.open(path)
    assert result.status == ["diverged"] * FEW
    assert reads["/held_pretension"] == 0
    first = result.labels
    assert first == [f"pretension {p} kN, break time 5 ms" for p in (45, 46, 47)]
    assert result.labels == first
    assert reads["/held_pretension"] == 1


def test_names_of_cases_are_read_once(tmp_path, reads):
    # two numbers that go with the case, and one that differs within it
    cases = [name for name in ("calm", "storm") for _ in range(3)]
    numbers = {"a": [1, 1, 1, 2, 2, 2], "b": [5] * 6, "c": [1, 2, 3, 1, 2, 3]}
    axes = [(f"bodies.{k}.mass", "kg", np.array(v, float)) for k, v in numbers.items()]
    with ResultWriter(
        tmp_path / "r.h5",
        dims={"run": 6, "time": 1},
        variables=[Variable("energy/kinetic", ("run", "time"), "f8", "J")],
        coordinates={**sweep_coordinates(axes), "case": Coordinate(cases, dims=("run",))},
    ):
        pass
    reads.clear()
    with open_result(tmp_path / "r.h5") as result:
        labels = [result.label(run) for run in range(result.runs)]
        assert [axis.key for axis in result.axes_apart] == ["bodies.c.mass"]
    assert labels[4] == "storm, c mass 2 kg"
    assert reads["/case"] == 1
