"""Roll, pitch and yaw of cargo that hangs: those that turn its hanger to where it points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lumpedcable.model.coordinates import Coordinates
from lumpedcable.study.carried import rider_fields

UP = np.array([0.0, 0.0, 1.0])


def pointed(attitude):
    """Where what hangs down points when it is rolled, then pitched, then yawed, (.., 3)."""
    return Rotation.from_euler("xyz", attitude.reshape(-1, 3)).apply(-UP).reshape(attitude.shape)


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5, np.pi / 2, np.pi, -1.2])
def test_in_an_upright_plane(heading):
    ahead = np.round([np.cos(heading), np.sin(heading), 0.0], 15)
    coordinates = Coordinates(np.stack([ahead, UP], axis=1), np.zeros(3))
    swing, rate, h = np.array([[-1.4, -0.3, 0.0, 0.2, 1.2]]), 0.7, 1e-6
    q = np.stack([0.0 * swing, 0.0 * swing, swing], axis=-1)
    v = np.broadcast_to([0.0, 0.0, rate], q.shape)
    found = rider_fields(coordinates, q, v)
    own = np.sin(swing)[..., None] * ahead - np.cos(swing)[..., None] * UP
    np.testing.assert_allclose(pointed(found["attitude"]), own, atol=1e-12)
    later, before = (rider_fields(coordinates, q + s * h * v, v)["attitude"] for s in (1, -1))
    np.testing.assert_allclose(found["turning"], (later - before) / (2 * h), atol=1e-8)
    # it does not yaw: nothing twists it
    assert np.all(found["attitude"][..., 2] == 0.0)


def test_plane_and_space_tell_the_same():
    a, heading = 0.4, 0.9
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    plane = Coordinates(np.stack([ahead, UP], axis=1), np.zeros(3))
    hanger = np.sin(a) * ahead - np.cos(a) * UP
    both = [np.arctan2(hanger[0], -hanger[2]), np.arcsin(hanger[1])]
    space = Coordinates(np.eye(3), np.zeros(3))
    one = rider_fields(plane, np.array([[[0.0, 0.0, a]]]), np.zeros((1, 1, 3)))
    two = rider_fields(space, np.array([[[0.0, 0.0, 0.0, *both]]]), np.zeros((1, 1, 5)))
    np.testing.assert_allclose(one["attitude"], two["attitude"], atol=1e-14)
