"""Static tables: recovery, intervals, what cannot be told, other losses, solvers and laws."""

import io
from dataclasses import replace

import numpy as np
import pytest
from fit_files import BENCH, NAMES, SCENE, TRUTH, bench_of, fit_of, write_bench
from nylon_line import tension
from rich.console import Console

from lumpedcable.fitting.columns import read_data
from lumpedcable.fitting.language import Column
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import _choices
from lumpedcable.fitting.run import fit_problem
from lumpedcable.status import Status

KNOWN = 'noise = "1 %"\n'


@pytest.mark.parametrize("factor", [0.5, 1.5], ids=["half", "half as much again"])
def test_five_numbers_come_back_from_data_without_noise(tmp_path, factor):
    fitted = fit_problem(bench_of(tmp_path, factor * TRUTH).problem)
    assert fitted.converged
    assert fitted.values == pytest.approx(TRUTH, rel=1e-6)
    assert fitted.predicted[0] == pytest.approx(tension(np.linspace(0.005, 0.32, 64)), rel=1e-9)


@pytest.mark.parametrize("solver", ["bfgs", "l-bfgs"])
@pytest.mark.slow
def test_other_minimisers_end_at_the_same_minimum(tmp_path, solver):
    # without p5, which is all but free: first-order methods do not get to the end of its valley
    def four(more):
        study = bench_of(tmp_path, 1.1 * TRUTH, noise=0.01, more=KNOWN + more)
        return fit_problem(replace(study.problem, parameters=study.problem.parameters[:4]))

    best, other = four(""), four(f'[method]\nsolver = "{solver}"\nmax_steps = 5000\n')
    assert best.converged
    assert other.converged
    assert other.loss == pytest.approx(best.loss, rel=1e-6)
    assert abs(other.values / best.values - 1.0) == pytest.approx(np.zeros(4), abs=1e-3)


def test_the_intervals_of_a_linear_law_are_those_of_linear_regression(tmp_path):
    # T = c1 e + c2 e^2 + c3 e^3 is linear in c: the covariance is s^2 (X'X)^-1, exactly
    random = np.random.default_rng(3)
    strain = np.linspace(0.01, 0.3, 40)
    matrix = np.stack([strain, strain**2, strain**3], axis=1)
    load = matrix @ [5e5, -1e6, 8e6] + 2e3 * random.standard_normal(strain.size)
    write_bench(tmp_path, strain, load)
    law = 'law = "polynomial"\ncoefficients = [4e5, 1e5, 1e6]\n'
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    text = 'scene = "scene.toml"\n[free]\n"materials.nylon.coefficients" = {}\n'
    fitted = fit_problem(fit_of(tmp_path, text + BENCH, scene).problem)
    best, rest = np.linalg.lstsq(matrix, load)[:2]
    inverse = np.linalg.inv(matrix.T @ matrix)
    s = np.sqrt(rest[0] / 37)
    assert fitted.values == pytest.approx(best, rel=1e-6)
    assert fitted.certainty.std == pytest.approx(s * np.sqrt(np.diag(inverse)), rel=1e-6)
    root = np.sqrt(np.diag(inverse))
    assert fitted.certainty.correlation == pytest.approx(inverse / np.outer(root, root), abs=1e-6)
    # Student's t with 37 degrees of freedom, 97.5 %: 2.0262 (tables)
    reach = (fitted.certainty.high - fitted.values) / fitted.certainty.std
    assert reach == pytest.approx([2.0262] * 3, abs=1e-4)
    # with the noise given it is no longer found from the fit, and the reach is the normal 1.95996
    known = fit_problem(fit_of(tmp_path, text + BENCH + 'noise = "1 kN"\n', scene).problem)
    assert known.certainty.std == pytest.approx(1e3 * np.sqrt(np.diag(inverse)), rel=1e-6)
    reach = (known.certainty.high - known.values) / known.certainty.std
    assert reach == pytest.approx([1.95996] * 3, abs=1e-5)


def test_the_truth_lies_in_its_interval_as_often_as_it_should(tmp_path):
    # of 5 numbers in 40 repeats 95 % of 200 are 190; correlated, so by the repeat: 3 sigma of 38 is 4.1
    inside = np.zeros(5)
    for seed in range(40):
        fitted = fit_problem(bench_of(tmp_path, TRUTH, noise=0.01, seed=seed, more=KNOWN).problem)
        inside += (fitted.certainty.low < TRUTH) & (fitted.certainty.high > TRUTH)
    assert np.all(inside >= 33)


