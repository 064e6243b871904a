"""Intervals are told with as many digits as they have, and that profiles find them wider is said."""

from dataclasses import replace

import numpy as np
import pytest
from fit_files import BENCH, NAMES, TRUTH, bench_of, fit_of, free

from lumpedcable.fitting.profile import departing, with_profiles
from lumpedcable.fitting.remarks import remarks_of
from lumpedcable.fitting.report import _digits, _values
from lumpedcable.fitting.run import fit_problem


def fitted_bench(folder):
    bench_of(folder, TRUTH, noise=0.02)
    text = 'scene = "scene.toml"\n' + free(TRUTH[1:3], NAMES[1:3]) + BENCH + 'noise = "2 %"\n'
    return fit_problem(fit_of(folder, text).problem)


def test_a_profile_that_is_wider_than_its_deviation_says_is_told(tmp_path):
    fitted = with_profiles(fitted_bench(tmp_path), [0])
    assert departing(fitted) is None
    assert not any("no parabola" in words for words in remarks_of(fitted))
    std = fitted.certainty.std / np.array([3.0, 1.0])
    rugged = replace(fitted, certainty=fitted.certainty._replace(std=std))
    assert departing(rugged) == (0, pytest.approx(3.0, rel=0.05))
    (said,) = (words for words in remarks_of(rugged) if "no parabola" in words)
    assert said.startswith(f"The profile of {fitted.problem.parameters[0].label} is 3")
    assert departing(with_profiles(rugged, [0, 1])) is None  # all have theirs


def test_an_interval_has_digits_enough_to_hold_the_value(tmp_path):
    fitted = fitted_bench(tmp_path)
    sure = fitted.certainty
    std = 1e-6 * np.abs(fitted.values)
    low, high = fitted.values - 2.0 * std, fitted.values + 2.0 * std
    sharp = replace(fitted, certainty=sure._replace(std=std, low=low, high=high))
    table = _values(sharp)
    found, interval = (next(iter(table.columns[k].cells)) for k in (2, 4))
    lower, upper = (float(text.split()[0]) for text in interval.split(" to "))
    value = float(found.split()[0])
    assert lower < value < upper
    assert upper - lower == pytest.approx(4e-6 * value, rel=0.1)


@pytest.mark.parametrize(
    ("value", "std", "digits"),
    [
        (100.53, 2.4e-3, 7),
        (1.0, 0.3, 4),
        (0.0, 1.0, 4),
        (5.0, 0.0, 4),
        (5.0, np.inf, 4),
        (1.0, 1e-30, 12),
    ],
)
def test_digits_go_by_the_deviation(value, std, digits):
    assert _digits(value, std, 4) == digits
