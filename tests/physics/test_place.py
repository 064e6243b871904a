"""Writing in place: the same values and derivatives as a concatenation, one run or many."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.place import framed, place, place_at_end

LINE = jnp.asarray([0.5, 1.0, -2.0, 4.0])
RUNS = jnp.stack([LINE, 2.0 * LINE, LINE**2])
OVER = jnp.full(6, jnp.nan)  # whatever stood there must not matter


def written(x, into=None):
    return framed(x[:1] ** 2, jnp.sin(x), 3.0 * x[-1:], into)


def joined(x):
    return jnp.concatenate([x[:1] ** 2, jnp.sin(x), 3.0 * x[-1:]])


@pytest.mark.parametrize("into", [None, OVER], ids=["anew", "over"])
def test_values_and_derivatives_are_those_of_a_concatenation(into):
    np.testing.assert_array_equal(written(LINE, into), joined(LINE))
    here, there = (
        jax.jacrev(f)(LINE) for f in (lambda x: written(x, into), joined)
    )  # both modes, since fitting uses either
    np.testing.assert_allclose(here, there, rtol=1e-15)
    np.testing.assert_allclose(jax.jacfwd(lambda x: written(x, into))(LINE), there, rtol=1e-15)


def test_a_batch_is_its_runs():
    together = jax.jit(jax.vmap(written))(RUNS)
    np.testing.assert_array_equal(together, jnp.stack([written(x) for x in RUNS]))
    slopes = jax.vmap(jax.jacrev(written))(RUNS)
    np.testing.assert_array_equal(slopes, jnp.stack([jax.jacrev(written)(x) for x in RUNS]))
    mixed = jax.vmap(lambda x: place(LINE, x[:1], 2))(RUNS)  # one array is shared by all runs
    np.testing.assert_array_equal(mixed[:, 2], RUNS[:, 0])
    np.testing.assert_array_equal(mixed[:, 3], np.full(3, LINE[3]))


def test_a_batch_is_no_scatter():
    program = jax.jit(jax.vmap(written)).lower(RUNS).as_text()
    assert "dynamic_update_slice" in program
    assert "scatter" not in program
    # the check sees one where there is one
    usual = jax.vmap(lambda x: jax.lax.dynamic_update_slice(x, x[:1], (1,)))
    assert "scatter" in jax.jit(usual).lower(RUNS).as_text()


def test_the_place_may_be_found_out_later():
    def spread(x):
        return jax.lax.fori_loop(0, 3, lambda k, x: place(x, 2.0 * x[:1], k + 1), x)

    expected = jnp.stack([x.at[1:].set(2.0 * x[0]) for x in RUNS])
    np.testing.assert_array_equal(jax.jit(jax.vmap(spread))(RUNS), expected)
    places = jnp.asarray([0, 3, 1])
    apart = jax.vmap(lambda x, k: place(x, jnp.zeros(1), k))(RUNS, places)
    np.testing.assert_array_equal(apart, RUNS.at[jnp.arange(3), places].set(0.0))


@pytest.mark.parametrize("node", [0, -1])
def test_one_end(node):
    points = jnp.stack([LINE, LINE + 1.0])
    found = place_at_end(points, node, jnp.asarray([7.0, 8.0]))
    np.testing.assert_array_equal(found, points.at[:, node].set(jnp.asarray([7.0, 8.0])))
