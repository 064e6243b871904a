"""Natural modes of cargo on lines that winches keep taut, and of what those pay out."""

import numpy as np
import pytest
from engine_runs import order_of, run_text
from modal_runs import line_on_a_winch, modes_of, springs_on_a_winch
from scipy.linalg import eigh
from scipy.optimize import brentq

from lumpedcable import exact

G = exact.STANDARD_GRAVITY
SPAN, TENSION, MASS = 60.0, 80e3, 2000.0
HIGHLINE = f"""
gravity = {G}

[materials.steel]
law = "linear"
EA = "57 MN"

[bodies.cargo]
mass = {MASS}
on = {{ line = "highline", place = "PLACE m" }}

[lines.highline]
model = "MODEL"
material = "steel"
length = "60 m"
segments = 40
mass = "LIGHT kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ winch = {{ at = [60, 0, 0], tension = {TENSION} }} }}

[output]
duration = 1
every = 1
"""


def highline(model="ideal", place=30, light=3):
    return (
        HIGHLINE.replace("PLACE", str(place)).replace("MODEL", model).replace("LIGHT", str(light))
    )


def held_by(*ways):
    """Stiffness (3, 3) in N/m of straight parts of one tension along `ways` (m), by hand."""
    total = np.zeros((3, 3))
    for way in ways:
        length = np.linalg.norm(way)
        u = way / length
        total += TENSION / length * (np.eye(3) - np.outer(u, u))
    return total


SAG = np.tan(np.arcsin(MASS * G / 2 / TENSION)) * SPAN / 2
WAYS = np.array([-SPAN / 2, 0.0, SAG]), np.array([SPAN / 2, 0.0, SAG])


def test_cargo_on_an_ideal_cable(tmp_path):
    found = modes_of(tmp_path, "dimensions = 3\n" + highline())
    known = np.sort(np.diag(held_by(*WAYS))) / MASS
    assert found.square == pytest.approx(known, rel=1e-9)
    assert found.bodies == pytest.approx(1.0)
    assert found.nodes["highline"][1] == pytest.approx([30, 0, -SAG])
    # along the line, then across it in space and up
    assert [int(np.argmax(np.abs(shape[1]))) for shape in found.shapes["highline"]] == [0, 2, 1]


def test_cargo_that_swings_under_it(tmp_path):
    depth, inertia = 3.0, 500.0
    text = highline().replace(
        f"mass = {MASS}", f"mass = {MASS}\ndepth = {depth}\ninertia = {inertia}"
    )
    found = modes_of(tmp_path, "dimensions = 3\n" + text, count=5)
    # x, y, z of the trolley, and how far the hanger leans along x and along y
    stiffness, mass = np.zeros((5, 5)), np.zeros((5, 5))
    stiffness[:3, :3] = held_by(*WAYS)
    stiffness[3:, 3:] = MASS * G * depth * np.eye(2)
    mass[:3, :3] = MASS * np.eye(3)
    mass[3:, 3:] = (MASS * depth**2 + inertia) * np.eye(2)
    for place, angle in ((0, 3), (1, 4)):
        mass[place, angle] = mass[angle, place] = MASS * depth
    known, vectors = eigh(stiffness, mass)
    assert found.square == pytest.approx(known, rel=1e-9)
    moved = found.rigid["cargo"].moved
    for own, mode in zip(moved, vectors.T, strict=True):
        # leaning to +x is a negative pitch, to +y a positive roll
        told = np.array([*own[:3], -own[4], own[3]])
        assert abs(told @ mode) == pytest.approx(np.linalg.norm(told) * np.linalg.norm(mode))
        assert own[5] == 0.0


@pytest.mark.slow
def test_a_light_line_holds_cargo_as_an_ideal_one(tmp_path):
    known = np.sort(np.diag(held_by(*WAYS)))[:2] / MASS
    errors = []
    for segments in (20, 80):
        text = "dimensions = 2\n" + highline("lumped", light=1e-3)
        found = modes_of(tmp_path, text, f"lines.highline.segments={segments}", count=2)
        errors.append(found.square / known - 1.0)
        assert found.rolling["cargo"] == 0.0
    errors = np.abs(errors)
    # across it the line's own mass tells, 60 g of 2 t; along it, where a highline hardly holds
    # anything, that the sheave feels the nodes by 1e-7 of the tension
    assert np.all(errors[:, 1] < 2e-5), errors
    assert np.all(errors[:, 0] < 5e-4), errors


