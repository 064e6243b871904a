"""The scene's own coordinates, and those in space."""

import numpy as np

from lumpedcable.model.coordinates import Coordinates


def test_what_has_blown_up_is_told_in_space_without_a_warning():
    # infinity times the nought of an axis is undefined; a warning would fail this test
    line = Coordinates(np.array([[1.0], [0.0], [0.0]]), np.zeros(3))
    found = line.expand(np.array([[2.0, np.inf, -1e308]]), 0)
    np.testing.assert_array_equal(found[:, 0], [2.0, 0.0, 0.0])
    assert found[0, 1] == np.inf
    assert found[0, 2] == -1e308
