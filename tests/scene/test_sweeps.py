"""Sweeps beyond lists: ranges, cases, keys that move together, draws, and how they are refused."""

import math

import good_scenes
import numpy as np
import pytest
from scipy.stats import kstest, lognorm, norm, qmc, truncnorm, uniform
from swept_rope import HOLD, LIST, PRETENSION, REFERENCE, TIME, faults, study_of, values

from lumpedcable.scene import CHECKED, load_study, run_checks
from lumpedcable.scene.draws import spread, unit_draws


@pytest.mark.parametrize(
    ("range_", "expected"),
    [
        ('{ from = "45 kN", to = "75 kN", count = 3 }', [45e3, 60e3, 75e3]),
        ('{ from = "1 kN", to = "100 kN", count = 3, spacing = "log" }', [1e3, 10e3, 100e3]),
        ('{ from = "10 kN", to = "14 kN", step = "2 kN" }', [10e3, 12e3, 14e3]),
    ],
)
def test_a_range_is_its_values(tmp_path, range_, expected):
    study = study_of(tmp_path, f'[sweep]\n"{PRETENSION}" = {range_}\n')
    assert values(study, PRETENSION) == pytest.approx(expected, rel=1e-14)
    again = study_of(tmp_path, "", [f"pretension={range_}"])
    assert again.axes == study.axes


def test_a_range_of_a_count_is_whole_numbers(tmp_path):
    study = study_of(
        tmp_path, '[sweep]\n"lines.rope.segments" = { from = 50, to = 200, step = 50 }\n'
    )
    assert [run.lines["rope"].segments for run in study.runs] == [50, 100, 150, 200]


def test_zipped_keys_move_together_and_multiply_with_the_rest(tmp_path):
    study = study_of(
        tmp_path,
        f'[sweep]\n"{PRETENSION}" = ["45 kN", "180 kN"]\n'
        f'[[sweep.zip]]\n"lines.rope.length" = ["50 m", "60 m", "70 m"]\n'
        f'"{TIME}" = {{ from = "1 ms", to = "3 ms", count = 3 }}\n',
    )
    assert study.shape == (2, 3)
    seen = [
        (r.lines["rope"].end.held.pretension, r.lines["rope"].length, r.events["break"].time)
        for r in study.runs
    ]
    rows = [(50.0, 0.001), (60.0, 0.002), (70.0, 0.003)]
    assert seen == [(t, *row) for t in (45e3, 180e3) for row in rows]


@pytest.mark.parametrize("method", ["random", "latin-hypercube", "sobol"])
def test_draws_are_those_of_scipy_and_the_seed(tmp_path, method):
    sweep = f"""
[sweep.sample]
method = "{method}"
count = 64
seed = 7
"{PRETENSION}" = {{ from = "45 kN", to = "450 kN" }}
"{TIME}" = {{ from = "1 ms", to = "100 ms", spacing = "log" }}
"""
    study = study_of(tmp_path, sweep)
    assert study.shape == (64,)
    engine = {"sobol": qmc.Sobol, "latin-hypercube": qmc.LatinHypercube}.get(method)
    rng = np.random.default_rng(7)
    unit = rng.random((64, 2)) if engine is None else engine(2, rng=rng).random(64)
    assert values(study, PRETENSION) == pytest.approx(45e3 + 405e3 * unit[:, 0], rel=1e-14)
    assert values(study, TIME) == pytest.approx(1e-3 * 100 ** unit[:, 1], rel=1e-12)
    assert study_of(tmp_path, sweep).axes == study.axes
    assert study_of(tmp_path, sweep.replace("seed = 7", "seed = 8")).axes != study.axes


