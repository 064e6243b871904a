"""Rods that something jerks at the start, against rigid rods of the textbook: least kinetic energy.

Impulses do no work on what they leave free, so that of all velocities that keep the lengths and what is
given the right ones have the least kinetic energy (Kelvin's theorem). That of a rod is here
m |c|^2 / 2 + m l^2 w^2 / 24 of its centre's velocity c and its turning w.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import line_text, run_text, scene_of

from lumpedcable.model.bodies import body_key
from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve.integrate import initial_state
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE

MASS, SPEED = 2.0, np.array([2.0, 0.0])  # kg per m, m/s
BLOCK, SIZE, HIGH = 3.0, (0.4, 0.2, 0.3), 0.15  # kg, m, m
INERTIA = BLOCK * (SIZE[0] ** 2 + SIZE[2] ** 2) / 12.0
START = """
gravity = 9.81
[materials.a]
law = "inextensible"
[solver]
step = 1e-4
[output]
duration = 0.02
every = 0.005
"""


def line(name, length, segments, start, end, material="a"):
    return line_text(name, material, length, segments, MASS, start, end)


def moved(x, ramp="", speed=(2, 0, 0)):
    return f"{{ motion = {{ position = [{x}, 0, 0], velocity = {list(speed)}{ramp} }} }}"


def between(ramp=""):
    """A line that lies between ends, one of which is moved; not quite as far as it reaches."""
    return line("pulled", 1.0, 4, moved(4, ramp), "{ fixed = [4.9, 0, 0] }")


HUNG = (
    line("upper", 1.0, 2, moved(6), '"block.top"')
    + line("lower", 0.5, 1, '"block.low"', '"free"')
    + f"""
[bodies.block]
mass = {BLOCK}
size = {list(SIZE)}
position = [6.8, 0, -0.7]
points = {{ top = [0, 0, {HIGH}], low = [0, 0, -{HIGH}] }}
"""
)
GIVEN = """
[bodies.light]
mass = 0.5
size = [1, 1, 1]
position = [8, 0, 0]
velocity = [2, 0, 0]
free = ["x"]
points = { p = [0, 0, 0] }
[bodies.ball]
mass = 5
size = [0.1, 0.1, 0.1]
position = [10, 0, -1]
velocity = [2, 0, -1]
free = ["x", "z"]
points = { p = [0, 0, 0] }
""" + (
    line("drawn", 1.0, 1, '"light.p"', '"free"')
    + line("hung", 1.0, 2, "{ fixed = [10, 0, 0] }", '"ball.p"')
)


class Motion:
    """Velocities of points in a plane as rows on unknowns: kinetic energy and conditions on them."""

    def __init__(self, unknowns):
        self.energy, self.rows, self.right = np.zeros((unknowns, unknowns)), [], []

    def weigh(self, row, mass):
        row = np.atleast_2d(row)
        self.energy += mass * row.T @ row

    def rods(self, nodes, velocities):
        """Rods between places (n, 2) in m whose velocities are rows (n, 2, unknowns)."""
        for a, b, v, w in zip(nodes, nodes[1:], velocities, velocities[1:], strict=False):
            d, length = b - a, np.linalg.norm(b - a)
            self.weigh(0.5 * (v + w), MASS * length)
            turn = np.array([d[1], -d[0]]) @ (w - v) / length**2
            self.weigh(turn, MASS * length**3 / 12.0)
            self.give(d / length @ (w - v), 0.0)

    def give(self, rows, values):
        self.rows += list(np.atleast_2d(rows))
        self.right += list(np.atleast_1d(values))

    def found(self):
        """The unknowns (m/s, rad/s) and the kinetic energy (J)."""
        n, rows = len(self.energy), np.array(self.rows)
        whole = np.block([[self.energy, rows.T], [rows, np.zeros((len(rows),) * 2)]])
        x = np.linalg.lstsq(whole, np.concatenate([np.zeros(n), self.right]), rcond=1e-12)[0][:n]
        return x, 0.5 * x @ self.energy @ x


def chain(nodes, ends):
    """Velocities (n, 2) of a chain's nodes, of whose ends some are given, and its energy (J)."""
    n = len(nodes)
    rows = np.eye(2 * n).reshape(n, 2, 2 * n)
    motion = Motion(2 * n)
    motion.rods(nodes, rows)
    for node, given in ends.items():
        motion.give(rows[node], given)
    x, energy = motion.found()
    return x.reshape(n, 2), energy


def with_block(upper, lower, mass=BLOCK):
    """Velocities of two lines' nodes with a block between them, those of the block, and their energy."""
    n, m = len(upper), len(lower)
    every = np.eye(2 * (n - 1) + 3 + 2 * (m - 1))
    middle = 2 * (n - 1)
    free, block, last = np.split(every, [middle, middle + 3])
    at = [block[:2] + np.outer([z, 0.0], block[2]) for z in (HIGH, -HIGH)]
    above = np.concatenate([free.reshape(n - 1, 2, -1), at[0][None]])
    below = np.concatenate([at[1][None], last.reshape(m - 1, 2, -1)])
    motion = Motion(len(every))
    motion.rods(upper, above)
    motion.rods(lower, below)
    motion.weigh(block[:2], mass)
    motion.weigh(block[2], INERTIA * mass / BLOCK)
    motion.give(above[0], SPEED)
    x, energy = motion.found()
    return above @ x, below @ x, block @ x, energy


