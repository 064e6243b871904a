"""Numbers come back from break tests: all digits without noise, as often as they should with it."""

import json
from dataclasses import replace
from itertools import product

import jax
import numpy as np
import pytest
from command_line import ROOT, say
from engine_runs import nylon_rope
from fit_files import BENCH, NAMES, TRUTH, fit_of, free, write_bench
from nylon_line import tension

from benchmarks.fitting import begun
from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import status_of
from lumpedcable.fitting.residual import group_start, predict
from lumpedcable.fitting.ropes import fit_ropes
from lumpedcable.fitting.run import fit_problem
from lumpedcable.status import Status
from lumpedcable.study.compiled import RUN_ONCE

# four pretensions of Zhu, Yin & Shen 2018; the law is told by the force at the wall and the end's place
PULLS = (45, 180, 315, 450)
RECORD = """
[experiments.at-{pull}]
file = "test.csv"
set = {{ pretension = "{pull} kN" }}
time = {{ column = "t (ms)" }}
observe = [
    {{ quantity = "tension", at = "rope.start", column = "F", noise = 1 }},
    {{ quantity = "position", at = "rope.end", component = "x", column = "x", noise = 1 }},
]
"""


def breaks(folder, segments=10, more="", pulls=PULLS):
    """A fit to break tests, one for each pretension (kN), whose data are still to be put in."""
    rows = "".join(f"{2 * k},1,1\n" for k in range(1, 51))
    (folder / "test.csv").write_text("t (ms),F,x\n" + rows)
    text = 'scene = "scene.toml"\n' + free(TRUTH) + more
    text += "".join(RECORD.format(pull=pull) for pull in pulls)
    return fit_of(folder, text, nylon_rope(segments, "100 ms", "2 ms")).problem


def answers(problem):
    """What the model says at the truth, by record and series."""
    spec, arrays = arrays_of(problem)
    said = jax.jit(predict, static_argnames=("spec",), compiler_options=RUN_ONCE)
    (group,) = said(spec, arrays, TRUTH).groups
    return np.asarray(group)


def measured(problem, said, share, random=None):
    """The problem with these answers as its data, with noise of a share of each one's largest."""
    records = []
    for record, rows in zip(problem.records, said, strict=True):
        series = []
        for s, values in zip(record.series, rows, strict=True):
            size = share * float(np.max(np.abs(values)))
            noisy = (
                values if random is None else values + size * random.standard_normal(values.size)
            )
            series.append(replace(s, values=noisy, noise=size))
        records.append(replace(record, series=tuple(series)))
    return replace(problem, records=tuple(records))


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    problem = breaks(tmp_path_factory.mktemp("breaks"))
    return measured(problem, answers(problem), 0.01)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [0.5, 1.5], ids=["half", "half as much again"])
def test_five_numbers_come_back_from_breaks_without_noise(clean, factor):
    # from half of each the law reaches two of the four pretensions alone
    fitted = fit_problem(begun(clean, factor * TRUTH))
    assert fitted.converged
    assert fitted.values == pytest.approx(TRUTH, rel=1e-6)
    # runs that cannot be pulled so far are counted on the way, and no more than that
    assert sum(start.failed for start in fitted.starts) > 0
    assert not fitted.failures


@pytest.mark.slow
def test_five_numbers_come_back_from_bench_and_breaks_of_fifty_segments(tmp_path):
    strain = np.linspace(0.005, 0.32, 64)
    write_bench(tmp_path, strain, tension(strain))
    problem = breaks(tmp_path, 50, BENCH + 'noise = "1 %"\n')
    problem = measured(problem, answers(problem), 0.01)
    for factor in (0.5, 1.5):
        fitted = fit_problem(begun(problem, factor * TRUTH))
        assert fitted.converged
        assert fitted.values == pytest.approx(TRUTH, rel=1e-6), factor


@pytest.mark.slow
def test_a_law_that_cannot_reach_a_pretension_is_told(tmp_path):
    # T = p1 tanh(...) + p4 + p5 e stays below 500 kN, a little more by p5: without an answer at 530 kN
    problem = breaks(tmp_path, pulls=(45, 315, 530))
    kept = {"materials.nylon.p1": 2.5e5, "materials.nylon.p4": 2.5e5}
    parameters = [replace(p, high=kept.get(p.key, np.inf)) for p in problem.parameters]
    method = problem.method.model_copy(update={"starts": 1})
    bounded = replace(problem, parameters=tuple(parameters), method=method)
    bounded = measured(bounded, answers(problem), 0.01)
    fitted = fit_problem(begun(bounded, [2.4e5, 10, -2, 2.4e5, 100]))
    assert [name for name, _ in fitted.failures] == ["at-530"]
    assert not fitted.converged
    assert status_of(fitted) == "run failed"
    assert any("experiments.at-530" in remark for remark in remarks_of(fitted))
    assert np.all(np.isfinite(fitted.values))