@pytest.mark.parametrize(
    ("how", "law"),
    [
        ({"from": 2.0, "to": 5.0}, uniform(2.0, 3.0)),
        ({"mean": 3.0, "deviation": 0.5}, norm(3.0, 0.5)),
        ({"mean": 3.0, "deviation": 2.0, "from": 2.5}, truncnorm(-0.25, math.inf, 3.0, 2.0)),
        ({"mean": 0.0, "deviation": 1.0, "from": -1.0, "to": 2.0}, truncnorm(-1.0, 2.0)),
        ({"mean": 1.0, "deviation": 0.1, "from": 2.0, "to": 2.5}, truncnorm(10, 15, 1.0, 0.1)),
        ({"mean": 0.0, "deviation": 1.0, "from": 30.0}, truncnorm(30.0, math.inf)),
        ({"mean": 0.0, "deviation": 1.0, "to": -30.0}, truncnorm(-math.inf, -30.0)),
    ],
)
def test_spread_is_the_distribution_of_scipy(how, law):
    u = unit_draws("latin-hypercube", 1000, 1, 3)[:, 0]
    np.testing.assert_allclose(spread(u, how), law.ppf(u), rtol=1e-9, atol=1e-12)


def test_a_log_spread_may_be_wider_than_its_ratio():
    u = unit_draws("random", 100, 1, 5)[:, 0]
    x = spread(u, {"from": 1e-200, "to": 1e200, "spacing": "log"})
    np.testing.assert_allclose(np.log10(x), -200.0 + 400.0 * u, rtol=1e-12, atol=1e-12)


def test_a_log_spread_is_uniform_in_the_logarithm():
    x = spread(unit_draws("random", 4000, 1, 5)[:, 0], {"from": 1e-3, "to": 1.0, "spacing": "log"})
    assert kstest(np.log10(x), uniform(-3.0, 3.0).cdf).pvalue > 0.01
    assert kstest(x, lognorm(1.0).cdf).pvalue < 1e-6  # what tells laws apart does so


def test_a_sweep_of_all_kinds_reads_back_from_its_effective_text(tmp_path):
    study = study_of(
        tmp_path,
        f"""
[sweep]
"solver.courant" = [0.5, 0.9]
[[sweep.cases]]
name = "a"
"gravity" = 9.81
[[sweep.cases]]
name = "b"
"gravity" = 1.62
[[sweep.zip]]
"lines.rope.length" = ["50 m", "60 m"]
"{TIME}" = ["1 ms", "2 ms"]
[[sweep.sample]]
method = "sobol"
count = 8
"{PRETENSION}" = {{ mean = "100 kN", deviation = "20 kN", from = "50 kN" }}
""",
    )
    assert study.shape == (2, 2, 2, 8)
    path = tmp_path / "again.toml"
    path.write_text(study.effective_text)
    again = load_study(path)
    assert again.factors == study.factors
    assert again.effective_text == study.effective_text
    ended = load_study(path, ["break.time=3 ms", "pretension=50 kN"])
    assert ended.shape == (2, 2, 2)
    assert {run.events["break"].time for run in ended.runs} == {0.003}


def test_ten_million_runs_are_rows_not_scenes(tmp_path, scenes_built):
    study = study_of(
        tmp_path,
        f'[sweep]\n"{PRETENSION}" = {{ from = "45 kN", to = "450 kN", count = 3125 }}\n'
        f'"{TIME}" = {{ from = 0, to = "50 ms", count = 3200 }}\n',
    )
    assert len(study.runs) == 10**7
    chosen = study.runs.numbers([0, 3199, 9_999_999])
    assert chosen[PRETENSION].tolist() == [45e3, 45e3, 450e3]
    assert chosen[TIME] == pytest.approx([0.0, 0.05, 0.05])
    everywhere = study.runs.numbers(np.arange(10**6))
    assert everywhere[TIME][3200:6400].tolist() == everywhere[TIME][:3200].tolist()
    assert scenes_built[0] < 3 * CHECKED


