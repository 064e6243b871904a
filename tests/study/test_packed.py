"""Trees of arrays as one array, and back."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.study.packed import pack

TREE = {
    "single": jnp.asarray([[0.1, jnp.inf], [jnp.nan, -0.0]], jnp.float32),
    "double": (jnp.asarray(0.1), jnp.linspace(0.0, 1.0, 7)),
    "whole": jnp.asarray([2**53, -3]),
    "flags": jnp.asarray([True, False, True]),
    "nothing": jnp.zeros((0, 3)),
    "none": None,
}


def same(found, expected):
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for mine, its in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert mine.dtype == its.dtype
        np.testing.assert_array_equal(mine, its)


def test_a_tree_comes_back_bit_for_bit():
    same(jax.jit(pack)(TREE).tree(), TREE)
    same(jax.jit(lambda tree: pack(tree).tree())(TREE), TREE)


def test_leading_axes_become_those_of_every_array():
    many = jax.tree.map(lambda x: jnp.stack([x, x, x]), TREE)
    packed = jax.jit(jax.vmap(pack))(many)
    same(packed.tree(), many)
    some = jax.tree.map(lambda x: np.asarray(x)[[2, 0]], packed)
    same(some.tree(), jax.tree.map(lambda x: np.asarray(x)[[2, 0]], many))


@pytest.mark.parametrize("change", [{"flags": jnp.zeros(3)}, {"whole": jnp.zeros(3, int)}])
def test_trees_of_other_types_or_shapes_are_of_another_form(change):
    assert pack(TREE).form == pack(jax.tree.map(lambda x: x + x, TREE)).form
    assert pack(TREE).form != pack(TREE | change).form
