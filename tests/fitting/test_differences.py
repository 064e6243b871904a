"""Derivatives beside differences: told where a change of the size that people make goes otherwise."""

import numpy as np
import pytest

from lumpedcable.fitting.difference import checked


def check_of(result, share):
    """Of a result of (x, y) at (2, 3), whose relative derivative by x is said to be `share`."""
    at = np.array([2.0, 3.0])
    shares = np.array([share, 0.25 * share])
    return checked(("x", "y"), at, shares, result(at), result)


def test_a_power_changes_as_its_derivative_says():
    check = check_of(lambda v: v[0] ** 3 * v[1], 3.0)
    assert (check.key, check.steps, check.good, check.close) == ("x", (1e-3,), True, True)
    # ((1 + h)^3 - (1 - h)^3) / 2h = 3 + h^2
    assert check.differences == pytest.approx([3.0 + 1e-6], rel=1e-12)
    assert str(check) == "By x the derivative is +3 % per %, a difference over ±0.1 % +3."


def test_a_wrong_derivative_is_told_with_both_figures():
    check = check_of(lambda v: v[0] ** 3, -3e9)
    assert not check.close
    assert len(check.differences) == 2
    assert str(check) == (
        "By x the derivative is -3e+09 % per %, a difference over ±0.1 % +3 and over ±0.001 % +3: "
        "derivatives of this size do not foretell here what a change does."
    )


def test_a_ripple_is_met_by_the_smaller_step_alone():
    # 1 + a sin(k (x/2 - 1)): its slope at 2 is a k per relative change, over steps of 1e-3 and
    # 1e-5 the difference a sin(k h) / h
    a, k = 1e-3, 3e3
    check = check_of(lambda v: 1.0 + a * np.sin(k * (0.5 * v[0] - 1.0)), a * k)
    assert check.differences == pytest.approx([np.sin(3.0), np.sin(0.03) * 100.0], rel=1e-9)
    assert (check.good, check.close) == (False, True)
    assert str(check).endswith("the derivatives hold for very small changes alone.")


def test_a_run_that_fails_beside_is_no_number():
    check = check_of(lambda v: v[0] if v[0] <= 2.0 else np.nan, 1.0)
    assert not check.close
    assert "over ±0.1 % none (a run fails)" in str(check)
