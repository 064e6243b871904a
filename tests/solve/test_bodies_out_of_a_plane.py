"""Rigid bodies that a plane would cut askew: they are in space, and do what their own equations say."""

import numpy as np
import pytest
from engine_runs import run_text, scene_of
from scipy.integrate import solve_ivp

from lumpedcable.model.coordinates import coordinates_of

MASS, SIZE = 500e3, (50.0, 10.0, 5.0)  # kg, m
DRAUGHT = MASS / (1025 * SIZE[0] * SIZE[1])
FLOATING = f"""
gravity = 9.81
[water]
density = "1025 kg/m3"
CURRENT
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
[bodies.ship]
mass = {MASS}
size = {list(SIZE)}
position = [0, 0, {1.2 - DRAUGHT}]
hull = {{ above_keel = "1.2 m" HULL }}
SHIP
[output]
duration = "4 s"
every = "0.1 s"
quantities = ["position", "velocity", "energy"]
[solver]
step = "20 ms"
"""


def floating(folder, ship, current="", hull=""):
    """A ship on a thread that hardly pulls: its place and attitude over time, of three numbers each."""
    text = FLOATING.replace("SHIP", ship).replace("CURRENT", current).replace("HULL", hull)
    ran = run_text(folder, text)
    assert ran.statuses == ["OK"]
    return ran.time, *(ran.bodies["ship"][kind][0] for kind in ("position", "attitude"))


@pytest.mark.slow
def test_a_thrust_to_the_side_pushes_a_ship_to_the_side(tmp_path):
    t, place, _ = floating(tmp_path, 'control.force = [0, "20 kN", 0]')
    assert place[:, 1] == pytest.approx(20e3 / MASS * t**2 / 2, abs=2e-4 * 20e3 / MASS * 8)


@pytest.mark.slow
def test_a_moment_turns_a_ship_out_of_the_plane_of_its_line(tmp_path):
    t, _, angle = floating(tmp_path, 'control.moment = [0, 0, "200 kN m"]')
    turned = 200e3 / (MASS / 12 * (SIZE[0] ** 2 + SIZE[1] ** 2)) * t**2 / 2
    assert angle[:, 2] == pytest.approx(turned, abs=2e-4 * turned[-1])


@pytest.mark.slow
def test_a_current_across_the_plane_carries_a_body_that_has_drag(tmp_path):
    # m v' = k (U - v)^2 from rest: y = U t - m / k log(1 + k U t / m)
    U, k = 2.0, 0.5 * 1025 * 1.2 * SIZE[0] * SIZE[2]
    t, place, _ = floating(
        tmp_path, "drag = [1, 1.2, 1]", f"current = {{ velocity = [0, {U}, 0] }}"
    )
    carried = U * t - MASS / k * np.log1p(k * U * t / MASS)
    assert place[:, 1] == pytest.approx(carried, abs=1e-3 * carried[-1])


@pytest.mark.slow
def test_a_hull_that_moves_sideways_has_no_resistance_along_its_length(tmp_path):
    skin = ', resistance = { viscosity = "1e-6 m2/s" }'
    t, place, _ = floating(tmp_path, "velocity = [0, 3, 0]", hull=skin)
    assert place[:, 1] == pytest.approx(3 * t, abs=1e-4)
    t, place, _ = floating(tmp_path, "velocity = [3, 0, 0]", hull=skin)
    assert place[-1, 0] < 3 * t[-1] - 1e-3


MOORED = """
gravity = 9.81
[water]
density = "1025 kg/m3"
[materials.a]
law = "linear"
EA = "2 MN"
[lines.l]
material = "a"
length = 30
segments = 6
mass = 5
diameter = 0.05
drag = {{ normal = 1.2, tangential = 0.02 }}
start = {{ fixed = {anchor} }}
end = "ship.bow"
[bodies.ship]
mass = "20 t"
size = ["10 m", "3 m", "2 m"]
position = {place}
points = {{ bow = [-5, 0, 0.2] }}
attitude = [0, 0, {yaw}]
velocity = {velocity}
drag = [1, 2, 1]
hull = {{ resistance = {{ viscosity = "1e-6 m2/s" }} }}
[output]
duration = "1.5 s"
every = "0.1 s"
quantities = ["position", "velocity", "tension"]
[solver]
step = "1 ms"
"""


def moored(folder, angle, more=""):
    """A ship that comes to the end of its mooring line, the whole scene turned by an angle about z.

    The tension over time and line, and how the ship goes: its places and its attitude's
    three parts, the places in axes that are turned with the scene.
    """
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    place, velocity = turn @ [34.0, 0, 0], turn @ [2.0, 0, 0]
    text = MOORED.format(
        anchor=[0, 0, 0], place=place.tolist(), velocity=velocity.tolist(), yaw=angle
    )
    ran = run_text(folder, more + text)
    assert ran.statuses == ["OK"]
    ship = ran.bodies["ship"]
    return ran.lines["l"]["tension"][0], ship["position"][0] @ turn, ship["attitude"][0]


