"""What single precision may cost, and what it may not."""

import numpy as np
import pytest

from lumpedcable.results import open_result
from lumpedcable.scene import load_study
from lumpedcable.study.run import run_study


def ran(folder, text, *overrides):
    """A scene in single precision, run and opened."""
    (folder / "scene.toml").write_text(text)
    run_study(load_study(folder / "scene.toml", list(overrides)), folder / "found.h5")
    return open_result(folder / "found.h5")


HAULED = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "57.1 MN"
[bodies.cargo]
mass = "2 t"
on = { line = "highline", place = "1 m", speed = "1 m/s", stop = "2 m" }
[lines.highline]
model = "ideal"
material = "steel"
length = "60 m"
segments = 60
mass = "3 kg/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = ["60 m", 0, 0], tension = "80 kN" } }
[solver]
dtype = "float32"
step = "9.0909 ms"
[output]
duration = "60 s"
every = "6 s"
"""


@pytest.mark.parametrize("method", ["leapfrog", pytest.param("rk4", marks=pytest.mark.slow)])
def test_hauled_cargo_is_where_it_is_hauled_to(tmp_path, method):
    # steps of 9 mm that are rounded, each by up to 2 um beyond 32 m, add up to 3 mm
    with ran(tmp_path, HAULED, f"solver.method={method}") as found:
        place = found.body("cargo", "position", 0)[:, 0]
        speed = found.body("cargo", "velocity", 0)[:, 0]
    t = np.arange(0.0, 55.0, 6.0)
    digit = float(np.spacing(np.float32(58.0)))
    np.testing.assert_allclose(place[:-1], 1.0 + t, rtol=0, atol=digit)
    assert place[-1] == pytest.approx(58.0, abs=digit)
    assert speed[-1] == pytest.approx(0.0, abs=1e-9)
