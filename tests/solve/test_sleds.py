"""A sled whose added mass differs from side to side slides on a bed: friction is against its motion."""

import numpy as np
import pytest
from engine_runs import run_text, scene_of
from scipy.integrate import solve_ivp

from lumpedcable.model.coordinates import coordinates_of

MASS, ADDED, WEIGHT, SPEED, FRICTION = 3e3, 3e3, 2e3 * 9.81, 3.0, 0.4
# the line weighs nothing that matters; it and the sled's way lie in one plane, its sides at 45 degrees
SLED = """
gravity = "9.81 m/s2"
[water]
density = "1000 kg/m3"
[seabed]
height = 0
stiffness = "1 MPa"
[materials.m]
LAW
[lines.tail]
material = "m"
length = "5 m"
segments = 2
mass = "0.01 kg/m"
diameter = "10 mm"
start = "free"
end = "sled.p"
[bodies.sled]
points = { p = [0, 0, 0.25] }
mass = "3 t"
volume = "1 m3"
size = [6, 1, 0.5]
position = [0, 40, 0.25]
velocity = ["3 m/s", "3 m/s", 0]
free = ["x", "y"]
friction = 0.4
added_mass = [0.0, 3.0, 0.0]
[output]
duration = "3 s"
every = "0.1 s"
"""
LAWS = {"elastic": 'law = "linear"\nEA = "100 N"\nmax_strain = 3', "rods": 'law = "inextensible"'}


def way():
    """Where it comes to rest (m): M v' = -mu N v / |v|."""
    mass = np.array([MASS, MASS + ADDED])

    def rate(t, y):
        v = y[2:]
        return np.concatenate([v, -FRICTION * WEIGHT * v / np.linalg.norm(v) / mass])

    def slow(t, y):
        return np.linalg.norm(y[2:]) - 1e-5

    slow.terminal = True
    found = solve_ivp(rate, (0, 5), [0, 0, SPEED, SPEED], events=slow, rtol=1e-10, atol=1e-12)
    return found.y[:2, -1]


def test_a_sled_that_moves_askew_to_its_sides_is_in_space(tmp_path):
    text = SLED.replace("LAW", LAWS["elastic"])
    alike = text.replace("[0.0, 3.0, 0.0]", "[3.0, 3.0, 3.0]")
    for scene, dimensions in ((text, 3), (alike, 2)):
        assert coordinates_of([scene_of(tmp_path, scene)]).dimensions == dimensions


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_friction_is_against_the_motion_not_the_momentum(tmp_path, law):
    step = '[solver]\nstep = "2 ms"\n' if law == "rods" else ""
    ran = run_text(tmp_path, SLED.replace("LAW", LAWS[law]) + step)
    assert ran.statuses == ["OK"]
    place = ran.bodies["sled"]["position"][0]
    assert place[-1] == pytest.approx(place[-2], abs=1e-9)  # it rests
    assert (place[-1] - place[0])[:2] == pytest.approx(way(), abs=3e-3)
    assert ran.outcomes[0].energy_closure < 1e-5
