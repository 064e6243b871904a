"""Heights over waves and wave gauges, against the one sine that such a sea is."""

import h5py
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable import response
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.moved import waves_of
from lumpedcable.study.run import run_study

HEIGHT, PERIOD, DIRECTION = 2.0, 6.0, 0.5  # m, s, rad
A, W = HEIGHT / 4 * np.sqrt(2.0), 2 * np.pi / PERIOD
SPEED, START = 2.0, 3.0  # m/s, m
SCENE = f"""
gravity = "9.81 m/s2"
[sea]
height = {HEIGHT}
period = {PERIOD}
components = 1
direction = {DIRECTION}
[materials.steel]
law = "linear"
EA = "57 MN"
[bodies.cargo]
mass = "2 t"
on = {{ line = "highline", place = {START}, speed = {SPEED}, stop = "3 m" }}
[lines.highline]
model = "ideal"
material = "steel"
length = "60 m"
segments = 60
mass = "3 kg/m"
start = {{ fixed = [0, "4 m", "15 m"] }}
end = {{ winch = {{ at = [0, "64 m", "16 m"], tension = "80 kN" }} }}
[measures.over]
height = "cargo"
over = "sea"
level = "1.5 m"
[measures.near]
elevation = [0, 0]
[measures.far]
elevation = ["30 m", "40 m"]
[solver]
method = "rk4"
[output]
duration = "24 s"
every = "20 ms"
"""


def results(tmp_path, text, *overrides):
    scene = tmp_path / "scene.toml"
    scene.write_text(text)
    study = load_study(scene, list(overrides))
    outcomes = run_study(study, tmp_path / "result.h5")
    with h5py.File(tmp_path / "result.h5") as file:
        found = {k: file[k][()] for k in ("time", "bodies/cargo/position") if k in file}
        found |= {f"measures/{k}": v[()] for k, v in file["measures"].items()}
        found |= {f"summary/{k}": file[f"summary/{k}"][()] for k in file["measures"]}
    found["stop"] = outcomes[0].stop_time
    return study, found


def along(x, y):
    """Distance along the waves (m)."""
    return x * np.cos(DIRECTION) + y * np.sin(DIRECTION)


def sine_of(time, gauge, omega):
    """The complex amplitude C (m) of a gauge that shows Re(C exp(i omega t))."""
    waves = np.stack([np.cos(omega * time), -np.sin(omega * time)], axis=1)
    c, s = np.linalg.lstsq(waves, gauge, rcond=None)[0]
    return c + 1j * s


def phase_of(found):
    """The phase of the sine at the origin at t = 0, from the gauge there."""
    sine = sine_of(found["time"], found["measures/near"][0], W)
    assert abs(sine) == pytest.approx(A, rel=1e-12)
    return np.angle(sine)


def test_cargo_is_as_high_over_the_waves_as_it_is_over_their_sine(tmp_path):
    _, found = results(tmp_path, SCENE)
    t, (x, y, z) = found["time"], found["bodies/cargo/position"][0].T
    e, k = phase_of(found), W**2 / 9.80665
    assert y[-1] - y[0] > 40.0  # hauled over more than half of a wave's length
    surface = A * np.cos(W * t - k * along(x, y) + e)
    np.testing.assert_allclose(found["measures/over"][0], z - surface - 1.5, atol=1e-12)
    assert found["summary/over"][0] == found["measures/over"][0].min()
    far = A * np.cos(W * t - k * along(30.0, 40.0) + e)
    np.testing.assert_allclose(found["measures/far"][0], far, atol=1e-12)
    assert found["summary/far"][0] == found["measures/far"][0].max()


def test_water_that_lies_higher_and_comes_to_move_takes_its_surface_along(tmp_path):
    water = (
        '[water]\ndensity = "1025 kg/m3"\n[bodies.cargo]',
        f'components = 1\nflow = {{ surface = "3 m", ramp = "8 s" }}\ndirection = {DIRECTION}\n',
    )
    text = SCENE.replace("[bodies.cargo]", water[0])
    text = text.replace(f"components = 1\ndirection = {DIRECTION}\n", water[1])
    text = text.replace('mass = "3 kg/m"', 'mass = "3 kg/m"\ndiameter = "28 mm"')
    study, found = results(tmp_path, text)
    t, (x, y, z) = found["time"], found["bodies/cargo/position"][0].T
    share = np.where(t < 8.0, np.sin(np.pi * t / 16.0) ** 2, 1.0)
    late = {k: v[..., t >= 8.0] if k.startswith("measures") else v for k, v in found.items()}
    e, k = phase_of(late | {"time": t[t >= 8.0]}), W**2 / 9.80665
    surface = 3.0 + share * A * np.cos(W * t - k * along(x, y) + e)
    np.testing.assert_allclose(found["measures/over"][0], z - surface - 1.5, atol=1e-12)
    # and pictures of the run have it there
    waves = waves_of(study.runs[0])
    for i in (0, 200, 900):
        place = np.array([[x[i], y[i], z[i]]])
        assert waves.height(t[i], place)[0] == pytest.approx(surface[i], abs=1e-12)


