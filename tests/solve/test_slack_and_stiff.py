"""States of rest that are hard to find: slack chains on a flat bed, and lines that hardly stretch."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, study_of
from scipy.optimize import brentq

from lumpedcable.exact import elastic_catenary

G, RHO = 9.80665, 1025.0
CHAIN = """
gravity = 9.80665
[seabed]
height = 0
stiffness = "1 MPa"
[materials.chain]
law = "linear"
EA = "100 MN"
tension_only = true
[lines.rope]
material = "chain"
length = 140
segments = 25
mass = 50
start = { fixed = [0, 0, 10] }
end = { fixed = [110, 0, 30] }
[output]
[sweep.sample]
count = 40
"lines.rope.length" = { from = 114, to = 160 }
"lines.rope.start.fixed.2" = { from = 0.1, to = 15 }
"lines.rope.end.fixed.2" = { from = 0.1, to = 30 }
"lines.rope.mass" = { from = 1, to = 500, spacing = "log" }
"materials.chain.EA" = { from = "1 MN", to = "1 GN", spacing = "log" }
"""
CLUMP = """
gravity = 9.80665
[water]
density = 1025
{current}
[seabed]
height = -50
stiffness = "100 kPa"
[materials.chain]
law = "linear"
EA = "100 MN"
tension_only = true
[bodies.clump]
mass = "2 t"
[lines.lower]
material = "chain"
length = 150
segments = 20
mass = 50
diameter = 0.05
{drag}
start = {{ fixed = [0, 0, -50] }}
end = "clump"
[lines.upper]
material = "chain"
length = 100
segments = 20
mass = 20
diameter = 0.05
{drag}
start = "clump"
end = {{ fixed = [220, 0, 0] }}
[output]
[sweep.sample]
count = 40
"lines.lower.length" = {{ from = 100, to = 180 }}
"lines.upper.length" = {{ from = 80, to = 140 }}
"lines.lower.mass" = {{ from = 5, to = 300, spacing = "log" }}
"lines.upper.mass" = {{ from = 5, to = 100, spacing = "log" }}
"materials.chain.EA" = {{ from = "1 MN", to = "1 GN", spacing = "log" }}
"lines.upper.end.fixed.0" = {{ from = 150, to = 230 }}
"bodies.clump.mass" = {{ from = "50 kg", to = "10 t", spacing = "log" }}
"""
TROLLEY = """
gravity = 9.80665
[materials.steel]
law = "linear"
EA = "2 GN"
[bodies.cargo]
mass = "2 t"
on = { line = "highline", place = "9 m" }
[lines.highline]
material = "steel"
length = 30
segments = 20
mass = "20 g/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = [30, 0, -3], tension = "60 kN" } }
[output]
[sweep.sample]
count = 40
"bodies.cargo.mass" = { from = "1 t", to = "5 t" }
"bodies.cargo.on.place" = { from = "4 m", to = "26 m" }
"lines.highline.end.winch.tension" = { from = "80 kN", to = "120 kN" }
"materials.steel.EA" = { from = "50 MN", to = "100 GN", spacing = "log" }
"""
# two lines that meet, and one that hangs from where they do
BRANCHED = """
gravity = 9.80665
[materials.rope]
law = "table"
strain = [0, 0.05, 0.12, 0.2]
tension = [0, 2e4, 6e4, 9e4]
tension_only = true
[lines.left]
material = "rope"
length = 25
segments = 2
mass = 6
start = { fixed = [0, 0, 0] }
end = "tail.start"
[lines.tail]
material = "rope"
length = 20
segments = 2
mass = 6
start = "left.end"
end = "free"
[lines.right]
material = "rope"
length = 28
segments = 2
mass = 6
start = { fixed = [10, 0, -5] }
end = "left.end"
[output]
[sweep.sample]
count = 6
"lines.left.length" = { from = 15, to = 30 }
"lines.right.length" = { from = 15, to = 30 }
"lines.tail.length" = { from = 3, to = 20 }
"lines.right.start.fixed.0" = { from = 5, to = 28 }
"lines.right.start.fixed.2" = { from = -10, to = 10 }
"""


def at_rest(folder, text):
    """The scenes of a sweep whose state of rest is found, with it."""
    runs = study_of(folder, text).runs
    every = [(runs[k], *equilibrium_of(runs[k])) for k in range(len(runs))]
    return [each for each in every if each[1].converged]


def tensions(found, name):
    """Tensions (N) of a line's segments."""
    line = found.model.lines[name]
    return np.asarray(line.law.tension(line.reference_strain))


