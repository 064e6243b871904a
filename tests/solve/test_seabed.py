"""Lines on a seabed: at rest against elastic catenaries, under way by their energies."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, fixed, line_text, nodes_in_space, run_text, scene_of
from modal_runs import modes_of

from lumpedcable.exact import elastic_catenary, rod_frequencies, string_frequencies
from lumpedcable.model.coordinates import coordinates_of
from lumpedcable.model.layout import make_layout
from lumpedcable.solve.end_forces import end_tension
from lumpedcable.solve.start import start_of
from lumpedcable.study.compiled import RUN_ONCE

G = 9.80665
BED = "[seabed]\nheight = {height}\nstiffness = {stiffness}\n"
HOOKE = '[materials.chain]\nlaw = "linear"\nEA = {EA}\n{more}\n'
OUTPUT = '[output]\nduration = "1 s"\nevery = "1 s"\n'


def text(
    start, end, length, EA=1e9, weight=3000.0, segments=60, height=0.0, stiffness=1e6,
    material="", line="", more="",
):  # fmt: skip
    """A line of `weight` (N/m) over a bed; ends as in a scene, or a place."""
    start, end = (e if isinstance(e, str) else fixed(*e) for e in (start, end))
    return (
        f"gravity = {G}\n"
        + BED.format(height=height, stiffness=stiffness)
        + HOOKE.format(EA=EA, more=material)
        + line_text("chain", "chain", length, segments, weight / G, start, end, line)
        + more
        + OUTPUT
    )


def at_rest(folder, scene, name="chain"):
    """The equilibrium, its end tensions (N) and nodes (3, n + 1)."""
    found, coordinates = equilibrium_of(scene_of(folder, scene))
    assert bool(found.converged)
    ends = np.array(ends_of(found.model.lines[name]))
    return found, ends, nodes_in_space(found, coordinates, name)


@partial(jax.jit, compiler_options=RUN_ONCE)
def ends_of(line):
    shape = line.shape()
    tension = line.law.tension(shape.strain)
    return [end_tension(line, tension, node, shape) for node in (0, -1)]


CASES = {
    # place of the end, unstretched length, EA, weight, height of the bed; the start is the origin
    "anchor on the bed": ((400.0, 0.0, 200.0), 500.0, 1e8, 800.0, 0.0),
    "belly on the bed": ((160.0, 0.0, 0.0), 180.0, 1e8, 400.0, -30.0),
    "uneven belly": ((160.0, 0.0, 20.0), 190.0, 1e8, 400.0, -30.0),
    "askew in space": ((120.0, 90.0, -20.0), 170.0, 1e7, 400.0, -40.0),
    "soft": ((100.0, 0.0, 50.0), 130.0, 2e5, 400.0, -10.0),
    "just above the bed": ((160.0, 0.0, 20.0), 165.0, 1e8, 400.0, -30.0),
}
LONG = ("anchor on the bed",)


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=pytest.mark.slow if case in LONG else ()) for case in CASES],
)
def test_end_tensions_and_shape(tmp_path, case):
    # a chain of lumps on a bed that gives: second order in the mesh, first in the sink
    end, length, EA, weight, height = CASES[case]
    span = float(np.hypot(*end[:2]))
    exact = elastic_catenary(span, end[2], length, EA, weight, seabed=height)
    assert (exact.bottom_length > 0.0) == (case != "just above the bed")
    expected = exact.tension([0.0, length])
    for segments, stiffness, band in ((60, 1e6, 6e-3), (240, 1e7, 4e-4)):
        scene = text((0, 0, 0), end, length, EA, weight, segments, height, stiffness)
        found, ends, nodes = at_rest(tmp_path, scene)
        assert int(found.iterations) <= 12
        assert ends == pytest.approx(expected, rel=band)
        x, z = exact.position(np.linspace(0.0, length, segments + 1))
        assert np.hypot(*nodes[:2]) == pytest.approx(x, abs=band * length)
        assert nodes[2] == pytest.approx(z, abs=band * length)


def test_the_bed_gives_in_proportion(tmp_path):
    # w / k, and a tenth of the dry weight over k, half the depth of the blend; out of the water
    # both are the same weight
    for stiffness in (1e5, 1e6, 1e7):
        scene = text((0, 0, 0), (400, 0, 200), 500, 1e8, 800, 60, 0.0, stiffness)
        _, _, nodes = at_rest(tmp_path, scene)
        assert nodes[2, 10] == pytest.approx(-1.1 * 800 / stiffness, rel=1e-6)


def test_which_end_is_the_anchor_does_not_matter(tmp_path):
    _, ends, nodes = at_rest(tmp_path, text((0, 0, 0), (400, 0, 200), 500, 1e8, 800))
    _, back, other = at_rest(tmp_path, text((400, 0, 200), (0, 0, 0), 500, 1e8, 800))
    assert back[::-1] == pytest.approx(ends, rel=1e-9)
    assert other[:, ::-1] == pytest.approx(nodes, abs=1e-7)


@pytest.mark.slow
def test_two_halves_joined_on_the_bed_are_the_whole(tmp_path):
    _, ends, nodes = at_rest(tmp_path, text((0, 0, 0), (400, 0, 100), 450, 1e8, 800))
    far = line_text("far", "chain", 225, 30, 800 / G, '"free"', fixed(400, 0, 100))
    scene = text((0, 0, 0), '"far.start"', 225, 1e8, 800, 30, more=far)
    _, half, first = at_rest(tmp_path, scene)
    assert half[0] == pytest.approx(ends[0], rel=1e-8)
    assert first == pytest.approx(nodes[:, :31], abs=1e-6)


def test_a_free_end_lies_down(tmp_path):
    # 60 m lowered over 50 m: the rest lies on the bed without tension, wherever it likes
    _, ends, nodes = at_rest(tmp_path, text((0, 0, 0), '"free"', 60, height=-50.0))
    assert ends == pytest.approx([50 * 3000.0, 0.0], abs=1.5 * 3000.0)
    assert nodes[2, -1] == pytest.approx(-50.0, abs=0.01)
    assert abs(nodes[0, -1]) == pytest.approx(10.0, abs=0.5)


def test_a_line_is_dragged_along_the_bed(tmp_path):
    # a force along the bed is carried to where the line lifts off: the catenary of H = 20 kN
    end = '{ held = { pretension = "20 kN", direction = [1, 0, 0] } }'
    scene = text((0, 0, 0), end, 160, 1e9, 1000.0, segments=320, height=-50.0, stiffness=1e7)
    _, ends, _ = at_rest(tmp_path, scene)
    # T = H + w h at the top of a line with a level end (stretch is 2e-5)
    assert ends == pytest.approx([20e3 + 50 * 1000.0, 20e3], rel=1e-3)


@pytest.mark.parametrize("length", [452.0, 465.0, 500.0])
def test_slack_is_left_on_the_bed(tmp_path, length):
    # more line than the way down and along: it hangs straight down and the rest lies slack
    scene = text((0, 0, 0), (400, 0, 50), length, 1e8, segments=200, material="tension_only = true")
    _, ends, nodes = at_rest(tmp_path, scene)
    assert ends[0] < 100.0
    assert ends[1] == pytest.approx(50 * 3000.0, rel=1.5 * length / 200 / 50)
    assert np.min(nodes[2]) > -0.01


@pytest.mark.parametrize(
    ("key", "change"),
    [
        # the difference is off by 1e-4 with a step of 1e3, by 8e-6 with this, by 1e-6 with 100
        pytest.param("seabed.stiffness", 250.0, marks=pytest.mark.slow),
        ("seabed.height", 1e-3),
        pytest.param("lines.chain.length", 1e-4, marks=pytest.mark.slow),
    ],
)
def test_derivatives_on_the_bed(tmp_path, key, change):
    # the implicit function theorem against central differences
    scene = scene_of(tmp_path, text((0, 0, 0), (160, 0, 20), 190, 1e8, 400, 20, -30.0, 1e5))
    layout, coordinates = make_layout(scene), coordinates_of([scene])
    base = scene.numbers()

    def pull(value):
        found = start_of(scene.with_numbers({**base, key: value}), layout, coordinates)
        line = found.model.lines["chain"]
        return line.law.tension(line.reference_strain)[-1]

    @partial(jax.jit, compiler_options=RUN_ONCE)
    def both(value):
        return jax.jvp(pull, (value,), (jnp.ones_like(value),))

    at = jnp.asarray(base[key])
    forward = float(both(at)[1])
    difference = float((both(at + change)[0] - both(at - change)[0]) / (2.0 * change))
    assert abs(forward) > 0.0
    assert forward == pytest.approx(difference, rel=1e-4)


# --- motion --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_taut_line_on_the_bed_is_a_string_on_springs(tmp_path):
    # omega^2 = k / m + (n pi / L)^2 T / m up and down; along the bed it is a free rod
    length, EA, m, k = 100.0, 1e6, 5.0, 2e3
    scene = text((0, 0, 0), (101, 0, 0), length, EA, m * G, 100, 0.0, k)
    found = modes_of(tmp_path, scene, count=3)
    # frequency of the string per stretched metre, mass and bed per unstretched one
    string = string_frequencies(101.0, EA * 0.01, m / 1.01, 3)
    across = np.sqrt(string**2 + k / m / (2 * np.pi) ** 2)
    along = rod_frequencies(length, EA, m, 1)
    assert found.frequency == pytest.approx([*along, *across[:2]], rel=2e-4)


# a chain lifted by its middle, until the lift parts and it falls back on the bed
FALL = """
gravity = 9.80665
[seabed]
height = "-10 m"
stiffness = "20 kPa"
damping = "{damping}"

