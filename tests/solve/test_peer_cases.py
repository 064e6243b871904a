"""Cases that other programs are known by, from configs/peers: statics and a pendulum."""

from functools import cache, partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from engine_runs import equilibrium_of, nodes_in_space, order_of, run_scenes
from test_moving_ends import period_of

from benchmarks.peers import moordyn_chain
from lumpedcable.exact import (
    cantilever_deflection,
    elastic_catenary,
    elastic_pendulum_periods,
    pendulum_period,
    simply_supported_deflection,
)
from lumpedcable.scene import load_study
from lumpedcable.solve.end_forces import end_tension
from lumpedcable.study.compiled import RUN_ONCE

PEERS = Path(__file__).parents[2] / "configs" / "peers"
G = 9.80665


@cache
def at_rest(file, *overrides):
    """Forces (2, 2) of the only line on its start and end (x, z; N), end tensions, nodes (3, n + 1)."""
    scene = load_study(PEERS / file, overrides).runs[0]
    found, coordinates = equilibrium_of(scene)
    assert bool(found.converged)
    name = next(iter(scene.lines))
    line = found.model.lines[name]
    ends, along = map(np.asarray, pulls_of(line))
    pull = coordinates.expand(along, 0)[:, [0, -1]]
    half = scene.lines[name].mass * G * scene.lines[name].length / line.segments / 2
    forces = np.array([pull[[0, 2], 0] - [0, half], -pull[[0, 2], 1] - [0, half]])
    return forces, ends, nodes_in_space(found, coordinates, name)


@partial(jax.jit, compiler_options=RUN_ONCE)
def pulls_of(line):
    """End tensions (2,) and the tension of each segment along it (d, n), N."""
    shape = line.shape()
    tension = line.law.tension(shape.strain)
    ends = [end_tension(line, tension, node, shape) for node in (0, -1)]
    return jnp.stack(ends), tension * shape.tangent


# --- MoorPy's catenary ----------------------------------------------------------------------------

MOORPY = np.array([[43694.581, -22365.599], [-43694.581, -77634.401]])  # MoorPy 1.3's own test


def exact_catenary(EA):
    line = elastic_catenary(400.0, 200.0, 500.0, EA, 200.0)
    return line, np.array([line.force_on_a, line.force_on_b])


def test_a_thousandth_of_moorpys_stiffness_is_stiff_enough():
    _, stiff = exact_catenary(7.51e12)
    assert stiff == pytest.approx(MOORPY, rel=1e-6)
    # strain T/EA = 1e-5 of the length, and sag answers to that by a few times as much
    assert exact_catenary(7.51e9)[1] == pytest.approx(MOORPY, rel=1e-4)


@pytest.mark.slow
def test_moorpys_catenary():
    line, exact = exact_catenary(7.51e9)
    errors, misses = [], []
    for segments in (50, 100):
        forces, _, nodes = at_rest("catenary.toml", f"segments={segments}")
        errors.append(np.max(np.abs(forces - exact)) / exact[0, 0])
        at = line.position(np.linspace(0.0, 500.0, segments + 1))
        misses.append(np.max(np.hypot(nodes[0] - at[0], nodes[2] - at[1])) / 500.0)
    # lumps on a curve: second order
    assert order_of(errors, 2) == pytest.approx(2.0, abs=0.1)
    assert order_of(misses, 2) == pytest.approx(2.0, abs=0.1)
    assert errors[1] < 1e-3


def test_moorpys_catenary_to_five_digits():
    # the extrapolation to no segments at all, from the order just shown
    coarse, fine = (at_rest("catenary.toml", f"segments={n}")[0] for n in (50, 100))
    _, exact = exact_catenary(7.51e9)
    assert (4.0 * fine - coarse) / 3.0 == pytest.approx(exact, rel=1e-5)


# --- chain mooring --------------------------------------------------------------------------------


@pytest.mark.slow
def test_chain_mooring():
    # elastic catenary on a frictionless bottom; the chain here lies on a bed that gives by 4 mm
    _, (anchor, fairlead), nodes = at_rest("chain-mooring.toml")
    assert fairlead == pytest.approx(1001.67e3, rel=2e-3)
    assert anchor == pytest.approx(835.59e3, rel=2e-3)
    assert nodes[2, 1:-1].min() == pytest.approx(-50.0, abs=0.01)


def test_the_comparison_knows_the_exact_chain():
    assert moordyn_chain.exact() == pytest.approx((1001.67e3, 835.59e3), rel=1e-5)


def test_distance_of_histories():
    # of a sine from itself a quarter of a period later: sqrt(2) times its own size
    t = np.arange(0.0, 40.0, 0.1)
    one, other = (
        moordyn_chain.Histories(t, 1e6 + np.sin(2 * np.pi * (t + lag) / 10.0), t, None, 0.0)
        for lag in (0.0, 2.5)
    )
    assert moordyn_chain.distance(one, one) == 0.0
    assert moordyn_chain.distance(one, other) == pytest.approx(np.sqrt(2.0), rel=1e-6)


