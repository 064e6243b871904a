"""Lines that a winch keeps taut, at rest: as long as the elastic catenary of the winch's tension."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, scene_of
from scipy.optimize import fsolve

from lumpedcable.model.couple import winch_name

WEIGHT, SEGMENTS = 4.0 * 9.81, 40  # N/m
LEVEL = f"""
dimensions = 3
gravity = "9.81 m/s2"
[materials.wire]
law = "linear"
EA = "50 MN"
[lines.rope]
material = "wire"
length = "60 m"
segments = {SEGMENTS}
mass = "4 kg/m"
start = {{ winch = {{ at = [0, 0, 0], tension = "5 kN" }} }}
end = {{ fixed = ["58 m", 0, 0] }}
[output]
"""


def catenary(span, rise, tension, EA):
    """Length (m) of an elastic catenary across span and rise (m) with this tension (N) at its top."""

    def miss(x):
        angle, length = x
        H, V = tension * np.cos(angle), tension * np.sin(angle)
        foot = V - WEIGHT * length
        across = H * length / EA + H / WEIGHT * (np.arcsinh(V / H) - np.arcsinh(foot / H))
        up = (tension - np.hypot(H, foot)) / WEIGHT + (V**2 - foot**2) / (2.0 * EA * WEIGHT)
        return across - span, up - rise

    chord = np.hypot(span, rise)
    guess = np.arctan2(rise, span) + WEIGHT * chord / (2.0 * tension), chord
    found, _, code, _ = fsolve(miss, guess, full_output=True, xtol=1e-12)
    assert code == 1
    return float(found[1])


# a winch at the level of the other end, and one that stands above it and over it to the side
PLACES = {
    "level": ((), 58.0, 0.0),
    "above": (
        ("rope.start.winch.at=[0, 0, 0]", "rope.end.fixed=[48, 36, -80]"), 60.0, 80.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("tension", [2e3, 5e3, 20e3])
@pytest.mark.parametrize("EA", [1e6, 50e6, 1e9])
def test_a_sagging_line_is_as_long_as_its_catenary(tmp_path, where, tension, EA):
    sets, span, rise = PLACES[where]
    if rise:
        tension += WEIGHT * rise
    found, _ = equilibrium_of(
        scene_of(tmp_path, LEVEL, f"wire.EA={EA}", f"winch.tension={tension}", *sets)
    )
    # Newton's method has next to nothing left to do, however stiff the line
    assert bool(found.converged)
    assert int(found.iterations) <= 3
    length = catenary(span, rise, tension, EA)
    bent = catenary(span, rise, tension, 1e15) - np.hypot(span, rise)
    # a polygon of n sides is 1/n^2 of what the arc is longer than its chord shorter than the arc
    owed = 2.0 * bent / SEGMENTS**2
    assert float(found.model.bodies[winch_name("rope")].reference[0]) == pytest.approx(
        length, abs=owed
    )


@pytest.mark.slow  # a quarter of a minute of compiling
def test_a_mooring_line_on_a_winch_lies_where_its_catenary_touches_down(tmp_path):
    depth, span, tension, weight = 60.0, 280.0, 20e3, 98.1
    text = (
        LEVEL.replace('mass = "4', 'mass = "10') + '[seabed]\nheight = -60\nstiffness = "1 MPa"\n'
    )
    where = ("start.winch.tension=20 kN", "rope.end.fixed=[280, 0, -60]", "wire.EA=1 GN")
    found, _ = equilibrium_of(scene_of(tmp_path, text, *where, "rope.segments=80"))
    assert bool(found.converged)
    assert int(found.iterations) <= 5
    H = tension - weight * depth
    hung = np.sqrt(depth**2 + 2.0 * depth * H / weight)
    across = H / weight * np.arcsinh(weight * hung / H)
    length = hung + span - across
    # not in the closed form: the mesh (1/40^2 of the hanging part's slack, a segment that lies half),
    # the sink of 0.1 mm and the stretch of T / EA = 2e-5
    slack = hung - np.hypot(across, depth)
    owed = 2.0 * slack / 40**2 + length * tension / 1e9
    assert float(found.model.bodies[winch_name("rope")].reference[0]) == pytest.approx(
        length, abs=owed
    )