[materials.chain]
law = "linear"
EA = "1 MN"

[lines.left]
material = "chain"
length = "14.99 m"
segments = 15
mass = "10 kg/m"
start = {{ fixed = [0, 0, -10] }}
end = "right.start"

[lines.right]
material = "chain"
length = "14.99 m"
segments = 15
mass = "10 kg/m"
start = "free"
end = {{ fixed = [30, 0, -10] }}

[lines.lift]
material = "chain"
length = "9 m"
segments = 1
mass = "0.1 kg/m"
start = "left.end"
end = {{ fixed = [15, 0, 0] }}

[events.release]
breaks = "lift.start"
time = 0

[output]
duration = "3 s"
every = "20 ms"
"""


@pytest.mark.slow
@pytest.mark.parametrize("damping", ["500 Pa s", "5 kPa s"])
def test_a_line_falls_on_the_bed_and_stays_there(tmp_path, damping):
    # of 2 sqrt(k m) = 894 Pa s, half critical and several times that
    ran = run_text(tmp_path, FALL.format(damping=damping))
    assert ran.statuses == ["OK"]
    assert ran.outcomes[0].energy_closure < 2e-3
    lost = ran.energy["lost_contact"][0]
    assert np.all(np.diff(lost) >= 0.0)
    # the fall from 1 m up of a triangle of 30 m by 10 kg/m, half of it lifted on average
    fallen = -np.ptp(ran.energy["gravitational"][0])
    assert lost[-1] > 0.5 * abs(fallen)
    height = ran["left.position"][0, :, :, 2]
    assert height[0, -1] == pytest.approx(-9.0, abs=0.05)
    assert height[-1] == pytest.approx(np.full(16, -10.0), abs=0.02)
    speed = np.abs(ran["left.velocity"][0, :, :, 2])
    assert np.max(speed[-1]) < 0.02 * np.max(speed)


UNDAMPED = FALL.replace('damping = "{damping}"\n', "").format()


@pytest.mark.slow
@pytest.mark.xfail(
    strict=True,
    raises=AssertionError,
    reason="the lift, one segment with 10 J in it, rings next to the largest stable step: 0.44 %",
)
def test_an_undamped_bed_gives_back_what_it_takes(tmp_path):
    ran = run_text(tmp_path, UNDAMPED)
    assert ran.statuses == ["OK"]
    assert "lost_contact" not in ran.energy
    assert np.max(ran.energy["seabed"][0]) > 2.0 * ran.energy["seabed"][0, 0]
    assert ran.outcomes[0].energy_closure < 2e-3


@pytest.mark.slow
def test_with_shorter_steps_an_undamped_bed_gives_back_what_it_takes(tmp_path):
    closures = []
    for courant in (0.45, 0.225):
        ran = run_text(tmp_path, f"{UNDAMPED}\n[solver]\ncourant = {courant}\n")
        assert ran.statuses == ["OK"]
        assert "lost_contact" not in ran.energy
        assert np.max(ran.energy["seabed"][0]) > 2.0 * ran.energy["seabed"][0, 0]
        closures.append(ran.outcomes[0].energy_closure)
    assert closures[0] < 2e-3
    assert closures[0] / closures[1] > 3.5


def test_without_a_bed_there_is_none(tmp_path):
    found, _ = equilibrium_of(
        scene_of(tmp_path, text((0, 0, 0), (160, 0, 20), 180).replace(BED.format(
            height=0.0, stiffness=1e6), ""))
    )  # fmt: skip
    names = [type(load).__name__ for load in found.model.lines["chain"].loads]
    assert names == ["Weight"]
    assert found.model.lines["chain"].resistances == ()


@pytest.mark.slow
def test_what_the_bed_bears_beside_a_line_does_not_pull_at_it(tmp_path):
    # a clump sinks, since nothing but the end of a slack line holds it up, so that the line begins
    # aslant; its own weight lies on the bed
    body = '[bodies.clump]\nmass = "2 t"\nposition = [0, 0, -20]\n'
    scene = text(
        '"clump"', (0, 0, 0), 25, EA=1e6, weight=G, segments=25, height=-20, stiffness=1e5,
        material="tension_only = true", more=body,
    )  # fmt: skip
    found, ends, nodes = at_rest(tmp_path, scene)
    assert nodes[2, 1] - nodes[2, 0] > 0.3
    strain = np.asarray(found.model.lines["chain"].reference_strain)
    assert np.all(strain[:3] < 0.0)
    assert ends[0] == pytest.approx(0.0, abs=1e-3)
    assert ends[1] == pytest.approx(G * 19.5, rel=0.01)  # what hangs


@pytest.mark.slow
def test_all_runs_of_a_sweep_find_their_bed(tmp_path):
    sweep = '\n[sweep]\n"seabed.height" = [-30, -25, -1000]\n'
    scene = text((0, 0, 0), (160, 0, 20), 180, 1e8, 400, height=-30.0) + sweep
    ran = run_text(tmp_path, scene)
    for run, height in enumerate((-30.0, -25.0, -1000.0)):
        exact = elastic_catenary(160, 20, 180, 1e8, 400, seabed=height)
        assert ran["end_tension"][run, 0] == pytest.approx(exact.tension(180.0), rel=6e-3)
        assert np.min(ran["position"][run, 0, :, 2]) > height - 0.01