@pytest.mark.slow
def test_a_wild_trial_fails_instead_of_taking_hours(tmp_path):
    # p1 a million million times too large: waves a million times as fast, and so many steps more
    problem = breaks(tmp_path)
    spec, arrays = arrays_of(problem)
    (own,), (group,) = arrays.groups, spec.groups
    wild = TRUTH * np.array([1e12, 1, 1, 1, 1])
    _, bound, converged = group_start(group, own, wild)
    assert np.all(converged)
    assert np.max(own.every / (own.courant * bound)) > 100 * own.most
    said = jax.jit(predict, static_argnames=("spec",), compiler_options=RUN_ONCE)
    calm, found = said(spec, arrays, TRUTH), said(spec, arrays, wild)
    assert np.all(calm.status[0] == Status.OK)
    assert int(found.steps[0]) == int(own.most)
    # the steps that a run takes are rounded up by a sixteenth at most
    assert 16 / 17 * int(calm.steps[0]) <= int(own.most) / 1000 <= int(calm.steps[0])
    assert np.all(found.status[0] != Status.OK)


@pytest.mark.slow
def test_what_breaks_cannot_tell_is_named(clean):
    said = [np.array([s.values for s in record.series]) for record in clean.records]
    fitted = fit_problem(measured(clean, said, 0.01, np.random.default_rng(3)))
    # p5 e is 40 N at most, of 450 kN with 4.5 kN of noise; the four others are told to some per cent
    assert abs(fitted.certainty.combinations[0].parts[4]) > 0.99
    assert "The data do not tell nylon p5" in " ".join(remarks_of(fitted))
    assert np.all(fitted.certainty.std[:4] < 0.05 * np.abs(TRUTH[:4]))
    assert np.all(abs(fitted.values - TRUTH) < 4.0 * fitted.certainty.std)


@pytest.mark.slow
def test_bench_and_breaks_tell_more_together_than_either(tmp_path):
    found = {}
    for name in ("bench", "breaks", "both"):
        said = say(ROOT, "fit", f"configs/fit/nylon-{name}.toml", "-o", tmp_path / name)
        assert said.code == 0, said.err
        assert "nylon p5" in said.out.split("The data do not tell")[1].splitlines()[0]
        told = json.loads((tmp_path / name / "fit.json").read_text())
        found[name] = np.array([[p["value"], p["std"]] for p in told["parameters"]])
        # the data's noise is of one seed: within three and a half standard deviations
        assert np.all(abs(found[name][:, 0] - TRUTH) < 3.5 * found[name][:, 1])
        assert [p["name"] for p in told["profiles"]] == [NAMES[4]]
        assert say(tmp_path, "check", tmp_path / name / "snapback-fitted.toml").code == 0
    assert np.all(found["both"][:, 1] < found["bench"][:, 1])
    assert np.all(found["both"][:, 1] < 1.01 * found["breaks"][:, 1])


@pytest.mark.slow
def test_the_truth_lies_in_its_interval_in_90_to_99_of_100_repeats(clean):
    said = [np.array([s.values for s in record.series]) for record in clean.records]
    inside = np.zeros(5)
    for seed in range(100):
        fitted = fit_problem(measured(clean, said, 0.01, np.random.default_rng(seed)))
        assert fitted.converged
        inside += (fitted.certainty.low < TRUTH) & (fitted.certainty.high > TRUTH)
    assert np.all((inside >= 90) & (inside <= 99)), inside


@pytest.mark.slow
def test_any_five_numbers_half_off_come_back(clean):
    # every number half as large or half as much again, in all 32 ways
    random = np.random.default_rng(7)
    said = [np.array([s.values for s in record.series]) for record in clean.records]
    noisy = measured(clean, said, 0.01, random)
    best = fit_problem(noisy)
    for factors in product((0.5, 1.5), repeat=5):
        fitted = fit_problem(begun(noisy, np.array(factors) * TRUTH))
        assert fitted.converged
        assert fitted.loss == pytest.approx(best.loss, rel=1e-4), factors


@pytest.mark.slow
def test_ropes_with_records_are_what_they_are_alone(clean):
    said = [np.array([s.values for s in record.series]) for record in clean.records]
    ropes = {
        str(seed): begun(measured(clean, said, 0.01, np.random.default_rng(seed)), factor * TRUTH)
        for seed, factor in ((1, 1.3), (2, 0.5), (3, 1.0))
    }
    for name, fitted in fit_ropes(ropes).items():
        alone = fit_problem(ropes[name])
        assert fitted.converged
        assert fitted.loss == pytest.approx(alone.loss, rel=1e-6)
        # where the ends differ, by next to nothing beside what the data leave open
        assert np.all(abs(fitted.values - alone.values) < 1e-2 * alone.certainty.std)