def test_every_run_of_a_large_sweep_is_asked_by_itself(tmp_path, monkeypatch):
    # of zipped rows the extremes of each key are looked at when the file is read: not the third, whose
    # tension falls with strain
    monkeypatch.setattr(run_checks, "CHECKED", 1)
    p1, p2 = "materials.nylon.p1", "materials.nylon.p2"
    sweep = f'[[sweep.zip]]\n"{p1}" = [-27e4, 27e4, 1e4]\n"{p2}" = [-10.2, 10.2, -1]\n'
    runs = study_of(tmp_path, sweep, ["materials.nylon.p4=300e3", f"{PRETENSION}=100e3"]).runs
    said = [runs.problem(k) for k in range(3)]
    assert said[:2] == [None, None]
    assert "materials.nylon: expected a tension that rises" in said[2]


@pytest.mark.parametrize("overrides", [(), ("solver.step=[1e-5, 2e-5]",)])
def test_a_swept_number_may_be_of_a_table_that_the_file_does_not_give(tmp_path, overrides):
    text = good_scenes.ROPE[:REFERENCE].replace(LIST, "")
    text = text.replace('[solver]\nmethod = "leapfrog"\n', "")
    swept = "" if overrides else '[sweep]\n"solver.step" = [1e-5, "20 us"]\n'
    study = load_study(good_scenes.write(tmp_path, text + swept), overrides)
    assert [run.solver.step for run in study.runs] == [1e-5, 2e-5]
    assert list(study.runs.numbers([1, 0])["solver.step"]) == [2e-5, 1e-5]


def test_what_else_such_a_table_needs_is_told(tmp_path):
    told = faults(tmp_path, '[sweep]\n"seabed.friction" = [0.1, 0.2]\n')
    assert [key for key, _ in told] == ["seabed.height", "seabed.stiffness"]
    assert all("found nothing" in message for _, message in told)


def test_a_number_that_moves_others_moves_them_in_the_columns(tmp_path):
    direction = "lines.rope.end.held.direction"
    study = study_of(tmp_path, f'[sweep]\n"{direction}.2" = [0, 1]\n')
    columns = study.runs.numbers([0, 1])
    assert columns[f"{direction}.0"] == pytest.approx([1.0, 0.5**0.5])
    assert columns[f"{direction}.2"] == pytest.approx([0.0, 0.5**0.5])


def test_three_components_of_a_direction_make_a_unit_vector(tmp_path):
    direction = "lines.rope.end.held.direction"
    rows = "".join(f'"{direction}.{k}" = {v}\n' for k, v in enumerate([[3, 1], [0, 0], [4, 0]]))
    study = study_of(tmp_path, f"[sweep.zip]\n{rows}")
    for run, exact in enumerate([(0.6, 0.0, 0.8), (1.0, 0.0, 0.0)]):
        assert study.runs[run].lines["rope"].end.held.direction == pytest.approx(exact, abs=1e-15)
        columns = study.runs.numbers([run])
        found = [columns[f"{direction}.{k}"][0] for k in range(3)]
        assert found == pytest.approx(exact, abs=1e-15)


