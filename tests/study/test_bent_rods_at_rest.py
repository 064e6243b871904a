"""Rods that bend at rest: what their ends carry, and states that a touch would turn over."""

import equinox as eqx
import numpy as np
import pytest
from command_line import rest_of
from engine_runs import equilibrium_of, scene_of, study_of
from scipy.optimize import brentq
from scipy.special import ellipk

from lumpedcable.results import open_result
from lumpedcable.solve import start
from lumpedcable.solve.clamps import folded
from lumpedcable.study.run import run_study

ROD = """
dimensions = 3
[materials.rod]
law = "linear"
EA = "10 MN"
[lines.rod]
material = "rod"
length = "2 m"
segments = {segments}
mass = 1
bending = {{ EI = "10 N m2" }}
start = {start}
end = {end}
[output]
"""
CLAMP = "{{ fixed = [0, 0, 0], direction = {} }}"
HELD = "{{ held = {{ pretension = 12, direction = {} }} }}"


@pytest.mark.slow
def test_a_clamped_line_carries_what_is_hung_on_it(tmp_path):
    """One force at the end of a bent line without weight, more than a right angle from its clamp: every
    part of it carries that force, and at the clamp its share in that direction, to second order."""
    pull, clamp = np.array([0.3, -1.0, 0.5]), np.array([0.8, 0.6, 0.0])
    force = 12.0 * pull / np.linalg.norm(pull)
    errors = []
    for side, segments in (("start", 40), ("start", 80), ("end", 80)):
        sign = 1 if side == "start" else -1  # a direction is that in which the line runs
        start, end = (CLAMP.format((sign * clamp).tolist()), HELD.format(pull.tolist()))[::sign]
        found = rest_of(tmp_path, ROD.format(segments=segments, start=start, end=end))
        assert found["horizontal_tension"] == pytest.approx(np.hypot(*force[:2]), rel=1e-6)
        errors.append(found[f"{side}_tension"] - force @ clamp)
    assert abs(errors[0]) < 0.01
    assert abs(errors[0] / errors[1]) == pytest.approx(4.0, rel=0.25)
    assert errors[2] == pytest.approx(errors[1], rel=1e-3)  # one is the other's mirror image


@pytest.mark.slow
def test_a_column_that_buckles_bends_aside(tmp_path):
    """A force straight back at a clamp, twice what Euler's column bears: the elastica.

    The angle a of its free end is that of a pendulum: L sqrt(P / EI) = K(sin(a / 2))
    (A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, 4th ed., section 263).
    """
    start, end = CLAMP.format([-1, 0, 0]), HELD.format([1, 0, 0])
    found = rest_of(tmp_path, ROD.format(segments=80, start=start, end=end))
    sine = brentq(lambda k: ellipk(k**2) - 2.0 * np.sqrt(12.0 / 10.0), 1e-3, 1.0 - 1e-9)
    assert found["start_tension"] == pytest.approx(-12.0, rel=1e-3)
    assert found["end_tension"] == pytest.approx(-12.0 * (1.0 - 2.0 * sine**2), abs=0.02)


@pytest.mark.slow
def test_what_would_fall_out_of_its_clamp_is_not_at_rest(tmp_path):
    text = ROD.format(segments=20, start=CLAMP.format([1, 0, 0]), end=HELD.format([1, 0, 0]))
    found, _ = equilibrium_of(scene_of(tmp_path, text))
    assert found.converged
    assert not folded(found.model)
    bends = found.model.lines["rod"].loads[0]
    turned = eqx.tree_at(lambda m: m.lines["rod"].loads[0].start, found.model, -bends.start)
    assert folded(turned)
    # a rope whose weight is more than its stiffness hangs down from where it points up
    limp = eqx.tree_at(lambda m: m.lines["rod"].loads[0].EI, turned, 0.01 * bends.EI)
    assert folded(limp)
    assert not folded(eqx.tree_at(lambda m: m.lines["rod"].loads[0].EI, turned, 1e-4 * bends.EI))


BESIDE = """
[lines.beside]
material = "rod"
length = "20 m"
segments = 4
mass = 1
start = { fixed = [0, 5, 0] }
end = { winch = { at = [20, 5, 0], tension = "100 N" } }
"""


@pytest.mark.parametrize(
    "beside",
    [
        pytest.param("", id="alone", marks=pytest.mark.slow),
        pytest.param(BESIDE, id="beside a line on a winch", marks=pytest.mark.slow),
    ],
)
def test_a_state_turned_over_is_none(tmp_path, monkeypatch, beside):
    # from a first shape that leaves its clamp backwards, Newton's method finds what no touch leaves so
    monkeypatch.setattr(start, "bent_out", lambda line, path, pull, held: path)
    monkeypatch.setattr(start, "stiffened", lambda line, path, pull, from_start: path)
    text = ROD.format(segments=21, start=CLAMP.format([-1, 0, 0]), end=HELD.format([1, 0, 0]))
    found, _ = equilibrium_of(scene_of(tmp_path, text.replace("[output]", beside + "[output]")))
    assert folded(found.model)
    assert not found.converged
    target = tmp_path / "r.h5"
    (outcome,) = run_study(
        study_of(tmp_path, text.replace("[output]", beside + "[output]")), target
    )
    assert "in balance, but a touch would turn it over" in outcome.message


@pytest.mark.parametrize("rise", [0.0, 0.35, 0.4])
@pytest.mark.slow
def test_a_span_leaves_its_clamps_forwards(tmp_path, rise):
    """A rod of 2 m over 1.2 m, clamped straight up and straight down: an arch, not a loop below."""
    start = CLAMP.format([0, 0, 1])
    end = f"{{ fixed = [1.2, 0, {rise}], direction = [0, 0, -1] }}"
    rest_of(tmp_path, ROD.format(segments=60, start=start, end=end))
    with open_result(tmp_path / "r.h5") as result:
        places = result.line("rod").field("position")[0, 0]
    tangent = np.diff(places, axis=0)
    assert tangent[0, 2] > 0 > tangent[-1, 2]
    assert np.sum(tangent[1:] * tangent[:-1], axis=1).min() > 0
