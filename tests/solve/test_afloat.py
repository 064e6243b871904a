"""Bodies at the water's surface: how deep they float, how they heave and roll, how they fall in."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, run_text, scene_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from lumpedcable.physics.sea import GRAVITY, SeaState

G, RHO = 9.81, 1000.0


def scene(body, *, line, output="", more=""):
    """A body `buoy` with a line at it."""
    return f"""
gravity = {G}
[water]
density = {RHO}
surface = 0.5
[materials.chain]
law = "linear"
EA = 1e8
[lines.chain]
material = "chain"
mass = 20
diameter = 0.02
{line}
[bodies.buoy]
{body}
{more}
[output]
{output}
"""


def cap(height, radius):
    """The share of a ball whose middle is at a height (m) over water that is wet."""
    x = np.clip(height / radius, -1.0, 1.0)
    return 0.25 * (2.0 - 3.0 * x + x**3)


HANGS = 'length = 30\nsegments = 10\nstart = "buoy"\nend = "free"\n'
CHAIN = 20.0 - RHO * np.pi * 0.02**2 / 4.0  # kg/m in water


def floating_height(carried, volume):
    """Height (m) over the water of a ball's middle that carries a share of what it could."""
    radius = (0.75 * volume / np.pi) ** (1.0 / 3.0)
    return brentq(lambda h: cap(h, radius) - carried, -radius, radius)


# the chain's uppermost half metre may be dry: two per mille of what it weighs
DEEP = floating_height((300.0 + 30.0 * CHAIN) / (RHO * 2.0), 2.0)


def test_a_point_floats_as_deep_as_what_hangs_from_it_takes_it(tmp_path):
    text = scene("mass = 300\nvolume = 2", line=HANGS)
    found, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert found.converged
    z = nodes_in_space(found, coordinates, "chain")[2, 0]
    assert z == pytest.approx(0.5 + DEEP, abs=1e-3)


@pytest.mark.slow
def test_a_ball_that_settles_floats_as_deep_as_what_hangs_from_it_takes_it(tmp_path):
    body = 'position = [0, 0, 2]\nfree = ["z"]\nsettle = true\npoints = { eye = [0, 0, 0] }'
    text = scene(
        "mass = 300\nvolume = 2\n" + body, line=HANGS.replace('"buoy"', '"buoy.eye"'),
        output='duration = "0.1 s"\nevery = "0.1 s"',
    )  # fmt: skip
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    z = ran.bodies["buoy"]["position"][0, :, 2]
    np.testing.assert_allclose(z, 0.5 + DEEP, atol=1e-3)


BOX = np.array([4.0, 2.0, 1.0])
DRAUGHT = 0.4
MASS = RHO * np.prod(BOX) * DRAUGHT / BOX[2]
FLOATING = 0.5 + 0.5 * BOX[2] - DRAUGHT
LINE = """
length = 1
segments = 1
start = {{ fixed = [0, 0, {z}] }}
end = "free"
"""
# far away, where it is nothing but the line that a scene has to have
ASIDE = LINE.format(z=50)
AFLOAT = f"""
mass = {MASS}
volume = {np.prod(BOX)}
size = {BOX.tolist()}
"""


def test_a_box_heaves_as_its_waterplane_has_it(tmp_path):
    body = AFLOAT + f'position = [0, 0, {FLOATING + 0.05}]\nfree = ["z"]'
    ran = run_text(tmp_path, scene(body, line=ASIDE, output='duration = "6 s"\nevery = "50 ms"'))
    assert ran.statuses == ["OK"]
    omega = np.sqrt(RHO * G * BOX[0] * BOX[1] / MASS)
    exact = FLOATING + 0.05 * np.cos(omega * ran.time)
    np.testing.assert_allclose(ran.bodies["buoy"]["position"][0, :, 2], exact, atol=2e-4)
    assert ran.outcomes[0].energy_closure < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("way", [0, 1])