def started(scene):
    """The model of a scene at the start."""
    coordinates = Coordinates(*coordinates_of([scene]))
    return jax.jit(
        lambda: start_of(scene, make_layout(scene), coordinates).model, compiler_options=RUN_ONCE
    )()


def places(model, name):
    """Where the nodes of a line are (nodes, 2) in m."""
    line = model.lines[name]
    return np.asarray(line.shape().position).T


@pytest.mark.slow
def test_rods_start_as_a_jerk_leaves_them(tmp_path):
    model = started(scene_of(tmp_path, START + between() + HUNG + GIVEN))
    velocity = jax.jit(lambda m: initial_state(m, False, False).velocity)(model)
    begun = {name: np.asarray(velocity[name]).T for name in model.lines}
    # a rod about its end: omega = 3 v / (2 l), its tip goes at -v / 2
    assert begun["drawn"] == pytest.approx(np.array([[2.0, 0.0], [-1.0, 0.0]]), abs=2e-7)
    for name, given in {
        "pulled": {0: SPEED, -1: np.zeros(2)},
        "drawn": {0: SPEED},
        "hung": {0: np.zeros(2), -1: SPEED},
    }.items():
        exact, _ = chain(places(model, name), given)
        assert begun[name] == pytest.approx(exact, abs=2e-7)
    upper, lower, block, _ = with_block(places(model, "upper"), places(model, "lower"))
    assert begun["upper"] == pytest.approx(upper, abs=2e-7)
    assert begun["lower"] == pytest.approx(lower, abs=2e-7)
    assert velocity[body_key("block")] == pytest.approx(block, abs=2e-7)
    # however light, a body has the velocity that it is given, unless its line cannot follow
    assert velocity[body_key("light")][:2] == pytest.approx(SPEED, abs=2e-7)
    assert velocity[body_key("ball")][:2] == pytest.approx(SPEED, abs=2e-7)


@pytest.mark.slow
def test_a_jerk_is_the_limit_of_a_short_ramp_and_closes(tmp_path):
    # in which rods turn by some v ramp / l, and gravity has time for as much
    shorter = ("solver.step=1e-5", "output.duration=1 ms", "output.every=1 ms")
    jerked = run_text(tmp_path, START + between(), *shorter)
    assert jerked.statuses == ["OK"]
    _, energy = chain(jerked["pulled.position"][0, 0][:, [0, 2]], {0: SPEED, -1: np.zeros(2)})
    assert jerked.energy["kinetic"][0, 0] == pytest.approx(energy, rel=1e-6)
    assert jerked.outcomes[0].energy_closure < 1e-6
    cases = '[sweep]\n"lines.pulled.start.motion.ramp" = [2e-4, 1e-4]\n'
    slow = run_text(tmp_path, START + between(", ramp = 1e-4") + cases, *shorter)
    errors = np.abs(slow["pulled.velocity"][:, -1] - jerked["pulled.velocity"][0, -1])
    most = np.max(errors, axis=(1, 2))
    assert most[0] < 1e-2
    assert most[0] / most[1] == pytest.approx(2.0, abs=0.3)


@pytest.mark.slow
def test_rods_that_give_way_pass_on_what_their_mass_does(tmp_path):
    # no impulse of a spring: the tip's share of the momentum, the integral of s v(s) m ds, stays zero
    soft = START.replace('"inextensible"', '"inextensible"\nEA = "1 MN"')
    text = soft + line("one", 1.0, 1, moved(0, speed=(2, 0, 1)), '"free"')
    ran = run_text(tmp_path, text, "output.duration=1 ms", "output.every=1 ms")
    assert ran["one.velocity"][0, 0, 1] == pytest.approx([-1.0, 0.0, -0.5], abs=1e-9)


@pytest.mark.slow
def test_it_has_derivatives(tmp_path):
    model = started(scene_of(tmp_path, START + HUNG))

    def spin(mass):
        share = mass / BLOCK
        body = model.bodies["block"]
        own = (share * body.translation, share * body.inertia)
        mine = eqx.tree_at(lambda b: (b.translation, b.inertia), body, own)
        bodies = model.bodies | {"block": mine}
        y = initial_state(eqx.tree_at(lambda m: m.bodies, model, bodies), False, False)
        return jnp.sum(y.velocity["lower"][:, -1] ** 2)

    def exactly(mass):
        upper, lower = places(model, "upper"), places(model, "lower")
        return np.sum(with_block(upper, lower, mass)[1][-1] ** 2)

    value, forward = jax.jit(lambda m: jax.jvp(spin, (m,), (1.0,)))(BLOCK)
    h = 1e-4
    slope = (exactly(BLOCK + h) - exactly(BLOCK - h)) / (2 * h)
    assert value == pytest.approx(exactly(BLOCK), rel=1e-6)
    assert forward == pytest.approx(slope, rel=1e-5)
    assert jax.jit(jax.grad(spin))(BLOCK) == pytest.approx(slope, rel=1e-5)
