"""Exact derivatives: of what is seen, by numbers of the scene, through statics and every step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from case import assert_gradient, assert_order
from catalogue import CASES, options
from nylon_line import MASS, cut
from player import sensitivity, setting_of
from release_cases import PULLED, SHOCK_WAVE, slope_at, towards_wall

from lumpedcable.exact import elastic_catenary, release_wave
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE
from lumpedcable.study.plan import structure_of

PAIRS = [(name, key) for name, case in CASES.items() for key in case.gradients]
# an event and a pretension; the others take as long to compile, each by itself
QUICK = {
    ("linear release, ramped", "events.break.time"),
    ("plateau", "lines.rope.end.held.pretension"),
    ("free fall", "gravity"),
}


def marked(pairs, quick):
    slow = pytest.mark.slow
    return [pair if pair in quick else pytest.param(*pair, marks=slow) for pair in pairs]


def assert_right(name, key, *overrides):
    case = CASES[name]
    _, found = case.gradient(key, *overrides)
    exact = case.gradients[key](case.play(*overrides).seen)
    assert_gradient(found, exact, case.allowed(), mean=case.mean)


@pytest.mark.parametrize(("name", "key"), marked(PAIRS, QUICK))
def test_forward(name, key):
    assert_right(name, key)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "key", "stepping"),
    [("taut string", "lines.rope.end.fixed.0", "tsit5"),
     ("shaken end", "lines.rope.end.motion.period", "dopri8"),
     ("standing axial wave", "materials.hooke.EA", "euler"),
     ("plateau", "lines.rope.end.held.pretension", "viscous"),
     ("plateau", "lines.rope.end.held.pretension", "plain")],
)  # fmt: skip
def test_forward_through_other_integrators(name, key, stepping):
    assert_right(name, key, *options(CASES[name], stepping))


@pytest.mark.parametrize(
    ("name", "key"), marked(PAIRS, {("linear release, ramped", "events.break.time")})
)
def test_reverse_is_forward(name, key):
    # d(sum of squares)/dp both ways: the same sums in another order. What cancels in the sum
    # of products leaves its rounding
    case = CASES[name]
    value, slope = case.gradient(key)
    _, found = case.gradient(key, reverse=True)
    parts = 2.0 * value * slope
    assert np.isfinite(found)
    assert float(found) == pytest.approx(np.sum(parts), abs=1e-9 * np.sum(np.abs(parts)))


def test_a_plateau_by_its_pretension():
    # dw/dT0 = 1/(m c(e0)) of the simple wave, in numbers: 1/(2.238 kg/m 657.8556 m/s)
    exact = CASES["plateau"].gradients["lines.rope.end.held.pretension"](None)
    assert exact[0] == pytest.approx(6.7923e-4, rel=1e-4)


@pytest.mark.slow
def test_the_end_behind_a_shock_by_its_pretension():
    # where the tension jumps it has no derivative; the end's speed has
    case = CASES["shock"]

    def speed(seen):
        return towards_wall(seen)[4:, -1].mean()

    line = f"rope.segments={case.segments}"
    value, found = sensitivity(case.text, PULLED, speed, line)
    exact = slope_at(lambda T0: release_wave(cut, MASS, tension0=T0).end_speed, 450e3)
    assert value == pytest.approx(SHOCK_WAVE.end_speed, rel=case.bound(case.segments))
    assert found == pytest.approx(exact, rel=case.allowed())


# --- statics --------------------------------------------------------------------------------------

SAGGING = """
gravity = 9.81
[materials.wire]
law = "linear"
EA = 2e5
[lines.rope]
material = "wire"
length = 100
segments = 8
mass = 2
start = { fixed = [0, 0, 0] }
end = { fixed = [99, 0, 0] }
[output]
duration = 1
every = 1
"""


def sag(EA=2e5, length=100.0, mass=2.0):
    """Sag (m) of the middle of the elastic catenary."""
    return -float(elastic_catenary(99.0, 0.0, length, EA, mass * 9.81).position(0.5 * length)[1])


BY = {"materials.wire.EA": ("EA", 2e5), "lines.rope.length": ("length", 100.0),
      "lines.rope.mass": ("mass", 2.0)}  # fmt: skip


def slope_of_sag(segments, key, reverse=False):
    """d(sag)/d(key) by the engine."""
    setting = setting_of(SAGGING, f"rope.segments={segments}")
    scene, layout = setting.scene, structure_of(setting.scene).layout
    values = scene.numbers()

    def f(value):
        found = start_of(scene.with_numbers({**values, key: value}), layout, setting.coordinates)
        return -found.model.lines["rope"].reference[-1, segments // 2]

    slope = (jax.grad if reverse else jax.jacfwd)(f)
    return float(jax.jit(slope, compiler_options=RUN_ONCE)(jnp.asarray(values[key])))


def exact_slope(key):
    """d(sag)/d(key) of the exact catenary, by central differences of sixth order in 0.1 %."""
    name, at = BY[key]
    h, parts = 1e-3 * at, ((1, 45.0), (2, -9.0), (3, 1.0))
    whole = sum(w * (sag(**{name: at + k * h}) - sag(**{name: at - k * h})) for k, w in parts)
    return whole / (60.0 * h)


@pytest.mark.slow
@pytest.mark.parametrize("key", BY)
def test_sag(key):
    exact = exact_slope(key)
    errors = [abs(slope_of_sag(n, key) / exact - 1.0) for n in (8, 16)]
    # lumps on a curve: second order
    assert_order(errors, 2, (1.8, 2.2))
    assert errors[-1] < 0.01


@pytest.mark.slow
def test_sag_in_reverse():
    found = slope_of_sag(8, "materials.wire.EA", reverse=True)
    assert found == pytest.approx(slope_of_sag(8, "materials.wire.EA"), rel=1e-10)
