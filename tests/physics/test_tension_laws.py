"""Tension laws against closed forms, quadrature and each other."""

from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicHermiteSpline

import lumpedcable.study.compiled  # noqa: F401  (float64)
from lumpedcable.physics.tension import (
    Linear,
    Polynomial,
    Table,
    Tanh,
    TensionOnly,
    stiffness,
    stiffness_bound,
    strain_at,
    tension_and_stiffness,
)

# Zhu, Yin & Shen 2018, below eq. 5
P = (2.703e5, 10.2, -2.128, 2.627e5, 135.5)


def num(value):
    return jnp.asarray(float(value))


NYLON = Tanh(*map(num, P))
STRAINS = jnp.array([0.0, 0.02, 0.05, 0.11, 0.2, 0.35])
TENSIONS = jnp.array([0.0, 3e3, 1e4, 5e4, 2e5, 3e5])
LAWS = {
    "linear": Linear(num(1e6)),
    "tanh": NYLON,
    "polynomial": Polynomial(jnp.array([2e5, 1e6, -5e5])),
    "table": Table(STRAINS, TENSIONS),
    "tension only": TensionOnly(NYLON, num(0.5)),
}
POINTS = jnp.array([-0.05, 0.0, 2e-4, 0.03, 0.12, 0.208627, 0.29, 0.4])


def test_the_paper_s_law():
    # computed from eq. 5 with 10 digits, independently of this package
    assert float(NYLON.tension(num(0.0))) == pytest.approx(-42.04758014, rel=1e-9)
    assert float(NYLON.tension(num(-0.05))) == pytest.approx(-4856.833005, rel=1e-9)
    strains = strain_at(NYLON, jnp.array([0.0, 45e3, 180e3, 315e3, 450e3]), num(0.5))
    exact = [2.755803798e-4, 0.09941749867, 0.177629779, 0.2278274905, 0.2922838839]
    np.testing.assert_allclose(strains, exact, rtol=1e-9)


def test_the_paper_s_fastest_wave():
    # at the inflection e = -p3 / p2 the stiffness is p1 p2 + p5; mass 2.238 kg/m
    fastest = np.sqrt(float(stiffness_bound(NYLON, num(0.5))) / 2.238)
    assert fastest == pytest.approx(1109.950828, rel=1e-5)
    assert float(stiffness(NYLON, num(2.128 / 10.2))) == pytest.approx(2.703e5 * 10.2 + 135.5)


