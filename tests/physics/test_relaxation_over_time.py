"""What branches carry as strain goes along a given way: ramps, holds, loops, jumps; and its slopes."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lumpedcable.physics.relaxation import Relaxation
from lumpedcable.physics.strain_history import relaxing_tension

EA, TAU = 2e5, 3.0
ONE = Relaxation(jnp.array([EA]), jnp.array([TAU]))
TWO = Relaxation(jnp.array([2e5, 7e4]), jnp.array([3.0, 40.0]))


def carried(relaxation, strain, time):
    return np.asarray(relaxing_tension(relaxation, jnp.asarray(strain), jnp.asarray(time)))


def test_a_ramp_then_a_hold_have_their_closed_forms():
    # a pull at v for 5 s, however it is cut into rows, then a hold
    v, end = 0.01, 5.0
    time = np.array([-1.0, 0.0, 0.1, 0.7, 2.0, 4.9, end, 5.2, 9.0, 30.0])
    strain = 0.02 + v * np.clip(time, 0.0, end)
    pulled = EA * TAU * v * (1.0 - np.exp(-np.clip(time, 0.0, end) / TAU))
    exact = pulled * np.exp(-np.clip(time - end, 0.0, None) / TAU)
    assert carried(ONE, strain, time) == pytest.approx(exact, rel=1e-13, abs=1e-9)


def test_the_rows_of_a_straight_piece_do_not_count():
    few, many = np.array([0.0, 10.0, 17.0]), np.linspace(0.0, 17.0, 171)
    way = np.interp(many, few, [0.0, 0.05, 0.03])
    at = np.searchsorted(many, few)
    assert carried(TWO, way, many)[at] == pytest.approx(
        carried(TWO, np.array([0.0, 0.05, 0.03]), few), rel=1e-11
    )


def test_a_sine_in_its_cycle_has_storage_and_loss_modulus():
    # Ferry 1980, chapter 3: EA w^2 tau^2 / (1 + w^2 tau^2) and EA w tau / (1 + w^2 tau^2)
    period, cycles, points = 8.0, 12, 4000
    w = 2.0 * np.pi / period
    time = np.linspace(0.0, cycles * period, cycles * points + 1)
    found = carried(ONE, 0.1 + 0.02 * np.sin(w * time), time)
    # the first cycles have died out as exp(-64 / 3), 5e-10
    last = slice(-points - 1, -1)
    storage = 2.0 * np.mean(found[last] * np.sin(w * time[last])) / 0.02
    loss = 2.0 * np.mean(found[last] * np.cos(w * time[last])) / 0.02
    x = w * TAU
    # chords of a sine in 4000 pieces a cycle are lower than it by (2 pi / 4000)^2 / 12, 2e-7
    assert storage == pytest.approx(EA * x**2 / (1.0 + x**2), rel=3e-7)
    assert loss == pytest.approx(EA * x / (1.0 + x**2), rel=3e-7)


def test_a_way_of_straight_pieces_is_that_of_the_differential_equation():
    # dq/dt = EA de/dt - q / tau, piece by piece, by scipy
    random = np.random.default_rng(4)
    time = np.cumsum(random.uniform(0.05, 6.0, 25))
    strain = np.cumsum(0.01 * random.standard_normal(25))
    q, exact = np.zeros(2), [0.0]
    for k in range(24):
        rate = (strain[k + 1] - strain[k]) / (time[k + 1] - time[k])

        def slope(_, q, rate=rate):
            return np.asarray(TWO.stiff) * rate - q / np.asarray(TWO.time)

        span = (time[k], time[k + 1])
        q = solve_ivp(slope, span, q, rtol=1e-11, atol=1e-9).y[:, -1]
        exact.append(np.sum(q))
    assert carried(TWO, strain, time) == pytest.approx(np.array(exact), rel=1e-8, abs=1e-6)


def test_equal_times_are_a_jump_that_all_springs_take():
    time, strain = np.array([0.0, 0.0, 6.0, 6.0]), np.array([0.01, 0.04, 0.04, 0.01])
    left = 0.03 * EA * np.exp(-6.0 / TAU)
    exact = np.array([0.0, 0.03 * EA, left, left - 0.03 * EA])
    assert carried(ONE, strain, time) == pytest.approx(exact, rel=1e-14, abs=1e-9)


@pytest.mark.parametrize(("tau", "kept"), [(1e-300, 0.0), (1e-7, 0.0), (1e9, 1.0), (1e300, 1.0)])
def test_times_beyond_those_of_the_rows_are_a_law_alone_or_a_spring(tau, kept):
    time, strain = np.array([0.0, 0.0, 1.0, 2.0]), np.array([0.0, 0.01, 0.03, 0.03])

    def last(log):
        return relaxing_tension(
            Relaxation(jnp.array([EA]), jnp.exp(log)[None]), jnp.asarray(strain), jnp.asarray(time)
        )[-1]

    value, slope = jax.value_and_grad(last)(jnp.log(tau))
    assert float(value) == pytest.approx(kept * EA * 0.03, rel=1e-8, abs=1e-9)
    assert abs(float(slope)) < 1e-4


@pytest.mark.parametrize("mode", [jax.jacfwd, jax.jacrev])
def test_slopes_by_stiffness_and_time_are_those_of_differences(mode):
    random = np.random.default_rng(7)
    time = np.cumsum(random.uniform(0.0, 3.0, 30))
    time[10] = time[9]
    strain = 0.05 + 0.02 * np.sin(time)

    def way(x):
        return relaxing_tension(Relaxation(x[:2], x[2:]), jnp.asarray(strain), jnp.asarray(time))

    x = np.concatenate([TWO.stiff, TWO.time])
    found = np.asarray(mode(way)(jnp.asarray(x)))
    for k in range(4):
        step = 1e-5 * x[k] * (np.arange(4) == k)
        difference = (np.asarray(way(x + step)) - np.asarray(way(x - step))) / (2e-5 * x[k])
        top = np.max(np.abs(difference))
        # of a step h of x: h^2 / 6 of third derivatives, and rounding over it, 1e-10
        assert found[:, k] == pytest.approx(difference, abs=1e-8 * top)


def test_slopes_hold_where_rows_are_close_beside_the_time():
    # h / tau from 1e-9 to 1e-2, around where a series takes the place of the closed form
    time = np.concatenate([[0.0], np.logspace(-8.5, -1.5, 40)])
    strain = 0.5 * time

    def last(tau):
        relaxation = Relaxation(jnp.array([EA]), tau[None])
        return relaxing_tension(relaxation, jnp.asarray(strain), jnp.asarray(time))[-1]

    t = time[-1]
    exact = EA * 0.5 * (1.0 - np.exp(-t / TAU) * (1.0 + t / TAU))
    # whose terms are 1 and cancel to t^2 / (2 tau^2) = 6e-5
    slope = float(jax.grad(last)(jnp.array(TAU)))
    assert slope == pytest.approx(exact, rel=1e-10)
