"""Submerged bodies in waves, beside their own equations: pushed, dragged, held by lines."""

import numpy as np
import pytest
from command_line import say
from engine_runs import run_text
from scipy.integrate import solve_ivp
from test_waves_on_lines import RHO, Water

SCENE = f"""
[water]
density = {RHO}
[sea]
height = 1.5
period = 8.0
components = 1
flow = {{ ramp = 6.0 }}
[materials.wire]
law = "linear"
EA = 1e4
[lines.rope]
material = "wire"
length = 1.0
segments = 1
mass = 1e-3
start = {{ fixed = [9, 0, -9] }}
end = "free"
[bodies.buoy]
BODY
[output]
duration = "16 s"
every = "0.2 s"
quantities = ["position", "energy"]
"""
VOLUME = 0.4


def moved(folder, body, *overrides):
    ran = run_text(folder, SCENE.replace("BODY", body), *overrides)
    assert ran.statuses == ["OK"]
    return ran, ran.bodies["buoy"]["position"][0]


def path(time, start, force, masses):
    """x and z (m) of a body at rest at `start`, pushed by `force` (N) of the water and its own speed."""
    water = Water(1.5)

    def moves(t, y):
        share = np.sin(np.pi * min(t, 6.0) / 12.0) ** 2
        now = share * np.array(water(t, y[0], y[1]))
        return [*y[2:], *(force(now[:2], now[2:], y[2:]) / masses)]

    found = solve_ivp(moves, (0, time[-1]), [*start, 0, 0], t_eval=time, rtol=1e-9, atol=1e-10)
    return found.y[:2].T


@pytest.mark.parametrize("added", ["", "added_mass = [0.5, 0.5, 1.2]"])
@pytest.mark.slow
def test_what_weighs_as_the_water_goes_with_it(tmp_path, added):
    body = f"mass = {RHO * VOLUME}\nvolume = {VOLUME}\nposition = [1, 0, -4]\nfree = ['x', 'z']\n"
    ran, place = moved(tmp_path, body + added)
    exact = path(ran.time, (1.0, -4.0), lambda u, a, v: a, np.ones(2))
    assert np.ptp(exact[:, 0]) > 0.5
    np.testing.assert_allclose(place[:, [0, 2]], exact, atol=2e-3)
    assert ran.outcomes[0].energy_closure < 1e-3


def test_a_box_is_dragged_and_pushed_along_each_of_its_axes(tmp_path):
    size, drag, added = np.array([1.0, 0.8, 0.5]), (1.1, 0.0, 1.4), (0.4, 0.0, 0.9)
    mass = 700.0
    body = f"""
mass = {mass}
volume = {VOLUME}
size = {size.tolist()}
drag = {list(drag)}
added_mass = {list(added)}
position = [1, 0, -4]
free = ['x', 'z']
"""
    ran, place = moved(tmp_path, body)
    faces = np.array([size[1] * size[2], size[0] * size[1]])
    factor = 0.5 * RHO * faces * np.array([drag[0], drag[2]])
    carried = RHO * VOLUME * np.array([added[0], added[2]])

    def force(u, a, v):
        return (RHO * VOLUME + carried) * a + factor * np.abs(u - v) * (u - v)

    exact = path(ran.time, (1.0, -4.0), force, mass + carried)
    assert np.ptp(exact[:, 0]) > 0.4
    np.testing.assert_allclose(place[:, [0, 2]], exact, atol=2e-3)
    assert {"work_waves", "lost_drag"} <= ran.energy.keys()
    assert ran.outcomes[0].energy_closure < 1e-3


def test_its_axes_turn_with_it(tmp_path):
    # stood on its end it has the added mass of its length upwards
    lying = "size = [2, 1, 1]\nadded_mass = [0.2, 1.0, 1.0]\n"
    standing = "size = [1, 1, 2]\nadded_mass = [1.0, 1.0, 0.2]\n"
    common = f"mass = 900\nvolume = {VOLUME}\nposition = [1, 0, -4]\nfree = ['x', 'z']\n"
    _, turned = moved(tmp_path, common + lying + "attitude = [0, '89.999999 deg', 0]\n")
    _, other = moved(tmp_path, common + standing)
    np.testing.assert_allclose(turned, other, atol=1e-6)


def test_with_waves_of_its_own_it_is_not_pushed_twice(tmp_path):
    body = f"mass = {RHO * VOLUME}\nvolume = {VOLUME}\nposition = [1, 0, -4]\nfree = ['x', 'z']\n"
    own = "waves = { surge = { amplitude = '0 N', period = '8 s' } }\n"
    line = ("lines.rope.diameter=0.01",)
    _, place = moved(tmp_path, body + own, *line)
    assert np.ptp(place, axis=0).max() < 1e-9


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("mass = 100\nposition = [0, 0, -4]\nfree = ['x']", "sea.flow: expected a line with a diameter"),
        ("mass = 100\nposition = [0, 0, -4]\nfree = ['x']\nadded_mass = [1, 1, 1]",
         "bodies.buoy.volume: expected the volume (m3) of a body with added_mass"),
    ],
)  # fmt: skip
def test_what_feels_nothing_is_told(tmp_path, body, words):
    (tmp_path / "scene.toml").write_text(SCENE.replace("BODY", body))
    said = say(tmp_path, "check", "scene.toml")
    assert said.code == 2
    assert words in " ".join(said.err.split())


MOORED = """
[materials.m]
law = "linear"
EA = 1e4

[bodies.s]
mass = 100
size = [4, 1, 1]
position = [0, 0, 0]
attitude = [0, 0, 0.8]
points = { b = [2, 0, 0], q = [-2, 0, 0] }
settle = true
waves = { surge = { amplitude = 100, period = 2 } }

[lines.a]
material = "m"
length = 9
segments = 1
mass = 1
start = "s.q"
end = { fixed = [-12, 0.5, 0] }

[lines.b]
material = "m"
length = 9
segments = 1
mass = 1
start = "s.b"
end = { fixed = [12, -0.7, 0] }

[solver]
step = 0.002

[output]
duration = 0.1
every = 0.01
"""


@pytest.mark.parametrize("dimensions", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_waves_push_along_the_heading_at_which_a_body_has_settled(tmp_path, dimensions):
    """Not along the one that is guessed: the ship lies between its anchors."""
    text = f"dimensions = {dimensions}\n{MOORED}"
    if dimensions == 3:
        text = text.replace("settle", 'free = ["x", "y", "yaw"]\nsettle')
    ran = run_text(tmp_path, text)
    body = ran.bodies["s"]
    yaw = body["attitude"][0, 0, 2]
    assert yaw == pytest.approx(np.arctan2(-1.2, 24.0), abs=1e-3)
    moved = body["position"][0, -1] - body["position"][0, 0]
    assert np.arctan2(moved[1], moved[0]) == pytest.approx(yaw, abs=0.01)