@pytest.mark.parametrize("name", LAWS)
def test_energy_is_the_integral_of_tension(name):
    law = LAWS[name]
    tension = jax.jit(lambda e: law.tension(e))
    for end in np.asarray(POINTS):
        corners = sorted({0.0, 2.755803798e-4, *map(float, STRAINS), float(end)})
        cuts = [c for c in corners if min(0.0, end) <= c <= max(0.0, end)]
        area = sum(
            quad(lambda e: float(tension(num(e))), a, b, epsrel=1e-12)[0] for a, b in pairwise(cuts)
        )
        area = -area if end < 0.0 else area
        energy = float(law.energy(num(end)))
        # a law that cannot push counts from its slack strain, a hair above 0 here
        assert energy - float(law.energy(num(0.0))) == pytest.approx(area, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("name", LAWS)
def test_stiffness_is_the_slope(name):
    law, h = LAWS[name], 1e-6
    inside = POINTS[3:]  # away from the corner of the cut law
    slope = (law.tension(inside + h) - law.tension(inside - h)) / (2.0 * h)
    value, found = tension_and_stiffness(law, inside)
    np.testing.assert_allclose(found, slope, rtol=1e-6)
    np.testing.assert_array_equal(value, law.tension(inside))


@pytest.mark.parametrize("name", LAWS)
def test_strain_of_a_tension_and_its_derivative(name):
    law = LAWS[name]
    for tension in (2e3, 4e4, 1.5e5):
        strain = strain_at(law, num(tension), num(0.5))
        assert float(law.tension(strain)) == pytest.approx(tension, rel=1e-12)
        slope = float(jax.grad(lambda t: strain_at(law, t, num(0.5)))(num(tension)))
        assert slope == pytest.approx(1.0 / float(stiffness(law, strain)), rel=1e-9)


def test_the_strain_of_a_tension_depends_on_the_law_s_numbers():
    # d e / d EA = -T / EA^2
    slope = jax.grad(lambda ea: strain_at(Linear(ea), num(5e4), num(0.5)))(num(1e6))
    assert float(slope) == pytest.approx(-5e4 / 1e12, rel=1e-9)


def test_a_table_passes_through_its_points_and_never_falls():
    law = LAWS["table"]
    np.testing.assert_allclose(law.tension(STRAINS), TENSIONS, atol=1e-9)
    fine = jnp.linspace(-0.1, 0.6, 7001)
    assert np.all(np.diff(jax.jit(lambda e: law.tension(e))(fine)) >= -1e-9)
    slopes = np.asarray(jax.jit(lambda e: stiffness(law, e))(fine))
    # no jumps of the wave speed: slopes of neighbours 1e-4 apart differ by little
    assert np.max(np.abs(np.diff(slopes))) < 0.03 * np.max(slopes)


def test_a_table_is_the_hermite_cubic_of_its_slopes():
    law = LAWS["table"]
    spline = CubicHermiteSpline(STRAINS, TENSIONS, law.curve.slopes)
    fine = np.linspace(0.0, 0.35, 501)
    np.testing.assert_allclose(law.tension(jnp.asarray(fine)), spline(fine), rtol=1e-10, atol=1e-6)
    # at an inner point the slope is the weighted harmonic mean of the secants (equal widths: plain)
    even = Table(jnp.array([0.0, 1.0, 2.0]), jnp.array([0.0, 1.0, 4.0]))
    assert float(even.curve.slopes[1]) == pytest.approx(2.0 * 1.0 * 3.0 / (1.0 + 3.0))


def test_a_table_goes_on_straight():
    law = LAWS["table"]
    end = (3e5 - 2e5) / 0.15
    assert float(law.tension(num(0.45))) == pytest.approx(3e5 + 0.1 * end)
    assert float(law.tension(num(-0.1))) == pytest.approx(-0.1 * 3e3 / 0.02)


def test_a_line_that_cannot_push():
    law = LAWS["tension only"]
    assert float(law.slack_strain) == pytest.approx(2.755803798e-4, rel=1e-8)
    assert np.all(law.tension(jnp.array([-0.3, 0.0, 2.7e-4])) == 0.0)
    assert np.all(law.energy(jnp.array([-0.3, 0.0, 2.7e-4])) == 0.0)
    assert float(law.tension(num(0.1))) == float(NYLON.tension(num(0.1)))


def test_a_slack_line_of_a_law_that_turns_back_up_does_not_pull():
    # T = 1e5 e + 2e6 e^2 is above 0 below e = -0.05 too: 30 kN at -0.15, where its slope is -5e5 N
    coefficients = jnp.array([1e5, 2e6])
    law = TensionOnly(Polynomial(coefficients), num(0.5))
    slack, taut = jnp.array([-0.6, -0.15, -0.02]), jnp.array([1e-3, 0.01, 0.3])
    for value in (*tension_and_stiffness(law, slack), law.energy(slack)):
        assert np.all(value == 0.0)
    tension, slope = tension_and_stiffness(law, taut)
    np.testing.assert_allclose(tension, 1e5 * taut + 2e6 * taut**2, rtol=1e-12)
    np.testing.assert_allclose(slope, 1e5 + 4e6 * taut, rtol=1e-12)
    by_number = jax.jacrev(lambda c: TensionOnly(Polynomial(c), num(0.5)).tension(slack))
    assert np.all(by_number(coefficients) == 0.0)
    # its slack side has no waves: the stiffest place is the far end, 1e5 + 4e6 * 0.5
    assert float(stiffness_bound(law, num(0.5))) == pytest.approx(2.1e6, rel=1e-12)


@pytest.mark.parametrize("name", ["linear", "tanh", "table"])
def test_laws_that_stay_slack_have_nothing_more_in_the_program(name):
    law = LAWS[name]
    cut = TensionOnly(law, num(0.5))
    bare, more = (
        sum(1 for _ in jax.make_jaxpr(lambda e, law=law: law.tension(e))(POINTS).eqns)
        for law in (law, cut)
    )
    assert more == bare + 1  # the maximum with 0
    # below the strain without tension none of them pulls again
    deep = jnp.linspace(-1.0, float(cut.slack_strain), 501)[:-1]
    assert np.all(jax.jit(lambda e: law.tension(e))(deep) <= 0.0)


def test_a_law_with_a_large_strain_does_not_overflow():
    assert np.isfinite(float(NYLON.energy(num(1e3))))
