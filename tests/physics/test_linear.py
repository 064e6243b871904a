"""Linear operations along a line: values and both ways as jax finds them from plain formulas."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.linear import differences, neighbours, pick, settled_back, sides
from lumpedcable.physics.place import framed, framed_differences, place_at_end
from lumpedcable.study.lanes import across

N = 6
RANDOM = np.random.default_rng(3)
LINE, FIRST, LAST = (jnp.asarray(RANDOM.normal(size=(2, n))) for n in (N, 1, 1))
POINT = jnp.asarray(RANDOM.normal(size=2))


def together(first, values, last):
    return jnp.concatenate([first, values, last], axis=-1)


CASES = {
    "differences": (differences, lambda x: x[..., 1:] - x[..., :-1], (LINE,)),
    "framed": (framed, together, (FIRST, LINE, LAST)),
    "framed differences": (
        framed_differences, lambda *x: jnp.diff(together(*x), axis=-1), (FIRST, LINE, LAST),
    ),
    "neighbours": (
        lambda x: jnp.stack(neighbours(x)),
        lambda x: jnp.stack([x[..., k : k + N - 2] for k in range(3)]), (LINE,),
    ),
    "neighbours of one": (
        lambda x: jnp.stack(neighbours(x)), lambda x: jnp.stack([x[..., k : k + 1] for k in range(3)]),
        (LINE[..., :3],),
    ),
    "sides of two": (
        lambda x: jnp.stack(sides(x)), lambda x: jnp.stack([x[..., :2], x[..., 2:]]), (LINE[..., :4],),
    ),
    "differences of one": (differences, lambda x: x[..., 1:] - x[..., :-1], (LINE[..., :2],)),
    "sides": (
        lambda x: jnp.stack(sides(x)), lambda x: jnp.stack([x[..., :-2], x[..., 2:]]), (LINE,),
    ),
    "first": (lambda x: pick(x, 0), lambda x: x[..., 0], (LINE,)),
    "last but one": (lambda x: pick(x, -2), lambda x: x[..., N - 2], (LINE,)),
    "at the start": (
        lambda x, y: place_at_end(x, 0, y), lambda x, y: x.at[..., 0].set(y), (LINE, POINT),
    ),
    "at the end": (
        lambda x, y: place_at_end(x, -1, y), lambda x, y: x.at[..., -1].set(y), (LINE, POINT),
    ),
    "the same": (settled_back, lambda x: x, (LINE,)),
}  # fmt: skip


def same(found, expected):
    found, expected = jax.tree.leaves(found), jax.tree.leaves(expected)
    assert len(found) == len(expected)
    for mine, own in zip(found, expected, strict=True):
        np.testing.assert_allclose(mine, own, rtol=1e-14, atol=1e-15)


def bent(of):
    """A number of the result of `of` that depends on each part of it in a way of its own."""

    def total(*operands):
        result = of(*operands)
        return jnp.sum(jnp.sin(result) * jnp.arange(1.0, result.size + 1).reshape(result.shape))

    return total


@pytest.mark.parametrize(("mine", "plain", "operands"), CASES.values(), ids=CASES)
def test_both_ways_are_those_of_the_plain_formula(mine, plain, operands):
    every = tuple(range(len(operands)))

    def ways(of):
        """Value and slopes of all operands; of one alone, and twice."""
        alone = [by(bent(of), k) for k in every for by in (jax.grad, jax.hessian)]
        found = [of, jax.jacfwd(of, every), jax.jacrev(of, every), *alone]
        return lambda *x: [one(*x) for one in found]

    same(*(jax.jit(ways(of))(*operands) for of in (mine, plain)))


@pytest.mark.parametrize(("mine", "plain", "operands"), CASES.values(), ids=CASES)
def test_many_runs_at_once(mine, plain, operands):
    some = [jnp.stack([x, 2.0 * x, x - 1.0]) for x in operands]
    every, rest = tuple(range(len(operands))), operands[1:]
    axes = (0, *(None for _ in rest))

    def ways(of, lanes):
        """Slopes in all operands or in one alone; along them, the runs laid by `lanes`."""
        slopes, along = jax.grad(bent(of), every), lambda *x: jax.jvp(of, x, x)[1]
        return lambda *x: (
            jax.vmap(slopes)(*x), jax.vmap(slopes, axes)(x[0], *rest), lanes(along, *x),
        )  # fmt: skip

    # studies lay the runs along the last axis
    found = jax.jit(ways(mine, across))(*some)
    same(found, jax.jit(ways(plain, lambda f, *x: jax.vmap(f)(*x)))(*some))


def test_single_precision_stays_single():
    x = LINE.astype(jnp.float32)
    for of in (differences, settled_back, lambda x: pick(x, 0)):
        assert jax.grad(lambda x, of=of: jnp.sum(of(x)))(x).dtype == jnp.float32
    assert framed(x[:, :1], x, x[:, :1]).dtype == jnp.float32
