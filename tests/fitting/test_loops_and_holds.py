"""Tables with times: what relaxes comes back from loops and holds, as surely as is said."""

import json

import jax
import numpy as np
import pytest
from command_line import refused
from engine_runs import run_text
from fit_files import BENCH, fit_of, write_bench
from loop_files import (
    BRANCHES,
    LOOPS,
    NAMES,
    SCENE,
    cycles_of,
    experiment,
    history,
    hold,
    loop,
    measure,
    start_text,
    write,
)
from nylon_line import tension

import lumpedcable as lc
from lumpedcable.fitting.arrays import arrays_of
from lumpedcable.fitting.laws import law_bands
from lumpedcable.fitting.profile import with_profiles
from lumpedcable.fitting.residual import predict
from lumpedcable.fitting.ropes import fit_ropes
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.write import pictures_of, write_fit
from lumpedcable.scene import load_study
from lumpedcable.view.fit import fit_figures, pictures_from

TRUTH = BRANCHES.ravel()
KNOWN = "1 %"
ALONE = "[method]\nstarts = 1\n"


def test_the_tension_of_a_table_is_the_sum_of_its_history(tmp_path):
    problem = cycles_of(tmp_path, TRUTH).problem
    found = predict(*arrays_of(problem), TRUTH).tables
    exact = [tension(e) + history(e, t) for e, t in [loop(m, p) for _, m, p in LOOPS] + [hold()]]
    for one, other in zip(found, exact, strict=True):
        assert np.asarray(one) == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize(
    "factors", [(1.3, 0.7, 0.7, 1.3), (1, 10, 1, 10), (1, 0.1, 1, 0.1), (0.1, 1, 10, 10)], ids=str
)
def test_two_branches_come_back_from_starts_that_are_far_off(tmp_path, factors):
    fitted = fit_problem(cycles_of(tmp_path, factors * TRUTH).problem)
    assert fitted.converged
    assert fitted.values == pytest.approx(TRUTH, rel=1e-6)
    assert fitted.sampled == 0


def test_times_that_start_on_each_other_s_side_end_at_the_same_minimum(tmp_path):
    # the names of two branches mean nothing but their order at the start
    fitted = fit_problem(cycles_of(tmp_path, [1e5, 40.0, 1e5, 6.0]).problem)
    assert fitted.converged
    assert fitted.values == pytest.approx(TRUTH[[2, 3, 0, 1]], rel=1e-6)


def test_several_starts_lie_evenly_over_the_decades_between_bounds(tmp_path):
    low, high = 0.01, 1e4
    names = measure(tmp_path)
    text = start_text([4.0], NAMES[1:2]).replace("= 4.0", f"= 4.0, low = {low}, high = {high}")
    text = text.replace("EA = 1e5, time = 2 ", "EA = 150e3, time = 2 ").replace(
        "EA = 1e5, time = 50 ", "EA = 90e3, time = 60 "
    )
    text += "".join(map(experiment, names)) + "[method]\nstarts = 8\n"
    fitted = fit_problem(fit_of(tmp_path, text, SCENE).problem)
    assert fitted.values == pytest.approx([4.0], rel=1e-6)
    logs = np.log([s.start[0] / low for s in fitted.starts[1:]]) / np.log(high / low)
    # points of a Sobol sequence, seven of eight: no two in the same eighth of what is drawn from
    assert len(set(np.floor(8.0 * (logs - 0.02) / 0.96))) == 7


@pytest.mark.slow
def test_slopes_of_the_deviations_are_those_of_differences(tmp_path):
    spec, arrays = arrays_of(cycles_of(tmp_path, TRUTH).problem)

    def all_of(x):
        return np.concatenate([np.asarray(t) for t in predict(spec, arrays, x).tables])

    slope = jax.jacfwd(lambda x: jax.numpy.concatenate(predict(spec, arrays, x).tables))(TRUTH)
    for k in range(4):
        step = 1e-5 * TRUTH[k] * (np.arange(4) == k)
        difference = (all_of(TRUTH + step) - all_of(TRUTH - step)) / (2e-5 * TRUTH[k])
        # rounding of tensions that are 10 times as large as their change by a branch: 1e-16 / 1e-5
        assert np.asarray(slope)[:, k] == pytest.approx(
            difference, abs=1e-8 * np.max(np.abs(difference))
        )


