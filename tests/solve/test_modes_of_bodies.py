"""Natural modes of rigid bodies at rest, with the lines that moor or carry them."""

import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import fixed, line_text, order_of, scene_of
from modal_runs import at_rest, modes_of, slopes_of_dynamics
from scipy.linalg import eig, eigh
from scipy.optimize import brentq

G, RHO = 9.81, 1025.0
OUTPUT = "[output]\nduration = 1\nevery = 1\n"


def wire(stiffness):
    return f'[materials.wire]\nlaw = "linear"\nEA = {stiffness}\n'


def in_hertz(square):
    return np.sqrt(square) / (2.0 * np.pi)


def of_body(found, name="box"):
    """The modes in which a body has more than half of the energy: frequencies (Hz), ways (k, 6)."""
    mine = found.rigid[name].share > 0.5
    return found.frequency[mine], found.rigid[name].ways[mine]


# --- a body between two lines: a string with a mass in the middle -----------------------------------

MASS, LENGTH, EA, LINE = 50.0, 50.0, 1e6, 1.0  # kg, m, N, kg/m
SPAN = 105.0  # m: 5 % strain, 50 kN


def between(segments, mass=MASS):
    place = 0.5 * SPAN
    return (
        "dimensions = 3\n"
        + wire(EA)
        + f"[bodies.box]\nmass = {mass}\nposition = [{place - 0.3}, 0, 0]\nsettle = true\n"
        + 'free = ["x", "y", "z"]\n'
        + line_text("left", "wire", LENGTH, segments, LINE, fixed(0, 0, 0), '"box"')
        + line_text("right", "wire", LENGTH, segments, LINE, '"box"', fixed(SPAN, 0, 0))
        + OUTPUT
    )


def string_with_a_mass(segments=None):
    """omega (rad/s) across and along where the mass moves: x tan x = 2 m L / M, x = omega L / c.

    c in metres of unstretched line a second: sqrt(T / (1 + e) / m) across, sqrt(EA / m) along. Of N
    lumps with u_j = sin(k j): omega = 2 (c / l) sin(k / 2), and the middle's equation is
    tan(k / 2) tan(k N) = m l / M.
    """
    ratio, strain = LINE * LENGTH / MASS, SPAN / (2.0 * LENGTH) - 1.0
    speeds = np.sqrt(np.array([EA * strain / (1.0 + strain), EA]) / LINE)
    if segments is None:
        return brentq(lambda x: x * np.tan(x) - 2.0 * ratio, 0.1, 1.5) / LENGTH * speeds
    n = segments
    k = brentq(lambda k: np.tan(0.5 * k) * np.tan(k * n) - ratio / n, 0.1 / n, 1.5 / n)
    return 2.0 * n / LENGTH * np.sin(0.5 * k) * speeds


def lowest_across_and_along(found):
    across, along = (found.rigid["box"].ways[:, [c]].sum(1) > 0.99 for c in (2, 0))
    moves = found.rigid["box"].share > 1e-6
    return np.array([found.frequency[moves & way].min() for way in (across, along)])


@pytest.mark.slow
def test_a_body_between_two_lines(tmp_path):
    errors = []
    for segments in (8, 16, 32):
        found = modes_of(tmp_path, between(segments), count=10)
        omega = 2.0 * np.pi * lowest_across_and_along(found)
        assert omega == pytest.approx(string_with_a_mass(segments), rel=1e-9)
        errors.append(np.abs(omega / string_with_a_mass() - 1.0).max())
    assert errors[-1] < 1e-4
    assert order_of(errors, 2.0) == pytest.approx(2.0, abs=0.1)
    across = [k for k in range(10) if found.rigid["box"].ways[k, 1] > 0.99]
    assert found.frequency[across[0]] == pytest.approx(found.frequency.min(), rel=1e-9)


@pytest.mark.slow
def test_a_wrong_mass_is_found(tmp_path):
    found = modes_of(tmp_path, between(32, 1.01 * MASS), count=10)
    omega = 2.0 * np.pi * lowest_across_and_along(found)
    assert np.all(omega / string_with_a_mass(32) < 1.0 - 1e-3)


