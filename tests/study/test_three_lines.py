"""The scene of three lines does what its first lines say."""

import numpy as np
import pytest
from engine_runs import run_scenes

from lumpedcable.results import open_result
from lumpedcable.scene import load_study


@pytest.mark.slow
def test_the_loose_line_whips_to_twice_the_speed_of_its_recoil(tmp_path, pytestconfig):
    scene = pytestconfig.rootpath / "configs" / "three-lines.toml"
    speeds = []
    for times in (1, 2):
        segments = {"left": 50, "right": 50, "breast": 30}
        more = [f"{line}.segments={times * count}" for line, count in segments.items()]
        folder = tmp_path / str(times)
        folder.mkdir()
        ran = run_scenes(folder, load_study(scene, more))
        assert ran.statuses == ["OK"]
        assert ran.outcomes[0].energy_closure < 1e-4
        with open_result(folder / "result.h5") as result:
            end = result.summary()["right.end"]
            fast = result.line("right").velocity(0)[:, -1]
        speeds.append(float(end["peak_end_speed"][0]))
        # the straight line's: T / sqrt(EA m)
        force = float(end["static_tension"][0])
        recoil = force / np.sqrt(3e6 * 3.0)
        assert recoil == pytest.approx(34.0, abs=0.5)
        first = np.linalg.norm(fast[1:20], axis=1)  # 5 to 95 ms, before the ring pulls
        assert np.median(first) == pytest.approx(recoil, rel=0.05)
    assert speeds[0] == pytest.approx(76.4, abs=0.5)
    assert speeds[1] == pytest.approx(speeds[0], rel=0.015)
