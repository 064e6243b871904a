"""Natural modes of lines that keep their length: masses of rods, and no stretching."""

import numpy as np
import pytest
from command_line import refused
from engine_runs import line_text, order_of, run_text
from modal_runs import modes_at, modes_of, straight
from scipy.linalg import eigh
from scipy.optimize import brentq

from lumpedcable import exact
from lumpedcable.model.materials import REST_STIFFNESS

G = 9.81


def scene(lines, bodies="", material='law = "inextensible"', head="dimensions = 2"):
    """A scene text of lines of one inextensible material."""
    return f"""
gravity = {G}
{head}
[materials.stiff]
{material}
{lines}
{bodies}
[solver]
step = "1 ms"
[output]
"""


def line(name, length, mass, start, end, segments=1):
    return line_text(name, "stiff", length, segments, mass, start, end)


ORIGIN = "{ fixed = [0, 0, 0] }"
ROD = scene(line("rod", 1.0, 3.0, ORIGIN, '"free"'))
L1, L2, M1, M2, JOINT, TIP = 1.5, 0.8, 2.0 * 1.5, 5.0 * 0.8, 0.7, 1.9  # of a double pendulum
DOUBLE = line("upper", L1, 2.0, ORIGIN, '"joint"') + line("lower", L2, 5.0, '"joint"', '"tip"')
WEIGHTS = f"[bodies.joint]\nmass = {JOINT}\n[bodies.tip]\nmass = {TIP}\n"


def in_hertz(square):
    return np.sqrt(square) / (2.0 * np.pi)


def double_pendulum():
    """Frequencies (Hz) from the 2 x 2 problem in the angles of two uniform rods with point masses."""
    below = M2 + JOINT + TIP
    mass = [
        [M1 * L1**2 / 3 + below * L1**2, (M2 / 2 + TIP) * L1 * L2],
        [(M2 / 2 + TIP) * L1 * L2, M2 * L2**2 / 3 + TIP * L2**2],
    ]
    stiffness = np.diag([(M1 / 2 + below) * G * L1, (M2 / 2 + TIP) * G * L2])
    return in_hertz(eigh(stiffness, mass, eigvals_only=True))


def test_a_compound_pendulum(tmp_path):
    found = modes_of(tmp_path, ROD, count=5)
    assert found.frequency == pytest.approx([in_hertz(1.5 * G)], rel=1e-9)
    assert found.unknowns == 1
    assert found.mass == pytest.approx([1.0])  # a third of 3 kg, for 1 m at the end
    assert found.transverse == pytest.approx([1.0])


@pytest.mark.slow
def test_a_double_pendulum(tmp_path):
    found = modes_of(tmp_path, scene(DOUBLE, WEIGHTS, head="dimensions = 3"))
    assert found.frequency == pytest.approx(np.repeat(double_pendulum(), 2), rel=1e-7)
    assert found.axial + found.transverse + found.bodies == pytest.approx(np.ones(4))
    assert np.all(found.bodies > 0.05)


@pytest.mark.slow
def test_it_swings_in_time_as_its_modes_say(tmp_path):
    # moved aside by 4 mm, it goes on in its two modes, which a fit of sines to its end tells apart
    times = [0.25 * k for k in range(85)]
    places = [[4e-3 * min(time, 1.0), 0, 0] for time in times]
    moved = f"{{ motion = {{ time = {times}, position = {places} }} }}"
    text = scene(DOUBLE.replace(ORIGIN, moved), WEIGHTS) + "duration = 21\nevery = 0.01\n"
    ran = run_text(tmp_path, text, "solver.step=2 ms")
    assert ran.statuses == ["OK"]
    time, end = ran.time, ran["lower.position"][0, :, -1, 0]
    time, end = time[time >= 4.0], end[time >= 4.0]  # what moves it is smooth, and still by then

    def left_over(frequencies):
        angle = 2.0 * np.pi * np.outer(time, frequencies)
        terms = np.column_stack([np.cos(angle), np.sin(angle), np.ones(time.size)])
        return np.std(end - terms @ np.linalg.lstsq(terms, end, rcond=None)[0])

    found = modes_of(tmp_path, scene(DOUBLE, WEIGHTS)).frequency
    assert found == pytest.approx(double_pendulum(), rel=1e-7)
    assert left_over(found) < 2e-3 * np.std(end)
    for k in (0, 1):
        wrong = np.where(np.arange(2) == k, 1.01 * found, found)
        assert left_over(wrong) > 5.0 * left_over(found)


