"""Natural modes against exact frequencies: strings, rods, chains, cables, beams, pendulums."""

import numpy as np
import pytest
from engine_runs import order_of
from modal_runs import STRING, modes_at, straight
from scipy.optimize import brentq

from lumpedcable import exact

LENGTH, SPAN, TENSION, EA, MASS = 100.0, 105.0, 50e3, 1e6, 1.0  # those of STRING
G = exact.STANDARD_GRAVITY
MESHES = (16, 64)
PLANE = f"dimensions = 2\n{STRING}"
HANGING = f"gravity = {G}\n{PLANE}".replace("{ fixed = [105, 0, 0] }", '"free"')


def assert_second_order(errors, factor=4):
    """Relative errors (meshes, modes) that fall with the square of the mesh, to a tenth in the order."""
    order = order_of(np.abs(errors), factor)
    assert order.size
    assert np.all(np.abs(order - 2.0) < 0.1), order


def loads(segments, length, weight, last=0.0):
    """Nodal loads (n + 1, 3) in N of a line of `weight` (N/m) with `last` (N) below its end."""
    nodal = np.zeros((segments + 1, 3))
    nodal[:, 2] = -weight * length / segments
    nodal[[0, -1], 2] *= 0.5
    nodal[-1, 2] -= last
    return nodal


# --- strings and rods ----------------------------------------------------------------------------


def test_a_taut_string_across(tmp_path):
    n = np.arange(1, 5)
    known = exact.string_frequencies(SPAN, TENSION, MASS * LENGTH / SPAN, 4)
    errors = []
    for segments in MESHES:
        found = modes_at(tmp_path, PLANE, straight(SPAN, segments), f"segments={segments}")
        # beads on a string (Lagrange): omega = 2 sqrt(T / (a m)) sin(n pi / 2 N), a the distance
        # between beads of mass m
        bead = MASS * LENGTH / segments
        lumped = np.sqrt(TENSION * segments / SPAN / bead) * np.sin(n * np.pi / 2 / segments)
        assert found.frequency == pytest.approx(lumped / np.pi, rel=1e-11)
        assert np.all(found.axial < 1e-20)
        assert found.transverse == pytest.approx(1.0)
        errors.append(found.frequency / known - 1.0)
    assert_second_order(errors)
    # the first term of the sine: f is low by (n pi / N)^2 / 24
    assert errors[-1] == pytest.approx(-((n * np.pi / 64) ** 2) / 24, rel=0.01)


@pytest.mark.parametrize("wrong", [{"EA": "1.01 MN"}, {"mass": "0.99 kg/m"}, {"length": 100.1}])
def test_a_wrong_number_is_found(tmp_path, wrong):
    known = exact.string_frequencies(SPAN, TENSION, MASS * LENGTH / SPAN, 4)
    changes = [f"{key}={value}" for key, value in wrong.items()]
    errors = [
        modes_at(tmp_path, PLANE, straight(SPAN, k), f"segments={k}", *changes).frequency / known
        - 1.0
        for k in MESHES
    ]
    with pytest.raises(AssertionError):
        assert_second_order(errors)


@pytest.mark.parametrize("free", [False, True])
def test_a_rod_along_itself(tmp_path, free):
    # in one dimension there is nothing else; a free end must be without tension
    text = STRING.replace("{ fixed = [105, 0, 0] }", '"free"') if free else STRING
    known = exact.rod_frequencies(LENGTH, EA, MASS, 4, free_end=free)
    errors = []
    for segments in MESHES:
        nodes = straight(LENGTH if free else SPAN, segments)
        found = modes_at(tmp_path, text, nodes, f"segments={segments}")
        angle = (np.arange(1, 5) - 0.5 * free) * np.pi / 2 / segments
        bead = MASS * LENGTH / segments
        lumped = np.sqrt(EA * segments / LENGTH / bead) * np.sin(angle) / np.pi
        assert found.frequency == pytest.approx(lumped, rel=1e-11)
        assert found.axial == pytest.approx(1.0)
        errors.append(found.frequency / known - 1.0)
    assert_second_order(errors)