@pytest.mark.parametrize(
    ("sweep", "key", "words"),
    [
        (f'[sweep]\n"{PRETENSION}" = {{ from = "1 kN", to = "2 kN" }}', f'sweep."{PRETENSION}"',
         "expected count or step, found neither"),
        (f'[sweep]\n"{PRETENSION}" = {{ from = "10 kN", to = "13 kN", step = "2 kN" }}',
         f'sweep."{PRETENSION}".to',
         'a whole number of steps from "10 kN", to 12 kN or 14 kN, found "13 kN"'),
        ('[sweep]\n"lines.rope.segments" = { from = 50, to = 60, step = 3 }',
         'sweep."lines.rope.segments".to',
         "a whole number of steps from 50, to 59 or 62, found 60"),
        (f'[sweep]\n"{PRETENSION}" = {{ form = "1 kN", to = "2 kN", count = 3 }}',
         f'sweep."{PRETENSION}".form', 'did you mean "from"'),
        (f'[sweep]\n"{PRETENSION}" = {{ from = "2 kN", to = "1 kN", count = 3 }}',
         f'sweep."{PRETENSION}".to', "expected more than from"),
        (f'[sweep]\n"{PRETENSION}" = {{ from = 0, to = 1, count = 3, spacing = "log" }}',
         f'sweep."{PRETENSION}".from', 'more than 0 with spacing = "log"'),
        (f'[sweep]\n"{PRETENSION}" = {{ from = "1 m", to = "2 kN", count = 3 }}',
         f'sweep."{PRETENSION}".from', "found a length (m)"),
        ('[sweep]\n"lines.rope.segments" = { from = 10, to = 15, count = 3 }',
         'sweep."lines.rope.segments"', "whole numbers, found 12.5"),
        (f'[sweep.zip]\n"{PRETENSION}" = [1, 2]\n"{TIME}" = [1]', f'sweep.zip."{TIME}"',
         "expected 2 values"),
        (f'[sweep]\n"{TIME}" = [1]\n[sweep.zip]\n"{PRETENSION}" = [1, 2]\n"{TIME}" = [1, 2]',
         f'sweep.zip."{TIME}"', "expected each key once"),
        ('[sweep]\nzip = 3', "sweep.zip", "expected tables, [[sweep.zip]], found 3"),
        (f'[[sweep.cases]]\n"{PRETENSION}" = "9 m"', f'sweep.cases.0."{PRETENSION}"',
         "found a length (m)"),
        ('[[sweep.cases]]\n"lines.roop.length" = 3\n', 'sweep.cases.0."lines.roop.length"',
         'did you mean "lines.rope.length"'),
        (f'[[sweep.cases]]\nname = "x"\n[[sweep.cases]]\n"{PRETENSION}" = "600 kN"',
         f'sweep.cases.1."{PRETENSION}"', "expected at most 531.654 kN"),
        ('[[sweep.cases]]\nname = "x"\n[[sweep.cases]]\nname = "y"', "sweep.cases",
         "expected keys with values in at least one case, found names alone"),
        ("[[sweep.cases]]\n[[sweep.cases]]", "sweep.cases",
         "expected keys with values in at least one case, found none"),
        (f'[[sweep.cases]]\nname = "x"\n[[sweep.cases]]\nname = "x"\n"{PRETENSION}" = 9',
         "sweep.cases.1.name", 'expected each name once, found "x" again'),
        (f'[[sweep.cases]]\nname = "a\\u0000b"\n"{PRETENSION}" = 9', "sweep.cases.0.name",
         "expected text of one line without control characters, found U+0000"),
        (f'[[sweep.cases]]\nname = "a\\nb"\n"{PRETENSION}" = 9', "sweep.cases.0.name", "found U+000A"),
        (f'[sweep.sample]\ncount = 4\nmethod = "sobel"\n"{TIME}" = {{ from = 0, to = 1 }}',
         "sweep.sample.method", 'did you mean "sobol"'),
        (f'[sweep.sample]\n"{TIME}" = {{ from = 0, to = 1 }}', "sweep.sample", "expected count"),
        (f'[sweep]\n"{TIME}" = {{ mean = 1, from = 0 }}', f'sweep."{TIME}".mean',
         "distributions are drawn in sweep.sample"),
        ("[sweep.sample]\ncount = 4", "sweep.sample", "expected at least one key"),
        (f'[sweep.sample]\ncount = 4\n"{TIME}" = {{ mean = 0, deviation = 1 }}',
         f'sweep.sample."{TIME}"', "in draw"),
        (f'[sweep.sample]\ncount = 4\n"{TIME}" = [1, 2]', f'sweep.sample."{TIME}"',
         "expected a table with from and to"),
        (f'[sweep.sample]\ncount = 4\n"{TIME}" = {{ mean = 1 }}', f'sweep.sample."{TIME}"',
         "expected mean and deviation"),
        *((f'[sweep.sample]\ncount = 4\n"{TIME}" = {{ mean = {m}, deviation = 1e-3, {cuts} }}',
           f'sweep.sample."{TIME}"', f"found cuts that lie {off}")
          for m, cuts, off in [
              (1, "from = 1e5, to = 2e5", "1e+08 deviations from the mean and 1e+08 apart"),
              (1, "from = 1e5", "1e+08 deviations from the mean"),
              (2, "to = 1", "1e+03 deviations from the mean"),
              (1, "from = 1, to = 1.000000000001", "0 deviations from the mean and 1e-09 apart")]),
        (f'[sweep.sample]\ncount = 4\n"{HOLD}" = {{ from = -1e308, to = 1.7e308 }}',
         f'sweep.sample."{HOLD}".to', "expected a way from -1e+308 that is finite, found 1.7e+308"),
        (f'[sweep.sample]\ncount = 4\n"{HOLD}" = {{ mean = 0, deviation = 1.7e308, to = 1.7e308 }}',
         f'sweep.sample."{HOLD}"', "found -inf, which is not finite in draw"),
        (f'[sweep]\n"{HOLD}" = {{ from = -1e308, to = 1e308, count = 3 }}',
         f'sweep."{HOLD}".to', "expected a way from -1e+308 that is finite, found 1e+308"),
        (f'[sweep]\n"{HOLD}" = {{ from = 0, to = 1e10, step = 1e-300 }}', f'sweep."{HOLD}".step',
         "expected at most 10000000 values, found more than can be counted"),
        ('[sweep.sample]\ncount = 4\n"lines.rope.segments" = { from = 1, to = 9 }',
         'sweep.sample."lines.rope.segments"', "sweep a count by a list"),
    ],
)  # fmt: skip
def test_a_wrong_sweep_is_told(tmp_path, sweep, key, words):
    told = faults(tmp_path, sweep)
    assert [k for k, _ in told] == [key]
    assert words in told[0][1]