def test_what_a_bench_cannot_tell_is_named(tmp_path):
    fitted = fit_problem(bench_of(tmp_path, 1.2 * TRUTH, noise=0.01, more=KNOWN).problem)
    said = " ".join(remarks_of(fitted))
    # p5 e is 43 N at most, of 480 kN with 4.8 kN of noise
    assert "The data do not tell nylon p5" in said
    assert "Nearly inseparable" in said
    assert abs(fitted.certainty.combinations[0].parts[4]) > 0.99
    assert fitted.certainty.std[4] > 100 * TRUTH[4]
    # the four others are told to some per cent
    assert np.all(fitted.certainty.std[:4] < 0.2 * np.abs(TRUTH[:4]))


def test_numbers_that_only_their_sum_is_told_of_have_no_interval(tmp_path):
    write_bench(tmp_path, np.array([0.1, 0.1, 0.1]), np.array([1e4, 1.1e4, 0.9e4]))
    law = 'law = "polynomial"\ncoefficients = [1e5, 1e5]\n'
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    text = 'scene = "scene.toml"\n[free]\n"materials.nylon.coefficients" = {}\n'
    fitted = fit_problem(fit_of(tmp_path, text + BENCH, scene).problem)
    # c1 0.1 + c2 0.01 is all that is seen: a change of c1 by d is met by one of c2 by -10 d
    worst = fitted.certainty.combinations[0]
    change = worst.parts * np.abs(fitted.values)
    assert not np.isfinite(worst.spread)
    assert change[1] / change[0] == pytest.approx(-10.0, rel=1e-6)
    assert not np.any(np.isfinite(fitted.certainty.std))


def test_outliers_are_forgiven_where_the_loss_says_so(tmp_path):
    strain = np.linspace(0.005, 0.32, 64)
    load = tension(strain) + 1e3 * np.random.default_rng(5).standard_normal(64)
    load[[7, 23, 40]] += [9e4, -8e4, 9e4]
    errors = {}
    for loss in ("squares", "huber", "cauchy"):
        write_bench(tmp_path, strain, load)
        text = 'scene = "scene.toml"\n' + 'set = { "rope.segments" = 20 }\n'
        text += "[free]\n" + "".join(f'"{n}" = {{}}\n' for n in NAMES[:4])
        text += BENCH + f'noise = "1 kN"\n[method]\nloss = "{loss}"\n'
        fitted = fit_problem(fit_of(tmp_path, text).problem)
        errors[loss] = np.max(np.abs(fitted.predicted[0] - tension(strain)))
    assert errors["squares"] > 5e3
    assert errors["huber"] < 2e3
    assert errors["cauchy"] < 1e3


def test_the_law_that_made_the_data_is_chosen(tmp_path):
    choices = """noise = "1 %"
[choices.straight]
set = { "materials.nylon" = { law = "linear", EA = "1 MN" } }
free = { "materials.nylon.EA" = {} }
[choices.cubic]
set = { "materials.nylon" = { law = "polynomial", coefficients = [1e5, 1e5, 1e5] } }
free = { "materials.nylon.coefficients" = {} }
"""
    study = bench_of(tmp_path, 1.2 * TRUTH, noise=0.01, more=choices)
    found = {name: fit_problem(p).criteria for name, p in study.choices.items()}
    tanh = fit_problem(study.problem).criteria
    assert tanh.aic < found["cubic"].aic < found["straight"].aic
    assert tanh.bic < found["cubic"].bic < found["straight"].bic


CHAIN = """
[experiments.chain]
material = "chain"
file = "chain.csv"
strain = { column = "strain (%)" }
tension = { column = "load", unit = "kN" }
noise = "1 kN"
"""
ROPE = (np.array([0.01, 0.05, 0.1, 0.2, 0.3]), np.array([4.1e3, 22.3e3, 49e3, 116e3, 200e3]))
LINKS = (np.array([0.01, 0.02, 0.03]), np.array([50.1e3, 100e3, 150.2e3]))


def two_materials(folder, choice):
    """A fit of a rope's bench and a chain's, and a choice for the rope alone."""
    write_bench(folder, *ROPE)
    write_bench(folder, *LINKS, "chain.csv")
    law = 'law = "polynomial"\ncoefficients = [4e5, 1e5]\n'
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    scene += '[materials.chain]\nlaw = "linear"\nEA = "1 MN"\n'
    text = 'scene = "scene.toml"\n[free]\n"materials.nylon.coefficients" = {}\n'
    text += '"materials.chain.EA" = {}\n'
    return fit_of(folder, text + BENCH + 'noise = "1 kN"\n' + CHAIN + choice, scene)


