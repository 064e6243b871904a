"""Lines in waves: one that weighs as the water goes with it, taut ones bear Morison's forces."""

import numpy as np
import pytest
from engine_runs import run_text
from scipy.integrate import cumulative_trapezoid, solve_ivp

from lumpedcable.physics.sea import GRAVITY, SeaState

RHO, PERIOD = 1025.0, 8.0
OMEGA = 2.0 * np.pi / PERIOD


def scene(line, *, height, output, more="", sea="", law='law = "linear"\nEA = 1e6'):
    """A line in a regular sea along x; `height` (m) is 2 sqrt(2) times that of its one sine."""
    return f"""
[water]
density = {RHO}
[sea]
height = {height}
period = {PERIOD}
components = 1
{sea}
[materials.own]
{law}
[lines.rope]
material = "own"
{line}
{more}
[output]
{output}
"""


class Water:
    """Velocity (m/s) and acceleration (m/s2) along x and z in one sine of amplitude a (m)."""

    def __init__(self, height, depth=None):
        self.a = height / 4.0 * np.sqrt(2.0)
        self.phase = float(SeaState.of(height, PERIOD, 3.3, 1, 1).phase[0])
        self.k, self.depth = OMEGA**2 / GRAVITY, depth
        if depth is not None:
            for _ in range(200):
                self.k = OMEGA**2 / GRAVITY / np.tanh(self.k * depth)

    def __call__(self, t, x, z):
        if self.depth is None:
            level = upright = np.exp(self.k * z)
        else:
            both = self.k * (z + self.depth)
            level, upright = (f(both) / np.sinh(self.k * self.depth) for f in (np.cosh, np.sinh))
        angle = OMEGA * t - self.k * x + self.phase
        fast = self.a * OMEGA
        u, w = fast * level * np.cos(angle), -fast * upright * np.sin(angle)
        return u, w, -OMEGA * fast * level * np.sin(angle), -OMEGA * fast * upright * np.cos(angle)


DRIFTER = """
length = 0.2
segments = 2
mass = {mass}
diameter = 0.1
added_mass = {{ normal = 1.0, tangential = 0.4 }}
start = {{ fixed = [1, 0, -4] }}
end = {{ held = {{ pretension = 0.01, direction = [{direction}] }} }}
"""
LET_GO = '[events.a]\nbreaks = "rope.start"\ntime = 0\n[events.b]\nbreaks = "rope.end"\ntime = 0\n'


SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    "direction",
    ["0.6, 0, 0.8", *(pytest.param(way, marks=SLOW) for way in ("1, 0, 0", "0, 0, -1"))],
)
@pytest.mark.slow
def test_what_weighs_as_the_water_goes_with_it_however_it_lies(tmp_path, direction):
    line = DRIFTER.format(mass=RHO * np.pi * 0.1**2 / 4.0, direction=direction)
    soft = 'law = "linear"\nEA = 1000'
    output = 'duration = "8 s"\nevery = "0.2 s"\nquantities = ["position"]'
    text = scene(line, height=1.5, output=output, more=LET_GO, sea="flow = {}", law=soft)
    found = run_text(tmp_path, text)
    assert found.statuses == ["OK"]
    middle = found["position"][0] @ [1.0, 0.0, 0.0], found["position"][0] @ [0.0, 0.0, 1.0]
    x, z = (np.average(part, axis=1, weights=[1, 2, 1]) for part in middle)
    water = Water(1.5)

    def moves(t, y):
        _, _, ax, az = water(t, y[0], y[1])
        return [y[2], y[3], ax, az]

    exact = solve_ivp(moves, (0, 8), [x[0], z[0], 0, 0], t_eval=found.time, rtol=1e-9, atol=1e-9)
    assert np.ptp(exact.y[0]) > 1.0
    np.testing.assert_allclose(x, exact.y[0], atol=2e-3)
    np.testing.assert_allclose(z, exact.y[1], atol=2e-3)


def taut(top, bottom, segments, length):
    return f"""
length = {length}
segments = {segments}
mass = 10.0
diameter = 0.05
drag = {{ normal = 1.2, tangential = 0.0 }}
added_mass = {{ normal = 1.0 }}
start = {{ fixed = [0, 0, {bottom}] }}
end = {{ fixed = [0, 0, {top}] }}
"""


