"""A free ship in waves, against linear oscillators that a sine pushes."""

import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.sea import SeaState
from lumpedcable.physics.ships import HarmonicBody, SeaBody, Swing
from lumpedcable.physics.wave_force import WaveForce
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

G, MASS, SIZE, ABOVE = 9.81, 500e3, (50.0, 10.0, 5.0), 1.2
DRAUGHT = MASS / (1025 * SIZE[0] * SIZE[1])
# of surge, heave, pitch and roll: inertia, damping and stiffness
SURGE = (MASS, 50e3, 30e3)
HEAVE = (MASS, 300e3, MASS * G / DRAUGHT)
PITCH = (
    MASS / 12 * (SIZE[0] ** 2 + SIZE[2] ** 2),
    30e6,
    MASS * G * (DRAUGHT / 2 + SIZE[0] ** 2 / (12 * DRAUGHT) - ABOVE),
)
ROLL = (
    MASS / 12 * (SIZE[1] ** 2 + SIZE[2] ** 2),
    0.5e6,
    MASS * G * (DRAUGHT / 2 + SIZE[1] ** 2 / (12 * DRAUGHT) - ABOVE),
)
SCENE = f"""
gravity = {G}
[water]
density = 1025
[sea]
height = "1.5 m"
period = "7 s"
components = 20
seed = 3
direction = "30 deg"
[materials.thread]
law = "linear"
EA = "1 N"
[lines.thread]
material = "thread"
length = "100 m"
segments = 1
mass = "1 g/m"
diameter = "1 mm"
start = {{ fixed = [0, 0, 80] }}
end = "ship"
[output]
duration = "60 s"
every = "100 ms"
[solver]
step = "20 ms"
"""


def ship(name, x, waves, attitude=""):
    return f"""
[bodies.{name}]
mass = {MASS}
size = [{SIZE[0]}, {SIZE[1]}, {SIZE[2]}]
position = [{x}, 0, {ABOVE - DRAUGHT}]
hull = {{ above_keel = {ABOVE} }}
{attitude}
[bodies.{name}.control]
stiffness = [{SURGE[2]}, {SURGE[2]}, 0]
damping = [{SURGE[1]}, {SURGE[1]}, {HEAVE[1]}]
turn_damping = [{ROLL[1]}, {PITCH[1]}, 0]
[bodies.{name}.waves]
{waves}
"""


SINES = """
surge = { amplitude = "2 kN", period = "11 s", phase = 0.4 }
heave = { amplitude = "30 kN", period = "8 s", phase = "-30 deg" }
pitch = { amplitude = "600 kN m", period = "6 s" }
"""
GIVEN = [(2e3, 11.0, 0.4), (30e3, 8.0, -np.pi / 6), (600e3, 6.0, 0.0)]
# by frequency (rad/s): force in N per m of wave and its phase (rad)
OMEGA = np.array([0.2, 1.0, 4.0])
LOADS = {
    "heave": [[60e3, 0.2], [40e3, 0.6], [0.0, 1.0]],
    "pitch": [[0, -1.6], [1.5e6, -1.2], [0, 0]],
}
IN_SEA = f"""omega = {OMEGA.tolist()}
response = {{ {", ".join(f"{name} = {table}" for name, table in LOADS.items())} }}"""
FAR = 37.0  # m, where the ship in the sea lies


class Ran:
    """A run: time (s), and by ship place (m) off the start and attitude (rad) over it."""

    def __init__(self, folder, text, *ships):
        (folder / "ship.toml").write_text(text)
        (self.outcome,) = run_study(load_study(folder / "ship.toml"), folder / "r.h5")
        with open_result(folder / "r.h5") as found:
            self.time = found.time
            both = ("position", "attitude")
            six = {n: np.hstack([found.body(n, q, 0) for q in both]) for n in ships}
        self.motion = {name: values - values[0] for name, values in six.items()}


def pushed(time, oscillator, amplitude, omega, phase):
    """x(t) of m x'' + c x' + k x = F cos(w t + p) from rest at 0: what stays and what dies away."""
    mass, damping, stiffness = oscillator
    response = amplitude * np.exp(1j * phase) / (stiffness - mass * omega**2 + 1j * damping * omega)
    steady = (response * np.exp(1j * omega * time)).real
    place, rate = response.real, (1j * omega * response).real
    fade = damping / (2 * mass)
    swing = np.sqrt(stiffness / mass - fade**2)
    dying = place * np.cos(swing * time) + (rate + fade * place) / swing * np.sin(swing * time)
    return steady - np.exp(-fade * time) * dying


def by_sine(time, oscillator, given):
    amplitude, period, phase = given
    return pushed(time, oscillator, amplitude, 2 * np.pi / period, phase - np.pi / 2)


