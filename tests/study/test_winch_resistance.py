"""What drags and rubs along a line that a winch hauls: the winch keeps its tension where it stands."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, run_text, scene_of

SET, SEGMENTS, DRAG = 20e3, 20, 0.5 * 1025.0 * np.pi * 0.06 * 0.02  # N, -, N s2/m3
SIDES = {
    "end": "start = { fixed = [100, 0, 0] }\nend = { winch = { at = [0, 0, 0], tension = 20e3 } }",
    "start": "start = { winch = { at = [0, 0, 0], tension = 20e3 } }\nend = { fixed = [100, 0, 0] }",
}
STREAM = f"""
[water]
density = "1025 kg/m3"
current.velocity = [3, 0, 0]
[materials.wire]
law = "linear"
EA = "1 GN"
[lines.rope]
material = "wire"
length = "101 m"
segments = {SEGMENTS}
mass = "3 kg/m"
diameter = "60 mm"
drag = {{ normal = 1.2, tangential = 0.02 }}
"""


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("current", [3.0, -3.0])
def test_a_current_along_the_line_acts_beyond_the_winch(tmp_path, side, current):
    text = STREAM.replace("[3, 0", f"[{current}, 0") + SIDES[side] + "\n[output]\n"
    found, _ = equilibrium_of(scene_of(tmp_path, text))
    assert bool(found.converged)
    line = found.model.lines["rope"]
    tension = np.asarray(line.law.tension(line.reference_strain))
    if side == "end":
        tension = tension[::-1]
    # away from the winch, each node takes a share of the drag off the tension; half of one at the post
    drag = DRAG * current * abs(current) * 100.0
    before = (np.arange(SEGMENTS) + 0.5) / SEGMENTS
    assert tension == pytest.approx(SET - drag * before, abs=1e-3 * abs(drag))


HAULED = f"""
[materials.wire]
law = "linear"
EA = "1 MN"
damping = "5 kN s"
[lines.rope]
material = "wire"
length = "50 m"
segments = {SEGMENTS}
mass = "1 kg/m"
diameter = "50 mm"
start = {{ fixed = [50, 0, 0] }}
end = {{ winch = {{ at = [0, 0, 0], tension = "1 kN", damping = "200 N s/m" }} }}
[events.let_go]
breaks = "rope.start"
time = 0
[output]
duration = "4 s"
every = "0.1 s"
quantities = ["tension", "energy"]
"""
WATER = '[water]\ndensity = "1000 kg/m3"\n[lines.rope.drag]\nnormal = 1\ntangential = 0.1\n'
BED = 'gravity = 10\n[seabed]\nheight = 0\nstiffness = "50 kPa"\ndamping = "2 kPa s"\n'


def winch(ran):
    """Length (m), speed of hauling (m/s) and the tension at the post, half a segment on (N)."""
    tension = ran["tension"][0]
    return ran["payout"][0], -ran["payout_speed"][0], 1.5 * tension[:, -1] - 0.5 * tension[:, -2]


@pytest.mark.slow
def test_a_line_is_hauled_through_water_against_its_whole_drag(tmp_path):
    # a tenth of the line is hauled in, by which the step must be short of its bound
    ran = run_text(tmp_path, HAULED + WATER, "solver.courant=0.7")
    assert ran.statuses == ["OK"]
    length, speed, tension = (x[ran.time > 1.0] for x in winch(ran))
    # the whole line comes with the speed v of the drum: T - c v = k L v^2
    k = 0.5 * 1000.0 * np.pi * 0.05 * 0.1 * length
    expected = (np.sqrt(200.0**2 + 4.0 * k * 1e3) - 200.0) / (2.0 * k)
    # 1 %: m L v' and m v^2, the momentum that comes in, are 0.3 % of the pull, the strain 0.1 %
    assert speed == pytest.approx(expected, rel=0.01)
    assert tension == pytest.approx(1e3 - 200.0 * expected, rel=0.01)
    assert np.min(np.diff(ran.energy["lost_drag"][0])) >= 0.0
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(("friction", "stalls"), [(3.0, True), (1.0, False)])
def test_a_winch_drags_a_line_over_the_bed_if_friction_lets_it(tmp_path, friction, stalls):
    ran = run_text(tmp_path, BED.replace("damping", f"friction = {friction}\ndamping") + HAULED)
    assert ran.statuses == ["OK"]
    late = ran.time > 2.5
    length, speed, _ = (x[late] for x in winch(ran))
    if stalls:  # 3 x 500 N are more than 1 kN
        assert np.max(np.abs(speed)) < 1e-3
        # the last half segment, which the winch holds, has no friction. What is recorded leaves out the
        # dispersion correction, of which a kink of at most 3 x 25 N in the tension makes a twelfth
        assert ran["tension"][0][late, -1] == pytest.approx(1e3, abs=75.0 / 12.0)
    else:  # what is left of the pull makes it slide: T - c v = mu m g L
        assert speed == pytest.approx((1e3 - 1.0 * 10.0 * length) / 200.0, rel=0.02)
    assert ran.outcomes[0].energy_closure < 5e-3


# friction of 196 N/m holds 147 m of chain on the bed; the pull at its far end rises by 10 kN, which 51 m
# bear: the rest cannot know of it
CHAIN = """
gravity = 9.81
[seabed]
height = 0
stiffness = "400 kPa"
damping = "10 kPa s"
friction = 1.0
[materials.chain]
law = "linear"
EA = "20 MN"
damping = "40 kN s"
[lines.rope]
material = "chain"
length = "200 m"
segments = 25
mass = "20 kg/m"
diameter = "60 mm"
ENDS
[output]
duration = "20 s"
every = "0.25 s"
"""
POST = "{ fixed = [0, 0, 0] }"
DRUM = """{ winch = { at = [200, 0, 20], tension = "20 kN", damping = "5 kN s/m", \
schedule = { time = ["2 s", "15 s"], tension = ["20 kN", "30 kN"] } } }"""


@pytest.mark.slow
@pytest.mark.parametrize("side", ["end", "start"])
def test_what_friction_holds_stays_while_the_line_is_hauled_past_its_nodes(tmp_path, side):
    ends = f"start = {POST}\nend = {DRUM}" if side == "end" else f"start = {DRUM}\nend = {POST}"
    ran = run_text(tmp_path, CHAIN.replace("ENDS", ends))
    assert ran.statuses == ["OK"]
    assert ran["payout"][0, 0] - ran["payout"][0, -1] > 0.9
    anchor = ran["tension"][0, :, 0 if side == "end" else -1]
    assert anchor == pytest.approx(anchor[0], abs=0.005 * 10e3)
    # what friction takes it does not give back
    assert np.min(np.diff(ran.energy["lost_friction"][0])) > -1e-6
    assert ran.energy["lost_friction"][0, -1] > 10.0
    assert ran.outcomes[0].energy_closure < 1e-4


SHAKEN = """
[water]
density = 1025
[materials.rope]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "rope"
length = "40 m"
segments = 6
mass = "2 kg/m"
diameter = "150 mm"
added_mass = { normal = 1.0, tangential = 0.2 }
start = { fixed = [0, 0, 0] }
end = { winch = { at = "ship.post", tension = "8 kN", inertia = "20 kg" } }
[bodies.ship]
position = ["40 m", 0, 0]
points = { post = [0, 0, 0] }
[bodies.ship.motion]
surge = { amplitude = "4 m", period = "2.5 s" }
heave = { amplitude = "4 m", period = "3 s" }
ramp = "1 s"
[output]
duration = "3 s"
every = "50 ms"
"""


@pytest.mark.slow
def test_what_a_winch_pays_out_brings_the_motion_of_its_water_along(tmp_path):
    # the added mass is nine times the rope's own: left out, a tenth of all energy would be missing
    ran = run_text(tmp_path, SHAKEN, "solver.courant=0.4")
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 1e-3
