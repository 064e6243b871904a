"""Hamiltonian sampling against the exact distributions of a linear law; and without the extra."""

import json
from unittest import mock

import numpy as np
import pytest
from command_line import refused, say
from fit_files import BENCH, SCENE, fit_of, write_bench

from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.sample import with_sample
from lumpedcable.scene import SceneError

STRAIN = np.linspace(0.02, 0.3, 12)
LAW = 'law = "polynomial"\ncoefficients = [4e5, 1e5]\n'
LINEAR = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{LAW}\n")
TEXT = 'scene = "scene.toml"\n[free]\n"materials.nylon.coefficients" = {}\n' + BENCH
SAMPLE = "\n[sample]\ndraws = 1000\nwarmup = 300\n"


def written(folder, more):
    random = np.random.default_rng(11)
    write_bench(folder, STRAIN, 5e5 * STRAIN + 1e6 * STRAIN**2 + 4e3 * random.standard_normal(12))
    return fit_of(folder, TEXT + more + SAMPLE, LINEAR)


@pytest.mark.slow
def test_draws_without_a_given_noise_are_students(tmp_path):
    # Student's t of n - p = 10, whose variance is 10/8 of the linear one (Gelman et al. 2013, 14.2)
    pytest.importorskip("numpyro")
    study = written(tmp_path, "")
    fitted = with_sample(fit_problem(study.problem), study.sampling)
    draws, certainty = fitted.draws, fitted.certainty
    flat, std = draws.values.reshape(-1, 2), certainty.std * np.sqrt(10 / 8)
    assert np.all(draws.r_hat < 1.02)
    assert abs(flat.mean(axis=0) - fitted.values) == pytest.approx(0, abs=4 * max(std) / 20)
    assert flat.std(axis=0) == pytest.approx(std, rel=4 / np.sqrt(draws.size.min()))
    again = with_sample(fit_problem(study.problem), study.sampling)
    assert np.array_equal(again.draws.values, draws.values)


@pytest.mark.slow
def test_draws_have_the_moments_of_linear_regression(tmp_path):
    # the noise given, they are normal with s^2 (X'X)^-1
    pytest.importorskip("numpyro")
    (series,) = written(tmp_path, 'noise = "4 kN"\n').problem.series
    said = say(tmp_path, "fit", "fit.toml", "-o", "out")
    assert said.code == 0, said.err
    assert "sampler" not in said.out
    assert "chains do not agree" not in said.out
    matrix = np.stack([series.x, series.x**2], axis=1)
    best = np.linalg.lstsq(matrix, series.values)[0]
    covariance = 4e3**2 * np.linalg.inv(matrix.T @ matrix)
    std = np.sqrt(np.diag(covariance))
    rows = (tmp_path / "out" / "draws.csv").read_text().splitlines()
    assert rows[0].startswith("chain,materials.nylon.coefficients.0 (N)")
    drawn = np.array([[float(x) for x in row.split(",")[1:]] for row in rows[1:]])
    assert drawn.shape == (4 * 1000, 2)
    told = json.loads((tmp_path / "out" / "fit.json").read_text())["sample"]
    size = min(told["effective_size"])
    assert max(told["r_hat"]) < 1.02
    assert size > 400
    # four standard errors
    assert abs(drawn.mean(axis=0) - best) / std == pytest.approx([0, 0], abs=4 / np.sqrt(size))
    assert drawn.std(axis=0) == pytest.approx(std, rel=4 / np.sqrt(size))
    correlation = covariance[0, 1] / std[0] / std[1]
    assert np.corrcoef(drawn.T)[0, 1] == pytest.approx(correlation, abs=0.02)
    assert told["mean"] == pytest.approx(drawn.mean(axis=0), rel=1e-9)
    assert (tmp_path / "out" / "sample.png").exists()


def test_without_the_extra_it_is_told_before_anything_is_computed(tmp_path):
    written(tmp_path, "")
    with mock.patch("importlib.util.find_spec", return_value=None):
        told = refused(tmp_path, "fit", "fit.toml")
    assert 'pip install "lumpedcable[sample]"' in told


def test_values_that_are_no_more_than_the_numbers_have_no_distribution(tmp_path):
    """S^(-n/2) cannot be integrated where a law meets n values exactly."""
    write_bench(tmp_path, STRAIN[:2], 5e5 * STRAIN[:2])
    fit_of(tmp_path, TEXT + 'noise = "4 kN"\n' + SAMPLE, LINEAR)
    with pytest.raises(SceneError) as caught:
        fit_of(tmp_path, TEXT + SAMPLE, LINEAR)
    (fault,) = caught.value.faults
    assert (fault.line, fault.key) == (11, "sample")
    assert "expected more values than numbers, found 2 values of unknown noise" in str(fault)
    write_bench(tmp_path, STRAIN[:3], 5e5 * STRAIN[:3])
    assert fit_of(tmp_path, TEXT + SAMPLE, LINEAR).sampling is not None
