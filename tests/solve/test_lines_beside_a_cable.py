"""Lines with joints and point masses at rest beside a cable with its cargo and a line on a winch."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, scene_of
from scipy.optimize import brentq

from lumpedcable.exact.ideal_highline import IdealHighline

GRAVITY, EA = 9.81, 5e6  # m/s2, N
SCENE = f"""
gravity = {GRAVITY}
[materials.steel]
law = "linear"
EA = {EA}
[bodies.cargo]
mass = "200 kg"
on = {{ line = "highline", place = "10 m" }}
[lines.highline]
model = "ideal"
material = "steel"
length = "30 m"
segments = 10
mass = "1 kg/m"
start = {{ fixed = [0, 0, 10] }}
end = {{ winch = {{ at = [30, 0, 10], tension = "20 kN" }} }}
[lines.a]
material = "steel"
length = "16 m"
segments = 5
mass = "1 kg/m"
start = {{ fixed = [0, 0, 30] }}
end = "b.start"
[lines.b]
material = "steel"
length = "16 m"
segments = 5
mass = "1 kg/m"
start = "a.end"
end = {{ fixed = [30, 0, 30] }}
[output]
duration = "0.1 s"
every = "0.05 s"
"""
MORE = """
[bodies.lamp]
mass = "5 kg"
[lines.c]
material = "steel"
length = "16 m"
segments = 5
mass = "1 kg/m"
start = { fixed = [40, 0, 30] }
end = "lamp"
[lines.pulled]
material = "steel"
length = "30 m"
segments = 4
mass = "1 kg/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = [30, 0, 0], tension = "20 kN" } }
"""


@pytest.mark.slow
def test_cargo_joint_and_point_mass_are_where_each_would_be_alone(tmp_path):
    found, coordinates = equilibrium_of(scene_of(tmp_path, SCENE + MORE))
    assert bool(found.converged)
    assert float(found.imbalance) < 1e-6
    places = {name: nodes_in_space(found, coordinates, name) for name in "abc"}
    cargo = coordinates.expand(np.asarray(found.model.bodies["cargo"].reference), 0, place=True)
    highline = IdealHighline(30.0, 20e3, 200.0, GRAVITY, place=10.0)
    assert cargo == pytest.approx([10.0, 0.0, 10.0 + highline.height()], abs=1e-9)

    # a chain of ten equal springs: H is the same in all, V grows by the weight of a node
    l, V = 3.2, 3.2 * GRAVITY * (np.arange(10) - 4.5)

    def parts(H):
        T = np.hypot(H, V)
        return l * (1.0 + T / EA) * np.stack([np.full(10, H), V]) / T

    H = brentq(lambda H: parts(H)[0].sum() - 30.0, 1.0, 1e4, xtol=1e-12)
    joint = np.cumsum(parts(H), axis=1)[:, 4]
    for node in (places["a"][:, -1], places["b"][:, 0]):
        assert node == pytest.approx([joint[0], 0.0, 30.0 + joint[1]], abs=1e-6)

    # each metre carries the lamp and what hangs below it
    stretch = GRAVITY * (5.0 * 16.0 + 16.0**2 / 2.0) / EA
    assert places["c"][:, -1] == pytest.approx([40.0, 0.0, 14.0 - stretch], abs=1e-7)


@pytest.mark.parametrize("model", ["ideal", pytest.param("lumped", marks=pytest.mark.slow)])
def test_a_joint_that_is_held_at_the_start_is_held_beside_a_cable_too(tmp_path, model):
    text = SCENE.replace('"ideal"', f'"{model}"')
    for side, tie in (("end", "b.start"), ("start", "a.end")):
        held = f'{side} = {{ joined = "{tie}", at = [14, 0, 25] }}'
        text = text.replace(f'{side} = "{tie}"', held)
    found, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert bool(found.converged)
    for name, node in (("a", -1), ("b", 0)):
        place = nodes_in_space(found, coordinates, name)[:, node]
        assert place == pytest.approx([14.0, 0.0, 25.0], abs=1e-12)
