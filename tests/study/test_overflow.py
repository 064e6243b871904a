"""Numbers so large that forces overflow: told as a failure of that run, whatever the others do."""

import numpy as np
from engine_runs import fixed, line_text, run_text

HANGING = (
    'gravity = 9.81\nmaterials.soft = { law = "linear", EA = "1 MN", tension_only = true }\n'
    + line_text("rope", "soft", 10, 10, 1, fixed(0, 0, 0), fixed(8, 0, 0))
    + '[output]\nduration = "20 ms"\nevery = "10 ms"\n'
)


def test_a_length_beyond_all_measure_fails_alone(tmp_path):
    """1e100 m overflow in the strains, 1e300 m in the residual and in what it is measured by."""
    ran = run_text(tmp_path, HANGING, "lines.rope.length=[12, 1e100, 1e300]")
    failed = "STATICS_NOT_CONVERGED"
    assert ran.statuses == ["OK", failed, failed]
    assert np.isfinite(ran["rope.end_tension"][0]).all()


def test_a_weight_beyond_all_measure_is_no_rest(tmp_path):
    assert run_text(tmp_path, HANGING, "lines.rope.mass=1e200").statuses == [
        "STATICS_NOT_CONVERGED"
    ]