@pytest.mark.slow
def test_added_mass_is_carried_across_rods(tmp_path):
    # light rods without buoyancy to speak of: of a rod, a third of what moves with it
    water = "dimensions = 2\n[water]\ndensity = 1000"
    own = (
        line("rod", 2.0, 3.0, ORIGIN, '"bob"') + "diameter = 0.05\nadded_mass = { normal = 1.0 }\n"
    )
    found = modes_of(tmp_path, scene(own, "[bodies.bob]\nmass = 4\n", head=water))
    added = 1000.0 * np.pi * 0.05**2 / 4
    inertia = 2.0**3 / 3 * (3.0 + added) + 4.0 * 2.0**2
    moment = G * (2.0**2 / 2 * (3.0 - added) + 4.0 * 2.0)
    assert found.frequency == pytest.approx([in_hertz(moment / inertia)], rel=1e-7)


@pytest.mark.slow
def test_a_hanging_chain_in_the_limit_of_many_rods(tmp_path):
    known = exact.hanging_chain_frequencies(10.0, 4, G)
    text = scene(line("chain", 10.0, 2.0, ORIGIN, '"free"'))
    errors = []
    for rods in (40, 160):
        found = modes_of(tmp_path, text, f"chain.segments={rods}")
        errors.append(found.frequency / known - 1.0)
        assert found.unknowns == rods
        assert found.axial == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.abs(order_of(np.abs(errors), 4) - 2.0) < 0.1)
    assert np.all(np.abs(errors[-1]) < 1e-3)


@pytest.mark.slow
def test_many_rods_in_space_swing_both_ways(tmp_path):
    # 480 unknowns are solved by iteration, 320 in a plane whole
    text = scene(line("chain", 10.0, 2.0, ORIGIN, '"free"', 160))
    plane = modes_of(tmp_path, text)
    space = modes_of(tmp_path, text, "dimensions=3", count=8)
    assert space.frequency == pytest.approx(np.repeat(plane.frequency, 2), rel=1e-9)
    assert space.unknowns == 320
    moves = np.max(np.abs(space.shapes["chain"]), axis=1)
    assert np.all(np.sort(moves, axis=1)[:, :2] < 1e-6)  # along x or along y


@pytest.mark.parametrize(("rods", "dimensions"), [(32, 2), (200, 3)])
def test_a_taut_line_between_two_points(tmp_path, rods, dimensions):
    # one of its lengths follows from the others; rods of mass m that carry T, l apart at their joints:
    # omega^2 = 6 T/(m l) (1 - cos k) / (2 + cos k), k = n pi / N
    text = scene(line("taut", 100.0, 1.0, ORIGIN, "{ fixed = [100.05, 0, 0] }", rods))
    dimension = f"dimensions={dimensions}"
    found = modes_at(tmp_path, text, straight(100.05, rods), dimension, count=4 * dimensions - 4)
    stiffness = REST_STIFFNESS * exact.STANDARD_GRAVITY  # at which it is as long as it lies here
    k = np.arange(1, 5) * np.pi / rods
    shape = (1.0 - np.cos(k)) / (2.0 + np.cos(k)) * rods**2 / (100.0 * 100.05)
    known = in_hertz(6.0 * stiffness * 5e-4 * shape)
    assert found.frequency == pytest.approx(np.repeat(known, dimensions - 1), rel=1e-8)
    assert found.unknowns == (rods - 1) * (dimensions - 1)


def four_bars():
    """Frequency (Hz) of three rods of 1, 1.4 and 1.2 m, 2 kg/m, between points 2 m apart."""
    lengths, span = np.array([1.0, 1.4, 1.2]), 2.0

    def joints(angle):
        first = lengths[0] * np.array([np.cos(angle), np.sin(angle)])
        step = np.array([span, 0.0]) - first
        far = np.hypot(*step)
        along = (far**2 + lengths[1] ** 2 - lengths[2] ** 2) / (2.0 * far)
        across = np.sqrt(lengths[1] ** 2 - along**2)
        unit = step / far
        second = first + along * unit + across * np.array([unit[1], -unit[0]])
        return np.array([[0.0, 0.0], first, second, [span, 0.0]])

    def height(angle):
        z = joints(angle)[:, 1]
        return np.sum(lengths * (z[1:] + z[:-1]) / 2)

    def slope(angle, h=1e-4):
        return (height(angle + h) - height(angle - h)) / (2.0 * h)

    rest, h = float(brentq(slope, -1.7, -1.0, xtol=1e-13)), 1e-3  # pyright: ignore
    curve = (slope(rest + h) - slope(rest - h)) / (2.0 * h)
    v = (joints(rest + 1e-5) - joints(rest - 1e-5)) / 2e-5
    ends = np.sum(v[1:] ** 2 + v[1:] * v[:-1] + v[:-1] ** 2, axis=1)
    return in_hertz(G * curve / np.sum(lengths * ends / 3.0))


