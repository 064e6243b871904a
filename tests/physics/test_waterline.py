"""Lines and bodies that the water's surface crosses: wet shares, forces from energies, known numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from test_loads import bent_line, number, shape_of

from lumpedcable.physics.afloat import Ball, BodyLift, Box
from lumpedcable.physics.rigid import rotation
from lumpedcable.physics.waterline import Lift, Waterline

UP = {1: [1.0], 2: [0.0, 1.0], 3: [0.0, 0.0, 1.0]}


def waterline(d, surface, diameter=0.05):
    return Waterline(jnp.asarray(UP[d]), number(-surface), number(diameter))


@pytest.mark.parametrize("d", [2, 3])
def test_the_lift_of_a_line_is_minus_the_slope_of_its_energy(d):
    position, length = bent_line(d)
    for surface in np.linspace(position[-1].min() - 0.1, position[-1].max() + 0.1, 7):
        load = Lift(number(19.3), waterline(d, surface))
        slope = jax.grad(lambda x, load=load: load.energy(shape_of(x, length)))(
            jnp.asarray(position)
        )
        np.testing.assert_allclose(load.force(shape_of(position, length)), -slope, atol=1e-12)


def test_as_much_is_wet_as_is_under_water_and_weighs_on_the_ends_as_on_a_bars():
    # thin straight segments, of which a share is known exactly
    position, length = bent_line(3)
    surface = float(np.median(position[2])) + 0.01
    wet = waterline(3, surface, 1e-9)
    found = wet.wet(wet.heights(jnp.asarray(position)), jnp.asarray(length))
    xi = (np.arange(200_000) + 0.5) / 200_000
    expected = np.zeros(position.shape[1])
    for j, size in enumerate(length):
        z = position[2, j] + xi * (position[2, j + 1] - position[2, j])
        under = z < surface
        expected[j] += size * np.mean(under * (1.0 - xi))
        expected[j + 1] += size * np.mean(under * xi)
    assert 0.0 < np.sum(expected) < np.sum(length)
    np.testing.assert_allclose(found, expected, atol=2e-5)


def test_a_level_line_goes_under_over_its_diameter():
    wet = waterline(2, 0.0, 0.2)
    for z, share in [(0.11, 0.0), (0.05, 0.25), (0.0, 0.5), (-0.05, 0.75), (-0.11, 1.0)]:
        found = wet.wet(jnp.full(3, z), jnp.asarray([2.0]))
        np.testing.assert_allclose(found, np.array([1.0, 2.0, 1.0]) * share, rtol=1e-14)


def test_a_ball_floats_as_archimedes_has_it():
    # the cap of height h of a ball of radius R has the volume pi h^2 (3 R - h) / 3
    radius = 0.7
    volume = 4.0 / 3.0 * np.pi * radius**3
    ball = Ball.of(number(volume))
    lift = BodyLift(number(1000.0), ball, jnp.asarray([1.0]), number(0.0))
    for height in np.linspace(-1.2, 1.2, 13):
        h = np.clip(radius - height, 0.0, 2.0 * radius)
        cap = np.pi * h**2 * (3.0 * radius - h) / 3.0 / volume
        q = jnp.asarray([height])
        np.testing.assert_allclose(lift.wet(q), cap, atol=1e-14)
        np.testing.assert_allclose(lift.force(q), [1000.0 * cap], atol=1e-11)


def sampled(size, turn, height, count=60):
    """Depth (m) of a box and its share that is wet, from many small parts of it."""
    x = (np.arange(count) + 0.5) / count - 0.5
    grid = np.stack(np.meshgrid(*(x * side for side in size), indexing="ij"), axis=-1)
    z = height + grid @ turn[2]
    return np.mean(np.maximum(-z, 0.0)), np.mean(z < 0.0)


SIZE = np.array([4.0, 2.0, 1.0])


@pytest.mark.parametrize("angles", [(0, 0, 0), (0.2, 0.1, 0.5), (0.7, 0.4, 1.0), (1.5, -0.3, 0)])
def test_a_box_displaces_what_its_small_parts_do(angles):
    box, up = Box(jnp.asarray(SIZE)), jnp.asarray(UP[3])
    turn = np.asarray(rotation(jnp.asarray(angles, float)))
    for height in (-0.6, -0.2, 0.05, 0.4):
        depth, share = sampled(SIZE, turn, height)
        found = box.depth(number(height), jnp.asarray(angles, float), up)
        np.testing.assert_allclose(found, depth, atol=1e-4)
        slope = -jax.grad(box.depth)(number(height), jnp.asarray(angles, float), up)
        np.testing.assert_allclose(slope, share, atol=2e-2)


def wetted(height, angle, sides):
    """Area share, and middle (m, over the box's), of what is under water of a turned rectangle."""
    corners = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    corners = corners @ turn.T + [0.0, height]
    kept = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if a[1] < 0.0:
            kept.append(a)
        if a[1] * b[1] < 0.0:
            kept.append(a + (b - a) * a[1] / (a[1] - b[1]))
    if len(kept) < 3:
        return 0.0, 0.0
    (x, y), (x1, y1) = np.array(kept).T, np.roll(kept, -1, axis=0).T
    cross = x * y1 - x1 * y
    return 0.5 * np.sum(cross) / np.prod(sides), np.sum((x + x1) * cross) / (3.0 * np.sum(cross))


@pytest.mark.parametrize("size", [SIZE, np.array([10.0, 1.0, 1.0])])
def test_a_box_that_rolls_is_lifted_as_the_polygon_that_is_wet(size):
    box, up = Box(jnp.asarray(size)), jnp.asarray(UP[3])
    slopes = jax.jit(jax.grad(lambda h, a: box.depth(h, jnp.stack([a, 0 * a, 0 * a]), up), (0, 1)))
    for angle in np.radians([0.0, 5.0, 27.0, 43.5, 45.0, 60.0, 88.0, 90.0, 130.0]):
        for height in np.linspace(-0.5, 0.5, 11) * np.hypot(*size[1:]):
            share, arm = wetted(height, angle, size[1:])
            less, turns = slopes(number(height), number(angle))
            assert -less == pytest.approx(share, abs=1e-9)
            assert -turns == pytest.approx(share * arm, abs=1e-9)


@pytest.mark.parametrize(
    ("size", "angles"),
    [
        # two extents along the vertical, or three, are one; a last digit beside it they are not
        ([3.0, 1.0, 0.2], (0.06656816377582381, 0, 0)),
        ([10.0, 10.0, 0.01], (np.pi / 4, np.arcsin(1 / np.sqrt(3.0)), 0)),
        ([1.0, 1.0, 1.0], (np.pi / 4, np.arcsin(1 / np.sqrt(3.0)), 0)),
        ([1.0, 1.0, 1.0], (np.pi / 4, 0, 0)),
    ],
)
def test_its_second_derivatives_are_those_of_its_depth_where_extents_are_alike(size, angles):
    box, up = Box(jnp.asarray(size)), jnp.asarray(UP[3])
    at, h = jnp.asarray(angles, float), 2e-4

    def depth(angles):
        return box.depth(number(0.05), angles, up)

    steps = h * np.eye(3)
    around = jax.jit(jax.vmap(depth))
    by_values = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            a, b = steps[i], steps[j]
            both = np.array([at + a + b, at + a - b, at - a + b, at - a - b])
            one, two, three, four = around(jnp.asarray(both))
            by_values[i, j] = (one - two - three + four) / (4.0 * h**2)
    found = np.asarray(jax.jit(jax.hessian(depth))(at))
    np.testing.assert_allclose(found, by_values, atol=2e-3 * max(1.0, np.abs(by_values).max()))


@pytest.mark.parametrize("way", [0, 1])
def test_a_tilted_box_rights_itself_with_the_arm_of_naval_architecture(way):
    # wall-sided: GZ = sin(p) (GM + BM tan(p)^2 / 2), GM = KB + BM - KG, KG in its middle
    draught = 0.4
    weight = 1000.0 * draught / SIZE[2]  # of water 1000 N per volume of the box
    lift = BodyLift(number(1000.0), Box(jnp.asarray(SIZE)), jnp.asarray(UP[3]), number(0.0))
    angle = 0.05
    breadth = SIZE[1 - way]
    bm = breadth**2 / (12.0 * draught)
    gm = 0.5 * draught + bm - 0.5 * SIZE[2]
    arm = np.sin(angle) * (gm + 0.5 * bm * np.tan(angle) ** 2)
    q = np.zeros(6)
    q[3 + way] = angle
    # where it carries the weight: heave is found by bisection
    force = jax.jit(lambda q: lift.force(q))
    low, high = -1.0, 1.0
    for _ in range(60):
        q[2] = 0.5 * (low + high)
        if float(force(jnp.asarray(q))[2]) > weight:
            low = q[2]
        else:
            high = q[2]
    # upright its stiffness is the metacentric height's
    flat = jnp.asarray(q).at[3 + way].set(0.0)
    bent = jax.jit(jax.hessian(lambda q: lift.energy(q)))(flat.at[2].set(0.5 * SIZE[2] - draught))
    assert bent[3 + way, 3 + way] == pytest.approx(weight * gm, rel=1e-6)
    moment = np.asarray(force(jnp.asarray(q)))[3 + way]
    np.testing.assert_allclose(moment, -weight * arm, rtol=1e-9)


def test_forces_of_bodies_are_finite_in_any_place():
    lift = BodyLift(number(1000.0), Box(jnp.asarray(SIZE)), jnp.asarray(UP[3]), number(0.0))
    bent = jax.jit(jax.hessian(lambda q: lift.energy(q)))
    force = jax.jit(lambda q: lift.force(q))
    for height in (-9.0, -0.5, 0.0, 0.5, 9.0):
        for angles in [np.zeros(3), *np.random.default_rng(1).normal(size=(4, 3))]:
            q = jnp.asarray([1.0, 2.0, height, *angles])
            assert np.all(np.isfinite(force(q)))
            assert np.all(np.isfinite(bent(q)))