def left_by(modes, time, height, faster=1.0, fainter=1.0):
    """What decaying modes leave of heights over time, as a share of how much those vary.

    Their frequencies and their damping are taken so many times as large.
    """
    upright = np.abs(modes.rigid["cargo"].moved[:, 2]) > 1e-6
    omega = 2.0 * np.pi * faster * modes.frequency[upright]
    zeta = 0.0 * omega if modes.damping is None else fainter * modes.damping[upright]
    waves = np.exp(np.outer(time, omega * (1j * np.sqrt(1.0 - zeta**2) - zeta)))
    waves = np.column_stack([waves.real, waves.imag, np.ones_like(time)])
    part, *_ = np.linalg.lstsq(waves, height, rcond=None)
    return np.std(height - waves @ part) / np.std(height)


@pytest.mark.slow
@pytest.mark.parametrize("damping", [0, 200])
def test_it_moves_and_dies_out_as_they_say(tmp_path, damping):
    text = "dimensions = 2\n" + highline("lumped")
    if damping:
        text = text.replace(f"tension = {TENSION}", f"tension = {TENSION}, damping = {damping}")
    found = modes_of(tmp_path, text, count=24)
    assert (found.damping is None) == (damping == 0)
    # let go 2 mm below its rest
    rest = found.rigid["cargo"].position[2]
    low = text.replace("[bodies.cargo]", f"[bodies.cargo]\nheight = {rest - 0.002}")
    low = low.replace("duration = 1\nevery = 1", 'duration = "8 s"\nevery = "20 ms"')
    ran = run_text(tmp_path, low)
    moved = ran.time, ran.bodies["cargo"]["position"][0, :, 2]
    assert left_by(found, *moved) < 2e-5
    # of any phase, so that even wrong ones meet most of it
    assert min(left_by(found, *moved, faster) for faster in (0.99, 1.01)) > 0.02
    if damping:
        assert min(left_by(found, *moved, 1.0, fainter) for fainter in (0.9, 1.1)) > 5e-4


BEAD = """
dimensions = 2

[materials.steel]
law = "linear"
EA = "57 MN"

[bodies.cargo]
mass = 60
on = { line = "highline", place = "24 m" }

[lines.highline]
material = "steel"
length = "60 m"
segments = 20
mass = "3 kg/m"
start = { fixed = [0, 0, 0] }
end = { winch = { at = [60, 0, 0], tension = 80e3 } }

[output]
duration = 1
every = 1
"""


@pytest.mark.parametrize("meshes", [(40,), pytest.param((40, 160), marks=pytest.mark.slow)])
def test_a_string_that_carries_a_mass(tmp_path, meshes):
    per_metre = 3.0 * 1.0 / (1.0 + 80e3 / 57e6)

    def left(w):
        k = w * np.sqrt(per_metre / TENSION)
        a, b = np.sin(24.0 * k), np.sin(36.0 * k)
        # T k (cot ka + cot kb) = M w^2, without its poles
        return TENSION * k * np.sin(60.0 * k) - 60.0 * w**2 * a * b

    grid = np.linspace(0.1, 30.0, 3000)
    values = left(grid)
    known = [
        brentq(left, *grid[k : k + 2])
        for k in range(grid.size - 1)
        if values[k] * values[k + 1] < 0.0
    ][:3]
    errors = []
    for segments in meshes:
        found = modes_of(tmp_path, BEAD, f"lines.highline.segments={segments}", count=8)
        across = found.frequency[
            (found.transverse + found.bodies > 0.99) & (found.frequency > 1e-3)
        ]
        errors.append(2.0 * np.pi * across[:3] / known - 1.0)
    # of the beads alone it is (n pi / N)^2 / 24 of the frequency, 2e-3 of the third at 40 segments
    assert np.all(np.abs(errors[0]) < 2e-3), errors
    if len(meshes) > 1:
        order = order_of(np.abs(errors), 4)
        assert np.all(np.abs(order - 2.0) < 0.05), order
        assert np.all(np.abs(errors[1]) < 1e-4), errors