def test_a_free_rod_drifts(tmp_path):
    text = STRING.replace("{ fixed = [0, 0, 0] }", '"free"').replace(
        "{ fixed = [105, 0, 0] }", '"free"'
    )
    found = modes_at(tmp_path, text, straight(LENGTH, 64), "segments=64")
    assert found.neutral.tolist() == [True, False, False, False]
    assert not found.unstable.any()
    assert found.frequency[0] == 0.0
    assert found.frequency[1:] == pytest.approx(
        exact.rod_frequencies(LENGTH, EA, MASS, 3), rel=2e-3
    )
    assert found.shapes["rope"][0, :, 0] == pytest.approx(1.0)
    assert found.mass[0] == pytest.approx(MASS * LENGTH)


def test_a_string_in_space_moves_along_any_axis(tmp_path):
    aslant = np.array([2.0, 3.0, 6.0]) / 7.0
    level = modes_at(tmp_path, PLANE, straight(SPAN, 32))
    end = f"end.fixed={(SPAN * aslant).tolist()}"
    found = modes_at(tmp_path, STRING, straight(SPAN, 32, aslant), "dimensions=3", end, count=8)
    assert found.frequency == pytest.approx(np.repeat(level.frequency, 2), rel=1e-10)
    assert np.abs(found.shapes["rope"] @ aslant).max() < 1e-10


def test_a_slack_line_resists_nothing_across(tmp_path):
    found = modes_at(tmp_path, PLANE, straight(LENGTH, 32), f"end.fixed=[{LENGTH}, 0, 0]", count=32)
    assert found.neutral.tolist() == [True] * 31 + [False]  # 31 nodes across, then the rod
    assert found.frequency[-1] == pytest.approx(np.sqrt(EA / MASS) / 2 / LENGTH, rel=1e-3)


# --- mass ----------------------------------------------------------------------------------------


def test_added_mass_slows_a_straight_string_across_and_not_along(tmp_path):
    water = f"dimensions = 2\n[water]\ndensity = 1025\n{STRING}"
    wet = ["rope.diameter=50 mm", "rope.added_mass={normal=1.0}"]
    dry = modes_at(tmp_path, PLANE, straight(SPAN, 32), count=62)
    found = modes_at(tmp_path, water, straight(SPAN, 32), *wet, count=62)
    added = 1025 * np.pi * 0.05**2 / 4
    across, along = dry.transverse > 0.5, found.axial > 0.5
    ratio = np.sqrt(MASS / (MASS + added))
    assert found.frequency[~along] == pytest.approx(dry.frequency[across] * ratio, rel=1e-10)
    assert found.frequency[along] == pytest.approx(dry.frequency[~across], rel=1e-10)
    # all of them carry their share of the fluid
    assert found.mass[0] == pytest.approx((MASS + added) * LENGTH / 2, rel=1e-10)
    assert dry.mass[0] == pytest.approx(MASS * LENGTH / 2, rel=1e-10)


def test_shapes_of_a_string_are_sines(tmp_path):
    found = modes_at(tmp_path, PLANE, straight(SPAN, 32))
    shape = found.shapes["rope"]
    assert shape.shape == (4, 33, 3)
    assert np.abs(shape).max(axis=(1, 2)) == pytest.approx(1.0)
    s = np.linspace(0.0, np.pi, 33)
    sines = np.sin(np.arange(1, 5)[:, None] * s)
    sines /= np.abs(sines).max(axis=1, keepdims=True)
    assert shape[..., 1] == pytest.approx(sines, abs=1e-9)
    assert np.abs(shape[..., [0, 2]]).max() < 1e-9
    assert found.nodes["rope"] == pytest.approx(straight(SPAN, 32), abs=1e-12)


# --- gravity -------------------------------------------------------------------------------------


