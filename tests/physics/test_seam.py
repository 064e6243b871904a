"""A cut at a place that is known only when the program runs: what it does to arrays."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.physics.linear import pick
from lumpedcable.physics.place import place_at_end
from lumpedcable.physics.seam import Seam
from lumpedcable.physics.tips import AFTER, BEFORE

NODES = jnp.asarray([[0.0, 1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0, 9.0]])
SEGMENTS = jnp.asarray([10.0, 11.0, 12.0, 13.0])


def of(function, before):
    """What a compiled function makes of a seam, whose place it does not know beforehand."""
    return np.asarray(jax.jit(lambda k: function(Seam(k)))(jnp.asarray(before)))


def test_the_node_at_the_cut_stands_on_both_sides_of_the_hole():
    opened = of(lambda seam: seam.opened(NODES)[0], 1)
    assert opened[0] == 0.0
    assert opened[1] == opened[3] == 1.0  # the two ends
    assert list(opened[4:]) == [2.0, 3.0, 4.0]
    assert list(np.flatnonzero(of(lambda seam: seam.hole(7), 1))) == [2]


def test_segments_keep_to_their_sides_of_the_slots():
    wide = of(lambda seam: seam.widened(SEGMENTS), 3)
    gap = of(lambda seam: seam.gap(6), 3)
    assert list(np.flatnonzero(gap)) == [3, 4]
    assert list(wide[~gap]) == list(SEGMENTS)


@pytest.mark.parametrize("before", [1, 2, 3])
def test_parts_are_what_was_put_together(before):
    nodes = [np.asarray(x) for x in jax.jit(
        lambda k: Seam(k).parts(Seam(k).opened(NODES), 4, True))(jnp.asarray(before))]  # fmt: skip
    segments = [np.asarray(x) for x in jax.jit(
        lambda k: Seam(k).parts(Seam(k).widened(SEGMENTS), 3, False))(jnp.asarray(before))]  # fmt: skip
    rest = 4 - before
    np.testing.assert_array_equal(nodes[0][:, : before + 1], NODES[:, : before + 1])
    np.testing.assert_array_equal(nodes[1][:, : rest + 1], NODES[:, before:])
    assert np.all(np.isnan(nodes[0][:, before + 1 :]))
    assert np.all(np.isnan(nodes[1][:, rest + 1 :]))
    np.testing.assert_array_equal(segments[0][:before], SEGMENTS[:before])
    np.testing.assert_array_equal(segments[1][:rest], SEGMENTS[before:])
    assert np.all(np.isnan(segments[0][before:]))
    assert np.all(np.isnan(segments[1][rest:]))


def test_ends_at_the_cut_are_counted_inwards():
    line = jnp.arange(12.0)  # segments 0 ... 4 | slots 5, 6 | 7 ... 11
    seam = Seam(jnp.asarray(5))
    assert [int(seam.segment(BEFORE, k)) for k in range(3)] == [4, 3, 2]
    assert [int(seam.segment(AFTER, k)) for k in range(3)] == [7, 8, 9]
    assert [int(seam.node(BEFORE, k)) for k in range(3)] == [5, 4, 3]
    assert [int(seam.node(AFTER, k)) for k in range(3)] == [7, 8, 9]
    assert (int(seam.slot(BEFORE)), int(seam.slot(AFTER))) == (5, 6)
    assert list(of(lambda seam: seam.last(line, BEFORE, 3), 5)) == [4.0, 3.0, 2.0]
    assert list(of(lambda seam: seam.last(line, AFTER, 3), 5)) == [7.0, 8.0, 9.0]


@pytest.mark.parametrize("index", [0, 2, 4])
def test_a_place_known_late_is_the_place_known_early(index):
    value = jnp.asarray([-1.0, -2.0])

    def early(x):
        return x[:, index], x.at[:, index].set(value)

    def late(x):
        here = jnp.asarray(index)
        return pick(x, here), place_at_end(x, here, value)

    for function in (lambda f: f, jax.jacfwd, jax.jacrev):
        for mine, plain in zip(function(late)(NODES), function(early)(NODES), strict=True):
            np.testing.assert_array_equal(mine, plain)