@pytest.mark.slow
def test_chains_between_slack_and_taut_on_a_flat_bed(tmp_path):
    # hanging straight down from both ends with length left over, or led up from the bed at a slope
    found, slack = at_rest(tmp_path, CHAIN), 0
    assert len(found) == 40
    for scene, rest, _ in found:
        line, EA = scene.lines["rope"], scene.materials["chain"].EA
        low, high = line.start.fixed[2], line.end.fixed[2]
        weight, part = float(line.mass) * G, float(line.length) / 25
        exact = elastic_catenary(110, high - low, line.length, EA, weight, seabed=-low)
        slack += exact.horizontal == 0.0
        middles = exact.tension(np.array([0.5 * part, line.length - 0.5 * part]))
        # a chain of lumps carries whole lumps, and lies on the bed from a node on
        assert tensions(rest, "rope")[[0, -1]] == pytest.approx(middles, abs=weight * part)
    assert 5 < slack < 35


@pytest.mark.slow
def test_clumps_between_chains_on_a_bed(tmp_path):
    # the upper chain hangs between the clump and its other end; slack ones on the bed are not all found
    found = at_rest(tmp_path, CLUMP.format(current="", drag=""))
    assert len(found) >= 38
    for scene, rest, coordinates in found:
        upper, EA = scene.lines["upper"], scene.materials["chain"].EA
        x, _, z = nodes_in_space(rest, coordinates, "upper")[:, 0]
        z = max(z, -50.0)  # of a clump that has sunk into the bed
        weight = (float(upper.mass) - RHO * np.pi / 4 * 0.05**2) * G
        exact = elastic_catenary(
            upper.end.fixed[0] - x, -z, upper.length, EA, weight, seabed=-50 - z
        )
        part = float(upper.length) / 20
        top = float(exact.tension(upper.length - 0.5 * part))
        assert tensions(rest, "upper")[-1] == pytest.approx(top, abs=weight * part)


@pytest.mark.slow
def test_clumps_between_chains_in_a_current(tmp_path):
    current = 'current = { velocity = ["0.7 m/s", 0, 0] }'
    drag = "drag = { normal = 1.2, tangential = 0.01 }"
    assert len(at_rest(tmp_path, CLUMP.format(current=current, drag=drag))) >= 38


@pytest.mark.slow
def test_trolleys_on_lines_that_hardly_stretch(tmp_path):
    # of a line without weight: T (sin p + sin q) = W, both its parts straight under the winch's tension
    found = at_rest(tmp_path, TROLLEY)
    assert len(found) == 40
    for scene, rest, _ in found:
        cargo = scene.bodies["cargo"]
        x, T = cargo.on.place, scene.lines["highline"].end.winch.tension

        def lifted(z, x=x, T=T, weight=float(cargo.mass) * G):
            up = -z / np.hypot(x, z) + (-3.0 - z) / np.hypot(30.0 - x, -3.0 - z)
            return T * up - weight

        z = brentq(lifted, -200.0, 5.0, xtol=1e-12)
        place = np.asarray(rest.model.bodies["cargo"].reference)[-1]
        # the kink under a trolley is of first order in the segments: a few thousandths where steepest
        assert place == pytest.approx(z, rel=5e-3)


@pytest.mark.slow
def test_lines_of_any_law_that_meet_and_cannot_push(tmp_path):
    found = at_rest(tmp_path, BRANCHED)
    assert len(found) == 6
    for scene, rest, coordinates in found:
        at_joint = np.zeros(3)
        for name, line in scene.lines.items():
            places = nodes_in_space(rest, coordinates, name)
            along = np.diff(places) / np.linalg.norm(np.diff(places), axis=0)
            pull = tensions(rest, name) * along
            lump = float(line.mass * line.length / line.segments) * G
            assert pull[:, :-1] - pull[:, 1:] == pytest.approx(
                np.tile([[0.0], [0.0], [-lump]], pull.shape[1] - 1), abs=1e-6 * lump
            )
            at_joint += pull[:, 0] if name == "tail" else -pull[:, -1]
            at_joint[2] -= 0.5 * lump
        assert at_joint == pytest.approx(np.zeros(3), abs=1e-3)
