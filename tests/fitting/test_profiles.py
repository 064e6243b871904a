"""Profiles: straight where the model is, the true limits where it is not, open where nothing is told."""

from dataclasses import replace

import numpy as np
import pytest
from fit_files import BENCH, NAMES, SCENE, TRUTH, bench_of, fit_of, free, write_bench
from scipy.optimize import brentq, least_squares

from lumpedcable.fitting.profile import flagged, profile_of, untold, with_profiles
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import contents_of
from lumpedcable.fitting.run import fit_problem
from lumpedcable.fitting.write import pictures_of
from lumpedcable.view import plot_fit
from lumpedcable.view.fit import pictures_from

KNOWN = 'noise = "1 %"\n'


def polynomial(folder, strain, load, coefficients, more="", extra=""):
    """The fit of a polynomial's coefficients, which is linear."""
    write_bench(folder, strain, load)
    law = f'law = "polynomial"\ncoefficients = {coefficients}\n'
    scene = SCENE.replace(SCENE[: SCENE.index("[lines")], f"[materials.nylon]\n{law}\n")
    text = 'scene = "scene.toml"\n[free]\n'
    text += f'"materials.nylon.coefficients" = {{ {extra} }}\n'
    return fit_problem(fit_of(folder, text + BENCH + more, scene).problem)


@pytest.mark.parametrize("noise", ["", 'noise = "2 kN"\n'], ids=["found", "given"])
def test_the_profile_of_a_linear_law_is_its_linear_interval(tmp_path, noise):
    random = np.random.default_rng(3)
    strain = np.linspace(0.01, 0.3, 40)
    load = 5e5 * strain - 1e6 * strain**2 + 8e6 * strain**3 + 2e3 * random.standard_normal(40)
    fitted = polynomial(tmp_path, strain, load, [4e5, 1e5, 1e6], noise)
    for k in range(3):
        profile = profile_of(fitted, k)
        wanted = [fitted.certainty.low[k], fitted.certainty.high[k]]
        width = wanted[1] - wanted[0]
        assert [profile.low, profile.high] == pytest.approx(wanted, abs=1e-5 * width)
        # the root is (x - best) / std
        straight = (profile.x - fitted.values[k]) / fitted.certainty.std[k]
        assert profile.root == pytest.approx(straight, abs=1e-4)
        assert not profile.better


def test_the_limits_of_a_law_that_bends_are_those_of_the_sum_of_squares(tmp_path):
    # two numbers free, the other found by SciPy at every value of the first
    keys = [NAMES[1], NAMES[2]]
    study = bench_of(tmp_path, TRUTH, noise=0.05, more='noise = "5 %"\n')
    text = 'scene = "scene.toml"\n' + free(TRUTH[1:3], keys) + BENCH + 'noise = "5 %"\n'
    fitted = fit_problem(fit_of(tmp_path, text).problem)
    assert study.problem.points == 64
    (series,) = fitted.problem.series

    def left(p2, p3):
        p1, _, _, p4, p5 = TRUTH
        model = p1 * np.tanh(p2 * series.x + p3) + p4 + p5 * series.x
        return (model - series.values) / series.noise

    def least(p2):
        best = least_squares(lambda p: left(p2, p[0]), [fitted.values[1]], xtol=1e-12, ftol=1e-12)
        return 2.0 * best.cost

    profile, std = profile_of(fitted, 0), fitted.certainty.std[0]
    limit = fitted.loss + 1.959964**2
    best = fitted.values[0]
    low = brentq(lambda x: least(x) - limit, best - 4 * std, best)
    high = brentq(lambda x: least(x) - limit, best, best + 4 * std)
    assert [profile.low, profile.high] == pytest.approx([low, high], abs=2e-3 * (high - low))
    # and they do not lie evenly about the best value, as the linear ones do
    assert abs(profile.low + profile.high - 2 * best) > 10 * 2e-3 * (high - low)


def test_profiles_of_what_the_data_hardly_tell_come_by_themselves(tmp_path):
    study = bench_of(tmp_path, 1.2 * TRUTH, noise=0.01, more=KNOWN)
    fitted = with_profiles(fit_problem(study.problem))
    (profile,) = fitted.profiles
    assert fitted.problem.parameters[profile.parameter].key == NAMES[4]
    assert profile.low < TRUTH[4] < profile.high
    told = contents_of(fitted)["profiles"][0]
    assert told["interval"] == [profile.low, profile.high]
    # asked for, and asked not to
    text = 'scene = "scene.toml"\n' + free(TRUTH).replace("} }", "}")
    text = text.replace("10.2 }", "10.2, profile = true }").replace(
        "135.5 }", "135.5, profile = false }"
    )
    asked = fit_problem(fit_of(tmp_path, text + BENCH + KNOWN).problem)
    assert flagged(asked) == [1]