def test_the_truth_lies_in_its_interval_as_often_as_it_should(tmp_path):
    # of 40 repeats 95 % are 38; 3 sigma of 38 is 4.1
    inside = np.zeros(4)
    for seed in range(40):
        # each from one start: the sample that guards against other minima takes longer than all else
        study = cycles_of(
            tmp_path, TRUTH * [0.8, 0.7, 1.2, 1.4], 0.01, seed, known=KNOWN, more=ALONE
        )
        fitted = fit_problem(study.problem)
        assert fitted.converged
        inside += (fitted.certainty.low < TRUTH) & (fitted.certainty.high > TRUTH)
    assert np.all(inside >= 33), inside


@pytest.mark.slow
def test_the_truth_lies_in_its_interval_in_92_to_98_of_100_of_many_repeats(tmp_path):
    # three standard deviations of 95 % of 400; branches that are told to some per cent, so that the
    # model is nearly linear over an interval
    inside, branches = np.zeros(4), np.array([[800e3, 4.0], [400e3, 60.0]])
    truth = branches.ravel()
    for seed in range(400):
        starts = truth * [0.8, 0.7, 1.2, 1.4]
        study = cycles_of(tmp_path, starts, 0.01, seed, ALONE, KNOWN, branches)
        fitted = fit_problem(study.problem)
        assert fitted.converged
        assert np.all(fitted.certainty.std < 0.07 * fitted.values)
        inside += (fitted.certainty.low < truth) & (fitted.certainty.high > truth)
    assert np.all(abs(inside / 400 - 0.95) < 3.0 * np.sqrt(0.95 * 0.05 / 400)), inside


def test_stiffnesses_of_known_times_are_those_of_linear_regression(tmp_path):
    # T - T(e) = sum EA_k u_k(t): the best values, their spread and their profile are exact
    strain, time = loop(0.1, 30.0)
    unit = np.stack([history(strain, time, [(1.0, tau)]) for tau in (2.0, 50.0)], axis=1)
    load = unit @ [150e3, 90e3] + 400.0 * np.random.default_rng(3).standard_normal(time.size)
    write(tmp_path, "loop.csv", strain, time, tension(strain) + load)
    text = start_text([5e5, 1e4], NAMES[::2]) + experiment("loop", "400 N")
    text = text.replace("10000.0", "10000.0, profile = true")
    fitted = fit_problem(fit_of(tmp_path, text, SCENE).problem)
    best = np.linalg.lstsq(unit, load)[0]
    std = 400.0 * np.sqrt(np.diag(np.linalg.inv(unit.T @ unit)))
    assert fitted.values == pytest.approx(best, rel=1e-6)
    assert fitted.certainty.std == pytest.approx(std, rel=1e-6)
    (profile,) = with_profiles(fitted, [1]).profiles
    # the normal 97.5 % quantile
    assert (profile.low, profile.high) == pytest.approx(
        (best[1] - 1.95996 * std[1], best[1] + 1.95996 * std[1]), rel=1e-4
    )


def test_a_start_of_wrong_size_is_solved_for(tmp_path):
    # from stiffnesses a thousand times too large, which enter linearly
    fitted = fit_problem(cycles_of(tmp_path, [1.5e8, 1.0, 9e7, 400.0], 0.01, known=KNOWN).problem)
    assert fitted.converged
    assert np.all(abs(fitted.values - TRUTH) < 4.0 * fitted.certainty.std)


LINE = """
[materials.fibre]
law = "polynomial"
coefficients = ["400 kN", "2 MN"]
relaxation = {{ fast = {{ EA = "150 kN", time = 2 }}, slow = {{ EA = "90 kN", time = 30 }} }}
[lines.rope]
material = "fibre"
length = "10 m"
segments = 1
mass = "20 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {{ position = [11, 0, 0], amplitude = [0.4, 0, 0], period = "10 s" }} }}
[solver]
step = {step}
waves = "plain"
[output]
duration = "20 s"
every = "50 ms"
"""