def test_a_box_rolls_and_pitches_as_its_metacentre_has_it(tmp_path, way):
    name, angle = ("roll", "pitch")[way], 0.01
    attitude = [0.0, 0.0, 0.0]
    attitude[way] = angle
    body = AFLOAT + f'position = [0, 0, {FLOATING}]\nattitude = {attitude}\nfree = ["{name}", "z"]'
    ran = run_text(tmp_path, scene(body, line=ASIDE, output='duration = "6 s"\nevery = "50 ms"'))
    assert ran.statuses == ["OK"]
    breadth = BOX[1 - way]
    gm = 0.5 * DRAUGHT + breadth**2 / (12.0 * DRAUGHT) - 0.5 * BOX[2]
    inertia = MASS / 12.0 * (breadth**2 + BOX[2] ** 2)
    omega = np.sqrt(MASS * G * gm / inertia)
    exact = angle * np.cos(omega * ran.time)
    np.testing.assert_allclose(ran.bodies["buoy"]["attitude"][0, :, way], exact, atol=2e-4)


@pytest.mark.slow
def test_a_box_heaves_with_what_it_takes_along_of_the_water(tmp_path):
    # as much as belongs to the share of it that is wet, MASS / (RHO V) of C RHO V at rest
    body = AFLOAT + f'position = [0, 0, {FLOATING + 0.005}]\nadded_mass = [0, 0, 0.8]\nfree = ["z"]'
    ran = run_text(tmp_path, scene(body, line=ASIDE, output='duration = "6 s"\nevery = "50 ms"'))
    assert ran.statuses == ["OK"]
    omega = np.sqrt(RHO * G * BOX[0] * BOX[1] / (1.8 * MASS))
    exact = FLOATING + 0.005 * np.cos(omega * ran.time)
    np.testing.assert_allclose(ran.bodies["buoy"]["position"][0, :, 2], exact, atol=5e-5)
    assert ran.outcomes[0].energy_closure < 1e-5


