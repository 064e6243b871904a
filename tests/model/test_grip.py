"""Coulomb friction where inertia is not the same in all ways, as of nodes that lift off the bed."""

import numpy as np
import pytest

from lumpedcable.model import inertia
from lumpedcable.model.grip import MatrixInertia, _friction, _Masses

DT = 0.3


def unit(vector):
    return np.asarray(vector, float) / np.linalg.norm(vector)


def masses(tangent, along, across):
    """Inertia of one node, and its matrix (kg)."""
    t = unit(tangent)
    frame = inertia.Frame(t[:, None], np.array([along]), np.array([across]), None, None, None)
    return _Masses(frame, False), across * np.eye(t.size) + (along - across) * np.outer(t, t)


def kicked(mass, matrix, normal, velocity, limit):
    """The force (N) on a node of a velocity (m/s), and the velocity that it has then."""
    n = unit(normal)
    level = velocity - n * (n @ velocity)
    flat = mass.along(n[:, None] if isinstance(mass, _Masses) else n)
    force, taken = _friction(level[:, None], flat, np.array([limit]), DT)
    force, taken = np.asarray(force)[:, 0], np.asarray(taken)[:, 0]
    after = velocity + np.linalg.solve(matrix, force) * DT
    # what is taken along the bed is what the force does there
    plane = np.eye(n.size) - np.outer(n, n)
    np.testing.assert_allclose(-plane @ (after - velocity), taken, atol=1e-12)
    assert abs(n @ force) < 1e-10 * max(np.linalg.norm(force), 1e-3)
    return force, plane @ after


CASES = [
    ([np.cos(0.4), np.sin(0.4)], [0, 1], [1.0, 0.3]),
    ([np.cos(0.4), np.sin(0.4)], [-0.6, 0.8], [-1.0, 0.3]),
    ([0.7, 0.2, 0.5], [0, 0, 1], [0.8, -0.5, 0.1]),
    ([0.7, 0.2, 0.5], [0.1, -0.2, 0.9], [0.8, 1.5, -0.4]),
    ([0.0, 0.0, 1.0], [0, 0, 1], [0.8, 1.5, -0.4]),
]


@pytest.mark.parametrize(("tangent", "normal", "velocity"), CASES)
@pytest.mark.parametrize("joint", [False, True])
def test_it_acts_along_the_bed_against_the_motion_that_is_left(tangent, normal, velocity, joint):
    mass, matrix = masses(tangent, 4.0, 8.0)
    mass = MatrixInertia(matrix) if joint else mass
    velocity, n = np.array(velocity), unit(normal)
    plane = np.eye(n.size) - np.outer(n, n)
    # what would stop it: P M^-1 P f dt = -P v
    needed = -np.linalg.pinv(plane @ np.linalg.inv(matrix) @ plane) @ plane @ velocity / DT
    force, left = kicked(mass, matrix, normal, velocity, 1.001 * np.linalg.norm(needed))
    np.testing.assert_allclose(force, needed, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(left, 0.0, atol=1e-12)
    for share in (0.999, 0.5, 0.05):
        limit = share * np.linalg.norm(needed)
        force, left = kicked(mass, matrix, normal, velocity, limit)
        assert np.linalg.norm(force) == pytest.approx(limit, rel=1e-9)
        np.testing.assert_allclose(force, -limit * unit(left), rtol=1e-6, atol=1e-6 * limit)


def test_a_plane_is_a_part_of_space():
    for share in (0.5, 2.0):
        found = []
        for way in (np.array, lambda v: np.array([v[0], 0.0, v[1]])):
            mass, matrix = masses(way([0.9, 0.4]), 4.0, 8.0)
            force, left = kicked(mass, matrix, way([0.0, 1.0]), way([1.0, 0.3]), 10.0 * share)
            found.append([force[0], force[-1], left[0], left[-1]])
        np.testing.assert_allclose(*found, atol=1e-10)