@pytest.mark.slow
def test_many_segments_go_by_way_of_the_inverse(tmp_path):
    found = modes_of(tmp_path, between(150), count=8)
    assert found.unknowns == 3 * (2 * 149 + 1)
    lumps = string_with_a_mass(150)
    assert 2.0 * np.pi * found.frequency[:2] == pytest.approx(lumps[[0, 0]], rel=1e-9)
    # and where the body stands still, each half is a string that is held: c / (2 L), twice for y and z
    strain = SPAN / (2.0 * LENGTH) - 1.0
    half = np.sqrt(EA * strain / (1.0 + strain) / LINE) / (2.0 * LENGTH)
    still = found.rigid["box"].share < 1e-9
    assert found.frequency[still][:2] == pytest.approx([half, half], rel=1e-4)


# --- bodies that hang -------------------------------------------------------------------------------

ROPE, ARM, HEAVY, TURNING = 3.0, 0.8, 200.0, 90.0  # m, m, kg, kg m2


@pytest.mark.slow
def test_a_body_on_a_rope_is_a_double_pendulum(tmp_path):
    light = 0.5  # kg/m: half of the rope's mass is at the eye
    text = (
        f"gravity = {G}\ndimensions = 2\n"
        + wire(1e8)
        + f"[bodies.box]\nmass = {HEAVY}\nposition = [0, 0, -4]\nsettle = true\n"
        + f"inertia = [{TURNING}, {TURNING}, {TURNING}]\npoints = {{ eye = [0, 0, {ARM}] }}\n"
        + line_text("rope", "wire", ROPE, 1, light, fixed(0, 0, 0), '"box.eye"')
        + OUTPUT
    )
    found = modes_of(tmp_path, text, count=3)
    eye = 0.5 * light * ROPE
    pull = (HEAVY + eye) * G
    length = ROPE * (1.0 + pull / 1e8)
    mass = np.array(
        [
            [(HEAVY + eye) * length**2, HEAVY * length * ARM],
            [HEAVY * length * ARM, TURNING + HEAVY * ARM**2],
        ]
    )
    square = eigh(np.diag([pull * length, HEAVY * G * ARM]), mass, eigvals_only=True)
    bounce = 1e8 / ROPE / (HEAVY + eye)
    assert found.frequency == pytest.approx(in_hertz([*square, bounce]), rel=1e-7)
    assert found.unknowns == 3
    assert found.bodies + found.axial + found.transverse == pytest.approx(np.ones(3))
    # both angles of the first mode have one sign: the rope's by the eye, the body's by its pitch
    moved = found.rigid["box"].moved
    assert np.sign(moved[0, 0]) == -np.sign(moved[0, 4]) != 0.0
    assert np.abs(moved[2, [0, 4]]).max() < 1e-9 * np.abs(moved[2, 2])


@pytest.mark.slow
def test_a_platform_on_four_wires(tmp_path):
    wide, long, drop, heavy = 1.0, 2.0, 4.0, 400.0
    inertia = (150.0, 300.0, 420.0)
    text = f"gravity = {G}\n" + wire(1e9)
    points, lines = [], ""
    for k, (a, b) in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)]):
        points.append(f"c{k} = [{a * long}, {b * wide}, 0]")
        lines += line_text(
            f"w{k}", "wire", drop, 1, 1e-6, fixed(a * long, b * wide, drop), f'"box.c{k}"'
        )
    text += (
        f"[bodies.box]\nmass = {heavy}\nposition = [0, 0, 0]\nsettle = true\n"
        f"inertia = {list(inertia)}\npoints = {{ {', '.join(points)} }}\n{lines}{OUTPUT}"
    )
    found = modes_of(tmp_path, text, count=6)
    stretched = drop + heavy * G / 4.0 / (1e9 / drop)
    sway, spring = G / stretched, 1e9 / drop
    yaw = heavy * G * (long**2 + wide**2) / stretched / inertia[2]
    exact = [sway, sway, yaw, 4 * spring / heavy]
    exact += [4 * spring * wide**2 / inertia[0], 4 * spring * long**2 / inertia[1]]
    assert found.frequency == pytest.approx(in_hertz(np.sort(exact)), rel=1e-5)
    ways = found.rigid["box"].ways
    named = ["x", "y", "z", "roll", "pitch", "yaw"]
    order = np.argsort(exact, kind="stable")
    free = np.array(["x", "y", "yaw", "z", "roll", "pitch"])[order]
    moves = [named[k] for k in np.argmax(ways, axis=1)]
    assert sorted(moves[:2]) == sorted(free[:2]) == ["x", "y"]
    assert moves[2:] == list(free[2:])
    assert np.all(np.max(ways, axis=1) > 0.999)


