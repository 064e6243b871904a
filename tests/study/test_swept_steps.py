"""A sweep over how time is stepped: every run has its own step, as it would have it alone."""

import numpy as np
import pytest
from engine_runs import HOOKE, run_text

SOLVER = "\n[solver]\n{}\n"


def alone_and_together(tmp_path, key, values, solver=""):
    """Velocities of runs with each value alone, and the sweep over them."""
    text = HOOKE + (SOLVER.format(solver) if solver else "")
    single = [run_text(tmp_path, text, f"{key}={v!r}") for v in values]
    swept = run_text(tmp_path, text, f"{key}={list(values)!r}")
    return [ran["velocity"][0] for ran in single], swept


@pytest.mark.parametrize(
    ("key", "values", "solver"),
    [
        ("solver.courant", (0.2, 0.9), ""),
        ("solver.step", (1e-4, 2e-5), ""),
        pytest.param("solver.step", (1e-4, 2e-5), 'method = "rk4"', marks=pytest.mark.slow),
        pytest.param("solver.courant", (0.1, 0.5), 'method = "tsit5"', marks=pytest.mark.slow),
        pytest.param("solver.rtol", (1e-2, 1e-7), 'method = "tsit5"', marks=pytest.mark.slow),
        pytest.param(
            "solver.atol", (1e-1, 1e-7), 'method = "tsit5"\nrtol = 1e-7', marks=pytest.mark.slow
        ),
    ],
)
def test_each_run_of_a_sweep_is_the_run_alone(tmp_path, key, values, solver):
    alone, swept = alone_and_together(tmp_path, key, values, solver)
    scale = np.max(np.abs(alone[0]))
    for mine, its in zip(swept["velocity"], alone, strict=True):
        np.testing.assert_allclose(mine, its, atol=1e-9 * scale)
    # and they do differ
    assert np.max(np.abs(alone[0] - alone[1])) > 1e-6 * scale
    if key == "solver.step":
        steps = [outcome.solver_step for outcome in swept.outcomes]
        assert steps == pytest.approx(values, rel=1e-12)
