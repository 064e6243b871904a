"""Which results differ from run to run must be known, neither too few of them nor too many."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import lax

from lumpedcable.study import differing as flows
from lumpedcable.study import lanes
from lumpedcable.study.compiled import configure
from lumpedcable.study.differing import differing

configure()

X, N = jnp.arange(1.0, 5.0), jnp.asarray(3)


def plain(x, n):
    return x + n, n * 2, jnp.sum(x), jnp.arange(4) + n


def slowly(x, n):
    """A loop in which what differs is handed on by one place at each turn."""
    return lax.fori_loop(0, n, lambda i, c: (x[0], c[0], c[1], c[3] + i), (0.0, 0.0, 0.0, 0))


def rows(x, n):
    carry, out = lax.scan(lambda c, r: (c + 1, (r * n, r * x[0])), n, jnp.ones((3, 2)))
    return carry, *out


def often(x, n):
    """How often is each run's own affair, and so is all that comes of it."""
    return lax.while_loop(lambda c: c[1] < x[0], lambda c: (c[0] + 1, c[1] + n), (0, 0))


def either(x, n):
    return lax.cond(n > 2, lambda: (x, n), lambda: (x * 2, n + 1))


def by_itself(x, n):
    return lax.cond(x[0] > 2, lambda: (x, n), lambda: (x * 2, n + 1))


def within(x, n):
    return jax.jit(lambda a, b: (a * b, b))(x, n)


def looked_up(x, n):
    places = jnp.arange(8)
    return (
        places[n],
        places[jnp.sum(x > 2)],
        lax.dynamic_slice(x, (n,), (1,)),
        jnp.sort(x),
        jnp.sort(places),
    )


@pytest.mark.parametrize(
    ("function", "by_x", "by_n"),
    [
        (plain, [True, False, True, False], [True, True, False, True]),
        (slowly, [True, True, True, False], [True, True, True, True]),
        (rows, [False, False, True], [True, True, False]),
        (often, [True, True], [True, True]),
        (either, [True, False], [True, True]),
        (by_itself, [True, True], [False, True]),
        (within, [True, False], [True, True]),
        (looked_up, [False, True, True, True, False], [True, False, True, False, False]),
    ],
    ids=lambda v: getattr(v, "__name__", ""),
)
def test_what_comes_of_a_number_that_differs(function, by_x, by_n):
    closed = jax.make_jaxpr(function)(X, N)
    assert differing(closed, [True, False], 3) == by_x
    assert differing(closed, [False, True], 3) == by_n
    assert differing(closed, [False, False], 3) == [False] * len(by_x)


@pytest.mark.parametrize(
    "function", [plain, slowly, rows, often, either, by_itself, within, looked_up]
)
def test_what_is_said_to_be_common_is(function):
    many = jnp.asarray(np.random.default_rng(5).random((6, 4)) * 5)
    found = [jax.tree.leaves(function(x, N)) for x in many]
    marks = differing(jax.make_jaxpr(function)(X, N), [True, False], 6)
    for mark, values in zip(marks, zip(*found, strict=True), strict=True):
        same = all(np.array_equal(values[0], value) for value in values)
        assert same == (not mark)


def test_what_is_said_to_have_a_rule_has_one():
    assert set(lanes.RULES) == flows.MOVING
    assert set(lanes.LOOPS) == set(flows.LOOPS)