@pytest.mark.slow
def test_three_rods_between_two_points(tmp_path):
    lines = line("a", 1.0, 2.0, ORIGIN, '"b.start"')
    lines += line("b", 1.4, 2.0, '"a.end"', '"c.start"')
    lines += line("c", 1.2, 2.0, '"b.end"', "{ fixed = [2, 0, 0] }")
    found = modes_of(tmp_path, scene(lines))
    assert found.frequency == pytest.approx([four_bars()], rel=1e-5)
    assert found.unknowns == 1


VEE = line("vee", 2.6, 2.0, "{ fixed = [-0.5, 0, 0] }", "{ fixed = [0.5, 0, 0] }", 2)


def test_two_rods_between_two_points_swing_out_of_their_plane(tmp_path):
    # a triangle 1.2 m deep about the line through its upper corners: omega^2 = 3/2 g/h
    found = modes_of(tmp_path, scene(VEE, head="dimensions = 3"))
    assert found.frequency == pytest.approx([in_hertz(1.5 * G / 1.2)], rel=1e-8)
    assert found.shapes["vee"][0, 1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_rods_that_give_way_have_both_kinds_of_modes(tmp_path):
    # EA of 1 GN: the swing is that of rods to 1e-8, and the bob bounces on the rod's stiffness
    text = scene(line("rod", 2.0, 3.0, ORIGIN, '"bob"'), "[bodies.bob]\nmass = 50\n")
    text = text.replace('"inextensible"', '"inextensible"\nEA = "1 GN"')
    found = modes_of(tmp_path, text)
    swing = G * (3.0 * 2.0**2 / 2 + 50.0 * 2.0) / (3.0 * 2.0**3 / 3 + 50.0 * 2.0**2)
    bounce = 1e9 / 2.0 / (50.0 + 3.0 * 2.0 / 3)
    assert found.frequency == pytest.approx(in_hertz(np.array([swing, bounce])), rel=2e-6)
    assert found.axial + found.bodies * [0.0, 1.0] == pytest.approx([0.0, 1.0], abs=1e-6)


@pytest.mark.slow
def test_rods_that_give_way_below_others_that_do_not(tmp_path):
    # straight down, the lower rod's spring sees a third of its mass and the tip
    lower = DOUBLE.split("[lines.lower]")
    lines = f"{lower[0]}[lines.lower]{lower[1].replace('stiff', 'soft')}"
    soft = '[materials.soft]\nlaw = "inextensible"\nEA = "1 MN"'
    found = modes_of(tmp_path, scene(lines, f"{WEIGHTS}{soft}"))
    assert found.unknowns == 3
    assert found.frequency[:2] == pytest.approx(double_pendulum(), rel=1e-4)
    assert found.frequency[2] == pytest.approx(in_hertz(1e6 / L2 / (TIP + M2 / 3)), rel=1e-6)


@pytest.mark.slow
def test_too_few_dimensions_are_told(tmp_path):
    (tmp_path / "scene.toml").write_text(ROD.replace("dimensions = 2", ""))
    told = refused(tmp_path, "modes", "scene.toml")
    assert "dimensions: expected 2 or 3 for natural modes, found 1: inextensible lines on" in told
    (tmp_path / "scene.toml").write_text(scene(VEE))
    told = refused(tmp_path, "modes", "scene.toml")
    assert "dimensions: expected 3 for natural modes, found 2: inextensible lines that" in told
    (tmp_path / "scene.toml").write_text(ROD.replace('"free"', "{ fixed = [0, 0, -1] }"))
    assert "lines: nothing can move: every node is held" in refused(tmp_path, "modes", "scene.toml")
