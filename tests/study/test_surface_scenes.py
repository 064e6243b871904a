"""The scenes of configs/surface do what their first lines say."""

from pathlib import Path

import numpy as np
import pytest
from engine_runs import run_scenes

from lumpedcable.exact import release_wave
from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.known_waves import curve_of

SCENES = Path(__file__).parents[2] / "configs" / "surface"


@pytest.mark.slow
def test_a_line_that_parts_in_the_air_comes_as_if_there_were_no_water(tmp_path):
    study = load_study(SCENES / "deck-line.toml", ["rope.segments=50"])
    ran = run_scenes(tmp_path, study)
    assert ran.statuses == ["OK"] * 5
    speed = np.linalg.norm(ran["velocity"][:, -1, -1], axis=1)
    exact = release_wave(curve_of(study.runs[0], "rope"), 2.238, tension0=180e3).end_speed
    # the water has not been heard of at the end of what is 20 m and more in the air
    np.testing.assert_allclose(speed[:3], exact, rtol=0.01)
    assert speed[4] < 0.4 * exact
    gone = np.linalg.norm(ran["position"][:, -1, -1] - ran["position"][:, 0, -1], axis=1)
    assert gone[4] == pytest.approx(0.5 * gone[0], rel=0.05)


@pytest.mark.slow
def test_a_buoy_follows_its_waves(tmp_path):
    ran = run_scenes(tmp_path, load_study(SCENES / "buoy.toml", ["ahead.segments=10"]))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
    with open_result(tmp_path / "result.h5") as result:
        found = {name: history[0] for name, (history, _) in result.measures().items()}
    late = ran.time >= 10.0
    heave, waves = found["heave"][late], found["waves"][late]
    assert np.corrcoef(heave, waves)[0, 1] > 0.85
    assert np.std(heave) == pytest.approx(np.std(waves), rel=0.1)
