"""Modes of bodies on lines that winches keep taut, and under cables with cargo."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import fixed, line_text, scene_of
from modal_runs import at_rest, modes_of, slopes_of_dynamics
from scipy.linalg import eig, eigh
from scipy.optimize import brentq, root

G = 9.81
OUTPUT = '[output]\nduration = "1 s"\nevery = "10 ms"\n'

# a body between two wires in a row, one of which a winch stretches by 2 %
ROW = (
    'dimensions = 1\nmaterials.wire = { law = "linear", EA = "1 MN", damping = "3 kN s"BRANCH }\n'
    "[bodies.box]\nmass = 50\nposition = [9.7, 0, 0]\nfree = ['x']\nsettle = true\n"
    "points = { eye = [0.5, 0, 0], tail = [-0.5, 0, 0] }\ncontrol = { damping = [200, 0, 0] }\n"
    + line_text("left", "wire", 10, 3, 0.4, "START", "END")
    + line_text("right", "wire", 10, 3, 0.4, '"box.eye"', fixed(21, 0, 0))
    + OUTPUT
)
ENDS = [
    ("{ winch = { at = [0, 0, 0], tension = 20e3, inertia = 5, damping = 70 } }", '"box.tail"'),
    (fixed(0, 0, 0), '{ winch = { at = "box.tail", tension = 20e3, inertia = 5, damping = 70 } }'),
]


def row():
    """How each of its six springs is strained by two nodes, the box, two nodes and the payout
    (m), (6, 6); masses (kg); unstretched lengths of the springs (m)."""
    span = 21 - 10.2 - 1.0
    out = span / 1.02
    sizes = np.array([out / 3] * 3 + [10 / 3] * 3)
    ways = np.zeros((6, 6))
    ways[:5, :5] += np.eye(5)
    ways[1:, :5] -= np.eye(5)
    ways[:3, 5] = -1.02 / 3
    left, right = 0.4 * out / 3, 0.4 * 10 / 3
    mass = np.diag([left, left, 50 + (left + right) / 2, right, right, left + 5.0])
    return ways / sizes[:, None], mass, sizes


def given(ends, branch=""):
    start, end = ends
    return ROW.replace("START", start).replace("END", end).replace("BRANCH", branch)


@pytest.mark.parametrize(
    "ends", [ENDS[0], pytest.param(ENDS[1], marks=pytest.mark.slow)], ids=["ashore", "aboard"]
)
def test_a_body_in_a_row_with_a_winch(tmp_path, ends):
    found = modes_of(tmp_path, given(ends), count=6)
    ways, mass, sizes = row()
    square, shapes = eigh(ways.T @ np.diag(1e6 * sizes) @ ways, mass)
    np.testing.assert_allclose(found.square, square, rtol=1e-10)
    lost = ways.T @ np.diag(3e3 * sizes) @ ways + np.diag([0, 0, 200, 0, 0, 70])
    damping = np.einsum("ik,ij,jk->k", shapes, lost, shapes) / (2 * np.sqrt(square))
    np.testing.assert_allclose(found.damping, damping, rtol=1e-9)
    assert found.asymmetry < 1e-12
    # what the box moves by and what the winch pays out
    share = found.payout["winch of left"] / found.rigid["box"].moved[:, 0]
    np.testing.assert_allclose(share, shapes[5] / shapes[2], rtol=1e-7)


@pytest.mark.slow
def test_a_row_that_relaxes(tmp_path):
    branch = ', relaxation = { only = { EA = "500 kN", time = "20 ms" } }'
    found = modes_of(tmp_path, given(ENDS[0], branch), count=3)
    ways, mass, sizes = row()
    form = ways.T @ np.diag(sizes) @ ways

    def apart(omega, k):
        w = omega * 20e-3
        return eigh((1e6 + 5e5 * w**2 / (1 + w**2)) * form, mass)[0][k] - omega**2

    for k in range(3):
        omega = brentq(apart, 0.1, 1e5, args=(k,), xtol=1e-12, rtol=1e-14)
        assert 2 * np.pi * found.frequency[k] == pytest.approx(omega, rel=1e-9)


LOAD = (
    f'dimensions = 2\ngravity = {G}\nmaterials.wire = {{ law = "linear", EA = "100 MN" }}\n'
    "[bodies.box]\nmass = 500\nposition = [0.5, 0, -1]\nsettle = true\ninertia = [50, 50, 50]\n"
    "points = { left = [-0.5, 0, 0.3], right = [0.5, 0, 0.3] }\n"
    + line_text(
        "one", "wire", 5, 4, 1e-7, "{ winch = { at = [-5, 0, 0], tension = 4e3 } }", '"box.left"'
    )
    + line_text(
        "two", "wire", 5, 4, 1e-7, '"box.right"', "{ winch = { at = [5, 0, 0], tension = 4e3 } }"
    )
    + OUTPUT
)


def lowest(potential, guess, mass):
    """omega^2 (rad2/s2) about the rest of a potential (J) of a few coordinates."""
    rest = root(jax.grad(potential), np.array(guess, float)).x
    return eigh(jax.hessian(potential)(rest), np.diag(mass), eigvals_only=True)


def hung(q):
    """The load's potential (J) at x, z and pitch: that of its weight and two constant tensions."""
    x, z, pitch = q
    cos, sin = jnp.cos(pitch), jnp.sin(pitch)
    ways = [
        jnp.hypot(x + a * cos + 0.3 * sin - 10 * a, z - a * sin + 0.3 * cos) for a in (-0.5, 0.5)
    ]
    return 500 * G * z + 4e3 * sum(ways)


