"""The scene's own coordinates, and those in space."""

import jax
import numpy as np
import pytest

from lumpedcable.model.coordinates import Coordinates, coordinates_of
from lumpedcable.scene import load_study


def test_what_has_blown_up_is_told_in_space_without_a_warning():
    # infinity times the nought of an axis is undefined; a warning would fail this test
    line = Coordinates(np.array([[1.0], [0.0], [0.0]]), np.zeros(3))
    found = line.expand(np.array([[2.0, np.inf, -1e308]]), 0)
    np.testing.assert_array_equal(found[:, 0], [2.0, 0.0, 0.0])
    assert found[0, 1] == np.inf
    assert found[0, 2] == -1e308


def lines_at(tmp_path, *places):
    lines = "".join(
        f'[lines.l{k}]\nmaterial = "m"\nlength = 1\nsegments = 2\nmass = 1\n'
        f'start = {{ fixed = {p} }}\nend = "free"\n'
        for k, p in enumerate(places)
    )
    law = '[materials.m]\nlaw = "linear"\nEA = 1\n'
    (tmp_path / "s.toml").write_text(f"{law}{lines}[output]\nduration = 1\nevery = 1\n")
    return list(load_study(tmp_path / "s.toml").runs)


def test_directions_hold_however_far_apart_places_are(tmp_path):
    # the square of 1e308 is no number; the axes are those of the same places in metres
    far = coordinates_of(lines_at(tmp_path, [0, 0, 0], [3e307, 0, 4e307]))
    near = coordinates_of(lines_at(tmp_path, [0, 0, 0], [3, 0, 4]))
    np.testing.assert_allclose(far.axes, near.axes, atol=1e-15)
    with pytest.raises(ValueError, match="too far apart"):
        coordinates_of(lines_at(tmp_path, [0, 0, -1e308], [0, 0, 1e308]))


def test_a_file_of_thousands_of_places_is_a_handful_of_operations():
    """Each place by itself took a second of compiling for every fifty rows."""
    turned = Coordinates(np.array([[0.6, 0.0], [0.0, 1.0], [0.8, 0.0]]), np.array([1.0, 2.0, 3.0]))
    places = tuple(map(tuple, np.random.default_rng(1).normal(size=(2000, 3)).tolist()))
    found = turned.points(places)
    for k in (0, 777, 1999):
        np.testing.assert_array_equal(found[k], turned.point(places[k]))
    assert len(jax.make_jaxpr(lambda: turned.points(places))().eqns) < 10
    # numbers that are followed stay so
    slope = jax.grad(lambda x: turned.points([(x, 0.0, 0.0), (0.0, 0.0, x)])[1, 0])(1.0)
    assert slope == pytest.approx(0.8)