@pytest.mark.parametrize("depth", [pytest.param(None, marks=SLOW), 12.0])
@pytest.mark.slow
def test_a_taut_upright_line_swings_as_a_string_under_morisons_forces(tmp_path, depth):
    length, stretch, EA, height = 4.0, 2.0, 2e3, 4.0  # unstretched; over that; N; m
    line = taut(-1.0, -9.0, 40, length)
    more = "" if depth is None else f"depth = {depth}\n"
    output = 'duration = "16 s"\nevery = "0.5 s"\nquantities = ["position", "energy"]'
    law = f'law = "linear"\nEA = {EA}\nmax_strain = 2'
    text = scene(line, height=height, output=output, sea=more + 'flow = { ramp = "8 s" }', law=law)
    found = run_text(tmp_path, text)
    assert found.statuses == ["OK"]
    assert found.outcomes[0].energy_closure < 2e-3
    assert found.attributes["coordinates"] == 2
    # the same string by finite differences of its own: m y'' = (T / stretch) d2y/ds2 + f
    count, water = 60, Water(height, depth)
    step = length / count
    z = -9.0 + stretch * np.linspace(0.0, length, count + 1)[1:-1]
    section = RHO * np.pi * 0.05**2 / 4.0
    pull = EA * (stretch - 1.0) / stretch / step**2

    def swings(t, y):
        way, speed = np.split(y, 2)
        share = np.sin(np.pi * min(t, 8.0) / 16.0) ** 2
        u, _, a, _ = water(t, way, z)
        u, a = share * u - speed, share * a
        bent = np.diff(np.concatenate([[0.0], way, [0.0]]), 2) * pull
        force = bent + 2.0 * section * a + 0.5 * RHO * 0.05 * 1.2 * np.abs(u) * u
        return np.concatenate([speed, force / (10.0 + section)])

    start = np.zeros(2 * (count - 1))
    exact = solve_ivp(swings, (0, 16), start, t_eval=found.time, rtol=1e-6, atol=1e-8)
    way = found["position"][0, :, 20, 0]
    middle = exact.y[29]
    assert np.abs(middle).max() > 0.02
    # the line's own tension changes by some 0.5 % as it swings, and water pushes along it
    np.testing.assert_allclose(way, middle, atol=0.01 * np.abs(middle).max())


@pytest.mark.slow
def test_along_a_level_line_the_tension_falls_by_what_pushes_it(tmp_path):
    half, height, diameter = 25.0, 3.0, 0.5
    line = f"""
length = {2.0 * half * (1.0 - 1e-3)}
segments = 20
mass = 200.0
diameter = {diameter}
added_mass = {{ normal = 1.0, tangential = 0.5 }}
start = {{ fixed = [{-half}, 0, -8] }}
end = {{ fixed = [{half}, 0, -8] }}
"""
    output = 'duration = "12 s"\nevery = "0.25 s"\nquantities = ["tension", "energy"]'
    stiff = 'law = "linear"\nEA = 1e9'
    found = run_text(
        tmp_path,
        scene(line, height=height, output=output, sea='flow = { ramp = "4 s" }', law=stiff),
    )
    assert found.statuses == ["OK"]
    assert {"work_waves"} <= found.energy.keys()
    tension = found["tension"][0]
    x = np.linspace(-half, half, 2001)
    per_metre = 1.5 * RHO * np.pi * diameter**2 / 4.0  # rho A + C_t rho A
    water, middles = Water(height), np.linspace(-half, half, 41)[1::2]
    late = found.time >= 6.0
    for t, row in zip(found.time[late], tension[late], strict=True):
        _, _, push, _ = water(t, x, -8.0)
        fallen = -cumulative_trapezoid(per_metre * push, x, initial=0.0)
        wanted = np.interp(middles, x, fallen)
        # ends that do not move leave the mean as it is, up to what the line sags
        np.testing.assert_allclose(row - row.mean(), wanted - wanted.mean(), atol=75.0)
    assert np.ptp(tension[late], axis=1).max() > 3500.0


RODS = """
length = 8
segments = 8
mass = 12.0
diameter = 0.1
drag = { normal = 1.0, tangential = 0.02 }
added_mass = { normal = 1.0 }
start = { fixed = [0, 0, -2] }
end = "free"
"""
SWUNG = 'duration = "6 s"\nevery = "0.5 s"\nquantities = ["position", "tension", "energy"]'


def hanging(law, *, more="", sea="flow = {}"):
    text = scene(RODS, height=2.0, output=SWUNG, sea=sea, law=law, more=more)
    return "gravity = 9.81\n" + text


