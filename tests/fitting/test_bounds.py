"""What is told of numbers at a bound and of the others, of runs that fail and of too few values."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from command_line import say
from fit_files import BENCH, SCENE, fit_of, write_bench
from scipy.optimize import brentq, minimize

from lumpedcable.fitting.profile import flagged, with_profiles
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import contents_of, print_fit
from lumpedcable.fitting.ropes import fit_ropes
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.uncertainty import Profile, certainty_of
from lumpedcable.fitting.write import pictures_of
from lumpedcable.view import plot_fit
from lumpedcable.view.fit import fit_figures, pictures_from

STRAIN, LOAD = np.array([0.05, 0.1, 0.15, 0.2]), np.array([26e3, 50.4e3, 74.2e3, 98.6e3])
KNOWN = 'noise = "1 kN"\n'
NORMAL = 1.959964
POLYNOMIAL = 'law = "polynomial"\ncoefficients = ["400 kN", "200 kN"]\n'
LINEAR = 'law = "linear"\nEA = "400 kN"\n'
TOO_LOW = '"materials.nylon.EA" = { high = "490 kN" }'


def written(folder, law, free, more=KNOWN, rows=4):
    """The fit of a law of the nylon rope to the first rows of the table."""
    write_bench(folder, STRAIN[:rows], LOAD[:rows])
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    return fit_of(folder, f'scene = "scene.toml"\n[free]\n{free}\n{BENCH}{more}', scene)


def bent(folder, more, bound="low = 0"):
    """Both coefficients of c0 e + c1 e^2, of which c1 would be negative."""
    keys = [f'"materials.nylon.coefficients.{k}"' for k in range(2)]
    free = f"{keys[0]} = {{}}\n{keys[1]} = {{ {bound} }}"
    return fit_problem(written(folder, POLYNOMIAL, free, more).problem)


def light(folder, strain, load, first, second='start = "40 N", low = "0 N"', more="", noise="20 N"):
    """The fit of c0 e + c1 e^2 to tensions of some newtons."""
    write_bench(folder, strain, load)
    law = "[materials.nylon]\n" + POLYNOMIAL + "max_strain = 2.0\n"
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], law)
    keys = [f'"materials.nylon.coefficients.{k}"' for k in range(2)]
    free = f"[free]\n{keys[0]} = {{ {first} }}\n{keys[1]} = {{ {second} }}\n"
    return fit_of(folder, f'scene = "scene.toml"\n{free}{BENCH}noise = "{noise}"\n{more}', scene)


@pytest.mark.parametrize("bound", ["low = 0", 'low = 0, high = "10 MN"'], ids=["one", "two"])
def test_a_number_at_its_lower_bound_leaves_the_others_what_they_are(tmp_path, bound):
    fitted = with_profiles(bent(tmp_path, KNOWN, bound))
    assert fitted.at_bound == (False, True)
    # c1 = 0: a straight line through zero
    square = STRAIN @ STRAIN
    assert fitted.values[0] == pytest.approx(STRAIN @ LOAD / square, rel=1e-6)
    assert fitted.certainty.std[0] == pytest.approx(1e3 / np.sqrt(square), rel=1e-5)
    # its own is that of both left free
    matrix = np.stack([STRAIN, STRAIN**2], axis=1)
    own = 1e3 * np.sqrt(np.linalg.inv(matrix.T @ matrix)[1, 1])
    assert fitted.certainty.std[1] == pytest.approx(own, rel=1e-5)
    assert fitted.certainty.low[1] == 0.0
    assert "Held at its bound for the intervals of the others: nylon coefficients 1." in remarks_of(
        fitted
    )

    def least(c1):
        left = LOAD - c1 * STRAIN**2
        return np.sum((left - STRAIN * (STRAIN @ left) / square) ** 2) / 1e6

    (profile,) = fitted.profiles
    high = brentq(lambda c1: least(c1) - least(0.0) - NORMAL**2, 0.0, 1e6)
    assert [profile.low, profile.high] == pytest.approx([0.0, high], abs=2e-3 * high)
    assert not profile.better


def test_the_noise_is_found_from_what_the_numbers_away_from_their_bounds_leave(tmp_path):
    """With c1 held at 0 the spread of c0 is that of a straight line alone: three degrees of freedom."""
    fitted = bent(tmp_path, "")
    assert fitted.at_bound == (False, True)
    square = STRAIN @ STRAIN
    best = STRAIN @ LOAD / square
    noise = np.sqrt(np.sum((LOAD - best * STRAIN) ** 2) / 3)
    assert fitted.certainty.std[0] == pytest.approx(noise / np.sqrt(square), rel=1e-5)
    # Student's t with 3 degrees of freedom, 97.5 %: 3.1824 (tables)
    reach = (fitted.certainty.high[0] - fitted.values[0]) / fitted.certainty.std[0]
    assert reach == pytest.approx(3.1824, abs=1e-4)


def test_a_number_at_its_upper_bound_has_a_profile_below_it(tmp_path):
    study = written(tmp_path, LINEAR, TOO_LOW)
    fitted = with_profiles(fit_problem(study.problem))
    assert fitted.at_bound == (True,)
    square = STRAIN @ STRAIN
    assert fitted.certainty.std[0] == pytest.approx(1e3 / np.sqrt(square), rel=1e-5)
    # S is a parabola about the best line, whose EA is larger than 490 kN
    best = STRAIN @ LOAD / square
    low = best - np.sqrt((best - 490e3) ** 2 + NORMAL**2 * 1e6 / square)
    (profile,) = fitted.profiles
    assert [profile.low, profile.high] == pytest.approx([low, 490e3], abs=2e-3 * (490e3 - low))
    assert not any("better fit" in words or "not tell" in words for words in remarks_of(fitted))
    said = say(tmp_path, "fit", "fit.toml", "-o", "out")
    assert said.code == 0, said.err
    assert (tmp_path / "out" / "profiles.png").exists()


@pytest.mark.parametrize("high", ["110 N", "110.5 N"])
@pytest.mark.parametrize("low", ['low = "0 N", ', ""], ids=["two", "one"])
def test_a_number_far_out_at_its_bound_has_the_spread_of_all_left_free(tmp_path, low, high):
    # the search for it runs so far out that its own derivatives fade away: exp(-853)
    strain = np.linspace(0.1, 1.0, 8)
    load = np.array([-5.54, -1.02, 37.12, 68.78, 103.02, 104.07, 114.06, 134.3])
    study = light(tmp_path, strain, load, f'start = "60 N", {low}high = "{high}"')
    fitted = fit_problem(study.problem)
    assert fitted.at_bound == (True, False)
    matrix = np.stack([strain, strain**2], axis=1)
    own = 20.0 * np.sqrt(np.linalg.inv(matrix.T @ matrix)[0, 0])
    assert fitted.certainty.std[0] == pytest.approx(own, rel=1e-6)
    assert contents_of(fitted)["parameters"][0]["std"] == pytest.approx(own, rel=1e-6)


SPREAD_STRAIN = np.linspace(0.1, 1.0, 12)
SPREAD = [
    92.52882440508608, 2.5133623194058075, 29.00188104703636, 28.88013695976739, 125.5624909602109,
    58.987710362272736, 69.41645306053708, 95.43461114981389, 183.29062788405287, 112.71725766760783,
    138.06745264573644, 158.29855307061325,
]  # fmt: skip
SPREAD = np.array(SPREAD)
FIRST, AWAY, CAUCHY = (
    'start = "10 N"',
    'start = "99 N", high = "100 N"',
    '[method]\nloss = "cauchy"\n',
)


def spread(folder, more=""):
    """Both coefficients of values so spread that a search for them comes to a bound on its way."""
    return light(folder, SPREAD_STRAIN, SPREAD, FIRST, AWAY, CAUCHY + more, "10 N")


def inner_minimum():
    """Where the cauchy loss is least, and how large, by a search without derivatives or bounds."""

    def loss(c):
        r = (c[0] * SPREAD_STRAIN + c[1] * SPREAD_STRAIN**2 - SPREAD) / 10.0
        return 1.5**2 * np.sum(np.log1p((r / 1.5) ** 2))

    end = minimize(
        loss, (60.0, 80.0), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-13}
    )
    assert end.x[1] < 95.0  # and so between the bounds
    return end


def test_a_search_that_stalls_at_a_bound_goes_on_to_the_minimum_inside(tmp_path):
    best = inner_minimum()
    fitted = fit_problem(spread(tmp_path).problem)
    assert fitted.values == pytest.approx(best.x, rel=1e-4)
    assert fitted.loss == pytest.approx(best.fun, rel=1e-8)
    assert fitted.converged
    assert fitted.at_bound == (False, False)


def test_so_does_that_of_one_of_many_ropes(tmp_path):
    best = inner_minimum()
    spread(tmp_path)
    write_bench(tmp_path, SPREAD_STRAIN, SPREAD, "wide.csv")
    write_bench(tmp_path, SPREAD_STRAIN, 60.0 * SPREAD_STRAIN + 50.0 * SPREAD_STRAIN**2, "even.csv")
    text = (tmp_path / "fit.toml").read_text().replace("bench.csv", "{rope}.csv")
    text = text.replace("[free]", 'ropes = ["wide", "even"]\n[free]', 1)
    fits = fit_ropes(fit_of(tmp_path, text, (tmp_path / "scene.toml").read_text()).ropes)
    assert fits["wide"].values == pytest.approx(best.x, rel=1e-4)
    assert fits["wide"].converged
    assert fits["even"].values == pytest.approx([60.0, 50.0], rel=1e-6)


def test_a_search_that_stays_at_such_a_bound_has_not_converged_and_says_so(tmp_path, monkeypatch):
    # without the second search, which finds the way on
    monkeypatch.setattr(
        "lumpedcable.fitting.seek._off_bounds", lambda problem, spec, once, found, arrays: found
    )
    fitted = fit_problem(spread(tmp_path, "starts = 1\n").problem)
    assert fitted.stalled == (False, True)
    assert not fitted.converged
    told = "Ended at a bound from which the loss falls inwards: nylon coefficients 1; give other starts"
    assert sum(words.startswith(told) for words in remarks_of(fitted)) == 1
    assert contents_of(fitted)["status"] == "not converged"
    # a bound that holds is none of these
    assert fit_problem(written(tmp_path, LINEAR, TOO_LOW).problem).stalled == (False,)


def test_a_profile_of_the_best_value_alone_is_not_drawn(tmp_path):
    fitted = fit_problem(written(tmp_path, LINEAR, '"materials.nylon.EA" = {}').problem)
    best, open_ = np.array(fitted.values), float(np.inf)
    # what is left where runs fail either way
    alone = Profile(0, best, np.zeros(1), NORMAL, -open_, open_, False, 9, (True, True))
    fitted = replace(fitted, profiles=(alone,))
    made = plot_fit(pictures_from(pictures_of(fitted)), tmp_path, ("svg",))
    assert "profiles.svg" not in [path.name for path in made]
    # points that are no numbers, or coincide, or are too small to have others between them
    for x in ([best[0], best[0]], [best[0], np.inf], [1e-310, 2e-310]):
        odd = replace(fitted, profiles=(alone._replace(x=np.array(x), root=np.array([0.0, 1.0])),))
        assert "profiles" not in fit_figures(pictures_from(pictures_of(odd)))
    assert sum("Runs fail with nylon EA" in words for words in remarks_of(fitted)) == 2


def test_ropes_have_the_profiles_that_are_asked_for(tmp_path):
    for name, share in (("stiff", 1.0), ("soft", 0.9)):
        write_bench(tmp_path, STRAIN, share * LOAD, f"{name}.csv")
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{LINEAR}\n")
    bench = BENCH.replace("bench.csv", "{rope}.csv") + KNOWN
    text = 'scene = "scene.toml"\nropes = "*"\n[free]\n"materials.nylon.EA" = { high = "490 kN"'
    square = STRAIN @ STRAIN
    best, std = STRAIN @ LOAD / square, 1e3 / np.sqrt(square)
    # at the upper bound: S is a parabola about the best line beyond it
    rise = np.sqrt((best - 490e3) ** 2 + (NORMAL * std) ** 2)
    soft = [0.9 * best - NORMAL * std, 0.9 * best + NORMAL * std]
    wanted = {"stiff": [best - rise, 490e3], "soft": soft}
    asked = fit_ropes(fit_of(tmp_path, f"{text}, profile = true }}\n{bench}", scene).ropes)
    for name, fitted in asked.items():
        found = [fitted.certainty.low[0], fitted.certainty.high[0]]
        assert found == pytest.approx(wanted[name], abs=2e-3 * std)
        assert len(fitted.profiles) == 1
    # without, they are linear, and end at a bound
    plain = fit_ropes(fit_of(tmp_path, f"{text} }}\n{bench}", scene).ropes)["stiff"]
    assert not plain.profiles
    assert plain.certainty.low[0] == pytest.approx(490e3 - NORMAL * std, rel=1e-6)
    assert plain.certainty.high[0] == 490e3


def test_a_start_far_above_a_bound_does_not_bring_the_end_to_it(tmp_path):
    study = written(tmp_path, LINEAR, '"materials.nylon.EA" = { start = "10 GN", low = 0 }')
    fitted = fit_problem(study.problem)
    assert fitted.values[0] == pytest.approx(STRAIN @ LOAD / (STRAIN @ STRAIN), rel=1e-6)
    assert fitted.at_bound == (False,)


def test_as_many_values_as_numbers_say_nothing_of_the_noise(tmp_path):
    free = '"materials.nylon.coefficients" = {}'
    fitted = fit_problem(written(tmp_path, POLYNOMIAL, free, "", rows=2).problem)
    assert np.all(np.isinf(fitted.certainty.std))
    assert np.all(fitted.certainty.low == -np.inf)
    assert "Give the noise for intervals." in remarks_of(fitted)[0]
    assert not flagged(fitted)
    # with the noise given they are those of linear regression
    known = fit_problem(written(tmp_path, POLYNOMIAL, free, rows=2).problem)
    matrix = np.stack([STRAIN[:2], STRAIN[:2] ** 2], axis=1)
    std = 1e3 * np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    assert known.certainty.std == pytest.approx(std, rel=1e-5)


def test_smoothness_leaves_the_values_that_it_does_not_use_for_the_noise(tmp_path):
    # 21 tensions, 20 values: their number says that nothing is left, the smoothness that much is
    strain = np.linspace(0.01, 0.32, 20)
    load = 1.2e6 * strain + 2e3 * np.random.default_rng(4).standard_normal(20)
    write_bench(tmp_path, strain, load)
    places = np.linspace(0.0, 0.32, 21).round(3).tolist()
    law = f'law = "table"\nstrain = {places}\ntension = {[1.1e6 * e for e in places]}\n'
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    free = '"materials.nylon.tension" = { smooth = 1e-6 }'
    text = f'scene = "scene.toml"\n[free]\n{free}\n{BENCH}noise = "2 kN"\n'
    fitted = fit_problem(fit_of(tmp_path, text, scene).problem)
    # as smooth as that it is a straight line: two numbers (one, where it must go through zero)
    line = fitted.certainty.effective
    assert line == pytest.approx(round(line), abs=1e-3)
    assert 1 <= round(line) <= 2
    assert fitted.sampled == 0  # nor does the search look elsewhere for what explains more
    square = np.sum(fitted.deviation**2)
    assert fitted.certainty.factor == pytest.approx(np.sqrt(square / (20 - line)), rel=1e-6)
    assert contents_of(fitted)["left_over"] == pytest.approx(1.0, abs=0.5)


def test_the_interval_of_many_values_needs_no_more_memory_than_they_do():
    random = np.random.default_rng(0)
    slope, left = random.standard_normal((4000, 2)), random.standard_normal(4000)
    tracemalloc.start()
    sure = certainty_of(np.ones(2), slope, left, 4000, True, 0.95)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert sure.std == pytest.approx(np.sqrt(np.diag(np.linalg.inv(slope.T @ slope))))
    assert peak < 20 * slope.nbytes  # 4000 by 4000 would be 2000 times as much


TANH = """[materials.nylon]
law = "tanh"
p1 = "270.3 kN"
p2 = 10.2
p3 = -2.128
p4 = "190 kN"
p5 = 0
[lines.rope]
material = "nylon"
length = "20 m"
segments = 2
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = { held = { pretension = "450 kN", direction = [1, 0, 0] } }
[output]
"""


def end_of(p4):
    """Where a pull of 450 kN takes the end of that rope without weight (m): tanh turned round."""
    return 20.0 * (1.0 + (np.arctanh((450e3 - p4) / 270.3e3) + 2.128) / 10.2)


@pytest.mark.slow
def test_a_profile_goes_up_to_where_runs_fail_and_says_so(tmp_path):
    noise = np.random.default_rng(0).standard_normal(20)
    places = end_of(190e3) + 15.0 * (noise - noise.mean())
    rows = [f"{0.02 * k:.2f},{x!r}" for k, x in enumerate(places.tolist())]
    (tmp_path / "rest.csv").write_text("t (ms),x (m)\n" + "\n".join(rows) + "\n")
    text = (
        'scene = "scene.toml"\n[free]\n"materials.nylon.p4" = { profile = true }\n'
        '[experiments.rest]\nfile = "rest.csv"\ntime = { column = "t (ms)" }\n'
        'observe = [{ quantity = "position", at = "rope.end", component = "x", column = "x (m)", '
        'noise = "15 m" }]\n'
    )
    fitted = with_profiles(fit_problem(fit_of(tmp_path, text, TANH).problem))
    (profile,) = fitted.profiles
    # the mean of 20 ends is known to 15 m / sqrt(20)
    way = NORMAL * 15.0 / np.sqrt(20.0)
    high = brentq(lambda p4: end_of(190e3) - end_of(p4) - way, 190e3, 720e3)
    assert profile.high == pytest.approx(high, abs=2e-3 * (high - 181e3))
    # below 450 kN - p1 the law has no such tension; shortly above its strain is more than max_strain
    assert profile.low == -np.inf
    assert profile.failed == (True, False)
    edge = brentq(lambda p4: end_of(p4) / 20.0 - 1.5, 450e3 - 270.2e3, 190e3)
    assert edge < profile.x[0] < edge + 0.02 * (190e3 - edge)
    assert any("Runs fail with nylon p4 below 181" in words for words in remarks_of(fitted))


def test_a_number_at_its_bound_is_told_as_that(tmp_path, capsys):
    print_fit(bent(tmp_path, KNOWN))
    row = next(r for r in capsys.readouterr().out.splitlines() if "at its bound" in r)
    assert row.split()[5:7] == ["0", "N"]
