"""Inextensible lines at rest: their lengths, their tensions, and what their EA makes of both."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, run_text, scene_of
from modal_runs import modes_of
from scipy.optimize import brentq

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE

G, SPAN, MASS, RODS = 9.81, 1000.0, 5.0, 40
WIRE = f"""
gravity = {G}
[materials.wire]
law = "inextensible"
[lines.rope]
material = "wire"
length = 1001.066
segments = {RODS}
mass = {MASS}
start = {{ fixed = [0, 0, 0] }}
end = {{ fixed = [{SPAN}, 0, 0] }}
[solver]
step = "1 ms"
[output]
"""


def rods_exactly(length):
    """Horizontal tension (N), tensions (N) and sag (m) of equal rods, weighing at their joints."""
    rod = length / RODS
    upwards = MASS * G * rod * (RODS / 2 - 0.5 - np.arange(RODS))

    def tensions(pull):
        return np.hypot(pull, upwards)

    pull = brentq(lambda h: np.sum(rod * h / tensions(h)) - SPAN, 1e3, 1e7, rtol=1e-14)
    return pull, tensions(pull), np.sum((rod * upwards / tensions(pull))[: RODS // 2])


def test_a_taut_line_of_rods_hangs_by_its_own_length(tmp_path):
    # the slack is 1.066 m: a stretch of half a thousandth would be half of it
    found, coordinates = equilibrium_of(scene_of(tmp_path, WIRE))
    assert bool(found.converged)
    _, tensions, sag = rods_exactly(1001.066)
    line, place = found.model.lines["rope"], nodes_in_space(found, coordinates)
    assert -np.min(place[2]) == pytest.approx(sag, rel=1e-8)
    np.testing.assert_allclose(line.law.tension(line.reference_strain), tensions, rtol=1e-8)
    rods = np.linalg.norm(np.diff(place), axis=0)
    np.testing.assert_allclose(rods, 1001.066 / RODS, rtol=1e-9)


@pytest.mark.slow
def test_its_derivatives_are_those_of_rods(tmp_path):
    scene = scene_of(tmp_path, WIRE)
    coordinates, layout = coordinates_of([scene]), make_layout(scene)
    numbers = scene.numbers()

    def first(length):
        mine = scene.with_numbers(numbers | {"lines.rope.length": length})
        line = start_of(mine, layout, Coordinates(*coordinates)).model.lines["rope"]
        return line.law.tension(line.reference_strain)[0]

    @partial(jax.jit, compiler_options=RUN_ONCE)
    def slopes(length):
        # what reverse mode transposes is the linear part of the forward mode: statics once for both
        _, forward = jax.linearize(first, length)
        one = jnp.ones_like(length)
        return forward(one), *jax.linear_transpose(forward, length)(one)

    h = 1e-3
    slope = (rods_exactly(1001.066 + h)[1][0] - rods_exactly(1001.066 - h)[1][0]) / (2 * h)
    assert slopes(jnp.asarray(1001.066)) == pytest.approx([slope, slope], rel=1e-5)


@pytest.mark.slow
def test_it_vibrates_as_what_does_not_stretch(tmp_path):
    # Irvine & Caughey (1974): f = c/L first, and c u/(pi L) with tan(u) = u of the first shape that
    # is the same on both sides; c^2 = H/m
    found = modes_of(tmp_path, WIRE)
    speed = np.sqrt(rods_exactly(1001.066)[0] / MASS)
    even = brentq(lambda u: np.tan(u) - u, 4.0, 4.6)
    expected = speed / SPAN * np.array([1.0, even / np.pi])
    np.testing.assert_allclose(found.frequency[:2], expected, rtol=5e-3)


def test_lines_that_seem_too_short_by_rounding_stretch(tmp_path):
    text = WIRE.replace("1001.066", "999.9")
    found, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert bool(found.converged)
    place = nodes_in_space(found, coordinates)
    whole = np.sum(np.linalg.norm(np.diff(place), axis=0))
    assert SPAN < whole < 1.001 * SPAN


BOB = f"""
gravity = {G}
[materials.wire]
law = "inextensible"
EA = "100 kN"
[lines.wire]
material = "wire"
length = 10
segments = 1
mass = 0.01
start = {{ fixed = [0, 0, 0] }}
end = "bob"
[bodies.bob]
mass = 100
[solver]
step = "1 ms"
[output]
duration = "20 ms"
every = "10 ms"
"""


@pytest.mark.slow
def test_rods_that_give_way_hang_and_swing_as_springs(tmp_path):
    # half the wire hangs at its lower end
    carried = 100.0 + 0.05
    below = 10.0 * (1.0 + carried * G / 1e5)
    ran = run_text(tmp_path, BOB)
    assert ran.statuses == ["OK"]
    np.testing.assert_allclose(ran["wire.position"][0, :, -1, 2], -below, rtol=1e-12)
    np.testing.assert_allclose(ran["wire.tension"][0, :, 0], carried * G, rtol=1e-9)
    # a third of a rod moves with its end
    found = modes_of(tmp_path, BOB)
    moving = 100.0 + 0.1 / 3.0
    assert found.frequency[0] == pytest.approx(np.sqrt(1e4 / moving) / (2 * np.pi), rel=1e-9)


@pytest.mark.slow
def test_rods_in_a_current_stay_where_they_rest(tmp_path):
    # statics and dynamics take the same drag, each rod's with its own tangent: what no force of the
    # residual moves does not move, however few rods there are
    text = """
gravity = 9.81
[water]
density = 1025
current = { velocity = [0.5, 0.3, 0.1] }
[materials.wire]
law = "inextensible"
[lines.rope]
material = "wire"
length = 10
segments = 4
mass = 5
diameter = 0.06
drag = { normal = 1.2, tangential = 0.2 }
start = { fixed = [0, 0, 0] }
end = { fixed = [8, 1, 1] }
[solver]
step = "1 ms"
[output]
duration = "2 s"
every = "0.2 s"
"""
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    place = ran["position"][0]
    assert np.ptp(place[0, :, 1]) > 1.0  # it is swept aside
    np.testing.assert_allclose(place, place[:1].repeat(len(place), 0), atol=1e-7)
    np.testing.assert_allclose(
        ran["tension"][0], ran["tension"][0, :1].repeat(len(place), 0), rtol=1e-6
    )
