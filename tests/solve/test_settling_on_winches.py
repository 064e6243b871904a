"""Bodies that settle on lines that winches keep taut, and under cables with cargo."""

import jax
import numpy as np
import pytest
from engine_runs import fixed, line_text, run_text
from scipy.optimize import brentq

from lumpedcable import response

G = 9.81
WIRE = """
[materials.wire]
law = "linear"
EA = "1 MN"
"""
OUTPUT = """
[output]
duration = "0.2 s"
every = "10 ms"
"""


def winch(place, tension):
    at = place if isinstance(place, str) else str(list(place))
    return f"{{ winch = {{ at = {at}, tension = {tension} }} }}"


def stays(ran, name="box"):
    """Whether a body is where it was at the start, in its first run."""
    place, turn = (ran.bodies[name][key][0] for key in ("position", "attitude"))
    return np.abs(place - place[0]).max() < 1e-7 and np.abs(turn - turn[0]).max() < 1e-8


SPRING = (
    "dimensions = 1\n"
    + WIRE
    + "[bodies.box]\nmass = 500\nposition = [9.7, 0, 0]\nfree = ['x']\nsettle = true\n"
    "points = { eye = [0.5, 0, 0], tail = [-0.5, 0, 0] }\n"
    + line_text("left", "wire", 10, 3, 0.1, "START", "END")
    + line_text("right", "wire", 10, 3, 0.1, '"box.eye"', fixed(21, 0, 0))
    + OUTPUT
)


@pytest.mark.slow
@pytest.mark.parametrize("aboard", [False, True])
def test_a_winch_against_a_spring(tmp_path, aboard):
    """What the winch pulls with stretches the other line, wherever the winch stands."""
    start, end = winch((0, 0, 0), 20e3), '"box.tail"'
    if aboard:
        start, end = fixed(0, 0, 0), winch('"box.tail"', 20e3)
    ran = run_text(tmp_path, SPRING.replace("START", start).replace("END", end))
    assert ran.statuses == ["OK"]
    assert ran.bodies["box"]["position"][0, 0, 0] == pytest.approx(21 - 10.2 - 0.5, rel=1e-9)
    assert ran["left.end_tension"][0, 0] == pytest.approx(20e3, rel=1e-9)
    assert stays(ran)


TWO = (
    f"dimensions = 2\ngravity = {G}\n"
    + WIRE.replace("1 MN", "100 MN")
    + "[bodies.box]\nmass = 500\nposition = [0.5, 0, -1]\nsettle = true\ninertia = [50, 50, 50]\n"
    "points = { left = [-0.5, 0, 0.3], right = [0.5, 0, 0.3] }\n"
    + line_text("one", "wire", 5, 4, 1e-3, winch((-5, 0, 0), 4e3), '"box.left"')
    + line_text("two", "wire", 5, 4, 1e-3, '"box.right"', winch((5, 0, 0), 4e3))
    + OUTPUT
)


@pytest.mark.slow
def test_a_load_between_two_winches(tmp_path):
    ran = run_text(tmp_path, TWO)
    assert ran.statuses == ["OK"]
    body = ran.bodies["box"]
    slope = np.tan(np.arcsin(500 * G / 2 / 4e3))
    np.testing.assert_allclose(
        body["position"][0, 0], [0, 0, -4.5 * slope - 0.3], atol=2e-4
    )  # the lines weigh a little
    np.testing.assert_allclose(body["attitude"][0, 0], 0.0, atol=1e-9)
    assert stays(ran)


@pytest.mark.slow
def test_a_load_between_two_winches_in_space(tmp_path):
    two, three = (
        run_text(tmp_path, TWO.replace("dimensions = 2", f"dimensions = {d}")) for d in (2, 3)
    )
    np.testing.assert_allclose(
        two.bodies["box"]["position"][0, 0], three.bodies["box"]["position"][0, 0], atol=1e-8
    )


HIGHLINE = (
    f"dimensions = 2\ngravity = {G}\n"
    + WIRE.replace("1 MN", "50 MN")
    + """
[bodies.cargo]
mass = 200
on = { line = "high", place = 12 }

[bodies.ship]
mass = 5000
position = [31, 0, -4]
free = ["x"]
settle = true
points = { post = [0, 0, 4] }
control = { stiffness = [50e3, 0, 0] }

[lines.high]
material = "wire"
length = 30
segments = 30
mass = MASS
start = { fixed = [0, 0, 0] }
end = { winch = { at = "ship.post", tension = 10e3 } }
"""
    + OUTPUT
)


@pytest.mark.parametrize("model", ["ideal", pytest.param("lumped", marks=pytest.mark.slow)])
def test_a_ship_under_a_highline_with_cargo(tmp_path, model):
    """It is drawn in until its springs hold what the cable pulls it with along the water."""
    text = HIGHLINE.replace("MASS", "1e-3")
    if model == "ideal":
        text = text.replace("segments = 30", 'model = "ideal"')
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    T, weight, place = 10e3, 200 * G, 12.0

    def height(x):
        left, right = place, x - place
        return brentq(
            lambda h: T * h / np.hypot(left, h) + T * h / np.hypot(right, h) - weight, 0, 20
        )

    def pull(x):
        return 50e3 * (31 - x) - T * (x - place) / np.hypot(x - place, height(x))

    x = brentq(pull, 25, 31)
    tolerance = 1e-9 if model == "ideal" else 1e-5
    assert ran.bodies["ship"]["position"][0, 0, 0] == pytest.approx(x, abs=tolerance * x)
    cargo = ran.bodies["cargo"]["position"][0, 0]
    assert cargo[2] == pytest.approx(-height(x), rel=10 * tolerance)


@pytest.mark.slow
def test_where_it_settles_has_derivatives(tmp_path):
    """By the tension of a winch against a spring: dx/dF = -L / EA."""
    text = SPRING.replace("START", winch((0, 0, 0), 20e3)).replace("END", '"box.tail"')
    (tmp_path / "scene.toml").write_text(text)
    place = response(
        tmp_path / "scene.toml",
        ["lines.left.start.winch.tension"],
        "first position at left.end in x",
    )
    value, slope = jax.value_and_grad(place)(place.values)
    assert value == pytest.approx(21 - 10.2 - 1.0, rel=1e-9)
    assert slope[0] == pytest.approx(-10.0 / 1e6, rel=1e-6)


@pytest.mark.slow
def test_a_length_that_brings_it_to_a_place(tmp_path):
    """The spring carries what the winch pulls, whatever its length: that says where the ship is."""
    text = SPRING.replace("START", winch((0, 0, 0), 20e3)).replace("END", '"box.tail"')
    text += '[targets.berth]\nchange = "lines.right.length"\nof = "box"\nx = 10\n'
    ran = run_text(tmp_path, text)
    assert ran.statuses == ["OK"]
    assert ran.bodies["box"]["position"][0, 0, 0] == pytest.approx(10.0, rel=1e-9)
