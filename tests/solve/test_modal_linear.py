"""What modes are made of: masses, the symmetry of stiffness, joints, current, faults."""

import good_scenes
import jax
import numpy as np
import pytest
from engine_runs import scene_of, study_of
from modal_runs import STRING, model_at, modes_at, modes_of, straight
from scipy.linalg import block_diag, eig

from lumpedcable.model import inertia
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.net import make_net
from lumpedcable.scene import SceneError
from lumpedcable.solve.modal import natural_modes
from lumpedcable.study.compiled import linearise
from lumpedcable.study.modes import NoEquilibriumError

# two lines in water that hold a sphere, everything at once
BRIDLE = """
gravity = 9.81
dimensions = 3

[water]
density = 1025

[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.left]
material = "hooke"
length = "10 m"
segments = 7
mass = "2 kg/m"
diameter = "30 mm"
drag = { normal = 1.2, tangential = 0.01 }
added_mass = { normal = 1.0, tangential = 0.1 }
bending = { EI = "20 N m2" }
start = { fixed = [0, 0, 0] }
end = "bob"

[lines.right]
material = "hooke"
length = "12 m"
segments = 9
grading = 2.0
mass = "2 kg/m"
diameter = "20 mm"
drag = { normal = 1.2, tangential = 0.01 }
start = "bob"
end = { fixed = [12, 3, 1] }

[bodies.bob]
mass = "50 kg"

[output]
duration = 1
every = 1
"""
# a line that trails in a current, its weight in water 20 N/m
TRAILING = """
gravity = 9.81
dimensions = 3

[water]
density = 1025
current = { velocity = ["0.5 m/s", 0, 0] }

[materials.hooke]
law = "linear"
EA = "1 MN"

[lines.rope]
material = "hooke"
length = "20 m"
segments = 20
mass = "2.844 kg/m"
diameter = "30 mm"
drag = { normal = 1.2, tangential = 0.01 }
start = { fixed = [0, 0, 0] }
end = "free"

[output]
duration = 1
every = 1
"""


def anywhere(scene, seed=3):
    """Places near a triangle, out of balance: stiffness and masses do not ask."""
    rng = np.random.default_rng(seed)
    corners = np.array([[0.0, 0, 0], [5.0, 1, -8], [12.0, 3, 1]])
    places = {}
    for name, a, b in (("left", 0, 1), ("right", 1, 2)):
        n = scene.lines[name].segments
        s = np.linspace(0.0, 1.0, n + 1)[:, None]
        places[name] = corners[a] + s * (corners[b] - corners[a])
        places[name][1:-1] += 0.1 * rng.standard_normal((n - 1, 3))
    return places


def full(linear, net, d):
    """Stiffness (N/m) and mass (kg) of the free unknowns as whole matrices."""
    lower, diagonal, upper = (np.asarray(part) for part in linear.stiffness)
    m, b, _ = diagonal.shape
    stiffness = np.zeros((m * b, m * b))
    for i in range(m):
        here = slice(i * b, (i + 1) * b)
        stiffness[here, here] = diagonal[i]
        if i > 0:
            stiffness[here, (i - 1) * b : i * b] = lower[i]
        if i + 1 < m:
            stiffness[here, (i + 1) * b : (i + 2) * b] = upper[i]
    free = np.ix_(*2 * [np.repeat(~net.fixed, d)])
    return stiffness[free], block_diag(*np.asarray(linear.mass))[free]


@jax.jit
def kinetic_energy(line, velocity):
    nodes = inertia.frame(line, line.shape(), None)
    return inertia.kinetic_energy(nodes, velocity)


