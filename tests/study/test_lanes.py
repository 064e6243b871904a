"""Many runs at once must give what each gives alone: against `jax.vmap`, operation by operation."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from lumpedcable.physics.place import framed, place, place_at_end
from lumpedcable.study.compiled import configure
from lumpedcable.study.lanes import across

configure()

RUNS = 5
MATRIX = jnp.arange(12.0).reshape(3, 4)


def elementwise(x, y):
    return jnp.tanh(x) * y[0] + jnp.where(x > 0.5, x, jnp.clip(y, 0.1, 0.4)[:4]) ** 2 - 3


def slices(x, y):
    whole = jnp.pad(x[1:], (0, 2)) + jnp.concatenate([y[::2], MATRIX[0, :2], x[:1]])[:5]
    return (
        whole[::-1].reshape(5, 1).T,
        jnp.squeeze(whole[None], 0),
        lax.dynamic_slice(x, (1,), (2,)),
    )


def writes(x, y):
    lead = place(jnp.zeros((2, 4)), x[None], 1, 0)
    return place_at_end(lead, -1, y[:2]), framed(y[:1], x, y[-1:]), x.at[2].set(y[0])


def products(x, y):
    big = jnp.outer(x, y) + MATRIX[:, :1].T @ MATRIX[:, :1]
    return jnp.dot(x, x), MATRIX @ x, big @ y, jnp.stack([x, x]) @ jnp.stack([y[:4], x]).T


def reductions(x, y):
    return (
        jnp.sum(x),
        jnp.max(jnp.stack([x, y[:4]]), axis=0),
        jnp.argmin(y),
        jnp.cumsum(x),
        jnp.any(x > 1),
    )


def loops(x, y):
    grown = lax.fori_loop(0, 3, lambda i, c: (c[0] + c[1], c[1] * 2.0, c[2] + i), (x, 1.0, 0))
    carry, rows = lax.scan(lambda c, r: (c + r * y[0], (c, r)), jnp.zeros(4), MATRIX)
    return grown, carry, rows


def until_each_is_done(x, y):
    return lax.while_loop(lambda v: jnp.sum(v) < 20.0, lambda v: v * 1.5 + 0.1, jnp.abs(x))


def as_often_as_each_says(x, y):
    count = jnp.sum(x > 0.5)
    return lax.while_loop(lambda c: c[0] < count, lambda c: (c[0] + 1, c[1] * 1.5), (0, x))


def choices(x, y):
    known = lax.cond(MATRIX[0, 1] > 0, lambda v: v * 2.0, lambda v: v + MATRIX[0], x)
    own = lax.cond(x[0] > 0.5, lambda v: jnp.sin(v), lambda v: jnp.cos(v) * y[0], x)
    return known, own


def derivatives(x, y):
    return jax.grad(lambda v: jnp.sum(jnp.tanh(v) * y[:4]))(x), jax.jvp(jnp.sin, (x,), (y[:4],))[1]


def solved(x, y):
    return jnp.linalg.solve(jnp.outer(x, x) + jnp.eye(4), x), jnp.sort(y), y[jnp.argsort(x)]


def checked(x, y):
    """A check that raises, and must not where no run is wrong: its branch is not to be run for all."""
    return eqx.error_if(x, jnp.any(x < 0.0), "expected nothing negative") * y[0]


def nested(x, y):
    return jax.jit(lambda v: jax.vmap(lambda s: s * y)(v))(x), jnp.linalg.norm(x), MATRIX


@pytest.mark.parametrize(
    "function",
    [elementwise, slices, writes, products, reductions, loops, until_each_is_done,
     as_often_as_each_says, choices,
     derivatives, solved, checked, nested],
    ids=lambda f: f.__name__,
)  # fmt: skip
def test_the_same_as_each_alone(function):
    rng = np.random.default_rng(3)
    x, y = jnp.asarray(rng.random((RUNS, 4))), jnp.asarray(rng.random((RUNS, 5)))
    together = jax.jit(lambda a, b: across(function, a, b))(x, y)
    alone = [function(a, b) for a, b in zip(x, y, strict=True)]
    for got, *expected in zip(
        jax.tree.leaves(together), *(jax.tree.leaves(one) for one in alone), strict=True
    ):
        assert got.dtype == jnp.asarray(expected[0]).dtype
        # rounding of sums in another order
        np.testing.assert_allclose(got, jnp.stack(expected), rtol=1e-14, atol=1e-14)


def along(x):
    """Reductions of every kind, of one axis, of two and of the other."""
    whole = jnp.sum(x), jnp.max(x), jnp.min(x), jnp.all(x > 1e-3), jnp.any(x > 0.999)
    return whole, jnp.sum(x, axis=1), jnp.sum(x, axis=0), jnp.max(x[0]), jnp.mean(x[1])


@pytest.mark.parametrize(
    ("runs", "count"),
    [
        (runs, count)
        if count in (32, 33, 1601)
        else pytest.param(runs, count, marks=pytest.mark.slow)
        for runs in (1, 7, 8)
        for count in (31, 32, 33, 40, 100, 101, 127, 128, 1601)
    ],
)
def test_long_axes_of_few_runs_are_reduced_as_they_are_alone(runs, count):
    x = jnp.asarray(np.random.default_rng(count).random((runs, 2, count)))
    x = x.at[0, 1, count // 2].set(jnp.inf)  # shows in sums and in extremes
    together = jax.jit(lambda a: across(along, a))(x)
    by_itself = jax.jit(along)
    alone = [by_itself(one) for one in x]
    for got, *expected in zip(
        jax.tree.leaves(together), *(jax.tree.leaves(one) for one in alone), strict=True
    ):
        np.testing.assert_allclose(got, jnp.stack(expected), rtol=1e-13)
    assert np.isinf(together[0][0][0])


def test_a_wrong_lane_would_be_found():
    x = jnp.arange(6.0).reshape(3, 2)
    got = across(lambda v: v[::-1], x)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(got, x)
