"""A highline from a fixed post to a ship that floats freely in waves, by both models of the cable."""

from functools import cache
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lumpedcable.physics.sea import SeaState
from lumpedcable.physics.ships import SeaBody
from lumpedcable.results import open_result
from lumpedcable.scene import SceneError, load_study
from lumpedcable.study.run import run_study

G, TENSION, CARGO, SHIP = 9.81, 80e3, 2000.0, 400e3
SIZE, ABOVE, POST = (10.0, 8.0, 6.0), 2.0, np.array([-3.0, 9.0])  # m; the post over the ship's side
DRAUGHT = SHIP / (1025 * SIZE[0] * SIZE[1])
START = np.array([60.0, ABOVE - DRAUGHT])  # x and z of the ship's centre of gravity
# what a metre of wave pushes with along x and z (N) and about y (N m), and its phase (rad)
OMEGA = [0.4, 1.2, 6.0]
LOADS = [
    [[5e3, 1.5], [12e3, 1.0], [0.0, 0.0]],
    [[300e3, 0.0], [150e3, 0.4], [0.0, 0.9]],
    [[0.0, -1.5], [400e3, -1.2], [0.0, -0.2]],
]
FREE = f"""
gravity = {G}
[water]
density = 1025
[materials.steel]
law = "linear"
EA = "57.1 MN"
[bodies.receiver]
mass = {SHIP}
size = [{SIZE[0]}, {SIZE[1]}, {SIZE[2]}]
position = [{START[0]}, 0, {START[1]}]
points = {{ post = [{POST[0]}, 0, {POST[1]}] }}
hull = {{ above_keel = {ABOVE} }}
[sea]
height = "1 m"
period = "5 s"
components = 20
direction = "60 deg"
[bodies.receiver.waves]
omega = {OMEGA}
response = {{ surge = {LOADS[0]}, heave = {LOADS[1]}, pitch = {LOADS[2]} }}
[bodies.receiver.control]
stiffness = ["60 kN/m", 0, 0]
damping = ["50 kN s/m", 0, "40 kN s/m"]
turn_damping = [0, "1 MN m s/rad", 0]
[bodies.cargo]
mass = {CARGO}
on = {{ line = "highline", place = 20, speed = 1, stop = 5 }}
[lines.highline]
model = "ideal"
material = "steel"
length = 57
segments = 20
mass = 3
diameter = "28 mm"
start = {{ fixed = [0, 0, 8] }}
end = {{ winch = {{ at = "receiver.post", tension = {TENSION} }} }}
[measures.h_d]
height = "cargo"
over = "receiver"
level = "4 m"
near = "receiver.post"
within = "30 m"
[output]
duration = "8 s"
every = "50 ms"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("free")


class Ran:
    def __init__(self, folder: Path, *overrides: str):
        (folder / "free.toml").write_text(FREE)
        study = load_study(folder / "free.toml", list(overrides))
        (self.outcome,) = run_study(study, folder / "free.h5")
        with open_result(folder / "free.h5") as found:
            self.time = found.time
            self.cargo = found.body("cargo", "position", 0)
            place, angle = (found.body("receiver", q, 0) for q in ("position", "attitude"))
            self.ship = np.stack([place[:, 0], place[:, 2], angle[:, 1]], axis=1)
            self.deck = found.measures()["h_d"][0][0]


@cache
def ran(folder: Path, *overrides: str) -> Ran:
    return Ran(folder, *overrides)


def sea():
    """Frequencies (rad/s) and complex forces and moment (3, N) of the waves that the scene draws."""
    still = {2: jnp.array([[1.0, 0.0], [1.0, 0.0]])}
    way = START[0] * np.cos(np.pi / 3)
    drawn = SeaBody.of(SeaState.of(1.0, 5.0, 3.3, 1, 20), way, jnp.array([0.0, 99.0]), still)
    wave = np.asarray(drawn.amplitude) * np.exp(1j * np.asarray(drawn.phase))
    loads = [[size * np.exp(1j * phase) for size, phase in load] for load in LOADS]
    omega = np.asarray(drawn.omega)
    return omega, np.stack([wave * np.interp(omega, OMEGA, load, 0.0, 0.0) for load in loads])


def exactly(time):
    """x, z, pitch of the ship and z of the cargo: four equations with a cable of one tension."""
    omega, waves = sea()
    inertia = SHIP * (SIZE[0] ** 2 + SIZE[2] ** 2) / 12
    afloat = 1025 * G * SIZE[0] * SIZE[1]
    tilt = SHIP * G * (DRAUGHT / 2 + SIZE[0] ** 2 / (12 * DRAUGHT) - ABOVE)

    def arm(p):
        # pitch turns z towards x
        return np.array([POST[0] * np.cos(p) + POST[1] * np.sin(p),
                         -POST[0] * np.sin(p) + POST[1] * np.cos(p)])  # fmt: skip

    def pulls(t, x, z, p, c):
        here = np.array([20.0 + t, c])
        ways = [np.array([0.0, 8.0]) - here, np.array([x, z]) + arm(p) - here]
        return [TENSION * way / np.hypot(*way) for way in ways]

    def slope(t, y):
        x, z, p, c = y[:4]
        back, ahead = pulls(t, x, z, p, c)
        r = arm(p)
        turn = r[1] * -ahead[0] - r[0] * -ahead[1]
        surge, heave, pitch = (waves @ np.exp(1j * omega * t)).real
        return [
            *y[4:],
            (surge - ahead[0] - 60e3 * (x - START[0]) - 50e3 * y[4]) / SHIP,
            (heave - ahead[1] - afloat * (z - START[1]) - 40e3 * y[5]) / SHIP,
            (pitch + turn - tilt * p - 1e6 * y[6]) / inertia,
            (back[1] + ahead[1]) / CARGO - G,
        ]

    # at rest the trolley hangs where the two parts carry it, the ship still held
    low, high = -60.0, 8.0
    for _ in range(80):
        c = 0.5 * (low + high)
        lift = sum(pull[1] for pull in pulls(0.0, *START, 0.0, c))
        low, high = (c, high) if lift > CARGO * G else (low, c)
    start = [*START, 0.0, c, 0.0, 0.0, 0.0, 0.0]
    return solve_ivp(slope, (0, time[-1]), start, "DOP853", time, rtol=1e-10, atol=1e-12).y[:4].T


@pytest.mark.slow
def test_ship_and_cargo_on_an_ideal_cable_meet_their_equations(folder):
    run = ran(folder)
    assert run.outcome.status.name == "OK"
    exact = exactly(run.time)
    # leapfrog's step is a thirtieth of the cargo's bounce: (w dt)^2 / 24
    for k in range(3):
        span = np.ptp(exact[:, k])
        assert span > 1e-3
        assert np.max(np.abs(run.ship[:, k] - exact[:, k])) < 5e-3 * span
    assert np.max(np.abs(run.cargo[:, 2] - exact[:, 3])) < 5e-3 * np.ptp(exact[:, 3])
    assert run.outcome.energy_closure < 1e-3
    # the deck goes where the ship goes: normal (sin p, cos p) through its centre
    x, z, p, c = exact.T
    deck = np.sin(p) * (20.0 + run.time - x) + np.cos(p) * (c - z) - 4.0
    post = x + POST[0] * np.cos(p) + POST[1] * np.sin(p)
    near = post - 20.0 - run.time <= 30.0
    assert np.array_equal(np.isfinite(run.deck), near)
    assert run.deck[near] == pytest.approx(deck[near], abs=5e-3)


@pytest.mark.slow
def test_the_whole_cable_moves_the_ship_as_the_ideal_one_does(folder):
    short = "output.duration=4"
    run, ideal = ran(folder, "highline.model=lumped", short), ran(folder, short)
    assert run.outcome.status.name == "OK"
    apart = np.max(np.abs(run.ship - ideal.ship), axis=0)
    size = np.ptp(ideal.ship, axis=0)
    assert apart[0] < 0.03 * size[0]
    assert apart[2] < 0.03 * size[2]
    # half of the cable's 170 kg hangs on the ship all at once, so that it dips twice as far
    weight = 0.5 * 57 * 3 * G
    assert apart[1] < 2.0 * weight / (1025 * G * SIZE[0] * SIZE[1])
    assert run.outcome.energy_closure < 1e-3


def test_a_wrong_post_of_a_free_ship_is_told(tmp_path):
    (tmp_path / "free.toml").write_text(FREE.replace('"receiver.post", t', '"receiver.pots", t'))
    with pytest.raises(SceneError) as caught:
        load_study(tmp_path / "free.toml")
    assert 'did you mean "receiver.post"' in str(caught.value)