def test_the_mass_matrix_gives_the_kinetic_energy(tmp_path):
    scene = scene_of(tmp_path, BRIDLE)
    model, _, _ = model_at(scene, anywhere(scene))
    net, linear = make_net(model), linearise(model)
    velocity = np.random.default_rng(4).standard_normal((net.size, 3))
    energy = 0.5 * np.einsum("pi,pij,pj->", velocity, linear.mass, velocity)
    known = 0.0
    for name, line in model.lines.items():
        known += float(kinetic_energy(line, velocity[net.index[name]].T))
    bob = velocity[net.index["left"][-1]]
    known += 0.5 * 50.0 * bob @ bob
    assert energy == pytest.approx(known, rel=1e-12)


def test_stiffness_without_current_is_symmetric_and_modes_diagonalise_it(tmp_path):
    scene = scene_of(tmp_path, BRIDLE)
    model, layout, coordinates = model_at(scene, anywhere(scene))
    net, linear = make_net(model), linearise(model)
    found = natural_modes(linear, net, layout, coordinates, 100)
    assert found.asymmetry < 1e-15
    assert found.unknowns == len(found.square) == 3 * (6 + 8 + 1)
    assert found.axial + found.transverse + found.bodies == pytest.approx(1.0)
    stiffness, mass = full(linear, net, 3)
    every = np.sort(eig(stiffness, mass)[0].real)
    assert found.square == pytest.approx(every, rel=1e-9, abs=1e-9 * every[-1])
    # the shapes, line by line, are those vectors: phi . K phi = omega^2 phi . M phi
    motion = np.zeros((45, net.size, 3))
    for name, places in net.index.items():
        motion[:, places] = found.shapes[name] @ found.axes
    motion = motion.reshape(45, -1)[:, np.repeat(~net.fixed, 3)]
    assert np.diag(motion @ mass @ motion.T) == pytest.approx(found.mass, rel=1e-10)
    form = motion @ stiffness @ motion.T / np.sqrt(np.outer(found.mass, found.mass))
    assert form == pytest.approx(np.diag(found.square), abs=1e-9 * every[-1])


def test_a_line_that_will_be_cut_is_whole_until_then(tmp_path):
    whole = modes_at(tmp_path, f"dimensions = 2\n{STRING}", straight(105.0, 32))
    cut = f"dimensions = 2\n{STRING}[events.cut]\nbreaks = 'rope@25 m'\ntime = 0\n"
    nodes = straight(105.0, 32)
    found = modes_at(tmp_path, cut, {"rope-1": nodes[:9], "rope-2": nodes[8:]})
    assert found.square == pytest.approx(whole.square, rel=1e-10)
    assert found.shapes["rope"] == pytest.approx(whole.shapes["rope"], abs=1e-9)
    assert found.nodes["rope"] == pytest.approx(nodes, abs=1e-12)


@pytest.mark.slow
def test_drag_of_a_current_counts(tmp_path):
    study = study_of(tmp_path, TRAILING)
    found = modes_of(tmp_path, TRAILING, count=6)
    assert found.asymmetry > 1e-9
    scene = study.runs[0]
    coordinates = coordinates_of([scene])
    places = {"rope": found.nodes["rope"]}
    model, _, _ = model_at(scene, places)
    stiffness, mass = full(linearise(model), make_net(model), coordinates.dimensions)
    every = eig(stiffness, mass)[0]
    exact = np.sort(every.real)
    # of all modes of the symmetric part they are exact, of 36 as good as they say of themselves
    whole = modes_of(tmp_path, TRAILING, count=60)
    assert whole.square == pytest.approx(exact, rel=1e-8)
    assert not whole.doubt.any()
    # but for what stiff modes along the line, which are none of the 36, would give
    assert found.square == pytest.approx(exact[:6], rel=1e-5)
    assert 0.0 < found.doubt.max() < 1e-5
    assert not found.unstable.any()
    # without the antisymmetric part they are others
    even = eig(0.5 * (stiffness + stiffness.T), mass)[0]
    assert np.abs(np.sort(even.real)[:6] / found.square - 1.0).max() > 1e-6


