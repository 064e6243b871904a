"""What physics may not depend on: where, which way round, in which frame, and in how many dimensions."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import NYLON, equilibrium_of, run_text, scene_of

from lumpedcable.model.forces import evaluate
from lumpedcable.model.line import placed
from lumpedcable.model.motion import acceleration, kick

SCENE = """
gravity = "9.81 m/s2"
[water]
density = "1025 kg/m3"
{current}
{nylon}
[lines.rope]
material = "nylon"
length = "60 m"
segments = 30
mass = "2.238 kg/m"
diameter = "50 mm"
drag = {{ normal = 1.5, tangential = 0.01 }}
added_mass = {{ normal = 1.0 }}
start = {{ fixed = {start} }}
end = {{ held = {{ pretension = "90 kN", direction = {direction} }} }}
[events.break]
breaks = "rope.end"
time = "5 ms"
[output]
duration = "40 ms"
every = "2 ms"
"""


def scene(start=(0, 0, 0), direction=(1, 0, 0), current=None, nylon=NYLON):
    flow = "" if current is None else f"current = {{ velocity = {list(map(float, current))} }}"
    return SCENE.format(
        start=list(map(float, start)),
        direction=list(map(float, direction)),
        current=flow,
        nylon=nylon,
    )


def turned(angle):
    """Rotation by an angle (rad) about the vertical."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def close(a, b, size=1.0):
    """Largest difference relative to a size."""
    return np.max(np.abs(a - b)) / size


@pytest.fixture(scope="module")
def level(tmp_path_factory):
    return run_text(tmp_path_factory.mktemp("level"), scene())


def test_translation(tmp_path, level):
    shift = np.array([300.0, -200.0, 40.0])
    moved = run_text(tmp_path, scene(start=shift))
    assert close(moved["position"] - shift, level["position"]) < 1e-9
    assert close(moved["tension"], level["tension"], 90e3) < 1e-9


@pytest.mark.parametrize("angle", [0.5 * np.pi, 0.7, np.pi])
def test_rotation_about_the_vertical(tmp_path, level, angle):
    rotation = turned(angle)
    ran = run_text(tmp_path, scene(direction=rotation @ [1.0, 0.0, 0.0]))
    # oblique or not, it is a vertical plane: two dimensions
    assert ran.attributes["coordinates"] == 2
    assert close(ran["position"], level["position"] @ rotation.T) < 1e-8
    assert close(ran["tension"], level["tension"], 90e3) < 1e-9


@pytest.mark.slow
def test_rotation_of_a_straight_line_in_space(tmp_path):
    # without weight a line is one-dimensional whichever way it points
    bare = scene().replace('gravity = "9.81 m/s2"', "")
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    one = run_text(tmp_path, bare)
    other = run_text(
        tmp_path, bare.replace("direction = [1.0, 0.0, 0.0]", f"direction = {axis.tolist()}")
    )
    assert one.attributes["coordinates"] == other.attributes["coordinates"] == 1
    assert close(other["position"], one["position"][..., :1] * axis) < 1e-9
    assert close(other["velocity"], one["velocity"][..., :1] * axis, 50.0) < 1e-9


def test_mirror(tmp_path, level):
    ran = run_text(tmp_path, scene(direction=(-1, 0, 0)))
    assert close(ran["position"] * [-1.0, 1.0, 1.0], level["position"]) < 1e-9


@pytest.mark.slow
def test_the_line_told_from_its_other_end(tmp_path, level):
    text = (
        scene()
        .replace("start = {", "@ = {")
        .replace("end = {", "start = {")
        .replace("@ =", "end =")
    )
    ran = run_text(tmp_path, text.replace('breaks = "rope.end"', 'breaks = "rope.start"'))
    assert close(ran["position"][:, :, ::-1], level["position"]) < 1e-8
    # sums are taken in the other order; the limiter's branches make a little more of that rounding
    assert close(ran["tension"][:, :, ::-1], level["tension"], 90e3) < 1e-8


def test_a_plane_computed_in_space(tmp_path, level):
    space = run_text(tmp_path, "dimensions = 3\n" + scene())
    assert level.attributes["coordinates"] == 2
    assert space.attributes["coordinates"] == 3
    assert close(space["position"], level["position"]) < 1e-8
    assert close(space["tension"], level["tension"], 90e3) < 1e-8


@pytest.mark.parametrize("dt", [pytest.param(None, marks=pytest.mark.slow), 2e-4])
@pytest.mark.slow
def test_galilean_invariance(tmp_path, dt):
    # seen from a frame that moves at -V, line and water both move at V faster: same accelerations
    still = scene_of(tmp_path, scene(current=(0.5, 0.3, 0)))
    boost = np.array([1.0, -2.0, 0.0])
    moving = scene_of(tmp_path, scene(current=(1.5, -1.7, 0)))
    gains = []
    for one, shift in ((still, 0.0 * boost), (moving, boost)):
        found, coordinates = equilibrium_of(one)
        line = found.model.lines["rope"]
        # the same shape and velocities for both, far from rest
        rng = np.random.default_rng(1)
        place = np.asarray(coordinates.axes).T @ (0.05 * rng.normal(size=(3, 31)))
        speed = np.asarray(coordinates.axes).T @ (rng.normal(size=(3, 31)) + shift[:, None])
        model = eqx.tree_at(
            lambda m: m.lines["rope"], found.model, placed(line, gains_reference(gains, line))
        )
        place, speed = {"rope": jnp.asarray(place)}, {"rope": jnp.asarray(speed)}
        t = jnp.asarray(0.1)
        if dt is None:
            gain, _ = acceleration(model, t, place, speed, {})
        else:
            after = kick(model, t, place, speed, {}, jnp.asarray(dt)).after
            gain = {"rope": (after["rope"] - speed["rope"]) / dt}
        gains.append((line.reference, np.asarray(gain["rope"])[:, 1:]))
    first, second = gains[0][1], gains[1][1]
    assert np.max(np.abs(first)) > 100.0
    assert close(second, first, np.max(np.abs(first))) < 1e-10


def gains_reference(gains, line):
    """The reference shape of the first frame for both: a current would bend the second otherwise."""
    return gains[0][0] if gains else line.reference


def test_momentum_is_what_the_ends_give(tmp_path):
    # without fluid, the sum of mass times acceleration is weight plus the forces at the two ends
    dry = scene().replace('[water]\ndensity = "1025 kg/m3"', "")
    dry = dry.replace("drag = {", "# drag = {").replace("added_mass = {", "# added_mass = {")
    found, _ = equilibrium_of(scene_of(tmp_path, dry))
    model = found.model
    line = model.lines["rope"]
    rng = np.random.default_rng(2)
    place = {"rope": jnp.asarray(0.05 * rng.normal(size=(2, 31)))}
    speed = {"rope": jnp.asarray(rng.normal(size=(2, 31)))}
    e = evaluate(model, jnp.asarray(-1.0), place, speed, {})["rope"]
    weight = 2.238 * 60.0 * 9.81 * np.array([0.0, -1.0])
    pull = np.array([90e3, 0.0])
    # inner forces come in pairs: tension, correction and viscosity give no momentum
    assert np.allclose(np.sum(e.force, axis=1), weight + pull, rtol=0.0, atol=1e-6 * 90e3)
    assert np.isclose(np.sum(e.nodes.mass_t), 2.238 * 60.0, rtol=1e-12)
    assert line.segments == 30
