"""Weight, water, ramps and motions against their formulas."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

import lumpedcable.study.compiled  # noqa: F401  (float64)
from lumpedcable.model import inertia
from lumpedcable.physics.fluid import PowerLawCurrent, TableCurrent, UniformCurrent
from lumpedcable.physics.morison import AddedMass, Drag
from lumpedcable.physics.motion import Harmonic, Recorded, Still, velocity_of
from lumpedcable.physics.ramp import release_ramp
from lumpedcable.physics.weight import buoyancy_per_length


def num(value):
    return jnp.asarray(float(value))


def test_the_paper_s_weights():
    # Zhu, Yin & Shen 2018, table 1: 2.238 kg/m weigh 21.96 N/m; sea water of 1025 kg/m3 carries all
    # but 2.217 N/m. Both hold for g = 9.81 m/s2 to their digits
    assert pytest.approx(21.96, abs=0.006) == 2.238 * 9.81
    wet = 2.238 * 9.81 - float(buoyancy_per_length(num(1025), num(9.81), num(0.05)))
    assert wet == pytest.approx(2.217, rel=3e-3)


def test_the_ramp_is_the_paper_s():
    # eq. 7: cos^2(pi t / (2 t_br)), 1 before and 0 after
    t = jnp.array([-1.0, 0.0, 1.0, 2.5, 5.0, 7.0])
    found = jax.vmap(lambda t: release_ramp(t, num(0.0), num(5.0)))(t)
    np.testing.assert_allclose(found, [1, 1, np.cos(0.1 * np.pi) ** 2, 0.5, 0, 0], atol=1e-15)


@pytest.mark.parametrize(("t", "share"), [(-1e-9, 1.0), (0.0, 0.0), (1.0, 0.0), (-np.inf, 1.0)])
def test_a_break_in_no_time(t, share):
    assert float(release_ramp(num(t), num(0.0), num(0.0))) == share
    slope = jax.grad(lambda time: release_ramp(num(t), num(0.0), time))(num(0.0))
    assert np.isfinite(float(slope))


def test_motions_move_as_they_say():
    x0, v, a = jnp.array([1.0, 2.0]), jnp.array([0.5, 0.0]), jnp.array([0.0, 3.0])
    path = Harmonic(x0, v, a, num(8.0), num(0.3))
    t, w = 1.7, 2 * np.pi / 8.0
    np.testing.assert_allclose(path.position(num(t)), [1 + 0.5 * t, 2 + 3 * np.sin(w * t + 0.3)])
    np.testing.assert_allclose(velocity_of(path, num(t)), [0.5, 3 * w * np.cos(w * t + 0.3)])
    np.testing.assert_array_equal(velocity_of(Still(x0), num(t)), [0.0, 0.0])
    # a ramp starts it from rest and ends with the motion itself, half the ramp behind in its way
    gentle = Harmonic(x0, v, a, num(8.0), num(0.0), num(4.0))
    np.testing.assert_allclose(velocity_of(gentle, num(0.0)), [0.0, 0.0], atol=1e-12)
    full = Harmonic(x0, v, a, num(8.0), num(0.0))
    np.testing.assert_allclose(gentle.position(num(5.0)), full.position(num(5.0)) - 2.0 * v)


def test_a_recorded_motion_meets_its_record():
    times = jnp.array([0.0, 1.0, 2.5, 3.0])
    record = jnp.array([[0.0, 1.0], [2.0, 1.5], [2.5, -1.0], [3.0, 0.0]])
    path = Recorded(times, record)
    for t, x in zip(times, record, strict=True):
        np.testing.assert_allclose(path.position(t), x, atol=1e-12)
    # smooth: the velocity from either side of a point is the same
    left, right = (velocity_of(path, num(2.5 + h)) for h in (-1e-9, 1e-9))
    np.testing.assert_allclose(left, right, atol=1e-6)
    # a record of a straight motion is a straight motion
    line = Recorded(times, jnp.stack([2.0 * times, -times], axis=1))
    np.testing.assert_allclose(line.position(num(1.3)), [2.6, -1.3], rtol=1e-12)
    # and goes on: a step that ends with it looks one step ahead
    np.testing.assert_allclose(line.position(num(3.4)), [6.8, -3.4], rtol=1e-12)
    np.testing.assert_allclose(velocity_of(line, num(3.4)), [2.0, -1.0], rtol=1e-12)
    np.testing.assert_array_equal(line.position(num(-1.0)), [0.0, 0.0])


@pytest.mark.parametrize(
    ("convention", "area"), [("textbook", np.pi), ("half", 0.5 * np.pi), ("projected", 1.0)]
)
def test_drag_conventions(convention, area):
    drag = Drag(num(1025), num(0.05), num(1.5), num(0.01), convention)
    assert float(drag.tangential) == pytest.approx(area * 0.5 * 1025 * 0.05 * 0.01)
    assert float(drag.normal) == pytest.approx(0.5 * 1025 * 0.05 * 1.5)


def test_added_mass_of_a_cylinder():
    # with C = 1 the mass of the displaced water, rho pi d^2 / 4
    added = AddedMass(num(1025), num(0.05), num(1.0), None)
    assert float(added.normal) == pytest.approx(1025 * np.pi * 0.05**2 / 4)
    assert added.tangential is None


def test_currents():
    z = jnp.array([5.0, 0.0, -10.0, -20.0, -25.0])
    same = UniformCurrent(jnp.array([1.0, 2.0])).velocity(z)
    np.testing.assert_array_equal(same, np.outer([1.0, 2.0], np.ones(5)))
    power = PowerLawCurrent(jnp.array([2.0]), num(1 / 7), num(20.0), num(0.0)).velocity(z)
    np.testing.assert_allclose(power[0], [2, 2, 2 * 0.5 ** (1 / 7), 0, 0], rtol=1e-12)
    slope = jax.grad(
        lambda n: PowerLawCurrent(jnp.array([2.0]), n, num(20.0), num(0.0)).velocity(z).sum()
    )(num(1 / 7))
    assert np.isfinite(float(slope))


def test_a_current_of_a_table_is_straight_between_its_heights():
    heights = jnp.array([-50.0, -20.0, 0.0])
    table = TableCurrent(heights, jnp.array([[0.0, 0.6, 1.1], [0.1, 0.2, -0.2]]))
    z = jnp.array([-80.0, -50.0, -41.0, -20.0, -10.0, 0.0, 3.0])
    expected = [[0, 0, 0.18, 0.6, 0.85, 1.1, 1.1], [0.1, 0.1, 0.13, 0.2, 0.0, -0.2, -0.2]]
    np.testing.assert_allclose(table.velocity(z), expected, atol=1e-15)
    slope = jax.grad(lambda h: TableCurrent(h, table.velocities).velocity(z[2:3])[0, 0])(heights)
    # u = 0.6 s, s = (z + 50) / 30: ds by the lower height is (s - 1) / 30, by the upper one -s / 30
    np.testing.assert_allclose(slope, [0.6 * (0.3 - 1.0) / 30.0, -0.6 * 0.3 / 30.0, 0.0])


def frame(d, drag=True, flow=None):
    """Two nodes with different masses and drags along and across a slanted tangent."""
    tangent = None if d == 1 else jnp.array([[0.6, 1.0], [0.8, 0.0], [0.0, 0.0]])[:d]
    k = (jnp.array([3.0, 0.5]), jnp.array([40.0, 7.0])) if drag else (None, None)
    return inertia.Frame(tangent, jnp.array([2.0, 1.0]), jnp.array([3.0, 1.5]), *k, flow)


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("dt", [1e-4, 0.1, 10.0])
@pytest.mark.parametrize("current", [False, True])
def test_a_kick_solves_its_equation(d, dt, current):
    # M (v+ - v-) / dt = F - k |v| v with v half way, along and across apart
    rng = np.random.default_rng(d)
    flow = jnp.asarray(rng.normal(size=(d, 2))) if current else None
    nodes = frame(d, flow=flow)
    force, before = (jnp.asarray(rng.normal(size=(d, 2)) * s) for s in (50.0, 5.0))
    middle, after = inertia.kick(nodes, force, before, num(dt))
    np.testing.assert_allclose(middle, 0.5 * (before + after), rtol=1e-12)
    gain = inertia.acceleration(nodes, force, middle)
    np.testing.assert_allclose((after - before) / dt, gain, rtol=1e-9, atol=1e-9 * 50.0)


@pytest.mark.parametrize("d", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_kick_s_derivative_is_its_differences(d):
    # also the second one: the root of the drag brings a rule of its own
    rng = np.random.default_rng(d)
    force, before = (jnp.asarray(rng.normal(size=(d, 2)) * s) for s in (50.0, 5.0))

    @jax.jit
    def of(force, before, mass, drag):
        nodes = frame(d)._replace(mass_t=mass, drag_t=drag)
        return inertia.kick(nodes, force, before, num(0.1))

    given = (force, before, jnp.array([2.0, 1.0]), jnp.array([3.0, 0.5]))
    check_grads(of, given, order=2, modes=["fwd", "rev"], eps=1e-5, rtol=1e-6)


def test_a_kick_without_drag_is_newton_s():
    nodes = frame(2, drag=False)
    force = jnp.array([[1.0, 2.0], [3.0, 4.0]])
    middle, after = inertia.kick(nodes, force, jnp.zeros((2, 2)), num(0.5))
    np.testing.assert_allclose(after, 0.5 * inertia.acceleration(nodes, force, after), rtol=1e-14)
    np.testing.assert_allclose(middle, 0.5 * after)


def test_drag_slows_down_at_second_order():
    # m dv/dt = -k v^2: v = v0 / (1 + k v0 t / m)
    nodes = inertia.Frame(None, jnp.ones(1), jnp.ones(1), jnp.array([2.0]), jnp.array([2.0]), None)
    errors = []
    for steps in (8, 16, 32):
        v = jnp.array([[3.0]])
        for _ in range(steps):
            v = inertia.kick(nodes, jnp.zeros((1, 1)), v, num(1.0 / steps))[1]
        errors.append(abs(float(v[0, 0]) - 3.0 / (1.0 + 2.0 * 3.0)))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all((ratios > 3.5) & (ratios < 4.5))


def test_kinetic_energy_counts_the_added_mass_across_only():
    nodes = frame(2)
    along = jnp.array([[0.6], [0.8]]) * jnp.array([1.0, 0.0])
    across = jnp.array([[-0.8], [0.6]]) * jnp.array([1.0, 0.0])
    assert float(inertia.kinetic_energy(nodes, along)) == pytest.approx(0.5 * 2.0)
    assert float(inertia.kinetic_energy(nodes, across)) == pytest.approx(0.5 * 3.0)
