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


TAUT = """
[materials.steel]
law = "linear"
EA = "57.1 MN"
[lines.wire]
material = "steel"
length = "5 m"
segments = 50
mass = "3 kg/m"
end = { held = { pretension = "40 kN", direction = [1, 0, 0] } }
[lines.wire.start.motion]
position = [0, 0, 0]
amplitude = ["0.2 m", 0, 0]
period = "2 s"
ramp = "1 s"
[solver]
dtype = "float32"
[output]
duration = "1 s"
every = "5 ms"
"""


def test_rounding_does_not_heat_a_taut_line(tmp_path):
    # a force of 40 kN holds what the other end moves to and fro: T = 40 kN - m (L - s) a, since waves
    # take 1 ms along 5 m. A digit of single precision is 0.2 m times 2^-24 or 7 N, 50 000 of them 2 kN
    with ran(tmp_path, TAUT) as found:
        tension, t = found.line("wire").tension(0), found.time
    w = np.pi
    grown = 0.5 - 0.5 * np.cos(w * t)
    rate, bend = 0.5 * w * np.sin(w * t), 0.5 * w**2 * np.cos(w * t)
    a = 0.2 * ((bend - w**2 * grown) * np.sin(w * t) + 2.0 * w * rate * np.cos(w * t))
    beyond = 5.0 - 0.1 * (np.arange(50) + 0.5)
    exact = 40e3 - 3.0 * beyond * a[:, None]
    digit = 57.1e6 * float(np.finfo("float32").eps)
    np.testing.assert_allclose(tension, exact, rtol=0, atol=digit)


HAULED_IN = TAUT.replace(
    '{ held = { pretension = "40 kN", direction = [1, 0, 0] } }',
    '{ winch = { at = ["5 m", 0, 0], tension = "40 kN" } }',
).replace('amplitude = ["0.2 m", 0, 0]\nperiod = "2 s"', 'velocity = ["5 mm/s", 0, 0]')


@pytest.mark.slow
def test_a_winch_costs_single_precision_no_digits(tmp_path):
    # hauled in at an even 5 mm/s, 15 kg of line have the winch's tension all along. A digit of the
    # whole length, 5e-8 of it, is 3 N in every segment, in every step another: 50 N and more together
    with ran(tmp_path, HAULED_IN, "output.duration=2 s") as found:
        tension, even = found.line("wire").tension(0), found.time > 1.0
    digit = 57.1e6 * float(np.finfo("float32").eps)
    np.testing.assert_allclose(tension[even], 40e3, rtol=0, atol=digit)
