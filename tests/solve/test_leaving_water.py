"""Lines that the water's surface crosses, at rest and in motion, against equations of their own."""

import jax
import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, run_text, scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from lumpedcable import response
from lumpedcable.physics.sea import GRAVITY, SeaState

G, RHO, D, EA = 9.81, 1025.0, 0.1, 2e6
LIFT = RHO * G * np.pi * D**2 / 4.0


def scene(line, *, surface=0.0, mass=15.0, law=f'law = "linear"\nEA = {EA}', output="", more=""):
    """A rope of which what is above the `surface` (m) is dry; it does not move without `output`."""
    return f"""
gravity = {G}
[water]
density = {RHO}
surface = {surface}
[materials.own]
{law}
[lines.rope]
material = "own"
mass = {mass}
diameter = {D}
{line}
{more}
[output]
{output}
"""


def nodes_of(tmp_path, *args, **kwargs):
    return nodes_in_space(*equilibrium_of(scene_of(tmp_path, scene(*args, **kwargs)))).T


HANGS = 'length = 40\nsegments = {n}\nstart = {{ fixed = [0, 0, 12.345] }}\nend = "free"'


def test_a_line_that_hangs_into_water_stretches_as_hooke_has_it(tmp_path):
    # N(s) is what lies below: w per metre, b less where it is wet; z(s) = top - s - int N / EA
    w, length, top = 15.0 * G, 40.0, 12.345

    def bottom(s_wet, s):
        """How far down (m) the place s is if the line is wet from s_wet on."""
        dry = min(s, s_wet)
        below = w * (length * s - 0.5 * s**2)
        lifted = LIFT * ((length - s_wet) * dry)
        if s > s_wet:
            lifted += LIFT * (0.5 * (length - s_wet) ** 2 - 0.5 * (length - s) ** 2)
        return s + (below - lifted) / EA

    s_wet = brentq(lambda s: bottom(s, s) - top, 1.0, 39.0)
    z = nodes_of(tmp_path, HANGS.format(n=40))[:, 2]
    exact = top - np.array([bottom(s_wet, s) for s in np.linspace(0.0, length, 41)])
    # lumps share out a segment's weight evenly, which is exact at the nodes but for the wet one's
    np.testing.assert_allclose(z, exact, atol=1e-5)
    wetted = nodes_of(tmp_path, HANGS.format(n=40), surface=100.0)[:, 2]
    assert np.max(np.abs(z - wetted)) > 1e-3


def string(length, start, end, mass):
    """x(s), z(s) of an elastic string: P' = (w - b [z < 0]) up, r' = P / |P| (1 + |P| / EA)."""
    w = mass * G

    def slopes(_, y):
        pull = np.hypot(y[2], y[3])
        way = y[2:] / pull * (1.0 + pull / EA)
        share = np.clip(0.5 - y[1] / (0.001 * D), 0.0, 1.0)
        return [way[0], way[1], 0.0, w - LIFT * share]

    def shape(pull):
        return solve_ivp(
            slopes, (0.0, length), [*start, *pull], rtol=1e-9, atol=1e-9, max_step=0.2,
            dense_output=True,
        ).sol  # fmt: skip

    found = root(lambda pull: shape(pull)(length)[:2] - end, [3e3, -4e3], tol=1e-8)
    assert found.success
    return shape(found.x)


SPANS = """
length = 70
segments = {n}
start = {{ fixed = [0, 0, 15.2] }}
end = {{ fixed = [50, 0, -25.4] }}
"""


@pytest.mark.slow
def test_a_line_from_a_deck_into_water_hangs_as_its_equations_have_it(tmp_path):
    sol = string(70.0, (0.0, 15.2), np.array([50.0, -25.4]), 15.0)
    errors = []
    for n in (40, 80):
        nodes = nodes_of(tmp_path, SPANS.format(n=n))
        exact = sol(np.linspace(0.0, 70.0, n + 1))[:2].T
        errors.append(np.abs(nodes[:, [0, 2]] - exact).max())
    assert errors[1] < 3e-3
    assert errors[1] < errors[0] / 3.0
    under = nodes_of(tmp_path, SPANS.format(n=80), surface=50.0)
    assert np.abs(under - nodes).max() > 0.3


