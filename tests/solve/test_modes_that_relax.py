"""Natural modes of materials that relax: a stiffness and a loss that depend on the frequency."""

import numpy as np
import pytest
from engine_runs import run_text
from modal_runs import STRING, line_on_a_winch, modes_of, springs_on_a_winch
from scipy.linalg import eigh
from scipy.optimize import brentq

BRANCHES = """
[materials.hooke.relaxation.fast]
EA = "600 kN"
time = "8 ms"

[materials.hooke.relaxation.slow]
EA = "300 kN"
time = "70 ms"

[lines.rope]
"""
ROPE = STRING.replace("[lines.rope]\n", BRANCHES)
FAST, SLOW = (600e3, 8e-3), (300e3, 70e-3)


def dynamic(omega, *branches):
    """sum EA i w / (1 + i w), w = omega tau (N)."""
    return sum(EA * 1j * omega * tau / (1 + 1j * omega * tau) for EA, tau in branches)


def own_frequency(square, low=1e-3, high=1e5):
    """The omega (rad/s) that is the root of the omega^2 that a function tells for it."""
    return brentq(lambda omega: square(omega) - omega**2, low, high, xtol=1e-12, rtol=1e-14)


def test_a_bar_with_two_branches(tmp_path):
    found = modes_of(tmp_path, f"dimensions = 1\n{ROPE}", count=5)
    size, mass = 100 / 32, 1.0 * 100 / 32
    for k, (omega, share) in enumerate(
        zip(2 * np.pi * found.frequency, found.damping, strict=True)
    ):
        shape = 4 * np.sin((k + 1) * np.pi / 64) ** 2 / (size * mass)

        def storage(omega, shape=shape):
            return (1e6 + dynamic(omega, FAST, SLOW).real) * shape

        assert omega == pytest.approx(own_frequency(storage), rel=1e-10)
        loss = dynamic(omega, FAST, SLOW).imag * shape
        assert share == pytest.approx(loss / (2 * omega**2), rel=1e-9)
    # the lowest is between that of slow loads and that of fast ones
    assert 1.3 < (2 * np.pi * found.frequency[0]) ** 2 / (1e6 * (np.pi / 100) ** 2) < 1.9


def test_damping_is_that_of_the_decay_to_first_order(tmp_path):
    """The roots of l^2 + K (1 + r l tau / (1 + l tau)) = 0, at two strengths of a branch."""
    errors = []
    for EA in (20e3, 10e3):
        text = f"dimensions = 1\n{ROPE}"
        one = ("materials.hooke.relaxation.slow.EA=0", f"materials.hooke.relaxation.fast.EA={EA}")
        found = modes_of(tmp_path, text, *one, count=2)
        size = 100 / 32
        k = 4e6 * np.sin(np.pi / 64) ** 2 / size**2
        r, tau = EA / 1e6, 8e-3
        roots = np.roots([tau, 1.0, k * (1 + r) * tau, k])
        root = roots[np.argmax(roots.imag)]
        omega = 2 * np.pi * found.frequency[0]
        assert omega == pytest.approx(abs(root), rel=r**2)
        errors.append(abs(found.damping[0] - -root.real / abs(root)) / found.damping[0])
    assert errors[0] < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)


def test_a_stiff_string_has_modes_of_both_kinds(tmp_path):
    """Across the line nothing relaxes; along it modes pass some of those as they stiffen."""
    text = f"dimensions = 2\n{ROPE}"
    count = 12
    found = modes_of(tmp_path, text, count=count)
    size, mass, k = 105 / 32, 100 / 32, np.arange(1, 25)
    sines = 4 * np.sin(k * np.pi / 64) ** 2
    across = np.sqrt(50e3 / size * sines / mass)
    along = [
        own_frequency(lambda w, s=s: (1e6 + dynamic(w, FAST, SLOW).real) * s / (100 / 32 * mass))
        for s in sines[:4]
    ]
    order = np.argsort([*across, *along], kind="stable")[:count]
    assert 2 * np.pi * found.frequency == pytest.approx(
        np.concatenate([across, along])[order], rel=1e-7
    )
    assert found.axial == pytest.approx((order >= across.size).astype(float), abs=1e-9)
    assert np.all(found.damping[order < across.size] < 1e-12)
    assert np.all(found.damping[order >= across.size] > 0.02)


def test_two_ropes_that_relax_apart_with_a_mass_between(tmp_path):
    text = """
dimensions = 1
[materials.one]
law = "linear"
EA = "1 MN"
relaxation.only = { EA = "500 kN", time = "20 ms" }

[materials.other]
law = "linear"
EA = "2 MN"
relaxation.only = { EA = "1 MN", time = "3 ms" }

[lines.left]
material = "one"
length = "10 m"
segments = 3
mass = "2 kg/m"
start = { fixed = [0, 0, 0] }
end = "load"

[lines.right]
material = "other"
length = "8 m"
segments = 2
mass = "3 kg/m"
start = "load"
end = { fixed = [18.5, 0, 0] }

[bodies.load]
mass = 40

[output]
duration = 1
every = 1
"""
    found = modes_of(tmp_path, text, count=4)
    one, two = 10 / 3, 4.0
    springs = np.zeros((5, 4))
    springs[:4] += np.eye(4)
    springs[1:] -= np.eye(4)
    mass = np.diag([2 * one, 2 * one, one + 40 + 1.5 * two, 3 * two])

    def stiffness(omega):
        left = 1e6 + dynamic(omega, (500e3, 20e-3))
        right = 2e6 + dynamic(omega, (1e6, 3e-3))
        return springs.T @ np.diag([left / one] * 3 + [right / two] * 2) @ springs

    for k in range(4):
        omega = own_frequency(lambda w, k=k: eigh(stiffness(w).real, mass)[0][k], 0.1, 1e5)
        assert 2 * np.pi * found.frequency[k] == pytest.approx(omega, rel=1e-10)
        _, vectors = eigh(stiffness(omega).real, mass)
        loss = vectors[:, k] @ stiffness(omega).imag @ vectors[:, k]
        assert found.damping[k] == pytest.approx(loss / (2 * omega**2), rel=1e-7)