def test_the_engines_own_equilibrium_hangs_like_a_chain(tmp_path):
    # without the current: the chain of the Bessel function, in the water's weight and added mass
    from lumpedcable import exact

    still = TRAILING.replace('current = { velocity = ["0.5 m/s", 0, 0] }', "")
    found = modes_of(tmp_path, still, "rope.added_mass={normal=1}", count=4)
    added = 1025 * np.pi * 0.03**2 / 4
    gravity = 9.81 * (2.844 - added) / (2.844 + added)
    known = exact.hanging_chain_frequencies(20.0, 2, gravity)
    assert found.frequency == pytest.approx(np.repeat(known, 2), rel=0.01)
    assert found.asymmetry < 1e-15
    # of two equal modes one is along x and one along y
    motion = np.sum(found.shapes["rope"] ** 2, axis=1)
    assert np.argmax(motion, axis=1).tolist() == [0, 1, 0, 1]


# --- dimensions ----------------------------------------------------------------------------------


def test_a_line_has_the_dimensions_that_it_is_given(tmp_path):
    found = {
        count: coordinates_of([scene_of(tmp_path, STRING, f"dimensions={count}")]).axes
        for count in (1, 2, 3)
    }
    assert found[1].tolist() == np.eye(3)[:, :1].tolist()
    assert found[2].tolist() == np.eye(3)[:, :2].tolist()
    assert found[3].tolist() == np.eye(3).tolist()
    absent = scene_of(tmp_path, STRING)
    assert coordinates_of([absent]).dimensions == 1
    assert scene_of(tmp_path, STRING, "dimensions=1").skeleton() != absent.skeleton()
    assert "dimensions" not in absent.numbers()


def test_scenes_aslant_and_together(tmp_path):
    aslant = scene_of(tmp_path, STRING, "end.fixed=[63, 84, 0]", "dimensions=3")
    axes = coordinates_of([aslant]).axes
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-14)
    alone = scene_of(tmp_path, STRING)
    assert coordinates_of([alone, aslant]).dimensions == 3
    upright = scene_of(tmp_path, f"gravity = 9.81\n{STRING}", "dimensions=3")
    assert coordinates_of([upright]).axes.tolist() == np.eye(3).tolist()


@pytest.mark.parametrize(
    ("text", "found", "needed"),
    [
        (f"gravity = 9.81\n{STRING}", 1, 2),
        (TRAILING, 1, 2),
        (BRIDLE.replace('"50 kg"', '"50 kg"\nposition = [5, 9, -8]'), 2, 3),
    ],
)
def test_too_few_dimensions_are_refused(tmp_path, text, found, needed):
    scene = scene_of(tmp_path, text, f"dimensions={found}")
    with pytest.raises(ValueError, match=f"expected at least {needed}, .*found {found}$"):
        coordinates_of([scene])


@pytest.mark.parametrize("wrong", ["0", "4", "2.5", "true", "two"])
def test_dimensions_are_one_two_or_three(tmp_path, wrong):
    with pytest.raises(SceneError, match="dimensions: expected a whole number from 1 to 3, found"):
        study_of(tmp_path, STRING, f"dimensions={wrong}")


# --- faults --------------------------------------------------------------------------------------


def test_where_nothing_can_move_there_are_no_modes(tmp_path):
    with pytest.raises(SceneError, match=r"lines: nothing can move: every node is held"):
        modes_of(tmp_path, STRING, "segments=1")


def test_what_falls_has_no_equilibrium(tmp_path):
    text = good_scenes.ROPE.replace("start = { fixed = [0, 0, 0] }", 'start = "free"')
    with pytest.raises(
        NoEquilibriumError, match=r"no static equilibrium .* check that something holds each line"
    ):
        modes_of(tmp_path, text, "segments=4")


def test_a_line_too_short_for_its_breaks_is_a_fault_of_the_scene(tmp_path):
    text = f"{STRING}[events.cut]\nbreaks = 'rope@25 m'\ntime = 0\n"
    with pytest.raises(SceneError, match=r"scene.toml:\d+: lines: .*too few segments"):
        modes_of(tmp_path, text, "segments=1")