def test_a_choice_for_one_material_fits_the_other_as_well(tmp_path):
    choice = """[choices.straight]
set = { "materials.nylon" = { law = "linear", EA = "1 MN" } }
free = { "materials.nylon.EA" = {} }
"""
    problem = two_materials(tmp_path, choice).choices["straight"]
    assert {p.key for p in problem.parameters} == {"materials.nylon.EA", "materials.chain.EA"}
    fitted = fit_problem(problem)
    # two straight lines through the origin, each by least squares
    best = {"materials.nylon.EA": ROPE, "materials.chain.EA": LINKS}
    best = {key: (e @ t) / (e @ e) for key, (e, t) in best.items()}
    found = dict(zip((p.key for p in problem.parameters), fitted.values, strict=True))
    assert found == pytest.approx(best, rel=1e-6)
    square = sum(np.sum((found[k] * e - t) ** 2) for k, (e, t) in
                 {"materials.nylon.EA": ROPE, "materials.chain.EA": LINKS}.items())  # fmt: skip
    assert fitted.loss == pytest.approx(square / 1e6, rel=1e-6)


@pytest.mark.parametrize(
    ("choice", "keys"),
    [
        # what it gives a value is no longer free, and what it frees in its own way is once
        ('{ "nylon.coefficients.1" = 0.0 }\nfree = { "materials.chain.EA" = { start = 5e6 } }',
         ["materials.nylon.coefficients.0", "materials.chain.EA"]),
        ('{ "chain.EA" = "5 MN" }\nfree = { "materials.nylon.coefficients.0" = {} }',
         ["materials.nylon.coefficients.1", "materials.nylon.coefficients.0"]),
    ],
)  # fmt: skip
def test_what_a_choice_leaves_free(tmp_path, choice, keys):
    problem = two_materials(tmp_path, f"[choices.other]\nset = {choice}\n").choices["other"]
    assert [p.key for p in problem.parameters] == keys


WEAK = """scene = "scene.toml"
set = { "materials.nylon.p5" = "1 N" }
[free]
"materials.nylon.p1" = { start = "100 kN", high = "110 kN" }
"materials.nylon.p4" = { start = "100 kN", high = "120 kN" }
[experiments.record]
file = "record.csv"
time = { column = "t (ms)" }
observe = [{ quantity = "tension", at = "rope.start", column = "F (kN)", noise = "1 kN" }]
[method]
starts = 1
"""


@pytest.mark.slow
def test_a_law_without_an_answer_is_not_the_best(tmp_path):
    """A line that is pulled by 300 kN has no equilibrium where its law never bears that."""
    rows = "".join(f"{t},300\n" for t in range(11))
    (tmp_path / "record.csv").write_text(f"t (ms),F (kN)\n{rows}")
    weak = fit_problem(fit_of(tmp_path, WEAK, SCENE.replace("45 kN", "300 kN")).problem)
    assert weak.failures == (("record", Status.STATICS_NOT_CONVERGED),)
    assert weak.criteria.aic == weak.criteria.bic == weak.certainty.factor == np.inf
    assert remarks_of(weak)[0] == "11 values, not all of which have an answer."
    good = fit_problem(bench_of(tmp_path, TRUTH, noise=0.01, more=KNOWN).problem)
    console = Console(record=True, width=200, file=io.StringIO())
    console.print(_choices({"weak": weak, "as given": good}))
    rows = [line.split() for line in console.export_text().splitlines()]
    assert ["as", "given", "5", f"{good.certainty.factor:.3g}", "+0.0", "+0.0", "ok"] in rows
    assert rows.index(["weak", "2", "-", "-", "-", "run", "failed"]) > 3


@pytest.mark.parametrize("name", ["load", "load (kN)"])
def test_a_column_is_named_with_its_unit_or_without(tmp_path, name):
    (tmp_path / "bench.csv").write_text("strain (%),load (kN)\n1,2\n2,3.5\n")
    wanted = [((), Column(column="strain"), ""), ((), Column(column=name), "N")]
    columns, problems = read_data(tmp_path / "bench.csv", (), wanted)
    assert problems == []
    assert columns.values == pytest.approx(np.array([[0.01, 0.02], [2e3, 3.5e3]]))
