"""Runs that are checked together are told what each is told alone."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from lumpedcable.scene import load_study
from lumpedcable.scene.many import Apart, Many
from lumpedcable.scene.runs import ALONE, Axis, Factor, Runs

CONFIGS = Path(__file__).parents[2] / "configs"
SCENES = sorted(path for path in CONFIGS.glob("**/*.toml") if path.parent.name != "fit")
PRETENSION = "lines.rope.end.held.pretension"
FACTORS = (1.0, 0.0, -1.0, 1e-3, 0.5, 0.999, 1.001, 2.0, 1e3, 1e200)


def values_of(value: float) -> list[float]:
    """Values about one that is right, many of them wrong."""
    some = [value * k for k in FACTORS]
    more = [value + 0.01 * k for k in range(-3, 4)]
    return [*some, *more, *np.linspace(0.9, 1.1, 2 * ALONE) * value]


def runs_over(study, *keys) -> Runs:
    """The study's first scene with numbers of it swept together."""
    base = study.runs[0]
    axes = [Axis(key, tuple(values_of(base.numbers()[key])), "", key) for key in keys]
    rows = min(len(axis.values) for axis in axes)
    axes = [Axis(a.key, a.values[:rows], "", a.key) for a in axes]
    return over(study, *axes)


def over(study, *axes) -> Runs:
    return Runs(study.runs._data, [Factor(tuple(axes), "zip")], study.runs[0])


def alone(runs: Runs) -> dict[int, str]:
    found = {run: runs.problem(run) for run in range(len(runs))}
    return {run: words for run, words in found.items() if words is not None}


LONG = (
    "adjustment",
    "moored-barge",
    "restraint",
    "restraint-two-anchors",
    "transfer-sea",
    "unloading",
)  # several seconds each


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem in LONG else [])
        for path in SCENES
    ],
)
def test_runs_checked_together_are_told_the_same(path):
    study = load_study(path)
    # of the output nothing is swept
    keys = sorted(key for key in study.runs[0].numbers() if not key.startswith("output."))
    for some in [*([key] for key in keys), *pairwise(keys)]:
        runs = runs_over(study, *some)
        if runs._plain:
            assert runs.problems(np.arange(len(runs))) == alone(runs), some


def test_right_runs_are_checked_at_once(monkeypatch):
    study = load_study(CONFIGS / "snapback.toml")
    pulls = np.linspace(45e3, 450e3, 100)
    runs = over(study, Axis(PRETENSION, tuple(pulls), "N", "pull"))
    asked = []
    monkeypatch.setattr(Runs, "problem", lambda self, run: asked.append(run))
    assert runs.problems(np.arange(100)) == {}
    assert asked == []


def test_wrong_runs_are_found_among_right_ones():
    study = load_study(CONFIGS / "snapback.toml")
    bad = {7, 93}
    pulls = [1e9 if k in bad else 45e3 + k for k in range(100)]
    runs = over(study, Axis(PRETENSION, tuple(pulls), "N", "pull"))
    told = runs.problems(np.arange(100))
    assert set(told) == bad
    assert all(words == runs.problem(run) for run, words in told.items())
    assert runs.problems([7]).keys() == {7}


def test_what_is_the_same_of_all_is_told():
    x = Many(np.array([1.0, 2.0, 3.0]))
    assert x > 0
    assert not x > 3
    assert 0.5 < x <= 3.0
    assert (2 * x - 1 + x / 2 - (-x) - abs(-x)).values.tolist() == [1.5, 4.0, 6.5]
    assert min(x, 0.0) == 0.0
    assert max(5.0, x) == 5.0


def test_what_differs_parts_the_runs():
    x = Many(np.array([1.0, 2.0, 3.0]))
    with pytest.raises(Apart) as apart:
        assert x < 2.5
    assert apart.value.where.tolist() == [True, True, False]
    with pytest.raises(Apart):
        assert x - 1.0
    with pytest.raises(Apart):
        assert 1.0 / (x - 2.0)
    with pytest.raises(ZeroDivisionError):
        assert x / 0.0


@pytest.mark.parametrize(
    "use",
    [math.isfinite, math.sqrt, float, int, round, hash, np.sin, lambda x: x**2, lambda x: f"{x:g}",
     lambda x: np.ones(3) * x, lambda x: x * np.ones(3), lambda x: math.hypot(x, x)],
)  # fmt: skip
def test_what_it_cannot_do_it_does_not_do(use):
    with pytest.raises(TypeError):
        use(Many(np.array([1.0, 2.0])))