@pytest.mark.parametrize("added", [0.0, 1.2])
def test_a_box_falls_freely_until_it_is_wet(tmp_path, added):
    body = AFLOAT + 'position = [0, 0, 6]\ndrag = [1, 1, 1]\nfree = ["x", "y", "z"]'
    if added:
        body += f"\nadded_mass = [0.3, 0.3, {added}]"
    ran = run_text(tmp_path, scene(body, line=ASIDE, output='duration = "4 s"\nevery = "20 ms"'))
    assert ran.statuses == ["OK"]
    t, z = ran.time, ran.bodies["buoy"]["position"][0, :, 2]
    touches = np.sqrt(2.0 * 5.0 / G)  # its bottom is five metres over the water

    def moves(_, y):
        share = np.clip((0.5 - y[0]) / BOX[2] + 0.5, 0.0, 1.0)
        drag = 0.5 * RHO * BOX[0] * BOX[1] * share * abs(y[1]) * y[1]
        wet = RHO * np.prod(BOX) * share
        return [y[1], (-MASS * G + wet * G - drag) / (MASS + added * wet)]

    exact = solve_ivp(moves, (0, 4), [6.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-9, max_step=5e-3)
    dry = t < touches
    np.testing.assert_allclose(z[dry], 6.0 - 0.5 * G * t[dry] ** 2, atol=1e-9)
    np.testing.assert_allclose(z, exact.y[0], atol=0.01)
    assert ran.outcomes[0].energy_closure < 5e-3


@pytest.mark.slow
@pytest.mark.parametrize("added", [0.0, 0.5])
def test_a_buoy_rides_on_waves(tmp_path, added):
    height, period, mass, volume = 2.0, 6.0, 400.0, 1.0
    sea = f"[sea]\nheight = {height}\nperiod = {period}\ncomponents = 1\n"
    sea += "flow = { surface = 0.5 }\n"
    body = f'mass = {mass}\nvolume = {volume}\nposition = [0, 0, 0.5]\nfree = ["z"]\nsettle = true'
    body += f"\nadded_mass = [0, 0, {added}]" if added else ""
    text = scene(body, line=ASIDE, output='duration = "20 s"\nevery = "0.1 s"', more=sea)
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    z = ran.bodies["buoy"]["position"][0, :, 2] - 0.5
    radius = (0.75 * volume / np.pi) ** (1.0 / 3.0)
    rest = floating_height(mass / (RHO * volume), volume)
    omega = 2.0 * np.pi / period
    k, phase = omega**2 / GRAVITY, float(SeaState.of(height, period, 3.3, 1, 1).phase[0])
    amplitude = height / 4.0 * np.sqrt(2.0)

    def moves(t, y):
        risen = amplitude * np.cos(omega * t + phase)
        share = cap(y[0] - risen, radius)
        surge = -(omega**2) * risen * np.exp(k * min(y[0], 0.0))
        wet = RHO * volume * share
        push = wet * G + (1.0 + added) * wet * surge
        return [y[1], (-mass * G + push) / (mass + added * wet)]

    exact = solve_ivp(
        moves, (0, 20), [rest, 0.0], t_eval=ran.time, rtol=1e-9, atol=1e-9, max_step=0.02
    )
    assert np.ptp(exact.y[0]) > amplitude
    np.testing.assert_allclose(z, exact.y[0], atol=0.01 * amplitude)
    assert ran.outcomes[0].energy_closure < 2e-3


TUMBLES = (
    AFLOAT
    + """
position = [0, 0, 1.2]
attitude = [0.3, -0.2, 0.1]
velocity = [1.5, -0.5, 1]
inertia = [1500, 4500, 5000]
added_mass = [0.1, 0.4, 1.2]
drag = [0.5, 0.8, 1]
"""
)


@pytest.mark.slow
def test_the_account_of_a_box_that_tumbles_in_waves_closes_with_the_square_of_the_step(tmp_path):
    sea = "[sea]\nheight = 1.5\nperiod = 4\ncomponents = 3\nflow = { surface = 0.5 }\n"
    output = 'duration = "4 s"\nevery = "0.1 s"\n[solver]\nstep = '
    closures = []
    for step in (4e-4, 2e-4):
        text = scene(TUMBLES, line=ASIDE, output=f"{output}{step}", more=sea)
        ran = run_text(tmp_path, text)
        assert ran.statuses == ["OK"]
        closures.append(ran.outcomes[0].energy_closure)
    assert np.abs(ran.bodies["buoy"]["attitude"][0]).max() > 0.3
    assert ran.bodies["buoy"]["position"][0, :, 2].max() > 1.2
    assert closures[1] < closures[0] / 3.0
    assert closures[1] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "density", "start", "height", "rests"),
    [
        # with a corner down: 0.35 of the square is a triangle as high as its root, from 1 / sqrt(2) down
        ([1, 1], 0.35, [0, 0.6, 0], np.sqrt(0.5) - np.sqrt(0.35), [np.pi / 4]),
        ([1, 1], 0.5, [0, 0.1, 0], 0.0, [np.pi / 4]),
        # half of it under water a cube stands on a corner, a beam of a square section on an edge
        ([1, 1, 1], 0.5, [0.6, 0.3, 0], 0.0, [np.pi / 4, np.arcsin(1 / np.sqrt(3.0))]),
        ([2, 1, 1], 0.5, [0.6, 0, 0], 0.0, [np.pi / 4, 0.0]),
    ],
)
def test_square_sections_float_on_an_edge(tmp_path, size, density, start, height, rests):
    whole = size if len(size) == 3 else [size[0], 1, size[1]]
    body = f"mass = {RHO * density * np.prod(whole)}\nvolume = {np.prod(whole)}\nsize = {whole}\n"
    body += f"position = [0, 0, 0.6]\nattitude = {start}\nsettle = true"
    text = scene(body, line=ASIDE, output='duration = "0.1 s"\nevery = "50 ms"')
    if len(size) == 2:  # the line lies in its plane
        text = "dimensions = 2\n" + text.replace('end = "free"', "end = { fixed = [1, 0, 50] }")
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    assert ran.bodies["buoy"]["position"][0, 0, 2] - 0.5 == pytest.approx(height, abs=1e-6)
    attitude = np.abs(ran.bodies["buoy"]["attitude"][0, 0])
    found = attitude[1:2] if len(size) == 2 else attitude[:2]
    np.testing.assert_allclose(found, rests, atol=1e-6)
