"""Starts whose linear numbers are solved for, and data that are far from the law at the start."""

import numpy as np
import pytest
from fit_files import BENCH, NAMES, SCENE, TRUTH, bench_of, fit_of, free, write_bench
from nylon_line import tension

from lumpedcable.fitting.linear import linear_start, start_faults
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import print_ropes
from lumpedcable.fitting.run import fit_problem

KNOWN = 'noise = "1 %"\n'
STRAIN = np.linspace(0.005, 0.32, 64)


def noisy(strain):
    """Tensions (N) at the size of strains, with noise of 1 % of the largest."""
    load = tension(np.abs(strain))
    return load + 0.01 * load.max() * np.random.default_rng(2).standard_normal(load.size)


def bench(folder, strain, load, more=KNOWN):
    write_bench(folder, strain, load)
    return fit_of(folder, 'scene = "scene.toml"\n' + free(1.4 * TRUTH) + BENCH + more).problem


def law_of(folder, law, free_text, strain, load, more=""):
    """The problem of a bench's table with another law."""
    write_bench(folder, strain, load)
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    return fit_of(
        folder, f'scene = "scene.toml"\n[free]\n{free_text}\n' + BENCH + more, scene
    ).problem


def start_of(problem):
    return np.array([p.start for p in problem.parameters])


def test_the_coefficients_of_a_polynomial_are_those_of_linear_regression(tmp_path):
    load = 5e5 * STRAIN + 8e6 * STRAIN**3 + 2e3 * np.sin(50 * STRAIN)
    law = 'law = "polynomial"\ncoefficients = [4e5, 1e5, 1e6]'
    problem = law_of(tmp_path, law, '"materials.nylon.coefficients" = {}', STRAIN, load)
    matrix = np.stack([STRAIN, STRAIN**2, STRAIN**3], axis=1)
    best = np.linalg.lstsq(matrix, load)[0]
    assert linear_start(problem, [start_of(problem)]) == pytest.approx(best, rel=1e-9)


def test_linear_numbers_stay_within_their_bounds(tmp_path):
    law, bounds = 'law = "linear"\nEA = "1 MN"', '"materials.nylon.EA" = { high = "2 MN" }'
    problem = law_of(tmp_path, law, bounds, STRAIN, 5e6 * STRAIN)
    # a thousandth of the way from the bound to the start
    assert linear_start(problem, [start_of(problem)]) == pytest.approx([1.999e6], rel=1e-12)
    falling = law_of(tmp_path, law, bounds, STRAIN, -5e6 * STRAIN)
    assert linear_start(falling, [start_of(falling)]) == pytest.approx([1e3], rel=1e-12)


def test_without_a_linear_number_there_is_no_such_start(tmp_path):
    text = 'scene = "scene.toml"\n' + free(TRUTH[1:3], NAMES[1:3]) + BENCH
    write_bench(tmp_path, STRAIN, tension(STRAIN))
    problem = fit_of(tmp_path, text).problem
    assert linear_start(problem, [start_of(problem)]) is None


def test_loads_a_thousand_times_too_large_end_at_the_law_a_thousand_times_as_large(
    tmp_path, capsys
):
    fitted = fit_problem(bench(tmp_path, STRAIN, noisy(STRAIN)))
    large = fit_problem(bench(tmp_path, STRAIN, 1e3 * noisy(STRAIN)))
    assert large.converged
    # the noise is a share of the largest load, so that the deviations are the same
    assert large.loss == pytest.approx(fitted.loss, rel=1e-6)
    assert large.values[:4] == pytest.approx(fitted.values[:4] * [1e3, 1.0, 1.0, 1e3], rel=1e-3)
    said = " ".join(remarks_of(large))
    assert "bench: tension: the data are about " in said
    assert "times what the law gives at the start: check the units of the columns." in said
    print_ropes({"one": fitted}, "ropes")
    assert "doubt" not in capsys.readouterr().out
    print_ropes({"one": large}, "ropes")
    assert "in doubt" in " ".join(capsys.readouterr().out.split())