@pytest.mark.slow
def test_rods_swing_in_waves_as_a_stiff_line_does(tmp_path):
    found, smooth = [], 'flow = { ramp = "4 s" }'
    for law, step in (('law = "inextensible"', '[solver]\nstep = "2 ms"\n'),
                      ('law = "linear"\nEA = 5e6', "")):  # fmt: skip
        text = hanging(law, more=step, sea=smooth).replace("mass = 12.0", "mass = 30.0")
        found.append(run_text(tmp_path, text))
    rods, stiff = found
    assert rods.statuses == stiff.statuses == ["OK"]
    tip = rods["position"][0, :, -1]
    assert np.ptp(tip[:, 0]) > 0.2
    # both are within 3 mm of finer meshes
    np.testing.assert_allclose(tip, stiff["position"][0, :, -1], atol=6e-3)
    assert rods.outcomes[0].energy_closure < 5e-3


@SLOW
@pytest.mark.parametrize("solver", ['method = "rk4"', 'method = "tsit5"'])
def test_other_methods_swing_alike(tmp_path, solver):
    soft = 'law = "linear"\nEA = 1e5'
    plain = run_text(tmp_path, hanging(soft))
    other = run_text(tmp_path, hanging(soft, more=f"[solver]\n{solver}\n"))
    assert other.statuses == ["OK"]
    np.testing.assert_allclose(other["position"], plain["position"], atol=2e-3)


@pytest.mark.slow
def test_waves_across_a_plane_move_its_line_out_of_it(tmp_path):
    soft = 'law = "linear"\nEA = 1e5'
    along = run_text(tmp_path, hanging(soft))
    across = run_text(tmp_path, hanging(soft, sea='flow = {}\ndirection = "90 deg"'))
    assert along.attributes["coordinates"] == across.attributes["coordinates"] == 2
    tip, turned = (found["position"][0, :, -1] for found in (along, across))
    np.testing.assert_allclose(turned[:, [1, 2]], tip[:, [0, 2]], atol=1e-12)
    assert np.all(turned[:, 0] == 0.0)


@pytest.mark.slow
def test_at_rest_no_wave_has_come_and_each_run_of_a_sweep_has_its_own(tmp_path):
    soft = 'law = "linear"\nEA = 1e5'
    sweep = '[sweep]\n"sea.height" = [1.0, 2.0]\n'
    both = run_text(tmp_path, hanging(soft, more=sweep))
    one = run_text(tmp_path, hanging(soft))
    np.testing.assert_allclose(both["position"][1], one["position"][0], atol=1e-12)
    assert np.abs(both["position"][0, -1] - one["position"][0, -1]).max() > 0.05
    rest = run_text(tmp_path, hanging(soft), "output={}")
    np.testing.assert_allclose(rest["position"][0, 0, :, 0], 0.0, atol=1e-12)


@pytest.mark.slow
def test_a_winch_keeps_its_tension_where_the_line_comes_in_whatever_pushes_along_it(tmp_path):
    pull, length, diameter = 50e3, 50.0, 0.2
    line = f"""
length = {length}
segments = 20
mass = 30.0
diameter = {diameter}
added_mass = {{ normal = 1.0, tangential = 0.5 }}
start = {{ fixed = [{length}, 0, -6] }}
end = {{ winch = {{ at = [0, 0, -6], tension = {pull}, damping = 500.0 }} }}
"""
    output = 'duration = "12 s"\nevery = "0.25 s"\nquantities = ["tension", "energy"]'
    law = 'law = "linear"\nEA = 1e8'
    smooth = 'flow = { ramp = "4 s" }'
    found = run_text(tmp_path, scene(line, height=1.5, output=output, sea=smooth, law=law))
    assert found.statuses == ["OK"]
    assert found.outcomes[0].energy_closure < 5e-3
    x, water, late = np.linspace(0.0, length, 1001), Water(1.5), found.time >= 6.0
    middles = np.linspace(length, 0.0, 41)[1::2]
    per_metre = 1.5 * RHO * np.pi * diameter**2 / 4.0
    for t, row in zip(found.time[late], found["tension"][0][late], strict=True):
        _, _, push, _ = water(t, x, -6.0)
        along = pull - cumulative_trapezoid(per_metre * push, x, initial=0.0)
        np.testing.assert_allclose(row, np.interp(middles, x, along), atol=20.0)
    assert np.ptp(found["tension"][0][late], axis=1).max() > 300.0
