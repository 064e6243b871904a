"""Bending: a cantilever bent far beyond small angles, and a stiff wire under a trolley."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, order_of, scene_of

from lumpedcable.exact import tip_loaded_cantilever

LENGTH, EI, EA = 2.0, 50.0, 1e8
CANTILEVER = f"""
[materials.steel]
law = "linear"
EA = {EA}
[lines.rod]
material = "steel"
length = {LENGTH}
segments = 20
mass = 1
bending = {{ EI = {EI} }}
start = {{ fixed = [0, 0, 0], direction = [1, 0, 0] }}
end = {{ held = {{ pretension = 1, direction = [0, 0, -1] }} }}
[output]
duration = "1 s"
every = "1 s"
"""


def test_a_cantilever_bends_as_the_elastica_does(tmp_path):
    # P L^2 / EI = 3: the tip turns by 55 degrees; elliptic integrals of Bisshopp & Drucker (1945)
    load = 3.0 * EI / LENGTH**2
    x, sink, angle = tip_loaded_cantilever(LENGTH, load, EI)
    assert np.rad2deg(angle) > 50.0
    errors = []
    for segments in (10, 40):
        scene = scene_of(tmp_path, CANTILEVER, f"pretension={load}", f"segments={segments}")
        rest, coordinates = equilibrium_of(scene)
        assert bool(rest.converged)
        tip = coordinates.origin + coordinates.axes @ rest.model.lines["rod"].reference[:, -1]
        errors.append(np.hypot(tip[0] - x, tip[2] + sink))
    assert errors[-1] < 1e-3 * LENGTH
    assert order_of(errors, 4.0) == pytest.approx([2.0], abs=0.15)


TAUT = """
dimensions = 2
[materials.steel]
law = "linear"
EA = "57.1 MN"
[bodies.cargo]
mass = 20
on = { line = "wire", place = 2.5 }
[lines.wire]
material = "steel"
length = 5
segments = 50
mass = "1 g/m"
bending = { EI = 6034 }
start = { fixed = [0, 0, 0] }
end = { winch = { at = [5, 0, 0], tension = "40 kN" } }
[output]
duration = "1 s"
every = "1 s"
"""


@pytest.mark.slow
def test_a_stiff_wire_under_a_trolley_is_a_tie_rod(tmp_path):
    # EI w'''' - T w'' = F at the middle of a pinned beam: w = F/(2T) (l/2 - r tanh(l / (2 r))) with
    # r = sqrt(EI/T) (S. Timoshenko, Strength of Materials II, 1956, chapter 2); here at small slopes
    tension, weight, reach = 40e3, 20 * 9.81, np.sqrt(6034 / 40e3)
    sag = weight / (2 * tension) * (2.5 - reach * np.tanh(2.5 / reach))
    rest, _ = equilibrium_of(scene_of(tmp_path, "gravity = 9.81\n" + TAUT))
    assert bool(rest.converged)
    # h^2 / (12 r^2) = 0.55 %, the mesh's own error of bending
    assert -float(rest.model.bodies["cargo"].reference[1]) == pytest.approx(sag, rel=0.006)
