"""A trolley in a deep kink: the line's sides meet in it at their exact angles, wherever nodes are."""

import numpy as np
import pytest
from engine_runs import equilibrium_of, scene_of
from scipy.optimize import fsolve

from lumpedcable.exact import IdealHighline

SCENE = """
gravity = 9.81

[materials.steel]
law = "linear"
EA = {EA}
tension_only = true

[bodies.cargo]
mass = {cargo}
on = {{ line = "highline", place = {place} }}

[lines.highline]
material = "steel"
length = {span}
segments = {segments}
mass = {mass}
start = {{ fixed = [0, 0, {start}] }}
end = {{ winch = {{ at = [{span}, 0, {end}], tension = {tension} }} }}

[output]
"""
G, EA, SPAN, START, END, CARGO, MASS, TENSION = 9.81, 30e6, 50.0, 15.0, 9.0, 4000.0, 3.0, 50e3


def rest(folder, **numbers):
    """Height of the wheel (m), and the line at rest, its nodes (m) about that height."""
    found, coordinates = equilibrium_of(scene_of(folder, SCENE.format(**numbers)))
    assert bool(found.converged)
    low = float(found.model.bodies["cargo"].reference[1])
    line = found.model.lines["highline"]
    nodes = np.asarray(line.reference) - np.array([[0.0], [low]])
    return low + coordinates.origin[2], line, nodes


@pytest.mark.parametrize(
    "place", [2.5, *(pytest.param(x, marks=pytest.mark.slow) for x in (1.3, 1.37, 1.45))]
)
def test_a_light_line_hangs_as_the_ideal_one(tmp_path, place):
    # 49 kN on 40 kN: some 40 degrees to either side; a taut line of next to no mass is straight
    numbers = {"start": 0, "end": 0, "span": 5, "tension": 40e3, "segments": 20}
    z, *_ = rest(tmp_path, EA=1e10, cargo=5000, mass=1e-3, place=place, **numbers)
    exact = IdealHighline(5.0, 40e3, 5000.0, 9.81, place=place).height()
    assert exact < -1.2
    assert z == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(
    ("segments", "place", "cargo", "tension"),
    [(15, 30.0, 2000, 80e3), pytest.param(20, 29.2, 5000, 40e3, marks=pytest.mark.slow)],
)
@pytest.mark.slow
def test_a_line_that_cannot_push_is_found_from_between_two_nodes(
    tmp_path, segments, place, cargo, tension
):
    # the first shape must not begin slack in the kink; next to no mass, as the ideal line
    numbers = {"start": 0, "end": 0, "span": 60, "mass": 0.01, "EA": 57e6}
    z, *_ = rest(tmp_path, cargo=cargo, place=place, segments=segments, tension=tension, **numbers)
    exact = IdealHighline(60.0, tension, cargo, 9.81, place=place).height()
    assert z == pytest.approx(exact, rel=1e-3)


def two_sides(place):
    """Height of the wheel (m), tensions at the start and beside it (N), of two elastic catenaries.

    They have one tension where they meet under a wheel without friction, and that of the winch at its
    end; the way along each by quadrature.
    """
    w = MASS * G

    def side(H, V, length):
        s = np.linspace(0.0, length, 20001)
        T = np.hypot(H, V - w * s)
        across, down = H / T * (1.0 + T / EA), (V - w * s) / T * (1.0 + T / EA)
        return np.trapezoid(across, s), np.trapezoid(down, s), T[[0, -1]], w * length - V

    def left(x):
        first, second, H, V, K, U, z = x
        there, down, pulls, lifts = side(H, V, first)
        over, fall, others, borne = side(K, U, second)
        return (
            there - place, down - (START - z), over - (SPAN - place), fall - (END - z),
            (pulls[1] - others[1]) / TENSION, (lifts + borne) / (CARGO * G) + 1.0,
            others[0] / TENSION - 1.0,
        )  # fmt: skip

    z = IdealHighline(SPAN, TENSION, CARGO, G, place=place).height() + 12.0
    ways = np.hypot(place, START - z), np.hypot(SPAN - place, END - z)
    down = (START - z) / ways[0], (END - z) / ways[1]
    across = place / ways[0], (SPAN - place) / ways[1]
    guess = [
        *ways,
        TENSION * across[0],
        TENSION * down[0],
        TENSION * across[1],
        TENSION * down[1],
        z,
    ]
    found, _, good, _ = fsolve(left, guess, full_output=True, xtol=1e-12)
    assert good == 1
    first, _, H, V, *_ = found
    return found[-1], np.hypot(H, V), np.hypot(H, V - w * first)


@pytest.mark.slow
@pytest.mark.parametrize("place", [8.0, 8.3, 8.6, 20.0])
def test_a_steep_line_has_one_tension_on_both_sides(tmp_path, place):
    z, start, beside = two_sides(place)
    apart = []
    for segments in (25, 50):
        numbers = {"EA": EA, "cargo": CARGO, "mass": MASS, "place": place, "span": SPAN}
        found, line, nodes = rest(
            tmp_path, start=START, end=END, tension=TENSION, segments=segments, **numbers
        )
        steps = np.diff(nodes, axis=1)
        lengths = np.linalg.norm(steps, axis=0)
        pull = EA * (lengths / np.asarray(line.segment_length) - 1.0)
        before = int(np.searchsorted(nodes[0], place)) - 1
        # three segments away its nodes carry nothing of it; beside it, half the way's weight less
        way = [before - 3, before + 3]
        rise = [0.5 * (nodes[1, k] + nodes[1, k + 1]) for k in way]
        sides = [pull[k] - MASS * G * up for k, up in zip(way, rise, strict=True)]
        assert sides == pytest.approx([beside, beside], abs=8.0 * 25 / segments)
        assert pull[0] == pytest.approx(start, abs=40.0 * 25 / segments)  # in its middle
        apart.append(abs(found - z))
    assert apart[1] < 3e-3  # of a sag of 8 m and more, and segments of 1 m
    assert apart[1] < 0.7 * apart[0]