FLOATS = """
length = 70
segments = {n}
start = {{ fixed = [0, 0, 6.3] }}
end = {{ fixed = [60, 0, 6.3] }}
"""


def test_a_light_rope_between_two_decks_floats_where_it_weighs_as_the_water(tmp_path):
    w, n = 5.0 * G, 140
    # wet to the share w / b, the middle of the rope that much below the surface
    afloat = D * (0.5 - w / LIFT)
    nodes = nodes_of(tmp_path, FLOATS.format(n=n), mass=5.0)
    np.testing.assert_allclose(nodes[n // 3 : -n // 3, 2], afloat, atol=1e-5)
    # it hangs from the decks as an elastic catenary: T + T^2 / (2 EA) grows by w times the rise, less
    # what the water carries over the height in which the rope comes out of it
    tension = EA * (np.linalg.norm(np.diff(nodes, axis=0), axis=1) / (70.0 / n) - 1.0)
    middle, first = tension[n // 2], tension[0]
    rise = 0.5 * (nodes[0, 2] + nodes[1, 2]) - afloat
    assert rise > 5.5
    grown = first + first**2 / (2.0 * EA) - middle - middle**2 / (2.0 * EA)
    np.testing.assert_allclose(grown, w * rise - 0.5 * D * w**2 / LIFT, rtol=2e-3)


# a heavy rope, stiff, that hangs from a soft one: one degree of freedom
WIDE, MASS, LONG, SPRING = 0.5, 250.0, 8.0, 4000.0  # m, kg/m, m, N/m
SECTION = np.pi * WIDE**2 / 4.0


def bounce(top, *, segments, sea="", drag="", output):
    return f"""
gravity = {G}
[water]
density = {RHO}
surface = 0
{sea}
[materials.soft]
law = "linear"
EA = {20.0 * SPRING}
[materials.stiff]
law = "linear"
EA = 1e8
[lines.spring]
material = "soft"
length = 20
segments = 1
mass = 1e-3
diameter = 1e-3
start = {top}
end = "ring"
[lines.rope]
material = "stiff"
length = {LONG}
segments = {segments}
mass = {MASS}
diameter = {WIDE}
{drag}
start = "ring"
end = "free"
[bodies.ring]
mass = 1e-3
[output]
{output}
"""


def at_rest(top):
    """Height (m) of the heavy rope's top at rest under a top at a height (m)."""
    # SPRING (top - 20 - y) + RHO G SECTION (LONG - y) = MASS LONG G
    water = RHO * G * SECTION
    return (SPRING * (top - 20.0) + water * LONG - MASS * LONG * G) / (SPRING + water)


def swung(t, y0, force, mass):
    """Heights (m) at times t (s) of what starts at rest at y0 (m) under a force(t, y, v) (N)."""
    sol = solve_ivp(
        lambda t, y: [y[1], force(t, *y) / mass(t, y[0])], (0.0, t[-1]), [y0, 0.0], t_eval=t,
        rtol=1e-9, atol=1e-9, max_step=0.02,
    )  # fmt: skip
    return sol.y[0]


TOP = 26.0
PERIOD = 4.0


@pytest.mark.parametrize("segments", [3, 16])
@pytest.mark.slow
def test_a_rope_on_a_soft_one_dips_in_and_out_as_one_mass(tmp_path, segments):
    sways = f'position = [0, 0, {TOP}], amplitude = [0, 0, 2.0], period = "{PERIOD} s"'
    top = f"{{ motion = {{ {sways} }} }}"
    drag = "drag = { normal = 0, tangential = 0.05 }\nadded_mass = { normal = 1, tangential = 0.3 }"
    output = 'duration = "12 s"\nevery = "0.2 s"'
    ran = run_text(tmp_path, bounce(top, segments=segments, drag=drag, output=output))
    assert ran.statuses == ["OK"]
    y = ran["rope.position"][0, :, 0, 2]
    added = 0.3 * RHO * SECTION
    resists = 0.5 * RHO * np.pi * WIDE * 0.05

    def wet(y):
        return np.clip(LONG - y, 0.0, LONG)

    def force(t, y, v):
        pull = SPRING * (TOP + 2.0 * np.sin(2.0 * np.pi * t / PERIOD) - y - 20.0)
        return pull - MASS * LONG * G + wet(y) * (RHO * G * SECTION - resists * np.abs(v) * v)

    exact = swung(ran.time, at_rest(TOP), force, lambda _, y: MASS * LONG + added * wet(y))
    assert np.ptp(exact) > 2.0
    np.testing.assert_allclose(y, exact, atol=0.01)
    assert ran.outcomes[0].energy_closure < 1e-3


@pytest.mark.slow
def test_waves_lift_a_rope_as_they_rise_along_it(tmp_path):
    # they wet it, lift it and push it as they accelerate; so low that they hardly swing it sideways
    height, period = 0.3, 12.0
    sea = f"[sea]\nheight = {height}\nperiod = {period}\ncomponents = 1\nflow = {{}}\n"
    output = 'duration = "20 s"\nevery = "0.5 s"'
    top = f"{{ fixed = [0, 0, {TOP}] }}"
    ran = run_text(tmp_path, bounce(top, segments=64, sea=sea, output=output))
    assert ran.statuses == ["OK"]
    y = ran["rope.position"][0, :, 0, 2]
    omega = 2.0 * np.pi / period
    k, phase = omega**2 / GRAVITY, float(SeaState.of(height, period, 3.3, 1, 1).phase[0])
    amplitude = height / 4.0 * np.sqrt(2.0)

    def risen(t):
        return amplitude * np.cos(omega * t + phase)

    def force(t, y, _):
        low, high = y - LONG, risen(t)
        # the upward acceleration -a w^2 cos e^kz up to z = 0, and as there above it
        under = (np.exp(k * min(high, 0.0)) - np.exp(k * low)) / k + max(high, 0.0)
        push = -RHO * SECTION * omega**2 * risen(t) * under
        pull = SPRING * (TOP - y - 20.0)
        return pull - MASS * LONG * G + RHO * G * SECTION * (high - low) + push

    exact = swung(ran.time, at_rest(TOP), force, lambda *_: MASS * LONG)
    still = swung(ran.time, at_rest(TOP), lambda t, y, v: 0.0 * t, lambda *_: 1.0)
    assert np.abs(exact - still).max() > 0.05
    np.testing.assert_allclose(y, exact, atol=0.01 * np.ptp(exact))
    assert ran.outcomes[0].energy_closure < 2e-3


CROSSING = """
length = 30
segments = 30
drag = {{ normal = 1.2, tangential = 0.01 }}
added_mass = {{ normal = 1.0, tangential = 0.1 }}
start = {{ fixed = [0, 0, 6] }}
end = {{ held = {{ pretension = {pull}, direction = [1, 0, {up}] }} }}
"""
FALLS = '[events.go]\nbreaks = "rope.end"\ntime = "0.1 s"\n'


@pytest.mark.slow
def test_a_rope_that_is_let_go_falls_into_water_and_its_account_closes(tmp_path):
    output = 'duration = "3 s"\nevery = "50 ms"'
    law = f'law = "linear"\nEA = {EA}\ntension_only = true'
    text = scene(CROSSING.format(pull=5e3, up=0.4), law=law, output=output, more=FALLS)
    dry = run_text(tmp_path, text, "water.surface=-1000")
    ran = run_text(tmp_path, text, "water.surface=0")
    wet = run_text(tmp_path, text, "water.surface=1000")
    for each in (dry, ran, wet):
        assert each.statuses == ["OK"]
        assert each.outcomes[0].energy_closure < 2e-3
    ends = [each["rope.position"][0, -1, -1] for each in (dry, ran, wet)]
    assert np.linalg.norm(ends[0] - ends[1]) > 1.0
    assert np.linalg.norm(ends[1] - ends[2]) > 1.0


@pytest.mark.slow
def test_far_above_the_water_nothing_of_it_is_felt_and_far_below_it_is_everywhere(tmp_path):
    output = 'duration = "0.6 s"\nevery = "50 ms"'
    law = f'law = "linear"\nEA = {EA}\ntension_only = true'
    text = scene(CROSSING.format(pull=5e3, up=0.4), law=law, output=output, more=FALLS)
    dry = run_text(tmp_path, text, "water.surface=-1000")
    wet = run_text(tmp_path, text, "water.surface=1000")
    without = text.replace("surface = 0.0\n", "")
    everywhere = run_text(tmp_path, without)
    gap = wet["rope.position"] - everywhere["rope.position"]
    assert np.abs(gap).max() < 1e-9
    air = run_text(tmp_path, without.replace(str(RHO), "1e-9"))
    gap = dry["rope.position"] - air["rope.position"]
    assert np.abs(gap).max() < 1e-9


HAULED = f"""
gravity = {G}
[water]
density = {RHO}
surface = 0
[materials.wire]
law = "linear"
EA = 1e6
[lines.wire]
material = "wire"
length = 34
segments = 12
mass = 20
diameter = 0.12
drag = {{ normal = 1.2, tangential = 0.02 }}
added_mass = {{ normal = 1, tangential = 0.2 }}
start = {{ winch = {{ at = [0, 0, 10], tension = "9 kN", inertia = 200 }} }}
end = {{ motion = {{ position = [8, 0, -20], amplitude = [0, 0, 2], period = "4 s" }} }}
[output]
duration = "4 s"
every = "0.1 s"
"""


@pytest.mark.slow
def test_a_winch_hauls_a_line_out_of_the_water_and_its_account_closes(tmp_path):
    ran = run_text(tmp_path, HAULED + '[solver]\nstep = "5 ms"\n')
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 2e-3
    # with lighter water it keeps the line with less of it out
    light = run_text(tmp_path, HAULED.replace(f"density = {RHO}", "density = 1"))
    length = [
        np.linalg.norm(np.diff(each["position"][0, 0], axis=0), axis=1).sum()
        for each in (ran, light)
    ]
    assert abs(length[0] - length[1]) > 0.05


@pytest.mark.slow
def test_what_it_does_has_the_derivatives_of_its_differences(tmp_path):
    path = tmp_path / "scene.toml"
    text = scene(
        CROSSING.format(pull=5e3, up=0.4), output='duration = "0.8 s"\nevery = "0.1 s"', more=FALLS
    )
    path.write_text(text, encoding="utf-8")
    keys = ["water.surface", "lines.rope.diameter", "water.density"]
    of = response(path, keys, "last position at rope.end in z")
    at = np.asarray(of.values)
    slopes = np.asarray(jax.jit(jax.jacfwd(of))(at))
    for k, h in enumerate((1e-4, 1e-6, 1e-2)):
        more, less = at.copy(), at.copy()
        more[k], less[k] = at[k] + h, at[k] - h
        slope = float(of(more) - of(less)) / (2.0 * h)
        assert slopes[k] == pytest.approx(slope, rel=1e-4)


@pytest.mark.slow
def test_single_precision_sees_the_same(tmp_path):
    output = 'duration = "0.8 s"\nevery = "0.1 s"'
    text = scene(CROSSING.format(pull=5e3, up=0.4), output=output, more=FALLS)
    double = run_text(tmp_path, text)["position"]
    single = run_text(tmp_path, text, "solver.dtype=float32")["position"]
    np.testing.assert_allclose(single, double, atol=2e-3)
