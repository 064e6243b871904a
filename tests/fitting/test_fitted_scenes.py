"""The scenes that a fit leaves: with the values found, whatever the scene sweeps or a test has alone."""

from dataclasses import replace

import numpy as np
import pytest
from fit_files import BENCH, SCENE, fit_of, write_bench

from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.write import write_fit
from lumpedcable.scene import load_study

LAW = '[materials.nylon]\nlaw = "polynomial"\ncoefficients = [3e5, 1e5]\n\n'
LINE = LAW + SCENE[SCENE.index("[lines") :]
FREE = 'scene = "scene.toml"\n[free]\n"materials.nylon.coefficients" = { MORE }\n'
FIRST, SECOND = (f"materials.nylon.coefficients.{k}" for k in (0, 1))
OTHER = BENCH.replace("bench", "other")
E = np.linspace(0.01, 0.3, 12)


def fitted(folder, sweep="", more="", scene=LINE):
    """T = 400 kN e + 200 kN e^2 on one bench, T = 500 kN e + 100 kN e^2 on another."""
    write_bench(folder, E, 4e5 * E + 2e5 * E**2)
    write_bench(folder, E, 5e5 * E + 1e5 * E**2, "other.csv")
    text = FREE.replace("MORE", more) + BENCH + (OTHER if more else "")
    return fit_problem(fit_of(folder, text, scene + sweep).problem)


def written(found, folder):
    """The scenes that a fit leaves, by name."""
    made, wrong = write_fit(found, {}, folder)
    assert not wrong
    return {p.stem: load_study(p) for p in made if p.suffix == ".toml"}


SWEEPS = {
    "alone": f'[sweep]\n"{FIRST}" = [1e5, 2e5]\n"lines.rope.mass" = [2, 3]\n',
    "in cases": f'[[sweep.cases]]\n"{FIRST}" = 1e5\n"lines.rope.mass" = 2\n'
    f'[[sweep.cases]]\n"{SECOND}" = 1e5\n"lines.rope.mass" = 3\n',
    "zipped": f'[[sweep.zip]]\n"{FIRST}" = [1e5, 2e5]\n"lines.rope.mass" = [2, 3]\n',
    "drawn": f'[[sweep.sample]]\nmethod = "sobol"\ncount = 2\n"{FIRST}" = {{ from = 1e5, to = 2e5 }}\n'
    '"lines.rope.mass" = { from = 2, to = 3 }\n',
}


@pytest.mark.parametrize("sweep", SWEEPS.values(), ids=SWEEPS.keys())
def test_a_fitted_number_is_no_longer_swept(tmp_path, sweep):
    found = fitted(tmp_path, sweep)
    (study,) = written(found, tmp_path / "out").values()
    assert [axis.key for axis in study.axes] == ["lines.rope.mass"]
    assert len(study.runs) == 2
    for run in study.runs:
        numbers = run.numbers()
        assert [numbers[key] for key in (FIRST, SECOND)] == pytest.approx([4e5, 2e5], rel=1e-6)
    if "sample" not in sweep:
        assert [run.numbers()["lines.rope.mass"] for run in study.runs] == [2.0, 3.0]


def test_a_scene_whose_swept_numbers_are_all_fitted_is_one_run_without_references(tmp_path):
    sweep = f'[sweep]\n"{FIRST}" = [1e5, 2e5]\n[references.a]\nsource = "a book"\n'
    found = fitted(tmp_path, sweep + "values = { front_arrival = [0.1, 0.2] }\n")
    (study,) = written(found, tmp_path / "out").values()
    assert len(study.runs) == 1
    assert not study.references


def test_private_numbers_of_benches_have_a_scene_each(tmp_path):
    found = fitted(tmp_path, more="private = true")
    scenes = written(found, tmp_path / "out")
    # none that holds no value found
    assert set(scenes) == {"scene-bench-fitted", "scene-other-fitted"}
    for name, law in (("bench", [4e5, 2e5]), ("other", [5e5, 1e5])):
        numbers = scenes[f"scene-{name}-fitted"].scene.numbers()
        assert [numbers[key] for key in (FIRST, SECOND)] == pytest.approx(law, rel=1e-6)


def test_a_private_number_and_one_for_all(tmp_path):
    found = fitted(tmp_path, more="private = true")
    first, *rest = found.problem.parameters
    # the first coefficient is now everybody's
    shared = replace(found.problem, parameters=(replace(first, experiment=None), *rest))
    scenes = written(replace(found, problem=shared), tmp_path / "out")
    assert set(scenes) == {"scene-fitted", "scene-bench-fitted", "scene-other-fitted"}
    numbers = scenes["scene-fitted"].scene.numbers()
    assert [numbers[key] for key in (FIRST, SECOND)] == pytest.approx([4e5, 1e5], rel=1e-6)