def test_a_hanging_chain(tmp_path):
    known = exact.hanging_chain_frequencies(LENGTH, 4)
    errors = []
    for segments in (40, 160):
        nodes = exact.hanging_nodes(
            [0, 0, 0], np.full(segments, LENGTH / segments), loads(segments, LENGTH, MASS * G),
            [0, 0, 0], exact.linear_strain(1e9),
        ).positions  # fmt: skip
        found = modes_at(tmp_path, HANGING, nodes, f"segments={segments}", "EA=1 GN")
        assert found.transverse == pytest.approx(1.0)
        errors.append(found.frequency / known - 1.0)
    # the lowest is good to 2e-5: there the stretch of 1e-6 and rounding count
    assert_second_order(np.array(errors)[:, 1:])
    assert np.all(np.abs(errors[-1]) < [2e-5, 2e-4, 7e-4, 1.7e-3])


@pytest.mark.parametrize("segments", [1, 20])
def test_a_heavy_bob_on_a_stiff_line(tmp_path, segments):
    bob, length, stiff = 1e5, 10.0, 1e9
    text = HANGING.replace('"free"', '"bob"') + f"[bodies.bob]\nmass = {bob}\n"
    nodes = exact.hanging_nodes(
        [0, 0, 0], np.full(segments, length / segments), loads(segments, length, 0.01 * G, bob * G),
        [0, 0, 0], exact.linear_strain(stiff),
    ).positions  # fmt: skip
    found = modes_at(
        tmp_path, text, nodes, f"segments={segments}", "EA=1 GN", f"length={length}",
        "lines.rope.mass=0.01", count=2,
    )  # fmt: skip
    # the line has a millionth of the mass: a third of it swings and bounces with the bob
    periods = exact.elastic_pendulum_periods(length, stiff, bob, G)
    assert 1.0 / found.frequency == pytest.approx(periods, rel=5e-7)
    assert found.bodies == pytest.approx(1.0, abs=1e-6)
    assert np.abs(found.shapes["rope"][:, -1]) == pytest.approx(np.eye(3)[[0, 2]], abs=1e-6)


def cable(folder, parameter, sag, segments=200, dimensions=2, count=6):
    """Modes of a level cable of given lambda^2 and sag over span, and Irvine's frequencies (Hz)."""
    span, mass = 100.0, 10.0
    weight = mass * G
    pull = weight * span / (8.0 * sag)
    slope = weight * span / pull
    stiff = parameter * pull * (1.0 + slope**2 / 8.0) / slope**2

    def too_long(length):  # elastic catenary (Irvine 1981, eq. 2.25)
        return (
            pull * length / stiff
            + 2 * pull / weight * np.arcsinh(weight * length / 2 / pull)
            - span
        )

    length = brentq(too_long, 0.5 * span, 2.0 * span, xtol=1e-13)
    nodes = exact.pinned_nodes(
        [0, 0, 0], [span, 0, 0], np.full(segments, length / segments),
        loads(segments, length, weight), exact.linear_strain(stiff),
    ).positions  # fmt: skip
    found = modes_at(
        folder, f"gravity = {G}\n{STRING}", nodes, f"EA={stiff!r}", f"length={length!r}",
        f"segments={segments}", f"mass={mass}", f"end.fixed=[{span}, 0, 0]",
        f"dimensions={dimensions}", count=count,
    )  # fmt: skip
    kinds = exact.sagged_cable_frequencies(span, pull, mass * length / span, parameter, 3)
    return found, *kinds, exact.string_frequencies(span, pull, mass * length / span, 3)


CROSSOVER = 4.0 * np.pi**2


@pytest.mark.parametrize(
    "parameter",
    [
        1.0,
        pytest.param(0.9 * CROSSOVER, marks=pytest.mark.slow),
        CROSSOVER,
        pytest.param(1.1 * CROSSOVER, marks=pytest.mark.slow),
        200.0,
    ],
)
def test_a_sagging_cable_in_its_plane(tmp_path, parameter):
    worst = []
    for sag in (1 / 50, 1 / 100):
        found, symmetric, antisymmetric, string = cable(tmp_path, parameter, sag)
        # which is which: the sag rises and falls in symmetric modes alone
        lift = np.abs(np.sum(found.shapes["rope"][..., 2], axis=1)) > 1.0
        assert lift.sum() == 3
        half_waves = found.frequency / string[0]
        known = np.empty(6)
        known[lift], known[~lift] = symmetric, antisymmetric
        # less what the mesh does, known from the string
        errors = found.frequency / known - 1.0 + (half_waves * np.pi / 200) ** 2 / 24
        assert np.all(np.abs(errors) < 0.1 * (8.0 * sag) ** 2)  # 8 sag: twice the slope at the ends
        worst.append(np.abs(errors).max())
    # what is left is Irvine's neglect of the slope, of the order of the sag squared
    assert worst[0] / worst[1] == pytest.approx(4.0, rel=0.15)


