"""A body that a current meets moves in the water as one that goes through water at rest."""

import numpy as np
import pytest
from engine_runs import run_text

# neutrally buoyant, 5 degrees askew to its way; a line far off that nothing holds at its lower end
BOX = """
gravity = 9.81
[water]
density = 1000
current.velocity = [CURRENT, 0, 0]
[materials.m]
law = "linear"
EA = "1 kN"
[lines.far]
material = "m"
length = "5 m"
segments = 2
mass = "1 kg/m"
diameter = "10 mm"
start = { fixed = [0, 50, -5] }
end = "free"
[bodies.box]
mass = "4 t"
volume = "4 m3"
size = [4, 1, 1]
position = [0, 0, -20]
attitude = [0, 0, "5 deg"]
velocity = [SPEED, 0, 0]
added_mass = [0.1, 1.0, 1.0]
drag = [0.2, 1.0, 1.0]
[solver]
step = "20 ms"
[output]
duration = "5 s"
every = "0.5 s"
"""


def moved(folder, current, speed):
    ran = run_text(folder, BOX.replace("CURRENT", str(current)).replace("SPEED", str(speed)))
    assert ran.statuses == ["OK"]
    box = ran.bodies["box"]
    return ran, box["position"][0] - current * np.outer(ran.time, [1, 0, 0]), box["attitude"][0]


@pytest.mark.slow
def test_only_what_it_does_in_the_water_counts(tmp_path):
    _, place, attitude = moved(tmp_path, 0, 1)
    # by hand: (A_y - A_x) u^2 sin 5 deg cos 5 deg over the inertia, 4 t (16 + 1) m2 / 12
    gain = 4e3 * 0.9 * np.sin(np.radians(5)) * np.cos(np.radians(5)) / (4e3 * 17 / 12)
    assert attitude[1, 2] - attitude[0, 2] == pytest.approx(0.5 * gain * 0.5**2, rel=0.05)
    for current, speed in ((-1, 0), (2, 3)):
        ran, other, turned = moved(tmp_path, current, speed)
        assert other == pytest.approx(place, abs=1e-9)
        assert turned == pytest.approx(attitude, abs=1e-10)
        assert ran.outcomes[0].energy_closure < 1e-3
        assert np.ptp(ran.energy["work_added_mass"]) > 1.0