def test_the_engine_carries_what_the_table_says(tmp_path):
    # an end moved at 11 m + 0.4 m sin(2 pi t / 10 s), of a line of 10 m: one segment, nothing swings
    time = 0.05 * np.arange(401)
    strain = 0.1 + 0.04 * np.sin(2.0 * np.pi * time / 10.0)
    exact = 4e5 * strain + 2e6 * strain**2 + history(strain, time, [(15e4, 2.0), (9e4, 30.0)])
    ran = run_text(tmp_path, LINE.format(step=0.005))
    assert ran.statuses == ["OK"]
    tensions = ran["start_tension"][0]
    # the chords of the table's rows, (w 0.05 s)^2 / 12 = 8e-5 of what the branches carry, 9 kN; the
    # engine's steps of 5 ms, a hundredth of that
    assert tensions == pytest.approx(exact, abs=8e-5 * 9e3)
    # which the law alone misses by the branches' thousands
    assert np.max(np.abs(exact - 4e5 * strain - 2e6 * strain**2)) > 5e3


def test_jumps_are_rows_of_one_time(tmp_path):
    # a length that is taken in at once and held: q = EA de exp(-t / tau)
    time = np.array([0.0, 0.0, *np.linspace(0.5, 30.0, 60)])
    strain = np.where(np.arange(62) == 0, 0.1, 0.15)
    load = tension(strain)
    load[1:] += 0.05 * sum(ea * np.exp(-time[1:] / tau) for ea, tau in BRANCHES)
    write(tmp_path, "jump.csv", strain, time, load)
    text = start_text([1e5, 1.0, 1e5, 20.0]) + experiment("jump")
    fitted = fit_problem(fit_of(tmp_path, text, SCENE).problem)
    assert fitted.values == pytest.approx(TRUTH, rel=1e-5)


def test_a_table_without_times_is_the_law_alone(tmp_path):
    # slow loads: a material that relaxes has them without its branches
    strain = np.linspace(0.01, 0.3, 30)
    write_bench(tmp_path, strain, tension(strain))
    names = measure(tmp_path)
    text = start_text([2e5, *TRUTH], ["materials.nylon.p1", *NAMES])
    text += BENCH + "".join(map(experiment, names))
    fitted = fit_problem(fit_of(tmp_path, text, SCENE).problem)
    assert fitted.values == pytest.approx([2.703e5, *TRUTH], rel=1e-6)
    assert fitted.predicted[0] == pytest.approx(tension(strain), rel=1e-6)


def test_a_table_with_times_of_what_does_not_relax_is_the_law_alone(tmp_path):
    strain, time = loop(0.1, 10.0)
    write(tmp_path, "loop.csv", strain, time, tension(strain))
    text = 'scene = "scene.toml"\n[free]\n"materials.nylon.p1" = { start = 2e5 }\n'
    fitted = fit_problem(fit_of(tmp_path, text + experiment("loop"), SCENE).problem)
    assert fitted.values == pytest.approx([2.703e5], rel=1e-9)


def test_numbers_of_one_test_alone(tmp_path):
    # another rope on another day: its own stiffness, the same times
    for name, factor in (("one", 1.0), ("two", 1.4)):
        strain, time = loop(0.1, 20.0)
        branches = BRANCHES * [[factor, 1.0], [1.0, 1.0]]
        write(
            tmp_path, f"{name}.csv", strain, time, tension(strain) + history(strain, time, branches)
        )
    text = start_text(TRUTH).replace("150000.0 }", "1e5, private = true }")
    fitted = fit_problem(
        fit_of(tmp_path, text + experiment("one") + experiment("two"), SCENE).problem
    )
    assert [p.name for p in fitted.problem.parameters[:2]] == [
        f"{NAMES[0]} [one]",
        f"{NAMES[0]} [two]",
    ]
    assert fitted.values == pytest.approx([150e3, 210e3, *TRUTH[1:]], rel=1e-5)


ONE_BRANCH = """
[choices.one]
set = { "materials.nylon.relaxation" = { only = { EA = 1e5, time = 10 } } }
free = { "materials.nylon.relaxation.only.EA" = {}, "materials.nylon.relaxation.only.time" = {} }
"""


