"""Functions at one place with slopes worked out once: the same values and derivatives as jax's own."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.each import at_each, settled

N = 7
X = np.linspace(-1.0, 2.0, N)


def bent(given, values):
    """Two results and one that is not asked for, of a mask and of x, y or none, and a number k."""
    x, y, k = values
    kept = jnp.where(given, jnp.sin(k * x), x * x)
    return kept if y is None else kept * y, None, jnp.abs(x) + k


GIVEN = jnp.asarray(X > 0.5)
CASES = {"all": (jnp.asarray(X), jnp.cos(jnp.asarray(X)), jnp.asarray(1.7)),
         "one missing": (jnp.asarray(X), None, jnp.asarray(1.7))}  # fmt: skip


@pytest.mark.parametrize("values", CASES.values(), ids=CASES)
def test_values_and_derivatives_in_both_modes(values):
    def once(v):
        return at_each(bent, GIVEN, v)

    def plain(v):
        return bent(GIVEN, v)

    for mine, own in zip(
        jax.tree.leaves(once(values)), jax.tree.leaves(plain(values)), strict=True
    ):
        np.testing.assert_array_equal(mine, own)
    for mode in (jax.jacfwd, jax.jacrev):
        found, expected = (jax.tree.leaves(mode(f)(values)) for f in (once, plain))
        assert len(found) == len(expected)
        for mine, own in zip(found, expected, strict=True):
            np.testing.assert_allclose(mine, own, rtol=1e-14, atol=1e-15)


@pytest.mark.slow
def test_second_derivatives_and_batches():
    def total(f):
        return lambda x: jnp.sum(f(GIVEN, (x, jnp.exp(x), jnp.sum(x)))[0])

    x = jnp.asarray(X)
    once, plain = (jax.hessian(total(f)) for f in (lambda g, v: at_each(bent, g, v), bent))
    np.testing.assert_allclose(once(x), plain(x), rtol=1e-12, atol=1e-13)
    some = jnp.stack([x, 2.0 * x])
    np.testing.assert_allclose(jax.vmap(once)(some), jax.vmap(plain)(some), rtol=1e-12, atol=1e-13)


def test_what_does_not_change_costs_no_slope(monkeypatch):
    """A slope of each of two results by each value that changes: each is settled, by one call."""

    monkeypatch.setattr(jax, "default_backend", lambda: "cpu")  # to be followed, not compiled

    def settlings(f, *at):
        return str(jax.make_jaxpr(lambda *v: jax.jvp(f, v, v)[1])(*at)).count("name=_apart")

    x, y, k = CASES["all"]
    assert settlings(lambda x, y, k: at_each(bent, GIVEN, (x, y, k)), x, y, k) == 6
    assert settlings(lambda k: at_each(bent, GIVEN, (x, y, k)), k) == 2


def test_a_slope_without_a_value_stays_one():
    """Where the derivative is infinite or not a number, it says so."""
    at = jnp.array([0.0, -1.0])
    _, change = jax.jvp(lambda x: at_each(lambda _, v: jnp.sqrt(v), None, x), (at,), (jnp.ones(2),))
    assert np.isinf(change[0])
    assert np.isnan(change[1])


@pytest.mark.skipif(jax.default_backend() != "cpu", reason="it is the CPU's compiler that is told")
def test_what_is_settled_is_worked_out_once():
    """Compiled, two arrays that share something cheap have it in one place; else in two."""

    def places(keep):
        def both(x):
            shared = keep(jnp.abs(x))
            return shared[1:] * x[:-1], shared[:-1] - x[1:]

        text = jax.jit(both).lower(jnp.ones(1000)).compile().as_text()
        assert text is not None
        return text.count(" abs(")

    assert places(settled) == 1
    assert places(lambda x: x) == 2


def test_a_settled_number_is_the_number():
    x = jnp.asarray([0.0, -0.0, 1.5, jnp.inf, -jnp.inf, jnp.nan])
    for way in (settled, jax.jit(settled), jax.vmap(settled)):
        np.testing.assert_array_equal(way(x), x)
    np.testing.assert_array_equal(jax.grad(lambda v: jnp.sum(settled(v) * v))(x[2:3]), 2.0 * x[2:3])