@pytest.mark.parametrize("gain", [0.0, 4.0])
def test_a_line_on_a_winch_alone(tmp_path, gain):
    drive = f", control = {{ gain = {gain} }}" if gain else ""
    found = modes_of(tmp_path, line_on_a_winch("", drive), count=5)
    # energy of n equal springs of l = L / n by places x and L: EA (x' - x - l)^2 / 2 l
    n, EA, stretch = 5, 1e6, 1.05
    length = 12.0 / stretch
    size = length / n
    ways = springs_on_a_winch(n, stretch)
    stiffness = EA / size * ways.T @ ways
    mass = np.diag([2.0 * size] * 4 + [(2.0 * length / 3.0 + 30.0) / (1.0 + gain / stretch)])
    known, vectors = eigh(stiffness, mass)
    assert found.square == pytest.approx(known, rel=1e-8)
    (name,) = found.payout
    assert name == "winch of wire"
    share = vectors[4] ** 2 * mass[4, 4]
    assert found.winch_share[name] == pytest.approx(share, abs=1e-8)
    assert found.bodies == pytest.approx(share, abs=1e-8)
    moves = found.shapes["wire"][:, 1:-1, 0].T
    assert moves * vectors[4] == pytest.approx(found.payout[name] * vectors[:4], abs=1e-8)


STREAM = """
dimensions = 3
gravity = 9.81

[water]
density = 1025
surface = 30
current = { velocity = [0, 2, 0] }

[materials.steel]
law = "linear"
EA = "57 MN"

[bodies.cargo]
mass = 2000
on = { line = "highline", place = "20 m" }

[lines.highline]
material = "steel"
length = "60 m"
segments = 12
mass = "3 kg/m"
diameter = 0.05
drag = { normal = 1.2, tangential = 0.01 }
start = { fixed = [0, 0, 0] }
end = { winch = { at = [60, 0, 0], tension = 80e3 } }

[output]
duration = 1
every = 1
"""


@pytest.mark.slow
def test_a_trolley_is_held_along_its_line_alone(tmp_path):
    found = modes_of(tmp_path, STREAM, count=12)
    sag = -found.rigid["cargo"].position[2]
    # an ideal cable draws it to and fro along the span, the stream half of the line's drag across it
    ways = np.array([-20.0, 0.0, sag]), np.array([40.0, 0.0, sag])
    along = TENSION * sum(way / np.linalg.norm(way) for way in ways)[0]
    # the line's own weight is a twelfth of what it carries
    assert found.rolling["cargo"] == pytest.approx(along, rel=0.05)
    # and the stream aside, by half of the line's drag: as much as the parts' tension holds
    drag = 0.5 * 1025 * 1.2 * 0.05 * 2.0**2 * 60.0
    aside = 0.5 * drag / (TENSION / 20.0 + TENSION / 40.0)
    assert found.rigid["cargo"].position[1] == pytest.approx(aside, rel=0.02)
    assert np.all(np.abs(found.rigid["cargo"].moved[:, 0]) < 1e-6)
    assert np.any(np.abs(found.rigid["cargo"].moved[:, 1]) > 0.5)


def test_friction_at_a_sheave_holds_the_winch(tmp_path):
    text = line_on_a_winch("", ', sheave = { friction = 0.1, wrap = "90 deg" }')
    found = modes_of(tmp_path, text, count=5)
    # beads of a rod between two fixed points: 2 sqrt(k / m) sin(n pi / 2 N)
    size = 12.0 / 1.05 / 5
    known = 2.0 * np.sqrt(1e6 / size / (2.0 * size)) * np.sin(np.arange(1, 5) * np.pi / 10)
    assert 2.0 * np.pi * found.frequency == pytest.approx(known, rel=1e-9)
    assert np.all(found.payout["winch of wire"] == 0.0)


@pytest.mark.slow
def test_a_trolley_in_a_stream_starts_at_rest(tmp_path):
    text = STREAM.replace('"20 m"', '"30 m"').replace("every = 1", "every = 0.05")
    ran = run_text(tmp_path, text)
    place = ran.bodies["cargo"]["position"][0]
    assert place[0, 1] > 0.1
    assert np.max(np.abs(place - place[0])) < 1e-6