def test_two_branches_are_chosen_before_one_where_they_made_the_data(tmp_path):
    study = cycles_of(tmp_path, TRUTH, 0.01, known=KNOWN, more=ONE_BRANCH)
    one = fit_problem(study.choices["one"])
    assert len(one.values) == 2
    assert one.converged
    assert fit_problem(study.problem).criteria.bic < one.criteria.bic - 10.0


def test_ropes_of_different_rows_are_what_they_are_alone(tmp_path):
    ropes = {"a": (1.0, 60), "b": (1.5, 83)}
    for name, (factor, points) in ropes.items():
        strain, time = loop(0.1, 30.0, points)
        load = tension(strain) + history(strain, time, BRANCHES * [factor, 1.0])
        write(tmp_path, f"coil-{name}.csv", strain, time, load)
    text = (
        'ropes = "*"\n' + start_text([1e5, 2.0, 1e5, 90.0]) + experiment("loop", "", "coil-{rope}")
    )
    study = fit_of(tmp_path, text, SCENE)
    for name, fitted in fit_ropes(study.ropes).items():
        assert fitted.converged
        exact = (BRANCHES * [ropes[name][0], 1.0]).ravel()
        assert fitted.values == pytest.approx(exact, rel=1e-5)
        assert fitted.predicted[0].size == ropes[name][1]


def test_what_is_left_behind_has_times_and_branches(tmp_path):
    fitted = fit_problem(cycles_of(tmp_path, 0.9 * TRUTH).problem)
    assert [p.label for p in fitted.problem.parameters] == [
        "nylon fast EA", "nylon fast time", "nylon slow EA", "nylon slow time",
    ]  # fmt: skip
    made, wrong = write_fit(fitted, {}, tmp_path / "out")
    assert wrong == []
    slow = load_study(made[0]).scene.materials["nylon"].relaxation["slow"]
    assert (slow.EA, slow.time) == pytest.approx((90e3, 60.0), rel=1e-6)
    series = json.loads(made[-1].read_text())["series"]
    for told, (strain, time) in zip(
        series, [loop(m, p) for _, m, p in LOOPS] + [hold()], strict=True
    ):
        assert told["time"] == pytest.approx(time)
        assert told["x"] == pytest.approx(strain)
    # what relaxes is no part of the law of slow loads, which the bench's points surround
    (band,) = law_bands(fitted)
    assert band.tension == pytest.approx(tension(band.strain), rel=1e-9)
    assert np.max(band.half) == 0.0


def test_loops_are_drawn_in_the_order_of_time(tmp_path):
    fitted = fit_problem(cycles_of(tmp_path, 0.9 * TRUTH).problem)
    figures = fit_figures(pictures_from(pictures_of(fitted)))
    assert list(figures)[:3] == ["data", "history", "residuals"]
    strain, time = loop(*LOOPS[0][1:])
    exact = tension(strain) + history(strain, time)
    for name, x in (("data", strain), ("history", time)):
        measured, model = figures[name].axes[0].lines
        assert model.get_xdata() == pytest.approx(x, rel=1e-9)
        assert model.get_ydata() == pytest.approx(exact / 1e3, rel=1e-5)
        assert measured.get_xdata() == pytest.approx(x, rel=1e-9)
    assert figures["residuals"].axes[0].get_xlabel() == "time (s)"
    assert figures["data"].axes[0].get_xlabel() == "strain (-)"


RECORD = """
[experiments.record]
file = "record.csv"
time = { column = "t (s)" }
observe = [{ quantity = "tension", at = "rope.start", column = "F (N)" }]
"""