@pytest.mark.slow
def test_nothing_resists_a_body_that_turns_on_its_line(tmp_path):
    text = (
        f"gravity = {G}\ndimensions = 3\n"
        + wire(1e6)
        + "[bodies.box]\nmass = 100\nposition = [0, 0, -6]\nsettle = true\n"
        + "size = [1, 1, 2]\npoints = { eye = [0, 0, 1] }\n"
        + line_text("rope", "wire", 5, 4, 0.1, fixed(0, 0, 0), '"box.eye"')
        + OUTPUT
    )
    found = modes_of(tmp_path, text, count=5)
    assert not found.unstable.any()
    assert list(found.neutral) == [True, False, False, False, False]
    assert found.rigid["box"].ways[0, 5] == pytest.approx(1.0)


# --- bodies that float ------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_floating_box(tmp_path):
    length, breadth, height, heavy = 8.0, 3.0, 2.0, 20e3
    text = (
        f"gravity = {G}\ndimensions = 3\n[water]\ndensity = {RHO}\nsurface = 0\n"
        + wire(1e6)
        + f"[bodies.box]\nmass = {heavy}\nvolume = {length * breadth * height}\n"
        + f"size = [{length}, {breadth}, {height}]\nposition = [0, 0, 0.1]\nsettle = true\n"
        + "points = { keel = [0, 0, -1] }\n"
        + line_text("tail", "wire", 2, 2, 1e-4, '"box.keel"', '"free"', "diameter = 1e-4")
        + OUTPUT
    )
    found = modes_of(tmp_path, text, count=30)
    frequency, ways = of_body(found)
    draft = heavy / (RHO * length * breadth)
    lever = 0.5 * draft - 0.5 * height  # of the centre of buoyancy over that of gravity
    inertia = heavy / 12.0 * (np.array([breadth, length]) ** 2 + height**2)
    metacentre = lever + np.array([breadth, length]) ** 2 / (12.0 * draft)
    heave = RHO * G * length * breadth / heavy
    exact = np.array([heave, *(heavy * G * metacentre / inertia)])
    named = {("z", "roll", "pitch")[k]: w for k, w in enumerate(in_hertz(exact))}
    for k, way in ((2, "z"), (3, "roll"), (4, "pitch")):
        mine = frequency[ways[:, k] > 0.99]
        assert mine == pytest.approx([named[way]], rel=1e-5), way
    drifts = found.rigid["box"].share > 0.5
    assert np.count_nonzero(found.neutral & drifts) == 3
    assert not found.unstable.any()


# --- everything together, against the dynamics ------------------------------------------------------

THICK, WET = "diameter = 0.05\n", "added_mass = { normal = 1 }"
MOORED = (
    f"gravity = {G}\n[water]\ndensity = {RHO}\nsurface = 0\n"
    + '[seabed]\nheight = "-18 m"\nstiffness = "100 kPa"\n'
    + '[materials.chain]\nlaw = "linear"\nEA = "20 MN"\ntension_only = true\n'
    + """
[bodies.box]
mass = "9 t"
volume = 24
size = [4, 3, 2]
position = [0, 0, -0.4]
attitude = [0, 0, 0.3]
points = { bow = [1.9, 0.2, -0.5], port = [-1, 1.4, -0.9], aft = [-1.8, -1.2, 0.3] }
added_mass = [0.3, 0.6, 0.9]
settle = true
[bodies.clump]
mass = 300
volume = 0.1
position = [14, 1, -10]
"""
    + line_text("upper", "chain", 18, 4, 12, '"box.bow"', '"clump"', THICK)
    + line_text("lower", "chain", 26, 4, 20, '"clump"', fixed(36, 3, -18), THICK)
    + line_text("port", "chain", 34, 5, 15, '"box.port"', fixed(-12, 27, -18), THICK + WET)
    + line_text("aft", "chain", 33, 4, 15, '"box.aft"', fixed(-14, -25, -18), THICK)
    + OUTPUT
)  # fmt: skip


