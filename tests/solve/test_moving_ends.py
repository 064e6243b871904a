"""Ends that are moved, and what hangs on them: paths, pulses, pendulums."""

import numpy as np
import pytest
from engine_runs import run_text

from lumpedcable.exact import elastic_pendulum_periods, pendulum_period

HEAD = """
[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "hooke"
length = "100 m"
segments = 100
mass = "1 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ motion = {motion} }}

[output]
duration = "80 ms"
every = "1 ms"
"""


def moved(motion):
    return HEAD.format(motion=motion)


SWAY = (
    "{ position = [101, 0, 0], velocity = [0.5, 0, 0], amplitude = [0.05, 0, 0],"
    ' period = "25 ms", phase = "30 deg" }'
)


def test_a_moved_end_is_where_it_is_moved_to(tmp_path):
    ran = run_text(tmp_path, moved(SWAY))
    t, w, phase = ran.time, 2 * np.pi / 25e-3, np.pi / 6
    place = 101 + 0.5 * t + 0.05 * np.sin(w * t + phase)
    speed = 0.5 + 0.05 * w * np.cos(w * t + phase)
    np.testing.assert_allclose(ran["position"][0, :, -1, 0], place, rtol=0, atol=1e-12)
    np.testing.assert_allclose(ran["velocity"][0, :, -1, 0], speed, rtol=0, atol=1e-10)
    assert ran.statuses == ["OK"]


@pytest.mark.slow
def test_a_recorded_path_is_followed(tmp_path):
    t = np.linspace(0.0, 0.08, 9)
    x = 101 + 0.02 * np.sin(40 * t)
    rows = "\n".join(f"{a},{b},0,0" for a, b in zip(t, x, strict=True))
    (tmp_path / "path.csv").write_text(f"t,x,y,z\n{rows}\n", encoding="utf-8")
    ran = run_text(tmp_path, moved('{ file = "path.csv" }'))
    found = ran["position"][0, ::10, -1, 0]
    np.testing.assert_allclose(found, x, rtol=0, atol=1e-12)


SHAKEN = '{ position = [101, 0, 0], amplitude = [1e-3, 0, 0], period = "20 ms", ramp = "40 ms" }'


def shake(folder, step):
    """An end that is shaken by 1 mm, 50 times a second, growing over 40 ms."""
    options = ("rope.segments=200", "output.duration=140 ms", f"solver.step={step}")
    return run_text(folder, moved(SHAKEN), *options)


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    return shake(tmp_path_factory.mktemp("shaken"), 2.5e-4)


@pytest.mark.slow
def test_small_waves_run_at_the_speed_of_sound(shaken):
    # c = sqrt(EA / m) = 1000 m/s per unstretched length: seen 50 m away 50 ms later, and
    # coming back upside down from the wall after 150 ms
    middle = shaken["position"][0, :, 100, 0] - shaken["position"][0, 0, 100, 0]
    late = np.maximum(shaken.time - 50e-3, 0.0)
    grown = np.sin(0.5 * np.pi * np.minimum(late / 40e-3, 1.0)) ** 2
    expected = 1e-3 * grown * np.sin(2 * np.pi * late / 20e-3)
    assert np.max(expected) > 0.9e-3
    # a chain of lumps lags by (k l)^2 / 24 (1 - nu^2) of its phase k x: here 0.012 rad
    np.testing.assert_allclose(middle, expected, atol=0.015e-3)


def test_who_moves_an_end_pays_for_it(tmp_path, shaken):
    # the impedance sqrt(EA m) = 1000 N s/m times the integral of v^2, and the pretension of 10 kN
    speed = shaken["velocity"][0, :, -1, 0]
    squares = speed**2
    area = np.concatenate([[0.0], np.cumsum(0.5 * (squares[1:] + squares[:-1]) * 1e-3)])
    expected = 1e3 * area + 1e4 * (shaken["position"][0, :, -1, 0] - 101.0)
    work = shaken.energy["work_ends"][0]
    np.testing.assert_allclose(work, expected, atol=0.01 * np.max(expected))
    # the balance is of a small wave on a large pretension; it closes with the square of the step
    half = shake(tmp_path, 1.25e-4)
    closures = [ran.outcomes[0].energy_closure for ran in (shaken, half)]
    assert closures[0] < 0.01
    assert 3.0 < closures[0] / closures[1] < 5.0


PENDULUM = """
gravity = 9.81
[materials.hooke]
law = "linear"
EA = "{EA}"

[lines.rope]
material = "hooke"
length = "{length} m"
segments = {segments}
mass = "{mass} kg/m"
start = {{ fixed = [0, 0, 0] }}
end = "bob"
{prop}

[bodies.bob]
mass = "1000 kg"

[output]
duration = "{duration} s"
every = "10 ms"
"""

# a light line to one side holds the bob back, and parts at once: it is gone within a step
PROP = """
[lines.prop]
material = "hooke"
length = "{length} m"
segments = 1
mass = "1e-3 kg/m"
start = "bob"
end = {{ fixed = [{x}, 0, {z}] }}

[events.release]
breaks = "prop.start"
time = 0
"""