def test_strains_of_the_other_sign_end_at_the_law_turned_round(tmp_path):
    fitted = fit_problem(bench(tmp_path, STRAIN, noisy(STRAIN)))
    turned = fit_problem(bench(tmp_path, -STRAIN, noisy(STRAIN)))
    assert turned.converged
    assert turned.loss == pytest.approx(fitted.loss, rel=1e-6)
    # T(-e) = -p1 tanh(p2 e - p3) + p4 - p5 e
    assert turned.values[:4] == pytest.approx(fitted.values[:4] * [-1, 1, -1, 1], rel=1e-3)
    assert "the data fall where the law at the start rises" in " ".join(remarks_of(turned))


@pytest.mark.parametrize("factor", [0.5, 1.0, 1.5])
def test_no_unit_is_in_doubt_where_the_start_is_near(tmp_path, factor):
    assert start_faults(bench_of(tmp_path, factor * TRUTH).problem) == []


def test_a_single_strain_says_nothing_of_units(tmp_path):
    strain = np.full(10, 0.05)
    assert start_faults(bench(tmp_path, strain, np.linspace(9e4, 1.1e5, 10))) == []


RECORD = """
[experiments.test]
file = "test.csv"
time = { column = "t", unit = "ms" }
observe = [
  { quantity = "tension", at = "rope.start", column = "F" },
  { quantity = "displacement", at = "rope.end", column = "s" },
]
"""


def test_a_record_of_another_unit_is_told_where_the_search_ends_badly(tmp_path):
    (tmp_path / "test.csv").write_text("t,F,s\n1,45000,0.1\n2,44000,0.2\n3,40000,0.3\n")
    text = 'scene = "scene.toml"\n' + free(TRUTH[:1], NAMES[:1]) + RECORD
    problem = fit_of(tmp_path, text).problem
    metres = np.array([0.1, 0.2, 0.3])
    assert start_faults(problem) == []
    assert start_faults(problem, (np.array([45e3, 43e3, 41e3]), metres)) == []
    (said,) = start_faults(problem, (np.array([45.0, 44.0, 40.0]), metres))
    assert said == (
        "test: tension at rope.start: the data are about 1000 times what the scene gives at the "
        "start: check the unit of the column."
    )
    assert start_faults(problem, (np.full(3, np.nan), metres)) == []


def test_times_that_end_far_too_early_are_told_where_the_search_ends_badly(tmp_path):
    (tmp_path / "test.csv").write_text("t,F,s\n0.001,45000,0.1\n0.002,44000,0.2\n0.003,40000,0.3\n")
    text = 'scene = "scene.toml"\n' + free(TRUTH[:1], NAMES[:1]) + RECORD
    problem = fit_of(tmp_path, text).problem
    right = np.array([45e3, 44e3, 40e3]), np.array([0.1, 0.2, 0.3])
    assert start_faults(problem) == []
    (said,) = start_faults(problem, right)
    assert said.startswith("test: the times end at 3 us, where the scene goes on to ")
    assert said.endswith(": check their unit.")


def test_where_all_is_linear_a_bad_end_is_not_sought_elsewhere(tmp_path):
    # scatter of twenty times the noise that is given: a bad end, but of the one minimum that there is
    strain, random = np.linspace(0.02, 0.2, 30), np.random.default_rng(5)
    load = 1e6 * strain + 3e6 * strain**2 + 4e3 * random.standard_normal(30)
    problem = law_of(
        tmp_path,
        'law = "polynomial"\ncoefficients = ["1 MN", "1 MN"]',
        '"materials.nylon.coefficients.0" = {}\n"materials.nylon.coefficients.1" = {}',
        strain,
        load,
        'noise = "0.2 kN"\n',
    )
    fitted = fit_problem(problem)
    exact = np.linalg.lstsq(np.stack([strain, strain**2], 1), load, rcond=None)[0]
    np.testing.assert_allclose(fitted.values, exact, rtol=1e-6)
    assert (len(fitted.starts), fitted.sampled) == (1, 0)
    assert any("cannot explain the data" in words for words in remarks_of(fitted))