def in_sea(time, oscillator, load):
    """The sum over the waves of the sea, whose frequencies and phases are those that it draws."""
    load = np.asarray(load, float)
    seen = load[:, 0] * np.exp(1j * load[:, 1])
    still = {2: jnp.array([[1.0, 0.0], [1.0, 0.0]])}
    state, way = SeaState.of(1.5, 7.0, 3.3, 3, 20), FAR * np.cos(np.pi / 6)
    sea = SeaBody.of(state, way, jnp.array([0.0, 9.0]), still)
    total = np.zeros_like(time)
    for omega, height, phase in zip(sea.omega, sea.amplitude, sea.phase, strict=True):
        force = np.interp(omega, OMEGA, seen, 0.0, 0.0) * height
        total += pushed(time, oscillator, abs(force), float(omega), phase + np.angle(force))
    return total


def close(found, exact, share):
    assert np.ptp(exact) > 1e-4
    assert np.max(np.abs(found - exact)) < share * np.ptp(exact)


@pytest.mark.slow
def test_waves_push_ships_as_sines_push_oscillators(tmp_path):
    text = SCENE + ship("ship", 0, SINES) + ship("far", FAR, IN_SEA)
    ran = Ran(tmp_path, text, "ship", "far")
    assert ran.outcome.status.name == "OK"
    # the thread pulls with at most 1 N; a step is a hundredth of the shortest period
    for column, oscillator, given in zip((0, 2, 4), (SURGE, HEAVE, PITCH), GIVEN, strict=True):
        close(ran.motion["ship"][:, column], by_sine(ran.time, oscillator, given), 2e-3)
    for column, oscillator, name in ((2, HEAVE, "heave"), (4, PITCH, "pitch")):
        close(ran.motion["far"][:, column], in_sea(ran.time, oscillator, LOADS[name]), 2e-3)
    assert ran.outcome.energy_closure < 1e-3


@pytest.mark.slow
def test_waves_push_a_ship_along_its_own_axes(tmp_path):
    # heading along y, what pushes it ahead moves it along y, and it heels about y
    waves = """
surge = { amplitude = "2 kN", period = "11 s", phase = 0.4 }
heave = { amplitude = "30 kN", period = "8 s", phase = "-30 deg" }
roll = { amplitude = "20 kN m", period = "6 s" }
"""
    text = SCENE + ship("ship", 0, waves, 'attitude = [0, 0, "90 deg"]')
    ran = Ran(tmp_path, text, "ship")
    assert ran.outcome.status.name == "OK"
    close(ran.motion["ship"][:, 1], by_sine(ran.time, SURGE, GIVEN[0]), 3e-3)
    close(ran.motion["ship"][:, 2], by_sine(ran.time, HEAVE, GIVEN[1]), 3e-3)
    close(ran.motion["ship"][:, 3], by_sine(ran.time, ROLL, (20e3, 6.0, 0.0)), 3e-3)
    assert ran.outcome.energy_closure < 1e-3


def test_forces_of_waves_can_grow_from_nothing():
    law = HarmonicBody((Swing(2, *map(jnp.asarray, (3.0, 8.0, 0.5))),))
    waves = WaveForce(law, jnp.eye(6), jnp.asarray(4.0))
    for t in (0.0, 1.3, 5.0):
        share = np.sin(np.pi * min(t / 4.0, 1.0) / 2.0) ** 2
        exact = [0, 0, share * 3.0 * np.sin(2 * np.pi * t / 8.0 + 0.5), 0, 0, 0]
        assert np.asarray(waves.force(jnp.zeros(6), jnp.asarray(t))) == pytest.approx(exact)


@pytest.mark.parametrize(
    ("waves", "body", "told"),
    [
        ("heeve = 1", "", "bodies.ship.waves: expected a table with any of surge, sway, heave"),
        (
            SINES,
            'free = ["x", "z"]',
            "bodies.ship.waves.pitch: expected a way that the body can move",
        ),
        (IN_SEA.replace("heave", "have"), "", 'did you mean "heave"'),
        ('rao = "none.csv"', "", "expected a file, found none"),
        ('heave = { amplitude = "3 m", period = 8 }', "", "bodies.ship.waves.heave.amplitude"),
    ],
)
def test_wrong_waves_are_told(tmp_path, waves, body, told):
    (tmp_path / "ship.toml").write_text(SCENE + ship("ship", 0, waves, body))
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "ship.toml")
    assert told in str(caught.value)


def test_forces_of_waves_need_a_sea(tmp_path):
    dry = SCENE.replace("[sea]", "[dropped]").split("[materials")[1]
    (tmp_path / "loads.csv").write_text(
        "omega,heave,heave_phase\n0.2,60000,0.2\n1.0,40000,0.6\n4.0,0,1.0\n"
    )
    text = f"gravity = {G}\n[water]\ndensity = 1025\n[materials{dry}"
    (tmp_path / "ship.toml").write_text(text + ship("ship", 0, 'rao = "loads.csv"'))
    with pytest.raises(SceneError, match=r"waves\.rao: expected \[sea\] for forces of waves"):
        load_study(tmp_path / "ship.toml")
    (tmp_path / "ship.toml").write_text(SCENE + ship("ship", 0, 'rao = "loads.csv"'))
    waves = load_study(tmp_path / "ship.toml").scene.bodies["ship"].waves
    assert waves.omega == tuple(OMEGA)
    assert [list(pair) for pair in waves.response["heave"]] == LOADS["heave"]