@pytest.mark.slow
def test_chain_mooring_under_way_beside_moordyn():
    # two programs with errors of their own, both of some per cent at 41 segments: they come closer
    # as the mesh gets finer
    pytest.importorskip("moordyn")
    data = moordyn_chain.run(quick=True)
    apart = [run["to_other"] for run in data["runs"] if run["program"] == "lumpedcable"]
    assert apart[0] < 0.05
    assert apart[1] < 0.7 * apart[0]
    assert len(moordyn_chain.table(data).splitlines()) == 3 + len(data["runs"])


DECK = "lines.chain.end.motion.position=[14, 0, 30]"


@pytest.mark.slow
def test_a_chain_from_a_deck_over_the_water_beside_moordyn():
    pytest.importorskip("moordyn")
    mine = moordyn_chain.by_engine(DECK, "water.surface=0")
    under = moordyn_chain.by_engine(DECK)
    other = moordyn_chain.by_moordyn(moordyn_chain.scene_of(DECK))
    assert mine.fairlead[0] == pytest.approx(other.force[0], rel=5e-4)
    assert mine.anchor[0] == pytest.approx(other.anchor[0], rel=1e-3)
    assert under.fairlead[0] < 0.98 * mine.fairlead[0]  # as if the 30 m were in water, too
    # in motion two programs of some per cent each at 82 segments, as under water
    late = mine.time >= moordyn_chain.LAST
    here, there = (x[late] - x[late].mean() for x in (mine.fairlead, other.fairlead))
    assert np.sqrt(np.mean((here - there) ** 2)) < 0.06 * np.sqrt(np.mean(there**2))


# --- pendulum -------------------------------------------------------------------------------------

SWING = 20.114  # s, 100 t on a rigid weightless line of 100.5 m: 2 pi sqrt(L/g)
ANGLE = np.arcsin(10.0 / 100.5)


def period(folder, *overrides):
    ran = run_scenes(folder, load_study(PEERS / "pendulum.toml", overrides))
    assert ran.statuses == ["OK"]
    return period_of(ran.time, ran["rope.position"][0, :, -1, 0])


@pytest.mark.slow
def test_the_pendulum(tmp_path):
    # stretched by the weight, swinging wide, and the line swinging with it: on the mass of the bob
    # M, m L/3 of inertia that pulls nothing back, since water carries the line
    stretched = 100.5 * (1.0 + 1e5 * G / 1e9)
    inertia = np.sqrt(1.0 + 7.85398 * 100.5 / 3.0 / 1e5)
    expected = pendulum_period(stretched, ANGLE) * inertia
    assert expected == pytest.approx(SWING * (1.0 + 0.0005 + 0.0006 + 0.0013), rel=2e-4)
    # few segments, and so few steps: the line is straight
    assert period(tmp_path, "rope.segments=5") == pytest.approx(expected, rel=5e-4)


@pytest.mark.slow
def test_the_pendulum_on_a_light_stiff_line(tmp_path):
    # a tenth of the mass (half of it at the bob: 0.02 %), ten times the stiffness (0.005 %) and
    # the amplitude (0.06 %): nearer than a thousandth to 20.114 s
    light = ("rope.mass=0.785398", "rope.diameter=31.6228 mm", "wire.EA=1e10", "rope.segments=1")
    assert period(tmp_path, *light) == pytest.approx(SWING, rel=1e-3)
    swing, _ = elastic_pendulum_periods(100.5, 1e10, 1e5, G)
    assert swing == pytest.approx(SWING, rel=1e-4)


# --- beams ----------------------------------------------------------------------------------------

Q = 100.0 * G  # N/m


def test_cantilever():
    exact = float(cantilever_deflection(10.0, 10.0, Q, 1e7))
    assert exact == pytest.approx(0.12258, abs=5e-6)
    assert -at_rest("cantilever.toml")[2][2, -1] == pytest.approx(exact, rel=0.01)


@pytest.mark.slow
def test_simply_supported():
    exact = float(simply_supported_deflection(5.0, 10.0, Q, 1e7))
    assert exact == pytest.approx(0.01277, abs=5e-6)
    assert -at_rest("simply-supported.toml")[2][2, 20] == pytest.approx(exact, rel=0.01)


@pytest.mark.slow
def test_chain_mooring_in_waves_beside_moordyn():
    pytest.importorskip("moordyn")
    waves = moordyn_chain.WAVY
    mine = moordyn_chain.by_engine(file=waves)
    other = moordyn_chain.by_moordyn(moordyn_chain.scene_of(file=waves), 5e-4)
    # the last 1.5 m of the chain bear some hundreds of N: the force on the ship, not a segment's tension
    late = mine.time >= moordyn_chain.LAST
    here, there = (x[late] - x[late].mean() for x in (mine.fairlead, other.force))
    swing = np.sqrt(np.mean(there**2))
    assert swing > 6e4  # N
    # MoorDyn leaves out the pressure along the line
    assert np.sqrt(np.mean((here - there) ** 2)) < 0.005 * swing