def test_a_relaxing_line_on_a_winch(tmp_path):
    text = line_on_a_winch('relaxation.only = { EA = "500 kN", time = "20 ms" }')
    found = modes_of(tmp_path, text, count=5)
    n, stretch = 5, 1.05
    length = 12.0 / stretch
    size = length / n
    ways = springs_on_a_winch(n, stretch)
    mass = np.diag([2.0 * size] * 4 + [2.0 * length / 3.0 + 30.0])
    form = ways.T @ ways / size
    for k, square in enumerate(eigh(form, mass, eigvals_only=True)):
        omega = own_frequency(
            lambda w, square=square: (1e6 + dynamic(w, (500e3, 20e-3)).real) * square
        )
        assert 2 * np.pi * found.frequency[k] == pytest.approx(omega, rel=1e-8)
        loss = dynamic(omega, (500e3, 20e-3)).imag * square
        assert found.damping[k] == pytest.approx(loss / (2 * omega**2), rel=1e-6)


WEIGHT = """
gravity = 10
dimensions = 3

[materials.hooke]
law = "linear"
EA = "1 MN"
relaxation.only = { EA = "40 kN", time = "60 ms" }

[lines.rope]
material = "hooke"
length = "10 m"
segments = 2
mass = "1e-3 kg/m"
start = { fixed = [0, 0, 0] }
end = "load.ring"

[bodies.load]
mass = 1000
position = [0, 0, -11.1]
inertia = [400, 500, 600]
points = { ring = [0, 0, 1] }
free = ["z"]
settle = true

[output]
duration = "6 s"
every = "10 ms"
"""


@pytest.mark.slow
def test_a_weight_swings_and_dies_out_as_they_say(tmp_path):
    found = modes_of(tmp_path, WEIGHT, count=1)
    ran = run_text(tmp_path, WEIGHT.replace("settle = true", "velocity = [0, 0, 0.01]"))
    height = ran.bodies["load"]["position"][0, :, 2]

    def left(omega, share):
        decay = np.exp(-share * omega * ran.time)
        ways = np.stack([decay * np.cos(omega * ran.time), decay * np.sin(omega * ran.time)])
        # what relaxes creeps from the start by itself, to first order of its share
        ways = np.stack([*ways, np.ones_like(ran.time), np.exp(-ran.time / 60e-3)], axis=1)
        amount = np.linalg.lstsq(ways, height, rcond=None)[0]
        return np.linalg.norm(height - ways @ amount) / np.linalg.norm(height - height.mean())

    omega, share = 2 * np.pi * found.frequency[0], found.damping[0]
    assert left(omega, share) < 2e-3
    assert min(left(f * omega, share) for f in (0.995, 1.005)) > 0.04
    assert min(left(omega, f * share) for f in (0.8, 1.2)) > 0.02


CARGO = """
dimensions = 2
gravity = 9.81

[materials.steel]
{law}

[bodies.cargo]
mass = 60
on = {{ line = "highline", place = "24 m" }}

[lines.highline]
material = "steel"
length = "60 m"
segments = 20
mass = "3 kg/m"
start = {{ fixed = [0, 0, 0] }}
end = {{ winch = {{ at = [60, 0, 0], tension = 80e3 }} }}

[output]
duration = 1
every = 1
"""


@pytest.mark.slow
def test_cargo_on_a_line_that_has_no_time_to_relax(tmp_path):
    """As on one whose law is as steep there: a table through the same tension."""
    slow = 'law = "linear"\nEA = "4 MN"\nrelaxation.only = { EA = "6 MN", time = "1e6 s" }'
    strain = [0.0, 0.015, 0.0175, 0.02, 0.0225, 0.025]
    tension = [0.0, 30e3, 55e3, 80e3, 105e3, 130e3]
    fast = f'law = "table"\nstrain = {strain}\ntension = {tension}'
    found = modes_of(tmp_path, CARGO.format(law=slow), count=16)
    expected = modes_of(tmp_path, CARGO.format(law=fast), count=16)
    assert found.frequency == pytest.approx(expected.frequency, rel=2e-4)
    assert np.all(found.damping < 1e-6)
    soft = modes_of(tmp_path, CARGO.format(law=slow.split("relaxation")[0]), count=16)
    pays = [
        each.frequency[np.argmax(each.winch_share["winch of highline"])] for each in (found, soft)
    ]
    assert pays[0] / pays[1] == pytest.approx(np.sqrt(2.5), rel=0.02)
