"""Static equilibria from no guess: slack, taut, heavy, light, stiff, joined, swept by a current."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, fixed, line_text, nodes_in_space, order_of, scene_of

from lumpedcable.exact import elastic_catenary, hanging_nodes, linear_strain
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve.end_forces import tension_at
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE


def text(length, end, *, EA=1e7, segments=40, mass=10.0, gravity=9.81, start=None, more="", top=""):
    head = "" if gravity is None else f"gravity = {gravity}\n"
    head += f'{top}\n[materials.wire]\nlaw = "linear"\nEA = {EA}\n'
    line = line_text("rope", "wire", length, segments, mass, start or fixed(0, 0, 0), end, more)
    return head + line + '\n[output]\nduration = "1 s"\nevery = "1 s"\n'


def tensions(found, name="rope"):
    return np.asarray(tensions_of(found.model.lines[name]))


@jax.jit
def tensions_of(line):
    return line.law.tension(line.reference_strain)


CATENARIES = {
    # span, rise, length, EA, mass
    "taut": (101.0, 0.0, 100.0, 1e7, 10.0),
    "slack": (100.0, 20.0, 120.0, 1e7, 10.0),
    "slack and stiff": (100.0, 20.0, 120.0, 1e9, 10.0),
    "three times its span": (100.0, 0.0, 300.0, 1e7, 10.0),
    "steep": (10.0, 90.0, 100.0, 1e7, 10.0),
    "soft": (50.0, 0.0, 100.0, 2e4, 10.0),
    "nearly weightless": (100.0, 20.0, 120.0, 1e7, 1e-3),
}


@pytest.mark.parametrize("case", CATENARIES)
def test_elastic_catenaries(tmp_path, case):
    span, rise, length, EA, mass = CATENARIES[case]
    exact = elastic_catenary(span, rise, length, EA, mass * 9.81)
    errors = []
    # the steep line turns within 2 m at its foot: 20 segments would not see that
    for n in (40, 160):
        scene = scene_of(tmp_path, text(length, fixed(span, 0, rise), EA=EA, mass=mass, segments=n))
        found, coordinates = equilibrium_of(scene)
        assert bool(found.converged)
        at = exact.position(np.linspace(0.0, length, n + 1))
        nodes = nodes_in_space(found, coordinates)
        miss = np.hypot(nodes[0] - at[0], nodes[2] - at[1])
        middle = exact.tension((np.arange(n) + 0.5) * length / n)
        wrong = np.abs(tensions(found) / middle - 1.0)
        errors.append((np.max(miss) / length, np.max(wrong)))
    places, forces = np.array(errors).T
    assert places[-1] < 5e-4
    # lumps on a curve: second order (the taut line is straight to rounding of its sag already)
    orders = order_of(places, 4)
    assert np.all((orders > 1.8) & (orders < 2.2))
    assert forces[-1] < 0.25 * forces[0]


def test_a_line_in_space_hangs_in_its_plane(tmp_path):
    flat, _ = equilibrium_of(scene_of(tmp_path, text(120, fixed(100, 0, 20))))
    turned, coordinates = equilibrium_of(scene_of(tmp_path, text(120, fixed(60, 80, 20))))
    assert coordinates.dimensions == 2
    np.testing.assert_allclose(tensions(turned), tensions(flat), rtol=1e-9)


def test_a_chain_of_lumps_from_a_force(tmp_path):
    # exact for the lumped chain itself: tensions are sums of loads
    pull = "{ held = { pretension = 2000, direction = [3, 0, 4] } }"
    found, coordinates = equilibrium_of(scene_of(tmp_path, text(100, pull)))
    loads = np.zeros((41, 3))
    loads[:, 2] = -10.0 * 9.81 * 2.5
    loads[[0, -1]] *= 0.5
    exact = hanging_nodes(
        np.zeros(3), np.full(40, 2.5), loads, np.array([1200.0, 0.0, 1600.0]), linear_strain(1e7)
    )
    assert bool(found.converged)
    np.testing.assert_allclose(nodes_in_space(found, coordinates), exact.positions.T, atol=1e-9)
    np.testing.assert_allclose(tensions(found), exact.tension, rtol=1e-9)


def test_held_at_its_start_instead(tmp_path):
    pull = "{ held = { pretension = 2000, direction = [3, 0, 4] } }"
    one, c = equilibrium_of(scene_of(tmp_path, text(100, pull)))
    other, d = equilibrium_of(scene_of(tmp_path, text(100, fixed(0, 0, 0), start=pull)))
    np.testing.assert_allclose(nodes_in_space(other, d)[:, ::-1], nodes_in_space(one, c), atol=1e-9)


def test_a_line_lighter_than_water_rises(tmp_path):
    water = '[water]\ndensity = "1025 kg/m3"'
    scene = text(100, '"free"', mass=1.0, more="diameter = 0.05", top=water)
    found, coordinates = equilibrium_of(scene_of(tmp_path, scene))
    lift = (1025 * np.pi * 0.05**2 / 4 - 1.0) * 9.81
    assert nodes_in_space(found, coordinates)[2, -1] > 100.0
    # the top segment carries half a node, the bottom one all but half a node
    np.testing.assert_allclose(tensions(found)[[0, -1]], lift * 100 * np.array([79, 1]) / 80)


def test_a_body_between_two_lines(tmp_path):
    # a weight on two nearly weightless, nearly rigid lines: a triangle of known sides
    scene = text(80, '"bob"', EA=1e11, mass=1e-6, segments=4)
    scene += line_text("stay", "wire", 60, 4, 1e-6, fixed(100, 0, 0), '"bob"')
    scene += "[bodies.bob]\nmass = 1000\n"
    found, coordinates = equilibrium_of(scene_of(tmp_path, scene))
    assert bool(found.converged)
    # 60-80-100: a right angle at the bob, 48 m below, 64 m along
    bob = nodes_in_space(found, coordinates)[:, -1]
    np.testing.assert_allclose(bob, [64.0, 0.0, -48.0], atol=1e-3)
    np.testing.assert_allclose(tensions(found)[0], 9810 * 0.6, rtol=1e-4)
    np.testing.assert_allclose(tensions(found, "stay")[0], 9810 * 0.8, rtol=1e-4)


def test_two_halves_joined_are_the_whole(tmp_path):
    whole, c = equilibrium_of(scene_of(tmp_path, text(120, fixed(100, 0, 20))))
    half = text(60, '"far.start"', segments=20)
    half += line_text("far", "wire", 60, 20, 10, '"free"', fixed(100, 0, 20))
    found, d = equilibrium_of(scene_of(tmp_path, half))
    assert bool(found.converged)
    both = np.concatenate(
        [nodes_in_space(found, d), nodes_in_space(found, d, "far")[:, 1:]], axis=1
    )
    np.testing.assert_allclose(both, nodes_in_space(whole, c), atol=1e-7)


def test_a_current_bows_a_light_line_sideways(tmp_path):
    # no weight, a uniform current across: the drag is across the line, and a shallow bow of load q
    # over a span L and a pull T sags q L^2 / (8 T)
    water = "[water]\ndensity = 1025\ncurrent = { velocity = [0, 0.2, 0] }"
    more = "diameter = 0.02\ndrag = { normal = 1.2, tangential = 0.0 }"
    scene = text(100, fixed(100.5, 0, 0), EA=1e6, gravity=None, top=water, more=more)
    found, coordinates = equilibrium_of(scene_of(tmp_path, scene))
    assert bool(found.converged)
    q = 0.5 * 1025 * 0.02 * 1.2 * 0.2**2
    pull = tensions(found).mean()
    sag = nodes_in_space(found, coordinates)[1, 20]
    assert pull == pytest.approx(1e6 * 0.005, rel=1e-3)
    assert sag == pytest.approx(q * 100.5**2 / (8 * pull), rel=5e-3)


@pytest.mark.slow
def test_a_swept_cable_carries_its_weight_at_the_end(tmp_path):
    # a weight without drag at the end of a cable in a current: there the cable carries that alone
    water = "[water]\ndensity = 1025\ncurrent = { velocity = [1, 0, 0] }"
    more = "diameter = 0.03\ndrag = { normal = 1.2, tangential = 0.02 }"
    misses = []
    for n in (20, 80):
        scene = text(100, '"bob"', mass=2.0, segments=n, top=water, more=more)
        scene = scene_of(tmp_path, scene + "[bodies.bob]\nmass = 50\n")
        found, _ = equilibrium_of(scene)
        assert bool(found.converged)
        end = jax.jit(lambda model: tension_at(model.lines["rope"], -1, model))(found.model)
        misses.append(abs(float(end) / (50.0 * 9.81) - 1.0))
    orders = order_of(misses, 4)
    assert misses[-1] < 1e-3
    assert np.all((orders > 1.8) & (orders < 2.2))


@pytest.mark.parametrize(
    "scene",
    [
        text(100, "{ held = { pretension = 10, direction = [1, 0, 0] } }",
             start="{ held = { pretension = 10, direction = [-1, 0, 0] } }"),
        text(100, '"free"', start='"free"'),
    ],
    ids=["weight that nothing carries", "a falling line"],
)  # fmt: skip
def test_no_equilibrium_is_said(tmp_path, scene):
    found, _ = equilibrium_of(scene_of(tmp_path, scene))
    assert not bool(found.converged)


@pytest.mark.slow
@pytest.mark.parametrize("bending", [False, True])
def test_derivatives_of_an_equilibrium(tmp_path, bending):
    # the implicit function theorem against central differences
    changes = {
        "lines.rope.length": 1e-4, "materials.wire.EA": 1e4, "gravity": 1e-4,
        "lines.rope.mass": 1e-4, "lines.rope.end.fixed.0": 1e-4,
    }  # fmt: skip
    more = "bending = { EI = 5000 }" if bending else ""
    scene = scene_of(tmp_path, text(120, fixed(100, 0, 20), segments=12, more=more))
    layout, coordinates = make_layout(scene), coordinates_of([scene])
    base = scene.numbers()

    def pull(values):
        found = start_of(scene.with_numbers({**base, **values}), layout, coordinates)
        line = found.model.lines["rope"]
        return line.law.tension(line.reference_strain)[-1]

    at = {key: jnp.asarray(base[key]) for key in changes}
    value = jax.jit(pull, compiler_options=RUN_ONCE)
    slopes = jax.jit(jax.jacfwd(pull), compiler_options=RUN_ONCE)(at)
    for key, change in changes.items():
        up, down = (value({**at, key: at[key] + sign * change}) for sign in (1.0, -1.0))
        difference = float((up - down) / (2.0 * change))
        assert float(slopes[key]) == pytest.approx(difference, rel=2e-6), key


HELD = "{{ held = {{ pretension = {}, direction = {} }} }}"
PULLS = {
    # what is at the far end, gravity
    "pulled straight": (HELD.format(45e3, "[1, 0, 0]"), None),
    "pulled aside": (HELD.format(4e3, "[3, 1, 4]"), 9.81),
    "hanging": ('"free"', 9.81),
}


@pytest.mark.parametrize(
    ("case", "mirrored"),
    [
        pytest.param("pulled straight", False, marks=pytest.mark.slow),
        pytest.param("pulled aside", False, marks=pytest.mark.slow),
        ("pulled aside", True),
        ("hanging", True),
        pytest.param("pulled straight", True, marks=pytest.mark.slow),
        pytest.param("hanging", False, marks=pytest.mark.slow),
    ],
)
def test_two_lines_in_a_row_from_one_held_end(tmp_path, case, mirrored):
    # exact for the chain of lumps: the tension of a segment is the sum of the loads beyond it
    pull, gravity = PULLS[case]
    anchor = fixed(0, 0, 0)
    ends = {"rope": (anchor, '"far.start"'), "far": ('"rope.end"', pull)}
    if mirrored:
        ends = {"rope": ('"far.end"', anchor), "far": (pull, '"rope.start"')}
    scene = text(30, ends["rope"][1], EA=1.2e6, segments=12, gravity=gravity, start=ends["rope"][0])
    scene += line_text("far", "wire", 30, 12, 10, *ends["far"])
    found, c = equilibrium_of(scene_of(tmp_path, scene))
    assert bool(found.converged)
    loads = np.zeros((25, 3))
    loads[:, 2] = -10.0 * (gravity or 0.0) * 2.5
    loads[[0, -1]] *= 0.5
    force = {
        "pulled straight": np.array([45e3, 0.0, 0.0]),
        "pulled aside": 4e3 * np.array([3.0, 1.0, 4.0]) / np.sqrt(26.0),
        "hanging": np.zeros(3),
    }[case]
    exact = hanging_nodes(np.zeros(3), np.full(24, 2.5), loads, force, linear_strain(1.2e6))
    nodes = [nodes_in_space(found, c, name) for name in ("rope", "far")]
    nodes = [part[:, ::-1] for part in nodes] if mirrored else nodes
    both = np.concatenate([nodes[0], nodes[1][:, 1:]], axis=1)
    np.testing.assert_allclose(both, exact.positions.T, atol=1e-6)
