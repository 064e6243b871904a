"""The slopes of the wave terms as they are written down, against those that jax finds by itself."""

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.physics.each import at_each
from lumpedcable.physics.wave_terms import Given, Values, slopes, tensions

N = 600
KINDS = [
    kind
    for kind in itertools.product((True, False), repeat=8)
    # neighbours count where the line can be slack and the step is known, turns where they do, and loads
    # where waves are corrected
    if not (kind[0] and not (kind[1] and kind[2]))
    and (kind[3] or not kind[6])
    and kind[7] <= kind[0]
]
FEW = [
    kind if sum(kind) in (0, 8) else pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS
]


def at_random(beside, steps, cut, corrected, ends, damped, loaded, turning):
    """Segments of every kind: at rest, smooth, at a front, stiff, soft and slack, loaded, at joints."""
    random = np.random.default_rng(7)
    rate = random.normal(size=(3, N)) * random.choice([1.0, 10.0, 100.0], N)
    rate = rate + random.choice([0.0, 5.0, 50.0], N)
    rate[:, :20] = 0.0
    stiffness = random.choice([1e4, 3e5, 5e5, 2e6], (3, N)) * random.uniform(0.5, 1.0, (3, N))
    tension = random.normal(size=(3, N)) * 1e4 + 1e4
    if cut:
        slack = random.random((3, N)) < 0.4
        stiffness, tension = np.where(slack, 0.0, stiffness), np.where(slack, 0.0, abs(tension))
    given = Given(
        jnp.asarray(np.arange(N) % 7 == 0, float) if ends else None,
        (jnp.asarray(np.arange(N) % 11 != 0) if ends else None, None),
        jnp.asarray(tension[1] > 0.0) if cut else None,
    )
    left, own, right = map(jnp.asarray, stiffness)
    values = Values(
        tuple(map(jnp.asarray, rate)), own, (left, right) if beside else None,
        tuple(map(jnp.asarray, tension)) if corrected else None,
        jnp.asarray(random.uniform(0.3, 0.6, N)), jnp.asarray(1.3),
        jnp.asarray(4e-4) if steps else None, jnp.asarray(30.0) if damped else None,
        jnp.asarray(random.normal(size=N)) * 2e3 if loaded else None,
        jnp.asarray(random.choice([0.0, 0.4, 1.0], N)) if turning else None,
    )  # fmt: skip
    return given, values


@pytest.mark.parametrize("kind", FEW, ids=str)
def test_slopes_are_those_that_jax_finds(kind):
    given, values = at_random(*kind)
    leaves, tree = jax.tree.flatten(values)
    random = np.random.default_rng(8)
    for mine, own in zip(
        jax.tree.leaves(slopes(given, values)[0]), jax.tree.leaves(tensions(given, values)),
        strict=True,
    ):  # fmt: skip
        np.testing.assert_array_equal(mine, own)

    def slope(of):
        return lambda change: jax.tree.leaves(jax.jvp(of, (values,), (change,))[1])

    def written(v):
        return at_each(tensions, given, v, slopes)

    by_jax = slope(lambda v: tensions(given, v))
    # compiled as well, where equal numbers need not be equal to the last bit
    ways = slope(written), slope(jax.jit(written))
    for k, moved in enumerate(leaves):
        change = [jnp.zeros_like(x) for x in leaves]
        change[k] = jnp.asarray(random.normal(size=moved.shape)) * jnp.maximum(abs(moved), 1e-3)
        change = tree.unflatten(change)
        expected = by_jax(change)
        # a slope of the correction is the difference of the two others
        most = max(float(jnp.max(jnp.abs(own))) for own in expected)
        for way in ways:
            for mine, own in zip(way(change), expected, strict=True):
                np.testing.assert_allclose(mine, own, rtol=1e-9, atol=1e-13 * most)


def test_every_case_of_the_formulas_is_among_them():
    given, values = at_random(*8 * [True])
    taut = np.asarray(given.taut)
    found = tensions(given, values)
    nu2 = np.asarray(values.stiffness / values.mass * (values.dt / values.length) ** 2)
    assert values.tension is not None
    rate, quiet = np.asarray(values.rate[1]), np.asarray(found.viscosity) == 0.0
    cut = np.asarray(found.correction == -values.tension[1])
    cases = (
        taut & cut, taut & ~cut, taut & (nu2 > 1.0), taut & (nu2 < 0.5), taut & quiet, taut & ~quiet,
        ~taut & (rate > 0.0), ~taut & (rate < 0.0), ~taut & ~quiet & (np.asarray(values.aligned) < 1.0),
    )  # fmt: skip
    assert min(map(np.sum, cases)) >= 3
