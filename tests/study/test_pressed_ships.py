"""Ships that waves press on, in a scene: they swing as oscillators do, however all of it is turned."""

import math

import h5py
import numpy as np
import pytest
from engine_runs import scene_of
from physics.test_wave_pressure import summed
from study.test_over_waves import sine_of
from study.test_waves_on_ships import HEAVE, SIZE, pushed

from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

G, RHO, MASS, KEEL = 9.81, 1025.0, 500e3, 1.2
DRAUGHT = MASS / (RHO * SIZE[0] * SIZE[1])
SCENE = f"""
gravity = {G}
[water]
density = {RHO}
[sea]
height = "1.5 m"
period = "7 s"
components = 1
direction = {{direction}}
[materials.thread]
law = "linear"
EA = "1 N"
[bodies.ship]
mass = {MASS}
size = [{SIZE[0]}, {SIZE[1]}, {SIZE[2]}]
position = {{position}}
attitude = [0, 0, {{yaw}}]
hull = {{{{ above_keel = {KEEL} }}}}
control = {{{{ damping = [0, 0, {HEAVE[1]}], turn_damping = [5e5, 3e7, 0] }}}}
waves = {{{{ law = "froude-krylov" }}}}
[lines.thread]
material = "thread"
length = "200 m"
segments = 1
mass = "1 g/m"
diameter = "1 mm"
start = {{{{ fixed = [0, 0, 60] }}}}
end = "ship"
[measures.wave]
elevation = [0, 0]
[output]
duration = "40 s"
every = "100 ms"
[solver]
step = "20 ms"
"""


def scene(direction=0.0, yaw=0.0, place=(30.0, 0.0)):
    position = [*place, KEEL - DRAUGHT]
    return SCENE.format(direction=direction, yaw=yaw, position=position)


def ran(folder, text):
    (folder / "ship.toml").write_text(text)
    (outcome,) = run_study(load_study(folder / "ship.toml"), folder / "r.h5")
    assert outcome.status.name == "OK"
    with h5py.File(folder / "r.h5") as file:
        both = ("position", "attitude")
        found = [file["time"][()], file["measures/wave"][0]]
        return *found, *(file[f"bodies/ship/{name}"][0] for name in both)


@pytest.mark.parametrize(
    ("direction", "yaw", "axes"),
    [
        ("0", "0", "xz"),
        ('"180 deg"', "0", "xz"),
        ('"90 deg"', "0", "xyz"),  # the line that holds it goes along x
        ('"30 deg"', "0", "xyz"),
        ("0", '"90 deg"', "xyz"),  # from abeam: it rolls about y, and is computed in space
    ],
)
def test_a_scene_has_the_dimensions_that_its_waves_ask_for(tmp_path, direction, yaw, axes):
    coordinates = coordinates_of([scene_of(tmp_path, scene(direction, yaw))])
    seen = ["xyz"[k] for k in range(3) if np.abs(coordinates.axes[k]).max() > 1e-9]
    assert "".join(seen) == axes


@pytest.mark.slow
def test_it_heaves_as_an_oscillator_that_the_pressure_pushes(tmp_path):
    time, wave, place, _ = ran(tmp_path, scene())
    omega = 2.0 * np.pi / 7.0
    k = omega**2 / 9.80665
    # amplitude and phase of the wave at the origin, from the gauge there
    sine = sine_of(time, wave, omega)
    assert abs(sine) == pytest.approx(1.5 / 4 * np.sqrt(2.0))
    force = pressed(k, KEEL - DRAUGHT)[2] * sine * np.exp(-30j * k)
    exact = pushed(time, HEAVE, abs(force), omega, np.angle(force))
    heave = place[:, 2] - place[0, 2]
    assert np.ptp(exact) > 0.2
    assert np.abs(heave - exact).max() < 3e-3 * np.ptp(exact)


@pytest.mark.slow
def test_waves_meet_a_ship_where_it_has_settled(tmp_path):
    # 60 kN of thrust on a mooring of 1 kN/m: 60 m ahead of where it is looked for
    text = scene().replace(
        "control = { ", "control = { force = [60e3, 0, 0], stiffness = [1e3, 0, 0], "
    )
    time, wave, place, _ = ran(tmp_path, text.replace("hull = {", "settle = true\nhull = {"))
    assert place[0, 0] == pytest.approx(90.0, abs=0.1)
    omega = 2.0 * np.pi / 7.0
    k = omega**2 / 9.80665
    sine = sine_of(time, wave, omega)
    force = pressed(k, KEEL - DRAUGHT)[2] * sine * np.exp(-1j * k * place[0, 0])
    exact = pushed(time, HEAVE, abs(force), omega, np.angle(force))
    assert np.abs(place[:, 2] - place[0, 2] - exact).max() < 0.01 * np.ptp(exact)


@pytest.mark.slow
def test_high_waves_from_ahead_and_aside_turn_a_ship_no_more_than_in_proportion(tmp_path):
    # moments about its own axes, which tilt, would turn it eight times as far at 2 m
    text = scene("0.6").replace(
        "[measures.wave]", '[sweep]\n"sea.height" = [0.01, 2.0]\n[measures.wave]'
    )
    (tmp_path / "ship.toml").write_text(text)
    run_study(load_study(tmp_path / "ship.toml"), tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.h5") as file:
        low, high = file["bodies/ship/attitude"][..., 2]
    assert np.abs(high).max() > 0.02
    np.testing.assert_allclose(high, 200.0 * low, atol=0.1 * np.abs(high).max())


def pressed(k, above):
    """The six of a box with its centre so high over the water (m), heading along the waves."""
    return summed(k, None, 0.0, (SIZE[0], SIZE[1], DRAUGHT, above), RHO * G)


@pytest.mark.slow
def test_a_ship_and_its_waves_can_be_turned_together(tmp_path):
    turn = 2.1
    _, _, place, attitude = ran(tmp_path, scene("0.6", "0.2", (30.0, 0.0)))
    there = (30.0 * math.cos(turn), 30.0 * math.sin(turn))
    _, _, other, turned = ran(tmp_path, scene(0.6 + turn, 0.2 + turn, there))
    c, s = np.cos(turn), np.sin(turn)
    back = other @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.ptp(place, axis=0).min() > 0.05
    np.testing.assert_allclose(back, place, atol=1e-6)
    assert np.ptp(attitude, axis=0).min() > 1e-3
    np.testing.assert_allclose(turned - [0.0, 0.0, turn], attitude, atol=1e-8)


def test_waves_press_on_hulls_alone(tmp_path):
    text = scene().replace(f"hull = {{ above_keel = {KEEL} }}\n", "")
    (tmp_path / "ship.toml").write_text(text)
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "ship.toml")
    told = {fault.key: fault.message for fault in caught.value.faults}
    assert told["bodies.ship.waves.law"] == (
        "expected a hull, on whose wetted box waves press, found none"
    )
    (tmp_path / "ship.toml").write_text(scene().replace("[sea]", "[sea]\ndepth = 0.9"))
    with pytest.raises(SceneError, match="expected more than the draught of ship, 97"):
        load_study(tmp_path / "ship.toml")
    (tmp_path / "ship.toml").write_text(scene().replace("[sea]", "[see]"))
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "ship.toml")
    assert "expected [sea] for forces of waves" in str(caught.value)