@pytest.mark.slow
def test_what_relaxes_comes_back_from_a_record_of_a_run(tmp_path):
    """Of the engine's own run: the end of a line of three segments is moved within 1 s."""
    scene = LINE.format(step='"4 ms"').replace("segments = 1", "segments = 3")
    scene = (
        scene.replace('"10 s"', '"1 s"')
        .replace('"20 s"', '"2 s"')
        .replace("time = 2", "time = 0.3")
    )
    ran = run_text(tmp_path, scene)
    rows = zip(ran.time.tolist(), ran["start_tension"][0].tolist(), strict=True)
    (tmp_path / "record.csv").write_text(
        "t (s),F (N)\n" + "".join(f"{t!r},{f!r}\n" for t, f in rows)
    )
    text = """scene = "scene.toml"
[free]
"materials.fibre.relaxation.fast.EA" = { start = "100 kN" }
"materials.fibre.relaxation.fast.time" = { start = "0.6 s" }
"""
    fitted = fit_problem(fit_of(tmp_path, text + RECORD, scene).problem)
    assert fitted.converged
    assert fitted.values == pytest.approx([150e3, 0.3], rel=1e-6)


@pytest.mark.slow
def test_slopes_of_a_run_by_what_relaxes_are_those_of_differences(tmp_path):
    scene = LINE.format(step='"5 ms"').replace('"20 s"', '"0.3 s"').replace('"10 s"', '"1 s"')
    (tmp_path / "scene.toml").write_text(scene.replace("segments = 1", "segments = 4"))
    keys = [f"materials.fibre.relaxation.{b}.{k}" for b in ("fast", "slow") for k in ("EA", "time")]
    found = lc.response(tmp_path / "scene.toml", keys, "last tension at rope.start")
    slope = np.asarray(jax.grad(found)(found.values))
    for k in range(4):
        step = 1e-4 * found.values[k] * (np.arange(4) == k)
        difference = (found(found.values + step) - found(found.values - step)) / (2 * step[k])
        # h^2 / 6 of a third derivative of the size of the first, 2e-9, and rounding over h: 1e-12 of
        # the tension over 1e-4, beside changes of a tenth to a hundredth of it
        assert slope[k] == pytest.approx(float(difference), rel=1e-6)


@pytest.mark.parametrize(
    ("text", "rows", "said"),
    [
        (start_text(TRUTH) + experiment("loop"), "0,1,2\n2,2,3\n1,3,4\n",
         "experiments.loop.time: expected times that never fall, found 1 s after 2 s in loop.csv:4"),
        (start_text(TRUTH) + experiment("loop"), "0,2,3\n2,2,3\n3,2,4\n",
         "loop.strain: expected strains that change with time, found 0.02 alone in loop.csv: "
         "begin with a row at the strain where the material was at rest"),
        (start_text(TRUTH) + experiment("loop").replace('"time"', '"tiem"'), "0,1,2\n1,2,3\n2,2,3\n",
         'experiments.loop.time.column: expected a column of loop.csv, found "tiem"; it has time (s), '
         "strain (%), load (kN)"),
        (start_text(TRUTH) + experiment("loop").replace('"time" }', '"time", unit = "N" }'),
         "0,1,2\n1,2,3\n2,2,3\n",
         'experiments.loop.time.unit: expected a unit of a time (s), found "N"'),
        (start_text(TRUTH[:1], NAMES[:1]) + experiment("loop").replace('time = {', '# {'),
         "0,1,2\n1,2,3\n2,2,3\n",
         'expected a number that an experiment depends on, found "materials.nylon.relaxation.fast.EA", '
         "which a bench's table tells where it has a column of times: time = { column = ... }"),
        (start_text(TRUTH[:1], ["materials.nylon.damping"]).replace(
            "[free]", '"materials.nylon.damping" = "1 kN s"\n[free]') + experiment("loop"),
         "0,1,2\n1,2,3\n2,2,3\n", 'depends on, found "materials.nylon.damping"'),
        (start_text(TRUTH[:1], NAMES[:1]).replace("fast.EA", "fats.EA") + experiment("loop"),
         "0,1,2\n1,2,3\n2,2,3\n", 'found "materials.nylon.relaxation.fats.EA"'),
    ],
    ids=["falling", "never pulled", "misspelt", "unit", "without times", "damping", "no such branch"],
)  # fmt: skip
def test_a_mistake_is_told_with_its_place(tmp_path, text, rows, said):
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "loop.csv").write_text("time (s),strain (%),load (kN)\n" + rows)
    (tmp_path / "fit.toml").write_text(text)
    told = refused(tmp_path, "fit", "fit.toml")
    assert said in told
    assert all(line.startswith("fit.toml:") for line in told.splitlines())