def test_a_number_that_is_told_of_by_a_sum_alone_is_open_but_for_its_bound(tmp_path):
    # c1 0.1 + c2 0.01 is all that is seen
    strain, load = np.array([0.1, 0.1, 0.1]), np.array([1e4, 1.1e4, 0.9e4])
    fitted = polynomial(tmp_path, strain, load, [1e5, 1e5])
    profile = profile_of(fitted, 0)
    assert (profile.low, profile.high) == (-np.inf, np.inf)
    bounded = polynomial(tmp_path, strain, load, [5e4, 4e5], extra='low = 0, high = "1 MN"')
    profile = profile_of(bounded, 0)
    # c2 is at least 0, so that c1 is not far above 1e5; and c1 itself ends at 0
    assert profile.low == pytest.approx(0.0, abs=1.0)
    # with c2 = 0 the sum of squares rises by 3 (0.1 c1 - 10 kN)^2; s^2 = 2 kN^2 / (3 - 2), and the reach
    # is Student's t with 1 degree of freedom, 12.7062
    assert profile.high == pytest.approx(1e5 + 12.7062 * np.sqrt(2e6 / 3) / 0.1, rel=2e-3)


@pytest.mark.parametrize(
    ("strain", "load", "first"),
    [(0.05, 8e4, 8e4 / 0.05), (0.0, 0.0, np.inf)],
    ids=["sum", "nothing"],
)
@pytest.mark.filterwarnings("error")
def test_data_without_noise_leave_open_what_they_do_not_tell(tmp_path, strain, load, first):
    rows = np.full(6, strain), np.full(6, load)
    fitted = with_profiles(polynomial(tmp_path, *rows, [4e5, 1e5]))
    sure = fitted.certainty
    assert sure.noise < 1e-15
    assert np.all(sure.std == np.inf)
    assert np.all(sure.low == -np.inf)
    assert np.all(sure.high == np.inf)
    assert np.max([c.spread for c in sure.combinations]) == np.inf
    assert untold(fitted) == {0, 1}
    assert "at all" in " ".join(remarks_of(fitted))
    plot_fit(pictures_from(pictures_of(fitted)), tmp_path)  # without a warning
    # neither is below 0, so that none is more than what makes the load by itself
    bounded = polynomial(tmp_path, *rows, [4e5, 1e5], extra="low = 0")
    profile = profile_of(bounded, 0)
    assert profile.low == pytest.approx(0.0, abs=1.0)
    assert bounded.values[0] < profile.high <= first * (1.0 + 1e-6)


def test_a_single_strain_tells_no_number_and_rounding_is_no_better_fit(tmp_path):
    write_bench(tmp_path, np.full(30, 0.05), np.full(30, 1e5))
    text = 'scene = "scene.toml"\n' + free(1.4 * TRUTH) + BENCH + KNOWN
    fitted = with_profiles(fit_problem(fit_of(tmp_path, text).problem))
    # one number is told of five: what is left is rounding of the one tension
    assert fitted.loss < 1e-20
    assert fitted.profiles
    assert not any(one.better for one in fitted.profiles)
    assert not any("better fit" in said for said in remarks_of(fitted))
    assert untold(fitted) == {0, 1, 2, 3, 4}


def test_a_number_with_a_wide_interval_is_not_told(tmp_path):
    # c1 and c2 of two strains: by 100 N/sqrt(2)/0.01 and that over 0.3, 7 and 24 %
    strain = np.array([0.01, 0.01, 0.3, 0.3])
    fitted = polynomial(tmp_path, strain, 1e5 * (strain + strain**2), [9e4, 9e4], "noise = 100\n")
    assert untold(fitted) == set()
    high = fitted.certainty.low + np.array([99e5, 101e5])
    wide = replace(fitted, certainty=fitted.certainty._replace(high=high))
    assert untold(wide) == {1}
    # of an interval that failed runs leave open the data say nothing
    open_ = wide.certainty._replace(high=np.array([np.inf, np.inf]))
    failing = profile_of(fitted, 0)._replace(failed=(False, True))
    assert untold(replace(wide, certainty=open_, profiles=(failing,))) == {1}