def test_at_the_crossover_a_sagging_cable_has_two_equal_modes(tmp_path):
    found, symmetric, antisymmetric, string = cable(tmp_path, CROSSOVER, 1 / 400, 100, 3, 4)
    assert symmetric[0] == pytest.approx(antisymmetric[0], rel=1e-9)
    expected = [string[0], symmetric[0], symmetric[0], string[1]]
    assert found.frequency == pytest.approx(expected, rel=3e-4)
    # out of the plane, in it, in it, out of it
    motion = np.sum(found.shapes["rope"] ** 2, axis=1)
    assert np.argmax(motion, axis=1).tolist()[0] == 1
    assert sorted(np.argmax(motion[1:], axis=1)) == [1, 2, 2]


# --- bending -------------------------------------------------------------------------------------

EULER = 1e4 * (np.pi / 10.0) ** 2  # N, of the beam below


@pytest.mark.parametrize(
    "tension", [pytest.param(0.0, marks=pytest.mark.slow), EULER, -0.9 * EULER]
)
def test_a_pinned_beam(tmp_path, tension):
    length, EI, stiff, mass = 10.0, 1e4, 1e8, 5.0
    stretch = 1.0 + tension / stiff
    known = exact.tensioned_beam_frequencies(
        length * stretch, tension, EI * stretch, mass / stretch, 4
    )
    errors = []
    for segments in (32, 64):
        found = beam(tmp_path, tension, segments)
        errors.append(found.frequency / known - 1.0)
        # springs of tension over length, hinges of EI over length: their stiffness for a sine
        l, s2 = length / segments, 4.0 * np.sin(np.arange(1, 5) * np.pi / 2 / segments) ** 2
        lumped = tension / stretch / l * s2 + EI / stretch**2 / l**3 * s2**2
        assert found.square == pytest.approx(lumped / (mass * l), rel=1e-6)
    assert_second_order(errors, 2)


def beam(folder, tension, segments):
    stretch = 1.0 + tension / 1e8
    return modes_at(
        folder, PLANE, straight(10.0 * stretch, segments), "EA=100 MN", "length=10",
        f"segments={segments}", "mass=5", "rope.bending={EI=1e4}",
        f"end.fixed=[{10.0 * stretch!r}, 0, 0]",
    )  # fmt: skip


# --- instability ---------------------------------------------------------------------------------


def test_a_beam_beyond_eulers_load_is_unstable(tmp_path):
    tension, mass, segments = -1.5 * EULER, 5.0, 64
    found = beam(tmp_path, tension, segments)
    assert found.unstable.tolist() == [True, False, False, False]
    assert np.isnan(found.frequency[0])
    assert np.all(found.frequency[1:] > 0.0)
    # omega^2 = k^2 (T + k^2 EI) / m, negative below Euler's load; the mesh weakens bending by
    # (pi / N)^2 / 6, which counts three times where two thirds of the load are balanced
    k = np.pi / 10.0
    assert found.square[0] == pytest.approx(k**2 * (tension + EULER) / mass, rel=1e-3)


def test_a_compressed_line_without_bending_folds_in_every_mode(tmp_path):
    nodes = straight(95.0, 32)
    found = modes_at(tmp_path, PLANE, nodes, "end.fixed=[95, 0, 0]", count=32)
    assert found.unstable.tolist() == [True] * 31 + [False]
    # the string's formula with a negative tension, the shortest wave first
    n = np.arange(31, 0, -1)
    rate = 4.0 * -50e3 * 32 / 95.0 / (MASS * LENGTH / 32) * np.sin(n * np.pi / 64) ** 2
    assert found.square[:31] == pytest.approx(rate, rel=1e-10)
