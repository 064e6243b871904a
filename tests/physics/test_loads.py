"""Weight, water and bending stiffness of a line: numbers, conventions, and forces from energies."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import lumpedcable.study.compiled  # noqa: F401  (double precision)
from lumpedcable.model.line import node_lengths
from lumpedcable.physics.bending import Bending
from lumpedcable.physics.fluid import PowerLawCurrent, UniformCurrent
from lumpedcable.physics.load import Shape
from lumpedcable.physics.morison import AddedMass, Drag
from lumpedcable.physics.seabed import Seabed, SeabedDamping
from lumpedcable.physics.weight import Weight, buoyancy_per_length


def number(x):
    return jnp.asarray(x, jnp.float64)


def shape_of(position, length):
    """The geometry of nodes at `position` (d, n + 1) with unstretched lengths (n,)."""
    position = jnp.asarray(position)
    step = position[:, 1:] - position[:, :-1]
    size = jnp.sqrt(jnp.sum(step**2, axis=0))
    length = jnp.asarray(length)
    nodes = node_lengths(length, step.shape[1])
    return Shape(position, step / size, size / length - 1.0, size, length, nodes)


def bent_line(d=3, n=7):
    """A line that is far from straight, its segments of different lengths."""
    random = np.random.default_rng(7)
    length = 0.5 + random.random(n)
    step = random.normal(size=(d, n)) * 0.5
    step[0] += 1.0
    position = np.concatenate([np.zeros((d, 1)), np.cumsum(step, axis=1)], axis=1)
    return position, length


def loads(d):
    tangent = np.zeros(d)
    tangent[0] = 1.0
    up = np.zeros(d)
    up[-1] = 1.0
    return {
        "weight": Weight(jnp.asarray(-21.9 * up)),
        "bending": Bending(number(40.0)),
        "clamped bending": Bending(number(40.0), jnp.asarray(tangent), jnp.asarray(up)),
        "seabed": Seabed(jnp.asarray(up), number(0.1), number(3e4), number(0.05)),
    }


@pytest.mark.parametrize("name", loads(2))
@pytest.mark.parametrize("d", [2, 3])
def test_a_load_is_minus_the_slope_of_its_energy(name, d):
    load = loads(d)[name]
    position, length = bent_line(d)
    slope = jax.jit(jax.grad(lambda x: load.energy(shape_of(x, length))))(jnp.asarray(position))
    force = jax.jit(lambda x: load.force(shape_of(x, length)))(position)
    assert np.max(np.abs(force)) > 1.0
    np.testing.assert_allclose(force, -slope, rtol=1e-10, atol=1e-10 * np.max(np.abs(force)))


class TestWeight:
    def test_numbers_of_the_nylon_line(self):
        # Zhu, Yin & Shen 2018: 2.238 kg/m and 50 mm in sea water; they print 21.96 N/m dry, and
        # 21.96 - 19.743 = 2.217 N/m wet
        dry = 2.238 * 9.81
        lost = float(buoyancy_per_length(number(1025.0), number(9.81), number(0.05)))
        assert dry == pytest.approx(21.96, abs=0.01)
        assert lost == pytest.approx(1025.0 * 9.81 * np.pi * 0.025**2, rel=1e-14)
        assert 21.96 - lost == pytest.approx(2.217, abs=1e-3)

    def test_nodes_carry_the_weight_of_their_length(self):
        position, length = bent_line()
        force = np.asarray(loads(3)["weight"].force(shape_of(position, length)))
        np.testing.assert_allclose(force[2].sum(), -21.9 * length.sum(), rtol=1e-14)
        np.testing.assert_allclose(force[2, 0], -21.9 * length[0] / 2, rtol=1e-14)
        assert np.all(force[:2] == 0.0)


class TestBending:
    def test_shear_is_the_paper_s_for_a_gentle_arc(self):
        # Zhu, Yin & Shen 2018, eq. 3: M = EI tau x dtau/ds, shear dM/ds x tau, and minus its
        # difference acts on a node. For a curve y(x) of small slope dM/ds x tau is EI y''' across;
        # three meshes show the second order
        EI, errors = 12.0, []
        for n in (20, 40, 80):
            x = np.linspace(0.0, 2.0, n + 1)
            y = 1e-5 * np.sin(x)
            shape = shape_of(np.array([x, y]), np.diff(x))
            shear = np.asarray(Bending(number(EI)).shear(shape))[1]
            middle = 0.5 * (x[1:] + x[:-1])
            exact = -EI * 1e-5 * -np.cos(middle)
            errors.append(np.max(np.abs(shear - exact)[2:-2]) / (EI * 1e-5))
        assert errors[0] < 2e-3
        np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2.0, atol=0.1)

    def test_energy_of_an_arc(self):
        # half a circle of radius 3: EI / 2 kappa^2 over its length, to second order in the mesh;
        # a chain with free ends has no curvature in the outer half segments
        EI, radius, n = 7.0, 3.0, 400
        angle = np.linspace(0.0, np.pi, n + 1)
        place = radius * np.array([np.cos(angle), np.sin(angle)])
        length = np.full(n, np.pi * radius / n)
        energy = float(Bending(number(EI)).energy(shape_of(place, length)))
        assert energy == pytest.approx(EI / 2 / radius**2 * np.pi * radius * (1 - 1 / n), rel=1e-4)

    def test_a_straight_line_resists_nothing(self):
        place = np.array([[1.0], [2.0], [-1.0]]) * np.linspace(0.0, 4.0, 9)
        shape = shape_of(place, np.full(8, 1.0))
        assert np.max(np.abs(Bending(number(1e6)).force(shape))) < 1e-9

    @pytest.mark.parametrize("name", ["bending", "clamped bending"])
    def test_does_not_care_where_or_which_way(self, name):
        position, length = bent_line()
        turn, _ = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))
        load = loads(3)[name]
        other = load
        if load.start is not None:
            other = Bending(load.EI, jnp.asarray(turn @ load.start), jnp.asarray(turn @ load.end))
        moved = turn @ position + np.array([[3.0], [5.0], [7.0]])
        first = np.asarray(load.force(shape_of(position, length)))
        second = np.asarray(other.force(shape_of(moved, length)))
        np.testing.assert_allclose(second, turn @ first, atol=1e-11 * np.max(np.abs(first)))
        energies = [float(load.energy(shape_of(position, length))),
                    float(other.energy(shape_of(moved, length)))]  # fmt: skip
        assert energies[0] == pytest.approx(energies[1], rel=1e-12)

    def test_gives_no_momentum_and_no_spin(self):
        position, length = bent_line()
        force = np.asarray(loads(3)["bending"].force(shape_of(position, length)))
        size = np.max(np.abs(force))
        np.testing.assert_allclose(force.sum(axis=1), 0.0, atol=1e-12 * size)
        torque = np.cross(position.T, force.T).sum(axis=0)
        np.testing.assert_allclose(torque, 0.0, atol=1e-11 * size)


class TestSeabed:
    bed = Seabed(jnp.asarray([0.0, 1.0]), number(0.0), number(2e4), number(0.02))

    def place(self, *heights):
        return shape_of(
            np.array([np.arange(len(heights)) * 1.0, heights]), np.ones(len(heights) - 1)
        )

    def test_pushes_and_does_not_pull(self):
        force = np.asarray(self.bed.force(self.place(0.5, 0.0, -0.01, -0.1)))
        assert np.all(force[0] == 0.0)
        # nothing above; k l p^2 / 2 b in the blend, k l (p - b/2) below it; the end stands for half
        np.testing.assert_allclose(force[1, :3], [0.0, 0.0, 2e4 * 0.01**2 / 0.04], atol=1e-12)
        np.testing.assert_allclose(force[1, 3], 0.5 * 2e4 * (0.1 - 0.01), rtol=1e-14)

    def test_damping_resists_where_there_is_contact_and_never_pulls(self):
        damping = SeabedDamping(self.bed, number(300.0))
        shape = self.place(0.5, -0.1, -0.1)
        sinking = damping.force(shape, jnp.asarray([[9.0] * 3, [-2.0] * 3]))
        np.testing.assert_allclose(sinking[1], [0.0, 600.0, 300.0], rtol=1e-14)
        np.testing.assert_allclose(sinking[0], 0.0)
        rising = damping.force(shape, jnp.asarray([[9.0] * 3, [1e3] * 3]))
        np.testing.assert_allclose(rising + self.bed.force(shape), 0.0, atol=1e-9)


class TestWater:
    @pytest.mark.parametrize(
        ("convention", "area"), [("textbook", np.pi), ("half", np.pi / 2), ("projected", 1.0)]
    )
    def test_drag_conventions(self, convention, area):
        # 1/2 rho d Cn across; along, the coefficient acts on pi d, pi d / 2 or d per metre
        drag = Drag(number(1025.0), number(0.05), number(1.5), number(0.01), convention)
        assert float(drag.normal) == pytest.approx(0.5 * 1025.0 * 0.05 * 1.5, rel=1e-14)
        assert float(drag.tangential) == pytest.approx(0.5 * 1025.0 * 0.05 * area * 0.01, rel=1e-14)

    def test_added_mass_of_a_cylinder(self):
        # Ca rho pi d^2 / 4: 2.0126 kg/m for the nylon line with Ca = 1
        added = AddedMass(number(1025.0), number(0.05), number(1.0), None)
        assert float(added.normal) == pytest.approx(2.01258, rel=1e-5)
        assert added.tangential is None
        both = AddedMass(number(1025.0), number(0.05), number(2.0), number(0.1))
        assert float(both.tangential) == pytest.approx(0.05 * float(both.normal), rel=1e-14)

    def test_uniform_current(self):
        flow = UniformCurrent(jnp.asarray([1.0, -2.0])).velocity(jnp.asarray([5.0, -300.0, 0.0]))
        np.testing.assert_array_equal(flow, [[1.0] * 3, [-2.0] * 3])

    def test_power_law_current(self):
        # Liu et al. 2018, eq. 38: V ((z - bed) / D)^n; full speed at the surface and above it
        current = PowerLawCurrent(jnp.asarray([2.0, 0.0]), number(1 / 7), number(30.0), number(5.0))
        z = np.array([-40.0, -25.0, -10.0, 5.0, 50.0])
        flow = current.velocity(jnp.asarray(z))
        expected = [0.0, 0.0, 2.0 * 0.5 ** (1 / 7), 2.0, 2.0]
        np.testing.assert_allclose(flow[0], expected, rtol=1e-14)
        np.testing.assert_array_equal(flow[1], 0.0)

    def test_power_law_current_has_finite_slopes_at_the_bed_and_below(self):
        current = PowerLawCurrent(jnp.asarray([2.0]), number(1 / 7), number(30.0), number(0.0))
        for z in (-50.0, -30.0 - 1e-9, -10.0, 0.0, 10.0):
            slope = jax.jacfwd(current.velocity)(jnp.asarray([z]))
            assert np.all(np.isfinite(slope))
