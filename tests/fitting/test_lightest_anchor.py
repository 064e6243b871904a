"""The lightest anchor that stops the ship of configs/restraint.toml in time, by derivatives."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_text, study_of

from lumpedcable.fitting.design import least_design, read_limit

SCENE = Path(__file__).parents[2] / "configs" / "restraint.toml"
MASS, VOLUME = "bodies.anchor.mass", "bodies.anchor.volume"
# two chains of 60 mm, R4 (Liu et al. 2018, table 1)
PROOF = 2 * 2709


@pytest.mark.slow
def test_the_lightest_anchor_that_stops_the_ship_in_time(tmp_path):
    # on a bed that is damped: links that rattle on one that is not make every small change a large one
    text = SCENE.read_text().split("[[sweep.cases]]")[0]
    more = ("output.duration=20.4 s", 'output.precision="float64"', "seabed.damping=1 kPa s")
    study = study_of(tmp_path, text, *more)
    limits = (
        "last displacement at ship in x <= 25 m",
        f"peak tension at chain.start <= {PROOF} kN",
    )
    found = least_design(study, MASS, tuple(read_limit(x, study) for x in limits), along=(VOLUME,))
    assert found.decides == 0
    # between the paper's cases 1 and 4, of 40 and 50 t
    assert 40e3 < found.value < 50e3
    # derivatives through the stop against what the last two trials, some kilograms apart, differ by
    before, last = found.trials[-2:]
    difference = np.subtract(last.values, before.values) / (last.number - before.number)
    mean = 0.5 * np.add(last.slopes, before.slopes)
    assert mean[0] == pytest.approx(difference[0], rel=1e-3)
    # the engine's own run with that anchor stops there, and its chain holds
    volume = found.value * 16.8 / 40e3
    ran = run_text(tmp_path, text, *more, f"{MASS}={found.value} kg", f"{VOLUME}={volume} m3")
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].stop_distance == pytest.approx(25.0, abs=5e-3)
    assert last.values[1] < PROOF * 1e3