@pytest.mark.slow
def test_modes_are_those_of_the_dynamics(tmp_path):
    scene = scene_of(tmp_path, MOORED)
    found = at_rest(scene)
    assert bool(found.converged)
    modes = modes_of(tmp_path, MOORED, count=100)
    slopes = np.asarray(slopes_of_dynamics(found.model, ["box"]))
    assert modes.unknowns == slopes.shape[0] == len(modes.square)
    values = eig(slopes)[0]
    assert np.abs(values.imag).max() < 1e-6 * np.abs(values).max()
    every = np.sort(values.real)
    assert modes.square == pytest.approx(every, rel=1e-6, abs=1e-9 * every[-1])
    assert modes.square[:12] == pytest.approx(every[:12], rel=1e-5)
    assert modes.asymmetry < 1e-8
    assert modes.axial + modes.transverse + modes.bodies == pytest.approx(np.ones(len(every)))
    # ends go with the body, in every mode
    box = modes.rigid["box"]
    assert set(modes.rigid) == {"box"}
    turn = np.asarray(found.model.bodies["box"].rate(
        found.model.bodies["box"].reference, jnp.zeros(6), jnp.asarray([1.9, 0.2, -0.5])
    )[0])  # fmt: skip
    assert modes.shapes["upper"][:, 0] == pytest.approx(box.moved @ turn.T, abs=1e-9)


# --- stiffness without energy -----------------------------------------------------------------------

OBLIQUE = f"""
gravity = {G}
[water]
density = {RHO}
current = {{ velocity = [1, 0, 0] }}
[materials.wire]
law = "linear"
EA = "4 MN"
[bodies.ship]
mass = "900 t"
size = [60, 10, 8]
position = [0, 0, 0]
attitude = [0, 0, "20 deg"]
hull = {{}}
drag = [0.2, 1.0, 1.0]
control = {{ stiffness = [2e3, 1e3, 0], turn_stiffness = [0, 0, 1e6] }}
free = ["x", "y", "yaw"]
settle = true
[lines.tail]
material = "wire"
length = 10
segments = 1
mass = 0.01
diameter = 0.003
start = "ship"
end = "free"
"""


@pytest.mark.slow
def test_a_current_couples_ways_one_way(tmp_path):
    # yaw changes the drag along x and y, and these change no moment: K is triangular, its own numbers
    # the springs', but for what the current turns the ship with
    found = modes_of(tmp_path, OBLIQUE + OUTPUT, count=12)
    mine = found.rigid["ship"].share > 0.5
    assert found.asymmetry > 1e-3
    assert not found.unstable.any()
    assert not found.growth.any()
    periods = 1.0 / found.frequency[mine]
    inertia = 900e3 / 12.0 * (60.0**2 + 10.0**2)
    exact = 2.0 * np.pi / np.sqrt([1e3 / 900e3, 2e3 / 900e3, 1e6 / inertia])
    assert np.sort(periods)[::-1] == pytest.approx(np.sort(exact)[::-1], rel=1e-3)


@pytest.mark.slow
def test_modes_in_a_current_are_those_of_the_dynamics(tmp_path):
    text = MOORED.replace("surface = 0", "surface = 0\ncurrent = { velocity = [0.8, 0.5, 0] }")
    text = text.replace("settle = true", "drag = [1, 1, 1]\nsettle = true")
    found = at_rest(scene_of(tmp_path, text))
    assert bool(found.converged)
    modes = modes_of(tmp_path, text, count=100)
    slopes = np.asarray(slopes_of_dynamics(found.model, ["box"]))
    values = eig(slopes)[0]
    every = values[np.lexsort((values.imag, values.real))]
    size = every.real.max()
    told = np.where(modes.growth > 0.0, modes.square - modes.growth**2, modes.square)
    assert np.sort(told) == pytest.approx(every.real, rel=1e-6, abs=1e-9 * size)
    assert modes.asymmetry > 1e-7
    growing = np.sort(np.abs(np.sqrt(values[np.abs(values.imag) > 1e-9 * size]).imag))
    assert np.sort(modes.growth[modes.growth > 0.0]) == pytest.approx(growing, rel=1e-5)