def test_single_precision_has_the_waves_too(tmp_path):
    _, double = results(tmp_path, SCENE)
    _, single = results(tmp_path, SCENE, "solver.dtype=float32")
    for name in ("over", "far"):
        np.testing.assert_allclose(
            single[f"measures/{name}"], double[f"measures/{name}"], atol=2e-4
        )


STOPPED = """
gravity = 9.81
[water]
density = 1025
[sea]
height = 1
period = 5
components = 1
[materials.wire]
law = "linear"
EA = "300 kN"
[bodies.block]
mass = 1000
position = [0, 0, 5]
size = [2, 2, 2]
free = ["x"]
velocity = [2, 0, 0]
control = { damping = [400, 0, 0], stiffness = [300, 0, 0] }
[lines.rope]
material = "wire"
length = 21
segments = 6
mass = 1
diameter = 0.02
start = { fixed = [-20, 0, 5] }
end = "block"
[measures.gauge]
elevation = [3, 0]
[output]
duration = 6
every = 0.1
stop = "block"
"""


@pytest.mark.slow
def test_what_has_stopped_hears_of_no_later_waves(tmp_path):
    _, alone = results(tmp_path, STOPPED)
    _, both = results(tmp_path, STOPPED, "block.mass=[1000, 60000]")
    gauge = alone["measures/gauge"][0]
    stop = alone["stop"]
    assert 0.5 < stop < 2.0
    after = alone["time"] >= stop
    assert np.ptp(gauge[after]) == 0.0
    np.testing.assert_allclose(both["measures/gauge"][0], gauge, rtol=1e-12)
    # as high as at that instant; the one before it is another
    assert np.ptp(both["measures/gauge"][1][after]) > 0.1
    start, end = gauge[~after][-1], both["measures/gauge"][1][after][0]
    assert min(start, end) <= gauge[after][0] <= max(start, end)
    value = response(tmp_path / "scene.toml", ["lines.rope.mass"], "max gauge")(jnp.array([1.0]))
    assert float(value) == pytest.approx(alone["summary/gauge"][0], rel=1e-6)


ZERO = "{ surface = 0 }"


@pytest.mark.parametrize(
    ("edits", "paths"),
    [
        ({}, []),
        ({"sea.flow": '{ surface = "2 m" }'}, []),  # what does not tell follows what does
        ({"sea.flow": '{ surface = "2 m" }', "hull": ZERO}, ["bodies.ship.hull.surface"]),
        ({"hull": '{ surface = "-1 m" }', "sea.flow": ZERO}, ["bodies.ship.hull.surface"]),
        ({"current": '{ profile = "power", velocity = ["1 m/s", 0, 0], exponent = 0.14, '
          'depth = "30 m", surface = "-2 m" }', "sea.flow": ZERO, "hull": ZERO},
         ["sea.flow.surface", "bodies.ship.hull.surface"]),
    ],
)  # fmt: skip
def test_water_has_one_surface(tmp_path, edits, paths):
    parts = {"sea.flow": "{}", "hull": "{}", "current": "{ velocity = [0, 0, 0] }"} | edits
    scene = tmp_path / "scene.toml"
    scene.write_text(f"""
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
current = {parts["current"]}
[sea]
height = "1 m"
period = "6 s"
flow = {parts["sea.flow"]}
[materials.rope]
law = "linear"
EA = "1 MN"
[bodies.ship]
mass = "500 t"
size = ["50 m", "10 m", "5 m"]
position = [0, 0, "1.5 m"]
hull = {parts["hull"]}
[lines.hawser]
material = "rope"
length = "60 m"
segments = 10
mass = "1 kg/m"
diameter = "30 mm"
drag = {{ normal = 1.2, tangential = 0.01 }}
start = {{ fixed = [-80, 0, 1] }}
end = "ship"
[output]
duration = "1 s"
every = "0.1 s"
""")
    told = {}
    try:
        level = load_study(scene).scene.sea_level
        assert level == (2.0 if edits else 0.0)
    except SceneError as error:
        told = {fault.key: fault.message for fault in error.faults}
    assert list(told) == paths
    assert all("the height of the water's surface in" in words for words in told.values())
