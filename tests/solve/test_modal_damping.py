"""How fast natural modes die out: closed forms, and the motion itself."""

import numpy as np
import pytest
from modal_runs import STRING, line_on_a_winch, modes_of, springs_on_a_winch
from scipy.linalg import eigh

BAR = f"dimensions = 1\n{STRING}".replace('EA = "1 MN"', 'EA = "1 MN"\ndamping = "2 kN s"')


def test_a_bar_whose_material_damps(tmp_path):
    found = modes_of(tmp_path, BAR)
    # C = (B / EA) K: zeta = omega B / (2 EA)
    omega = 2.0 * np.pi * found.frequency
    assert found.damping == pytest.approx(omega * 2e3 / (2.0 * 1e6), rel=1e-9)


def test_nothing_damps_a_string(tmp_path):
    assert modes_of(tmp_path, f"dimensions = 2\n{STRING}").damping is None


STREAM = (
    "dimensions = 3\n[water]\ndensity = 1025\n"
    'current = { profile = "uniform", velocity = [0, 0.5, 0] }\n' + STRING
).replace(
    'mass = "1 kg/m"',
    'mass = "3 kg/m"\ndiameter = 0.02\ndrag = { normal = 1.2, tangential = 0.01 }\n'
    "added_mass = { normal = 1, tangential = 0 }",
)


def test_a_string_in_a_stream(tmp_path):
    found = modes_of(tmp_path, STREAM, 'materials.hooke.EA="1 MN"', count=4)
    # 1/2 rho Cd d U^2 a metre (unstretched): 2 (1/2 rho Cd d U) along the stream, half of it across
    drag = 1025 * 1.2 * 0.02 * 0.5
    mass = 3.0 + 1025 * np.pi * 0.02**2 / 4
    omega = 2.0 * np.pi * found.frequency
    along = np.argmax([np.abs(found.shapes["rope"][k]).max(axis=0) for k in range(4)], axis=1)
    expected = np.where(along == 1, 1.0, 0.5) * drag / mass / (2.0 * omega)
    assert set(along) == {1, 2}
    # it bows in the stream
    assert found.damping == pytest.approx(expected, rel=1e-3)


BUOY = """
gravity = 10
dimensions = 3

[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "hooke"
length = "10 m"
segments = 2
mass = "1e-6 kg/m"
start = { fixed = [0, 0, 0] }
end = "load.ring"

[bodies.load]
mass = 1000
position = [0, 0, -11]
inertia = [400, 500, 600]
points = { ring = [0, 0, 1] }
free = ["z"]
settle = true
control = { damping = [0, 0, 50] }

[output]
duration = 1
every = 1
"""


def test_a_body_that_is_damped(tmp_path):
    found = modes_of(tmp_path, BUOY, count=1)
    omega = np.sqrt(1e6 / 10.0 / 1000.0)
    assert 2.0 * np.pi * found.frequency[0] == pytest.approx(omega, rel=1e-6)
    assert found.damping[0] == pytest.approx(50.0 / (2.0 * 1000.0 * omega), rel=1e-6)


def test_a_winch_that_is_damped(tmp_path):
    drive = ", damping = 700, control = { gain = 4 }"
    found = modes_of(tmp_path, line_on_a_winch('damping = "300 N s"', drive), count=5)
    # EA (x' - x - l)^2 / 2 l of n equal segments of l = L / n; B (de/dt)^2 / 2 times l damps alike
    n, EA, B, stretch = 5, 1e6, 300.0, 1.05
    length = 12.0 / stretch
    size = length / n
    ways = springs_on_a_winch(n, stretch)
    stiffness, damping = EA / size * ways.T @ ways, B / size * ways.T @ ways
    # the drive multiplies what the line pulls, not what its own damper does
    ratio = 1.0 + 4.0 / stretch
    damping[4, 4] += 700.0 / ratio
    mass = np.diag([2.0 * size] * 4 + [(2.0 * length / 3.0 + 30.0) / ratio])
    square, vectors = eigh(stiffness, mass)
    expected = np.sum(vectors * (damping @ vectors), axis=0) / (2.0 * np.sqrt(square))
    assert found.damping == pytest.approx(expected, rel=1e-6)