@pytest.mark.slow
def test_a_load_between_two_winches(tmp_path):
    found = modes_of(tmp_path, LOAD, count=3)
    square = lowest(hung, [0, -4, 0], [500, 500, 50])
    np.testing.assert_allclose(found.square, square, rtol=3e-8)  # the wires stretch by 4e-5


@pytest.mark.slow
def test_a_load_between_two_winches_in_space(tmp_path):
    """It also swings across them, about the line through the winches and about the wires' ends."""
    found = modes_of(tmp_path, LOAD.replace("dimensions = 2", "dimensions = 3"), count=6)

    def hung_in_space(q):
        x, y, z, *turns = q
        (a, b, c), (sa, sb, sc) = jnp.cos(jnp.array(turns)), jnp.sin(jnp.array(turns))
        turn = jnp.array(
            [
                [c * b, c * sb * sa - sc * a, c * sb * a + sc * sa],
                [sc * b, sc * sb * sa + c * a, sc * sb * a - c * sa],
                [-sb, b * sa, b * a],
            ]
        )
        ways = [
            jnp.linalg.norm(jnp.array([x - 10 * s, y, z]) + turn @ jnp.array([s, 0.0, 0.3]))
            for s in (-0.5, 0.5)
        ]
        return 500 * G * z + 4e3 * sum(ways)

    square = lowest(hung_in_space, [0, 0, -4, 0, 0, 0], [500] * 3 + [50] * 3)
    np.testing.assert_allclose(found.square, square, rtol=1e-7)


HIGHLINE = f"""
dimensions = 2
gravity = {G}
materials.wire = {{ law = "linear", EA = "50 MN" }}

[bodies.cargo]
mass = 200
on = {{ line = "high", place = 12 }}

[bodies.barge]
mass = 5000
position = [31, 0, -4]
free = ["x"]
settle = true
points = {{ post = [0, 0, 4] }}
control = {{ stiffness = [50e3, 0, 0] }}

[lines.high]
material = "wire"
length = 30
MODEL
mass = 1e-4
start = {{ fixed = [0, 0, 0] }}
end = {{ winch = {{ at = "barge.post", tension = 10e3 }} }}
{OUTPUT}"""


def carried(q):
    """The potential (J) of ship and cargo at x and z, the cargo held along the line's span."""
    x, z = q
    return 200 * G * z + 1e4 * (jnp.hypot(12.0, z) + jnp.hypot(x - 12.0, z)) + 25e3 * (31 - x) ** 2


def test_a_ship_under_an_ideal_highline(tmp_path):
    found = modes_of(tmp_path, HIGHLINE.replace("MODEL", 'model = "ideal"'), count=4)
    np.testing.assert_allclose(found.square, lowest(carried, [30, -1.5], [5000, 200]), rtol=1e-11)
    # the line is drawn from post to cargo to the post that goes with the ship
    line = found.shapes["high"]
    np.testing.assert_allclose(line[:, 2, 0], found.rigid["barge"].moved[:, 0], atol=1e-12)
    np.testing.assert_allclose(line[:, 1], found.rigid["cargo"].moved[:, :3], atol=1e-12)
    assert np.all(line[:, 0] == 0.0)


@pytest.mark.slow
def test_a_ship_under_a_lumped_highline(tmp_path):
    found = modes_of(tmp_path, HIGHLINE.replace("MODEL", "segments = 30"), count=2)
    square = lowest(carried, [30, -1.5], [5000, 200])
    np.testing.assert_allclose(found.square, square, rtol=2e-5)  # it weighs 3 g and stretches


# a ship with a winch aboard, a hose clamped to it, and cargo on its way over from its mast
TRANSFER = f"""
dimensions = 2
gravity = {G}
materials.wire = {{ law = "linear", EA = "8 MN" }}
materials.hose = {{ law = "linear", EA = "2 MN" }}

[bodies.barge]
mass = "9 t"
inertia = [9e3, 30e3, 33e3]
position = [0, 0, 0]
settle = true
points = {{ bow = [1.9, 0, -0.5], aft = [-1.8, 0, 0.3], mast = [0.3, 0, 3] }}
control = {{ stiffness = [4e3, 0, 200e3], turn_stiffness = [0, 120e3, 0] }}

[bodies.cargo]
mass = 300
on = {{ line = "high", place = 14 }}

[lines.high]
material = "wire"
length = 33
model = "ideal"
mass = 1
start = "barge.mast"
end = {{ winch = {{ at = [33, 0, 4], tension = 9e3 }} }}
""" + (
    line_text(
        "aft", "wire", 25, 4, 2,
        '{ winch = { at = "barge.aft", tension = 7e3, inertia = 9 } }', fixed(-22, 0, 2),
    )
    + line_text(
        "hose", "hose", 24, 5, 12,
        '{ tied = "barge.bow", direction = [1, 0, -1] }', fixed(21, 0, 1), "bending = { EI = 5e3 }",
    )
    + OUTPUT
)  # fmt: skip


@pytest.mark.slow
def test_modes_are_those_of_the_dynamics(tmp_path):
    found = at_rest(scene_of(tmp_path, TRANSFER))
    assert bool(found.converged)
    modes = modes_of(tmp_path, TRANSFER, count=100)
    assert modes.rolling["cargo"] > 0.0  # it is held along the line, whose span is level here
    slopes = np.asarray(slopes_of_dynamics(found.model, list(found.model.bodies), [("cargo", 0)]))
    assert modes.unknowns == slopes.shape[0] == len(modes.square)
    values = eig(slopes)[0]
    assert np.abs(values.imag).max() < 1e-9 * np.abs(values).max()
    every = np.sort(values.real)
    np.testing.assert_allclose(modes.square, every, rtol=1e-8)