def test_a_key_of_very_many_dots_is_refused(tmp_path):
    ((key, message),) = faults(tmp_path, f"[sweep]\n{'.'.join(3000 * 'a')} = [1, 2]\n")
    assert key.startswith("sweep.a.a")
    assert message.startswith("expected the full path of a number of the scene, found")


KEYS = ("lines.rope.length", "events.break.time", "lines.rope.mass")
VALUES = ('["50 m", "60 m"]', '["1 ms", "2 ms", "3 ms"]', '["2 kg/m", "3 kg/m"]')


@pytest.mark.parametrize("quote", ["", '"'])
def test_the_first_key_of_a_sweep_is_the_slowest_with_quotes_or_without(tmp_path, quote):
    rows = [f"{quote}{key}{quote} = {of}\n" for key, of in zip(KEYS, VALUES, strict=True)]
    study = study_of(tmp_path, "[sweep]\n" + "".join(rows))
    assert [axis.key for axis in study.axes] == list(KEYS)
    assert study.shape == (2, 3, 2)
    last = len(study.runs) - 1
    assert study.runs.values(1)["lines.rope.mass"] == 3.0  # the last key is the quickest
    assert study.runs.values(last)["lines.rope.length"] == 60.0
    assert load_study(good_scenes.write(tmp_path, study.effective_text)).axes == study.axes


@pytest.mark.parametrize("quote", ["", '"'])
def test_draws_do_not_depend_on_quotes(tmp_path, quote):
    rows = [f"{quote}{key}{quote} = {{ from = 1.0, to = 2.0 }}\n" for key in KEYS]
    study = study_of(tmp_path, "[sweep.sample]\ncount = 3\n" + "".join(rows))
    points = qmc.LatinHypercube(3, rng=np.random.default_rng(0)).random(3)
    for key, column in zip(KEYS, points.T, strict=True):
        assert values(study, key) == pytest.approx(1.0 + column, rel=1e-14)