@pytest.mark.slow
@pytest.mark.parametrize("angle", [np.pi, 0.6457718232379019, np.pi / 2])
def test_a_scene_turned_about_the_vertical_does_the_same(tmp_path, angle):
    tension, place, attitude = moored(tmp_path, 0.0)
    assert np.ptp(tension) > 1e4
    other, there, turned = moored(tmp_path, angle)
    assert other == pytest.approx(tension, abs=1e-6 * np.max(tension))
    assert there == pytest.approx(place, abs=1e-8)
    # roll and pitch are a ship's own whatever its heading
    assert turned[:, 1] == pytest.approx(attitude[:, 1], abs=1e-8)
    assert turned[:, 2] == pytest.approx(angle, abs=1e-8)


@pytest.mark.slow
def test_three_dimensions_asked_for_are_x_y_and_z(tmp_path):
    angle = 0.6457718232379019
    tension, place, _ = moored(tmp_path, angle)
    other, there, _ = moored(tmp_path, angle, "dimensions = 3\n")
    assert other == pytest.approx(tension, abs=1e-6 * np.max(tension))
    assert there == pytest.approx(place, abs=1e-8)


TETHERED = """
[materials.elastic]
law = "linear"
EA = "100 kN"
[lines.l]
material = "elastic"
length = "9 m"
segments = 1
mass = "0.01 kg/m"
start = "b"
end = {{ fixed = {} }}
[bodies.b]
mass = "100 kg"
position = [0, 0, 0]
{}
[output]
duration = "1 s"
every = "0.25 s"
"""
WAYS = 'free = ["x", "y", "z"]\n'
SPRING = 'control.stiffness = ["10 kN/m", 0, 0]'


@pytest.mark.slow
def test_a_spring_along_x_pulls_a_body_off_its_oblique_line(tmp_path):
    more = WAYS + SPRING + '\ncontrol.damping = ["50 N s/m", 0, 0]'
    ran = run_text(tmp_path, TETHERED.format([8, 6, 0], more))
    assert ran.statuses == ["OK"]

    def rate(_, state):
        place, velocity = state[:2], state[2:]
        arm = np.array([8.0, 6.0]) - place
        pull = 100e3 * (np.hypot(*arm) / 9.0 - 1.0) * arm / np.hypot(*arm)
        own = np.array([10e3 * place[0] + 50.0 * velocity[0], 0.0])
        return [*velocity, *((pull - own) / (100.0 + 0.01 * 9.0 / 2.0))]

    exact = solve_ivp(rate, (0.0, 1.0), np.zeros(4), t_eval=ran.time, rtol=1e-10, atol=1e-12)
    found = ran.bodies["b"]["position"][0]
    # second order in a step of which there are hundreds to a period
    assert found[:, :2] == pytest.approx(exact.y[:2].T, abs=2e-3)
    assert found[:, 2] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("end", "body", "dimensions"),
    [
        ([8, 6, 0], WAYS + SPRING, 3),
        ([8, 6, 0], "inertia = [10, 10, 10]\n" + SPRING, 3),
        ([8, 6, 0], WAYS + 'control.damping = [0, "50 N s/m", 0]', 3),
        ([8, 6, 0], 'free = ["x"]', 3),
        ([8, 6, 0], 'free = ["x", "y"]', 1),
        ([8, 6, 0], WAYS + 'control.stiffness = ["1 kN/m", "1 kN/m", 0]', 1),
        ([8, 0, 6], WAYS + 'control.stiffness = ["1 kN/m", "1 kN/m", 0]', 3),
        ([9, 0, 0], WAYS + SPRING, 1),
        ([0, 9, 0], 'free = ["x"]', 1),
    ],
)
def test_springs_and_guides_between_axes_are_in_space(tmp_path, end, body, dimensions):
    scene = scene_of(tmp_path, TETHERED.format(end, body))
    assert coordinates_of([scene]).dimensions == dimensions


@pytest.mark.parametrize(("end", "dimensions"), [([8, 6, 0], 3), ([9, 0, 0], 2)])
def test_a_guide_in_a_vertical_plane(tmp_path, end, dimensions):
    # under gravity: the plane through z and the line, in which x alone is free
    text = "gravity = 9.81\n" + TETHERED.format(end, 'free = ["x", "z"]')
    assert coordinates_of([scene_of(tmp_path, text)]).dimensions == dimensions
