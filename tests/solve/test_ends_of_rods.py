"""Tension at the ends of rods that swing and are moved: the reactions of rigid bodies."""

import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text

G, LENGTH, ROD = 9.81, 2.0, 10.0  # m/s2, m, kg
WIRE = """
{gravity}
[materials.wire]
law = "inextensible"
[solver]
step = {step}
[output]
duration = {duration}
every = {every}
"""


@pytest.mark.parametrize("load", [5.0, pytest.param(1e-4, marks=pytest.mark.slow)])
def test_a_rod_that_swings_pulls_at_its_pivot_and_at_its_load(tmp_path, load):
    """(m + M) g cos a + S w^2 and M (g cos a + L w^2), S = m L / 2 + M L, I w^2 / 2 = S g cos a."""
    text = WIRE.format(gravity=f"gravity = {G}", step=1e-3, duration=0.8, every=0.02)
    text += (
        f"[bodies.load]\nmass = {load}\nposition = [{LENGTH}, 0, 0]\nsize = [0.01, 0.01, 0.01]\n"
    )
    text += line_text("rod", "wire", LENGTH, 1, ROD / LENGTH, fixed(0, 0, 0), '"load"')
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    end = ran["position"][0, :, 1]
    down = -end[:, 2] / LENGTH
    arm, inertia = (ROD / 2 + load) * LENGTH, (ROD / 3 + load) * LENGTH**2
    square = 2.0 * arm * G * down / inertia
    pivot = (ROD + load) * G * down + arm * square
    # from the release on, when it begins to move
    np.testing.assert_allclose(ran["start_tension"][0, 1:], pivot[1:], atol=1e-5 * pivot.max())
    borne = load * (G * down + LENGTH * square)
    np.testing.assert_allclose(ran["end_tension"][0, 1:], borne[1:], atol=1e-5 * pivot.max())


@pytest.mark.parametrize("segments", [1, pytest.param(5, marks=pytest.mark.slow)])
def test_a_rod_that_is_heaved_pulls_with_its_mass(tmp_path, segments):
    size, period, ramp = 0.3, 0.8, 0.4
    path = f"position = [0, 0, 0], amplitude = [0, 0, {size}], period = {period}, ramp = {ramp}"
    text = WIRE.format(gravity=f"gravity = {G}", step=1e-3, duration=2.0, every=0.02)
    start = f"{{ motion = {{ {path} }} }}"
    text += line_text("rod", "wire", LENGTH, segments, ROD / LENGTH, start, '"free"')
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    turn = 2.0 * np.pi / period
    steady = ran.time > ramp + 0.01
    gain = -size * turn**2 * np.sin(turn * ran.time)
    wanted = ROD * (G + gain)  # it is pushed where the start falls faster than it would
    np.testing.assert_allclose(
        ran["start_tension"][0, steady], wanted[steady], atol=1e-4 * np.abs(wanted).max()
    )


def test_rods_at_rest_pull_with_their_weight(tmp_path):
    """A scene without a duration has no steps, and none of their accelerations."""
    text = WIRE[: WIRE.index("duration")].format(gravity=f"gravity = {G}", step=1e-3)
    text += line_text("rod", "wire", LENGTH, 4, ROD / LENGTH, fixed(0, 0, 0), '"free"')
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    assert ran["start_tension"][0, 0] == pytest.approx(ROD * G, rel=1e-9)
