"""Statics of lines that are alike: at rest as each alone, from a program hardly longer."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, fixed, length_of, line_text, scene_of

from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.model.line import alike, done_alike
from lumpedcable.model.net import make_net
from lumpedcable.solve.start import start_of
from lumpedcable.solve.statics import forces_at_rest

SURROUNDINGS = """
gravity = 9.81
[water]
density = 1025
[seabed]
height = -12
stiffness = "10 kPa"
[materials.wire]
law = "linear"
EA = "1 MN"
[output]
duration = "1 s"
every = "1 s"
"""
CURRENT = "current = { velocity = [0.5, 0.3, 0] }\n"
BUOY = "[bodies.buoy]\nmass = 3\nposition = [20, 2, -3]\n"
NAMES = ("a", "b", "long", "c", "tied-1", "tied-2")


def lines(folder, *names, current=False):
    """A scene of some of them: the tied ones end at a buoy, the long one has more segments."""
    text = SURROUNDINGS.replace("density = 1025\n", f"density = 1025\n{CURRENT * current}")
    for k, name in enumerate(NAMES):
        if name in names:
            end = '"buoy"' if name.startswith("tied") else fixed(19, 5 * k, -2 - k)
            text += line_text(
                name, "wire", 24 + k, 9 if name == "long" else 6, 1.0 + 0.3 * k, fixed(0, 5 * k, -10),
                end, 'diameter = "20 mm"\ndrag = { normal = 1.2, tangential = 0.1 }',
            )  # fmt: skip
    return scene_of(folder, text + BUOY * ("tied-1" in names))


def strain_of_b(scene):
    """Strains of line b at rest as a function of its mass (kg/m)."""
    layout, coordinates = make_layout(scene), coordinates_of([scene])

    def strain(mass):
        found = start_of(scene.with_numbers({"lines.b.mass": mass}), layout, coordinates)
        return found.model.lines["b"].reference_strain

    return strain


@pytest.fixture(scope="module")
def untied(tmp_path_factory):
    """The model of the lines that no buoy ties, at rest."""
    return equilibrium_of(lines(tmp_path_factory.mktemp("untied"), *NAMES[:4]))[0].model


@pytest.mark.slow
def test_what_is_done_to_all_is_done_to_each(untied):
    model = untied
    assert alike(model.lines) == [["a", "b", "c"], ["long"]]
    some = [model.lines[name] for name in ("a", "b", "c")]
    moved = jnp.asarray(np.random.default_rng(1).normal(0, 0.01, (3, *some[0].reference.shape)))

    def force(line, u):
        return line.forces(u, None).force

    together = done_alike(force, some, moved)
    for k, line in enumerate(some):
        np.testing.assert_allclose(together[k], force(line, moved[k]), rtol=1e-12, atol=1e-8)
    # one alone has an axis too
    assert done_alike(force, some[:1], moved[:1]).shape == (1, *moved.shape[1:])


@pytest.mark.parametrize("tied", [pytest.param(False, marks=pytest.mark.slow), True])
@pytest.mark.slow
def test_forces_on_the_net_are_those_of_the_lines(request, tmp_path, tied):
    if tied:
        model = equilibrium_of(lines(tmp_path, "tied-1", "tied-2"))[0].model
    else:
        model = request.getfixturevalue("untied")
    net, d = make_net(model), next(iter(model.lines.values())).dimensions
    moved = jnp.asarray(np.random.default_rng(2).normal(0, 0.01, (net.size, d)))
    total = np.zeros((net.size, d))
    for name, u in net.spread(moved).items():
        np.add.at(total, net.index[name], np.asarray(model.lines[name].forces(u, None).force).T)
    for junction in model.junctions:
        line, node = junction.members[0]
        total[net.index[line][node]] += np.asarray(junction.load)
    np.testing.assert_allclose(forces_at_rest(model, moved, net), total, rtol=1e-11, atol=1e-8)


@pytest.mark.parametrize("current", [True, False])
@pytest.mark.slow
def test_lines_rest_as_each_does_alone(tmp_path, current):
    told = []
    for names in (("a", "b", "long"), ("b",)):
        strain = strain_of_b(lines(tmp_path, *names, current=current))
        both = jax.jit(lambda m, s=strain: jax.jvp(s, (m,), (jnp.ones_like(m),)))
        told.append(list(map(np.asarray, both(jnp.asarray(1.3)))))
    (strain, slope), (alone, alone_slope) = told
    assert np.abs(alone).min() > 1e-5
    np.testing.assert_allclose(strain, alone, rtol=1e-7)
    np.testing.assert_allclose(slope, alone_slope, rtol=1e-5)


def test_another_line_is_little_more_of_a_program(tmp_path):
    scenes = [lines(tmp_path, *NAMES[:2], *more) for more in ((), ("c",))]
    two, three = (length_of(strain_of_b(x), jnp.asarray(1.3)) for x in scenes)
    alone = length_of(strain_of_b(lines(tmp_path, "b")), jnp.asarray(1.3))
    # it is assembled, and put together with the others
    assert three - two < 0.25 * alone