def period_of(t, x):
    """Mean time between crossings of the mean place in one direction (s), linear between samples."""
    y = x - 0.5 * (np.max(x) + np.min(x))
    k = np.flatnonzero((y[:-1] > 0.0) & (y[1:] <= 0.0))
    cross = t[k] + (t[k + 1] - t[k]) * y[k] / (y[k] - y[k + 1])
    return np.mean(np.diff(cross))


@pytest.mark.slow  # the peers' pendulum is among the quick tests
@pytest.mark.parametrize("amplitude", [0.05, 0.6])
def test_a_pendulum_swings_in_its_time(tmp_path, amplitude):
    # 10 m of stiff line, one segment, drawn aside by a horizontal line until that parts
    x, z = 10.0 * np.sin(amplitude), -10.0 * np.cos(amplitude)
    pull = 9810.0 * np.tan(amplitude)
    prop = PROP.format(length=5.0 / (1.0 + pull / 1e8), x=x + 5.0, z=z)
    text = PENDULUM.format(EA="100 MN", length=10.0, segments=1, mass=1e-3, prop=prop, duration=20)
    ran = run_text(tmp_path, text)
    bob = ran["rope.position"][0, :, -1]
    assert bob[0, 0] == pytest.approx(x, abs=2e-3)
    exact = pendulum_period(10.0 * (1 + 9810 / 1e8), amplitude, 9.81)
    assert period_of(ran.time, bob[:, 0]) == pytest.approx(exact, rel=1e-3)
    assert np.max(np.abs(bob[:, 1])) == 0.0


@pytest.mark.slow
def test_a_bob_bounces_in_its_time(tmp_path):
    # on a soft line, drawn 0.1 m down by another that parts: 2 pi sqrt(M L / EA)
    stretch = 10.0 * (1 + 9810 / 2e5)
    prop = PROP.format(length=5.0, x=0.0, z=-(stretch + 0.1 + 5.0 + 0.05))
    text = PENDULUM.format(EA="200 kN", length=10.0, segments=4, mass=1e-3, prop=prop, duration=10)
    ran = run_text(tmp_path, text)
    height = ran["rope.position"][0, :, -1, 2]
    _, bounce = elastic_pendulum_periods(10.0, 2e5, 1000.0, 9.81)
    assert period_of(ran.time, height) == pytest.approx(bounce, rel=1e-3)
    assert np.mean([np.max(height), np.min(height)]) == pytest.approx(-stretch, abs=2e-3)


BETWEEN_SHIPS = """
gravity = 9.81

[materials.hooke]
law = "linear"
EA = "1 MN"

[bodies.left]
position = [0, 0, "1 m"]
motion.heave = { amplitude = "1 m", period = "0.8 s" }
motion.roll = { amplitude = "5 deg", period = "1 s" }
points = { post = ["3 m", "5 m", "12 m"] }

[bodies.right]
position = [0, "60 m", 0]
motion = { sway = { amplitude = "0.5 m", period = "0.7 s", phase = "90 deg" } }
points = { post = ["3 m", "-5 m", "10 m"] }

[lines.rope]
material = "hooke"
length = "53 m"
segments = 10
mass = "1 kg/m"
start = "left.post"
end = "right.post"

[output]
duration = "0.2 s"
every = "10 ms"
"""


@pytest.mark.slow
def test_the_ends_of_a_line_between_two_ships_go_with_their_posts(tmp_path):
    ran = run_text(tmp_path, BETWEEN_SHIPS)
    t = ran.time
    angle, heave = np.deg2rad(5.0) * np.sin(2 * np.pi * t), np.sin(2 * np.pi * t / 0.8)
    c, s = np.cos(angle), np.sin(angle)
    left = np.stack([3.0 + 0 * t, 5 * c - 12 * s, 1.0 + heave + 5 * s + 12 * c], axis=1)
    sway = 0.5 * np.cos(2 * np.pi * t / 0.7)
    right = np.stack([3.0 + 0 * t, 55.0 + sway, 10.0 + 0 * t], axis=1)
    np.testing.assert_allclose(ran["position"][0, :, 0], left, rtol=0, atol=1e-11)
    np.testing.assert_allclose(ran["position"][0, :, -1], right, rtol=0, atol=1e-11)
    assert ran.statuses == ["OK"]
    assert ran.attributes["coordinates"] == 2  # all of it happens in one plane across the ships


WIRE = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "57.1 MN"
[lines.wire]
material = "steel"
length = "120 m"
segments = 24
mass = 3
start = { fixed = [0, 0, 0] }
end = { motion = { position = [119.9, 0, 0], amplitude = [0.02, 0, 0.3], period = "4 s", ramp = "2 s" } }
[output]
duration = "8 s"
every = "50 ms"
"""


@pytest.mark.slow
def test_an_end_moves_as_smoothly_in_single_precision(tmp_path):
    # places of 120 m have steps of 8 um in single precision; the wave of such a jump within a step
    # has 8 um / dt sqrt(EA m), 105 N; the strain of a segment is known to 6e-8, 3 N
    double, single = (
        run_text(tmp_path, WIRE, f"dtype={dtype}")["tension"][0] for dtype in ("float64", "float32")
    )
    assert np.max(double) > 20e3
    assert np.max(np.abs(single - double)) < 10.0
