"""Slack lines that bend, at rest: least energy by a search of another kind, and no folds."""

import equinox as eqx
import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, scene_of
from scipy.optimize import minimize

from lumpedcable.model.line import placed
from lumpedcable.solve.clamps import folded

LENGTH, EA, WEIGHT = 10.0, 1e6, 9.81
SCENE = """
gravity = 9.81
[materials.steel]
law = "linear"
EA = "1 MN"
[lines.rope]
material = "steel"
length = "10 m"
segments = {segments}
mass = 1
bending = {{ EI = {EI} }}
start = {{ fixed = [0, 0, 0]{direction} }}
end = {end}
[output]
"""


def energy(inner, segments, EI, end, clamp=None):
    """Energy (J) of a chain between (0, 0) and `end` in x and z (m), and its slope by the inner nodes.

    EA e^2 l / 2, EI (1 - cos) / l at each joint, twice that at a clamp, and weights; `end` None: free.
    """
    l = LENGTH / segments
    places = np.vstack([[0.0, 0.0], inner.reshape(-1, 2)] + ([] if end is None else [end]))
    step = np.diff(places, axis=0)
    size = np.hypot(*step.T)
    u = step / size[:, None]
    e = size / l - 1.0
    share = np.ones(segments + 1)
    share[[0, -1]] = 0.5
    value = 0.5 * EA * l * np.sum(e**2) + WEIGHT * l * share @ places[:, 1]
    value += EI / l * np.sum(1.0 - np.sum(u[1:] * u[:-1], axis=1))
    neighbours = np.zeros_like(u)
    neighbours[1:] += u[:-1]
    neighbours[:-1] += u[1:]
    if clamp is not None:
        value += 2.0 * EI / l * (1.0 - clamp @ u[0])
        neighbours[0] += 2.0 * clamp
    shear = EI / l * (neighbours - np.sum(neighbours * u, axis=1)[:, None] * u) / size[:, None]
    pull = EA * e[:, None] * u - shear
    slope = np.zeros_like(places)
    slope[1:] += pull
    slope[:-1] -= pull
    slope[:, 1] += WEIGHT * l * share
    return value, slope[1 : segments if end is not None else None].ravel()


def least(first, *arguments):
    """The least energy (J) that a search downhill finds from a first shape, and its places (m)."""
    options = {"maxiter": 60_000, "maxfun": 90_000, "ftol": 1e-16, "gtol": 1e-8, "maxcor": 50}
    found = minimize(energy, first.ravel(), arguments, "L-BFGS-B", jac=True, options=options)
    return found.fun, found.x.reshape(-1, 2)


@pytest.mark.parametrize(
    ("segments", "EI", "end"),
    [
        pytest.param(40, 10, (0.0, -2.0), marks=pytest.mark.slow),
        pytest.param(41, 10, (0.0, -2.0), marks=pytest.mark.slow),
        pytest.param(40, 10, (0.1, 0.0), marks=pytest.mark.slow),
        pytest.param(40, 100, (0.3, 0.0), marks=pytest.mark.slow),
    ],
)
def test_a_loop_hangs_open(tmp_path, segments, EI, end):
    text = SCENE.format(
        segments=segments, EI=EI, direction="", end=f"{{ fixed = [{end[0]}, 0, {end[1]}] }}"
    )
    found, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert found.converged
    places = nodes_in_space(found, coordinates)[::2].T
    u = np.diff(places, axis=0)
    u /= np.hypot(*u.T)[:, None]
    assert np.min(np.sum(u[1:] * u[:-1], axis=1)) > 0.5  # a fold has -1
    s = np.linspace(0.0, 1.0, segments + 1)[1:-1]
    turn = 2.0 * np.pi * s
    wide = np.stack([end[0] * s - np.sin(turn), end[1] * s - 2.25 * (1.0 - np.cos(turn))], axis=1)
    value, _ = least(wide, segments, EI, np.array(end))
    mine, _ = energy(places[1:-1], segments, EI, np.array(end))
    assert mine == pytest.approx(value, abs=1e-3)


@pytest.mark.slow
def test_a_rod_clamped_upwards_bends_over(tmp_path):
    """It lies on one line with its weight, and yet it is a plane that it needs."""
    text = SCENE.format(segments=20, EI=100, direction=", direction = [0, 0, 1]", end='"free"')
    found, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert found.converged
    s = LENGTH * np.linspace(0.0, 1.0, 21)[1:]
    arch = np.stack([0.5 * (1.0 - np.exp(-s)), 1.0 - np.abs(s - 1.0)], axis=1)
    _, places = least(arch, 20, 100.0, None, np.array([0.0, 1.0]))
    tip = nodes_in_space(found, coordinates)[:, -1]
    assert np.hypot(tip[0], tip[1]) == pytest.approx(abs(places[-1, 0]), abs=1e-4)
    assert tip[2] == pytest.approx(places[-1, 1], abs=1e-4)


@pytest.mark.parametrize(
    ("direction", "end", "dimensions"),
    [
        (", direction = [0, 0, -1]", '"free"', 1),
        ("", '"free"', 1),
        (", direction = [0, 0, 1]", "{ held = { pretension = 200, direction = [0, 0, 1] } }", 2),
        (", direction = [0, 0, -1]", "{ fixed = [0, 0, -10.01] }", 1),
        (", direction = [0, 0, 1]", "{ fixed = [0, 0, -10.01] }", 2),
    ],
)
def test_a_line_has_a_plane_where_its_clamp_asks_for_one(tmp_path, direction, end, dimensions):
    text = SCENE.format(segments=10, EI=10, direction=direction, end=end)
    _, coordinates = equilibrium_of(scene_of(tmp_path, text))
    assert coordinates.dimensions == dimensions


@pytest.mark.slow
def test_a_fold_is_no_state_of_rest(tmp_path):
    text = SCENE.format(segments=40, EI=10, direction="", end="{ fixed = [0.3, 0, 0] }")
    found, _ = equilibrium_of(scene_of(tmp_path, text))
    assert not folded(found.model)
    line = found.model.lines["rope"]
    s = np.linspace(0.0, 1.0, 41)
    deep = np.sqrt(5.0**2 - 0.15**2)  # as long as its segments are
    hairpin = line.reference.at[:].set(np.stack([0.3 * s, -deep * (1.0 - np.abs(2.0 * s - 1.0))]))
    assert folded(placed_in(found.model, hairpin))
    # a rope so limp that it turns within a segment may
    text = SCENE.format(segments=40, EI=1e-3, direction="", end="{ fixed = [0.1, 0, 0] }")
    limp, _ = equilibrium_of(scene_of(tmp_path, text))
    assert limp.converged


def placed_in(model, places):
    return eqx.tree_at(lambda m: m.lines["rope"], model, placed(model.lines["rope"], places))
