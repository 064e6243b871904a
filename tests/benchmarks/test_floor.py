"""What a front one segment wide costs, against what can be said by hand."""

import numpy as np
import pytest

from benchmarks.floor import averaged, floor, table
from benchmarks.measures import FINE, Histories


def test_the_mean_of_a_step_is_a_ramp_of_that_width():
    time = np.arange(0.0, 0.1, 1e-4)
    step = np.where(time < 0.05, 3.0, 1.0)
    found = averaged(time, step, 4e-3)
    # the step itself is linear over a sample, from 49.9 to 50 ms
    np.testing.assert_allclose(
        found, 2.0 - 2.0 * np.clip((time - 0.04995) / 4e-3, -0.5, 0.5), atol=3e-2
    )
    assert found[0] == pytest.approx(3.0)
    assert found[-1] == pytest.approx(1.0)


def test_the_error_of_a_step_is_the_root_of_a_twelfth_of_the_width():
    # a step from 1 to 0 at t0 made a ramp of width w: the square of the difference integrates to w / 12,
    # that of the step to t0
    time = np.arange(0.0, 0.2 + FINE / 2, FINE)
    front = 0.06
    step = np.where(time < front - FINE / 4, 1.0, 0.0)
    truth = Histories(time, step, 0.0 * step, 1.0, front)
    for segments in (6, 12):
        width = front / segments
        assert floor(truth, segments) == pytest.approx(np.sqrt(width / 12 / front), rel=2e-2)


def test_every_case_is_there():
    rows = table().splitlines()
    numbers = [float(x) for row in rows[2:] for x in row.replace("/", "|").split("|")[2:-1]]
    # four pretensions, four meshes, two kinds of break
    assert len(numbers) == 32
    assert min(numbers) > 0.0
