"""The sag of a line from its nodes: under the middle of the chord, whatever nodes are near it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lumpedcable.solve.targets import sag_of

UP = jnp.array([0.0, 1.0])
UNEVEN = np.array([0.0, 0.9, 2.2, 4.1, 5.7, 8.0])


def curve(x, top=6.0, curved=0.07, more=0.0):
    return jnp.stack([x, top * x / 8 - curved * x * (8 - x) + more * x**2 * (8 - x)])


@pytest.mark.parametrize("x", [UNEVEN, np.linspace(0, 8, 3), np.linspace(0, 8, 4)])
def test_of_nodes_on_a_parabola_it_is_exact(x):
    assert sag_of(jnp.asarray(curve(x)), UP) == pytest.approx(0.07 * 16, rel=1e-12)


def test_it_does_not_depend_on_which_end_is_first():
    nodes = jnp.asarray(curve(UNEVEN, more=0.01))
    assert sag_of(nodes, UP) == pytest.approx(float(sag_of(nodes[:, ::-1], UP)), rel=1e-13)


def test_it_is_smooth_where_a_node_passes_the_middle():
    x = jnp.asarray(UNEVEN)
    slope = jax.grad(lambda at: sag_of(curve(x.at[3].set(at), more=0.01), UP))
    before, after = slope(4.0 - 1e-9), slope(4.0 + 1e-9)
    assert before == pytest.approx(float(after), abs=1e-6)
